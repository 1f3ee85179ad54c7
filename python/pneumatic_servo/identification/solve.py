"""Bounded nonlinear least squares from many starts: the search of the crate `fit`."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from concurrent import futures
from concurrent.futures import Executor, Future
from dataclasses import dataclass, replace
from functools import partial
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from pneumatic_servo import _native
from pneumatic_servo.identification.problem import Problem
from pneumatic_servo.identification.records import Record
from pneumatic_servo.identification.sensor import Sensor
from pneumatic_servo.identification.watch import Watch
from pneumatic_servo.tasks import cancel

Array = NDArray[np.float64]

REFINED = _native.REFINED
"""Number of the best starts that are refined."""
LOOK = 0.1
"""Interval in s between two looks for an interrupt while an executor works."""
CHUNK = 32
"""Starts that are simulated in one task."""


@dataclass(frozen=True)
class Solution:
    """The end of a refinement."""

    x: Array
    cost: float
    converged: bool
    message: str


def sensitivities(problem: Problem, x: Array, *, is_central: bool = True) -> tuple[Array, Array]:
    """Return the derivatives of the differences within the bounds, and the differences."""
    return problem.native.sensitivities(x, is_central, False)


def jacobian(problem: Problem, x: Array, *, is_central: bool = True) -> Array:
    """Return the derivatives of the residuals."""
    return problem.native.sensitivities(x, is_central, True)[0]


def refine(problem: Problem, start: Array, loss: str = "linear") -> Solution:
    """Go down from a start, as accurately as for a search that another one continues."""
    return Solution(*problem.native.refine(start, loss))


class Reached(NamedTuple):
    """How far a search has come.

    Attributes
    ----------
    problem, fitted : Problem
        The problem with validation data, and without them: its vector is searched.
    best : Solution or None
        The end of the search, or the best until it was interrupted.
    is_interrupted : bool
        Whether it was.
    """

    problem: Problem
    fitted: Problem
    best: Solution | None
    is_interrupted: bool


def search(
    problem: Problem, records: Sequence[Record], validation: float, extra: Sequence[Record], starts: int, seed: int,
    loss: str, executor: Executor | None, watch: Watch,
) -> Reached | None:  # fmt: skip
    """Search from starts that the data tell; return how far it has come, or nothing if it was interrupted at once.

    The data choose how measured forces are used, as far as the options leave it to them. An executor simulates all
    starts, and refines the best of them at once; the bits do not depend on which executor it is.
    """
    names = list(dict.fromkeys(record.name for record in [*records, *extra]))
    shares = [validation] * len(records) + [1.0] * len(extra)
    sources = [(record.name, record.numbers, names.index(record.name), share)
               for record, share in zip([*records, *extra], shares, strict=True)]  # fmt: skip
    solver = None if executor is None else partial(_by, executor, seed, loss, watch)
    notes = list(problem.experiment.notes)
    told = problem.native.search(sources, notes, starts, seed, loss, watch, watch.every, solver)
    if told is None:
        return None
    length, inputs, smoothing = told["options"]
    experiment = problem.experiment.with_options(window=length, inputs=inputs, smoothing=smoothing)
    if experiment.options != problem.experiment.options:
        problem = replace(problem, windows=Problem.of(experiment, records, problem.free, validation, extra).windows,
                          experiment=experiment)  # fmt: skip
    problem.experiment.notes[:] = told["notes"]
    choices = told["choices"]
    before, after = (
        {name: Sensor(*own) for name, own in zip(problem.experiment.compared, sensors, strict=True)}
        for sensors in told["sensors"]
    )
    problem = replace(
        problem, free=problem.limited(told["parameters"]), sensors=before, step=choices["step"],
        exactness=choices["exactness"], other_form=told["other_form"],
        windows=tuple(replace(window, begin=replace(window.begin, values=values))
                      for window, values in zip(problem.windows, told["begins"], strict=True)),
    )  # fmt: skip
    fitted = replace(problem.trained().seen_by(after), most=choices["most"])
    best = None if told["best"] is None else Solution(*told["best"])
    return Reached(problem, fitted, best, told["is_interrupted"])


def _chunks(candidates: Sequence[Array]) -> list[Sequence[Array]]:
    return [candidates[first : first + CHUNK] for first in range(0, len(candidates), CHUNK)]


def _by(
    executor: Executor, seed: int, loss: str, watch: Watch,
    problem: _native.LeastSquares, starts: int, is_halted: Callable[[], bool],
) -> tuple[Array, float, bool, str, bool]:  # fmt: skip
    """Let an executor simulate all starts and refine the best of them, each by one thread.

    Returns the best solution, and whether it was interrupted before it had all of them.
    """
    candidates, size = [problem.start(), *problem.scattered(starts, seed)], problem.size()
    simulated = [executor.submit(_costs, problem, chunk) for chunk in _chunks(candidates)]
    refined: list[Future[tuple[Array, float, bool, str]]] = []
    solutions: list[tuple[Array, float, bool, str]] = []
    is_interrupted = False
    try:
        costs = np.concatenate([_result(task, is_halted) for task in simulated])
        order = [int(index) for index in np.argsort(costs, kind="stable")]
        best = list(dict.fromkeys([0, *order[:REFINED]]))[: REFINED if len(candidates) > 1 else 1]
        solutions = [(candidates[order[0]], 0.5 * float(costs[order[0]]), False, "it is a start")]
        watch.see(float(costs[order[0]]) / size)
        watch.done(f"{len(candidates)} starts are simulated, {len(best)} are refined")
        refined += [executor.submit(_refined, problem, candidates[index], loss) for index in best]
        ends: list[tuple[Array, float, bool, str]] = []
        for task in refined:
            ends.append(_result(task, is_halted))
            solutions = ends
            watch.see(2.0 * ends[-1][1] / size)
    except KeyboardInterrupt:
        if not solutions:
            raise
        is_interrupted = True
    except futures.BrokenExecutor:
        # A terminal interrupts the workers, too, which may end before the interrupt is noticed here.
        time.sleep(LOOK)
        if not solutions or not is_halted():
            raise
        is_interrupted = True
    finally:
        cancel([*simulated, *refined])
    return *min(solutions, key=lambda solution: (solution[1], not solution[2])), is_interrupted


def _result(task: Future[Any], is_halted: Callable[[], bool]) -> Any:
    """Wait for a task, unless an interrupt comes first."""
    while True:
        try:
            return task.result(timeout=LOOK)
        except futures.TimeoutError:
            if task.done():
                raise
            if is_halted():
                raise KeyboardInterrupt from None


def _costs(problem: _native.LeastSquares, vectors: Sequence[Array]) -> Array:
    return np.array(problem.costs(list(vectors)))


def _refined(problem: _native.LeastSquares, start: Array, loss: str) -> tuple[Array, float, bool, str]:
    return problem.refine(start, loss)
