"""Nonlinear least squares from many starts."""

from __future__ import annotations

from collections.abc import Sequence
from concurrent.futures import Executor, Future
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares
from scipy.stats import qmc

from pneumatic_servo.identification.compression import compressed
from pneumatic_servo.identification.problem import TOLERANCE, Problem
from pneumatic_servo.identification.sensor import Sensor
from pneumatic_servo.identification.watch import Watch
from pneumatic_servo.tasks import cancel

Array = NDArray[np.float64]

REFINED = 3
"""How many of the best starts are refined."""
SPREAD = 1.6
"""Starts without bounds lie within a factor of five, or within so many magnitudes, of the first."""
AT_NOISE = 1.5
"""Mean square of residuals, in units of the noise, at which no other start can lead to anything better."""
SAME = 1e-3
"""Relative difference of costs below which two solutions are taken for the same."""
LOOKED = 8
"""A rough search ends where so many vectors in a row have gained little."""
GAINED = 0.02
"""Share of the cost that is little."""
CHUNK = 32
"""Starts that are simulated in one task."""


@dataclass(frozen=True)
class Effort:
    """How exactly a search goes down.

    Attributes
    ----------
    cost, step : float
        Relative changes of cost and vector at which it ends.
    tolerance : float
        Relative tolerance of the solver.
    is_central : bool
        Whether derivatives are central differences, which take twice as many runs as those to one side.
    gives_up : bool
        Whether it ends as well where `LOOKED` vectors in a row have gained little, as along a valley of a model that
        does not describe the data, which leads on and on to nowhere.
    """

    cost: float
    step: float
    tolerance: float
    is_central: bool
    gives_up: bool = False


ROUGH = Effort(1e-4, 1e-5, 1e-5, is_central=False, gives_up=True)
"""For a search that another one continues."""
FINE = Effort(1e-6, 1e-8, TOLERANCE, is_central=True)
"""For the last one."""


@dataclass(frozen=True)
class Solution:
    """The end of a refinement."""

    x: Array
    cost: float
    converged: bool
    message: str


class Stalled(Exception):
    """A search that leads nowhere."""


class Course:
    """The course of a search.

    Attributes
    ----------
    best : ndarray
        Its best vector.
    cost : float
        The cost there.
    """

    def __init__(self) -> None:
        self.best: Array = np.zeros(0)
        self.cost = np.inf
        self._before: list[float] = []

    def see(self, x: Array, cost: float) -> None:
        """Take notice of a vector.

        Raises
        ------
        Stalled
            Where the last `LOOKED` vectors have gained less than the share `GAINED` together.
        """
        if cost < self.cost or not len(self.best):
            self.best, self.cost = x.copy(), cost
        self._before.append(self.cost)
        if len(self._before) > LOOKED and self.cost > (1.0 - GAINED) * self._before[-1 - LOOKED]:
            raise Stalled


def sensitivities(problem: Problem, x: Array, *, is_central: bool = True) -> tuple[Array, Array]:
    """Return the derivatives of the differences by finite differences within the bounds, and the differences.

    The runs are made at once on all cores. What windows begin with is moved in all of them together, since none sees
    that of another. Where a law refuses one side, as sliding friction beyond what breaks away, the other one tells.
    """
    moves = _moves(problem)
    low, high = problem.bounds
    ups = [np.minimum(x + problem.step * move, high) for move in moves]
    downs = [np.maximum(x - problem.step * move, low) for move in moves]
    base, *above = problem.stacked([x, *ups])
    has_above = [not np.array_equal(up, x) and not np.all(np.isnan(run)) for up, run in zip(ups, above, strict=True)]
    both = [index for index in range(len(moves)) if is_central or not has_above[index]]
    below = dict(zip(both, problem.stacked([downs[index] for index in both]), strict=True)) if both else {}
    slopes = []
    for index, (up, down) in enumerate(zip(ups, downs, strict=True)):
        first, last = (up, above[index]) if has_above[index] else (x, base)
        has_below = index in below and not (has_above[index] and np.all(np.isnan(below[index])))
        second, least = (down, below[index]) if has_below else (x, base)
        slopes.append((last - least) / np.max(first - second))
    return np.nan_to_num(_by_column(problem, np.array(slopes)), posinf=0.0, neginf=0.0), base


def jacobian(problem: Problem, x: Array, *, is_central: bool = True) -> Array:
    """Return the derivatives of the residuals."""
    slopes, differences = sensitivities(problem, x, is_central=is_central)
    return np.asarray(slopes * np.nan_to_num(problem.by_sensor(Sensor.slopes, differences))[:, None])


def _moves(problem: Problem) -> list[Array]:
    """Return the directions in which runs are made: each parameter, and each kind of beginning in all windows."""
    free = len(problem.free)
    moves = [np.arange(free + sum(problem.loose)) == index for index in range(free)]
    places = np.concatenate([np.full(free, -1), *(np.arange(count) for count in problem.loose)])
    return [move.astype(float) for move in [*moves, *(places == place for place in range(max(problem.loose)))]]


def _by_column(problem: Problem, slopes: Array) -> Array:
    """Return the derivatives, of shape (samples, vector), from those along the directions."""
    free, compared = len(problem.free), len(problem.experiment.compared)
    columns = np.zeros((slopes.shape[1], free + sum(problem.loose)))
    columns[:, :free] = slopes[:free].T
    row, column = 0, free
    for window, loose in zip(problem.windows, problem.loose, strict=True):
        last = row + window.fitted * compared
        columns[row:last, column : column + loose] = slopes[free : free + loose, row:last].T
        row, column = last, column + loose
    return columns


def refine(
    problem: Problem, start: Array, loss: str = "linear", watch: Watch | None = None, effort: Effort = FINE
) -> Solution:
    """Go down from a start."""
    problem = replace(problem, tolerance=effort.tolerance)
    low, high = problem.bounds
    margin = 1e-9 * (1.0 + np.abs(start))
    inside = np.clip(start, low + margin, high - margin)
    last: list[tuple[Array, Array]] = []
    course = Course()

    def residuals(x: Array) -> Array:
        if last and np.array_equal(last[0][0], x):
            return last[0][1]
        [of_data] = problem.residuals([x])
        found: Array = np.concatenate([of_data, problem.pulls(x)])
        last[:] = [(x.copy(), found)]
        if watch is not None:
            watch.see(x, float(np.mean(of_data**2)))
        if effort.gives_up and loss == "linear":
            course.see(x, 0.5 * float(found @ found))
        return found

    def slopes(x: Array) -> Array:
        return np.vstack([jacobian(problem, x, is_central=effort.is_central), np.diag(problem.pull)])

    # Other losses look at each residual by itself.
    function, derivatives = compressed(residuals, slopes) if loss == "linear" else (residuals, slopes)
    try:
        found: Any = least_squares(
            function, inside, jac=derivatives, bounds=(low, high), loss=loss,
            x_scale="jac", ftol=effort.cost, xtol=effort.step, gtol=1e-10, max_nfev=80,
        )  # fmt: skip
    except Stalled:
        return Solution(course.best, course.cost, False, f"{LOOKED} steps in a row have gained little")
    return Solution(found.x, float(found.cost), bool(found.status > 0), str(found.message))


def solve(
    problem: Problem, starts: int, seed: int, loss: str = "linear", executor: Executor | None = None,
    watch: Watch | None = None,
) -> tuple[Solution, list[Solution]]:  # fmt: skip
    """Return the best solution and all that were refined.

    The first start is refined; unless it leaves no more than noise, random ones are simulated, and the best of them
    refined, until one leaves no more than noise or two have come to the same end. An executor simulates
    all of them, and refines the best at once; the bits do not depend on which executor it is.
    """
    if executor is not None:
        solutions = _by(executor, problem, [problem.start, *scattered(problem, starts, seed)], loss, watch)
    else:
        solutions = [refine(problem, problem.start, loss, watch, ROUGH)]
        if starts > 0 and not _is_enough(problem, solutions):
            candidates = scattered(problem, starts, seed)
            for index in _best(_costs_told(problem, candidates, watch), REFINED - 1):
                solutions.append(refine(problem, candidates[index], loss, watch, ROUGH))
                if _is_enough(problem, solutions):
                    break
    solutions.sort(key=lambda solution: (solution.cost, not solution.converged))
    return solutions[0], solutions


def _is_enough(problem: Problem, solutions: Sequence[Solution]) -> bool:
    """Tell whether the last solution leaves no more than noise, or the two best are the same."""
    if 2.0 * solutions[-1].cost < AT_NOISE * problem.size:
        return True
    costs = sorted(solution.cost for solution in solutions)
    return len(costs) > 1 and costs[1] <= (1.0 + SAME) * costs[0]


def _best(costs: Array, number: int) -> list[int]:
    return [int(index) for index in np.argsort(costs, kind="stable")[:number]]


def _chunks(candidates: Sequence[Array]) -> list[Sequence[Array]]:
    return [candidates[first : first + CHUNK] for first in range(0, len(candidates), CHUNK)]


def _costs_told(problem: Problem, candidates: Sequence[Array], watch: Watch | None) -> Array:
    found: list[float] = []
    for chunk in _chunks(candidates):
        found.extend(_costs(problem, chunk))
        if watch is not None:
            watch.done(f"start {len(found)} of {len(candidates)}")
    return np.array(found)


def _by(
    executor: Executor, problem: Problem, candidates: Sequence[Array], loss: str, watch: Watch | None
) -> list[Solution]:
    """Let an executor simulate all candidates and refine the best of them, each by one thread."""
    own = replace(problem, workers=1)
    simulated = [executor.submit(_costs, own, chunk) for chunk in _chunks(candidates)]
    refined: list[Future[Solution]] = []
    solutions = []
    try:
        costs = np.concatenate([task.result() for task in simulated])
        best = list(dict.fromkeys([0, *_best(costs, REFINED)]))[: REFINED if len(candidates) > 1 else 1]
        if watch is not None:
            [first] = _best(costs, 1)
            watch.see(candidates[first], float(costs[first]) / problem.size)
            watch.done(f"{len(candidates)} starts are simulated, {len(best)} are refined")
        refined += [executor.submit(refine, own, candidates[index], loss, None, ROUGH) for index in best]
        for task in refined:
            solutions.append(task.result())
            if watch is not None:
                watch.see(solutions[-1].x, 2.0 * solutions[-1].cost / problem.size)
    finally:
        cancel([*simulated, *refined])
    return solutions


def scattered(problem: Problem, number: int, seed: int) -> list[Array]:
    """Return starts that fill the bounds, or the neighbourhood of the first start, evenly."""
    if number <= 0:
        return []
    low, high = problem.bounds
    first = problem.start
    spread = np.where(np.arange(len(first)) < len(problem.free), SPREAD, 0.0)
    least, most = np.maximum(low, first - spread), np.minimum(high, first + spread)
    sample = qmc.LatinHypercube(len(first), rng=np.random.default_rng(seed)).random(number)
    return [least + row * (most - least) for row in sample]


def _costs(problem: Problem, vectors: Sequence[Array]) -> Array:
    problem = replace(problem, tolerance=ROUGH.tolerance)
    return np.asarray(np.sum(problem.residuals(vectors) ** 2, axis=1))
