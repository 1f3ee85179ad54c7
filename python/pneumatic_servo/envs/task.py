"""The positioning task: targets, observations, rewards, and the variation between episodes."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, fields, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pneumatic_servo import effects, plant_warnings
from pneumatic_servo.checks import mapping, names, whole_number
from pneumatic_servo.envs.arm import Arm
from pneumatic_servo.errors import Refused
from pneumatic_servo.model import Model
from pneumatic_servo.names import did_you_mean
from pneumatic_servo.units import has_unit
from pneumatic_servo.values import checked, number_in, seconds, settings, value_of
from pneumatic_servo.variables import Value

Array = NDArray[np.float64]
OBSERVED = ["position", "velocity", "chamberA.pressure", "chamberB.pressure"]
"""Variables of the plant behind an observation."""
MASS = "mass.moving"
SIGNALS = 5
"""Length of an observation: error, position, velocity and both pressures."""

HOLDING = {"chamberA.pressure0": 4e5, "chamberB.pressure0": 3e5}
"""Pressures in Pa with which an episode with an arm begins: nearly its weight."""

RANDOM: Mapping[str, tuple[float, float]] = {
    "mass.moving": (0.8, 1.6),
    "valve.deadZone": (0.04, 0.12),
    "supplyPressure": (4.5e5, 7e5),
    "valve.C": (3e-9, 5e-9),
}
"""Ranges of parameters that are drawn for each episode if nothing else is asked for, in SI units."""


LONGEST_PERIOD = 1.0
"""In s; the carriage crosses its stroke in less."""


@dataclass(frozen=True)
class Task:
    """Move the carriage to a target and keep it there.

    Attributes
    ----------
    law : str, optional
        Friction law; by default Stribeck, or drawn from `laws`.
    laws : sequence of str, optional
        Friction laws to draw from for each episode.
    ranges : mapping
        Parameters to draw uniformly for each episode: name, and smallest and largest value, in SI units or with their
        own, as in ``("5 bar", "7 bar")``.
    parameters : mapping
        Parameters and start values that stay.
    targets : pair of float
        Range of targets in m, or with a unit.
    period : float
        Time between actions in s, or with a unit.
    substeps : int
        Communication steps of the plant between actions.
    duration : float
        Length of an episode in s, or with a unit; it is truncated then.
    effort : float
        Weight of the voltage's square in the reward.
    arm : Arm, optional
        Lever arm that the carriage moves; ``mass.moving`` is then without it.

    Examples
    --------
    >>> import pneumatic_servo.envs as envs
    >>> task = envs.Task(laws=["Stribeck", "LuGre"], targets=("100 mm", "400 mm"), duration="2 s", period="10 ms")
    >>> envs.Positioning(laws=task.laws, targets=task.targets).reset(seed=1)[0].shape
    (5,)
    """

    law: str | None = None
    laws: Sequence[str] | None = None
    ranges: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    parameters: Mapping[str, Value] = field(default_factory=dict)
    targets: tuple[float, float] = (0.1, 0.4)
    period: float = 1e-3
    substeps: int = 1
    duration: float = 1.5
    effort: float = 1e-3
    arm: Arm | None = None

    @staticmethod
    def of(given: Mapping[str, Any]) -> Task:
        """Return the task of some options; another one is refused by its name."""
        known = [one.name for one in fields(Task)]
        other = next((name for name in given if name not in known), None)
        if other is not None:
            hint = did_you_mean(other, known)
            raise TypeError(f"the environment has no option {other}{hint}; there are {', '.join(known)}")
        for name in ("ranges", "parameters"):
            mapping(name, given.get(name))
        return Task(**given)

    def in_si(self, model: Model) -> Task:
        """Return the same with numbers in SI units, from values that may have units."""
        ranges = {}
        for name, ends in self.ranges.items():
            low, high = _pair(f"ranges: {name}", ends)
            ranges[name] = (_number(model, name, low), _number(model, name, high))
        low, high = (number_in("m", "targets", end) for end in _pair("targets", self.targets))
        if self.laws is not None and not names("laws", self.laws):
            raise ValueError("laws is empty: name at least one friction law, or leave it out")
        if self.laws is not None and len({*self.laws}) < len(self.laws):
            repeated = next(law for law in self.laws if [*self.laws].count(law) > 1)
            raise ValueError(f"laws has {repeated} twice")
        given = {"laws": self.laws, "law": self.law, "friction.law": self.parameters.get("friction.law")}
        twice = [name for name, value in given.items() if value is not None]
        if len(twice) > 1:
            raise ValueError(f"the friction law is given twice, by {' and by '.join(twice)}")
        default = str(model.parameters["friction.law"].default)
        law: Any = self.laws[0] if self.laws else self.law or self.parameters.get("friction.law", default)
        if self.arm is not None and not isinstance(self.arm, Arm):
            raise TypeError(f"arm = {self.arm!r} is refused: it must be an envs.Arm, or None")
        return replace(
            self, law=law, laws=self.laws or (), ranges=ranges, targets=(low, high),
            arm=None if self.arm is None else self.arm.in_si(self.stroke(model)),
            period=seconds("period", self.period),
            duration=seconds("duration", self.duration),
        )  # fmt: skip

    def check(self, model: Model) -> None:
        """Refuse impossible values, before anything is drawn."""
        for law in (self.law, *(self.laws or ())):
            checked(model.parameters["friction.law"], law)
        for name in ("position0", "valveVoltage"):
            if name in self.parameters or name in self.ranges:
                why = "each episode draws where it begins" if name == "position0" else "actions are the voltage"
                raise ValueError(f"{name} is refused: {why}")
        stroke = self.stroke(model)
        whole_number("substeps", self.substeps, least=1)
        low, high = self.targets
        if not 0.0 <= low < high:
            raise ValueError(f"targets = {self.targets} is refused: it must be an increasing pair of positions in m")
        if high > stroke:
            raise ValueError(f"targets = {self.targets} is refused: the stroke ends at {stroke:g} m")
        for name, value in [("period", self.period), ("duration", self.duration)]:
            if not value > 0:
                raise ValueError(f"{name} = {value} is refused: it must be positive")
        if self.period >= LONGEST_PERIOD:
            raise ValueError(
                f"period = {self.period:g} s is refused: an action that is held for so long drives the carriage from "
                f"cover to cover; milliseconds are '{self.period:g} ms'"
            )
        if self.duration < self.period:
            raise ValueError(
                f"duration = {self.duration:g} s is refused: it is less than a period of {self.period:g} s"
            )
        if not 0.0 <= self.effort < math.inf:
            raise ValueError(
                f"effort = {self.effort} is refused: it must not be negative, or actions would be rewarded"
            )
        if self.arm is not None and "externalForce" in {*self.parameters, *self.ranges}:
            raise ValueError("externalForce is refused: the arm is that force")
        if "cylinder.stroke" in self.ranges:
            raise ValueError("ranges: cylinder.stroke is refused: observations are in units of the one stroke")
        for name, (smallest, largest) in self.ranges.items():
            if not smallest <= largest:
                raise ValueError(f"ranges: {name} is refused: {smallest} is larger than {largest}")
            if name in self.parameters:
                raise ValueError(f"{name} is given twice, among the ranges and among the parameters")

    def tell(self, model: Model) -> None:
        """Warn of accepted values that are hardly meant, as a single run does."""
        stays = self.settings(model)
        ends = [{**stays, **{name: pair[end] for name, pair in self.ranges.items()}} for end in (0, 1)]
        runs = [{**own, "friction.law": law} for own in ends for law in self.laws or (str(stays["friction.law"]),)]
        effects.tell_runs(model, runs, [*self.parameters, *self.ranges])
        plant_warnings.warn_size(model.variables, ends)
        for own in ends if self.ranges else ends[:1]:
            # Both ends together may be refused where no episode is, which is for the plants to say.
            with suppress(Refused):
                effects.tell_notices(model, model._native.start(list(own.items()), 0.0).notices(), own)
            model._tell_saturated(own)

    @property
    def steps(self) -> int:
        """Actions in an episode."""
        return round(self.duration / self.period)

    def stroke(self, model: Model) -> float:
        """Return the stroke in m."""
        given = self.parameters.get("cylinder.stroke", model.parameters["cylinder.stroke"].default)
        return float(value_of(model.variables, "cylinder.stroke", given))

    def settings(self, model: Model) -> dict[str, Value]:
        """Return the parameters that all plants share."""
        loaded = {} if self.arm is None else {MASS: float(model.parameters[MASS].default or 0.0), **HOLDING}
        return {
            **loaded,
            "friction.law": self.law or "Stribeck",
            "supplyPressure": 6e5,
            # Each episode begins where it draws; this is only within the stroke.
            "position0": self.targets[0],
            **settings("parameters", model.variables, self.parameters),
        }

    def draw(self, random: np.random.Generator) -> tuple[float, list[tuple[str, Value]]]:
        """Draw an episode: its target in m, and the settings of its plant."""
        low, high = self.targets
        target, start = random.uniform(low, high, size=2)
        settings: list[tuple[str, Value]] = [("position0", float(start))]
        if self.laws:
            settings.append(("friction.law", self.laws[int(random.integers(len(self.laws)))]))
        settings += [(name, float(random.uniform(*ends))) for name, ends in self.ranges.items()]
        return float(target), settings


def _number(model: Model, name: str, given: Any) -> float:
    return float(value_of(model.variables, name, given))


def _pair(argument: str, given: Any) -> tuple[Any, Any]:
    """Return the two ends of a range; one unit may stand behind both, as in ``([5, 7], "bar")``."""
    is_shared = isinstance(given, tuple) and has_unit(given) and not isinstance(given[0], str)
    if is_shared and not any(has_unit(end) for end in given):
        values, unit = given
        ends = [(value, unit) for value in values] if np.ndim(values) == 1 else []
    else:
        ends = list(given) if isinstance(given, (tuple, list, np.ndarray)) or np.shape(given) else []
    if len(ends) != 2:
        raise ValueError(f"{argument} = {given!r} is refused: it must be a pair, the least and the largest")
    return ends[0], ends[1]


def observations(stroke: float, seen: Array, targets: Array) -> NDArray[np.float32]:
    """Scale measurements of plants with a stroke in m, of shape (plants, 4 or 5), to observations of shape (plants, 5).

    Error and position in units of the stroke, velocity in m/s, pressures in 10 bar: within -1 and 1 while nothing
    unusual happens.
    """
    scaled = np.empty((len(seen), SIGNALS), dtype=np.float32)
    scaled[:, 0] = (targets - seen[:, 0]) / stroke
    scaled[:, 1] = seen[:, 0] / stroke
    scaled[:, 2] = seen[:, 1]
    scaled[:, 3:] = seen[:, 2:4] * 1e-6
    return scaled


def voltages(actions: Array) -> Array:
    """Turn actions from -1 to 1 into voltages from 0 to 10 V, limited to this range."""
    return np.ascontiguousarray(5.0 + 5.0 * np.clip(actions, -1.0, 1.0), dtype=np.float64)


def rewards(task: Task, seen: Array, targets: Array, actions: Array) -> Array:
    """Return ``-|error| / 0.1 m - effort * action^2`` for each plant."""
    error = np.abs(targets - seen[:, 0])
    reward: Array = -10.0 * error - task.effort * np.clip(actions, -1.0, 1.0) ** 2
    return reward
