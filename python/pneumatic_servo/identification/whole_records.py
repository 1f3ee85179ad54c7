"""Records that are not cut, where a force or pressures are exact.

Segments of 0.15 s forget the noise of a force. But a segment begins without the deflection of its bristles, and
smoothing wipes out the course of a force at a break-away: both pass into the parameters. Where a force is exact,
nothing has to be forgotten: each record is simulated as a whole, of laws with deflections from a start that the balance
of forces gives.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.stats import t as student

from pneumatic_servo.identification.experiments import INPUTS
from pneumatic_servo.identification.parameters import DAMPING_SPEED, Free, group_of
from pneumatic_servo.identification.problem import OtherForm, Problem
from pneumatic_servo.identification.records import Record
from pneumatic_servo.identification.sensor import Sensor
from pneumatic_servo.identification.solve import AT_NOISE, FINE, ROUGH, Solution, refine
from pneumatic_servo.identification.watch import Watch
from pneumatic_servo.model import Model

Array = NDArray[np.float64]

PRESLIDING = ("N/m", "1/m", "m")
"""Units of parameters of laws that deflect."""
WHOLE = 1e9
"""Length in s of segments that no record has."""
STEP, TOLERANCE = 1e-5, 1e-2
"""Step of the differences of runs, and the factor of the solver's tolerances, where nothing hides a small change."""
BLOCKS, LEVEL = 20, 0.95
"""Stretches of time whose residuals are compared, and how sure the better ones have to be."""
LIKE = 10.0
"""Ratio of what two courses of inputs leave from which on only the better one is searched further."""


def remembers(law: str, model: Model) -> bool:
    """Tell whether friction of a law depends on deflections before."""
    group = group_of(law, model) + "."
    return any(
        variable.unit in PRESLIDING and variable.default != 0.0
        for name, variable in model.parameters.items()
        if name.startswith(group)
    )


class WholeRecords(NamedTuple):
    """Problems of whole records that take the place of one of segments where a force or pressures are exact.

    Attributes
    ----------
    problems : tuple of Problem
        For each course of the inputs between samples.
    """

    problems: tuple[Problem, ...]

    @classmethod
    def of(
        cls, problem: Problem, records: Sequence[Record], validation: float, extra: Sequence[Record]
    ) -> WholeRecords | None:
        """Return them for a mass under measured forces, if its position is measured and nobody chose the segments."""
        experiment = problem.experiment
        if not (experiment.native.is_pushed and experiment.options.window is None and "position" in experiment.signals):
            return None
        if experiment.options.smooths and not experiment.options.is_smoothing_free:
            return None
        given = experiment.options.inputs
        # Pressures are never held.
        courses = INPUTS if given is None and experiment.name == "force" else (given,)
        changed = [experiment.with_options(window=WHOLE, smooths=False, inputs=course) for course in courses]
        wholes = [Problem.of(other, records, problem.free, validation, extra) for other in changed]
        return cls(tuple(replace(one, workers=problem.workers, step=STEP, exactness=TOLERANCE) for one in wholes))

    def from_balance(self, segments: Problem, watch: Watch) -> Problem:
        """Return the problem that whole records bear from the balance of forces on, or segments with a better start.

        The segments of a law without deflections are returned as they are.
        """
        if not remembers(segments.experiment.law, segments.experiment.table):
            return segments
        watch.stage("balance of forces")
        free = _balanced(self.problems[0])
        if free is None:
            return segments
        segments = _better(segments, free)
        ends = self._ends(free, watch)
        best = min(ends, key=lambda end: end.loudness)
        if best.loudness >= AT_NOISE:
            # Data that whole records of the other form describe are exact enough for whole records of the given one.
            for end in ends:
                if (form := _other_form(end, watch)) is not None:
                    return end.begun(form)
            if best.loudness >= _mean_square(segments.with_free(_at(free, best.found.x))):
                return segments
        return self._noted(best).begun()

    def from_segments(self, segments: Problem, found: Solution, watch: Watch) -> Problem | None:
        """Return the problem that whole records bear from what segments gave, if it leaves less than these.

        Segments that leave no more than noise are not asked again: where they can, they forget the noise of the force.
        """
        if 2.0 * found.cost / segments.size < AT_NOISE:
            return None
        try:
            best = min(self._ends(_at(segments.free, found.x), watch), key=lambda end: end.loudness)
        finally:
            # Until they are taken, the best vector is the one of the segments.
            watch.best = found.x
        return self._noted(best).begun() if best.loudness < 2.0 * found.cost / segments.size else None

    def _ends(self, free: Sequence[Free], watch: Watch) -> list[_Whole]:
        """Return the ends of searches from a start."""
        ends = []
        for whole in self.problems:
            watch.stage(f"whole records, inputs {whole.experiment.options.inputs or INPUTS[0]}")
            ends.append(_Whole.of(whole.with_free(free), watch))
            # A controller holds its command until the next sample; a measured force varies between two samples.
            if len(ends) == 1 and ends[0].loudness < AT_NOISE:
                break
        least = min(end.loudness for end in ends)
        return [end.further(watch) if end.loudness < LIKE * least else end for end in ends]

    def _noted(self, best: _Whole) -> _Whole:
        """Say how records are simulated."""
        experiment = best.problem.experiment
        left = "nothing but noise is left so" if best.loudness < AT_NOISE else "segments of smoothed forces leave more"
        experiment.notes.append(f"records are simulated as a whole, and forces are not smoothed: {left}")
        if experiment is not self.problems[0].experiment:
            experiment.notes.append(_note_on(experiment.options.inputs))
        return best


class _Whole(NamedTuple):
    """A problem of whole records, its fitted part, and the end of a search from its start."""

    problem: Problem
    trained: Problem
    found: Solution

    @classmethod
    def of(cls, whole: Problem, watch: Watch) -> _Whole:
        """Search."""
        trained = whole.trained().bounded()
        return cls(whole, trained, refine(trained, trained.start, "linear", watch, ROUGH))

    def further(self, watch: Watch) -> _Whole:
        """Search on from the end, with other scales, as long as it more than halves what is left."""
        end, before = self, np.inf
        while AT_NOISE <= end.loudness < 0.5 * before:
            before = end.loudness
            end = end._replace(found=refine(end.trained, end.found.x, "linear", watch, ROUGH))
        return end

    @property
    def loudness(self) -> float:
        """The mean square of the residuals, in units of the noise."""
        return 2.0 * self.found.cost / self.trained.size

    def begun(self, other_form: OtherForm | None = None) -> Problem:
        """Return the problem from the end of the search on."""
        problem = replace(self.problem, other_form=other_form)
        return problem.begun(self.trained, self.found.x).with_free(_at(problem.free, self.found.x))


def under_likely_inputs(
    problem: Problem, fitted: Problem, found: Solution, loss: str, watch: Watch
) -> tuple[Problem, Problem, Solution]:
    """Return a problem, its fitted part and a solution under the course of a measured force that leaves least."""
    own = fitted.experiment
    if own.name != "force" or own.options.inputs is not None:
        return problem, fitted, found
    ends = [(own, found)]
    for course in INPUTS[1:]:
        watch.stage(f"inputs {course}")
        experiment = own.with_options(inputs=course)
        experiment.notes.extend([*own.notes, _note_on(course)])
        ends.append((experiment, refine(replace(fitted, experiment=experiment), found.x, loss, watch, ROUGH)))
    experiment, found = min(ends, key=lambda end: end[1].cost)
    watch.best = found.x
    return replace(problem, experiment=experiment), replace(fitted, experiment=experiment), found


def under_likely_smoothing(
    problem: Problem, fitted: Problem, found: Solution, records: Sequence[Record], extra: Sequence[Record],
    validation: float, loss: str, watch: Watch,
) -> tuple[Problem, Problem, Solution]:  # fmt: skip
    """Return a problem, its fitted part and a solution, with measured forces unsmoothed if that leaves less.

    Smoothing wipes out the course of a force that is exact; where its noise breaks a mass away, or nothing tells which
    is better, it stays.
    """
    own = fitted.experiment
    if not (own.native.is_pushed and own.options.smooths and own.options.is_smoothing_free):
        return problem, fitted, found
    watch.stage("forces without smoothing")
    raw = Problem.of(own.with_options(smooths=False), records, problem.free, validation, extra)
    raw = replace(raw, workers=problem.workers, jac=problem.jac, sensors=problem.sensors)
    trained = raw.trained().bounded()
    if len(trained.start) != len(found.x) or trained.size != fitted.size:
        return problem, fitted, found
    best = refine(trained, found.x, loss, watch, FINE)
    if not _leaves_less(trained, best, fitted, found):
        watch.best = found.x
        return problem, fitted, found
    raw.experiment.notes.append("measured forces are not smoothed: smoothed ones leave more")
    return raw, trained, best


def _leaves_less(one: Problem, found: Solution, other: Problem, base: Solution) -> bool:
    """Tell whether one problem leaves less of the same samples than another, by more than chance.

    The noise of a force makes autocorrelated residuals, of which a few percent less say nothing: the gains of
    stretches of time have to agree.
    """
    blocks = one.blocks(BLOCKS)
    squares = [problem.residuals([end.x])[0] ** 2 for problem, end in ((one, found), (other, base))]
    gains = np.bincount(blocks, squares[1] - squares[0])
    return bool(np.mean(gains) > student.ppf(LEVEL, len(gains) - 1) * np.std(gains, ddof=1) / np.sqrt(len(gains)))


def _note_on(course: str | None) -> str:
    """Return a note on inputs that are not held."""
    how = "on straight lines" if course == "lines" else "on a smooth curve"
    return f"between samples the inputs run {how}: held ones leave more"


def _other_form(end: _Whole, watch: Watch) -> OtherForm | None:
    """Return the other form of a law whose form is fixed, if whole records of it leave no more than noise.

    Segments and smoothed forces hide which form is right.
    """
    whole = end.problem
    for name, given, others in whole.suspects()[2]:
        if name != DAMPING_SPEED:
            continue
        for other in others:
            watch.stage(f"{name} = {other}")
            changed = replace(whole, experiment=whole.experiment.with_setting(name, float(other)))
            free = _balanced(changed)
            if free is None:
                continue
            left = _Whole.of(changed.with_free(free), watch).loudness
            if left < AT_NOISE:
                return OtherForm(name, given, other, end.loudness, left)
    return None


def _balanced(whole: Problem) -> list[Free] | None:
    """Return the estimated parameters that best balance the forces along the measured motion."""
    balance = whole.experiment.balance()
    windows = [balance.balanced(window) for window in whole.windows]
    used = tuple(window for window in windows if window.fitted)
    if not used:
        return None
    problem = Problem(balance, used, whole.free, {balance.compared[0]: Sensor(1.0)}, whole.workers)
    start = problem.residuals([problem.start])
    if not len(start[0]) or not np.sqrt(np.mean(start**2)) < 1e9:
        return None
    found = refine(problem.bounded(), problem.start, effort=ROUGH)
    return _at(whole.free, found.x)


def _better(problem: Problem, free: Sequence[Free]) -> Problem:
    """Return the problem with the start that leaves less."""
    return min(problem, problem.with_free(free), key=_mean_square)


def _mean_square(problem: Problem) -> float:
    """Return the mean square of the residuals at the start, in units of the noise."""
    trained = problem.trained()
    return float(np.mean(trained.residuals([trained.start])[0] ** 2))


def _at(free: Sequence[Free], x: Array) -> list[Free]:
    """Return parameters with other starts, as the solver sees them; bounds that nobody gave move along."""
    moved = []
    for one, inner in zip(free, x, strict=False):
        value = one.outer(float(inner))
        moved.append(replace(replace(one, is_given=False).at(value), is_given=one.is_given))
    return moved
