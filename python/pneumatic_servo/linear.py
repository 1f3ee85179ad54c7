"""The plant linearised at an operating point, for controller design."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from html import escape
from typing import TYPE_CHECKING, Literal, NamedTuple, get_args

import numpy as np
from numpy.typing import NDArray

from pneumatic_servo.errors import MissingPackage, warn
from pneumatic_servo.model_description import ModelDescription
from pneumatic_servo.names import did_you_mean
from pneumatic_servo.run import table
from pneumatic_servo.simulation import SavedState, Simulation
from pneumatic_servo.trim import OperatingPoint, Start
from pneumatic_servo.variables import Value, Variables

if TYPE_CHECKING:
    import control

Array = NDArray[np.float64]
LeftOut = Literal["residualise", "hold"]


@dataclass(frozen=True)
class Linearisation:
    """``dx/dt = A x + B u``, ``y = C x + D u`` for small deviations from an operating point.

    It can be taken apart: ``A, B, C, D = linearisation``.

    Attributes
    ----------
    A, B, C, D : ndarray
        Of shapes (states, states), (states, inputs), (outputs, states), (outputs, inputs), in SI units.
    states, inputs, outputs : tuple of str
        Names of rows and columns.
    x, u, y : ndarray
        The operating point, in SI units.
    variables : Variables
        All variables of the model.
    is_scaled : bool
        Whether all is in units of nominal values instead of SI units; see `scaled`.
    left_out : dict
        States of the plant that are not among `states`, with their values in SI units at the operating point.
    held : tuple of str
        States of `left_out` that are held there (truncated). The others follow at once (residualised): their rates are
        0, and the static gain is that of the whole plant.
    settings : dict
        Parameters and inputs of the operating point, and those states that a run can be given at its start. A run of
        `Model.start` with the linearisation begins with all of its states.

    Examples
    --------
    >>> import pneumatic_servo as ps
    >>> linear = ps.Model().linearise({"velocity": 0.05, "valve.hysteresis": 0})
    >>> A, B, C, D = linear.scaled()
    >>> linear.to_control().nstates == len(linear.states)
    True
    """

    A: Array
    B: Array
    C: Array
    D: Array
    states: tuple[str, ...]
    inputs: tuple[str, ...]
    outputs: tuple[str, ...]
    x: Array
    u: Array
    y: Array
    variables: Variables
    is_scaled: bool = False
    left_out: Mapping[str, float] = field(default_factory=dict)
    held: tuple[str, ...] = ()
    settings: Mapping[str, Value] = field(default_factory=dict)
    _start: tuple[Mapping[str, Value], SavedState] | None = field(default=None, repr=False, compare=False)

    def __iter__(self) -> Iterator[Array]:
        return iter((self.A, self.B, self.C, self.D))

    def scaled(self) -> Linearisation:
        """Return the same with every state, input and output in units of its nominal value.

        Matrices in SI units mix pascal and metre; scaled ones have entries of like size, which is better for design
        and for comparing directions.
        """
        x, u, y = (self._nominal(names) for names in (self.states, self.inputs, self.outputs))
        return Linearisation(
            self.A * x / x[:, None],
            self.B * u / x[:, None],
            self.C * x / y[:, None],
            self.D * u / y[:, None],
            self.states,
            self.inputs,
            self.outputs,
            self.x / x,
            self.u / u,
            self.y / y,
            self.variables,
            is_scaled=True,
            left_out=self.left_out,
            held=self.held,
            settings=self.settings,
            _start=self._start,
        )

    def _nominal(self, names: Sequence[str]) -> Array:
        return np.array([self.variables[name].nominal or 1.0 for name in names])

    def to_control(self) -> control.StateSpace:
        """Return a state space of python-control, with names."""
        try:
            import control
        except ImportError as error:
            raise MissingPackage("python-control", "control") from error
        # Its names of signals may have no dots.
        names = {
            key: [name.replace(".", "_") for name in values]
            for key, values in [("states", self.states), ("inputs", self.inputs), ("outputs", self.outputs)]
        }
        return control.ss(self.A, self.B, self.C, self.D, **names)

    def __repr__(self) -> str:
        blocks = [
            _block("A", self.A, self.states, self.states),
            _block("B", self.B, self.states, self.inputs),
            _block("C", self.C, self.outputs, self.states),
            _block("D", self.D, self.outputs, self.inputs),
        ]
        scaled = ["in units of nominal values:"] if self.is_scaled else []
        return "\n".join([*scaled, *self._point(), *self._reduced(), *blocks])

    def _reduced(self) -> list[str]:
        """Say which states were left out, and how."""
        following = [name for name in self.left_out if name not in self.held]
        ways = [("left out, following at once", following), ("left out, held at their values", self.held)]
        return [f"{way}: {', '.join(names)}" for way, names in ways if names]

    def _repr_html_(self) -> str:
        scaled = ["in units of nominal values"] if self.is_scaled else []
        lines = "<br>".join(escape(line) for line in [*scaled, *self._point(), *self._reduced()])
        blocks = [
            ("A", self.A, self.states, self.states), ("B", self.B, self.states, self.inputs),
            ("C", self.C, self.outputs, self.states), ("D", self.D, self.outputs, self.inputs),
        ]  # fmt: skip
        tables = (
            table(
                [title, *columns], ([name, *(f"{x:.4g}" for x in row)] for name, row in zip(rows, matrix, strict=True))
            )
            for title, matrix, rows, columns in blocks
        )
        # A wide matrix scrolls, and is not folded.
        return f"<p>{lines}</p>" + "".join(f'<div style="overflow-x:auto" tabindex="0">{one}</div>' for one in tables)

    def _point(self) -> Iterator[str]:
        for names, values in [(self.states, self.x), (self.inputs, self.u)]:
            for name, value in zip(names, values, strict=True):
                yield f"{name} = {value:.6g}{self._unit(name)}"

    def _unit(self, name: str) -> str:
        """Return the unit of a value of the operating point, for people."""
        variable = self.variables[name]
        unit = "" if variable.unit == "1" else f" {variable.unit}"
        if not self.is_scaled:
            return unit
        nominal = 1.0 if variable.nominal is None else variable.nominal
        return f" times {nominal:g}{unit}"


def _block(title: str, matrix: Array, rows: Sequence[str], columns: Sequence[str]) -> str:
    width = max([12, *(len(name) + 2 for name in columns)])
    margin = max(len(name) for name in [title, *rows])
    head = f"\n{title:{margin}}" + "".join(f"{name:>{width}}" for name in columns)
    body = (
        f"{name:{margin}}" + "".join(f"{x:{width}.4g}" for x in row) for name, row in zip(rows, matrix, strict=True)
    )
    return "\n".join([head, *body])


def linearise(
    model: ModelDescription,
    start: Start,
    at: Mapping[str, Value],
    states: Sequence[str] | None,
    inputs: Sequence[str],
    outputs: Sequence[str],
    trim: bool,
    left_out: LeftOut,
) -> Linearisation:
    """Linearise a model; see `Model.linearise`."""
    if left_out not in get_args(LeftOut):
        raise ValueError(f"left_out is 'residualise' or 'hold', not {left_out!r}")
    unknown = next((name for name in inputs if name not in model.inputs), None)
    if unknown is not None:
        hint = did_you_mean(unknown, model.inputs)
        raise ValueError(
            f"inputs: {unknown!r} is not an input of {model.name}{hint}; "
            f"the inputs are {', '.join(model.inputs) or 'none'}"
        )
    discrete = next((name for name in inputs if model.inputs[name].kind != "real"), None)
    if discrete is not None:
        raise ValueError(f"inputs: {discrete} is true or false, and nothing can be differentiated by it")
    point = OperatingPoint(model, start, at, inputs)
    if trim:
        point.trim()
    simulation = point.simulation
    chosen = tuple(states if states is not None else simulation.states)
    unknown = next((name for name in chosen if name not in simulation.states), None)
    if unknown is not None:
        raise ValueError(
            f"{unknown} is no state of this run{did_you_mean(unknown, simulation.states)}; "
            f"the states are {', '.join(simulation.states)}"
        )
    others = tuple(name for name in simulation.states if name not in chosen)
    every = (*chosen, *others)
    rates = [point.rates[name] for name in every]
    full = _Matrices(
        simulation.jacobian(rates, every),
        simulation.jacobian(rates, inputs),
        simulation.jacobian(outputs, every),
        simulation.jacobian(outputs, inputs),
    )
    found, held = full.reduced(every, len(chosen), left_out, [model.variables[name].nominal or 1.0 for name in every])
    for place, name in enumerate(inputs):
        if not found.b[:, place].any() and not found.d[:, place].any():
            value = f"{name} = {simulation[name]:g}{_of_unit(model, name)}"
            warn(f"{value}: it has no effect here, B is 0; {full.blocking(every, len(chosen), place) or _why(point)}")
    for law in held_between_samples(model, simulation):
        warn(f"{law}, so that its stiffness and damping are not in A; a frequency response by simulation shows them")
    return Linearisation(
        *found,
        chosen,
        tuple(inputs),
        tuple(outputs),
        simulation.get(chosen),
        simulation.get(inputs),
        simulation.get(outputs),
        model.variables,
        left_out={name: simulation.get_one(name) for name in others},
        held=held,
        settings=_settings(model, simulation),
        _start=(simulation._settings, simulation.save()),
    )


def held_between_samples(model: ModelDescription, simulation: Simulation) -> Iterator[str]:
    """Yield the beginning of a warning for each law whose force does not follow the states between its samples."""
    for own in model.variables.values():
        if own.meaning == "sampling" and own.counts_for and str(simulation[own.counts_for[0]]) == own.counts_for[1]:
            choice, law = own.counts_for
            yield f"{choice} = {law}: it holds its force between samples ({own.name})"


class _Matrices(NamedTuple):
    """A, B, C and D."""

    a: Array
    b: Array
    c: Array
    d: Array

    def reduced(
        self, names: tuple[str, ...], kept: int, left_out: LeftOut, nominal: Sequence[float]
    ) -> tuple[_Matrices, tuple[str, ...]]:
        """Leave out all states but the first ones; also return which of them are held.

        Residualisation (singular perturbation approximation): with the rates of the others at 0, these follow from the
        states that are kept and the inputs. A state whose rate no other left-out state changes comes to no rest of its
        own, as a position, and is held.
        """
        follow = list(range(kept, len(names))) if left_out == "residualise" else []
        while True:
            pushed = [row for row in follow if self.a[row, follow].any()]
            if len(pushed) == len(follow):
                break
            follow = pushed
        held = tuple(name for place, name in enumerate(names) if place >= kept and place not in follow)
        if not follow:
            return _Matrices(self.a[:kept, :kept], self.b[:kept], self.c[:, :kept], self.d), held
        units = np.array(nominal)[follow]
        own = self.a[np.ix_(follow, follow)] * units / units[:, None]
        words = ", ".join(names[place] for place in follow)
        if np.linalg.matrix_rank(own) < len(follow):
            raise ValueError(
                f"states: {words} come to no rest of their own, and cannot follow at once; keep one more of them, or "
                "hold them by left_out='hold'"
            )
        if np.linalg.eigvals(own).real.max() > 0.0:
            warn(f"{words}: left out, but unstable at this point; keep them among the states")
        to_states, to_inputs = (
            units[:, None] * np.linalg.solve(own, rows[follow] / units[:, None]) for rows in (self.a[:, :kept], self.b)
        )
        through_states, through_outputs = self.a[:kept][:, follow], self.c[:, follow]
        return _Matrices(
            self.a[:kept, :kept] - through_states @ to_states,
            self.b[:kept] - through_states @ to_inputs,
            self.c[:, :kept] - through_outputs @ to_states,
            self.d - through_outputs @ to_inputs,
        ), held

    def blocking(self, names: tuple[str, ...], kept: int, place: int) -> str:
        """Name the states whose being held takes the effect of an input that it would have, and the remedy."""
        moved = self.b[:, place] != 0.0
        first = [names[row] for row in np.flatnonzero(moved) if row >= kept]
        reached = moved
        for _ in names:
            reached = reached | (self.a[:, reached] != 0.0).any(axis=1)
        if not first or not reached[:kept].any():
            return ""
        return (
            f"it acts through {', '.join(first)}, which is left out and held; left_out='residualise' keeps its static "
            "gain, and a state that is kept its dynamics"
        )


def _settings(model: ModelDescription, simulation: Simulation) -> dict[str, Value]:
    """Return the parameters and inputs of a run that begins at the present point."""
    states = {f"{name}0": simulation.get_one(name) for name in simulation.states if f"{name}0" in model.parameters}
    return {**simulation._settings, **states, **{name: simulation.get_one(name) for name in model.inputs}}


def _of_unit(model: ModelDescription, name: str) -> str:
    unit = model.variables[name].unit
    return "" if unit == "1" else f" {unit}"


def _sticks(point: OperatingPoint) -> bool:
    return "sticking" in point.variables and bool(point.simulation["sticking"] > 0.5)


def _why(point: OperatingPoint) -> str:
    """Say why an input has no effect, and the remedy."""
    stuck = "the carriage sticks, and " if _sticks(point) else ""
    return (
        f"{stuck}an input has none while the valve is in its dead zone, or within the play of its hysteresis; "
        "linearise about a motion instead, for example at velocity = 0.05 with valve.hysteresis = 0"
    )
