"""The common part of the experiments whose mass is moved by measured forces."""

from __future__ import annotations

from abc import abstractmethod

import numpy as np
from numpy.typing import NDArray

from pneumatic_servo.identification.experiments import position
from pneumatic_servo.identification.experiments.base import Experiment, Values, Window
from pneumatic_servo.identification.records import Record
from pneumatic_servo.identification.smoothing import noise, smooth

Array = NDArray[np.float64]

FACTOR = "friction.direction.factor"
"""Friction outwards over friction inwards."""
RESTING = 8.0
"""Multiple of the noise of its readings within which a smoothed velocity is at rest."""


class Pushed(Experiment):
    """An experiment whose mass is moved by forces that are measured."""

    @abstractmethod
    def applied(self, window: Window, values: Values) -> Array:
        """Return the force on the mass but for its friction, at the communication points."""

    @abstractmethod
    def level(self, window: Window, values: Values) -> Array:
        """Return the load level at the communication points."""

    @abstractmethod
    def inertia(self, values: Values) -> float:
        """Return the mass."""

    def direction(self, record: Record) -> Array:
        """Return the sign of the measured velocity at the communication points; 0 where the mass rests."""
        width = self.options.width
        if "position" in record.signals:
            speed, resting = position.velocity(record, width), position.resting(record, width)
        else:
            speed = smooth(record.on_grid("velocity"), record.step, width)
            seen = np.interp(record.time, record.grid, speed)
            resting = np.abs(seen) <= RESTING * noise(record.signals["velocity"])
        at = np.clip(np.searchsorted(record.time, record.grid - 1e-6 * record.step), 0, len(record.time) - 1)
        return np.where(resting[at], 0.0, np.sign(self.pace * speed))

    def directed(self, level: Array, window: Window, values: Values) -> Array:
        """Return a load level with the factor by direction: of the motion, or at rest of the applied force."""
        factor = self.beside_value(FACTOR, values, 1.0)
        if factor == 1.0:
            return level
        moving = window.driven["direction"]
        towards = np.where(moving == 0.0, self.applied(window, values), moving)
        return np.where(towards > 0.0, factor * level, level)
