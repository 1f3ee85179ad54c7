"""Runs one case: plant and friction law together, from event to event."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from gas import Gas
from plant import DEFAULTS, Inputs, Plant, Value
from scipy.integrate import solve_ivp  # type: ignore[import-untyped]

from friction import LAWS, Contact, Law, Regime

DEFAULT_LAW = "Stribeck"
INPUT_DEFAULTS: dict[str, Any] = {
    "valveVoltage": 5.0,
    "externalForce": 0.0,
    "supplyPressure": 5e5,
}
MAX_EVENTS_PER_STEP = 200
"""Beyond this the regimes alternate without end, which no correct case does."""
LONGEST_INTEGRATION_STEP = 1e-4
"""Far below half a period of a ringing bristle, lest a step hide two reversals."""


class Row(NamedTuple):
    """One line of a reference file."""

    time: float
    position: float
    velocity: float
    pressureA: float
    temperatureA: float
    pressureB: float
    temperatureB: float
    spool: float
    frictionForce: float
    sticking: int


def simulate(case: Mapping[str, Any], tolerance: float) -> list[Row]:
    """The trajectory of ``case`` at a relative tolerance."""
    plant_parameters, law = configure(case["parameters"])
    run = Run(Plant(plant_parameters), law, tolerance)
    return list(_rows(run, case))


def configure(parameters: Mapping[str, Value]) -> tuple[dict[str, Value], Law]:
    """Splits the parameters of a case into plant parameters and a ready friction law."""
    own = dict(parameters)
    entry = LAWS[str(own.pop("friction.law", DEFAULT_LAW))]
    prefix = f"friction.{entry.group}."
    settings = {name.removeprefix(prefix): own.pop(name) for name in parameters if name.startswith(prefix)}
    unknown = (settings.keys() - entry.defaults.keys()) | (own.keys() - DEFAULTS.keys())
    if unknown:
        raise ValueError(f"unknown parameters {sorted(unknown)}")
    numbers = {name: float(value) for name, value in settings.items()}
    return DEFAULTS | own, entry.build({**entry.defaults, **numbers})


def _rows(run: Run, case: Mapping[str, Any]) -> Iterator[Row]:
    step = case["communicationStep"]
    steps_per_row = round(case["outputStep"] / step)
    signals = INPUT_DEFAULTS | case["inputs"]
    run.sample(_inputs(signals, 0.0), 0.0)
    run.start()
    yield run.row(0.0)
    for k in range(round(case["stopTime"] / step)):
        run.sample(_inputs(signals, k * step), k * step)
        run.advance(step)
        if (k + 1) % steps_per_row == 0:
            yield run.row((k + 1) * step)


def _inputs(signals: Mapping[str, Any], time: float) -> Inputs:
    return Inputs(
        signal(signals["valveVoltage"], time),
        signal(signals["externalForce"], time),
        signal(signals["supplyPressure"], time),
    )


def signal(description: Any, time: float) -> float:
    """The value of an input: a constant, or an offset sine."""
    if not isinstance(description, Mapping):
        return float(description)
    if description["waveform"] != "sine":
        raise ValueError(f"unknown waveform {description['waveform']!r}")
    angle = 2.0 * math.pi * description["frequency"] * time
    return float(description["offset"] + description["amplitude"] * math.sin(angle))


@dataclass(frozen=True)
class Instant:
    """Everything the equations need at one state."""

    velocity: float
    """The velocity of the carriage: zero where the friction law holds it."""
    a: Gas
    b: Gas
    contact: Contact


class Run:
    """The state of a simulation that advances by communication steps."""

    def __init__(self, plant: Plant, law: Law, tolerance: float) -> None:
        self._plant = plant
        self._law = law
        self._tolerance = tolerance
        self._size = len(plant.units())
        self._absolute = tolerance * np.array([*plant.units(), *law.units])
        self._inputs: Inputs
        self._begin: float
        self._command: float
        self._regime: Regime
        self._state: list[float]

    def sample(self, inputs: Inputs, time: float) -> None:
        """Takes new inputs, to be held until the next sample, at the beginning of a communication step."""
        self._inputs, self._begin = inputs, time
        self._command = self._plant.actuator.command(inputs.voltage, time)

    def start(self) -> None:
        """Sets the initial state and regime."""
        self._state = self._plant.start(self._command, self._inputs.supply_pressure) + [0.0] * len(self._law.units)
        self._regime = self._law.start(self._instant(0.0, self._state, held=False, direction=0).contact)

    def advance(self, duration: float) -> None:
        """Integrates over one communication step; times within it count from its beginning."""
        self._adopt_inputs()
        time = 0.0
        kinks = self._plant.actuator.kinks(self._begin, self._begin + duration)
        ends = [*(kink - self._begin for kink in kinks), duration]
        for _ in range(MAX_EVENTS_PER_STEP):
            time = self._integrate(time, ends[0])
            if time >= ends[0]:
                ends.pop(0)
            if not ends:
                return
        raise RuntimeError(f"no progress in regime {self._regime}")

    def row(self, time: float) -> Row:
        """The outputs at the current state, with the inputs in force up to now."""
        now = self._instant(time - self._begin, self._state, self._regime.held, self._regime.direction)
        return Row(
            round(time, 9),
            self._state[0],
            now.velocity,
            now.a.pressure,
            now.a.temperature,
            now.b.pressure,
            now.b.temperature,
            self._plant.actuator.spool(self._state[6:8]),
            self._regime.force(now.contact),
            int(self._regime.sticking),
        )

    def _adopt_inputs(self) -> None:
        """Leaves a regime that a jump of the inputs has ended."""
        contact = self._contact(0.0)
        for which, margin in enumerate(self._regime.margins(contact)):
            if margin < 0.0:
                self._regime = self._regime.expired(contact, which)
                return

    def _integrate(self, time: float, end: float) -> float:
        """Integrates to ``end`` or to the end of the regime, and returns the time reached."""
        events = self._events(time)
        solution = solve_ivp(
            lambda t, y: self._rates(t, y.tolist()),
            (time, end),
            np.array(self._state),
            method="DOP853",
            events=events,
            rtol=self._tolerance,
            atol=self._absolute,
            max_step=LONGEST_INTEGRATION_STEP,
        )
        if not solution.success:
            raise RuntimeError(solution.message)
        self._state = solution.y[:, -1].tolist()
        reached = float(solution.t[-1])
        if solution.status == 1:
            self._change_regime(reached, next(i for i, hits in enumerate(solution.t_events) if len(hits)))
        return reached

    def _change_regime(self, time: float, event: int) -> None:
        directed = self._regime.direction != 0
        if directed and event == 0:
            # The event leaves a velocity of rounding size; the mass is exactly at rest.
            self._state[1] = 0.0
            at_rest = self._instant(time, self._state, held=True, direction=0).contact
            self._regime = self._regime.at_rest(at_rest)
        else:
            self._regime = self._regime.expired(self._contact(time), event - int(directed))

    def _events(self, time: float) -> list[Callable[[float, Any], float]]:
        """The event functions of the regime: reversal first, if it has a direction."""
        regime = self._regime
        count = len(regime.margins(self._contact(time)))
        events = [self._margin_event(regime, i) for i in range(count)]
        if regime.direction != 0:
            events.insert(0, _terminal(lambda t, y: regime.direction * y[1]))
        return events

    def _margin_event(self, regime: Regime, which: int) -> Callable[[float, Any], float]:
        return _terminal(
            lambda t, y: regime.margins(self._instant(t, y.tolist(), regime.held, regime.direction).contact)[which]
        )

    def _rates(self, time: float, state: list[float]) -> list[float]:
        if not all(content > 0.0 for content in state[2:6]):
            # A trial step far too long has left the physical states; NaN makes it be rejected.
            return [math.nan] * len(state)
        regime = self._regime
        now = self._instant(time, state, regime.held, regime.direction)
        acceleration = (now.contact.applied - regime.force(now.contact)) / self._plant.inertia(state[0])
        return [
            *self._plant.rates(
                state,
                now.velocity,
                acceleration,
                now.a,
                now.b,
                self._command,
                self._inputs.supply_pressure,
                self._begin + time,
            ),
            *regime.rates(now.contact),
        ]

    def _contact(self, time: float) -> Contact:
        return self._instant(time, self._state, self._regime.held, self._regime.direction).contact

    def _instant(self, time: float, state: list[float], held: bool, direction: int) -> Instant:
        x, v = state[0], 0.0 if held else state[1]
        a, b = self._plant.gases(state)
        applied = self._plant.applied_force(x, v, a, b, self._inputs.external_force)
        level = self._plant.friction_level(x, a, b, direction or v or applied)
        contact = Contact(x, state[1], state[self._size :], applied, level, self._begin + time)
        return Instant(v, a, b, contact)


def _terminal(function: Callable[[float, Any], float]) -> Callable[[float, Any], float]:
    """Marks an event function: integration stops where it falls through zero."""
    function.terminal = True  # type: ignore[attr-defined]
    function.direction = -1.0  # type: ignore[attr-defined]
    return function
