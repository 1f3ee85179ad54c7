"""Tests of faults of single sensors as explanations of the residuals of a fit.

A voltage that is recorded late, a pressure behind the filter of a recorder, a sensor with an offset: each leaves its
own trace in the residuals. For every gain, offset, delay and lag that nobody has freed or given, the residuals are
asked how much less would be left with it, all free parameters moving along (a score test: C. R. Rao, "Large sample
tests of statistical hypotheses concerning several parameters", 1948). Delays and lags are tried at several values,
since what they do is not in proportion to them.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from pneumatic_servo.identification.fitted import Fitted
from pneumatic_servo.identification.intervals import certainty
from pneumatic_servo.identification.parameters import free_of
from pneumatic_servo.identification.problem import Problem
from pneumatic_servo.identification.residuals import Residuals
from pneumatic_servo.identification.sensor import Sensor
from pneumatic_servo.identification.solve import ROUGH, refine, sensitivities

Array = NDArray[np.float64]

MUCH = 0.5
"""Share of what is left that a fault has to explain."""
TIMES = (0.003, 0.01, 0.02, 0.04)
"""Delays and lags in s that are tried."""
STEP = 0.05
"""Tried change of a gain or an offset, in its magnitudes."""
BLIND = 1e-6
"""A direction of which the free parameters leave less than this share is theirs."""


@dataclass(frozen=True)
class Doubt:
    """A fault of a sensor that would explain what is left.

    Attributes
    ----------
    name : str
        ``gain.SIGNAL``, ``offset.SIGNAL``, ``delay.SIGNAL`` or ``lag.SIGNAL``.
    value : float
        Magnitude of the mistake, in SI units.
    unit : str
        SI unit.
    gain : float
        By how much the sum of squares would fall, in units of the noise.
    signal : str
        The signal that is missed less with it.
    share : float
        Share of the sum of its squares that would be gone.
    low, high : float
        Ends of its 95 % interval where it was fitted along; infinite otherwise.
    """

    name: str
    value: float
    unit: str
    gain: float
    signal: str
    share: float
    low: float = -np.inf
    high: float = np.inf

    def __str__(self) -> str:
        kind, _, own = self.name.partition(".")
        unit = "" if self.unit == "1" else f" {self.unit}"
        is_fitted = np.isfinite(self.low) and np.isfinite(self.high)
        times = 1e3 if kind in ("delay", "lag") else 1.0
        within = f" [{times * self.low:.4g}, {times * self.high:.4g}]" if is_fitted else ""
        late = f"if {own} were read {1e3 * self.value:.2g}{within} ms late"
        what = {
            "gain": f"if {own} were {self.value:.4g}{within} times what is read",
            "offset": f"if {self.value:.3g}{within}{unit} of {own} were an offset of its sensor",
            "delay": late,
            "lag": f"{late}, or through a filter",
        }[kind]
        other = f" or delay.{own}" if kind == "lag" else ""
        return (
            f"Of the squares of what is left of {self.signal} {100.0 * self.share:.0f} % would be gone {what}: free "
            f"{self.name}{other}."
        )


def doubt(fit: Fitted, residuals: Residuals) -> Doubt | None:
    """Return the fault of a sensor that would explain the most of what a fit leaves, if it is much."""
    if explains_nothing(fit, residuals):
        return None
    problem = fit.problem.trained()
    # Start values of windows are the fitted ones.
    x = np.concatenate([fit.x, np.zeros(sum(problem.loose))])
    known = {*fit.problem.experiment.settings, *(free.name for free in problem.free)}
    names = [name for name in problem.experiment.beside if "." in name and name not in known]
    slopes, differences = sensitivities(problem, x)
    weights = problem.by_sensor(Sensor.weights, differences)
    columns = slopes * weights[:, None]
    if not (names and np.all(np.isfinite(columns)) and np.all(np.isfinite(differences))):
        return None
    basis = np.linalg.qr(columns / np.maximum(np.linalg.norm(columns, axis=0), 1e-300))[0]
    left = without(basis, differences * weights)
    if not left @ left > 0.0:
        return None
    found = [one for name in names for one in _of(problem, x, name, differences, weights, basis, left)]
    best = max(found, key=lambda one: one.gain, default=None)
    return best if best is not None and best.share > MUCH else None


def sized(fit: Fitted, found: Doubt) -> Doubt:
    """Return a fault with its size when everything that is free is fitted anew along with it, and its interval.

    One step is in proportion, and a sensor's noise is what the fit without the fault has left: it tells which fault it
    is, and not how large.
    """
    experiment, number = fit.problem.experiment, len(fit.problem.free)
    free = free_of(found.name, experiment.table, experiment.compared, experiment.beside, found.name)
    problem = fit.problem.trained().with_free([*fit.problem.free, free]).bounded()
    near = min(max(free.inner(found.value), problem.bounds[0][number]), problem.bounds[1][number])
    end = refine(problem, np.concatenate([fit.x, [near], np.zeros(sum(problem.loose))]), effort=ROUGH).x
    problem = problem.seen_by(problem.likely_sensors(end))
    end = refine(problem, end).x
    sure = certainty(problem, end)
    value, low, high = free.outer(float(end[number])), float(sure.low[number]), float(sure.high[number])
    return replace(found, value=value, low=low, high=high)


def explains_nothing(fit: Fitted, residuals: Residuals) -> bool:
    """Tell whether nothing can explain much: noise is what no fault explains, and little else is left."""
    return not any(rms**2 * (1.0 - MUCH) > residuals.noise(signal) ** 2 for signal, rms in fit.rms.items())


def _of(
    problem: Problem, x: Array, name: str, differences: Array, weights: Array, basis: Array, left: Array
) -> list[Doubt]:
    """Return what a fault of some sizes would explain; nothing where it has no effect of its own.

    The differences are those without it.
    """
    experiment = problem.experiment
    free = free_of(name, experiment.table, experiment.compared, experiment.beside, name)
    kind = name.partition(".")[0]
    ways = {"delay": (*TIMES, *(-time for time in TIMES)), "lag": TIMES}.get(kind, (STEP * free.scale,))
    found = []
    for way in ways:
        run = replace(problem, experiment=experiment.with_value(name, free.start + way)).stacked([x])[0]
        column = (run - differences) * weights
        own = without(basis, column)
        size = float(own @ own)
        if not size > BLIND * float(column @ column):
            continue
        times = -float(own @ left) / size
        value = free.start + times * way
        # A shift of more than half a second is none of a sensor.
        if free.low <= value <= free.high:
            signal, share = most_explained(problem, left, left + times * own)
            found.append(Doubt(name, value, free.unit, times**2 * size, signal, share))
    return found


def most_explained(problem: Problem, left: Array, then: Array) -> tuple[str, float]:
    """Return the signal of whose squares the largest share is gone, and this share."""
    signals = problem.experiment.compared
    own = np.concatenate([np.repeat(np.arange(len(signals)), window.fitted) for window in problem.windows])
    before, after = (np.bincount(own, weights=rest**2) for rest in (left, then))
    shares = 1.0 - after / np.maximum(before, 1e-300)
    return signals[int(np.argmax(shares))], float(np.max(shares))


def without(basis: Array, column: Array) -> Array:
    """Return a column without what the free parameters can do."""
    return np.asarray(column - basis @ (basis.T @ column))
