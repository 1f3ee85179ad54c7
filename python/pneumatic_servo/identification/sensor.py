"""A sensor: how likely its readings are if a simulation is true."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pneumatic_servo import _native

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Sensor:
    """A sensor with normal noise, and perhaps a converter that rounds its readings.

    The rounding errors of a carriage at rest are all the same, so that least squares would take them for motion. A
    reading of a coarse converter says only between which two values the noisy signal was:

    ```text
    P(d) = Phi((d + step/2)/noise) - Phi((d - step/2)/noise)      d: reading minus simulation
    ```

    Attributes
    ----------
    noise : float
        Standard deviation of the noise, in SI units.
    step : float
        Step of the converter; 0 without one.
    is_coarse : bool
        Whether readings are taken as ranges.
    """

    noise: float
    step: float = 0.0
    is_coarse: bool = False

    @staticmethod
    def of(signals: Sequence[Array]) -> Sensor:
        """Estimate noise and rounding together from measured courses of a signal, and find the converter."""
        return Sensor(*_native.sensor_of(list(signals)))

    @property
    def numbers(self) -> tuple[float, float, bool]:
        """The attributes, in their order."""
        return self.noise, self.step, self.is_coarse

    def with_noise_of(self, differences: Array) -> Sensor:
        """Return the sensor whose noise makes the differences most likely."""
        return Sensor(*_native.with_noise_of(self.numbers, differences))

    def residuals(self, differences: Array) -> Array:
        """Return the summands of least squares: the signed root of twice the deficit of log P to its maximum."""
        return self._at("residual", differences)

    def slopes(self, differences: Array) -> Array:
        """Return the derivatives of the residuals."""
        return self._at("slope", differences)

    def scores(self, differences: Array) -> Array:
        """Return the slopes of the logarithm of P against the simulation, in units of `weights`: of variance 1."""
        return self._at("score", differences)

    def weights(self, differences: Array) -> Array:
        """Return the roots of the expected information of a reading about the simulation."""
        return self._at("weight", differences)

    def log_density(self, differences: Array) -> Array:
        """Return the log density of readings, in 1/unit; for a coarse converter, log of P over its step."""
        return self._at("log_density", differences)

    def _at(self, function: str, differences: Array) -> Array:
        return _native.sensed(function, self.numbers, np.ascontiguousarray(differences, dtype=np.float64))


def converter(values: Array) -> float:
    """Return the step of the converter whose lattice the values lie on; 0 if they lie on none."""
    return _native.converter(values)
