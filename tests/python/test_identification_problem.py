"""What a problem makes of records: windows, what is held out of them, and numbers in the order of its samples."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from bounds import assert_close
from numpy.typing import NDArray
from pneumatic_servo.identification.experiments import Options
from pneumatic_servo.identification.experiments.base import Beginning
from pneumatic_servo.identification.fitting import make_experiment
from pneumatic_servo.identification.parameters import Free, parse
from pneumatic_servo.identification.problem import FAILED, PULL, Problem
from pneumatic_servo.identification.records import Record
from pneumatic_servo.identification.sensor import Sensor

Array = NDArray[np.float64]


def record(name: str, samples: int = 400, begin: float = 0.0) -> Record:
    """Dry friction with a noise of 0.1 N, which is off by another one by record."""
    rng = np.random.default_rng(len(name))
    time = 0.01 * np.arange(samples)
    position = 0.02 * np.sin(2.0 * np.pi * 0.7 * time)
    way = np.sign(np.append(0.0, np.diff(position)))
    return Record(
        name, time, begin, {"position": position, "frictionForce": 7.0 * way + 0.1 * rng.standard_normal(samples)}
    )


def left(one: Record) -> Array:
    """What is left of a record by a friction of 7 N."""
    return one.signals["frictionForce"] - 7.0 * np.sign(np.append(0.0, np.diff(one.signals["position"])))


FIRST, SECOND, EXTRA = record("a"), record("bb", 300, 5.0), record("ccc", 200)
FC = "friction.coulomb.Fc"


@pytest.fixture
def problem() -> Problem:
    """Two records, of which the last quarter is held out, and one that is held out as a whole; Fc is free."""
    kind = make_experiment("motion", "Coulomb", {"friction.coulomb.sigma2": 0.0}, Options(play=0.0))
    kind.use(["time", "position", "frictionForce"])
    return Problem.of(kind, [FIRST, SECOND], [parse(f"{FC}=7", kind.table, ["frictionForce"])], 0.25, [EXTRA])


def test_last_part_of_each_record_and_the_extra_one_are_held_out(problem: Problem) -> None:
    assert [window.record for window in problem.windows] == [FIRST, SECOND, EXTRA]
    for window, one in zip(problem.windows[:2], (FIRST, SECOND), strict=True):
        assert np.array_equal(window.held, one.time > 0.75 * one.time[-1])
    assert np.all(problem.windows[2].held)
    # At the first sample nothing has moved.
    assert all(np.array_equal(window.used, window.record.time > 0.0) for window in problem.windows)
    fitted = [299, 224, 0]
    assert [window.fitted for window in problem.windows] == fitted and problem.size == sum(fitted)
    expected = np.concatenate(
        [one.signals["frictionForce"][1 : 1 + size] for one, size in ((FIRST, 299), (SECOND, 224))]
    )
    assert np.array_equal(problem.measured()["frictionForce"], expected)
    none = Problem.of(problem.experiment, [FIRST], problem.free, 0.0)
    assert not np.any(none.windows[0].held)


def test_fit_sees_no_more_than_what_it_is_given(problem: Problem) -> None:
    trained = problem.trained()
    assert [len(window.record.time) for window in trained.windows] == [300, 225]
    for window, one in zip(trained.windows, (FIRST, SECOND), strict=True):
        size = len(window.record.time)
        assert len(window.record.grid) == len(window.driven["position"]) == size and window.fitted == size - 1
        assert np.array_equal(window.record.signals["frictionForce"], one.signals["frictionForce"][:size])
        assert len(window.used) == len(window.held) == size
    x = problem.start
    assert_close(trained.residuals([x])[0], problem.residuals([x])[0], within=5e-14, what="residuals")


def test_what_is_left_is_told_of_what_is_fitted_and_of_what_is_held_out(problem: Problem) -> None:
    x = problem.start
    fitted = np.concatenate([left(FIRST)[1:300], left(SECOND)[1:225]])
    held = np.concatenate([left(FIRST)[300:], left(SECOND)[225:], left(EXTRA)[1:]])
    for is_held, expected in ((False, fitted), (True, held)):
        assert_close(problem.stacked([x], held=is_held)[0], expected, within=3e-11, what="differences")
        rms = problem.rms(x, held=is_held)["frictionForce"]
        assert_close(rms, np.sqrt(np.mean(expected**2)), rel=1.5e-13, what="rms")
    noise = problem.sensors["frictionForce"].noise
    assert_close(problem.residuals([x])[0], fitted / noise, within=1e-10, what="residuals")
    [sensor] = problem.likely_sensors(x).values()
    assert_close(sensor.noise, np.sqrt(np.mean(fitted**2)), rel=1.5e-13, what="likely noise")
    assert Problem.of(problem.experiment, [FIRST], problem.free, 0.0).rms(x, held=True) == {}


def test_run_that_fails_is_worse_than_any_other(problem: Problem, monkeypatch: pytest.MonkeyPatch) -> None:
    lost = np.full((1, problem.size), np.nan)
    monkeypatch.setattr(Problem, "stacked", lambda self, vectors: lost)
    assert np.all(problem.residuals([problem.start]) == FAILED)
    nothing = [[{"frictionForce": np.full(len(window.used), np.nan)} for window in problem.windows]]
    monkeypatch.setattr(Problem, "differences", lambda self, vectors: nothing)
    # Of which no sensor is learned.
    assert problem.likely_sensors(problem.start) == problem.sensors


def test_parameters_without_bounds_are_drawn_to_their_starts() -> None:
    """By one deviation, a factor of 4.5, in logarithms; those that may be anything, and those with bounds, are not."""
    free = [
        Free("a", "N", 2.0, 0.1, 10.0, 0.0), Free("b", "m", 2.0, -np.inf, np.inf, 0.5),
        Free("c", "N", 2.0, 1.0, 10.0, 0.0, is_bounded=True),
    ]  # fmt: skip
    windows = [SimpleNamespace(begin=Beginning({"position0": 0.1}, ("position0",)))]
    experiment: Any = SimpleNamespace(held={"known": 3.0})
    problem = Problem(experiment, tuple(windows), tuple(free), {})  # type: ignore[arg-type]
    assert_close(problem.start, np.array([np.log(2.0), 4.0, np.log(2.0), 0.0]), within=4e-14, what="start")
    pulls = problem.pulls(problem.start + np.array([np.log(4.5), 1.0, 1.0, 1.0]))
    assert_close(pulls, np.array([1.0, 0.0, 0.0, 0.0]), within=0.003, what="pulls", why="4.5 is a rounded number")
    assert problem.pull.tolist() == pytest.approx([1.0 / PULL, 0.0, 0.0, 0.0])
    low, high = problem.bounds
    assert_close(np.exp(low[[0, 2]]), np.array([0.1, 1.0]), rel=1e-14, what="lower bounds")
    assert_close(np.exp(high[[0, 2]]), np.array([10.0, 10.0]), rel=1e-14, what="upper bounds")
    assert (low[1], high[1], low[3], high[3]) == (-np.inf, np.inf, -np.inf, np.inf)
    assert problem.values(np.array([0.0, 4.0, 0.0, 9.0])) == {"known": 3.0, "a": 1.0, "b": 2.0, "c": 1.0}
    # The beginning moves by tenths of a millimetre, if it is in the vector.
    [begin] = problem.begins(np.array([0.0, 0.0, 0.0, 2.0]))
    assert_close(begin["position0"], 0.1002, rel=1e-14, what="beginning")
    assert problem.begins(np.zeros(3)) == [{"position0": 0.1}]


def of_windows(fitted: list[int], compared: str = "p", names: str = "") -> Any:
    """A problem as far as its samples are counted."""
    named = names or "a" * len(fitted)
    windows = [
        SimpleNamespace(fitted=size, record=SimpleNamespace(name=name))
        for size, name in zip(fitted, named, strict=True)
    ]
    return SimpleNamespace(windows=windows, experiment=SimpleNamespace(compared=tuple(compared)))


@pytest.mark.parametrize(
    ("fitted", "compared", "number", "expected"),
    [
        # Stretches of as many samples, over windows and all their signals.
        ([6], "p", 3, "001122"),
        ([7], "p", 3, "0001112"),
        ([4, 3], "p", 2, "0000" "111"),
        ([5, 1], "p", 3, "00112" "2"),
        ([4], "pq", 2, "0011" "0011"),
        # As many windows as blocks are not cut; short ones share a block.
        ([1, 1, 4], "p", 3, "0" "0" "1111"),
        ([2, 2], "p", 1, "00" "00"),
        ([3], "p", 10, "012"),
    ],
)  # fmt: skip
def test_blocks_are_stretches_of_time(fitted: list[int], compared: str, number: int, expected: str) -> None:
    found = Problem.blocks(of_windows(fitted, compared), number)
    assert "".join(map(str, found)) == expected and found.dtype == np.int64


def test_samples_know_their_records() -> None:
    found = Problem.records(of_windows([2, 1, 3], "pq", "xyx"))
    assert found.tolist() == [0] * 4 + [1] * 2 + [0] * 6


def test_windows_of_the_same_times_run_together() -> None:
    grids = [(10, 0.1), (20, 0.1), (10, 0.1), (10, 0.2)]
    windows = [SimpleNamespace(record=SimpleNamespace(grid=np.zeros(size), step=step)) for size, step in grids]
    assert Problem.groups(SimpleNamespace(windows=windows)) == [[0, 2], [1], [3]]  # type: ignore[arg-type]


def test_each_signal_is_seen_by_its_own_sensor() -> None:
    problem = of_windows([2, 1], "pq")
    problem.sensors = {"p": Sensor(1.0), "q": Sensor(0.5)}
    found = Problem.by_sensor(problem, Sensor.residuals, np.ones(6))
    assert found.tolist() == [1.0, 1.0, 2.0, 2.0, 1.0, 2.0]


def test_late_reading_is_compared_with_what_was_true_before(problem: Problem) -> None:
    """On straight lines between the points of the simulation."""
    kind = problem.experiment
    free = [*problem.free, parse("delay.frictionForce", kind.table, kind.compared, kind.beside)]
    late = Problem.of(kind, [FIRST], free, 0.0)
    window = late.windows[0]
    x = late.start.copy()
    x[1] = free[1].inner(0.015)
    [[found]] = late.differences([x])
    true = 7.0 * np.sign(np.append(0.0, np.diff(FIRST.signals["position"])))
    seen = np.interp(FIRST.time - 0.015, FIRST.time, true)
    expected = FIRST.signals["frictionForce"] - seen
    assert_close(found["frictionForce"][window.used][2:], expected[window.used][2:], within=3e-11, what="differences")


def test_run_may_take_twenty_times_the_steps_of_the_start(problem: Problem) -> None:
    """Of the record that takes most: each of its 399 intervals takes a step, and a few more where friction turns."""
    most = problem.bounded().most
    assert most is not None and most % 20 == 0 and 399 <= most // 20 < 420
    enough, half = (replace(problem, most=steps).residuals([problem.start])[0] for steps in (most // 20, most // 40))
    assert np.all(np.abs(enough) < 100.0)
    assert np.abs(half[0]) < 100.0 and half[problem.windows[0].fitted - 1] == FAILED


def test_windows_begin_as_the_fit_has_found(problem: Problem) -> None:
    """Those of which nothing is fitted begin as they were measured."""
    begun = [replace(window, begin=Beginning({"position0": 0.1}, ("position0",))) for window in problem.windows]
    whole = replace(problem, windows=tuple(begun))
    trained = whole.trained()
    x = np.append(trained.start[:1], [3.0, -2.0])
    starts = [window.begin.values["position0"] for window in whole.begun(trained, x).windows]
    assert_close(starts, np.array([0.1003, 0.0998, 0.1]), rel=1e-14, what="beginnings")
    assert (whole.loose, trained.loose) == ((1, 1, 1), (1, 1))


def test_all_friction_is_scaled(problem: Problem) -> None:
    """By a factor of the problem, of which only what is left knows: twice the friction leaves 7 N more."""
    twice = replace(problem, scale=2.0)
    way = problem.measured()["frictionForce"] - problem.stacked([problem.start])[0]
    assert_close(
        twice.stacked([problem.start])[0], problem.stacked([problem.start])[0] - way, within=1e-13, what="twice"
    )
    viscous = {"friction.coulomb.Fc": 7.0, "friction.coulomb.sigma2": 30.0}
    groups = problem.groups()
    one, two = (
        whole.run(groups[0], [(viscous, whole.begins(whole.start))], ["frictionForce"])["frictionForce"][0]
        for whole in (problem, twice)
    )
    assert_close(two, 2.0 * one, within=3e-13, what="dry and viscous friction")
