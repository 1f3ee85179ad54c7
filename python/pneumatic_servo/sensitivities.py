"""Sensitivities of the recorded outputs of a run to parameters, inputs and states."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pneumatic_servo import _native, constant_voltage
from pneumatic_servo.errors import NoDerivative
from pneumatic_servo.grid import Grid, courses_of
from pneumatic_servo.names import did_you_mean
from pneumatic_servo.variables import Value, Variables

Array = NDArray[np.float64]
Followers = Mapping[str, tuple[str, float]]
"""Defaults that follow a parameter: by the name of each that parameter, and the derivative by it."""


@dataclass(frozen=True)
class Crossing:
    """An event of a run.

    Attributes
    ----------
    time : float
        When, in s.
    name : str
        Which.
    rate : float
        Rate at which its indicator fell, in its own unit per s; a small one means that the motion nearly missed the
        event.
        NaN where the indicator has no derivative.
    delays : dict
        Derivatives of its time, in s per SI unit of each variable; NaN where there is none.

    Examples
    --------
    >>> import pneumatic_servo as ps
    >>> run = ps.Model().simulate({"friction.law": "Coulomb"}, inputs={"valveVoltage": 7}, stop=0.2, step=1e-3,
    ...                           sensitivities=["friction.coulomb.Fc"])
    >>> first = run.sensitivities.events[0]
    >>> 0.0 < first.time < 0.2
    True
    """

    time: float
    name: str
    rate: float
    delays: Mapping[str, float]


class Sensitivities:
    """Derivatives of recorded variables: ``run.sensitivities["position", "valve.C"]``, in SI per SI.

    Attributes
    ----------
    names : tuple of str
        Variables by which the run is differentiated.
    events : list of Crossing
        The events of the run.
    lost : dict
        Points beyond which there is no derivative: a `NoDerivative` by the name of the variable.

    Examples
    --------
    >>> import pneumatic_servo as ps
    >>> run = ps.Model().simulate(inputs={"valveVoltage": 7}, stop=0.2, step=1e-3, sensitivities=["valve.C"])
    >>> bool(run.sensitivities["position", "valve.C"][-1] > 0.0)  # a larger valve moves the carriage further
    True
    """

    def __init__(
        self,
        names: Sequence[str],
        variables: Variables,
        time: Array,
        values: Array,
        lost: Sequence[tuple[float, str, str] | None],
        events: Sequence[tuple[float, str, float, Sequence[float]]],
    ) -> None:
        self.names = tuple(names)
        self.variables = variables
        self.lost = {name: NoDerivative(*where) for name, where in zip(names, lost, strict=True) if where is not None}
        self.events = [
            Crossing(time, name, rate, dict(zip(names, delays, strict=True))) for time, name, rate, delays in events
        ]
        self._time, self._values = time, values

    @classmethod
    def of(
        cls, names: Sequence[str], followers: Followers, variables: Variables, time: Array, told: _native._Sensitivities
    ) -> Sensitivities:
        """Return derivatives by names, from the extension module's by names and by defaults that follow them."""
        values, lost, events = told
        leaders = [list(names).index(leader) for leader, _ in followers.values()]
        own = list(lost[: len(names)])
        for place, other in zip(leaders, lost[len(names) :], strict=True):
            own[place] = min((it for it in (own[place], other) if it is not None), key=lambda it: it[0], default=None)
        delays = [(*event[:3], along_leaders(names, np.asarray(event[3]), followers).tolist()) for event in events]
        return cls(names, variables, time, along_leaders(names, values[:, :, : len(time)], followers), own, delays)

    def __getitem__(self, key: tuple[str, str]) -> Array:
        """Return how a recorded variable changes with another, of shape (rows,).

        Raises
        ------
        TypeError
            For anything but two names.
        KeyError
            When the one was not recorded, or the run not differentiated by the other.
        NoDerivative
            When the run has come through a point at which there is none; `until_lost` has the rows before.
        """
        if not isinstance(key, tuple) or len(key) != 2:
            raise TypeError(f'two names are needed, of what and by what, as in ["position", "valve.C"], not {key!r}')
        found = self.until_lost(*key)
        if key[1] in self.lost:
            raise self.lost[key[1]]
        lacking = np.isnan(found)
        if lacking.any():
            reason = (
                "it is rounded, or bends just there, as a flow where a valve begins to open at a communication point; "
                "until_lost has the other rows"
            )
            raise NoDerivative(float(self._time[np.argmax(lacking)]), key[0], reason)
        return found

    def until_lost(self, of: str, by: str) -> Array:
        """Return the same, of shape (rows,), with NaN in the rows for which there is no derivative."""
        output = _place(of, list(self.variables), f"{of} is not recorded")
        direction = _place(by, self.names, f"the run is not differentiated by {by}")
        if self.variables[of].kind != "real":
            raise KeyError(f"{of} is no real number, and has no derivative")
        found: Array = self._values[direction, output]
        return found

    def jacobian(self, of: str) -> Array:
        """Return how a recorded variable changes with all `names`, of shape (rows, names)."""
        return np.stack([self[of, by] for by in self.names], axis=1)

    @property
    def smallest_rate(self) -> float:
        """Slowest rate of an indicator at its event, in its own unit per s; infinite in a run without events."""
        return min((abs(event.rate) for event in self.events), default=float("inf"))

    def __iter__(self) -> Iterator[tuple[str, str]]:
        return ((of, by) for by in self.names for of in self.variables)

    def __len__(self) -> int:
        return len(self.names) * len(self.variables)

    def __repr__(self) -> str:
        lost = f"; lost by {', '.join(self.lost)}" if self.lost else ""
        of, by = ", ".join(self.variables), ", ".join(self.names)
        return f"<Sensitivities of {of} by {by}; {len(self.events)} events{lost}>"


def along_leaders(names: Sequence[str], slopes: Array, followers: Followers) -> Array:
    """Return derivatives by names, from derivatives by names and followers: defaults vary with the parameter."""
    found = np.array(slopes[: len(names)])
    for by_follower, (leader, slope) in zip(slopes[len(names) :], followers.values(), strict=True):
        found[list(names).index(leader)] += slope * by_follower
    return found


def _place(name: str, known: Sequence[str], lacking: str) -> int:
    if name not in known:
        raise KeyError(lacking + (did_you_mean(str(name), known) or f"; there are {', '.join(known)}"))
    return list(known).index(name)


@dataclass(frozen=True)
class Transition:
    """Derivatives of a step by states and inputs, exact through the events in it: ``A, B, C, D = transition``.

    ``x+ = A x + B u + P p`` and ``y = C x + D u + Q p``, all in SI units.

    Attributes
    ----------
    A, B, P : ndarray
        Of shapes (next_states, states), (next_states, inputs) and (next_states, parameters).
    C, D, Q : ndarray
        Of shapes (outputs, states), (outputs, inputs) and (outputs, parameters); outputs are those at the end.
    states, next_states : tuple of str
        Names of x at the begin of the step and at its end: the continuous states that are integrated and, behind
        them, the numbers that the memory keeps, such as ``memory.friction.since``. They differ where the mode does.
    inputs, parameters, outputs : tuple of str
        Names of u, which is added to the inputs over the whole step, of p and of y. Inputs that are true or false, as
        ``coil[1]``, have no derivative: their columns are 0.
    lost : dict
        States, inputs and parameters without a derivative, and why; their columns are NaN. With ``at_rest="refuse"`` so
        it is with the voltage while it rests, unless ``valve.hysteresis`` is 0: more of it moves the spool, and less
        does not.

    Examples
    --------
    >>> import pneumatic_servo as ps
    >>> A, B, C, D = ps.Model().start().transition(1e-3, outputs=["position"])
    >>> A.shape[0] == A.shape[1] == B.shape[0], C.shape[0] == D.shape[0] == 1
    (True, True)
    """

    A: Array
    B: Array
    C: Array
    D: Array
    P: Array
    Q: Array
    states: tuple[str, ...]
    next_states: tuple[str, ...]
    inputs: tuple[str, ...]
    parameters: tuple[str, ...]
    outputs: tuple[str, ...]
    lost: Mapping[str, NoDerivative]

    def __iter__(self) -> Iterator[Array]:
        return iter((self.A, self.B, self.C, self.D))

    @classmethod
    def _of(
        cls, told: _native._Transition, inputs: Sequence[str], parameters: Sequence[str], outputs: Sequence[str]
    ) -> Transition:
        """Return the extension module's answer for a step, with names."""
        states, next_states, (a, b, c, d, p, q), lost = told
        columns = [*states, *inputs, *parameters]
        reasons = {columns[column]: NoDerivative(time, event, reason) for column, time, event, reason in lost}
        x, next_x, u, by, of = map(tuple, (states, next_states, inputs, parameters, outputs))
        return cls(a, b, c, d, p, q, x, next_x, u, by, of, reasons)

    def settled(self, at_rest: str, side: Callable[[float], Transition]) -> Transition:
        """Return the transition with the columns of a constant voltage, and of the play that it drags, as chosen.

        `side` returns the transition of the same step with so much more voltage.
        """
        names = [name for name, lost in self.lost.items() if lost.event == constant_voltage.VOLTAGE]
        if at_rest == "refuse" or not names:
            return self
        sides = [side(constant_voltage.HARDLY), side(-constant_voltage.HARDLY)] if at_rest == "mean" else []
        if any(one.next_states != self.next_states or not one.lost.keys().isdisjoint(names) for one in sides):
            return self
        columns = {field: getattr(self, field).copy() for field in "ABCD"}
        for name in names:
            known, fields = (self.states, "AC") if name in self.states else (self.inputs, "BD")
            place = known.index(name)
            for field in fields:
                own = [getattr(one, field)[:, place] for one in sides]
                columns[field][:, place] = np.mean(own, axis=0) if own else 0.0
        return replace(self, **columns, lost={name: lost for name, lost in self.lost.items() if name not in names})

    def along_leaders(self, parameters: Sequence[str], followers: Followers) -> Transition:
        """Return the transition by parameters alone: the columns of their followers, at the end, are added."""
        by = tuple(parameters)
        if by == self.parameters:
            return self
        used = {name: own for name, own in followers.items() if name in self.parameters}
        rows = [self.parameters.index(name) for name in (*by, *used)]
        p, q = (along_leaders(by, matrix.T[rows], used).T for matrix in (self.P, self.Q))
        lost = {name: why for name, why in self.lost.items() if name not in self.parameters or name in by}
        for name, (leader, _) in used.items():
            if name in self.lost:
                lost.setdefault(leader, self.lost[name])
        return replace(self, P=p, Q=q, parameters=by, lost=lost)


@dataclass(frozen=True)
class Gradient:
    """Gradient of a scalar of a run, in its unit per SI unit.

    Attributes
    ----------
    inputs : dict
        With what is added to each input over each step: an array of shape (steps,) by its name.
    states : dict
        With the states at the begin, and with the numbers that the memory keeps then.
    parameters : dict
        With the parameters that were asked for.

    Examples
    --------
    >>> import pneumatic_servo as ps
    >>> run = ps.Model().simulate(inputs={"valveVoltage": 6.5}, stop=0.2, step=1e-3, outputs=["position"])
    >>> gradient = run.vjp({"position": [0.0] * 200 + [1.0]}, parameters=["valve.C"])
    >>> sorted(gradient.parameters), gradient.inputs["valveVoltage"].shape
    (['valve.C'], (200,))
    """

    inputs: Mapping[str, Array]
    states: Mapping[str, float]
    parameters: Mapping[str, float]


class Replay:
    """Arguments of a run, so that it can be repeated."""

    def _voltage(self) -> Array:
        """Return the valve voltage over each step."""
        begin = self._native.start(list(self._settings.items()), self._grid.start).get(constant_voltage.VOLTAGE)
        given = dict(self._inputs).get(constant_voltage.VOLTAGE, begin)
        return courses_of({constant_voltage.VOLTAGE: given}, self._grid)[constant_voltage.VOLTAGE]

    def __init__(
        self,
        native: _native.Model,
        settings: Mapping[str, Value],
        inputs: Sequence[tuple[str, Any]],
        grid: Grid,
        names: Sequence[str],
        followers: Followers,
    ) -> None:
        self._native, self._settings, self._inputs, self._grid, self._names = native, settings, inputs, grid, names
        self._followers = followers

    def gradient(
        self, cotangents: Mapping[str, Any], parameters: Sequence[str], rows: int, at_rest: str = "mean"
    ) -> Gradient:
        """Return the gradient of the sum of recorded variables times cotangents."""
        constant_voltage.check(at_rest)
        if rows != self._grid.rows:
            raise ValueError("the run ended early, and has no gradient")
        weights = np.zeros((len(cotangents), rows))
        for row, (name, given) in zip(weights, cotangents.items(), strict=True):
            own = np.asarray(given, dtype=np.float64)
            if own.shape not in ((), (rows,)):
                raise ValueError(f"cotangents of {name} have the shape {own.shape}; the run has {rows} rows")
            if not np.isfinite(own).all():
                raise ValueError(f"cotangents of {name} must be finite numbers")
            row[:] = own
        followed = {
            name: follows
            for name, follows in self._followers.items()
            if follows[0] in parameters and name not in parameters
        }

        def made(driven: Sequence[tuple[str, Any]]) -> tuple[Array, Sequence[tuple[str, float]], Sequence[float]]:
            settings = [own for own in self._settings.items() if own[0] not in dict(driven)]
            return _native.gradient(
                self._native, settings, list(driven), self._grid.numbers, list(cotangents), weights,
                [*parameters, *followed],
            )  # fmt: skip

        def again(voltage: Array) -> Array:
            held = (constant_voltage.VOLTAGE, (self._grid.points()[:-1], voltage))
            return made([*(own for own in self._inputs if own[0] != constant_voltage.VOLTAGE), held])[0]

        inputs, states, slopes = made(self._inputs)
        inputs = constant_voltage.settled(self._names, inputs, at_rest, self._voltage, again)
        constant_voltage.refuse(self._names, inputs, self._grid.points())
        of_parameters = along_leaders(parameters, np.asarray(slopes), followed).tolist()
        return Gradient(
            dict(zip(self._names, inputs, strict=True)), dict(states), dict(zip(parameters, of_parameters, strict=True))
        )
