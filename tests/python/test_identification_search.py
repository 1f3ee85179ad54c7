"""How a search looks around: derivatives by runs beside it, starts that fill the bounds, and when it has enough."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from bounds import assert_close
from numpy.typing import NDArray
from pneumatic_servo.identification import solve as search
from pneumatic_servo.identification.sensor import Sensor
from pneumatic_servo.identification.solve import (
    ROUGH,
    STEP,
    Effort,
    Solution,
    _is_enough,
    jacobian,
    scattered,
    sensitivities,
)

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Curved:
    """Two windows of two signals: differences are of second degree, and each window sees its own beginnings alone."""

    low: float = -np.inf
    high: float = np.inf
    refused_above: float = np.inf
    refused_below: float = -np.inf
    tolerance: float = 0.0
    workers: int | None = None

    free = (None, None)
    loose = (2, 1)
    windows = (SimpleNamespace(fitted=3), SimpleNamespace(fitted=2))
    experiment = SimpleNamespace(compared=("p", "q"))
    start = np.array([0.5, -0.25, 0.1, 0.2, 0.3])
    size = 10

    @property
    def bounds(self) -> tuple[Array, Array]:
        none = np.full(3, np.inf)
        return np.array([self.low, -np.inf, *-none]), np.array([self.high, np.inf, *none])

    @property
    def matrices(self) -> tuple[Array, Array]:
        """Those of the first and of the second power: 6 and 4 rows."""
        first, second = np.random.default_rng(1).standard_normal((2, 10, 5))
        seen = np.ones((10, 5))
        seen[:6, 4] = seen[6:, 2:4] = 0.0
        return first * seen, second * seen

    def stacked(self, vectors: list[Array]) -> Array:
        first, second = self.matrices
        runs = [first @ x + second @ x**2 for x in vectors]
        refused = [not self.refused_below <= x[0] <= self.refused_above for x in vectors]
        return np.array([np.full(10, np.nan) if one else run for one, run in zip(refused, runs, strict=True)])

    def residuals(self, vectors: list[Array]) -> Array:
        return self.stacked(vectors) / 0.1

    def by_sensor(self, of: Any, stacked: Array) -> Array:
        return of(Sensor(0.1), stacked)


def slopes(problem: Curved, sides: float) -> Array:
    """The derivatives at the start; differences of the first parameter to one side see half a step of its curvature."""
    first, second = problem.matrices
    found = first + 2.0 * second * problem.start
    found[:, 0] += sides * STEP * second[:, 0]
    return found


@pytest.mark.parametrize(
    ("limits", "sides"),
    [
        ({}, 0.0),
        # At a bound, and where a run is refused, the other side tells.
        ({"high": 0.5}, -1.0),
        ({"low": 0.5}, 1.0),
        ({"refused_above": 0.5}, -1.0),
        ({"refused_below": 0.5}, 1.0),
        # A step that a bound cuts short is as long as it is.
        ({"high": 0.5 + 0.5 * STEP}, -0.5),
    ],
)
def test_derivatives_are_those_of_both_sides_or_of_the_one_that_there_is(
    limits: dict[str, float], sides: float
) -> None:
    problem: Any = Curved(**limits)
    found, base = sensitivities(problem, problem.start)
    assert np.array_equal(base, problem.stacked([problem.start])[0])
    assert_close(found, slopes(problem, sides), within=1.5e-12, what="derivatives")
    # In units of the noise.
    assert_close(jacobian(problem, problem.start), 10.0 * found, within=2e-13, what="derivatives of the residuals")


def test_quick_derivatives_are_those_of_one_side() -> None:
    problem: Any = Curved()
    _, second = problem.matrices
    found, _ = sensitivities(problem, problem.start, is_central=False)
    assert_close(found, slopes(problem, 0.0) + STEP * second, within=1.5e-12, what="derivatives")
    # But where there is none above.
    for limits in ({"high": 0.5}, {"refused_above": 0.5}):
        bounded: Any = Curved(**limits)
        found = jacobian(bounded, problem.start, is_central=False)
        assert_close(found[:, 0], 10.0 * slopes(problem, -1.0)[:, 0], within=7e-12, what="derivatives at a bound")


def test_what_is_refused_on_both_sides_has_no_derivative() -> None:
    problem: Any = Curved(refused_above=0.5, refused_below=0.5)
    assert not np.any(sensitivities(problem, problem.start)[0][:, 0])


def test_starts_fill_the_bounds_evenly() -> None:
    """Of twenty each has a twentieth of the range of its own; what windows begin with stays."""
    problem: Any = Curved(low=0.0, high=1.0)
    found = np.array(scattered(problem, 20, seed=3))
    assert sorted((20.0 * found[:, 0]).astype(int)) == list(range(20))
    # Without bounds within 1.6 of the first start.
    assert sorted(np.floor((found[:, 1] + 0.25 + 1.6) / 0.16).astype(int)) == list(range(20))
    assert np.array_equal(found[:, 2:], np.tile(problem.start[2:], (20, 1)))
    assert np.array_equal(found, scattered(problem, 20, seed=3))
    assert not np.array_equal(found, scattered(problem, 20, seed=4))
    assert scattered(problem, 0, seed=3) == []


def ended(cost: float, *, converged: bool = True, x: float = 0.0) -> Solution:
    return Solution(np.array([x]), cost, converged, "")


@pytest.mark.parametrize(
    ("costs", "is_enough"),
    [
        # The cost is half the sum of squares: of ten residuals noise alone leaves 5, and half as much again is near it.
        ([7.4], True),
        ([7.6], False),
        # Two that have come to the same end, wherever others are; the last counts for the noise.
        ([100.0, 100.09], True),
        ([100.0, 100.11], False),
        ([100.0, 300.0, 300.0], False),
        ([300.0, 100.0, 100.05], True),
        ([300.0, 7.4], True),
        ([7.4, 300.0], False),
    ],
)
def test_search_has_enough_at_the_noise_or_where_two_meet(costs: list[float], is_enough: bool) -> None:
    problem: Any = Curved()
    assert _is_enough(problem, [ended(cost) for cost in costs]) is is_enough


def test_executor_refines_the_first_start_and_the_best(monkeypatch: pytest.MonkeyPatch) -> None:
    """Of forty in two tasks; the best end is the first, and of two that are as good the one that has converged."""
    starts = [np.array([float(k)]) for k in range(40)]
    costs = np.arange(40.0)[::-1] + 20.0
    told: list[str] = []
    looked: list[tuple[float, float]] = []
    watch: Any = SimpleNamespace(done=told.append, see=lambda x, mean: looked.append((float(x[0]), mean)))
    tasks: list[int] = []

    def simulate(problem: Any, vectors: list[Array]) -> Array:
        assert problem.workers == 1
        tasks.append(len(vectors))
        return np.array([costs[int(x[0])] for x in vectors])

    def refine(problem: Any, start: Array, loss: str, watch: Any, effort: Any) -> Solution:
        assert (problem.workers, loss, watch, effort) == (1, "huber", None, ROUGH)
        return ended(4.0, converged=start[0] != 39.0, x=float(start[0]))

    monkeypatch.setattr(search, "_costs", simulate)
    monkeypatch.setattr(search, "refine", refine)
    monkeypatch.setattr(search, "scattered", lambda problem, number, seed: starts[1 : 1 + number])
    monkeypatch.setattr(Curved, "start", starts[0])
    problem: Any = Curved()
    with ThreadPoolExecutor(1) as executor:
        best, solutions = search.solve(problem, 39, 0, "huber", executor, watch)
        assert [solution.x[0] for solution in solutions] == [0.0, 38.0, 39.0] and best is solutions[0]
        assert tasks == [32, 8] and told == ["40 starts are simulated, 3 are refined"]
        # The mean squares of the best start and of the ends, of ten residuals.
        assert looked == [(39.0, 2.0), (0.0, 0.8), (39.0, 0.8), (38.0, 0.8)]
        # Alone the first is all.
        assert len(search.solve(problem, 0, 0, "huber", executor, watch)[1]) == 1


def test_starts_are_tried_until_there_is_enough(monkeypatch: pytest.MonkeyPatch) -> None:
    starts = [np.array([float(k)]) for k in range(4)]
    ends = {0: 300.0, 1: 200.0, 2: 100.0, 3: 100.0}
    monkeypatch.setattr(search, "_costs", lambda problem, vectors: np.array([-x[0] for x in vectors]))
    monkeypatch.setattr(search, "refine", lambda problem, x, *given: ended(ends[int(x[0])], x=float(x[0])))
    monkeypatch.setattr(search, "scattered", lambda problem, number, seed: starts[1 : 1 + number])
    monkeypatch.setattr(Curved, "start", starts[0])
    problem: Any = Curved()
    told: list[str] = []
    watch: Any = SimpleNamespace(done=told.append)
    best, solutions = search.solve(problem, 3, 0, watch=watch)
    # The two best of three, beside the first.
    assert [solution.x[0] for solution in solutions] == [3.0, 2.0, 0.0] and best.cost == 100.0
    assert told == ["start 3 of 3"]
    ends[3] = 1.0
    assert [solution.x[0] for solution in search.solve(problem, 3, 0)[1]] == [3.0, 0.0]
    ends[0] = 1.0
    assert [solution.x[0] for solution in search.solve(problem, 3, 0)[1]] == [0.0]


def test_costs_are_sums_of_squares_of_quick_runs() -> None:
    problem: Any = Curved(tolerance=1.0)
    seen: list[float] = []

    class Noted(Curved):
        def residuals(self, vectors: list[Array]) -> Array:
            seen.append(self.tolerance)
            return super().residuals(vectors)

    noted: Any = Noted()
    vectors = [problem.start, 2.0 * problem.start]
    expected = [sum(one**2) for one in problem.residuals(vectors)]
    assert_close(search._costs(noted, vectors), np.array(expected), rel=1e-14, what="costs")
    assert seen == [ROUGH.tolerance]


class Drawn(Curved):
    """The same with a pull to 0 by 3, 0 and nothing for what windows begin with."""

    pull = np.array([3.0, 0.0, 0.0, 0.0, 0.0])

    def pulls(self, x: Array) -> Array:
        return self.pull * x


@pytest.mark.parametrize("loss", ["linear", "huber"])
def test_refinement_goes_down_all_residuals_as_it_is_told(loss: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """Of a linear loss the least squares see fewer residuals, with the same sum of squares and the same slopes."""
    problem: Any = Drawn(high=0.4)
    seen: list[tuple[Any, ...]] = []
    looked: list[tuple[Array, float]] = []
    watch: Any = SimpleNamespace(see=lambda x, mean: looked.append((x, mean)))
    ends = SimpleNamespace(x=np.ones(5), cost=7.0, status=2, message="enough")

    def least_squares(function: Any, start: Array, **options: Any) -> Any:
        seen.append((start, function(start), options.pop("jac")(start), options))
        return ends

    monkeypatch.setattr(search, "least_squares", least_squares)
    effort = Effort(0.1, 0.2, 0.3, is_central=False)
    found = search.refine(problem, problem.start, loss, watch, effort)
    assert (found.cost, found.converged, found.message) == (7.0, True, "enough") and found.x is ends.x
    ends.status = 0
    assert not search.refine(problem, problem.start, loss, watch, effort).converged
    start, residuals, jacobians, options = seen[0]
    # A start beyond a bound is taken to it, and a hair inside, as least squares need it.
    assert 0.0 < 0.4 - start[0] < 1e-8 and np.array_equal(start[1:], problem.start[1:])
    low, high = options.pop("bounds")
    assert np.array_equal(low, problem.bounds[0]) and np.array_equal(high, problem.bounds[1])
    assert {name: options[name] for name in ("loss", "ftol", "xtol", "x_scale")} == {
        "loss": loss, "ftol": 0.1, "xtol": 0.2, "x_scale": "jac",
    }  # fmt: skip
    of_data = problem.residuals([start])[0]
    every = np.append(of_data, problem.pulls(start))
    slopes = np.vstack([jacobian(problem, start, is_central=False), np.diag(problem.pull)])
    if loss == "linear":
        assert_close(residuals @ residuals, every @ every, rel=1e-14, what="sum of squares")
        assert_close(jacobians.T @ residuals, slopes.T @ every, rel=1e-14, what="slope of the cost")
    else:
        assert np.array_equal(residuals, every) and np.array_equal(jacobians, slopes)
    # What is looked at is the mean square of what is left of the data.
    assert np.array_equal(looked[0][0], start)
    assert_close(looked[0][1], np.mean(of_data**2), rel=1e-14, what="mean square")


def test_refinement_is_of_runs_as_exact_as_it_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    tolerances: list[float] = []

    class Noted(Drawn):
        def residuals(self, vectors: list[Array]) -> Array:
            tolerances.append(self.tolerance)
            return super().residuals(vectors)

    problem: Any = Noted()
    fine, rough = search.refine(problem, problem.start), search.refine(problem, problem.start, effort=ROUGH)
    assert fine.converged and set(tolerances) == {1e-6, 1e-5}
    # At 0 nothing is left.
    assert_close(fine.x, np.zeros(5), within=1e-12, what="end", why="an end is as good as it happens to be")
    assert fine.cost <= rough.cost < 1e-6
