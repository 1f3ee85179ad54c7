"""Confidence intervals, correlations, and parameters that are not identifiable."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pneumatic_servo import _native
from pneumatic_servo.identification.compression import triangle
from pneumatic_servo.identification.fitted import Estimate
from pneumatic_servo.identification.problem import Problem

Array = NDArray[np.float64]

RANK = 1e-7
"""Singular values below this share of the largest are no information."""
LEVEL = 0.95


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
    ties : dict
        Parameters that follow from others, whose errors those of the estimated ones make in proportion.
    """

    low: Array
    high: Array
    correlation: Array
    reasons: dict[str, str]
    ties: dict[str, Estimate]


def certainty(problem: Problem, x: Array, method: str = "jacobian", seed: int = 0) -> Certainty:
    """Return the 95 % intervals: from the Jacobian, by ``profile``, or by block ``bootstrap``."""
    low, high, correlation, reasons, tied = problem.native.certainty(x, method, seed)
    ties = {tie.name: Estimate(*ends, tie.unit) for tie, ends in zip(problem.experiment.ties, tied, strict=True)}
    return Certainty(low, high, correlation, dict(reasons), ties)


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
        Index of the block of time, for each sample.
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
