"""A carriage with measured pressures: the mechanical half alone, without valve and gas."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from pneumatic_servo.identification.experiments.base import Beginning, Options, Values, Window
from pneumatic_servo.identification.experiments.cylinder import OfCylinder, middle
from pneumatic_servo.identification.experiments.pushed import Pushed
from pneumatic_servo.identification.records import Record
from pneumatic_servo.identification.signals import SLIDING, Units
from pneumatic_servo.identification.smoothing import smooth
from pneumatic_servo.model import Model
from pneumatic_servo.variables import Value

Array = NDArray[np.float64]

WINDOW = 0.15
"""Length in s of the windows, unless another is given.

The noise of the pressures adds up in the position, to a tenth of a millimetre in half a second at 0.5 kPa. Short
windows forget it, and are so many that their differences tell how far it moves the parameters.
"""


class Mechanical(OfCylinder, Pushed):
    """A free mass on FrictionBench, pushed by the measured pressures; its position is compared."""

    name = "mechanical"
    required = ("time", "position", "chamberA.pressure", "chamberB.pressure")

    def __init__(self, law: str, settings: Mapping[str, Value], options: Options, units: Units = SLIDING) -> None:
        window = WINDOW if options.window is None else options.window
        super().__init__(law, settings, replace(options, window=window, is_cut=options.window is not None), units)

    def make_model(self) -> Model:
        """Return the bench."""
        return Model("FrictionBench")

    @property
    def compared(self) -> tuple[str, ...]:
        """The position."""
        return ("position",)

    @property
    def driving(self) -> tuple[str, ...]:
        """Measured forces on the carriage."""
        more = ("externalForce",) if "externalForce" in self.signals else ()
        return ("chamberA.pressure", "chamberB.pressure", *more)

    @property
    def outputs(self) -> list[str]:
        """The position."""
        return ["position"]

    def prepare(self, record: Record) -> tuple[Mapping[str, Array], NDArray[np.bool_]]:
        """Smooth the pressures, whose noise would break the carriage away before its time; compare all samples."""
        driven, width = self.grids(record), self.options.width
        driven["direction"] = self.direction(record)
        if self.options.smooths:
            for chamber in ("chamberA.pressure", "chamberB.pressure"):
                driven[chamber] = smooth(driven[chamber], record.step, width)
            self.notes.append(f"{record.name}: the pressures are smoothed over {1e3 * width:.3g} ms")
        return driven, np.ones(len(record.time), dtype=bool)

    def begin(self, record: Record, driven: Mapping[str, Array]) -> Beginning:
        """Begin with the smoothed position and its slope."""
        return self.begin_motion(record)

    def level(self, window: Window, values: Values) -> Array:
        """Return the load level: it grows with the pressures, and may differ by direction."""
        return self.directed(super().level(window, values), window, values)

    def inertia(self, values: Values) -> float:
        """Return the mass of the carriage."""
        return self.value("mass.moving", values)

    def inputs(self, window: Window, values: Values) -> dict[str, Array]:
        """Return the force on the carriage and the load level."""
        return {"appliedForce": middle(self.applied(window, values)), "friction.level": self.level(window, values)}

    def start(self, window: Window, values: Values) -> dict[str, Value]:
        """Return the fixed and fitted values."""
        return {
            **self.of_model(values), "friction.law": self.law, "bench.drive": "Free", "driveVelocity": 0.0,
            "mass": self.value("mass.moving", values),
        }  # fmt: skip
