"""The most informative excitation, by the Fisher information of the predicted measurements."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pneumatic_servo import checks
from pneumatic_servo import progress as shown_progress
from pneumatic_servo import values as quantities
from pneumatic_servo.argument_names import quoted
from pneumatic_servo.files import write_csv
from pneumatic_servo.identification.compression import triangle
from pneumatic_servo.identification.experiments import Experiment, Options
from pneumatic_servo.identification.fitting import free_parameters, make_experiment
from pneumatic_servo.identification.intervals import RANK
from pneumatic_servo.identification.parameters import Free
from pneumatic_servo.identification.problem import Problem, check_jac, tell_underivable
from pneumatic_servo.identification.records import Record
from pneumatic_servo.identification.sensor import Sensor
from pneumatic_servo.identification.signals import SIGNALS
from pneumatic_servo.identification.solve import jacobian
from pneumatic_servo.model import Parameters
from pneumatic_servo.names import did_you_mean
from pneumatic_servo.run_errors import Interrupted
from pneumatic_servo.tasks import cancel

Array = NDArray[np.float64]

NOISE = {"position": 1e-5, "velocity": 1e-3, "chamberA.pressure": 500.0, "chamberB.pressure": 500.0,
         "frictionForce": 0.05, "force": 0.05}  # fmt: skip
"""Standard deviations of usual sensors in SI units."""
LONGEST = 10.0
"""Length in m beyond which no machine goes."""
LOUDEST = {"m": 0.01, "m/s": 1.0, "Pa": 1e5, "N": 1e3}
"""Noise in SI units beyond which no sensor is of use, so that another unit was meant."""


@dataclass(frozen=True)
class Excitation:
    """An excitation.

    Attributes
    ----------
    name : str
        Description of the excitation.
    input : str
        Which input it is given to.
    time, course : ndarray
        Points of the input, in SI units.
    """

    name: str
    input: str
    time: Array
    course: Array

    def to_csv(self, file: str | Path) -> None:
        """Write it as a table of its input."""
        rows = zip(self.time.tolist(), self.course.tolist(), strict=True)
        write_csv(Path(file), ["time", self.input], rows)


@dataclass(frozen=True)
class Candidate(Excitation):
    """An excitation and the intervals that it would give.

    Attributes
    ----------
    half : dict
        Half of the 95 % interval to expect, by parameter; infinite where nothing is learned.
    information : float
        Logarithm of the determinant of the scaled information.
    """

    half: Mapping[str, float]
    information: float


@dataclass(frozen=True)
class Plan:
    """Candidates, the most informative first, and the parameter values at which they were simulated.

    Examples
    --------
    >>> import pneumatic_servo as ps
    >>> found = ps.plan(law="Coulomb", experiment="motion", duration=2.0, step=0.01, noise={"frictionForce": "0.1 N"},
    ...                 progress=False)
    >>> found.best.half["friction.coulomb.Fc"] < 0.5 * found.values["friction.coulomb.Fc"]
    True
    >>> found.to_csv("excitation.csv")
    """

    candidates: tuple[Candidate, ...]
    values: Mapping[str, float]
    units: Mapping[str, str]

    @property
    def best(self) -> Candidate:
        """The first."""
        return self.candidates[0]

    @property
    def determined(self) -> dict[str, bool]:
        """Whether the best would tell each parameter to better than half of its value."""
        return {name: self.best.half[name] < 0.5 * abs(value) if value else np.isfinite(self.best.half[name])
                for name, value in self.values.items()}  # fmt: skip

    def to_csv(self, file: str | Path) -> None:
        """Write the best as a table of its input."""
        self.best.to_csv(file)

    def __repr__(self) -> str:
        lines = ["excitations, the most informative first:"]
        lines += [f"  {candidate.information:10.1f}  {candidate.name}" for candidate in self.candidates]
        lines.append(f"with {self.best.name}, half of the 95 % interval will be about:")
        for name, half in self.best.half.items():
            verdict = "" if self.determined[name] else "   not identifiable"
            lines.append(f"  {name} = {self.values[name]:.6g} +- {half:.2g} {self.units[name]}{verdict}")
        return "\n".join(lines)


def plan(
    *,
    law: str,
    fit: str | Sequence[str] = (),
    experiment: str = "rig",
    settings: Parameters | None = None,
    noise: Mapping[str, Any] | None = None,
    duration: float = 10.0,
    step: float = 1e-3,
    stroke: float = 0.05,
    jac: str = "differences",
    executor: Executor | None = None,
    progress: shown_progress.Progress = True,
) -> Plan:
    """Propose an excitation.

    Parameters
    ----------
    law, fit, settings
        As for `fit`; start values are where the plan is judged.
    experiment : str
        ``rig``: the voltage is proposed; ``motion``: the position.
    noise : mapping, optional
        Standard deviations of what is measured, by signal in SI units or with their unit, ``"10 um"``; by default those
        of usual sensors.
    duration, step : float
        Length and interval of the samples in s.
    stroke : float
        Largest amplitude in m, for ``motion``.
    jac : str
        As for `fit`.
    executor : concurrent.futures.Executor, optional
        Who judges the candidates instead of this process; the bits are the same.
    progress : bool or callable
        Whether to show progress on a terminal, or what is called with candidates done and candidates in all.

    Returns
    -------
    Plan

    Raises
    ------
    ValueError
        For values that cannot be used; the message names them.
    Interrupted
        On Ctrl-C; its ``finished`` is a plan of the candidates judged until then, or None.

    Examples
    --------
    >>> import pneumatic_servo as ps
    >>> found = ps.plan(law="Coulomb", experiment="motion", duration=2.0, step=0.01, noise={"frictionForce": "0.1 N"})
    >>> found.determined
    {'friction.coulomb.Fc': True, 'friction.coulomb.sigma2': True}
    """
    if experiment not in ("rig", "motion"):
        raise ValueError(f"{quoted('experiment', experiment)}: a plan can be made for rig or motion")
    check_jac(jac)
    time, driven, courses = excitations(experiment, duration, step, stroke)
    kind = sensed(experiment, law, settings)
    free = free_parameters(kind, fit)
    values = {parameter.name: parameter.start for parameter in free}
    checks.submits("executor", executor)
    noises = {**NOISE, **noises_of(checks.mapping("noise", noise))}
    judge = _Judge(kind, tuple(free), noises, driven, time, jac)
    candidates: list[Candidate] = []
    refusals: list[str] = []
    units = {parameter.name: parameter.unit for parameter in free}
    try:
        with shown_progress.shown(progress, "plan", len(courses), " candidates") as tell:
            for done, found in enumerate(_judged(judge, courses.items(), executor), start=1):
                if isinstance(found, str):
                    refusals.append(found)
                else:
                    candidates.append(found)
                if tell is not None:
                    tell(done)
    except KeyboardInterrupt:
        interrupted = Interrupted("interrupted")
        interrupted.finished = Plan(_ranked(candidates), values, units) if candidates else None
        raise interrupted from None
    if not candidates:
        raise ValueError(f"no excitation could be simulated with these values; {refusals[0]}")
    return Plan(_ranked(candidates), values, units)


def sensed(experiment: str, law: str, settings: Parameters | None) -> Experiment:
    """Return an experiment in which all is measured that such a rig has sensors for, without play."""
    kind = make_experiment(experiment, law, settings, Options(play=0.0))
    signals = ("valveVoltage", "position", "chamberA.pressure", "chamberB.pressure")
    kind.use(["time", *(signals if experiment == "rig" else ("position", "frictionForce"))])
    return kind


def excitations(experiment: str, duration: float, step: float, stroke: float) -> tuple[Array, str, dict[str, Array]]:
    """Return times, the driven input, and its courses by their descriptions."""
    duration, step = quantities.seconds("duration", duration), quantities.seconds("step", step)
    stroke = quantities.number_in("m", "stroke", stroke)
    if not duration >= 100 * step > 0.0:
        raise ValueError(f"duration {duration} s and step {step} s: there must be at least 100 samples")
    if stroke > LONGEST:
        raise ValueError(
            f"{quoted('stroke', stroke)} m: it must be at most {LONGEST:g} m; did you mean {stroke:g} mm, which is "
            f"{1e-3 * stroke:g} m?"
        )
    if not stroke > 0.0:
        raise ValueError(f"{quoted('stroke', stroke)} m: it must be positive")
    time = np.arange(round(duration / step) + 1, dtype=np.float64) * step
    if experiment == "rig":
        return time, "valveVoltage", voltages(time)
    return time, "prescribedPosition", positions(time, stroke)


@dataclass(frozen=True)
class _Judge:
    """Judges excitations; it can be sent to other processes."""

    kind: Experiment
    free: tuple[Free, ...]
    noises: Mapping[str, float]
    driven: str
    time: Array
    jac: str

    def __call__(self, candidate: tuple[str, Array]) -> Candidate | str:
        """Return the intervals of an excitation, or why it cannot be simulated."""
        name, course = candidate
        values = {parameter.name: parameter.start for parameter in self.free}
        record = imagined(self.kind, self.time, course, self.kind.tied(values))
        if isinstance(record, str):
            return f"{name}: {record}"
        sensors = {name: Sensor(self.noises[name]) for name in self.kind.compared}
        problem = replace(Problem.of(self.kind, [record], self.free, 0.0), jac=self.jac)
        half, information = _judge(problem.seen_by(sensors))
        tell_underivable(problem)
        return Candidate(name, self.driven, self.time, course, half, information)


def _judged(
    judge: Callable[[tuple[str, Array]], Candidate | str], candidates: Iterable[tuple[str, Array]],
    executor: Executor | None,
) -> Iterator[Candidate | str]:  # fmt: skip
    if executor is None:
        yield from map(judge, candidates)
        return
    tasks = [executor.submit(judge, candidate) for candidate in candidates]
    try:
        for task in tasks:
            yield task.result()
    finally:
        cancel(tasks)


def _ranked(candidates: Sequence[Candidate]) -> tuple[Candidate, ...]:
    return tuple(sorted(candidates, key=lambda candidate: -candidate.information))


def noises_of(given: Mapping[str, Any]) -> dict[str, float]:
    """Return standard deviations in SI units; impossible ones are refused."""
    found = {}
    for signal, value in given.items():
        if signal not in NOISE:
            hint = did_you_mean(str(signal), NOISE)
            raise ValueError(
                f"{quoted('noise', signal)}: there is no signal {signal}{hint}; there are {', '.join(NOISE)}"
            )
        unit = SIGNALS[signal]
        size = quantities.number_in(unit, f"noise of {signal}", value)
        if not size > 0.0:
            raise ValueError(f"noise of {signal} = {size:g} {unit} is refused: it must be positive")
        if size > LOUDEST[unit]:
            small = {"m": "um", "m/s": "mm/s", "Pa": "bar", "N": "mN"}[unit]
            raise ValueError(
                f"noise of {signal} = {size:g} {unit} is refused: it must be at most {LOUDEST[unit]:g} {unit}, since "
                f"no sensor of that noise is of use; did you mean {value} {small}?"
            )
        found[signal] = size
    return found


def voltages(time: Array) -> dict[str, Array]:
    """Return courses of the valve's voltage."""
    courses = {}
    for amplitude in (1.0, 2.0, 3.0):
        for frequency in (0.25, 0.5, 1.0, 2.0):
            name = f"a sine of {amplitude:g} V at {frequency:g} Hz"
            courses[name] = 5.0 + amplitude * np.sin(2.0 * np.pi * frequency * time)
        sweep = 2.0 * np.pi * (0.2 * time + 0.5 * (3.0 - 0.2) / time[-1] * time**2)
        courses[f"a sweep of {amplitude:g} V from 0.2 to 3 Hz"] = 5.0 + amplitude * np.sin(sweep)
        growing = amplitude * time / time[-1] * np.sin(2.0 * np.pi * time)
        courses[f"a sine at 1 Hz that grows to {amplitude:g} V"] = 5.0 + growing
    return courses


def positions(time: Array, stroke: float) -> dict[str, Array]:
    """Return courses of the position."""
    courses = {}
    for share in (0.001, 0.01, 0.1, 1.0):
        for frequency in (0.1, 0.5, 2.0):
            courses[f"a sine of {1e3 * share * stroke:g} mm at {frequency:g} Hz"] = (
                share * stroke * np.sin(2.0 * np.pi * frequency * time)
            )
    swell = np.geomspace(1e-3, 1.0, len(time))
    for frequency in (0.2, 1.0):
        name = f"a sine at {frequency:g} Hz that grows from {stroke:g} to {1e3 * stroke:g} mm"
        courses[name] = stroke * swell * np.sin(2.0 * np.pi * frequency * time)
    return courses


def imagined(kind: Experiment, time: Array, course: Array, values: Mapping[str, float]) -> Record | str:
    """Return the predicted measurements, or why the simulation cannot go on."""
    step = float(time[1])
    if kind.name == "motion":
        return Record("plan", time, 0.0, {"position": course, "frictionForce": np.zeros_like(course)})
    runs = kind.simulated._run_many(
        [kind.under_law(values)], common={}, inputs={"valveVoltage": (time, course[None, :])}, stop=float(time[-1]),
        step=step, outputs=["position", "chamberA.pressure", "chamberB.pressure"],
    )  # fmt: skip
    if runs.failures:
        return next(iter(runs.failures.values()))
    signals = {name: runs[name][0] for name in runs.variables}
    return Record("plan", time, 0.0, {"valveVoltage": course, **signals})


def _judge(problem: Problem) -> tuple[dict[str, float], float]:
    """Return half of the intervals to expect, and the logarithm of the determinant of the information."""
    derivatives = jacobian(problem, problem.start)
    _, sizes, directions = np.linalg.svd(triangle(derivatives), full_matrices=False)
    seen = sizes > RANK * max(float(sizes[0]), 1e-300)
    variance = np.sum((directions[seen] / sizes[seen, None]) ** 2, axis=0)
    blind = np.any(np.abs(directions[~seen]) > 0.1, axis=0)
    half = {}
    for place, free in enumerate(problem.free):
        size = 1.96 * float(np.sqrt(variance[place]))
        wide = free.start * np.expm1(min(size, 50.0)) if free.is_logarithmic else size * free.scale
        half[free.name] = np.inf if blind[place] else float(abs(wide))
    return half, float(2.0 * np.sum(np.log(np.maximum(sizes, 1e-12))))
