"""A problem: data, given and compared signals, estimated parameters."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from pneumatic_servo import _native
from pneumatic_servo.argument_names import quoted
from pneumatic_servo.errors import warn
from pneumatic_servo.identification.experiments import Experiment, Window
from pneumatic_servo.identification.parameters import Free, viscous_of
from pneumatic_servo.identification.records import Record
from pneumatic_servo.identification.sensor import Sensor
from pneumatic_servo.run import Runs
from pneumatic_servo.tasks import available_cores
from pneumatic_servo.variables import Value

Array = NDArray[np.float64]
Vectors = Sequence[tuple[Mapping[str, float], Sequence[Mapping[str, float]]]]
"""Values of the estimated parameters, and start values of each segment, for each vector."""

STEP = 1e-3
"""Step of the differences that make the Jacobian, in scaled parameters, unless its effect exceeds the noise."""

TOLERANCE = 1e-6
"""Relative tolerance of the solver at which differences of runs are differences of parameters."""

JACOBIANS = ("differences", "exact")
"""Kinds of a Jacobian."""

PULL = 1.5
"""Standard deviation, in logarithms, of how far a parameter without bounds is from its start: a factor of 4.5."""

WORK = 20
"""Limit of the solver steps of a run, relative to the start's; one that takes more is given up."""

COUNTED = ["solver.steps", "solver.rejectedSteps"]
"""Counters of the solver steps of a run."""

FAILED = 1e12
"""Residual, in units of the noise, where a simulation could not go on: worse than any of one that could."""


MAGNITUDES = {"position0": 1e-4, "velocity0": 1e-2, "chamberA.pressure0": 1e3, "chamberB.pressure0": 1e3}
"""Magnitudes of changes of start values of a window, in SI units."""


@dataclass(frozen=True)
class OtherForm:
    """The other form of a law whose form is fixed, where only whole records tell which one is right.

    Attributes
    ----------
    name, given, item : str
        The setting that decides, its fixed value, and the other one.
    before, after : float
        Mean squares of the residuals of whole records under both, in units of the noise.
    """

    name: str
    given: str
    item: str
    before: float
    after: float


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
    tolerance: float = TOLERANCE
    """Relative tolerance of the solver."""
    exactness: float = 1.0
    """Factor of this tolerance."""
    step: float = STEP
    """Step of the differences that make the Jacobian, in scaled parameters."""
    most: int | None = None
    """Solver steps after which a run is given up."""
    clock: float = 1.0
    """True time over the time of the records."""
    scale: float = 1.0
    """Factor of all friction, where the model takes its load level as an input."""
    other_form: OtherForm | None = None
    """A form of the law that describes whole records, which the fixed one does not."""
    jac: str = "differences"
    """Kind of the Jacobian: differences of runs, or the exact derivatives of one."""
    underivable: dict[str, str] = field(default_factory=dict, compare=False)
    """Names by which a run had no derivative, so that differences were taken, and why."""
    refusals: list[str] = field(default_factory=list, compare=False)
    """Why a single vector could not be simulated, last time."""

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
        named = {*experiment.settings, *(one.name for one in free)}
        for record in [*records, *extra]:
            share = 1.0 if any(record is other for other in extra) else validation
            windows += experiment.windows(record, share, named)
        courses = {signal: [window.record.signals[signal] for window in windows] for signal in experiment.compared}
        sensors = {signal: Sensor.of(measured) for signal, measured in courses.items()}
        return Problem(experiment, tuple(windows), tuple(free), sensors)

    def values(self, x: Array) -> dict[str, float]:
        """Return the values of the free parameters by name."""
        fitted = {free.name: free.outer(float(inner)) for free, inner in zip(self.free, x, strict=False)}
        return {**self.experiment.held, **fitted}

    def begins(self, x: Array) -> list[dict[str, float]]:
        """Return the start values of each segment."""
        begins = [dict(window.begin.values) for window in self.windows]
        if len(x) > len(self.free):
            inner = iter(x[len(self.free) :])
            for begin, window in zip(begins, self.windows, strict=True):
                for name in window.begin.loose:
                    begin[name] += MAGNITUDES[name] * float(next(inner))
        if self.clock != 1.0 and "velocity" not in self.experiment.signals:
            # It is a slope of the measured position.
            begins = [{**begin, "velocity0": begin["velocity0"] / self.clock} if "velocity0" in begin else begin
                      for begin in begins]  # fmt: skip
        return begins

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
        """Return the same problem, in which runs are given up that take many times the work of the start.

        Far off what can be meant, say where a bristle is all damping, a run may take a thousand times as long, and
        tells no more than that this is no place to look.
        """
        steps = 0.0
        every = [(self.values(self.start), self.begins(self.start))]
        for group in self.groups():
            runs = self.run(group, every, COUNTED)
            steps = max(steps, float(np.nanmax(sum(runs[name] for name in COUNTED))))
        return replace(self, most=int(WORK * steps))

    def with_free(self, free: Sequence[Free]) -> Problem:
        """Return the same problem with other free parameters."""
        return replace(self, free=tuple(free))

    def differences(self, vectors: Sequence[Array]) -> list[list[dict[str, Array]]]:
        """Return measured minus simulated for each vector and window, by signal; NaN where a run failed."""
        every = [(self.values(x), self.begins(x)) for x in vectors]
        found: list[list[dict[str, Array]]] = [[{} for _ in self.windows] for _ in every]
        for group in self.groups():
            self._simulate(group, every, found)
        return found

    def stacked(self, vectors: Sequence[Array], *, held: bool = False) -> Array:
        """Return the differences of vectors, of shape (vectors, samples): window by window, in it signal by signal."""
        return self._stack(self.differences(vectors), held=held)

    def near(self, x: Array, vectors: Sequence[Array]) -> Array:
        """Return the same of vectors near another one, by the exact derivatives of the runs there.

        Where a run has no derivative by what a vector changes, it is run under that vector.
        """
        every = [(self.values(one), self.begins(one)) for one in [x, *vectors]]
        found: list[list[dict[str, Array]]] = [[{} for _ in self.windows] for _ in vectors]
        with ThreadPoolExecutor(self.workers or available_cores()) as threads:
            # The runs are made without the lock of the interpreter.
            made = threads.map(lambda index: self._derive(index, every), range(len(self.windows)))
            for index, near in enumerate(made):
                lacking = [vector for vector, courses in enumerate(near) if courses is None]
                for vector, courses in enumerate(near):
                    if courses is not None:
                        found[vector][index] = self._compare(index, courses, every[1 + vector][0])
                if lacking:
                    runs: list[list[dict[str, Array]]] = [[{} for _ in self.windows] for _ in lacking]
                    self._simulate([index], [every[1 + vector] for vector in lacking], runs)
                    for vector, run in zip(lacking, runs, strict=True):
                        found[vector][index] = run[index]
        return self._stack(found)

    def _derive(self, index: int, every: Vectors) -> list[dict[str, Array] | None]:
        """Return the outputs of a window under all vectors but the first, on the tangent of its run under that."""
        window = self.windows[index]
        settings = [self.settings_of(window, values, begins[index]) for values, begins in every]
        inputs = [self.inputs_of(window, values) for values, _ in every]
        first = settings[0]
        moved = [{name: float(number) - float(first[name]) for name, number in own.items() if number != first[name]}
                 for own in settings[1:]]  # fmt: skip
        by = list(dict.fromkeys(name for own in moved for name in own))
        outputs, slopes = self._differentiate(window, first, inputs[0], by)
        courses: list[dict[str, Array] | None] = []
        for own, driven in zip(moved, inputs[1:], strict=True):
            is_driven_alike = all(np.array_equal(driven[name], course) for name, course in inputs[0].items())
            if outputs is None or not is_driven_alike or not slopes.keys() >= own.keys():
                courses.append(None)
                continue
            courses.append({
                name: course + sum(by * slopes[setting][output] for setting, by in own.items())
                for output, (name, course) in enumerate(outputs.items())
            })  # fmt: skip
        return courses

    def _differentiate(
        self, window: Window, settings: Mapping[str, Value], inputs: Mapping[str, Array], by: Sequence[str]
    ) -> tuple[dict[str, Array] | None, dict[str, Array]]:
        """Return the outputs of a run, if it comes to its end, and their derivatives by those names that have them."""
        record, outputs, model = window.record, self.experiment.outputs, self.experiment.simulated
        grid = self.clock * record.grid
        driven = [(name, (grid, course)) for name, course in inputs.items()]
        given = {**settings, "solver.relativeTolerance": self.exactness * self.tolerance}
        by = list(by)
        while True:
            try:
                found, _, failure, ended, _, _, derived = _native.simulate(
                    model._native, list(given.items()), driven, (0.0, self.clock * record.step, len(grid) - 1, 1),
                    list(outputs), by, None, self.experiment.native.has_lines,
                )  # fmt: skip
                break
            except ValueError as refused:
                named = [name for name in by if f"to {name}:" in str(refused)]
                if not named:
                    return None, {}
                self.underivable[named[0]] = str(refused)
                by.remove(named[0])
        if ended is not None:
            raise ended
        if failure is not None:
            return None, {}
        slopes, lost, _ = derived if derived is not None else (np.zeros((0, len(outputs), len(grid))), [], [])
        known = {}
        for name, slope, why in zip(by, slopes, lost, strict=True):
            if why is None and np.isfinite(slope).all():
                known[name] = slope
            else:
                told = "outputs are rounded" if why is None else f"at {why[0]:g} s, {why[1]}: {why[2]}"
                self.underivable[name] = told
        return dict(zip(outputs, found, strict=True)), known

    def _stack(self, every: Sequence[Sequence[Mapping[str, Array]]], *, held: bool = False) -> Array:
        rows = [
            np.concatenate([
                difference[signal][window.used & (window.held == held)]
                for window, difference in zip(self.windows, differences, strict=True)
                for signal in self.experiment.compared
            ])
            for differences in every
        ]  # fmt: skip
        return np.array(rows)

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

    def suspects(self) -> _native.Suspects:
        """Return what may be a cause of residuals: settings, properties of sensors, choices, and whether a clock."""
        return self.experiment.native.suspects([free.name for free in self.free])

    def groups(self) -> list[list[int]]:
        """Windows of the same times, which are simulated in one call."""
        groups: dict[tuple[int, float], list[int]] = {}
        for index, window in enumerate(self.windows):
            groups.setdefault((len(window.record.grid), window.record.step), []).append(index)
        return list(groups.values())

    def _simulate(self, group: list[int], every: Vectors, found: list[list[dict[str, Array]]]) -> None:
        outputs = self.experiment.outputs
        runs = self.run(group, every, outputs, self.most)
        pairs = _pairs(group, every)
        if len(pairs) == len(group) and runs.failures:
            self.refusals[:] = [next(iter(runs.failures.values()))]
        for run, (vector, index) in enumerate(pairs):
            courses = {name: runs[name][run] for name in outputs}
            found[vector][index] = self._compare(index, courses, every[vector][0])

    def run(self, group: list[int], every: Vectors, outputs: Sequence[str], most: int | None = None) -> Runs:
        """Make the runs of a group of windows under vectors."""
        settings: list[Mapping[str, Value]] = []
        driven: dict[str, list[Array]] = {}
        for vector, index in _pairs(group, every):
            values, begins = every[vector]
            settings.append(self.settings_of(self.windows[index], values, begins[index]))
            for name, course in self.inputs_of(self.windows[index], values).items():
                driven.setdefault(name, []).append(course)
        record = self.windows[group[0]].record
        grid = self.clock * record.grid
        return self.experiment.simulated._run_many(
            settings,
            common={"solver.relativeTolerance": self.exactness * self.tolerance},
            inputs={name: (grid, np.array(rows)) for name, rows in driven.items()},
            stop=(len(grid) - 1) * self.clock * record.step,
            step=self.clock * record.step,
            outputs=outputs,
            workers=self.workers,
            most=most,
            lines=self.experiment.native.has_lines,
        )

    def settings_of(self, window: Window, values: Mapping[str, float], begin: Mapping[str, float]) -> dict[str, Value]:
        """Return the settings of the run of a segment: its start, and fixed and estimated values."""
        # The load level multiplies all friction but the viscous one.
        viscous = [] if self.scale == 1.0 else viscous_of(self.experiment.law, self.experiment.table)
        scaled = {name: self.scale * self.experiment.value(name, values) for name in viscous}
        return {**begin, **self.experiment.start(window, values), **scaled}

    def inputs_of(self, window: Window, values: Mapping[str, float]) -> dict[str, Array]:
        """Return the inputs of the run of a window at its communication points."""
        return {
            name: self.scale * course if name == "friction.level" and self.scale != 1.0 else course
            for name, course in self.experiment.inputs(window, values).items()
        }

    def _compare(self, index: int, outputs: Mapping[str, Array], values: Mapping[str, float]) -> dict[str, Array]:
        return self.experiment.differences(self.windows[index], outputs, values, self.clock)


def check_jac(jac: str) -> None:
    """Refuse unknown kinds of Jacobians."""
    if jac not in JACOBIANS:
        raise ValueError(f"{quoted('jac', jac)}: it must be {' or '.join(JACOBIANS)}")


def tell_underivable(problem: Problem) -> None:
    """Warn of parameters by which differences were taken though exact derivatives were asked for."""
    if problem.underivable:
        why = next(iter(problem.underivable.values()))
        named = ", ".join(problem.underivable)
        warn(f"differences of runs are taken by {named}, by which a run has no derivative: {why}")


def _pairs(group: list[int], every: Vectors) -> list[tuple[int, int]]:
    """Return vector and window of each run."""
    return [(vector, index) for vector in range(len(every)) for index in group]


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
