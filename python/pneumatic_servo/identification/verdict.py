"""What a fit is worth: a paragraph and a traffic light."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import maximum_filter1d

from pneumatic_servo.identification.records import Record
from pneumatic_servo.identification.residuals import Residuals
from pneumatic_servo.identification.sensor import Sensor
from pneumatic_servo.identification.signals import SIGNALS
from pneumatic_servo.identification.smoothing import slope

if TYPE_CHECKING:
    from pneumatic_servo.identification.result import Fit

Array = NDArray[np.float64]

LIGHTS = ("green", "yellow", "red")
NEAR = 0.05
"""Time in s about a reversal, or after a rest, that counts to it."""
SLOW = 0.2
"""Share of the fast velocities below which a motion is slow."""
REST = 0.01
"""The same below which there is none."""
FEWEST = 20
"""Samples without which nothing is said of a regime."""
WORSE = 1.5
"""A regime whose rms is so many times that of all is named."""
MISSED = 0.5
"""Share of a signal's spread that no model of it leaves."""
LOUD = 3.0
"""A fit that leaves so many times the noise of a sensor misses something."""
OFF, FAR_OFF = 1.5, 3.0
"""Data held out that are missed by so many times what was fitted are predicted badly, or not at all."""


@dataclass(frozen=True)
class Finding:
    """Something that a fit is to be judged by: its light, and a sentence."""

    light: str
    text: str


@dataclass(frozen=True)
class Verdict:
    """What a fit is worth.

    Attributes
    ----------
    findings : tuple of Finding
        What it is judged by, the worst first.
    """

    findings: tuple[Finding, ...]

    @property
    def light(self) -> str:
        """The worst of the findings: ``green``, ``yellow`` or ``red``."""
        return max((finding.light for finding in self.findings), key=LIGHTS.index, default="green")

    @property
    def text(self) -> str:
        """All findings in one paragraph."""
        heads = {
            "green": "The law describes the data as far as they tell.",
            "yellow": "Look at this before the values are used.",
            "red": "These values do not describe the machine.",
        }
        return " ".join([heads[self.light], *(finding.text for finding in self.findings)])

    def __str__(self) -> str:
        return f"{self.light}: {self.text}"


def verdict(fit: Fit) -> Verdict:
    """Judge a fit by what it leaves, where, how it predicts, and what the data tell."""
    found = [*_of_search(fit), *_of_misfit(fit), *_of_prediction(fit)]
    return Verdict(tuple(sorted(found, key=lambda finding: -LIGHTS.index(finding.light))))


def _of_search(fit: Fit) -> Iterator[Finding]:
    if not fit.converged:
        yield Finding("red", f"The search has not come to an end ({fit.message}).")
    if fit.undetermined:
        names = ", ".join(fit.undetermined)
        yield Finding("yellow", f"The data do not tell {names}: give it, or measure what tells it.")


def _of_misfit(fit: Fit) -> Iterator[Finding]:
    residuals = Residuals(fit)
    regimes = _regimes(residuals)
    for signal, rms in fit.rms.items():
        unit = SIGNALS[signal]
        measured = np.concatenate([course.measured for course in residuals.courses(signal)])
        spread, sensor = float(np.std(measured)), Sensor.of([course.measured for course in residuals.courses(signal)])
        noise = float(np.hypot(sensor.noise, sensor.step / np.sqrt(12.0)))
        where = _worst(residuals.all(signal), regimes)
        if not rms <= MISSED * spread:
            yield Finding(
                "red", f"It leaves {rms:.3g} {unit} rms of {signal}, which varies by {spread:.3g} {unit}{where}: "
                "look at signs, units and what was assumed."
            )  # fmt: skip
        elif rms > LOUD * noise:
            yield Finding(
                "yellow", f"It leaves {rms:.3g} {unit} rms of {signal}, {rms / noise:.2g} times the noise of its sensor"
                f"{where}: the law, or what is held fixed, misses something."
            )  # fmt: skip
        elif not residuals.is_white(signal):
            yield Finding(
                "green", f"What it leaves of {signal}, {rms:.3g} {unit} rms, is about as large as the noise of its "
                f"sensor, but hangs together{where}."
            )  # fmt: skip
        else:
            yield Finding("green", f"What it leaves of {signal}, {rms:.3g} {unit} rms, looks like noise.")


def _of_prediction(fit: Fit) -> Iterator[Finding]:
    if not fit.hold_out_rms:
        yield Finding("green", "Nothing was held out, so that no prediction was tried.")
    for signal, rms in fit.hold_out_rms.items():
        ratio = rms / max(fit.rms[signal], 1e-300)
        light = "red" if not ratio <= FAR_OFF else "yellow" if ratio > OFF else "green"
        unit = SIGNALS[signal]
        yield Finding(
            light, f"Data held out are predicted to {rms:.3g} {unit} rms of {signal}, {ratio:.2g} times what is left "
            "of those fitted."
        )  # fmt: skip


def _worst(rest: Array, regimes: dict[str, NDArray[np.bool_]]) -> str:
    """Name the regime in which most is missed, if one stands out."""
    whole = float(np.sqrt(np.mean(rest**2)))
    own = {
        name: float(np.sqrt(np.mean(rest[inside] ** 2))) for name, inside in regimes.items() if np.sum(inside) >= FEWEST
    }
    name = max(own, key=lambda one: own[one], default=None)
    if name is None or not own[name] > WORSE * whole:
        return ""
    return f", most of it {name} ({own[name]:.3g})"


def _regimes(residuals: Residuals) -> dict[str, NDArray[np.bool_]]:
    """Tell which samples belong to which kind of motion, in the order of the residuals."""
    parts: dict[str, list[NDArray[np.bool_]]] = {}
    speeds = [_speed(window.record) for window in residuals.windows]
    fast = float(np.quantile(np.abs(np.concatenate(speeds)), 0.98))
    for window, speed in zip(residuals.windows, speeds, strict=True):
        around = max(1, 2 * round(NEAR / window.record.step) + 1)
        still = np.abs(speed) < REST * fast
        turns = np.zeros(len(speed), dtype=bool)
        moving = np.flatnonzero(~still)
        signs = np.sign(speed[moving])
        turns[moving[1:][signs[1:] != signs[:-1]]] = True
        near = maximum_filter1d(turns, around).astype(bool)
        leaves = np.concatenate([[False], still[:-1] & ~still[1:]])
        breaks = maximum_filter1d(leaves, around).astype(bool) & ~still & ~near
        slow = ~still & ~near & ~breaks & (np.abs(speed) < SLOW * fast)
        for name, inside in (
            ("at rest", still & ~near), ("at break-away", breaks), ("at reversals", near), ("in slow motion", slow),
            ("in fast motion", ~still & ~near & ~breaks & ~slow),
        ):  # fmt: skip
            parts.setdefault(name, []).append(inside[window.used])
    return {name: np.concatenate(inside) for name, inside in parts.items()}


def _speed(record: Record) -> Array:
    signals, time, step = record.signals, record.time, record.step
    if "velocity" in signals:
        return np.asarray(signals["velocity"])
    if "position" not in signals:
        return np.zeros(len(time))
    return slope(np.asarray(signals["position"]), step, max(NEAR / 2.0, 5.0 * step))
