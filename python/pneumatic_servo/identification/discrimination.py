"""Experiments that tell two laws apart.

One law is simulated with its fitted values, the other is fitted to that: what it leaves, in units of the noise, is what
an experiment tells of which of both is true (A. C. Atkinson and V. V. Fedorov, "The design of experiments for
discriminating between two rival models", Biometrika, 1975).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pneumatic_servo import progress as shown_progress
from pneumatic_servo.argument_names import quoted
from pneumatic_servo.identification.experiments import Experiment
from pneumatic_servo.identification.fitting import free_parameters
from pneumatic_servo.identification.parameters import Free
from pneumatic_servo.identification.planning import NOISE, Excitation, excitations, imagined, noises_of, sensed
from pneumatic_servo.identification.problem import Problem
from pneumatic_servo.identification.records import Record
from pneumatic_servo.identification.result import Fit
from pneumatic_servo.identification.sensor import Sensor
from pneumatic_servo.identification.solve import refine
from pneumatic_servo.run_errors import Interrupted

Array = NDArray[np.float64]

CLEAR = 5.0
"""Distances in units of the noise from which on an experiment tells two laws apart nearly always."""


@dataclass(frozen=True)
class Trial(Excitation):
    """An excitation and how far apart two laws are under it.

    Attributes
    ----------
    distance : float
        Root of the sum of squares, in units of the noise, of what the second law leaves of the first.
    """

    distance: float


@dataclass(frozen=True)
class Telling:
    """Experiments that would tell two laws apart, the most telling first.

    Examples
    --------
    >>> import numpy as np
    >>> import pneumatic_servo as ps
    >>> t, rng = np.arange(0.0, 1.0, 0.02), np.random.default_rng(0)
    >>> data = {"time": t, "position": 0.01 * np.sin(6.0 * t),
    ...         "frictionForce": 7.0 * np.sign(np.cos(6.0 * t)) + 0.1 * rng.standard_normal(len(t))}
    >>> ranking = ps.compare_fits(data, ["Coulomb", "Dahl"], experiment="motion", starts=0, progress=False)
    >>> found = ranking.telling("Coulomb", "Dahl", duration=1.0, step=0.01, progress=False)
    >>> found.best.distance == max(trial.distance for trial in found.trials)
    True
    """

    first: str
    second: str
    trials: tuple[Trial, ...]

    @property
    def best(self) -> Trial:
        """The first."""
        return self.trials[0]

    def to_csv(self, file: str | Path) -> None:
        """Write the best as a table of its input."""
        self.best.to_csv(file)

    def __repr__(self) -> str:
        lines = [f"excitations that distinguish {self.first} from {self.second}; residual in units of the noise:"]
        lines += [f"  {trial.distance:10.1f}  {trial.name}" for trial in self.trials]
        if not self.best.distance > CLEAR:
            lines.append("none of them distinguishes the two with these sensors")
        return "\n".join(lines)


def telling(
    first: Fit, second: Fit, *, noise: Mapping[str, Any] | None = None, duration: float = 10.0, step: float = 1e-3,
    stroke: float = 0.05, progress: shown_progress.Progress = True,
) -> Telling:  # fmt: skip
    """Judge excitations by how well they tell two fits apart; see `Ranking.telling`."""
    name = first.problem.experiment.name
    if name not in ("rig", "motion"):
        raise ValueError(f"{quoted('experiment', name)}: what tells laws apart can be planned for rig or motion")
    time, driven, courses = excitations(name, duration, step, stroke)
    noises = {**NOISE, **noises_of(noise or {})}
    sides = _side(first), _side(second)
    trials: list[Trial] = []
    refusals: list[str] = []
    try:
        with shown_progress.shown(progress, "tell apart", len(courses), " candidates") as tell:
            for done, (words, course) in enumerate(courses.items(), start=1):
                distance = _distance(*sides, time, course, noises)
                if isinstance(distance, str):
                    refusals.append(distance)
                else:
                    trials.append(Trial(words, driven, time, course, distance))
                if tell is not None:
                    tell(done)
    except KeyboardInterrupt:
        interrupted = Interrupted("interrupted")
        interrupted.finished = _ranked(first, second, trials) if trials else None
        raise interrupted from None
    if not trials:
        raise ValueError(f"no excitation could be simulated with these values; {refusals[0]}")
    return _ranked(first, second, trials)


def _ranked(first: Fit, second: Fit, trials: list[Trial]) -> Telling:
    return Telling(first.law, second.law, tuple(sorted(trials, key=lambda trial: -trial.distance)))


def _side(fit: Fit) -> tuple[Experiment, tuple[Free, ...]]:
    """Return an experiment with fixed and fitted values; sensors are taken as ideal."""
    experiment, table = fit.problem.experiment, fit.problem.experiment.table
    values = {name: value for name, value in fit.values.items() if name in table.variables}
    known = {name: value for name, value in experiment.settings.items() if name in table.variables}
    kind = sensed(experiment.name, fit.law, known)
    ties = {tie.name: f"{tie.name}={tie.text}" for tie in experiment.ties if tie.name in values}
    used = {name for tie in experiment.ties if tie.name in ties for name in tie.names}
    words = [ties.get(name, f"{name}={value!r}") for name, value in values.items()]
    # Numbers that only expressions use have no start of their own.
    words += [f"{name}={value!r}" for name, value in fit.values.items() if name in used and name not in values]
    return kind, tuple(free_parameters(kind, words))


def _distance(
    truth: tuple[Experiment, tuple[Free, ...]], rival: tuple[Experiment, tuple[Free, ...]], time: Array, course: Array,
    noises: Mapping[str, float],
) -> float | str:  # fmt: skip
    """Return the residual of the true law under the rival, or why it cannot be simulated."""
    kind, free = truth
    record = imagined(kind, time, course, kind.tied({one.name: one.start for one in free}))
    if isinstance(record, str):
        return record
    sensors = {signal: Sensor(noises[signal]) for signal in kind.compared}
    if kind.name == "motion":
        problem = Problem.of(kind, [record], free, 0.0).seen_by(sensors)
        # The measured signal is zero there, so the difference is minus the simulation.
        [difference] = problem.differences(problem.start)
        record = Record(record.name, time, 0.0, {**record.signals, **{name: -one for name, one in difference.items()}})
    other, others = rival
    problem = Problem.of(other, [record], others, 0.0).seen_by(sensors).bounded()
    found = refine(problem, problem.start)
    [residuals] = problem.residuals([found.x])
    return float(np.linalg.norm(residuals))
