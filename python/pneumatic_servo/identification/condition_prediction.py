"""Friction of a condition as the others predict it, with the law's own error, and as it was measured.

Intervals from residuals alone take the law for true at every pressure, which it is not: friction of a machine differs
from any law by some percent between conditions. Here this is part of the model. In each condition a law misses friction
by a share of its own, alike along everything that its parameters, or a factor of all friction, could change:

```text
B_i' residuals_i = B_i' J_i (theta - theta0) + e_i + noise,    e_i ~ N(0, tau^2 |f_i|^2 I),    tau ~ |N(0, 0.2^2)|
```

with the derivatives J_i by the parameters in the condition i, those f_i by the logarithm of all friction, and an
orthonormal basis B_i of both. How large tau is, is told by friction as a whole in each condition, about the curve that
the law can draw through them at best; it is integrated out, as A. Gelman advises for few groups ("Prior distributions
for variance parameters in hierarchical models", Bayesian Analysis, 2006): that a law is off by more than a factor of
1.5 between conditions is not expected, unless `law_error` gives another deviation than 0.2; the data say the rest. The
condition that is left out is off by a share, too.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq
from scipy.special import ndtr
from scipy.stats import t as student

from pneumatic_servo.identification.intervals import LEVEL, RANK
from pneumatic_servo.identification.problem import Problem
from pneumatic_servo.identification.sensor import Sensor
from pneumatic_servo.identification.solve import sensitivities

Array = NDArray[np.float64]

USUAL = 0.2
"""Prior standard deviation of the error of any law in a condition, relative to friction."""
SPREADS = np.geomspace(1e-3, 1.0, 120)
"""Deviations tau that are looked at."""
STEP = 0.01
"""Step of the factor of all friction whose effect is looked for."""
STRETCHES = 10
"""Stretches of time of the condition left out that count as independent."""
TOLD = 1e-3
"""Singular values below this, of how the logarithm of friction changes with scaled parameters, are none."""
WIDE = 3.0
"""An interval whose ends have this ratio tells hardly anything."""


@dataclass(frozen=True)
class FrictionPrediction:
    """Mean friction of a condition in N: as the other conditions predict it, and as measured, with 95 % intervals."""

    predicted: float
    low: float
    high: float
    measured: float
    measured_low: float
    measured_high: float
    spread: float
    """Median of tau, as far as the other conditions tell it; NaN if the law has as many parameters as there are."""

    @property
    def is_within(self) -> bool:
        """Whether the interval of the prediction contains the measurement."""
        return self.low <= self.measured <= self.high

    @property
    def is_wide(self) -> bool:
        """Whether the interval is so wide that it tells hardly anything."""
        return self.high > WIDE * self.low

    def said(self, unit: str) -> str:
        """Return it for people, in a unit."""
        return (
            f"predicted {self.predicted:.4g} {unit} [{self.low:.4g}, {self.high:.4g}], "
            f"measured {self.measured:.4g} {unit} [{self.measured_low:.4g}, {self.measured_high:.4g}]"
        )


@dataclass(frozen=True)
class SegmentResiduals:
    """Residuals of some windows, and the derivatives that could reduce them.

    Attributes
    ----------
    by_signal : dict
        Residuals by signal, in SI units, with optimal start values of the windows.
    weights : ndarray of shape (samples,)
        Factors that convert a difference to units of the noise.
    residuals : ndarray of shape (samples,)
        The same in units of the noise.
    derivatives : ndarray of shape (samples, parameters)
        Their derivatives by the estimated parameters, with the sign of the simulation, start values projected out.
    basis : ndarray of shape (samples, beginnings)
        Derivatives by start values.
    """

    by_signal: dict[str, Array]
    weights: Array
    residuals: Array
    derivatives: Array
    basis: Array

    @staticmethod
    def of(problem: Problem, x: Array) -> SegmentResiduals:
        """Return it for the windows of a problem at a vector."""
        slopes, differences = sensitivities(problem, x)
        weights = problem.by_sensor(Sensor.weights, differences)
        every = -slopes * weights[:, None]
        count = len(problem.free)
        basis = np.linalg.qr(every[:, count:])[0] if every.shape[1] > count else np.zeros((len(weights), 0))
        residuals = np.nan_to_num(differences) * weights
        residuals = residuals - basis @ (basis.T @ residuals)
        own = every[:, :count] - basis @ (basis.T @ every[:, :count])
        return SegmentResiduals(_by_signal(problem, residuals / weights), weights, residuals, own, basis)

    def without(self, column: Array) -> Array:
        """Return a column, with the effects of start values projected out."""
        return np.asarray(column - self.basis @ (self.basis.T @ column))


def _by_signal(problem: Problem, stacked: Array) -> dict[str, Array]:
    parts: dict[str, list[Array]] = {signal: [] for signal in problem.experiment.compared}
    first = 0
    for window in problem.windows:
        for signal in problem.experiment.compared:
            parts[signal].append(stacked[first : first + window.fitted])
            first += window.fitted
    return {signal: np.concatenate(own) for signal, own in parts.items()}


def _of_factor(problem: Problem, x: Array, left: SegmentResiduals) -> Array:
    """Return how residuals change with the logarithm of all friction, in units of the noise."""
    up, down = (replace(problem, scale=problem.scale * np.exp(step)).stacked([x])[0] for step in (STEP, -STEP))
    return left.without(np.nan_to_num((down - up) / (2.0 * STEP)) * left.weights)


def predict_friction(
    training: Problem, x: Array, groups: Sequence[Sequence[int]], out: Problem, asked: Array, left: SegmentResiduals,
    law_error: float,
) -> FrictionPrediction:  # fmt: skip
    """Predict friction of windows from others that are fitted, and measure it.

    Parameters
    ----------
    training, x : Problem, ndarray
        The windows that are fitted, and their solution.
    groups : sequence of sequence of int
        Their places, condition by condition.
    out, asked : Problem, ndarray
        The validation windows, with the values estimated from the others and their start values.
    left : SegmentResiduals
        Residuals under these values.
    law_error : float
        Deviation of tau, before the data tell.
    """
    fitted = SegmentResiduals.of(training, x)
    factors = _of_factor(training, x, fitted)
    counts = [window.fitted * len(training.experiment.compared) for window in training.windows]
    windows = np.repeat(np.arange(len(counts)), counts)
    own = np.column_stack([np.where(np.isin(windows, list(group)), factors, 0.0) for group in groups])
    mean, slope = _mean_friction(out, asked)
    sensors = _of_sensors(training)
    middle, low, high, spread = _predicted(fitted, own, training.blocks(2 * STRETCHES), slope, sensors, law_error)
    with np.errstate(over="ignore"):
        # Without information from the others, the upper end is as good as infinite.
        middle, low, high = (float(mean * np.exp(end)) for end in (middle, low, high))
    share, half = _measured(out, left, _of_factor(out, asked, left))
    return FrictionPrediction(
        middle, low, high,
        mean * (1.0 + share), mean * (1.0 + share - half), mean * (1.0 + share + half), spread,
    )  # fmt: skip


def _predicted(
    left: SegmentResiduals,
    factors: Array,
    blocks: NDArray[np.int64],
    slope: Array,
    sensors: Sequence[int],
    law_error: float,
) -> tuple[float, float, float, float]:
    """Return median and ends of the logarithm of the factor that is expected, and the median of tau."""
    noise = _noise(np.column_stack([left.derivatives, factors]), left.residuals, blocks)
    seen = [_Seen.of(left, factors[:, group]) for group in range(factors.shape[1])]
    levels = [_Seen.level(left, factors[:, group], sensors) for group in range(factors.shape[1])]
    weights, means, variances = [], [], []
    for tau in SPREADS:
        whole, right, _ = _likelihood(seen, tau, noise)
        solved = np.linalg.solve(whole, np.column_stack([right, slope]))
        likely = _likelihood(levels, tau, noise)[2]
        # The grid is even in the logarithm of tau.
        weights.append(likely + np.log(tau) - 0.5 * (tau / law_error) ** 2)
        means.append(float(slope @ solved[:, 0]))
        variances.append(float(slope @ solved[:, 1]) + tau**2)
    shares = np.exp(np.array(weights) - np.max(weights))
    shares /= np.sum(shares)
    low, middle, high = (
        _quantile(shares, np.array(means), np.sqrt(variances), level)
        for level in (0.5 - 0.5 * LEVEL, 0.5, 0.5 + 0.5 * LEVEL)
    )
    slopes = np.concatenate([one.derivatives / np.sqrt(one.size) for one in levels])
    is_told = len(levels) > np.linalg.matrix_rank(slopes, tol=TOLD)
    spread = float(SPREADS[np.searchsorted(np.cumsum(shares), 0.5)]) if is_told else np.nan
    return middle, low, high, spread


@dataclass(frozen=True)
class _Seen:
    """A condition along the effects of the parameters and of the factor of friction.

    Attributes
    ----------
    residuals : ndarray of shape (directions,)
        Residuals in units of the noise.
    derivatives : ndarray of shape (directions, parameters)
        Their derivatives by the parameters.
    size : float
        Square of how much the factor of all friction does.
    """

    residuals: Array
    derivatives: Array
    size: float

    @staticmethod
    def of(left: SegmentResiduals, factor: Array) -> _Seen:
        """Return it, with the factor of all friction as the first direction."""
        inside = factor != 0.0
        own, slopes = factor[inside], left.derivatives[inside]
        size = float(own @ own)
        first = own / np.sqrt(size)
        columns = slopes / np.maximum(np.linalg.norm(slopes, axis=0), 1e-300)
        directions, values, _ = np.linalg.svd(columns - np.outer(first, first @ columns), full_matrices=False)
        basis = np.column_stack([first, directions[:, values > RANK]])
        return _Seen(basis.T @ left.residuals[inside], basis.T @ slopes, size)

    @staticmethod
    def level(left: SegmentResiduals, factor: Array, sensors: Sequence[int]) -> _Seen:
        """Return friction as a whole alone, as far as no sensor could make it look so."""
        inside = factor != 0.0
        own, slopes = factor[inside], left.derivatives[inside]
        theirs = np.linalg.qr(slopes[:, sensors])[0]
        own = own - theirs @ (theirs.T @ own)
        size = float(own @ own)
        first = own[:, None] / np.sqrt(size)
        return _Seen(first.T @ left.residuals[inside], first.T @ slopes, size)


def _likelihood(seen: Sequence[_Seen], tau: float, noise: float) -> tuple[Array, Array, float]:
    """Return the information about the parameters, its right side, and how likely the residuals are."""
    count = seen[0].derivatives.shape[1]
    # Nearly flat: it only bounds directions without information.
    whole, right, likely = 1e-9 * np.eye(count), np.zeros(count), 0.0
    for one in seen:
        variance = tau**2 * one.size + noise
        whole += one.derivatives.T @ one.derivatives / variance
        right += one.derivatives.T @ one.residuals / variance
        likely -= 0.5 * (len(one.residuals) * np.log(variance) + float(one.residuals @ one.residuals) / variance)
    likely += 0.5 * (float(right @ np.linalg.solve(whole, right)) - float(np.linalg.slogdet(whole)[1]))
    return whole, right, likely


def _noise(columns: Array, residuals: Array, blocks: NDArray[np.int64]) -> float:
    """Return the variance of the residuals beside factors and parameters, for autocorrelated samples.

    As many of them as hang together count as one: by how much more the products with the columns vary from stretch to
    stretch than they would for independent samples.
    """
    fitted, *_ = np.linalg.lstsq(columns, residuals, rcond=1e-10)
    rest = residuals - columns @ fitted
    products = columns * rest[:, None]
    sums = np.array([np.bincount(blocks, weights=column) for column in products.T])
    ratios = np.sum(sums**2, axis=1) / np.maximum(np.sum(products**2, axis=0), 1e-300)
    return float(np.mean(rest**2) * max(1.0, np.median(ratios)))


def _quantile(shares: Array, means: Array, deviations: Array, level: float) -> float:
    """Return a quantile of a mixture of normal distributions."""

    def over(value: float) -> float:
        return float(shares @ ndtr((value - means) / deviations)) - level

    reach = 12.0 * float(np.max(deviations))
    return float(brentq(over, float(np.min(means)) - reach, float(np.max(means)) + reach))


def _mean_friction(problem: Problem, x: Array) -> tuple[float, Array]:
    """Return the mean magnitude of friction as it is simulated, and the derivatives of its logarithm."""
    count = len(problem.free)
    low, high = problem.bounds
    vectors = [x]
    for place in range(count):
        move = np.zeros(len(x))
        move[place] = 1e-3
        vectors += [np.minimum(x + move, high), np.maximum(x - move, low)]
    means = np.array([_means(problem, vector) for vector in vectors])
    ups, downs = means[1::2], means[2::2]
    steps = np.array([vectors[1 + 2 * k][k] - vectors[2 + 2 * k][k] for k in range(count)])
    return float(means[0]), np.log(ups / downs) / steps


def _means(problem: Problem, x: Array) -> float:
    total, number = 0.0, 0
    friction = problem.native.recorded(x, ["frictionForce"])
    for window, [on_grid] in zip(problem.windows, friction, strict=True):
        course = np.interp(window.record.time, window.record.grid, on_grid)
        total += float(np.sum(np.abs(course[window.used])))
        number += int(np.sum(window.used))
    return total / number


def _measured(problem: Problem, left: SegmentResiduals, factor: Array) -> tuple[float, float]:
    """Return by which share friction is measured to be more than simulated, and half the interval of it.

    What sensors do, and an area that a pressure pushes on, is found along with it: they are none of the law.
    """
    columns = np.column_stack([factor, left.derivatives[:, _of_sensors(problem)]])
    blocks = problem.blocks(STRETCHES)
    square, right = columns.T @ columns, columns.T @ left.residuals
    whole = float(np.linalg.lstsq(square, right, rcond=1e-12)[0][0])
    others = []
    for block in range(int(blocks.max()) + 1):
        inside = blocks == block
        part = columns[inside]
        kept = np.linalg.lstsq(square - part.T @ part, right - part.T @ left.residuals[inside], rcond=1e-12)[0]
        others.append(float(kept[0]))
    number = len(others)
    if number < 2:
        return whole, np.inf
    variance = (number - 1) / number * float(np.sum((np.array(others) - whole) ** 2))
    return whole, float(student.ppf(0.5 + 0.5 * LEVEL, number - 1) * np.sqrt(variance))


def _of_sensors(problem: Problem) -> list[int]:
    """Return the places of estimated parameters of sensors."""
    kinds = ("area", "gain", "offset", "delay", "lag")
    return [place for place, free in enumerate(problem.free) if free.name.partition(".")[0] in kinds]
