"""Many runs of one model: here on all cores, or in pieces by an executor, with the same bits either way."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import Executor, Future, wait
from dataclasses import dataclass, field, replace
from reprlib import repr as shortened
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pneumatic_servo import _native
from pneumatic_servo.run import Runs
from pneumatic_servo.tasks import cancel, is_finished
from pneumatic_servo.variables import Value

Array = NDArray[np.float64]
Courses = float | Array | tuple[Array, Array]
LOOK = 0.1
"""Interval in s of checks for finished pieces."""
PIECES = 64
"""Most pieces of the work of an executor: enough for many workers, few to send."""


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
        Recorded outputs.
    most : int or None
        Solver steps, rejected ones included, after which a run is given up.
    lines : bool
        Whether inputs run on straight lines from each communication point to the next; otherwise they are held.
    """

    model: str
    shared: Mapping[str, Value]
    runs: Sequence[Mapping[str, Value]]
    inputs: Mapping[str, Courses]
    grid: tuple[float, float, int, int]
    outputs: Sequence[str]
    most: int | None = None
    lines: bool = False

    def part(self, numbers: Sequence[int]) -> Work:
        """Return the runs of some numbers."""
        return replace(
            self,
            runs=[self.runs[number] for number in numbers],
            inputs={name: _part(course, numbers, len(self.runs)) for name, course in self.inputs.items()},
        )

    def beside(self, earlier: Runs, make: Callable[[Work], Done]) -> Done:
        """Make the runs that are not among earlier ones of the same work, and put all of them together.

        Raises
        ------
        ValueError
            When the earlier runs differ from these; the message names the difference.
        """
        missing = self.missing(earlier)
        whole = Done(earlier._values.copy(), earlier.rows.copy(), dict(earlier.failures), None, [])
        if not missing:
            return whole
        done = make(self.part(missing))
        whole.values[missing] = done.values
        whole.rows[missing] = done.rows
        whole.failures.update({missing[run]: failure for run, failure in done.failures.items()})
        whole.noticed.extend((missing[run], name, value, remark) for run, name, value, remark in done.noticed)
        return replace(whole, ended=done.ended, extremes=done.extremes)

    def missing(self, earlier: Runs) -> list[int]:
        """Return the numbers of the runs that earlier ones of the same work did not finish."""
        check_same(earlier, [{**self.shared, **own} for own in self.runs], self.outputs)
        if earlier._controlled is not None:
            raise ValueError("resume: the earlier runs had a controller, and here is none")
        _, step, count, every = self.grid
        rows = -(-count // every) + 1
        if len(earlier.time) != rows or (count and abs(earlier.time[-1] - self.grid[0] - count * step) > 0.5 * step):
            raise ValueError(
                f"resume: the earlier runs have {len(earlier.time)} rows up to {earlier.time[-1]:g} s, these {rows} up "
                f"to {self.grid[0] + count * step:g} s"
            )
        check_same_inputs(earlier, self.inputs)
        if earlier._lines != self.lines:
            ways = ("held over each step", "on straight lines")
            raise ValueError(
                f"resume: inputs of the earlier runs are {ways[earlier._lines]}, and these are {ways[self.lines]}"
            )
        return unfinished(earlier)

    def make(self, threads: int, progress: Callable[[int], None] | None = None) -> Done:
        """Make the runs on threads of this process."""
        values, reached, ended, noticed = _native.simulate_many(
            _native.Model(self.model),
            list(self.shared.items()),
            [list(settings.items()) for settings in self.runs],
            [(name, aligned(course)) for name, course in self.inputs.items()],
            self.grid,
            list(self.outputs),
            threads,
            progress,
            self.most,
            self.lines,
        )
        return Done.of(values, reached, ended, noticed)

    def make_by(self, executor: Executor, progress: Callable[[int], None] | None = None) -> Done:
        """Let an executor make the runs, in pieces of which each is made by one thread.

        An interrupt keeps the pieces that are done.
        """
        size = max(1, -(-len(self.runs) // PIECES))
        places = [(first, min(first + size, len(self.runs))) for first in range(0, len(self.runs), size)]
        tasks = [executor.submit(_make, self.part(range(first, last))) for first, last in places]
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
            widened(whole.extremes, done.extremes)
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
        Recorded outputs.
    rows : ndarray of shape (runs,)
        Number of rows of each run.
    failures : dict
        Why runs stopped early, by their number.
    ended : exception or None
        Exception that ended all runs.
    noticed : list of tuple
        Warnings: run, variable, value and remark.
    extremes : dict
        Least and largest value of each input of the plant, where a controller sets some.
    """

    values: Array
    rows: NDArray[np.int64]
    failures: dict[int, str]
    ended: BaseException | None
    noticed: list[tuple[int, str, float, str]]
    extremes: dict[str, tuple[float, float]] = field(default_factory=dict)

    @classmethod
    def of(
        cls, values: Array, reached: Sequence[tuple[int, str | None]], ended: BaseException | None,
        noticed: Sequence[tuple[int, tuple[str, float, str]]],
        extremes: Mapping[str, tuple[float, float]] | None = None,
    ) -> Done:  # fmt: skip
        """Return runs as the extension module tells them."""
        rows = np.array([count for count, _ in reached], dtype=np.int64)
        failures = {run: failure for run, (_, failure) in enumerate(reached) if failure is not None}
        return cls(
            values, rows, failures, ended, [(run, *notice) for run, notice in noticed], dict(extremes or {})
        )  # fmt: skip


def widened(extremes: dict[str, tuple[float, float]], others: Mapping[str, tuple[float, float]]) -> None:
    """Widen the ranges of inputs by those of other runs."""
    for name, (low, high) in others.items():
        least, most = extremes.get(name, (low, high))
        extremes[name] = min(low, least), max(high, most)


def _make(work: Work) -> Done:
    return work.make(1)


def _wait(tasks: Sequence[Future[Done]], sizes: Sequence[int], progress: Callable[[int], None] | None) -> None:
    """Wait until all are done.

    Raises
    ------
    KeyboardInterrupt
        Here, or in a worker: a terminal interrupts both, and a worker may be the first to tell.
    Exception
        The exception of a task.
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


def aligned(course: Courses) -> Courses:
    """Return a course as the extension module reads it: arrays that came over a wire may lie anywhere in memory."""
    if isinstance(course, tuple):
        times, rows = course
        return np.require(times, requirements=("C", "A")), np.require(rows, requirements=("C", "A"))
    return np.require(course, requirements=("C", "A")) if isinstance(course, np.ndarray) else course


def _part(course: Courses, numbers: Sequence[int], count: int) -> Courses:
    if isinstance(course, tuple):
        times, rows = course
        return times, rows if len(rows) != count else np.ascontiguousarray(rows[list(numbers)])
    return np.ascontiguousarray(course[list(numbers)]) if isinstance(course, np.ndarray) else course


def _is_same(one: Courses, other: Courses) -> bool:
    before, now = _arrays(one), _arrays(other)
    return len(before) == len(now) and all(np.array_equal(*pair) for pair in zip(before, now, strict=True))


def _arrays(course: Courses) -> tuple[Any, ...]:
    return course if isinstance(course, tuple) else (course,)


def check_same(earlier: Runs, runs: Sequence[Mapping[str, Value]], outputs: Sequence[str]) -> None:
    """Refuse runs of another study, and name the difference."""
    if not isinstance(earlier, Runs):
        raise TypeError(f"resume must be the `finished` of runs that were interrupted, not {shortened(earlier)}")
    if list(earlier.variables) != list(outputs):
        raise ValueError(f"resume: the earlier runs recorded {', '.join(earlier.variables)}, not {', '.join(outputs)}")
    if len(earlier) != len(runs):
        raise ValueError(f"resume: there are {len(earlier)} earlier runs, but {len(runs)} here")
    for number, (before, now) in enumerate(zip(earlier._settings, runs, strict=True)):
        for name in dict.fromkeys([*now, *before]):
            if before.get(name) != now.get(name):
                had, has = (own.get(name, "not given") for own in (before, now))
                raise ValueError(f"resume: {name} of run {number} was {had}, and here it is {has}")


def check_same_inputs(earlier: Runs, inputs: Mapping[str, Courses]) -> None:
    """Refuse runs with other inputs, and name the input."""
    before = earlier.inputs or {}
    for name in dict.fromkeys([*inputs, *before]):
        if name not in before or name not in inputs or not _is_same(before[name], inputs[name]):
            raise ValueError(f"resume: the input {name} of the earlier runs is another one")


def unfinished(earlier: Runs) -> list[int]:
    """Return the numbers of runs that did not come to their end, and may: those that failed would fail again."""
    return [int(run) for run in np.flatnonzero(~earlier.is_complete) if run not in earlier.failures]
