"""How sure the values are: intervals, correlations, and what the data do not determine."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.stats import t as student

from pneumatic_servo.identification.parameters import Free
from pneumatic_servo.identification.problem import Problem
from pneumatic_servo.identification.solve import jacobian, refine

Array = NDArray[np.float64]

BLOCKS = 20
"""Stretches of time that count as independent."""
RANK = 1e-7
"""Singular values below this share of the largest are no information."""
LEVEL = 0.95


@dataclass(frozen=True)
class Certainty:
    """Intervals and what belongs to them.

    Attributes
    ----------
    low, high : ndarray
        Ends of the 95 % intervals, in SI units.
    correlation : ndarray of shape (parameters, parameters)
        Correlations of the errors.
    undetermined : tuple of str
        Parameters that the data do not determine.
    reasons : dict
        Why, by name.
    """

    low: Array
    high: Array
    correlation: Array
    undetermined: tuple[str, ...]
    reasons: dict[str, str]


def certainty(problem: Problem, x: Array, method: str = "jacobian", seed: int = 0) -> Certainty:
    """Return the 95 % intervals: from the Jacobian, by ``profile``, or by block ``bootstrap``."""
    derivatives = jacobian(problem, x)
    [residuals] = problem.residuals([x])
    blocks = problem.blocks(BLOCKS)
    spread, factors = covariance(derivatives, residuals, blocks)
    blind = _blind(derivatives)
    deviation = np.sqrt(np.clip(np.diag(spread), 0.0, None))
    deviation[blind] = np.inf
    low, high = x - factors * deviation, x + factors * deviation
    if method == "bootstrap":
        low, high = _bootstrap(derivatives, residuals, blocks, x, seed)
    elif method == "profile":
        low, high = _profile(problem, x, spread, factors)
    elif method != "jacobian":
        raise ValueError(f"intervals = {method}: it must be jacobian, profile or bootstrap")
    reasons = _undetermined(problem, x, low, high, blind)
    with np.errstate(invalid="ignore", divide="ignore"):
        correlation = spread / np.outer(np.sqrt(np.diag(spread)), np.sqrt(np.diag(spread)))
    outer = [(_outer(free, a), _outer(free, b)) for free, a, b in zip(problem.free, low, high, strict=True)]
    return Certainty(
        np.array([a for a, _ in outer]), np.array([b for _, b in outer]), np.nan_to_num(correlation),
        tuple(reasons), reasons,
    )  # fmt: skip


def covariance(derivatives: Array, residuals: Array, blocks: NDArray[np.int64]) -> tuple[Array, Array]:
    """Return the covariance of the scaled parameters, and the factors from deviations to half intervals.

    For each parameter the wider of two: that of independent residuals, and that of a jackknife which leaves out one
    block of time after the other, for residuals that hang together, as they do where a converter rounds a carriage at
    rest or the model is not the truth.
    """
    number, count = len(residuals), derivatives.shape[1]
    inverse = np.linalg.pinv(derivatives, rcond=RANK)
    variance = float(residuals @ residuals) / max(1, number - count)
    white = inverse @ inverse.T * variance
    groups = int(blocks[-1]) + 1 if len(blocks) else 0
    if groups <= count + 1:
        return white, np.full(count, float(student.ppf(0.5 + 0.5 * LEVEL, max(1, number - count))))
    moves = np.array([_without(derivatives, residuals, blocks == block) for block in range(groups)])
    clustered = moves.T @ moves * (groups - 1) / groups
    ratio = np.sqrt(np.diag(clustered) / np.maximum(np.diag(white), 1e-300))
    wide = np.maximum(1.0, ratio)
    freedom = np.where(ratio > 1.0, groups - 1, max(1, number - count))
    return white * np.outer(wide, wide), np.asarray(student.ppf(0.5 + 0.5 * LEVEL, freedom))


def _without(derivatives: Array, residuals: Array, block: NDArray[np.bool_]) -> Array:
    """Return by how much the parameters move if a block is left out."""
    left = derivatives[~block]
    own = derivatives[block].T @ residuals[block]
    return np.asarray(np.linalg.pinv(left.T @ left, rcond=RANK**2, hermitian=True) @ own)


def _outer(free: Free, inner: float) -> float:
    """Return an end of an interval in SI units, which may be infinite."""
    with np.errstate(over="ignore"):
        return float(np.exp(inner) if free.is_logarithmic else inner * free.scale)


def _blind(derivatives: Array) -> NDArray[np.bool_]:
    """Tell which parameters take part in a direction that the residuals do not see."""
    _, values, directions = np.linalg.svd(derivatives, full_matrices=False)
    if not len(values) or values[0] == 0.0:
        return np.ones(derivatives.shape[1], dtype=bool)
    unseen = directions[values < RANK * values[0]]
    return np.asarray(np.any(np.abs(unseen) > 0.1, axis=0))


def _undetermined(problem: Problem, x: Array, low: Array, high: Array, blind: NDArray[np.bool_]) -> dict[str, str]:
    reasons = {}
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
        elif min(x[index] - least[index], most[index] - x[index]) < 1e-6 * max(1.0, abs(x[index])):
            reasons[free.name] = "it is at a bound"
    return reasons


def _bootstrap(
    derivatives: Array, residuals: Array, blocks: NDArray[np.int64], x: Array, seed: int, number: int = 1000
) -> tuple[Array, Array]:
    """Return the quantiles of one Gauss-Newton step for blocks drawn with replacement."""
    rng = np.random.default_rng(seed)
    groups = int(blocks[-1]) + 1
    squares = np.array([derivatives[blocks == block].T @ derivatives[blocks == block] for block in range(groups)])
    slopes = np.array([derivatives[blocks == block].T @ residuals[blocks == block] for block in range(groups)])
    steps = []
    for _ in range(number):
        drawn = rng.integers(0, groups, groups)
        inverse = np.linalg.pinv(squares[drawn].sum(axis=0), rcond=RANK**2, hermitian=True)
        steps.append(-inverse @ slopes[drawn].sum(axis=0))
    ends = np.quantile(np.array(steps), [0.5 - 0.5 * LEVEL, 0.5 + 0.5 * LEVEL], axis=0)
    return x + ends[0], x + ends[1]


def _profile(problem: Problem, x: Array, spread: Array, factors: Array) -> tuple[Array, Array]:
    """Return where the cost, with everything else fitted anew, has risen as much as at the ends of the interval."""
    low, high = x.copy(), x.copy()
    least, most = problem.bounds
    [best] = problem.residuals([x])
    white = float(best @ best) / max(1, len(best) - len(x))
    derivatives = jacobian(problem, x)
    information = derivatives.T @ derivatives
    for index in range(len(x)):
        deviation = float(np.sqrt(spread[index, index]))
        # What the quadratic approximation rises by at the end of the interval.
        inverse = np.linalg.pinv(information, rcond=RANK**2, hermitian=True)[index, index]
        rise = (factors[index] * deviation) ** 2 / max(inverse, 1e-300)
        for side, ends in ((-1.0, low), (1.0, high)):
            near, far = 0.0, factors[index] * deviation
            if not np.isfinite(far) or far == 0.0:
                ends[index] = side * np.inf
                continue
            for _ in range(6):
                if _cost_at(problem, x, index, x[index] + side * far) - white * (len(best) - len(x)) >= rise:
                    break
                near, far = far, 2.0 * far
            for _ in range(8):
                middle = 0.5 * (near + far)
                over = _cost_at(problem, x, index, x[index] + side * middle) - white * (len(best) - len(x)) >= rise
                near, far = (near, middle) if over else (middle, far)
            ends[index] = np.clip(x[index] + side * far, least[index], most[index])
    return low, high


def _cost_at(problem: Problem, x: Array, index: int, inner: float) -> float:
    """Return the cost with one parameter held and the others fitted."""
    low, high = problem.bounds
    held = problem.free[index]
    value = held.outer(float(np.clip(inner, low[index], high[index])))
    others = [free for place, free in enumerate(problem.free) if place != index]
    experiment = problem.experiment.with_value(held.name, value)
    rest = replace(problem, experiment=experiment, free=tuple(others))
    if not others:
        [found] = rest.residuals([np.empty(0)])
        return float(found @ found)
    return 2.0 * refine(rest, np.delete(x, index)).cost
