"""An interrupted study resumes: complete parts are kept, with the bits of one call."""

from __future__ import annotations

import copy
import pickle
from collections.abc import Callable, Mapping
from functools import partial
from typing import Any

import numpy as np
import pandas
import pneumatic_servo as ps
import pytest

ZONES = np.linspace(0.0, 0.2, 40)
GIVEN: dict[str, Any] = {
    "parameters": {"valve.deadZone": ZONES}, "inputs": {"valveVoltage": np.linspace(6.0, 7.0, 40)}, "stop": 0.1,
    "step": 1e-3, "outputs": ["valveVoltage", "position"],
}  # fmt: skip
LONG: dict[str, Any] = {"common": {"friction.law": "Bristle"}, "stop": 1.0}
"""A step of breaking bonds takes longest."""


def interrupted(many: Callable[..., ps.Runs], at: int, **given: Any) -> ps.Runs:
    def progress(done: int, total: int) -> None:
        if done >= at:
            raise KeyboardInterrupt

    with pytest.raises(ps.Interrupted) as caught:
        many(progress=progress, **given)
    finished: Any = caught.value.finished
    assert isinstance(finished, ps.Runs)
    return finished


def test_interrupted_study_is_resumed_where_it_ended() -> None:
    many = partial(ps.Model().simulate_many, **GIVEN | LONG)
    finished: ps.Runs = pickle.loads(pickle.dumps(interrupted(many, 1, workers=1)))
    before = int(np.sum(finished.is_complete))
    assert 0 < before < 40
    told: list[tuple[int, int]] = []
    runs = many(resume=finished, progress=lambda *counts: told.append(counts))
    assert runs.is_complete.all() and told[-1] == (40 - before, 40 - before)
    assert runs["position"].tobytes() == many(progress=False)["position"].tobytes()
    # Complete as it is, it is not made again.
    again = many(resume=runs, progress=lambda *counts: told.append(counts))
    assert again["position"].tobytes() == runs["position"].tobytes() and told[-1] == (40 - before, 40 - before)


class Counting:
    made = 0

    def __call__(self, time: float, seen: Mapping[str, float]) -> float:
        Counting.made += time == 0.0
        return 5.0 + 20.0 * (0.25 - seen["position"])


def test_study_of_closed_loops_is_resumed_too() -> None:
    given: dict[str, Any] = {"parameters": {"mass.moving": np.linspace(0.8, 1.2, 5)}, "controller": Counting(),
                             "stop": 0.05, "step": 1e-3, "outputs": ["position"]}  # fmt: skip
    many = ps.Model().simulate_many
    finished = interrupted(many, 2, **given)
    assert finished.is_complete.tolist() == [True, True, False, False, False] and Counting.made == 2
    runs = many(resume=finished, progress=False, **given)
    assert Counting.made == 5
    assert runs["position"].tobytes() == many(progress=False, **given)["position"].tobytes()


T = np.linspace(0.0, 0.1, 5)
NOTATIONS: dict[str, Any] = {
    "constant": 6.0,
    "one for each": np.linspace(6.0, 7.0, 40),
    "points": (T, 5.0 + T),
    "hold": {"hold": (T, 5.0 + T)},
    "lines": {"lines": (T, 5.0 + T)},
    "two columns": np.array([T, 5.0 + T]).T,
    "two points": ([0.0, 0.1], [5.0, 6.0]),
    "as many points as runs": (np.linspace(0.0, 0.1, 40), np.linspace(5.0, 6.0, 40)),
    "for each run": (T, 5.0 + np.outer(np.ones(40), T)),
    "series": pandas.Series(5.0 + T, index=T),
    "function": lambda t: 5.0 + t,
}


@pytest.mark.parametrize("notation", NOTATIONS)
def test_inputs_are_recognised_in_every_notation(notation: str) -> None:
    many = partial(
        ps.Model().simulate_many, **{**GIVEN, "inputs": {"valveVoltage": NOTATIONS[notation]}}, progress=False
    )
    runs = many()
    assert many(resume=runs)["position"].tobytes() == runs["position"].tobytes()
    with pytest.raises(ValueError, match="the input valveVoltage of the earlier runs is another one"):
        many(resume=runs, inputs={"valveVoltage": (T, 5.0 + 2.0 * T)})


def proportional(gain: float) -> Callable[[float, Mapping[str, float]], float]:
    return lambda time, seen: 5.0 + gain * (0.25 - seen["position"])


def test_another_controller_is_refused() -> None:
    many = partial(ps.Model().simulate_many, number=2, stop=0.02, step=1e-3, outputs=["position"], progress=False)
    earlier = pickle.loads(pickle.dumps(many(controller=proportional(20.0))))
    assert many(controller=proportional(20.0), resume=earlier)["position"].tobytes() == earlier["position"].tobytes()
    for other in ({"controller": proportional(21.0)}, {"controller": proportional(20.0), "delay": 1e-3}):
        with pytest.raises(ValueError, match="the earlier runs had another controller"):
            many(resume=earlier, **other)
    with pytest.raises(ValueError, match="the earlier runs had a controller"):
        many(resume=earlier)


OTHER: dict[str, tuple[dict[str, Any], str]] = {
    "another value": ({"parameters": {"valve.deadZone": ZONES + 0.01}}, "valve.deadZone of run 0 was 0.0, and here it"),
    "another parameter": ({"common": {"mass.moving": 2.0}}, "mass.moving of run 0 was not given, and here it is 2.0"),
    "another input": ({"inputs": {"valveVoltage": np.linspace(6.0, 7.1, 40)}}, "the input valveVoltage of the earlier"),
    "another end": ({"stop": 0.2}, "the earlier runs have 101 rows up to 0.1 s, these 201 up to 0.2 s"),
    "other outputs": ({"outputs": ["position"]}, "the earlier runs recorded valveVoltage, position, not position"),
    "no runs": ({"resume": {"position": 1.0}}, "resume must be the `finished` of runs"),
}


@pytest.mark.parametrize("case", OTHER)
def test_runs_of_another_study_are_refused(case: str) -> None:
    changed, words = OTHER[case]
    many = ps.Model().simulate_many
    earlier = many(progress=False, **GIVEN)
    with pytest.raises((TypeError, ValueError), match=words):
        many(**{**GIVEN, "resume": earlier, "progress": False, **changed})


def test_run_that_failed_is_kept_as_it_is() -> None:
    """A repetition would fail again."""
    many = ps.Model().simulate_many
    earlier = many(progress=False, **GIVEN)
    short = copy.copy(earlier)
    short.rows, short.failures = earlier.rows.copy(), {3: "the solver cannot go on"}
    short.rows[3] = 50
    runs = many(resume=short, keep_failures=True, progress=False, **GIVEN)
    assert runs.failures == short.failures and runs.rows[3] == 50
    with pytest.raises(ps.SimulationError, match="run 3 of 40: the solver cannot go on"):
        many(resume=short, progress=False, **GIVEN)
