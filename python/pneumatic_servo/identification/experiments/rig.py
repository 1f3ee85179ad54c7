"""The whole rig: the voltage is given, position and pressures are compared."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from pneumatic_servo.identification.experiments import position
from pneumatic_servo.identification.experiments.base import Values, Window
from pneumatic_servo.identification.experiments.cylinder import OfCylinder, first
from pneumatic_servo.identification.records import Record
from pneumatic_servo.variables import Value

Array = NDArray[np.float64]

COMPARED = ("position", "velocity", "chamberA.pressure", "chamberB.pressure")
GIVEN = ("valveVoltage", "supplyPressure", "externalForce")


class Rig(OfCylinder):
    """PneumaticServoCylinder, open loop from the beginning of each window."""

    name = "rig"
    required = ("time", "valveVoltage", "position")

    @property
    def compared(self) -> tuple[str, ...]:
        """What is measured of the motion and the gas."""
        return tuple(signal for signal in COMPARED if signal in self.signals)

    def prepare(self, record: Record) -> tuple[Mapping[str, Array], NDArray[np.bool_]]:
        """Start from the smoothed position and its slope."""
        width = self.options.width
        driven = self.grids(record)
        speed = position.start_velocity(record, width)
        rests = speed == 0.0
        place = first(driven, "position", 5) if rests else float(position.smoothed(record, width)[0])
        driven["start"] = np.array([place, speed])
        return driven, np.ones(len(record.time), dtype=bool)

    def inputs(self, window: Window, values: Values) -> dict[str, Array]:
        """Return what is given."""
        return {signal: window.driven[signal] for signal in GIVEN if signal in window.driven}

    def start(self, window: Window, values: Values) -> dict[str, Value]:
        """Start from what is measured, unless it is known or fitted."""
        place, speed = window.driven["start"]
        begin: dict[str, Value] = {"position0": float(place), "velocity0": float(speed)}
        for chamber in ("chamberA", "chamberB"):
            if f"{chamber}.pressure" in window.driven:
                begin[f"{chamber}.pressure0"] = first(window.driven, f"{chamber}.pressure", 5)
        return {**begin, **self.of_model(values), "friction.law": self.law}
