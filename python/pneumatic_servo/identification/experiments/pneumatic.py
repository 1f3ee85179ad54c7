"""The gas half alone: motion and voltage are given, the pressures are compared."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from pneumatic_servo.identification.experiments import position
from pneumatic_servo.identification.experiments.base import Beginning, Values, Window
from pneumatic_servo.identification.experiments.cylinder import OfCylinder, first, middle
from pneumatic_servo.identification.records import Record
from pneumatic_servo.variables import Value

Array = NDArray[np.float64]

MASS = 1e4
"""Mass in kg of a carriage that the pressures cannot push off the measured path.

A force that accelerates it as measured carries it along; an error of the simulated pressures by 1 N moves it by 50 um
in a second, which no chamber notices.
"""


class Pneumatic(OfCylinder):
    """PneumaticServoCylinder without friction, with a carriage that goes where it was measured."""

    name = "pneumatic"
    required = ("time", "position", "valveVoltage", "chamberA.pressure", "chamberB.pressure")

    @property
    def compared(self) -> tuple[str, ...]:
        """Both pressures."""
        return ("chamberA.pressure", "chamberB.pressure")

    @property
    def driving(self) -> tuple[str, ...]:
        """Given and measured signals."""
        return tuple(signal for signal in ("position", "valveVoltage", "supplyPressure") if signal in self.signals)

    def prepare(self, record: Record) -> tuple[Mapping[str, Array], NDArray[np.bool_]]:
        """Smooth the position; its slopes move the carriage."""
        width = self.options.width
        driven = self.grids(record)
        path = position.smoothed(record, width)
        # Velocities at the points that lead from one position to the next: those at their middle, averaged.
        between = np.diff(path) / record.step
        speed = np.concatenate([between[:1], 0.5 * (between[1:] + between[:-1]), between[-1:]])
        driven["path"], driven["speed"] = path, speed
        driven["acceleration"] = np.append(np.diff(speed) / record.step, 0.0)
        self.notes.append(f"{record.name}: the position is smoothed over {1e3 * width:.3g} ms")
        return driven, np.ones(len(record.time), dtype=bool)

    def begin(self, record: Record, driven: Mapping[str, Array]) -> Beginning:
        """Begin with the measured pressures."""
        return Beginning().with_more({
            f"{chamber}.pressure0": first(driven, f"{chamber}.pressure", 5) for chamber in ("chamberA", "chamberB")
        })  # fmt: skip

    def inputs(self, window: Window, values: Values) -> dict[str, Array]:
        """Return voltage and supply, and the force that carries the carriage against the measured pressures."""
        inputs = self.measured_inputs(window, ("valveVoltage", "supplyPressure"), values)
        acceleration = self._slope(window, "acceleration", values)
        carrying = MASS * acceleration - middle(self.pressure_force(window, values))
        inputs["externalForce"] = carrying + self.value("wireForce", values)
        return inputs

    def start(self, window: Window, values: Values) -> dict[str, Value]:
        """Return the fixed and fitted values, with a start on the path."""
        path = self.true("position", self.reading(window, "path", "position", values), values)
        begin = {"position0": float(path[0]), "velocity0": float(self._slope(window, "speed", values)[0])}
        return {**begin, **self.of_model(values), "mass.moving": MASS, "friction.law": "None", "incline": 0.0}

    def _slope(self, window: Window, name: str, values: Values) -> Array:
        """Return speed or acceleration of the true motion at the communication points."""
        return self.beside_value("gain.position", values, 1.0) * self.reading(window, name, "position", values)

    def forces(self, window: Window, values: Values) -> None:
        """Nothing of friction is asked here."""
        return
