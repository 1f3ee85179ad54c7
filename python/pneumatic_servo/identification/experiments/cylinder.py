"""The common part of the experiments with the whole cylinder."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping

import numpy as np
from numpy.typing import NDArray

from pneumatic_servo.identification.experiments import position
from pneumatic_servo.identification.experiments.base import Beginning, Experiment, Values, Window
from pneumatic_servo.identification.records import Record
from pneumatic_servo.identification.smoothing import slope
from pneumatic_servo.model import Model

Array = NDArray[np.float64]

GRAVITY = 9.80665


class OfCylinder(Experiment):
    """An experiment with the parameters of PneumaticServoCylinder."""

    def make_table(self) -> Model:
        """Return the cylinder."""
        return Model("PneumaticServoCylinder")

    def make_model(self) -> Model:
        """Return the same: unless it takes less, the cylinder is simulated."""
        return self.make_table()

    def pressure_force(self, window: Window, values: Values) -> Array:
        """Return the force of both chambers and of the atmosphere on the rod at the communication points."""
        bore, rod = (0.25 * math.pi * self.value(f"cylinder.{name}", values) ** 2 for name in ("bore", "rod"))
        ambient = self.value("ambientPressure", values)
        signals = [f"chamber{chamber}.pressure" for chamber in "AB"]
        a, b = (self.given(window, signal, values) for signal in signals)
        return a * bore - b * (bore - rod) - ambient * rod

    def dead_load(self, values: Values) -> float:
        """Return the force towards -x that wire and weight exert."""
        weight = self.value("mass.moving", values) * GRAVITY * math.sin(self.value("incline", values))
        return self.value("wireForce", values) + weight

    def applied(self, window: Window, values: Values) -> Array:
        """Return the force on the carriage but for its friction, at the communication points."""
        applied = self.pressure_force(window, values) - self.dead_load(values)
        if "externalForce" in window.driven:
            applied = applied + self.given(window, "externalForce", values)
        return applied

    def measured_inputs(self, window: Window, signals: Iterable[str], values: Values) -> dict[str, Array]:
        """Return the inputs of the rig; over a step on a straight line their mean."""
        given = {s: self.given(window, s, values) for s in signals if s in window.driven}
        if self.options.inputs == "held":
            return given
        return {signal: middle(course) for signal, course in given.items()}

    def grids(self, record: Record) -> dict[str, Array]:
        """Return all signals at the communication points."""
        return {signal: record.on_grid(signal) for signal in record.signals}

    def begin_motion(self, record: Record) -> Beginning:
        """Begin with the smoothed position and its slope; at rest the slope is exactly 0."""
        return position.begin(record, self.options.width)

    def resting(self, record: Record) -> NDArray[np.bool_]:
        """Tell where the position stays within its noise."""
        if "position" not in record.signals:
            return super().resting(record)
        return position.resting(record, self.options.width)

    def forces(self, window: Window, values: Values) -> tuple[Array, Array, Array] | None:
        """Return velocity, pressure force minus inertial force, and the load level, while moving."""
        needed = {"position", "chamberA.pressure", "chamberB.pressure"}
        if not needed <= set(window.record.signals):
            return None
        record = window.record
        width = 2.0 * self.options.width
        speed = self.pace * position.velocity(record, width)
        acceleration = slope(speed, record.step, width)
        friction = self.applied(window, values) - self.value("mass.moving", values) * acceleration
        return speed, friction, self.level(window, values)

    def level(self, window: Window, values: Values) -> Array:
        """Return the load level: it grows with the pressures above ambient."""
        ambient = self.value("ambientPressure", values)
        level = np.ones(len(window.record.grid))
        for chamber in "AB":
            kappa = self.value(f"friction.kappa{chamber}", values)
            signal = f"chamber{chamber}.pressure"
            level = level + kappa * (self.given(window, signal, values) - ambient)
        return np.maximum(level, 0.0)


def middle(values: Array) -> Array:
    """Return a signal in the middle of the step that begins at each point."""
    return np.append(0.5 * (values[1:] + values[:-1]), values[-1])


def first(values: Mapping[str, Array], signal: str, number: int) -> float:
    """Return the start value of a signal, from its first samples."""
    return float(np.mean(values[signal][:number]))
