"""Many runs of one model: here on all cores, or in pieces by an executor, with the same bits either way."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import Executor, Future, wait
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from pneumatic_servo import _native
from pneumatic_servo.tasks import cancel, is_finished
from pneumatic_servo.variables import Value

Array = NDArray[np.float64]
Courses = float | Array | tuple[Array, Array]
LOOK = 0.1
"""How often in s it is looked which pieces are done."""
PIECES = 64
"""Into so many pieces at most the work of an executor is cut: as many as there may well be workers, few to send."""


@dataclass(frozen=True)
class Work:
    """Runs to be made; it can be pickled.

    Attributes
    ----------
    model : str
        The model.
    shared : dict
        Settings of all runs.
    runs : list of dict
        Settings of each.
    inputs : dict
        Inputs by name: a constant, one per run, or times and rows.
    grid : tuple
        Start, step, number of steps, and steps per row.
    outputs : list of str
        What is recorded.
    most : int or None
        Solver steps, rejected ones included, after which a run is given up.
    """

    model: str
    shared: Mapping[str, Value]
    runs: Sequence[Mapping[str, Value]]
    inputs: Mapping[str, Courses]
    grid: tuple[float, float, int, int]
    outputs: Sequence[str]
    most: int | None = None

    def part(self, first: int, last: int) -> Work:
        """Return the runs from one number up to another."""
        return replace(
            self,
            runs=self.runs[first:last],
            inputs={name: _part(course, first, last, len(self.runs)) for name, course in self.inputs.items()},
        )

    def make(self, threads: int, progress: Callable[[int], None] | None = None) -> Done:
        """Make the runs on threads of this process."""
        values, reached, ended, noticed = _native.simulate_many(
            _native.Model(self.model),
            list(self.shared.items()),
            [list(settings.items()) for settings in self.runs],
            [(name, _aligned(course)) for name, course in self.inputs.items()],
            self.grid,
            list(self.outputs),
            threads,
            progress,
            self.most,
        )
        rows = np.array([count for count, _ in reached], dtype=np.int64)
        failures = {run: failure for run, (_, failure) in enumerate(reached) if failure is not None}
        return Done(values, rows, failures, ended, [(run, *notice) for run, notice in noticed])

    def make_by(self, executor: Executor, progress: Callable[[int], None] | None = None) -> Done:
        """Let an executor make the runs, in pieces of which each is made by one thread.

        An interrupt keeps the pieces that are done.
        """
        size = max(1, -(-len(self.runs) // PIECES))
        places = [(first, min(first + size, len(self.runs))) for first in range(0, len(self.runs), size)]
        tasks = [executor.submit(_make, self.part(first, last)) for first, last in places]
        try:
            _wait(tasks, [last - first for first, last in places], progress)
        except KeyboardInterrupt as interrupt:
            return self._joined(places, [task.result() if is_finished(task) else None for task in tasks], interrupt)
        finally:
            cancel(tasks)
        pieces = [task.result() for task in tasks]
        return self._joined(places, pieces, next((piece.ended for piece in pieces if piece.ended is not None), None))

    def _joined(
        self, places: Sequence[tuple[int, int]], pieces: Sequence[Done | None], ended: BaseException | None
    ) -> Done:
        """Put the pieces together that there are."""
        rows = -(-self.grid[2] // self.grid[3]) + 1
        whole = Done(
            np.full((len(self.runs), len(self.outputs), rows), np.nan),
            np.zeros(len(self.runs), np.int64),
            {},
            ended,
            [],
        )
        for (first, last), done in zip(places, pieces, strict=True):
            if done is None:
                continue
            whole.values[first:last] = done.values
            whole.rows[first:last] = done.rows
            whole.failures.update({first + run: failure for run, failure in done.failures.items()})
            known = {name for _, name, _, _ in whole.noticed}
            whole.noticed.extend(
                (first + run, name, value, remark) for run, name, value, remark in done.noticed if name not in known
            )
        return whole


@dataclass(frozen=True)
class Done:
    """Runs that were made.

    Attributes
    ----------
    values : ndarray of shape (runs, outputs, rows)
        What was recorded.
    rows : ndarray of shape (runs,)
        How many rows of each run.
    failures : dict
        Why runs stopped early, by their number.
    ended : exception or None
        What ended all of them.
    noticed : list of tuple
        What was unusual: run, variable, value and remark.
    """

    values: Array
    rows: NDArray[np.int64]
    failures: dict[int, str]
    ended: BaseException | None
    noticed: list[tuple[int, str, float, str]]


def _make(work: Work) -> Done:
    return work.make(1)


def _wait(tasks: Sequence[Future[Done]], sizes: Sequence[int], progress: Callable[[int], None] | None) -> None:
    """Wait until all are done.

    Raises
    ------
    KeyboardInterrupt
        Here, or in a worker: a terminal interrupts both, and a worker may be the first to tell.
    Exception
        Whatever a task has raised.
    """
    left = set(tasks)
    while left:
        _, left = wait(left, timeout=LOOK)
        if progress is not None:
            progress(sum(size for task, size in zip(tasks, sizes, strict=True) if task.done()))
        failures = [failure for task in tasks if task.done() and (failure := task.exception()) is not None]
        if any(isinstance(failure, KeyboardInterrupt) for failure in failures):
            raise KeyboardInterrupt
        if failures:
            raise failures[0]


def _aligned(course: Courses) -> Courses:
    """Return a course as the extension module reads it: arrays that came over a wire may lie anywhere in memory."""
    if isinstance(course, tuple):
        times, rows = course
        return np.require(times, requirements=("C", "A")), np.require(rows, requirements=("C", "A"))
    return np.require(course, requirements=("C", "A")) if isinstance(course, np.ndarray) else course


def _part(course: Courses, first: int, last: int, number: int) -> Courses:
    if isinstance(course, tuple):
        times, rows = course
        return times, rows if len(rows) != number else np.ascontiguousarray(rows[first:last])
    return np.ascontiguousarray(course[first:last]) if isinstance(course, np.ndarray) else course
