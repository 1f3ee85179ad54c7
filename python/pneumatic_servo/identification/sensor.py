"""A sensor: how likely its readings are if a simulation is true."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize_scalar
from scipy.special import log_ndtr

from pneumatic_servo.identification.smoothing import noise

Array = NDArray[np.float64]

COARSE = 2.0
"""Noise of so many steps of a converter hides it: the sum of both is as good as normal."""
FINEST = 0.02
"""Noise is not looked for below this share of the step of a converter."""
LEAST = 1e-12
"""Noise in SI units below which no sensor is taken for."""
ON_LATTICE = 0.1
"""Values that leave a lattice by more than this share of its step were not made by a converter."""


@dataclass(frozen=True)
class Sensor:
    """A sensor with normal noise, and perhaps a converter that rounds what it reads.

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
        magnitude = max(float(np.max(np.abs(values))) for values in signals)
        estimate = float(np.median([noise(values) for values in signals]))
        return Sensor(max(estimate, 1e-9 * magnitude, LEAST), converter(np.concatenate(list(signals))))

    def with_noise_of(self, differences: Array) -> Sensor:
        """Return the sensor whose noise makes the differences most likely."""
        rms = max(float(np.sqrt(np.mean(differences**2))), LEAST)
        if rms >= COARSE * self.step:
            return replace(self, noise=rms, is_coarse=False)

        def cost(logarithm: float) -> float:
            return -float(np.sum(replace(self, noise=np.exp(logarithm), is_coarse=True)._log_likelihood(differences)))

        bounds = (np.log(FINEST * self.step), np.log(COARSE * self.step))
        found = minimize_scalar(cost, bounds=bounds, method="bounded", options={"xatol": 0.01})
        return replace(self, noise=float(np.exp(found.x)), is_coarse=True)

    def residuals(self, differences: Array) -> Array:
        """Return what least squares may add up: the signed root of twice what the logarithm of P lacks to its best."""
        if not self.is_coarse:
            return differences / self.noise
        best = self._log_likelihood(np.zeros(1))[0]
        lack = np.maximum(best - self._log_likelihood(differences), 0.0)
        return np.asarray(np.sign(differences) * np.sqrt(2.0 * lack))

    def log_density(self, differences: Array) -> Array:
        """Return the logarithm of the density of readings, in 1/unit; of a coarse converter that of P over its step."""
        if not self.is_coarse:
            return np.asarray(-0.5 * (differences / self.noise) ** 2 - np.log(np.sqrt(2.0 * np.pi) * self.noise))
        return np.asarray(self._log_likelihood(differences) - np.log(self.step))

    def slopes(self, differences: Array) -> Array:
        """Return the derivatives of the residuals."""
        if not self.is_coarse:
            return np.full_like(differences, 1.0 / self.noise)
        residuals = self.residuals(differences)
        # Next to its middle the residual is as straight as anything; the quotient is not.
        near = 1e-3 * self.noise
        straight = float(self.residuals(np.array([near]))[0]) / near
        is_far = np.abs(differences) > near
        return np.where(is_far, -self._score(differences) / np.where(is_far, residuals, 1.0), straight)

    def scores(self, differences: Array) -> Array:
        """Return the slopes of the logarithm of P against the simulation, in units of `weights`: of variance 1."""
        if not self.is_coarse:
            return differences / self.noise
        return -self._score(differences) / self.weights(differences)

    def weights(self, differences: Array) -> Array:
        """Return the roots of the information that a reading is expected to have about what is simulated."""
        if not self.is_coarse:
            return np.full_like(differences, 1.0 / self.noise)
        reach = int(np.ceil(6.0 * self.noise / self.step)) + 1
        # What the simulation is off the nearest value that the converter has: all readings are expected from there.
        offset = differences - self.step * np.round(differences / self.step)
        information = np.zeros_like(differences)
        for reading in range(-reach, reach + 1):
            shifted = offset + self.step * reading
            information += np.exp(self._log_likelihood(shifted)) * self._score(shifted) ** 2
        weights: Array = np.sqrt(np.maximum(information, (1e-6 / self.noise) ** 2))
        return weights

    def _ends(self, differences: Array) -> tuple[Array, Array]:
        """Return the ends of the ranges that readings stand for, in units of the noise, as P sees them: it is even."""
        half, distance = 0.5 * self.step, np.abs(differences)
        return (half - distance) / self.noise, (-half - distance) / self.noise

    def _log_likelihood(self, differences: Array) -> Array:
        """Return the logarithm of P, which is even, without the loss of digits in the tails."""
        upper, lower = self._ends(differences)
        high, low = log_ndtr(upper), log_ndtr(lower)
        return np.asarray(high + np.log1p(-np.exp(low - high)))

    def _score(self, differences: Array) -> Array:
        """Return the derivative of the logarithm of P."""
        upper, lower = self._ends(differences)
        likelihood = self._log_likelihood(differences) + 0.5 * np.log(2.0 * np.pi)
        size = (np.exp(-0.5 * upper**2 - likelihood) - np.exp(-0.5 * lower**2 - likelihood)) / self.noise
        return np.asarray(-np.sign(differences) * size)


def converter(values: Array) -> float:
    """Return the step of the converter whose lattice the values lie on; 0 if they lie on none."""
    levels = np.unique(values)
    if len(levels) < 2:
        return 0.0
    jumps = np.diff(levels)
    numbers = np.concatenate([[0.0], np.cumsum(np.round(jumps / np.min(jumps)))])
    step, first = np.polyfit(numbers, levels, 1)
    off = float(np.max(np.abs(levels - first - step * numbers)))
    return float(step) if off < ON_LATTICE * step else 0.0
