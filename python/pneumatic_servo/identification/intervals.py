"""Confidence intervals, correlations, and parameters that are not identifiable."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.stats import t as student

from pneumatic_servo import _native
from pneumatic_servo.identification.compression import triangle
from pneumatic_servo.identification.parameters import Free
from pneumatic_servo.identification.problem import Problem
from pneumatic_servo.identification.profile import profile

Array = NDArray[np.float64]

BLOCKS = 20
"""Stretches of time that count as independent."""
RANK = 1e-7
"""Singular values below this share of the largest are no information."""
LEVEL = 0.95
AT_BOUND = 1e-6
"""Relative distance, in scaled values, at which a value is at its bound."""


@dataclass(frozen=True)
class Certainty:
    """Intervals, with correlations and bounds.

    Attributes
    ----------
    low, high : ndarray
        Ends of the 95 % intervals, in SI units.
    correlation : ndarray of shape (parameters, parameters)
        Correlations of the errors.
    reasons : dict
        Parameters that the data do not determine, and why.
    """

    low: Array
    high: Array
    correlation: Array
    reasons: dict[str, str]


def certainty(problem: Problem, x: Array, method: str = "jacobian", seed: int = 0) -> Certainty:
    """Return the 95 % intervals: from the Jacobian, by ``profile``, or by block ``bootstrap``."""
    linear = linearised(problem, x)
    spread, factors = covariance(linear)
    own = x[: len(problem.free)]
    blind = _blind(linear.derivatives)
    deviation = np.sqrt(np.clip(np.diag(spread), 0.0, None))
    deviation[blind] = np.inf
    low, high = own - factors * deviation, own + factors * deviation
    if method == "bootstrap":
        low, high = _bootstrap(linear, own, seed)
    elif method == "profile":
        low, high = profile(problem, x, factors * deviation, np.sqrt(np.diag(linear.white)))
    reasons = _undetermined(problem, own, low, high, blind)
    with np.errstate(invalid="ignore", divide="ignore"):
        correlation = spread / np.outer(np.sqrt(np.diag(spread)), np.sqrt(np.diag(spread)))
    outer = [(_outer(free, a), _outer(free, b)) for free, a, b in zip(problem.free, low, high, strict=True)]
    return Certainty(
        np.array([a for a, _ in outer]), np.array([b for _, b in outer]), np.nan_to_num(correlation), reasons
    )


def hidden(problem: Problem) -> dict[str, str]:
    """Return the parameters that the data hardly tell, and why, before anything is fitted.

    At the start values, they would be hidden if nothing but the noise of the sensors were left.
    """
    x = problem.start
    linear = linearised(problem, x)
    own, blind = x[: len(problem.free)], _blind(linear.derivatives)
    half = float(student.ppf(0.5 + 0.5 * LEVEL, max(1, len(linear.scores)))) * np.sqrt(np.diag(linear.white))
    half[blind] = np.inf
    return _undetermined(problem, own, own - half, own + half, blind)


@dataclass(frozen=True)
class Linearised:
    """A problem about its solution: least squares of the free parameters alone.

    Attributes
    ----------
    derivatives : ndarray of shape (samples, parameters)
        Derivatives with the start values of windows projected out, in units of the noise.
    scores : ndarray of shape (samples,)
        Residuals in the same units, of variance 1.
    blocks : ndarray of shape (samples,)
        Index of the `BLOCKS` stretches of time, for each sample.
    records : ndarray of shape (samples,)
        Index of the record, for each sample.
    """

    derivatives: Array
    scores: Array
    blocks: NDArray[np.int64]
    records: NDArray[np.int64]

    @property
    def white(self) -> Array:
        """Covariance if the residuals are independent."""
        inverse = np.linalg.pinv(triangle(self.derivatives), rcond=RANK)
        return np.asarray(inverse @ inverse.T)


def linearised(problem: Problem, x: Array) -> Linearised:
    """Return the problem about a solution."""
    derivatives, scores, blocks, records = problem.native.linearised(x)
    return Linearised(derivatives, scores, np.array(blocks, dtype=np.int64), np.array(records, dtype=np.int64))


def covariance(linear: Linearised) -> tuple[Array, Array]:
    """Return the covariance of the scaled parameters, and the factors from deviations to half intervals.

    For each parameter the widest of three intervals: for independent residuals; by a jackknife over blocks of time,
    for autocorrelated residuals; and by a jackknife over records, for records that one model does not fit together.
    """
    found, factors = _native.covariance(linear.derivatives, linear.scores, linear.blocks, linear.records)
    return found, np.array(factors)


def _outer(free: Free, inner: float) -> float:
    """Return an end of an interval in SI units, which may be infinite."""
    with np.errstate(over="ignore"):
        return float(np.exp(inner) if free.is_logarithmic else inner * free.scale)


def _blind(derivatives: Array) -> NDArray[np.bool_]:
    """Tell which parameters take part in a direction that the residuals do not see.

    It is looked for with the parameters as they are scaled, and with each in units of its own effect: only in these a
    gain of 50 and the logarithm of a mass that make up for one another take part alike.
    """
    return np.array(_native.unseen(derivatives), dtype=bool)


def at_bounds(problem: Problem, x: Array) -> dict[str, float]:
    """Return the parameters whose values have run to a bound, and the bound in SI units."""
    least, most = problem.bounds
    found = {}
    for index, free in enumerate(problem.free):
        own = problem.experiment.table.variables.get(free.name)
        physical = () if own is None else (own.minimum, own.maximum)
        for bound, outer in ((least[index], free.low), (most[index], free.high)):
            # Beyond a bound of the model is nothing, so that a value there is one like any other.
            if outer not in physical and abs(x[index] - bound) < AT_BOUND * max(1.0, abs(x[index])):
                found[free.name] = free.outer(float(bound))
    return found


def _undetermined(problem: Problem, x: Array, low: Array, high: Array, blind: NDArray[np.bool_]) -> dict[str, str]:
    reasons = {}
    bounded = at_bounds(problem, x)
    least, most = problem.bounds
    for index, free in enumerate(problem.free):
        half = 0.5 * (high[index] - low[index])
        span = most[index] - least[index]
        if blind[index] or not np.isfinite(half):
            reasons[free.name] = "the data do not change with it, or only with a combination of parameters"
        elif np.isfinite(span) and low[index] <= least[index] and high[index] >= most[index]:
            reasons[free.name] = "its interval is wider than its bounds"
        elif free.is_logarithmic and half > 1.0:
            reasons[free.name] = "its interval is wider than from a third to three times its value"
        elif not free.is_logarithmic and half > 1.0 and low[index] < free.inner(free.legal[0]):
            # The default of a parameter without a logarithm is 1, as the search sees it.
            reasons[free.name] = "its interval reaches beyond what is possible, and is wider than its usual value"
        elif free.name in bounded:
            reasons[free.name] = "it is at a bound"
    return reasons


def _bootstrap(linear: Linearised, x: Array, seed: int, number: int = 1000) -> tuple[Array, Array]:
    """Return the quantiles of one Gauss-Newton step for blocks drawn with replacement."""
    ends = np.array(_native.bootstrap(linear.derivatives, linear.scores, linear.blocks, x, seed, number))
    return ends[:, 0], ends[:, 1]
