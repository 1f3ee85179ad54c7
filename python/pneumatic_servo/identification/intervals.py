"""Confidence intervals, correlations, and parameters that are not identifiable."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pneumatic_servo import _native
from pneumatic_servo.identification.compression import triangle
from pneumatic_servo.identification.problem import Problem
from pneumatic_servo.identification.profile import profile

Array = NDArray[np.float64]

BLOCKS = 20
"""Stretches of time that count as independent."""
RANK = 1e-7
"""Singular values below this share of the largest are no information."""
LEVEL = 0.95
DRAWS = 1000
"""Draws of the bootstrap."""


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
    ends = None
    if method == "profile":
        linear = linearised(problem, x)
        spread, factors = covariance(linear)
        deviation = np.sqrt(np.clip(np.diag(spread), 0.0, None))
        deviation[np.array(_native.unseen(linear.derivatives), dtype=bool)] = np.inf
        ends = np.transpose(profile(problem, x, factors * deviation, np.sqrt(np.diag(linear.white)))).tolist()
    draws = DRAWS if method == "bootstrap" else None
    low, high, correlation, reasons = problem.native.certainty(x, seed, draws, ends)
    return Certainty(low, high, correlation, dict(reasons))


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
