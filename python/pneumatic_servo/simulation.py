"""A plant that is run step by step."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from reprlib import repr as shortened
from typing import Any, Literal, overload

import numpy as np
from numpy.typing import NDArray

from pneumatic_servo import _native, checks, constant_voltage, effects, values
from pneumatic_servo.checks import mapping
from pneumatic_servo.constant_voltage import AtRest
from pneumatic_servo.model_description import ModelDescription
from pneumatic_servo.names import did_you_mean
from pneumatic_servo.sensitivities import Followers, Transition
from pneumatic_servo.tasks import available_cores
from pneumatic_servo.variables import Value


class SavedState:
    """A saved state of a `Simulation`; it serves every simulation of the same model with the same parameters.

    It can be pickled, and so goes to other processes and into files.

    Examples
    --------
    >>> import pneumatic_servo as ps
    >>> simulation = ps.Model().start()
    >>> state = simulation.save()
    >>> simulation.step(0.1)
    >>> simulation.restore(ps.SavedState.from_bytes(state.to_bytes()))
    >>> simulation.time
    0.0
    """

    __slots__ = ("_state",)

    def __init__(self, state: _native.SavedState) -> None:
        self._state = state

    def to_bytes(self) -> bytes:
        """Return the state as bytes, which the same version of the package reads on every platform."""
        return self._state.to_bytes()

    @classmethod
    def from_bytes(cls, data: bytes) -> SavedState:
        """Return the state of such bytes.

        Raises
        ------
        ValueError
            If the bytes are none of this version, or were changed.
        """
        return cls(_native.SavedState.from_bytes(data))

    def __reduce__(self) -> tuple[Callable[[bytes], SavedState], tuple[bytes]]:
        return SavedState.from_bytes, (self.to_bytes(),)


class Simulation:
    """A running plant: set inputs, make a step, read variables; save a state and go back to it.

    A run from a saved state repeats bit for bit. `Model.start` makes one. It can be copied and pickled; the copy goes
    on from where the original is.

    Examples
    --------
    >>> import copy
    >>> import pneumatic_servo as ps
    >>> simulation = ps.Model().start()
    >>> simulation.set({"valveVoltage": "7 V"})
    >>> simulation.step(0.01)
    >>> other = copy.copy(simulation)
    >>> other.step(0.01), simulation.step(0.01)
    (None, None)
    >>> other["position"] == simulation["position"]
    True
    """

    def __init__(
        self, native: _native.Simulation, model: ModelDescription, settings: Mapping[str, Value],
        followers: Followers | None = None,
    ) -> None:  # fmt: skip
        self._native = native
        self._followers = dict(followers or {})
        self._model = model
        self._settings = dict(settings)
        self._told: set[str] = set()
        # Bound once, because loops call them every step; the methods of the class document them.
        self.__dict__.update(step=native.step, set_one=native.set_one, get_one=native.get)

    def step(self, size: float | str | tuple[float, str]) -> None:
        """Integrate over a step of a size in s, or with its unit, as ``"1 ms"``.

        Raises
        ------
        ValueError
            If the step leads nowhere.
        SimulationError
            When the solver cannot go on.
        """
        self._native.step(size)

    def set_one(self, name: str, value: Value) -> None:
        """Set one input or tunable parameter to a value in its SI unit, as fast as can be: for loops.

        Units are understood, and warnings told, by `set` and ``simulation[name] = value``.
        """
        self._native.set_one(name, value)

    def get_one(self, name: str) -> float:
        """Return the value of one variable in its SI unit as a number, of enumerations too, as fast as can be."""
        return self._native.get(name)

    def __setattr__(self, name: str, value: object) -> None:
        # A user's class may have attributes of its own; here another one would do nothing.
        if type(self).__module__.partition(".")[0] == __package__ and not name.startswith("_"):
            raise AttributeError(f"a simulation has no attribute {name}{self._meant(name)}")
        super().__setattr__(name, value)

    def __getattr__(self, name: str) -> Any:
        raise AttributeError(f"a simulation has no attribute {name}{self._meant(name)}")

    def _meant(self, name: str) -> str:
        model = self.__dict__.get("_model")
        if model is None or name.startswith("_"):
            return ""
        if name == "time":
            return " that can be set; `step` moves it on, and Model.start(time=) begins there"
        if name in model.variables:
            return f"; write simulation[{name!r}]"
        return MEANT.get(name, "") or did_you_mean(name, [*model.variables, *METHODS])

    def __reduce__(self) -> tuple[Callable[..., Simulation], tuple[Any, ...]]:
        return _resumed, (self._model, self._settings, self.save(), self._followers)

    def __repr__(self) -> str:
        return f"<Simulation of {self._model.name} at t = {self.time:g} s>"

    def _ipython_key_completions_(self) -> list[str]:
        return list(self._model.variables)

    @property
    def time(self) -> float:
        """Present time in s."""
        return self._native.time

    def set(self, new: Mapping[str, Any] | None = None, /, **more: Any) -> None:
        """Set inputs and tunable parameters, by a mapping or, where the name allows, by keywords.

        Values have units as for `Model.simulate`. They are set one after the other; each must be legal together with
        what is set by then. If one is refused, none of them is set.
        """
        variables = self._model.variables
        every = {**values.settings("values", variables, new), **values.settings("values", variables, more)}
        with self._model._with_units():
            self._native.set(list(every.items()))
        self._tell(every)

    def get(self, names: Sequence[str]) -> NDArray[np.float64]:
        """Return the values of variables, of shape (names,), in SI units."""
        return np.array([self._native.get(name) for name in checks.names("names", names)])

    @overload
    def __getitem__(self, name: Literal["friction.law"]) -> str: ...  # type: ignore[overload-overlap]
    @overload
    def __getitem__(self, name: str) -> float: ...
    def __getitem__(self, name: str) -> float | str:
        """Return the value of a variable in its SI unit; of an enumeration the name of its item."""
        value = self._native.get(name)
        variable = self._model.variables.get(name)
        if variable is None or variable.kind != "enumeration":
            return value
        return next((item for item, number in variable.ids.items() if number == value), value)

    def __setitem__(self, name: str, value: Any) -> None:
        """Set an input or a tunable parameter, with a unit as for `Model.simulate`."""
        own = values.value_of(self._model.variables, name, value)
        with self._model._with_units():
            self._native.set_one(name, own)
        self._tell({name: own})

    def _put(self, new: Mapping[str, Value]) -> None:
        """Set values that are known to be in SI units, without warnings."""
        self._native.set(list(new.items()))

    def _tell(self, new: Mapping[str, Value]) -> None:
        self._model._tell_saturated(new)
        inputs = self._model.inputs
        # An input has said nothing yet as long as it stays at its default.
        fresh = [n for n in new if n not in self._told and (n not in inputs or new[n] != inputs[n].default)]
        if fresh:
            self._told.update(fresh)
            effects.tell(self._model, {**self._settings, **new}, fresh)
        effects.tell_notices(self._model, self._native.notices(), {**self._settings, **new})

    def save(self) -> SavedState:
        """Return everything that affects the further run."""
        return SavedState(self._native.save())

    def restore(self, saved: SavedState) -> None:
        """Go back to a saved state."""
        if not isinstance(saved, SavedState):
            raise TypeError(f"restore takes what save() has returned, not {shortened(saved)}")
        self._native.restore(saved._state)

    @property
    def states(self) -> list[str]:
        """Names of the continuous states that are integrated under the present law and rig."""
        return self._native.states()

    def move_states(self, states: Mapping[str, float]) -> None:
        """Move continuous states to other values at the present time, with the present modes of valve and law.

        If one is refused, none of them is moved.
        """
        self._native.move_states(list(mapping("states", states).items()))

    def jacobian(self, of: Sequence[str], to: Sequence[str]) -> NDArray[np.float64]:
        """Return exact partial derivatives in SI units.

        Parameters
        ----------
        of : sequence of str
            Computed variables, the rows.
        to : sequence of str
            Continuous states and inputs, the columns.

        Returns
        -------
        ndarray of shape (of, to)
        """
        return self._native.jacobian(checks.names("of", of), checks.names("to", to))

    def transition(
        self,
        size: float,
        *,
        parameters: Sequence[str] = (),
        outputs: Sequence[str] = (),
        at_rest: AtRest = "mean",
    ) -> Transition:
        """Integrate over a step of a size in s, and return its transition, exact through events.

        Parameters
        ----------
        size : float
            Size of the step in s.
        parameters : sequence of str
            Real parameters with columns of their own.
        outputs : sequence of str
            Computed variables, for their derivatives at the end.
        at_rest : str
            Choice of the derivative by a constant voltage, whose left and right derivatives differ under valve
            hysteresis: their ``mean``, for which the step is made twice more; ``zero``; or ``refuse``: the column is
            NaN then, and ``lost``.

        Returns
        -------
        Transition
            ``A, B, C, D = simulation.transition(...)``, with names. With a parameter varies what follows it.

        Raises
        ------
        ValueError
            For a name that is none of these, or a step that leads nowhere; nothing has been done then.
        SimulationError
            When the solver cannot go on.

        Examples
        --------
        >>> import pneumatic_servo as ps
        >>> simulation = ps.Model().start({"valveVoltage": 6.5})
        >>> step = simulation.transition(1e-3, outputs=["position"])
        >>> A, B, C, D = step
        >>> A.shape[1] == len(A), C.shape == (1, len(A)), D.shape == (1, len(step.inputs))
        (True, True, True)
        """
        constant_voltage.check(at_rest)
        asked = _Asked(size, checks.names("parameters", parameters), checks.names("outputs", outputs))
        before = asked.before(self, at_rest)
        return asked.settled(self, self._native.transition(*asked.of(self)), before, at_rest)

    def _followed(self, parameters: Sequence[str]) -> dict[str, tuple[str, float]]:
        """Return the defaults that follow some of the parameters and are not asked for themselves."""
        return {name: own for name, own in self._followers.items() if own[0] in parameters and name not in parameters}


METHODS = ("step", "set", "get", "save", "restore", "states", "move_states", "jacobian", "transition")
MEANT = {
    "run": "; a whole run is Model.simulate", "advance": "; did you mean step?", "do_step": "; did you mean step?",
    "reset": "; restore(saved) goes back to a state that save() has returned",
}  # fmt: skip
"""Names of other tools for methods of this class."""


def transitions(
    simulations: Sequence[Simulation],
    size: float,
    *,
    parameters: Sequence[str] = (),
    outputs: Sequence[str] = (),
    at_rest: AtRest = "mean",
    workers: int | None = None,
) -> list[Transition]:
    """Integrate many simulations over a step of a size in s, on all cores, and return their transitions.

    A step and its `Transition` have the same bits as by `Simulation.transition`. Simulations may be of different laws
    and models, and at different times.

    Parameters
    ----------
    simulations : sequence of Simulation
        Each of them another one.
    size : float
        Size of the step in s.
    parameters, outputs, at_rest
        As for `Simulation.transition`.
    workers : int, optional
        Number of threads; by default one per core that this process may use.

    Returns
    -------
    list of Transition
        One for each simulation, with shapes and units of their own: states differ where laws and modes do.

    Raises
    ------
    ValueError
        For a name that is none, a step that leads nowhere, or a simulation that is given twice.
    SimulationError
        When the solver cannot go on; the message has the number of the simulation. The others have made their step.

    Examples
    --------
    >>> import pneumatic_servo as ps
    >>> simulations = [ps.Model().start({"valveVoltage": voltage}) for voltage in (6.0, 7.0)]
    >>> steps = ps.transitions(simulations, 1e-3, outputs=["position"])
    >>> [step.D.shape == (1, len(step.inputs)) for step in steps]
    [True, True]
    """
    if not isinstance(simulations, Sequence):
        raise TypeError(f"simulations must be a list of simulations, not {shortened(simulations)}")
    constant_voltage.check(at_rest)
    asked = _Asked(size, checks.names("parameters", parameters), checks.names("outputs", outputs))
    threads = available_cores() if workers is None else checks.whole_number("workers", workers, least=1)
    # The followed variables differ from plant to plant; the extension module is asked for the same names of all.
    followed = list(dict.fromkeys(name for own in simulations for name in own._followed(asked.parameters)))
    before = [asked.before(own, at_rest) for own in simulations]
    natives = [simulation._native for simulation in simulations]
    told = _native.transitions(natives, size, [*asked.parameters, *followed], asked.outputs, threads)
    return [
        asked.settled(own, it, earlier, at_rest, followed)
        for own, it, earlier in zip(simulations, told, before, strict=True)
    ]


@dataclass(frozen=True)
class _Asked:
    """Arguments of a step."""

    size: float
    parameters: list[str]
    outputs: list[str]

    def of(self, simulation: Simulation) -> tuple[float, list[str], list[str]]:
        """Return it as the extension module takes it."""
        return self.size, [*self.parameters, *simulation._followed(self.parameters)], self.outputs

    def before(self, simulation: Simulation, at_rest: str) -> SavedState | None:
        """Return the state before a step that may have to be made again."""
        return simulation.save() if at_rest == "mean" and constant_voltage.VOLTAGE in simulation._model.inputs else None

    def told(
        self, simulation: Simulation, told: _native._Transition, followed: Sequence[str] | None = None
    ) -> Transition:
        """Return the extension module's answer for a step, with names."""
        own = simulation._followed(self.parameters)
        found = Transition._of(
            told, list(simulation._model.inputs), [*self.parameters, *(own if followed is None else followed)],
            self.outputs,
        )  # fmt: skip
        return found.along_leaders(self.parameters, own)

    def settled(
        self,
        simulation: Simulation,
        told: _native._Transition,
        before: SavedState | None,
        at_rest: str,
        followed: Sequence[str] | None = None,
    ) -> Transition:
        """Return the transition of a step that was made, with the columns of a voltage that rests as chosen."""
        found = self.told(simulation, told, followed)
        if not found.lost or at_rest == "refuse":
            return found
        after = None if before is None else simulation.save()

        def side(more: float) -> Transition:
            assert before is not None
            simulation.restore(before)
            simulation.set_one(constant_voltage.VOLTAGE, simulation.get_one(constant_voltage.VOLTAGE) + more)
            return self.told(simulation, simulation._native.transition(*self.of(simulation)))

        try:
            return found.settled(at_rest, side)
        finally:
            if after is not None:
                simulation.restore(after)


def _resumed(
    model: ModelDescription, settings: Mapping[str, Value], saved: SavedState, followers: Followers
) -> Simulation:
    """Return a simulation that goes on from a saved state, without repeating warnings."""
    simulation = Simulation(model._native.start(list(settings.items()), 0.0), model, settings, followers)
    simulation.restore(saved)
    return simulation
