"""Residuals of a fit, and tests of whether they look like noise."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import uniform_filter1d

from pneumatic_servo.identification.fitted import Fitted
from pneumatic_servo.identification.kinds import Mask, kinds
from pneumatic_servo.identification.problem import sensors_of
from pneumatic_servo.identification.sensor import Sensor

Array = NDArray[np.float64]

LAGS = 100
AROUND = 11
"""Samples over which a misfit has to last to be the worst: a single sample is noise."""


@dataclass(frozen=True)
class Course:
    """A segment of a signal: times after the segments before, measured values, and measured minus fitted."""

    time: Array
    measured: Array
    difference: Array


@dataclass(frozen=True)
class Worst:
    """Largest residual: signal, window, sample, and the mean square there in units of the noise."""

    signal: str
    window: int
    sample: int
    size: float


class Residuals:
    """Measured minus fitted of all windows of a fit."""

    def __init__(self, fit: Fitted) -> None:
        self.problem = fit.problem
        self.windows = fit.problem.windows
        self.differences = fit.problem.differences(fit.x)
        self.signals = fit.problem.experiment.compared

    @cached_property
    def kinds(self) -> dict[str, list[Mask]]:
        """Samples of each window by kind of motion."""
        return kinds(self.problem)

    @cached_property
    def sensors(self) -> dict[str, Sensor]:
        """The sensor of each compared signal, as all windows show it."""
        return sensors_of(self.problem.experiment, self.windows)

    def unit(self, signal: str) -> str:
        """Return the SI unit of a signal."""
        return self.problem.experiment.units.of_signal(signal)

    def noise(self, signal: str) -> float:
        """Return the noise of a signal, estimated from its data, with the quantisation noise of its converter."""
        sensor = self.sensors[signal]
        return float(np.hypot(sensor.noise, sensor.step / np.sqrt(12.0)))

    def courses(self, signal: str) -> Iterator[Course]:
        """Yield the windows of a signal one after the other; samples that are not compared are NaN."""
        before = 0.0
        for window, difference in zip(self.windows, self.differences, strict=True):
            rest = np.where(window.used, difference[signal], np.nan)
            yield Course(window.record.time + before, window.record.signals[signal], rest)
            before += float(window.record.time[-1] + window.record.step)

    def all(self, signal: str) -> Array:
        """Return the residuals of a signal in all segments."""
        parts = [d[signal][w.used] for w, d in zip(self.windows, self.differences, strict=True)]
        return np.concatenate(parts)

    def worst(self) -> Worst | None:
        """Return where most is missed for a while; nothing where nothing is compared."""
        found = None
        for place, (window, difference) in enumerate(zip(self.windows, self.differences, strict=True)):
            for signal in self.signals:
                noise = self.problem.sensors[signal].noise
                size = np.where(window.used, difference[signal] / noise, 0.0) ** 2
                around = uniform_filter1d(np.nan_to_num(size), min(AROUND, len(size)), mode="constant")
                sample = int(np.argmax(around))
                if window.used.any() and (found is None or around[sample] > found.size):
                    found = Worst(signal, place, sample, float(around[sample]))
        return found

    @property
    def position(self) -> Array:
        """The position of these samples; the number of the sample where none is measured."""
        parts = [w.record.signals.get("position", w.record.time)[w.used] for w in self.windows]
        return np.concatenate(parts)

    @property
    def velocity(self) -> Array:
        """The velocity of these samples."""
        parts = []
        for window in self.windows:
            record = window.record
            course = record.signals.get("position", record.time)
            speed = record.signals.get("velocity", np.gradient(course, record.time))
            parts.append(speed[window.used])
        return np.concatenate(parts)

    def correlation(self, signal: str) -> Array:
        """Return the autocorrelation of the residuals, within the segments."""
        lags = min(LAGS, min(int(np.sum(window.used)) for window in self.windows if np.any(window.used)) // 2)
        total = np.zeros(lags + 1)
        for window, difference in zip(self.windows, self.differences, strict=True):
            rest = difference[signal][window.used]
            rest = rest - rest.mean() if len(rest) else rest
            total += [float(rest[lag:] @ rest[: max(0, len(rest) - lag)]) for lag in range(lags + 1)]
        return np.asarray(total / total[0]) if total[0] > 0.0 else total

    def limit(self, signal: str) -> float:
        """Return the 95 % bound of the autocorrelations of white noise."""
        return float(1.96 / np.sqrt(max(1, len(self.all(signal)))))

    def is_white(self, signal: str) -> bool:
        """Tell whether at most a tenth of the autocorrelations leave the band of white noise."""
        beyond = np.abs(self.correlation(signal)[1:]) > self.limit(signal)
        return bool(np.mean(beyond) <= 0.1) if len(beyond) else True
