"""The whole rig: the voltage is given, position and pressures are compared."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from pneumatic_servo.identification.experiments.base import Beginning, Values, Window
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
        """Measured signals of the motion and the gas."""
        return tuple(signal for signal in COMPARED if signal in self.signals)

    @property
    def driving(self) -> tuple[str, ...]:
        """Given and measured signals."""
        return tuple(signal for signal in GIVEN if signal in self.signals)

    def prepare(self, record: Record) -> tuple[Mapping[str, Array], NDArray[np.bool_]]:
        """Compare all samples."""
        return self.grids(record), np.ones(len(record.time), dtype=bool)

    def begin(self, record: Record, driven: Mapping[str, Array]) -> Beginning:
        """Begin with the smoothed position and its slope, and with the pressures."""
        return self.begin_motion(record).with_more({
            f"{chamber}.pressure0": first(driven, f"{chamber}.pressure", 5)
            for chamber in ("chamberA", "chamberB") if f"{chamber}.pressure" in driven
        })  # fmt: skip

    def inputs(self, window: Window, values: Values) -> dict[str, Array]:
        """Return the given signals."""
        return self.measured_inputs(window, GIVEN, values)

    def start(self, window: Window, values: Values) -> dict[str, Value]:
        """Return the fixed and fitted values."""
        return {**self.of_model(values), "friction.law": self.law}
