"""A seal or a tribometer: the motion is prescribed, the force is measured."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from pneumatic_servo.argument_names import quoted
from pneumatic_servo.identification.experiments.base import Experiment, Values, Window
from pneumatic_servo.identification.records import Record
from pneumatic_servo.identification.smoothing import follow, noise
from pneumatic_servo.model import Model
from pneumatic_servo.variables import Value

Array = NDArray[np.float64]

PACED = 5
"""Steps whose mean velocity a motion keeps beyond the ends of its record."""


class Motion(Experiment):
    """FrictionBench under a prescribed position; `force = pressure * area + friction` where a seal is under pressure.

    The load level is `normalForce / rated`, grows with the pressure by `friction.kappaA`, and is
    `friction.direction.factor` times as large outwards as inwards.
    """

    name = "motion"
    required = ("time",)

    def make_model(self) -> Model:
        """Return the bench."""
        return Model("FrictionBench")

    def use(self, signals: object) -> None:
        """Take the measured signals; refuse too few."""
        super().use(signals)  # type: ignore[arg-type]
        if not self.signals & {"position", "velocity"}:
            raise ValueError(f"{quoted('experiment', 'motion')} needs a column for position or velocity")
        if not self.signals & {"frictionForce", "force"}:
            raise ValueError(f"{quoted('experiment', 'motion')} needs a column for frictionForce, or for force")

    @property
    def compared(self) -> tuple[str, ...]:
        """The force that is measured."""
        return ("frictionForce",) if "frictionForce" in self.signals else ("force",)

    @property
    def driving(self) -> tuple[str, ...]:
        """The motion and the load."""
        return (self.moving, *(signal for signal in ("pressure", "normalForce") if signal in self.signals))

    @property
    def moving(self) -> str:
        """Signal of the motion."""
        return "position" if "position" in self.signals else "velocity"

    @property
    def beside(self) -> Mapping[str, str]:
        """Parameters of sensors; the zero of a position has no effect here."""
        return {name: unit for name, unit in super().beside.items() if name != "offset.position"}

    @property
    def unknown(self) -> tuple[str, ...]:
        """The area that the pressure pushes on, where the force has both."""
        return ("area",) if self.compared == ("force",) and "pressure" in self.signals else ()

    @property
    def outputs(self) -> list[str]:
        """The friction force."""
        return ["frictionForce"]

    def prepare(self, record: Record) -> tuple[Mapping[str, Array], NDArray[np.bool_]]:
        """Hide the jitter of the position, and leave out samples at rest: friction at rest answers the drive."""
        if "position" in record.signals:
            measured = record.on_grid("position") - record.signals["position"][0]
            play = 3.0 * noise(record.signals["position"]) if self.options.play is None else self.options.play
            self.notes.append(f"{record.name}: the position is followed with a play of {1e6 * play:.3g} um")
            position = follow(measured, play)
        else:
            speed = record.on_grid("velocity")
            position = np.concatenate([[0.0], np.cumsum(0.5 * record.step * (speed[1:] + speed[:-1]))])
        driven = {"position": position}
        for signal in ("pressure", "normalForce"):
            if signal in record.signals:
                driven[signal] = record.on_grid(signal)
        moves = np.concatenate([[False], np.diff(position) != 0.0])
        at = np.clip(np.ceil(record.time / record.step - 1e-6).astype(int), 0, len(moves) - 1)
        return driven, moves[at]

    def level(self, window: Window, values: Values) -> Array:
        """Return the load level at the communication points."""
        level = np.ones_like(window.driven["position"])
        if "normalForce" in window.driven:
            level = self.given(window, "normalForce", values) / self.options.rated
        if "pressure" in window.driven:
            kappa = values.get("friction.kappaA", float(self.settings.get("friction.kappaA", 0.0)))
            level = level * (1.0 + kappa * self.given(window, "pressure", values))
        factor = self.beside_value("friction.direction.factor", values, 1.0)
        if factor != 1.0:
            level = np.where(_outwards(self.path(window, values)), factor * level, level)
        return np.maximum(level, 0.0)

    def path(self, window: Window, values: Values) -> Array:
        """Return the way from where a window begins, at the communication points.

        What a reading that is late has not yet told at the end of a record is taken to go on as fast as before.
        """
        seen = self.reading(window, "position", self.moving, values)
        whole = window.around
        late = whole.begin + window.record.grid + self.beside_value(f"delay.{self.moving}", values, 0.0)
        for end, way in ((0, np.minimum(late - whole.grid[0], 0.0)), (-1, np.maximum(late - whole.grid[-1], 0.0))):
            if np.any(way != 0.0):
                seen = seen + way * _pace(whole.driven["position"], window.record.step, end)
        way = seen - seen[0]
        if self.moving == "velocity":
            way = way - self.beside_value("offset.velocity", values, 0.0) * window.record.grid
        return np.asarray(self.beside_value(f"gain.{self.moving}", values, 1.0) * way)

    def inputs(self, window: Window, values: Values) -> dict[str, Array]:
        """Return the position at the end of each step, and the load level."""
        position = self.path(window, values)
        return {
            "prescribedPosition": np.append(position[1:], position[-1]),
            "friction.level": self.level(window, values),
        }

    def start(self, window: Window, values: Values) -> dict[str, Value]:
        """Start at rest at the first sample."""
        return {
            **self.of_model(values), "friction.law": self.law, "bench.drive": "PrescribedPosition",
            "driveVelocity": 0.0, "position0": 0.0,
        }  # fmt: skip

    def predict(self, window: Window, outputs: Mapping[str, Array], values: Values) -> dict[str, Array]:
        """Add the force of the pressure."""
        friction = outputs["frictionForce"]
        if self.compared == ("frictionForce",):
            return {"frictionForce": friction}
        area = values.get("area", float(self.settings.get("area", 0.0)))
        pressure = self.given(window, "pressure", values) if "pressure" in window.driven else 0.0
        return {"force": friction + area * pressure}

    def forces(self, window: Window, values: Values) -> tuple[Array, Array, Array] | None:
        """Return velocity, friction and load level at the samples that are compared."""
        record = window.record
        position = self.path(window, values)
        speed = np.interp(record.time, record.grid, np.gradient(position, record.step))
        level = np.interp(record.time, record.grid, self.level(window, values))
        force = record.signals[self.compared[0]] - values.get(f"offset.{self.compared[0]}", 0.0)
        if self.compared == ("force",) and "pressure" in record.signals:
            pressure = self.true("pressure", record.signals["pressure"], values)
            force = force - values.get("area", float(self.settings.get("area", 0.0))) * pressure
        use = window.used & ~window.held
        return speed[use], force[use], level[use]


def _outwards(path: Array) -> NDArray[np.bool_]:
    """Return whether each step of a path leads outwards, or the last motion before it did."""
    steps = np.append(np.diff(path), 0.0)
    moving = np.maximum.accumulate(np.where(steps != 0.0, np.arange(len(steps)), -1))
    return np.asarray((moving >= 0) & (steps[moving] > 0.0))


def _pace(path: Array, step: float, end: int) -> float:
    """Return the mean velocity over some steps at the beginning of a path, or at its end."""
    number = min(PACED, len(path) - 1)
    way = path[number] - path[0] if end == 0 else path[-1] - path[-1 - number]
    return float(way) / (number * step)
