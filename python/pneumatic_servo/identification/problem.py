"""A problem: data, what is given, what is compared, what is free."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from pneumatic_servo.identification.experiments import Experiment, Window
from pneumatic_servo.identification.parameters import Free
from pneumatic_servo.identification.records import Record
from pneumatic_servo.identification.smoothing import noise
from pneumatic_servo.variables import Value

Array = NDArray[np.float64]

TOLERANCE = 1e-6
"""Relative tolerance of the solver, so that differences of runs are differences of parameters."""

FAILED = 1e3
"""Residual, in units of the noise, where a simulation could not go on."""


@dataclass(frozen=True)
class Problem:
    """Data, experiment and free parameters; the solver sees a vector of scaled parameters.

    Attributes
    ----------
    experiment : Experiment
        Which model is run, with which inputs.
    windows : tuple of Window
        The measured stretches.
    free : tuple of Free
        What is fitted.
    noises : dict
        Standard deviation that each compared signal is weighted with.
    """

    experiment: Experiment
    windows: tuple[Window, ...]
    free: tuple[Free, ...]
    noises: Mapping[str, float]
    workers: int | None = None
    refusals: list[str] = field(default_factory=list, compare=False)
    """Why a single vector could not be simulated, last time."""

    @staticmethod
    def of(
        experiment: Experiment,
        records: Sequence[Record],
        free: Sequence[Free],
        hold_out: float,
        extra: Sequence[Record] = (),
    ) -> Problem:
        """Cut the records into windows; the last part of each, and the extra records, are held out."""
        windows = []
        for record in [*records, *extra]:
            share = 1.0 if any(record is other for other in extra) else hold_out
            limit = record.time[-1] * (1.0 - share) if share > 0.0 else np.inf
            for part in experiment.windows(record):
                driven, used = experiment.prepare(part)
                held = part.time + part.begin - record.begin > limit if share < 1.0 else np.ones_like(used)
                windows.append(Window(part, driven, held, used))
        noises = {signal: _noise(windows, signal) for signal in experiment.compared}
        return Problem(experiment, tuple(windows), tuple(free), noises)

    def values(self, x: Array) -> dict[str, float]:
        """Return the values of the free parameters by name."""
        fitted = {free.name: free.outer(float(inner)) for free, inner in zip(self.free, x, strict=True)}
        return {**self.experiment.held, **fitted}

    @property
    def start(self) -> Array:
        """The start values as the solver sees them."""
        return np.array([free.inner(free.start) for free in self.free])

    @property
    def bounds(self) -> tuple[Array, Array]:
        """The bounds as the solver sees them."""
        low = [_bound(free, free.low) for free in self.free]
        high = [_bound(free, free.high) for free in self.free]
        return np.array(low), np.array(high)

    def weighted(self, noises: Mapping[str, float]) -> Problem:
        """Return the same problem with other weights."""
        return replace(self, noises=dict(noises))

    def trained(self) -> Problem:
        """Return the same problem without what is held out, which the fit need not simulate."""
        return replace(self, windows=tuple(cut for window in self.windows if (cut := _cut(window)) is not None))

    def with_free(self, free: Sequence[Free]) -> Problem:
        """Return the same problem with other free parameters."""
        return replace(self, free=tuple(free))

    def differences(self, vectors: Sequence[Array]) -> list[list[dict[str, Array]]]:
        """Return measured minus simulated for each vector and window, by signal; NaN where a run failed."""
        every = [self.values(x) for x in vectors]
        found: list[list[dict[str, Array]]] = [[{} for _ in self.windows] for _ in every]
        for group in self._groups():
            self._simulate(group, every, found)
        return found

    def residuals(self, vectors: Sequence[Array], *, held: bool = False) -> Array:
        """Return the weighted residuals of vectors, of shape (vectors, residuals)."""
        rows = []
        for differences in self.differences(vectors):
            parts = [
                difference[signal][window.used & (window.held == held)] / self.noises[signal]
                for window, difference in zip(self.windows, differences, strict=True)
                for signal in self.experiment.compared
            ]
            rows.append(np.concatenate(parts))
        return np.asarray(np.nan_to_num(np.array(rows), nan=FAILED, posinf=FAILED, neginf=-FAILED))

    def rms(self, x: Array, *, held: bool = False) -> dict[str, float]:
        """Return the rms of measured minus simulated by signal; empty if there are no such samples."""
        [differences] = self.differences([x])
        found = {}
        for signal in self.experiment.compared:
            parts = [
                difference[signal][window.used & (window.held == held)]
                for window, difference in zip(self.windows, differences, strict=True)
            ]
            every = np.concatenate(parts)
            if len(every):
                found[signal] = float(np.sqrt(np.mean(every**2)))
        return found

    def blocks(self, number: int) -> NDArray[np.int64]:
        """Return the number of the block of each residual: stretches of time, all signals of a stretch together."""
        total = sum(int(np.sum(window.used & ~window.held)) for window in self.windows)
        size = max(1, -(-total // number))
        blocks, before = [], 0
        for window in self.windows:
            count = int(np.sum(window.used & ~window.held))
            own = (before + np.arange(count)) // size
            blocks += [own] * len(self.experiment.compared)
            before += count
        return np.concatenate(blocks)

    def _groups(self) -> list[list[int]]:
        """Windows of the same times, which are simulated in one call."""
        groups: dict[tuple[int, float], list[int]] = {}
        for index, window in enumerate(self.windows):
            groups.setdefault((len(window.record.grid), window.record.step), []).append(index)
        return list(groups.values())

    def _simulate(
        self, group: list[int], every: Sequence[Mapping[str, float]], found: list[list[dict[str, Array]]]
    ) -> None:
        experiment = self.experiment
        pairs = [(vector, index) for vector in range(len(every)) for index in group]
        settings: list[Mapping[str, Value]] = []
        driven: dict[str, list[Array]] = {}
        for vector, index in pairs:
            settings.append(experiment.start(self.windows[index], every[vector]))
            for name, values in experiment.inputs(self.windows[index], every[vector]).items():
                driven.setdefault(name, []).append(values)
        record = self.windows[group[0]].record
        grid = record.grid
        runs = experiment.simulated.simulate_many(
            settings,
            common={"solver.relativeTolerance": TOLERANCE},
            inputs={name: (grid, np.array(rows)) for name, rows in driven.items()},
            stop=(len(grid) - 1) * record.step,
            step=record.step,
            outputs=experiment.outputs,
            workers=self.workers,
            keep_failures=True,
            progress=False,
        )
        if len(pairs) == len(group) and runs.failures:
            self.refusals[:] = [next(iter(runs.failures.values()))]
        for run, (vector, index) in enumerate(pairs):
            outputs = {name: runs[name][run] for name in experiment.outputs}
            found[vector][index] = self._compare(self.windows[index], outputs, every[vector])

    def _compare(self, window: Window, outputs: Mapping[str, Array], values: Mapping[str, float]) -> dict[str, Array]:
        record = window.record
        predicted = self.experiment.predict(window, outputs, values)
        differences = {}
        for signal, course in predicted.items():
            # A sensor that lags shows what was true before.
            seen = np.interp(record.time - values.get(f"delay.{signal}", 0.0), record.grid, course)
            differences[signal] = record.signals[signal] - seen - values.get(f"offset.{signal}", 0.0)
        return differences


def _cut(window: Window) -> Window | None:
    """Return a window up to its last sample that is fitted; nothing if there is none."""
    fitted = np.flatnonzero(window.used & ~window.held)
    if not len(fitted):
        return None
    last = int(fitted[-1]) + 1
    points = len(window.record.grid)
    record = window.record.part(0, last)
    driven = {name: values[: len(record.grid)] if len(values) == points else values
              for name, values in window.driven.items()}  # fmt: skip
    return Window(record, driven, window.held[:last], window.used[:last])


def _bound(free: Free, bound: float) -> float:
    if free.is_logarithmic:
        return float(np.log(bound)) if bound > 0.0 else -np.inf
    return bound / free.scale


def _noise(windows: Sequence[Window], signal: str) -> float:
    estimates = [noise(window.record.signals[signal]) for window in windows]
    magnitude = max(float(np.max(np.abs(window.record.signals[signal]))) for window in windows)
    return max(float(np.median(estimates)), 1e-9 * magnitude, 1e-12)
