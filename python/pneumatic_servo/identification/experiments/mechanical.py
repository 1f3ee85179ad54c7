"""A carriage with measured pressures: the mechanical half alone, whatever valve and gas do."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from pneumatic_servo.identification.experiments import position
from pneumatic_servo.identification.experiments.base import Options, Values, Window
from pneumatic_servo.identification.experiments.cylinder import OfCylinder, middle
from pneumatic_servo.identification.records import Record
from pneumatic_servo.model import Model
from pneumatic_servo.variables import Value

Array = NDArray[np.float64]

WINDOW = 0.5
"""Length in s of the windows, unless another is given: the noise of the pressures adds up in the position."""


class Mechanical(OfCylinder):
    """A free mass on FrictionBench, pushed by the measured pressures; its position is compared."""

    name = "mechanical"
    required = ("time", "position", "chamberA.pressure", "chamberB.pressure")

    def __init__(self, law: str, settings: Mapping[str, Value], options: Options) -> None:
        super().__init__(law, settings, replace(options, window=WINDOW if options.window is None else options.window))

    def make_model(self) -> Model:
        """Return the bench."""
        return Model("FrictionBench")

    @property
    def compared(self) -> tuple[str, ...]:
        """The position."""
        return ("position",)

    @property
    def outputs(self) -> list[str]:
        """The position."""
        return ["position"]

    def prepare(self, record: Record) -> tuple[Mapping[str, Array], NDArray[np.bool_]]:
        """Start from the smoothed position and its slope."""
        driven = self.grids(record)
        driven["start"] = np.array([
            position.smoothed(record, self.options.width)[0], position.start_velocity(record, self.options.width)
        ])  # fmt: skip
        return driven, np.ones(len(record.time), dtype=bool)

    def inputs(self, window: Window, values: Values) -> dict[str, Array]:
        """Return the force on the carriage and the load level."""
        applied = self.pressure_force(window, values) - self.dead_load(values)
        if "externalForce" in window.driven:
            applied = applied + window.driven["externalForce"]
        return {"appliedForce": middle(applied), "friction.level": self.level(window, values)}

    def start(self, window: Window, values: Values) -> dict[str, Value]:
        """Start from what is measured."""
        place, speed = window.driven["start"]
        return {
            **self.of_model(values), "friction.law": self.law, "bench.drive": "Free", "driveVelocity": 0.0,
            "mass": self.value("mass.moving", values), "position0": float(place), "velocity0": float(speed),
        }  # fmt: skip
