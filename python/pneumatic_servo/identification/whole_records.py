"""Laws that remember where they have been: a start from the balance of forces, and records that are not cut.

Segments of 0.15 s forget the noise of a force. But a segment begins without the deflection of its bristles, which
passes into the parameters. Where a force is exact, nothing has to be forgotten: each record is simulated as a whole.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pneumatic_servo.identification.experiments import INPUTS
from pneumatic_servo.identification.parameters import DAMPING_SPEED, Free, group_of
from pneumatic_servo.identification.problem import OtherForm, Problem
from pneumatic_servo.identification.records import Record
from pneumatic_servo.identification.sensor import Sensor
from pneumatic_servo.identification.solve import AT_NOISE, ROUGH, Solution, refine
from pneumatic_servo.identification.watch import Watch
from pneumatic_servo.model import Model

Array = NDArray[np.float64]

PRESLIDING = ("N/m", "1/m", "m")
"""Units of parameters of laws that deflect."""
WHOLE = 1e9
"""Length in s of segments that no record has."""
STEP, TOLERANCE = 1e-5, 1e-2
"""Step of the differences of runs, and the factor of the solver's tolerances, where nothing hides a small change."""


def remembers(law: str, model: Model) -> bool:
    """Tell whether friction of a law depends on deflections before."""
    group = group_of(law, model) + "."
    return any(
        variable.unit in PRESLIDING and variable.default != 0.0
        for name, variable in model.parameters.items()
        if name.startswith(group)
    )


def from_balance(
    problem: Problem, records: Sequence[Record], validation: float, extra: Sequence[Record], watch: Watch
) -> Problem:
    """Return a problem of a law with deflections with a better start, and with whole records if they bear it.

    A problem whose segments somebody chose, or whose motion is not measured by a position, is returned as it is.
    """
    experiment = problem.experiment
    if not (
        experiment.native.is_pushed
        and experiment.options.window is None
        and "position" in experiment.signals
        and remembers(experiment.law, experiment.table)
    ):
        return problem
    watch.stage("balance of forces")
    given = experiment.options.inputs
    # Pressures are never held.
    courses = INPUTS if given is None and experiment.name == "force" else (given,)
    wholes = [
        replace(
            Problem.of(
                experiment.with_options(window=WHOLE, smooths=False, inputs=course), records, problem.free, validation,
                extra,
            ),
            workers=problem.workers, step=STEP, exactness=TOLERANCE,
        )
        for course in courses
    ]  # fmt: skip
    free = _balanced(wholes[0])
    if free is None:
        return problem
    short = _better(problem, free)
    ends = []
    for whole in wholes:
        watch.stage(f"whole records, inputs {whole.experiment.options.inputs}")
        ends.append(_Whole.of(whole.with_free(free), watch))
        # A controller holds its command until the next sample; a measured force varies between two samples.
        if whole is wholes[0] and ends[0].loudness < AT_NOISE:
            break
    best = min(ends, key=lambda end: end.loudness)
    if best.loudness >= AT_NOISE:
        # Data that whole records of the other form describe are exact enough for whole records of the given one.
        others = (end.begun(free, other) for end in ends if (other := _other_form(end, watch)) is not None)
        return next(others, short)
    notes = best.problem.experiment.notes
    notes.append("records are simulated as a whole, and forces are not smoothed: nothing but noise is left so")
    if best is not ends[0]:
        how = {"lines": "on straight lines", "smooth": "on a smooth curve"}[
            best.problem.experiment.options.inputs or ""
        ]
        notes.append(f"between samples the inputs run {how}: held ones leave more than noise")
    return best.begun(free)


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

    @property
    def loudness(self) -> float:
        """The mean square of the residuals, in units of the noise."""
        return 2.0 * self.found.cost / self.trained.size

    def begun(self, free: Sequence[Free], other_form: OtherForm | None = None) -> Problem:
        """Return the problem from the end of the search on."""
        problem = replace(self.problem, other_form=other_form)
        return problem.begun(self.trained, self.found.x).with_free(_at(free, self.found.x))


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
    other = problem.with_free(free)
    costs = [float(np.sum(one.trained().residuals([one.trained().start])[0] ** 2)) for one in (problem, other)]
    return other if costs[1] < costs[0] else problem


def _at(free: Sequence[Free], x: Array) -> list[Free]:
    """Return parameters with other starts, as the solver sees them; bounds that nobody gave move along."""
    moved = []
    for one, inner in zip(free, x, strict=False):
        value = one.outer(float(inner))
        moved.append(replace(replace(one, is_given=False).at(value), is_given=one.is_given))
    return moved
