"""An excitation that tells most, proposed by the Fisher information of what would be measured."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from pneumatic_servo.files import write_csv
from pneumatic_servo.identification.compression import triangle
from pneumatic_servo.identification.experiments import Experiment, Options
from pneumatic_servo.identification.fitting import free_parameters, make_experiment
from pneumatic_servo.identification.intervals import RANK
from pneumatic_servo.identification.problem import Problem
from pneumatic_servo.identification.records import Record
from pneumatic_servo.identification.sensor import Sensor
from pneumatic_servo.identification.solve import Tell, jacobian
from pneumatic_servo.variables import Value

Array = NDArray[np.float64]

NOISE = {"position": 1e-5, "velocity": 1e-3, "chamberA.pressure": 500.0, "chamberB.pressure": 500.0,
         "frictionForce": 0.05, "force": 0.05}  # fmt: skip
"""Standard deviations of usual sensors in SI units."""


@dataclass(frozen=True)
class Candidate:
    """An excitation and what it would determine.

    Attributes
    ----------
    name : str
        What it is, in words.
    input : str
        Which input it is given to.
    time, course : ndarray
        Points of the input, in SI units.
    half : dict
        Half of the 95 % interval to expect, by parameter; infinite where nothing is learned.
    information : float
        Logarithm of the determinant of the scaled information.
    """

    name: str
    input: str
    time: Array
    course: Array
    half: Mapping[str, float]
    information: float


@dataclass(frozen=True)
class Plan:
    """Candidates, the most telling first, and the values they were judged at."""

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
        rows = zip(self.best.time.tolist(), self.best.course.tolist(), strict=True)
        write_csv(Path(file), ["time", self.best.input], rows)

    def __repr__(self) -> str:
        lines = ["excitations, the most telling first:"]
        lines += [f"  {candidate.information:10.1f}  {candidate.name}" for candidate in self.candidates]
        lines.append(f"with {self.best.name}, half of the 95 % interval will be about:")
        for name, half in self.best.half.items():
            verdict = "" if self.determined[name] else "   not determined"
            lines.append(f"  {name} = {self.values[name]:.6g} +- {half:.2g} {self.units[name]}{verdict}")
        return "\n".join(lines)


def plan(
    *,
    law: str,
    fit: str | Sequence[str] = (),
    experiment: str = "rig",
    settings: Mapping[str, Value] | None = None,
    noise: Mapping[str, float] | None = None,
    duration: float = 10.0,
    step: float = 1e-3,
    stroke: float = 0.05,
    progress: Tell | None = None,
) -> Plan:
    """Propose an excitation.

    Parameters
    ----------
    law, fit, settings
        As for `fit`; start values are where the plan is judged.
    experiment : str
        ``rig``: the voltage is proposed; ``motion``: the position.
    noise : mapping, optional
        Standard deviations of what is measured, by signal in SI units; by default those of usual sensors.
    duration, step : float
        Length and interval of the samples in s.
    stroke : float
        Largest amplitude in m, for ``motion``.

    Returns
    -------
    Plan
    """
    if experiment not in ("rig", "motion"):
        raise ValueError(f"--experiment {experiment}: a plan can be made for rig or motion")
    if not duration >= 100 * step > 0.0:
        raise ValueError(f"duration {duration} s and step {step} s: there must be at least 100 samples")
    if not (stroke > 0.0 and np.isfinite(stroke)):
        raise ValueError(f"--stroke {stroke} m: it must be positive")
    kind = make_experiment(experiment, law, settings or {}, Options(play=0.0))
    signals = ("valveVoltage", "position", "chamberA.pressure", "chamberB.pressure")
    kind.use(["time", *(signals if experiment == "rig" else ("position", "frictionForce"))])
    free = free_parameters(kind, fit)
    values = {parameter.name: parameter.start for parameter in free}
    time = np.arange(round(duration / step) + 1, dtype=np.float64) * step
    noises = {**NOISE, **(noise or {})}
    courses = voltages(time) if experiment == "rig" else positions(time, stroke)
    candidates = []
    refusals: list[str] = []
    for name, course in courses.items():
        if progress is not None:
            progress(name)
        record = _imagined(kind, time, course, values)
        if isinstance(record, str):
            refusals.append(f"{name}: {record}")
            continue
        problem = Problem.of(kind, [record], free, 0.0).seen_by({name: Sensor(noises[name]) for name in kind.compared})
        half, information = _judge(problem)
        driven = "valveVoltage" if experiment == "rig" else "prescribedPosition"
        candidates.append(Candidate(name, driven, time, course, half, information))
    if not candidates:
        raise ValueError(f"no excitation could be simulated with these values; {refusals[0]}")
    candidates.sort(key=lambda candidate: -candidate.information)
    return Plan(tuple(candidates), values, {parameter.name: parameter.unit for parameter in free})


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


def _imagined(kind: Experiment, time: Array, course: Array, values: Mapping[str, float]) -> Record | str:
    """Return what would be measured, or why the simulation cannot go on."""
    step = float(time[1])
    if kind.name == "motion":
        return Record("plan", time, 0.0, {"position": course, "frictionForce": np.zeros_like(course)})
    settings = {**kind.of_model(values), "friction.law": kind.law}
    runs = kind.simulated.simulate_many(
        [settings], inputs={"valveVoltage": (time, course)}, stop=float(time[-1]), step=step,
        outputs=["position", "chamberA.pressure", "chamberB.pressure"], keep_failures=True, progress=False,
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
