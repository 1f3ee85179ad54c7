"""Intervals and what is not determined, on linear problems of which both are known by other ways."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from bounds import assert_close
from numpy.typing import NDArray
from pneumatic_servo.identification import intervals
from pneumatic_servo.identification.intervals import Linearised, _blind, _bootstrap, certainty, covariance, hidden
from pneumatic_servo.identification.parameters import Free
from scipy.stats import bootstrap
from scipy.stats import t as student

Array = NDArray[np.float64]
ROUND = "other libraries of linear algebra round otherwise"
Labels = NDArray[np.int64]


def solved(rows: Array, right: Array, labels: Labels, records: Labels | None = None) -> tuple[Array, Linearised]:
    """A regression by its solution."""
    found = np.linalg.lstsq(rows, right)[0]
    none = np.zeros(len(rows), dtype=int)
    return found, Linearised(-rows, right - rows @ found, labels, none if records is None else records)


def deleted(rows: Array, right: Array, labels: Labels) -> Array:
    """Deviations of a jackknife: the regression is solved anew without each group."""
    every = np.linalg.lstsq(rows, right)[0]
    groups = np.unique(labels)
    moves = [np.linalg.lstsq(rows[labels != one], right[labels != one])[0] - every for one in groups]
    return np.sqrt(np.sum(np.square(moves), axis=0) * (len(groups) - 1) / len(groups))


def drawn(number: int = 120) -> tuple[Array, Array]:
    rng = np.random.default_rng(7)
    return np.column_stack([np.ones(number), rng.standard_normal(number)]), rng.standard_normal(number)


def test_independent_residuals_have_the_covariance_of_a_regression() -> None:
    """Two records are no sample of records, and three stretches none of stretches where two parameters are free."""
    rows, right = drawn()
    stretches, records = np.repeat(np.arange(3), 40), np.repeat(np.arange(2), 60)
    _, linear = solved(rows, right + 5.0 * records, stretches, records)
    spread, factors = covariance(linear)
    assert_close(spread, np.linalg.inv(rows.T @ rows), within=2e-15, what="covariance", why=ROUND)
    assert_close(factors, student.ppf(0.975, 118), rel=1e-12, what="factors")
    alone = Linearised(rows[:2], right[:2], np.zeros(2, dtype=int), np.zeros(2, dtype=int))
    assert_close(covariance(alone)[1], student.ppf(0.975, 1), rel=1e-12, what="factor of two samples")


@pytest.mark.parametrize("of", ["stretches", "records"])
def test_residuals_that_hang_together_have_the_covariance_of_a_jackknife(of: str) -> None:
    """A step from group to group shifts the mean; how the slope is told does not change."""
    rows, right = drawn()
    groups = np.repeat(np.arange(4 if of == "stretches" else 3), 30 if of == "stretches" else 40)
    right = 0.2 * right + np.array([3.0, -3.0, 4.0, -2.0])[groups]
    one = np.zeros(120, dtype=int)
    _, linear = solved(rows, right, *((groups, one) if of == "stretches" else (one, groups)))
    spread, factors = covariance(linear)
    white = np.sqrt(np.diag(np.linalg.inv(rows.T @ rows)))
    together = deleted(rows, right, groups)
    group = student.ppf(0.975, len(np.unique(groups)) - 1)
    assert together[0] * group > white[0] * student.ppf(0.975, 118)
    assert_close(np.sqrt(spread[0, 0]), together[0], rel=1e-13, what="deviation", why=ROUND)
    assert_close(factors[0], group, rel=1e-14, what="factor")
    # The widest counts; correlations are taken from independent residuals.
    halves = np.maximum(together * group, white * student.ppf(0.975, 118))
    assert_close(np.sqrt(np.diag(spread)) * factors, halves, rel=1e-13, what="half intervals", why=ROUND)
    inverse = np.linalg.inv(rows.T @ rows)
    correlation = inverse[0, 1] / np.sqrt(inverse[0, 0] * inverse[1, 1])
    assert_close(
        spread[0, 1] / np.sqrt(spread[0, 0] * spread[1, 1]), correlation, rel=1e-13, what="correlation", why=ROUND
    )


def test_bootstrap_of_a_mean_is_that_of_scipy() -> None:
    """Of twenty stretches of four samples each, whose means are skewed, so that its two ends differ."""
    means = np.random.default_rng(8).exponential(1.0, 20)
    right = np.repeat(means, 4)
    found, linear = solved(np.ones((80, 1)), right, np.repeat(np.arange(20), 4))
    low, high = _bootstrap(linear, found, seed=1, number=4000)
    other = bootstrap((means,), np.mean, n_resamples=10000, method="percentile", random_state=2).confidence_interval
    assert_close(found[0] - low[0], found[0] - other.low, rel=0.03, what="below", why="of 4000 draws")
    assert_close(high[0] - found[0], other.high - found[0], rel=0.03, what="above", why="of 4000 draws")
    again, _ = _bootstrap(linear, found, seed=1, number=4000)
    assert again == low


@pytest.mark.parametrize(
    ("factors", "expected"),
    [
        # Rows say what a parameter does along two directions. One that hardly takes part is not blind.
        ([[1.0, 0.0], [0.0, 1.0], [1.0, 1e-3]], [True, False, True]),
        ([[1.0, 0.0], [0.0, 1.0]], [False, False]),
        ([[1.0, 0.0], [2.0, 0.0], [0.0, 1.0]], [True, True, False]),
        # The one that has fifty times the effect takes little part in the direction of both, but makes it up.
        ([[1.0, 0.0], [50.0, 0.0], [0.0, 1.0]], [True, True, False]),
        ([[1.0, 0.0], [1.0, 1e-5]], [False, False]),
        ([[1.0, 0.0], [1.0, 1e-9]], [True, True]),
        ([[1.0, 0.0], [0.0, 0.0]], [False, True]),
        ([[0.0, 0.0], [0.0, 0.0]], [True, True]),
    ],
)
def test_directions_without_effect_blind_their_parameters(factors: list[list[float]], expected: list[bool]) -> None:
    basis = np.linalg.qr(np.random.default_rng(9).standard_normal((50, 2)))[0]
    assert _blind(basis @ np.array(factors).T).tolist() == expected


LOGARITHM = Free("mass", "kg", 2.0, 0.0, 1e3, 0.0)
PLAIN = Free("offset", "N", 0.0, -10.0, 10.0, 0.5)


def fitted(
    monkeypatch: pytest.MonkeyPatch, linear: Linearised, *free: Free, start: Array, low: Array, high: Array
) -> Any:
    """A problem about its solution."""
    monkeypatch.setattr(intervals, "linearised", lambda problem, x: linear)
    experiment = SimpleNamespace(table=SimpleNamespace(variables={}))
    return SimpleNamespace(free=free, bounds=(low, high), start=start, experiment=experiment)


def test_ends_are_those_of_what_the_solver_sees(monkeypatch: pytest.MonkeyPatch) -> None:
    """Of the logarithm of a mass of 2 kg, and of an offset in units of 0.5 N."""
    rows, right = drawn()
    _, linear = solved(rows, right, np.zeros(120, dtype=int))
    none = np.full(2, np.inf)
    problem = fitted(monkeypatch, linear, LOGARITHM, PLAIN, start=np.zeros(2), low=-none, high=none)
    found = certainty(problem, np.array([np.log(2.0), 3.0, 9.0]))
    inverse = np.linalg.inv(rows.T @ rows)
    half = student.ppf(0.975, 118) * np.sqrt(np.diag(inverse))
    assert_close(found.low, [2.0 / np.exp(half[0]), 1.5 - 0.5 * half[1]], rel=1e-13, what="low", why=ROUND)
    assert_close(found.high, [2.0 * np.exp(half[0]), 1.5 + 0.5 * half[1]], rel=1e-13, what="high", why=ROUND)
    correlation = inverse[0, 1] / np.sqrt(inverse[0, 0] * inverse[1, 1])
    assert_close(
        found.correlation, [[1.0, correlation], [correlation, 1.0]], within=1e-13, what="correlation", why=ROUND
    )
    assert found.reasons == {}


def test_ends_are_those_of_the_way_that_is_asked_for(monkeypatch: pytest.MonkeyPatch) -> None:
    """A profile begins at the ends from the Jacobian, with the rise of independent residuals."""
    rows, right = drawn()
    _, linear = solved(rows, right, np.repeat(np.arange(20), 6))
    none = np.full(2, np.inf)
    problem = fitted(monkeypatch, linear, PLAIN, PLAIN, start=np.zeros(2), low=-none, high=none)
    x, scale = np.array([1.0, 2.0, 9.0]), 0.5
    plain = certainty(problem, x)
    drawn_ends = [scale * end for end in _bootstrap(linear, x[:2], seed=5)]
    found = certainty(problem, x, "bootstrap", 5)
    assert np.array_equal([found.low, found.high], drawn_ends)
    asked: list[Any] = []
    monkeypatch.setattr(intervals, "profile", lambda *given: asked.extend(given) or (np.array([-4.0, 0]), np.ones(2)))
    other = certainty(problem, x, "profile")
    assert other.low.tolist() == [-2.0, 0.0] and other.high.tolist() == [0.5, 0.5]
    assert asked[0] is problem and asked[1] is x
    assert_close(asked[2], (plain.high - plain.low) / 2.0 / scale, rel=1e-13, what="half intervals", why=ROUND)
    assert_close(asked[3], np.sqrt(np.diag(np.linalg.inv(rows.T @ rows))), rel=1e-13, what="deviations", why=ROUND)


def test_what_has_no_effect_may_be_anything(monkeypatch: pytest.MonkeyPatch) -> None:
    rows, right = drawn()
    _, linear = solved(np.column_stack([rows[:, 0], np.zeros(120), rows[:, 1]]), right, np.zeros(120, dtype=int))
    none = np.full(3, np.inf)
    problem = fitted(
        monkeypatch, linear, PLAIN, LOGARITHM, Free("force", "N", 0.0, 0.0, 1.0, 1.0), start=np.zeros(3), low=-none,
        high=none,
    )  # fmt: skip
    found = certainty(problem, np.array([0.0, 0.0, 1.0]))
    assert (found.low[1], found.high[1]) == (0.0, np.inf) and np.all(np.isfinite(found.low[[0, 2]]))
    assert found.correlation[1].tolist() == [0.0, 0.0, 0.0] and found.correlation[0, 0] == pytest.approx(1.0)
    nothing = "the data do not change with it, or only with a combination of parameters"
    assert found.reasons == hidden(problem) == {"mass": nothing}


WIDE = "its interval is wider than its bounds"
THRICE = "its interval is wider than from a third to three times its value"
BOUND = "it is at a bound"


@pytest.mark.parametrize(
    ("free", "at", "half", "low", "high", "reason"),
    [
        (PLAIN, 0.0, 5.0, -np.inf, np.inf, None),
        (PLAIN, 0.0, 1.01, -1.0, 1.0, WIDE),
        (PLAIN, 0.0, 0.99, -1.0, 1.0, None),
        # Beyond one bound alone.
        (PLAIN, 0.5, 1.0, -1.0, 1.0, None),
        (PLAIN, -0.5, 1.0, -1.0, 1.0, None),
        (LOGARITHM, 0.0, 1.01, -np.inf, np.inf, THRICE),
        (LOGARITHM, 0.0, 0.99, -np.inf, np.inf, None),
        (PLAIN, 1.0, 0.5, -1.0, 1.0, BOUND),
        (PLAIN, -1.0, 0.5, -1.0, 1.0, BOUND),
        (PLAIN, 1e4, 0.5, -1.0, 1e4 * (1.0 + 0.5e-6), BOUND),
        (PLAIN, 1e4, 0.5, -1.0, 1e4 * (1.0 + 2e-6), None),
        (PLAIN, 0.0, 0.5, -2e-6, 10.0, None),
    ],
)
def test_what_is_not_determined_says_why(
    free: Free, at: float, half: float, low: float, high: float, reason: str | None, monkeypatch: pytest.MonkeyPatch
) -> None:
    """One parameter, whose half interval follows from a thousand samples of the same effect."""
    factor = student.ppf(0.975, 1000)
    effect = np.full((1000, 1), factor / half / np.sqrt(1000.0))
    linear = Linearised(effect, np.zeros(1000), np.zeros(1000, dtype=int), np.zeros(1000, dtype=int))
    start = np.array([at])
    problem = fitted(monkeypatch, linear, free, start=start, low=np.array([low]), high=np.array([high]))
    assert hidden(problem) == ({} if reason is None else {free.name: reason})
