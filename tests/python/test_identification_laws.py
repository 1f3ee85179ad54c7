"""How laws are ranked, on fits that are made by hand, and what is free under each."""

from __future__ import annotations

from typing import Any

import numpy as np
import pneumatic_servo as ps
import pytest
from pneumatic_servo.identification.fitted import Estimate
from pneumatic_servo.identification.laws import Ranking, _free, _ranking
from pneumatic_servo.identification.result import Fit
from test_identification import bench

ONE = Estimate(1.0, 0.5, 1.5, "N")


def fit(law: str, aic: float, rms: tuple[float, ...], held: tuple[float, ...] = (), free: int = 2) -> Fit:
    nothing: Any = None
    signals = ("position", "chamberA.pressure")
    return Fit(
        converged=law != "Dahl", law=law, parameters={str(k): ONE for k in range(free)}, aic=aic,
        rms=dict(zip(signals, rms, strict=False)), hold_out_rms=dict(zip(signals, held, strict=False)), undetermined={},
        notes=(), problem=nothing, x=np.zeros(free), certainty=nothing,
    )  # fmt: skip


def test_laws_are_ranked_by_aic_or_by_what_they_leave_of_data_held_out() -> None:
    """The latter is the root mean square of signals in units of what the first law that was fitted leaves of each."""
    fits = [fit("A", 30.0, (1.0,)), fit("B", -5.0, (2.0,)), fit("Dahl", 10.0, (3.0,))]
    assert [one.law for one in _ranking(list(fits)).fits] == ["B", "Dahl", "A"]
    held = [
        fit("A", 30.0, (1e-3, 500.0), (2e-3, 400.0)),
        fit("B", -5.0, (2e-3, 500.0), (2e-3, 200.0)),
        fit("Dahl", 0.0, (1e-3, 1500.0), (6e-3, 400.0), free=3),
    ]
    found = _ranking(list(held))
    assert [one.law for one in found.fits] == ["B", "A", "Dahl"] and found.best is held[1]
    # Rows are in units of what the best leaves: its own is 1; of A half of a deviation and once, once and twice.
    expected = [
        ("B", True, 2, 1.0, 1.0, -5.0),
        ("A", True, 2, np.sqrt((0.25 + 1.0) / 2.0), np.sqrt((1.0 + 4.0) / 2.0), 30.0),
        ("Dahl", False, 3, np.sqrt((0.25 + 9.0) / 2.0), np.sqrt((9.0 + 4.0) / 2.0), 0.0),
    ]
    for row, wanted in zip(found.rows(), expected, strict=True):
        assert row[:3] == wanted[:3] and row[3:] == pytest.approx(wanted[3:], rel=1e-14)
    assert found["A"] is held[0] and found._ipython_key_completions_() == ["B", "A", "Dahl"]


def test_law_that_cannot_be_simulated_is_the_last_and_no_measure() -> None:
    nan = float("nan")
    broken = fit("A", nan, (nan, nan), (nan, nan))
    held = [broken, fit("B", 3.0, (1.0, 1.0), (4.0, 1.0)), fit("C", 1.0, (1.0, 1.0), (1.0, 2.0))]
    # In units of B: 1 and 1 for itself, 1/4 and 2 for C, which is more.
    assert [one.law for one in _ranking(held).fits] == ["B", "C", "A"]
    assert [one.law for one in _ranking([broken, fit("B", 3.0, (1.0,)), fit("C", 1.0, (1.0,))]).fits] == ["C", "B", "A"]
    assert _ranking([broken]).best is broken


def test_ranking_is_a_table_of_all_signals() -> None:
    found = Ranking((fit("Stribeck", -12.34, (1.5e-5, 512.0), (2e-5, 600.0), free=4), fit("Dahl", 7.0, (3e-5, 700.0))))
    assert repr(found).splitlines() == [
        "law                  free            rms position      hold-out   rms chamberA.pressure      hold-out"
        "           AIC",
        "Stribeck                4                 1.5e-05         2e-05                     512           600"
        "         -12.3",
        "Dahl                    2                   3e-05           nan                     700           nan"
        "           7.0",
    ]
    assert "<td>Dahl</td><td>False</td><td>2</td>" in found._repr_html_()
    assert "<td>1</td><td>1</td><td>-12.3</td>" in found._repr_html_()


@pytest.mark.parametrize(
    ("known", "own", "common", "expected"),
    [
        ({}, (), (), ["friction.coulomb.Fc", "friction.coulomb.sigma2"]),
        # What is named for all laws is free besides, and counts instead of the same by default.
        ({}, (), "area", ["friction.coulomb.Fc", "friction.coulomb.sigma2", "area"]),
        ({}, (), ["friction.coulomb.Fc =3: 1:5"], ["friction.coulomb.sigma2", "friction.coulomb.Fc =3: 1:5"]),
        ({}, "friction.coulomb.Fc=2", "area", ["friction.coulomb.Fc=2", "area"]),
        # What is known is not free.
        ({"friction.coulomb.Fc": 3.0}, (), "area", ["friction.coulomb.sigma2", "area"]),
        ({"area": 1e-4}, ["friction.coulomb.Fc"], "area:1e-5:1e-3", ["friction.coulomb.Fc"]),
    ],
)
def test_each_law_has_its_own_and_what_all_share(
    known: dict[str, float], own: Any, common: Any, expected: list[str]
) -> None:
    assert _free("Coulomb", known, own, common, "motion") == expected


@pytest.mark.parametrize(
    ("laws", "text"),
    [
        ([], "laws: name at least one law"),
        (["Coulomb", ""], "laws='Coulomb,': a law between the commas is empty"),
        (["Coulomb", "Dahl", "Coulomb"], "laws: Coulomb is given twice"),
    ],
)
def test_laws_that_are_none_are_refused(laws: list[str], text: str) -> None:
    with pytest.raises(ValueError, match=f"^{text}$"):
        ps.compare_fits(bench(), laws, experiment="motion")
