"""Nonlinear least squares from many starts."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares
from scipy.stats import qmc

from pneumatic_servo.identification.problem import Problem

Array = NDArray[np.float64]
Tell = Callable[[str], None]

STEP = 1e-3
"""Step of the differences that make the Jacobian, in scaled parameters."""
REFINED = 3
"""How many of the best starts are refined."""
SPREAD = 1.6
"""Starts without bounds lie within a factor of five, or within so many magnitudes, of the first."""
CHUNK = 32
"""Starts that are simulated in one task."""


@dataclass(frozen=True)
class Solution:
    """The end of a refinement."""

    x: Array
    cost: float
    converged: bool
    message: str


def jacobian(problem: Problem, x: Array) -> Array:
    """Return the derivatives of the residuals by central differences within the bounds, all runs on all cores."""
    low, high = problem.bounds
    ups, downs = [], []
    for index in range(len(x)):
        step = np.zeros_like(x)
        step[index] = STEP
        ups.append(np.minimum(x + step, high))
        downs.append(np.maximum(x - step, low))
    residuals = problem.residuals([*ups, *downs])
    widths = np.array([np.sum(up - down) for up, down in zip(ups, downs, strict=True)])
    columns = (residuals[: len(x)] - residuals[len(x) :]) / widths[:, None]
    return np.ascontiguousarray(columns.T)


def refine(problem: Problem, start: Array, loss: str = "linear", tell: Tell | None = None) -> Solution:
    """Go down from a start."""
    low, high = problem.bounds
    margin = 1e-9 * (1.0 + np.abs(start))
    inside = np.clip(start, low + margin, high - margin)
    last: list[tuple[Array, Array]] = []

    def residuals(x: Array) -> Array:
        if last and np.array_equal(last[0][0], x):
            return last[0][1]
        [found] = problem.residuals([x])
        last[:] = [(x.copy(), found)]
        if tell is not None:
            tell(f"cost {np.mean(found**2):.5g}")
        return np.asarray(found)

    found: Any = least_squares(
        residuals, inside, jac=lambda x: jacobian(problem, x), bounds=(low, high), loss=loss,
        x_scale="jac", ftol=1e-7, xtol=1e-7, gtol=1e-10, max_nfev=80,
    )  # fmt: skip
    return Solution(found.x, float(found.cost), bool(found.status > 0), str(found.message))


def solve(
    problem: Problem, starts: int, seed: int, loss: str = "linear", cluster: Any = None, tell: Tell | None = None
) -> tuple[Solution, list[Solution]]:
    """Return the best solution and all that were refined.

    Starts are simulated once; the best are refined. A Dask client as `cluster` does both on its workers.
    """
    candidates = [problem.start, *scattered(problem, starts, seed)]
    chunks = [candidates[first : first + CHUNK] for first in range(0, len(candidates), CHUNK)]
    if cluster is not None:
        costs = np.concatenate(cluster.gather([cluster.submit(_costs, problem, chunk, pure=False) for chunk in chunks]))
    else:
        found = []
        for number, chunk in enumerate(chunks):
            found.append(_costs(problem, chunk))
            if tell is not None:
                tell(f"start {min((number + 1) * CHUNK, len(candidates))} of {len(candidates)}")
        costs = np.concatenate(found)
    order = np.argsort(costs, kind="stable")[: REFINED if starts else 1]
    best = list(dict.fromkeys([int(order[0]), 0, *map(int, order)]))[:REFINED]
    if cluster is not None:
        tasks = [cluster.submit(refine, problem, candidates[index], loss, pure=False) for index in best]
        solutions = list(cluster.gather(tasks))
    else:
        solutions = [refine(problem, candidates[index], loss, tell) for index in best]
    solutions.sort(key=lambda solution: (solution.cost, not solution.converged))
    return solutions[0], solutions


def scattered(problem: Problem, number: int, seed: int) -> list[Array]:
    """Return starts that fill the bounds, or the neighbourhood of the first start, evenly."""
    if number <= 0:
        return []
    low, high = problem.bounds
    first = problem.start
    least, most = np.maximum(low, first - SPREAD), np.minimum(high, first + SPREAD)
    sample = qmc.LatinHypercube(len(first), rng=np.random.default_rng(seed)).random(number)
    return [least + row * (most - least) for row in sample]


def _costs(problem: Problem, vectors: Sequence[Array]) -> Array:
    return np.asarray(np.sum(problem.residuals(vectors) ** 2, axis=1))
