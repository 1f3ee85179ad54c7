"""Operating points: the states and inputs at which a plant stays as it is, or moves on steadily."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from itertools import product

import numpy as np
from numpy.typing import NDArray

from pneumatic_servo.model_description import ModelDescription
from pneumatic_servo.run_errors import SimulationError
from pneumatic_servo.simulation import SavedState, Simulation
from pneumatic_servo.variables import Value

Array = NDArray[np.float64]
Start = Callable[[Mapping[str, Value]], Simulation]
"""Starts a run with settings, as `Model.start` does."""

NEWTON_STEPS = 100
OFFSETS = (0.0, 0.1, -0.1, 0.2, -0.2, 0.4, -0.4, 0.8, -0.8)
"""Inputs that are tried, as distances from their values in nominal units."""
FILLED = (0.0, 0.5)
"""Shares of the supply pressure that chambers are filled by."""
SUPPLY = "supplyPressure"
FASTER = tuple(4.0**power for power in range(1, 10))
"""Largest factor of the faster motions that are tried for one whose point is not found."""
FASTEST = 10.0
"""Largest speed, in nominal units, of a motion that leads to a slower one."""
SETTLING_STEP, SETTLING_STEPS = 5e-5, 2000
"""In s, so short that only a slow mass comes to rest within one; and enough of them for the chambers to fill."""
RUN_IN, RUN_IN_SPEED, RUN_IN_TIME = 1e-3, 0.02, 0.02
"""In m, m/s and s: the way on which friction forgets a rest, the least speed there, the duration of the given speed."""
VACUUM = 0.01
"""Share of its start below which a pressure or temperature is not physical, though rates may vanish there."""
TOLERANCE = 1e-9
"""Largest rate at rest, in nominal units: far below what a run at the default tolerance resolves."""


class TrimError(ValueError):
    """An operating point that cannot be found; the message names the states that do not come to rest."""


class OperatingPoint:
    """An operating point: a plant that has just been started, whose states and inputs are moved."""

    def __init__(self, model: ModelDescription, start: Start, at: Mapping[str, Value], inputs: Sequence[str]) -> None:
        variables = model.variables
        self.variables = variables
        self.rates = {v.derivative_of: v.name for v in variables.values() if v.derivative_of is not None}
        self.simulation, given = _start(model, start, at, self.rates)
        states = self.simulation.states
        # A state whose rate is given moves on, from where it starts: at a given velocity the position does.
        carried = {name for name in states if self.rates[name] in given}
        self.wanted = {name: float(at[key]) for name in states for key in (name, f"{name}0") if key in at}
        self.given = {name: self.simulation[name] for name in states if name in given | carried} | self.wanted
        self.held = self.given
        self.carriers = {name: self.rates[name] for name in carried if self.rates[name] in self.given}
        self.speeds = set(self.carriers.values())
        self.moving = [self.rates[name] for name in states if name not in carried]
        self.free_inputs = [name for name in inputs if name not in at]
        self.fixed_inputs = [name for name in inputs if name in at]
        self.free = [*(name for name in states if name not in self.given), *self.free_inputs]
        is_supplied = SUPPLY in variables
        self.chambers = [name for name in self.free if variables[name].unit == "Pa" and name in states and is_supplied]
        self.absolute = [name for name in states if variables[name].unit in ("Pa", "K") and self.simulation[name] > 0.0]
        self.floor = VACUUM * self.simulation.get(self.absolute)
        self.units = self._nominal(self.free)
        self.scale = self._nominal(self.moving)

    def _nominal(self, names: Sequence[str]) -> Array:
        return np.array([self.variables[name].nominal or 1.0 for name in names])

    def trim(self) -> None:
        """Find free states and inputs for which all rates vanish.

        The point of a slow motion lies in the gap just beyond the dead zone of the valve, which Newton's method misses
        easily. The point of a faster motion is found more easily, and leads there.
        """
        start = self.simulation.save()
        reason = self._search(start)
        if reason and not any(self._follow(start, times) for times in self._faster()):
            raise TrimError(f"no operating point was found: {reason}")

    def _search(self, start: SavedState) -> str:
        """Search the point under the held values; return why it was not found, or nothing.

        Around a dead zone Newton's method finds the way only from a valve that is open to the right side, so that it
        starts from several inputs, with the chambers as they are, then half filled.
        """
        best = np.full(len(self.moving), np.inf)
        lost = ""
        for filled, offset in product(FILLED if self.chambers else [0.0], OFFSETS if self.free_inputs else [0.0]):
            self._begin(start, offset, filled)
            residual = self._newton()
            if _is_rest(residual):
                lost = self._lost()
                if not lost:
                    return ""
            elif np.linalg.norm(residual) < np.linalg.norm(best):
                best = residual
        return lost or self._left(best)

    def _begin(self, start: SavedState, offset: float, filled: float) -> None:
        """Go to the start of Newton's method: inputs, chambers filled by a share of the supply, and consequences."""
        self.simulation.restore(start)
        inputs = self.simulation.get(self.free_inputs) + offset * self._nominal(self.free_inputs)
        self.simulation._put(self._named(self.free_inputs, inputs))
        if filled:
            pressures = self.simulation.get(self.chambers)
            pressures += filled * (self.simulation[SUPPLY] - pressures)
            self.simulation.move_states(self._named(self.chambers, pressures))
        self._settle()
        self._run_in()

    def _faster(self) -> list[float]:
        """Return factors of faster motions whose points lead to the point of the given motion."""
        speeds = [abs(self.given[name]) / (self.variables[name].nominal or 1.0) for name in self.speeds]
        largest = max(speeds, default=0.0)
        return [times for times in FASTER if 0.0 < times * largest <= FASTEST]

    def _follow(self, start: SavedState, times: float) -> bool:
        """Find the point of a motion faster by a factor, and follow it down to the given motion."""
        self._hold(times)
        found = not self._search(start)
        while found and times > 1.0:
            times = max(1.0, 0.5 * times)
            self._hold(times)
            self._run_in()
            found = _is_rest(self._newton())
        self._hold(1.0)
        return found and not self._lost()

    def _hold(self, times: float) -> None:
        """Hold the given values, with a motion faster by a factor."""
        self.held = {name: times * value if name in self.speeds else value for name, value in self.given.items()}

    def _left(self, residual: Array) -> str:
        """Name the states that do not come to rest."""
        if not np.isfinite(residual).all():
            return "pressures or temperatures would have to vanish"
        worst = int(np.argmax(np.abs(residual)))
        rate = self.moving[worst]
        if self.fixed_inputs and not self.speeds:
            name = self.fixed_inputs[0]
            value = f"{name} = {self.simulation[name]:g} {self.variables[name].unit}"
            free = {f"{state}": own for state, own in self.rates.items() if state in self.simulation.states}
            speed = next((own for own in free.values() if self.variables[own].unit == "m/s"), "velocity")
            return (
                f"with {value} nothing balances at rest: {rate} stays at {residual[worst] * self.scale[worst]:.3g} "
                f"{self.variables[rate].unit}. Give a motion in place of the input, for example {speed} = 0.05 m/s, "
                f"and the {name} that keeps it up is found; or leave {name} out"
            )
        return (
            f"{rate} stays at {residual[worst] * self.scale[worst]:.3g} {self.variables[rate].unit}. "
            "Within the play of valve.hysteresis and within a dead zone without leakage the valve does not react; "
            "a mass that sticks does not either"
        )

    def _lost(self) -> str:
        """Tell which given state has not stayed as it was given; nothing if all have."""
        for name in self.wanted:
            wanted, found = self.held[name], self.simulation[name]
            if abs(found - wanted) > TOLERANCE * abs(wanted):
                unit = self.variables[name].unit
                return f"{name} = {wanted:g} {unit} was given, but the plant comes to {name} = {found:g} {unit}"
        return ""

    def _settle(self) -> None:
        """Let everything follow the inputs while the given states are held."""
        for _ in range(SETTLING_STEPS):
            self.simulation.step(SETTLING_STEP)
            self.simulation.move_states(self.held)

    def _run_in(self) -> None:
        """Come to the place from behind at the given speed: held in place, friction would remember a rest.

        A slow motion begins faster, so that it comes far enough. What the gas does on the way does not count.
        """
        before = self.simulation.save()
        gas = self._named(self.absolute, self.simulation.get(self.absolute))
        try:
            for place, rate in self.carriers.items():
                if self.held[rate] != 0.0:
                    self._come(place, rate, self.held[rate])
        except SimulationError:
            # There is no room behind, so close to a cover.
            self.simulation.restore(before)
        self.simulation.move_states(self.held | gas)

    def _come(self, place: str, rate: str, speed: float) -> None:
        """Come to the given place, at a speed in the end."""
        end = self.held[place]
        fast = math.copysign(max(abs(speed), RUN_IN_SPEED), speed)
        slow = end - RUN_IN_TIME * speed
        self.simulation.move_states({place: slow - math.copysign(RUN_IN, speed)})
        self._travel(place, slow, rate, fast)
        self._travel(place, end, rate, speed)

    def _travel(self, place: str, end: float, rate: str, speed: float) -> None:
        """Go to a position at a speed; the other free values follow."""
        for _ in range(2 * SETTLING_STEPS):
            self.simulation.move_states({rate: speed})
            left = (end - self.simulation[place]) / speed
            if left < 1e-9 * SETTLING_STEP:
                break
            self.simulation.step(min(left, SETTLING_STEP))
        self.simulation.move_states({rate: speed})

    def _newton(self) -> Array:
        """Take Newton's steps in nominal units; return the rates that are left."""
        residual = self._residual()
        for _ in range(NEWTON_STEPS):
            if _is_rest(residual):
                break
            jacobian = self.simulation.jacobian(self.moving, self.free) * self.units / self.scale[:, None]
            if not (np.isfinite(jacobian).all() and np.isfinite(residual).all()):
                break
            # The shortest step, where some directions change nothing.
            move = np.linalg.lstsq(jacobian, -residual, rcond=1e-12)[0] * self.units
            residual = self._walk(move, float(np.linalg.norm(residual)))
        return residual

    def _residual(self) -> Array:
        """Return the rates in nominal units; without end where a pressure or temperature all but vanishes."""
        if np.any(self.simulation.get(self.absolute) <= self.floor):
            return np.full(len(self.moving), np.inf)
        return self.simulation.get(self.moving) / self.scale

    def _walk(self, move: Array, before: float) -> Array:
        """Go along a direction, half as far until that is better; return the rates there."""
        origin = self.simulation.get(self.free)
        share = 1.0
        while True:
            self._go(origin + share * move)
            residual = self._residual()
            if np.linalg.norm(residual) < before:
                return residual
            if share < 1e-3:
                self._go(origin)
                return self._residual()
            share /= 2.0

    def _go(self, values: Array) -> None:
        number = len(self.free) - len(self.free_inputs)
        self.simulation.move_states(self._named(self.free[:number], values[:number]))
        self.simulation._put(self._named(self.free_inputs, values[number:]))

    @staticmethod
    def _named(names: Sequence[str], values: Array) -> dict[str, float]:
        return dict(zip(names, values.tolist(), strict=True))


def _is_rest(residual: Array) -> bool:
    return bool(np.max(np.abs(residual), initial=0.0) < TOLERANCE)


def _start(
    model: ModelDescription, start: Start, at: Mapping[str, Value], rates: Mapping[str, str]
) -> tuple[Simulation, set[str]]:
    """Start a plant at given parameters, inputs and states; also return which states are given."""
    settings: dict[str, Value] = {}
    moved: dict[str, float] = {}
    given: set[str] = set()
    for name, value in at.items():
        if name not in rates:
            settings[name] = value
            continue
        given.add(name)
        initial = f"{name}0"
        # Through the parameter the law starts in the mode that belongs to the state, sliding or sticking.
        if initial in model.parameters:
            settings[initial] = value
        else:
            moved[name] = float(value)
    for name in given:
        if f"{name}0" in at:
            raise ValueError(f"{name} is given twice, as itself and as {name}0")
    simulation = start(settings)
    simulation.move_states(moved)
    # The initial position and velocity, given as parameters, stay as they are too.
    started = {name.removesuffix("0") for name in at if name.endswith("0")} & set(simulation.states)
    return simulation, given | started
