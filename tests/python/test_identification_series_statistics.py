"""Statistics of a series of records, on problems whose answer is known in closed form."""

from __future__ import annotations

from dataclasses import replace
from datetime import date
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from bounds import assert_close
from numpy.typing import NDArray
from pneumatic_servo.identification.fitted import Estimate
from pneumatic_servo.identification.parameters import Free
from pneumatic_servo.identification.series import Series, _doubtful, _estimate, _places
from scipy.stats import chi2, norm

Array = NDArray[np.float64]


LINE = Free("friction.stribeck.sigma2", "N.s/m", 1.0, -np.inf, np.inf, 10.0)
LOG = Free("friction.stribeck.Fc", "N", 1.0, 0.1, 10.0, 0.0)


def test_estimate_is_in_units_of_the_parameter() -> None:
    assert _estimate(LINE, 2.0, 0.5) == Estimate(20.0, 15.0, 25.0, "N.s/m")
    one = _estimate(LOG, np.log(2.0), np.log(4.0))
    assert_close([one.value, one.low, one.high], np.array([2.0, 0.5, 8.0]), rel=1e-14, what="ends")
    assert one.unit == "N" and _estimate(LOG, 0.0, 1e3).high == np.inf


def alone(places: list[float], halves: list[float], undetermined: tuple[str, ...] = ()) -> Any:
    """A fit to a single record, with values as the solver sees them."""
    ends = zip((LOG, LINE), places, halves, strict=True)
    estimates = {free.name: _estimate(free, x, half) for free, x, half in ends}
    return SimpleNamespace(parameters=estimates, not_identifiable=dict.fromkeys(undetermined, ""), x=np.array(places))


def test_shared_parameter_is_doubtful_where_records_alone_differ() -> None:
    """By the chi square of what they differ by; what a record does not tell has no part in it."""
    one, other = alone([0.3, 1.0], [0.2, 0.1]), alone([-0.3, 1.0], [0.3, 0.1])
    joint = np.array([0.05, 1.0])
    errors = np.array([0.2, 0.3]) / norm.ppf(0.975)
    likely = chi2(1).sf(np.sum((np.array([0.25, 0.35]) / errors) ** 2))
    assert 1e-4 < likely < 0.01
    blind = [alone([9.0, 5.0], [0.1, 0.1], (LOG.name, LINE.name)), alone([9.0, 1.0], [1e3, 1e3])]
    for fits in ([one, other], [one, *blind, other]):
        [(name, p)] = _doubtful(fits, [LOG, LINE], joint).items()
        assert name == LOG.name
        assert_close(p, likely, rel=1e-13, what="p")
    # Of a single one there is nothing to differ from.
    assert _doubtful([one, *blind], [LOG, LINE], joint) == {}


@pytest.mark.parametrize(("p", "number", "is_said"), [(0.04, 1, True), (0.06, 1, False), (0.04, 2, False)])
def test_doubts_are_said_of_five_in_a_hundred_series(p: float, number: int, is_said: bool) -> None:
    """For every number of shared parameters."""
    off = np.sqrt(chi2(1).isf(p) / 2.0) / norm.ppf(0.975)
    fits = [alone([off, 0.0], [1.0, 1.0]), alone([-off, 0.0], [1.0, 1.0])]
    found = _doubtful(fits, [LOG, LINE][:number], np.zeros(2))
    assert list(found) == [LOG.name] * is_said


def test_records_stand_at_their_dates_or_numbers_in_a_figure() -> None:
    days = [date(2026, 1, 1), date(2026, 3, 1)]
    assert _places(days) == (days, False) == _places(["2026-01-01", "2026-03-01"])
    assert _places([3, 7.5]) == ([3, 7.5], False)
    assert _places(["new", "2026-03-01"]) == ([1, 2], True)


def test_series_says_what_moves(tmp_path: Path) -> None:
    first, second = Estimate(2.0, 1.5, 2.5, "N"), Estimate(3.0, 2.75, 3.25, "N")
    fits: Any = (SimpleNamespace(law="Coulomb"),) * 2
    found = Series(
        ("new", "worn"), True, {"valve.C": Estimate(1e-9, 9e-10, 1.1e-9, "m3/(s.Pa)")},
        {"friction.coulomb.Fc": (first, second), "massB": (second, second)},
        {"friction.coulomb.Fc": 1.23e-4, "massB": 1.0}, {"friction.coulomb.Fc": True, "massB": False},
        {"valve.C": 0.001}, ({}, {}), fits,
    )  # fmt: skip
    assert repr(found) == (
        "Coulomb, 2 records: converged\n"
        "  valve.C              1e-09 [9e-10, 1.1e-09] m3/(s.Pa), shared\n"
        "  friction.coulomb.Fc  moves (p = 0.00012)\n"
        "    new: 2 [1.5, 2.5] N\n"
        "    worn: 3 [2.75, 3.25] N\n"
        "  massB                does not move (p = 1)\n"
        "    new: 3 [2.75, 3.25] N\n"
        "    worn: 3 [2.75, 3.25] N\n"
        "  valve.C is shared, but differs among the records (p = 0.001): let it change"
    )
    assert repr(replace(found, converged=False)).startswith("Coulomb, 2 records: not converged\n")
    found.to_csv(tmp_path / "wear.csv")
    assert (tmp_path / "wear.csv").read_text(encoding="utf-8").splitlines() == [
        "record,parameter,value,low,high,unit,moves,p",
        "new,friction.coulomb.Fc,2.0,1.5,2.5,N,True,0.000123",
        "worn,friction.coulomb.Fc,3.0,2.75,3.25,N,True,0.000123",
        "new,massB,3.0,2.75,3.25,N,False,1.0",
        "worn,massB,3.0,2.75,3.25,N,False,1.0",
    ]
    upper, lower = found.plot().axes
    assert [label.get_text() for label in lower.get_xticklabels()] == ["new", "worn"]
    assert upper.get_shared_x_axes().joined(upper, lower) and not any(
        label.get_visible() for label in upper.get_xticklabels()
    )
