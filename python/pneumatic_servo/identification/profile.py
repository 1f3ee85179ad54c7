"""Intervals by profile: how far a parameter can be moved if everything else is fitted anew."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from pneumatic_servo.identification.problem import Problem
from pneumatic_servo.identification.solve import refine

Array = NDArray[np.float64]

DOUBLINGS = 6
"""Doublings of the distance in the search for an end."""
HALVINGS = 6
"""Halvings of the distance of an end between two that enclose it."""


def profile(problem: Problem, x: Array, half: Array, white: Array) -> tuple[Array, Array]:
    """Return the ends of intervals, in scaled parameters, at which the cost has risen as it does at given ones.

    Parameters
    ----------
    problem : Problem
        The problem.
    x : ndarray
        Its solution.
    half : ndarray of shape (parameters,)
        Half intervals from the Jacobian.
    white : ndarray of shape (parameters,)
        Standard deviations with which one unit of cost goes along.
    """
    ends = np.array([
        [_end(problem, x, index, side * half[index], float((half[index] / white[index]) ** 2)) for side in (-1.0, 1.0)]
        for index in range(len(problem.free))
    ])  # fmt: skip
    low, high = (bound[: len(problem.free)] for bound in problem.bounds)
    return np.clip(ends[:, 0], low, high), np.clip(ends[:, 1], low, high)


def _end(problem: Problem, x: Array, index: int, first: float, rise: float) -> float:
    """Return where the cost has risen by so much, from a first distance on."""
    if not np.isfinite(first) or first == 0.0:
        return float(np.sign(first) * np.inf)
    [residuals] = problem.residuals([x])
    pulls = np.delete(problem.pulls(x), index)
    limit = float(residuals @ residuals + pulls @ pulls) + rise
    near, far = 0.0, first
    for _ in range(DOUBLINGS):
        if _cost(problem, x, index, x[index] + far) >= limit:
            break
        near, far = far, 2.0 * far
    else:
        return float(np.sign(first) * np.inf)
    for _ in range(HALVINGS):
        middle = 0.5 * (near + far)
        near, far = (near, middle) if _cost(problem, x, index, x[index] + middle) >= limit else (middle, far)
    return float(x[index] + far)


def _cost(problem: Problem, x: Array, index: int, inner: float) -> float:
    """Return the cost with one parameter held and everything else fitted."""
    low, high = problem.bounds
    if not low[index] <= inner <= high[index]:
        return np.inf
    held = problem.free[index]
    others = problem.free[:index] + problem.free[index + 1 :]
    rest = replace(problem, experiment=problem.experiment.with_value(held.name, held.outer(inner)), free=others)
    start = np.delete(x, index)
    if not len(start):
        [residuals] = rest.residuals([start])
        return float(residuals @ residuals)
    return 2.0 * refine(rest, start).cost
