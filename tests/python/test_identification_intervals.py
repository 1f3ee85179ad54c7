"""Intervals and what is not determined, on linear problems of which both are known by other ways."""

from __future__ import annotations

import numpy as np
import pytest
from bounds import assert_close
from numpy.typing import NDArray
from pneumatic_servo import _native
from pneumatic_servo.identification.intervals import Linearised, covariance
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
    assert _native.unseen(basis @ np.array(factors).T) == expected
