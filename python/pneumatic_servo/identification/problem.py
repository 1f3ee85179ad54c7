"""A problem: data, given and compared signals, estimated parameters."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pneumatic_servo import _native
from pneumatic_servo.argument_names import quoted
from pneumatic_servo.errors import warn
from pneumatic_servo.identification.experiments import Experiment, Window
from pneumatic_servo.identification.parameters import Free
from pneumatic_servo.identification.records import Record
from pneumatic_servo.identification.sensor import Sensor
from pneumatic_servo.tasks import available_cores

Array = NDArray[np.float64]
STEP = _native.STEP
"""Step of the differences that make the Jacobian, in scaled parameters, unless its effect exceeds the noise."""

TOLERANCE = _native.TOLERANCE
"""Relative tolerance of the solver."""

JACOBIANS = ("differences", "exact")
"""Kinds of a Jacobian."""

PULL = _native.PRIOR
"""Standard deviation, in logarithms, of how far a parameter without bounds is from its start: a factor of 4.5."""

FAILED = _native.FAILED
"""Residual, in units of the noise, where a simulation could not go on: worse than any of one that could."""


@dataclass(frozen=True)
class Problem:
    """Data, experiment and free parameters; the solver sees a vector of scaled parameters.

    After the free parameters the vector has what each window begins with, as far as it was only measured: the first
    samples tell it no better than all others, and what it errs by would pass into the parameters. A vector of the free
    parameters alone leaves the windows their beginnings.

    Attributes
    ----------
    experiment : Experiment
        Which model is run, with which inputs.
    windows : tuple of Window
        The measured stretches.
    free : tuple of Free
        Estimated parameters.
    sensors : dict
        Sensor of each compared signal.
    """

    experiment: Experiment
    windows: tuple[Window, ...]
    free: tuple[Free, ...]
    sensors: Mapping[str, Sensor]
    workers: int | None = None
    exactness: float = 1.0
    """Factor of the tolerance of the solver."""
    step: float = STEP
    """Step of the differences that make the Jacobian, in scaled parameters."""
    most: float | None = None
    """Solver steps after which a run is given up."""
    scale: float = 1.0
    """Factor of all friction, where the model takes its load factor as an input."""
    other_form: _native.Told | None = None
    """The other form of a law whose form is fixed, where only whole records tell which one is right."""
    jac: str = "differences"
    """Kind of the Jacobian: differences of runs, or the exact derivatives of one."""

    @staticmethod
    def of(
        experiment: Experiment,
        records: Sequence[Record],
        free: Sequence[Free],
        validation: float,
        extra: Sequence[Record] = (),
    ) -> Problem:
        """Cut the records into windows; the last part of each, and the extra records, are validation data."""
        windows = []
        named = {*experiment.settings, *(one.name for one in free), *(one.name for one in experiment.ties)}
        for record in [*records, *extra]:
            share = 1.0 if any(record is other for other in extra) else validation
            windows += experiment.windows(record, share, named)
        return Problem(experiment, tuple(windows), tuple(free), sensors_of(experiment, windows))

    def __getstate__(self) -> dict[str, Any]:
        """Return what is sent to other processes."""
        return {name: value for name, value in self.__dict__.items() if name != "native"}

    @cached_property
    def native(self) -> _native.LeastSquares:
        """The problem of the crate."""
        records = list(dict.fromkeys(window.record.name for window in self.windows))
        sensors = [self.sensors[signal] for signal in self.experiment.compared]
        return _native.LeastSquares(
            [free.numbers for free in self.free],
            self.experiment.native,
            [
                (window.native, dict(window.begin.values), list(window.begin.loose), records.index(window.record.name))
                for window in self.windows
            ],
            [sensor.numbers for sensor in sensors],
            {},
            [(tie.name, tie.text) for tie in self.experiment.ties],
            {
                "step": self.step, "scale": self.scale, "exactness": self.exactness, "most": self.most,
                "workers": self.workers or available_cores(), "is_exact": self.jac == "exact",
            },
        )  # fmt: skip

    def values(self, x: Array) -> dict[str, float]:
        """Return the values of the free parameters by name, and of those that follow from them."""
        return self.native.values(x)

    def begins(self, x: Array) -> list[dict[str, float]]:
        """Return the start values of each segment."""
        return self.native.begins(x)

    @property
    def size(self) -> int:
        """Number of the residuals."""
        return sum(window.fitted for window in self.windows) * len(self.experiment.compared)

    @property
    def loose(self) -> tuple[int, ...]:
        """Number of estimated start values of each window."""
        return tuple(len(window.begin.loose) for window in self.windows)

    @property
    def start(self) -> Array:
        """The start values as the solver sees them."""
        return np.array([*(free.inner(free.start) for free in self.free), *[0.0] * sum(self.loose)])

    @property
    def bounds(self) -> tuple[Array, Array]:
        """The bounds as the solver sees them."""
        low = [_bound(free, free.low) for free in self.free]
        high = [_bound(free, free.high) for free in self.free]
        none = [np.inf] * sum(self.loose)
        return np.array([*low, *(-bound for bound in none)]), np.array([*high, *none])

    def seen_by(self, sensors: Mapping[str, Sensor]) -> Problem:
        """Return the same problem with other sensors."""
        return replace(self, sensors=dict(sensors))

    def trained(self) -> Problem:
        """Return the same problem without validation data, which the fit need not simulate."""
        return replace(self, windows=tuple(cut for window in self.windows if (cut := _cut(window)) is not None))

    def begun(self, trained: Problem, x: Array) -> Problem:
        """Return the same problem whose windows begin as a vector of the trained problem says; others as measured."""
        begins = iter(trained.begins(x))
        windows = [
            window if _cut(window) is None else replace(window, begin=replace(window.begin, values=next(begins)))
            for window in self.windows
        ]
        return replace(self, windows=tuple(windows))

    def bounded(self) -> Problem:
        """Return the same problem, in which runs are given up that take many times the work of the start."""
        return replace(self, most=self.native.limit())

    def started(self) -> Problem:
        """Return the same problem with starts from the data for parameters without a given start."""
        return replace(self, free=self.limited(self.native.started()))

    def limited(self, limits: Sequence[tuple[float, float, float]]) -> tuple[Free, ...]:
        """Return the free parameters with other starts and bounds."""
        pairs = zip(self.free, limits, strict=True)
        return tuple(replace(free, start=start, low=low, high=high) for free, (start, low, high) in pairs)

    def differences(self, x: Array) -> list[dict[str, Array]]:
        """Return measured minus simulated for each window, by signal; NaN where a run failed."""
        return self.native.differences(x)

    def stacked(self, vectors: Sequence[Array], *, held: bool = False) -> Array:
        """Return the differences of vectors, of shape (vectors, samples): window by window, in it signal by signal."""
        return self.native.stacked(list(vectors), held)

    def by_sensor(self, of: Callable[[Sensor, Array], Array], stacked: Array) -> Array:
        """Return the readings' residuals of differences in the order of `stacked`."""
        parts, first = [], 0
        for window in self.windows:
            for signal in self.experiment.compared:
                last = first + window.fitted
                parts.append(of(self.sensors[signal], stacked[first:last]))
                first = last
        return np.concatenate(parts)

    def residuals(self, vectors: Sequence[Array]) -> Array:
        """Return the residuals of vectors in units of the noise, of shape (vectors, samples)."""
        rows = [self.by_sensor(Sensor.residuals, row) for row in self.stacked(vectors)]
        return np.asarray(np.nan_to_num(np.array(rows), nan=FAILED, posinf=FAILED, neginf=-FAILED))

    def pulls(self, x: Array) -> Array:
        """Return the priors of parameters without bounds as residuals, of shape (vector,).

        Too weak to be felt where the data tell a value, it keeps those that they do not tell from going astray, to
        where a hair less is left of the noise and everything is wrong with other data.
        """
        drawn = np.zeros_like(x)
        for index, free in enumerate(self.free):
            if free.is_logarithmic and not free.is_bounded:
                drawn[index] = (x[index] - free.inner(free.start)) / PULL
        return drawn

    @property
    def pull(self) -> Array:
        """The derivatives of these, of shape (vector,)."""
        return self.pulls(self.start + 1.0)

    def rms(self, x: Array, *, held: bool = False) -> dict[str, float]:
        """Return the rms of measured minus simulated by signal; empty if there are no such samples."""
        differences = self.differences(x)
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

    def measured(self) -> dict[str, Array]:
        """Return the samples of each compared signal that are fitted."""
        return {
            signal: np.concatenate([w.record.signals[signal][w.used & ~w.held] for w in self.windows])
            for signal in self.experiment.compared
        }

    def blocks(self, number: int) -> NDArray[np.int64]:
        """Return the number of the block of each sample: stretches of time, all signals of a stretch together.

        As many windows as blocks are not cut: what happens in one has no part in the next.
        """
        total = sum(window.fitted for window in self.windows)
        size = max(1, -(-total // number))
        blocks, before = [], 0
        for window in self.windows:
            inside = np.zeros(window.fitted) if len(self.windows) >= number else np.arange(window.fitted)
            blocks += [((before + inside) // size).astype(np.int64)] * len(self.experiment.compared)
            before += window.fitted
        _, places = np.unique(np.concatenate(blocks), return_inverse=True)
        return places.astype(np.int64)


def sensors_of(experiment: Experiment, windows: Sequence[Window]) -> dict[str, Sensor]:
    """Return the sensor of each compared signal, with the noise that the data show."""
    found = experiment.native.sensors_of([window.native for window in windows])
    return {signal: Sensor(*numbers) for signal, numbers in zip(experiment.compared, found, strict=True)}


def check_jac(jac: str) -> None:
    """Refuse unknown kinds of Jacobians."""
    if jac not in JACOBIANS:
        raise ValueError(f"{quoted('jac', jac)}: it must be {' or '.join(JACOBIANS)}")


def tell_underivable(problem: Problem) -> None:
    """Warn of parameters by which differences were taken though exact derivatives were asked for."""
    if underivable := problem.native.underivable:
        why = next(iter(underivable.values()))
        named = ", ".join(underivable)
        warn(f"differences of runs are taken by {named}, by which a run has no derivative: {why}")


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
    return replace(window, record=record, driven=driven, held=window.held[:last], used=window.used[:last])


def _bound(free: Free, bound: float) -> float:
    if free.is_logarithmic:
        return float(np.log(bound)) if bound > 0.0 else -np.inf
    return bound / free.scale
