"""The helper that holds results against bounds: it must not let NaN pass, as a plain maximum of two numbers does."""

from __future__ import annotations

import math

import bounds
import numpy as np
import pytest
from bounds import assert_close, largest, report


@pytest.fixture(autouse=True)
def _own_record(monkeypatch: pytest.MonkeyPatch) -> None:
    """What these tests compare is none of the suite's bounds."""
    monkeypatch.setattr(bounds, "used", {})


def test_largest_deviation_of_nan_is_nan_wherever_it_is() -> None:
    assert max(1.0, math.nan) == 1.0, "this is why"
    for values in ([math.nan, 1.0], [1.0, math.nan], [[1.0, 2.0], [math.nan, 0.0]]):
        assert math.isnan(largest(values))
    assert largest([-3.0, 2.0]) == 3.0
    with pytest.raises(AssertionError, match="nothing is compared"):
        largest([])


@pytest.mark.parametrize(
    ("found", "expected"),
    [
        (math.nan, 0.0),
        (0.0, math.nan),
        (math.nan, math.nan),
        ([1.0, math.nan], [1.0, 2.0]),
        ([1.0, math.inf], 1.0),
        ([1.0, 2.0], [1.0, 2.0 + 1.001e-3]),
        ([1.0, 2.0], [1.0, 2.0, 3.0]),
        ([], []),
    ],
)
def test_what_is_not_close_fails(found: object, expected: object) -> None:
    with pytest.raises(AssertionError), np.errstate(invalid="ignore"):
        assert_close(found, expected, within=1e-3)  # type: ignore[arg-type]


def test_wider_of_both_bounds_counts_and_none_at_all_is_refused() -> None:
    assert_close([100.0, 0.0], [100.9, 0.01], within=0.01, rel=0.01)
    with pytest.raises(AssertionError, match="by equality"):
        assert_close([1.0, 0.0], [1.0, 0.0], rel=1e-3)


def test_report_has_the_worst_use_of_each_bound_and_leaves_out_what_has_a_reason() -> None:
    for observed in (2e-9, 1e-9):
        assert_close(observed, 0.0, within=1e-6, what="position")
    assert_close(0.5, 0.0, within=1.0, what="pressure")
    assert_close(1e-9, 0.0, within=1.0, what="torque", why="a host's own rounding")
    head, *lines = report()
    assert head.startswith("3 bounds, 1 of them")
    name = "test_bounds.py::test_report_has_the_worst_use_of_each_bound_and_leaves_out_what_has_a_reason"
    assert lines == [
        f"       500 times: {name} position: observed 2e-09, bound 1e-06",
        f"         2 times: {name} pressure: observed 0.5, bound 1",
    ]
