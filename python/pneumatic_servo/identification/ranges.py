"""The range of the fitted data, and questions beyond it.

A law says nothing of pressures, speeds and voltages that its data have not seen: its values may hold there, or not.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pneumatic_servo.identification.experiments import OF_CYLINDER, Window
from pneumatic_servo.identification.kinds import measured_speed
from pneumatic_servo.identification.problem import Problem
from pneumatic_servo.identification.signals import SLIDING, Units

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

MARGIN, OF_LARGEST = 0.1, 0.05
"""Share of its width, or of its largest value if that is more, by which a signal may leave the range."""
RARE = 0.01
"""Share of samples at each end that is not counted as asked: noise and single peaks ask for nothing."""


@dataclass(frozen=True)
class Ranges:
    """From where to where each quantity goes, in SI units.

    Attributes
    ----------
    limits : dict
        Low and high by signal; of ``velocity`` the range of the faster direction in both.
    units : Units
        The units of the fit.
    """

    limits: Mapping[str, tuple[float, float]]
    units: Units = SLIDING

    @staticmethod
    def of(problem: Problem, x: Array) -> Ranges:
        """Return the ranges of the samples that are fitted, with gains and offsets of sensors as in a vector."""
        courses = _courses(problem, x, lambda window: window.used & ~window.held)
        limits = {signal: _limits(signal, course) for signal, course in courses.items()}
        return Ranges(limits, problem.experiment.units)

    def beyond(self, asked: Mapping[str, ArrayLike]) -> dict[str, str]:
        """Say of each signal that leaves its range how far; values are in SI units.

        A signal that was not measured is not judged.
        """
        found: dict[str, str] = {}
        for signal, given in asked.items():
            if signal not in self.limits:
                continue
            values = np.ravel(np.asarray(given, dtype=np.float64))
            if signal == "velocity":
                values = np.abs(values)
            low, high = self.limits[signal]
            margin = max(MARGIN * (high - low), OF_LARGEST * max(abs(low), abs(high)))
            least, most = (float(end) for end in np.quantile(values, [RARE, 1.0 - RARE]))
            unit = self.units.of_signal(signal)
            if most > high + margin:
                found[signal] = f"{signal} reaches {most:.4g} {unit}, of which up to {high:.4g} {unit} was fitted"
            elif least < low - margin:
                found[signal] = f"{signal} falls to {least:.4g} {unit}, of which down to {low:.4g} {unit} was fitted"
        return found


def held_of(problem: Problem, x: Array) -> dict[str, Array]:
    """Return the validation data, in SI units."""
    held = _courses(problem, x, lambda window: window.used & window.held)
    return {signal: course for signal, course in held.items() if len(course)}


def asked_of(problem: Problem, x: Array) -> dict[str, Array]:
    """Return the samples at which a problem asks its model, in SI units."""
    return _courses(problem, x, lambda window: window.used)


def _courses(problem: Problem, x: Array, of: Callable[[Window], Mask]) -> dict[str, Array]:
    """Return the samples of a question, in SI units."""
    experiment = problem.experiment
    asked = set(experiment.signals) - {"time", "frictionForce"}
    if experiment.name not in OF_CYLINDER:
        # A bench counts its positions from anywhere, and its compared signals are answers.
        asked -= {"position", *(signal for signal in experiment.compared if signal != "velocity")}
    found: dict[str, Array] = {}
    for signal in sorted(asked - {"velocity"}):
        parts = [window.record.signals[signal][of(window)] for window in problem.windows]
        found[signal] = np.asarray(experiment.true(signal, np.concatenate(parts), problem.values(x)))
    if experiment.signals & {"position", "velocity"}:
        speeds = [measured_speed(window.record)[of(window)] for window in problem.windows]
        found["velocity"] = np.abs(np.concatenate(speeds))
    return found


def _limits(signal: str, course: Array) -> tuple[float, float]:
    if signal == "velocity":
        top = float(np.quantile(course, 1.0 - RARE))
        return -top, top
    return float(np.min(course)), float(np.max(course))
