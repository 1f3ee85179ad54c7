"""Bounded nonlinear least squares from many starts: the search of the crate `fit`."""

from __future__ import annotations

from collections.abc import Sequence
from concurrent.futures import Executor, Future
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from pneumatic_servo.identification.problem import TOLERANCE, Problem
from pneumatic_servo.identification.sensor import Sensor
from pneumatic_servo.identification.watch import Watch
from pneumatic_servo.tasks import cancel

Array = NDArray[np.float64]

REFINED = 3
"""Number of the best starts that are refined."""
AT_NOISE = 1.5
"""Mean square of residuals, in units of the noise, at which no other start can lead to anything better."""
CHUNK = 32
"""Starts that are simulated in one task."""


@dataclass(frozen=True)
class Effort:
    """Accuracy of a search.

    Attributes
    ----------
    cost, step : float
        Relative changes of cost and vector at which it ends.
    tolerance : float
        Relative tolerance of the solver.
    is_central : bool
        Whether derivatives are central differences, which take twice as many runs as those to one side.
    gives_up : bool
        Whether it ends as well where several vectors in a row have gained little, as along a valley of a model that
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


def sensitivities(problem: Problem, x: Array, *, is_central: bool = True) -> tuple[Array, Array]:
    """Return the derivatives of the differences within the bounds, and the differences."""
    return problem.native.sensitivities(x, problem.tolerance, is_central, False)


def jacobian(problem: Problem, x: Array, *, is_central: bool = True) -> Array:
    """Return the derivatives of the residuals."""
    return problem.native.sensitivities(x, problem.tolerance, is_central, True)[0]


def refine(
    problem: Problem, start: Array, loss: str = "linear", watch: Watch | None = None, effort: Effort = FINE
) -> Solution:
    """Go down from a start."""
    own = (effort.cost, effort.step, effort.tolerance, effort.is_central, effort.gives_up)
    return Solution(*problem.native.refine(start, loss, own, None if watch is None else watch.see))


def solve(
    problem: Problem, starts: int, seed: int, loss: str = "linear", executor: Executor | None = None,
    watch: Watch | None = None,
) -> Solution:  # fmt: skip
    """Return the best solution.

    The first start is refined; unless it leaves no more than noise, random ones are simulated, and the best of them
    refined, until one leaves no more than noise or two have come to the same end. An executor simulates
    all of them, and refines the best at once; the bits do not depend on which executor it is.
    """
    if executor is not None:
        return _by(executor, problem, [problem.start, *problem.native.scattered(starts, seed)], loss, watch)
    see, done = (None, None) if watch is None else (watch.see, watch.done)
    return Solution(*problem.native.solve(starts, seed, loss, see, done))


def with_likely_sensors(
    problem: Problem, best: Solution, loss: str = "linear", watch: Watch | None = None
) -> tuple[Problem, Solution]:
    """Weigh the signals by what remains of them, and fit anew, until both agree.

    A signal that the model misses must not drown the others, and a converter is only known once the rest is.
    """
    see, stage = (None, None) if watch is None else (watch.see, watch.stage)
    numbers, found = problem.native.weighed(best.x, best.cost, loss, see, stage)
    sensors = {name: Sensor(*own) for name, own in zip(problem.experiment.compared, numbers, strict=True)}
    return problem.seen_by(sensors), Solution(*found)


def _best(costs: Array, number: int) -> list[int]:
    return [int(index) for index in np.argsort(costs, kind="stable")[:number]]


def _chunks(candidates: Sequence[Array]) -> list[Sequence[Array]]:
    return [candidates[first : first + CHUNK] for first in range(0, len(candidates), CHUNK)]


def _by(executor: Executor, problem: Problem, candidates: Sequence[Array], loss: str, watch: Watch | None) -> Solution:
    """Let an executor simulate all candidates and refine the best of them, each by one thread."""
    own = replace(problem, workers=1)
    simulated = [executor.submit(_costs, own, chunk) for chunk in _chunks(candidates)]
    refined: list[Future[Solution]] = []
    solutions = []
    try:
        costs = np.concatenate([task.result() for task in simulated])
        best = list(dict.fromkeys([0, *_best(costs, REFINED)]))[: REFINED if len(candidates) > 1 else 1]
        if watch is not None:
            first = _best(costs, 1)[0]
            watch.see(candidates[first], float(costs[first]) / problem.size)
            watch.done(f"{len(candidates)} starts are simulated, {len(best)} are refined")
        refined += [executor.submit(refine, own, candidates[index], loss, None, ROUGH) for index in best]
        for task in refined:
            solutions.append(task.result())
            if watch is not None:
                watch.see(solutions[-1].x, 2.0 * solutions[-1].cost / problem.size)
    finally:
        cancel([*simulated, *refined])
    return min(solutions, key=lambda solution: (solution.cost, not solution.converged))


def _costs(problem: Problem, vectors: Sequence[Array]) -> Array:
    return np.array(problem.native.costs(list(vectors)))
