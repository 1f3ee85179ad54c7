"""Starts, bounds, expressions and results as users of other fitting packages know them."""

from __future__ import annotations

from typing import Any

import numpy as np
import pneumatic_servo as ps
import pytest
from pneumatic_servo.identification import discrimination
from shared import is_styled
from test_identification import bench

FS, FC, VS, SIGMA2 = (f"friction.stribeck.{name}" for name in ("Fs", "Fc", "vs", "sigma2"))
GIVEN: dict[str, Any] = {"experiment": "motion", "law": "Stribeck", "play": 0.0, "starts": 0, "progress": False}


def fit(free: Any, **options: Any) -> ps.Fit:
    return ps.fit(bench(), fit=free, **{**GIVEN, **options})


def test_mapping_of_starts_is_that_of_words() -> None:
    words = fit([f"{FS}=12", f"{FC}=6:1:20", f"{VS}=10 mm/s", SIGMA2])
    found = fit({FS: 12, FC: (6.0, 1.0, 20.0), VS: "10 mm/s", SIGMA2: None})
    assert found.values == words.values
    free = {one.name: one for one in found.problem.free}
    assert (free[FS].start, free[FS].is_given) == (12.0, True)
    assert (free[FC].start, free[FC].low, free[FC].high, free[FC].is_bounded) == (6.0, 1.0, 20.0, True)
    assert free[VS].start == 0.01


def test_quantity_as_a_start_is_converted() -> None:
    pint = pytest.importorskip("pint")
    found = fit({FS: pint.Quantity(0.012, "kN"), FC: None, VS: 0.01, SIGMA2: None})
    assert {one.name: one.start for one in found.problem.free}[FS] == pytest.approx(12.0, rel=1e-12)
    with pytest.raises(ValueError, match=r"Fs.* must be in N"):
        fit({FS: pint.Quantity(0.012, "mm")})


def test_results_are_found_by_name() -> None:
    found = fit([FS, FC, VS, SIGMA2])
    assert found.params is found.parameters
    one = found[FC]
    assert float(one) == one.value == found.values[FC] and one.low < one.value < one.high and one.unit == "N"
    with pytest.raises(KeyError, match=r"did you mean friction\.stribeck\.Fc"):
        found["friction.stribeck.fc"]
    figure = found.plot()
    assert is_styled(figure)
    assert [axis.get_ylabel() for axis in figure.axes] == ["frictionForce (N)", "rest (N)"]


def test_tied_parameter_follows_and_has_an_interval() -> None:
    """The truth is Fs = 11/7 Fc; the interval of what is in proportion is so, too."""
    free = fit([FS, FC, VS, SIGMA2])
    found = fit({FC: None, VS: None, SIGMA2: None, FS: f"11/7*{FC}"})
    assert list(found.values) == [FC, VS, SIGMA2, FS]
    assert found.values[FS] == pytest.approx(11.0 / 7.0 * found.values[FC], rel=1e-14)
    assert found[FC].low < 7.0 < found[FC].high and found.settings[FS] == found.values[FS]
    for end in ("low", "high"):
        ratio = np.log(getattr(found[FS], end) / found.values[FS]) / np.log(getattr(found[FC], end) / found.values[FC])
        assert ratio == pytest.approx(1.0, abs=0.02)
    # What ties two gives one a narrower interval.
    assert found[FS].high - found[FS].low < free[FS].high - free[FS].low
    assert found.verdict.light == "green" and len(found.problem.free) == 3


@pytest.mark.parametrize("jac", ["differences", "exact"])
def test_ratio_may_be_the_parameter(jac: str) -> None:
    free = fit([FS, FC, VS, SIGMA2], jac=jac)
    words = [FC, VS, SIGMA2, "ratio=1.3:1:3", f"{FS}=ratio*{FC}"]
    found = fit(words, jac=jac)
    assert found[FS].value == pytest.approx(free[FS].value, rel=1e-4)
    assert found[FS].high - found[FS].low == pytest.approx(free[FS].high - free[FS].low, rel=0.1)
    assert found["ratio"].low < 11.0 / 7.0 < found["ratio"].high and found["ratio"].unit == "1"
    assert "ratio" not in found.settings and found.settings[FS] == found.values[FS]
    # A chain of them, by functions and brackets.
    chain = fit([FC, VS, "ratio=1.3", f"{FS}=sqrt(ratio**2)*{FC}", f"{SIGMA2}=25*({FS}/{FS})"], jac=jac)
    assert chain.values[SIGMA2] == pytest.approx(25.0, rel=1e-12)


@pytest.mark.parametrize(
    ("free", "words"),
    [
        ([FC, f"{FS}=1.2*friction.stribeck.Fx"], ["no parameter friction.stribeck.Fx", "did you mean"]),
        ([f"{FS}=2*{FC}", f"{FC}=2*{FS}", VS], ["no parameter friction.stribeck.Fc", "comes later"]),
        ([FC, f"{FS}=max({FC})"], ["max() is refused", "sqrt"]),
        ([FC, "ratio", f"{FS}=ratio*{FC}"], ["ratio is none of the model", "needs a start"]),
        ([FC, f"friction.stribeck.Fx=2*{FC}"], ["friction.stribeck.Fx"]),
        ([FC, FS, f"{FS}=2*{FC}"], ["Fs is given twice"]),
        ({FC: [1, 2]}, ["it must be a number, a text, None, or (start, low, high)"]),
    ],
)
def test_what_cannot_be_meant_is_refused(free: Any, words: list[str]) -> None:
    with pytest.raises(ValueError) as caught:  # noqa: PT011
        fit(free)
    assert all(word in str(caught.value) for word in words), caught.value


def test_inputs_are_held_by_the_word_of_a_simulation() -> None:
    with pytest.raises(ValueError, match="one of hold, lines, smooth"):
        fit(FC, inputs="curves")
    assert fit(FC, inputs="hold").values == fit(FC, inputs="held").values


def test_command_line_takes_expressions(tmp_path: Any, capsys: pytest.CaptureFixture[str]) -> None:
    from pneumatic_servo.cli import main
    from test_identification import COLUMNS, write

    file = write(tmp_path / "bench.csv", bench())
    assert main([
        "fit", str(file), "--experiment", "motion", "--law", "Stribeck", "--columns", COLUMNS, "--play", "0",
        "--starts", "0", "--fit", f"{FC},{VS},{SIGMA2},{FS}=11/7*{FC}", "--report", str(tmp_path / "a.html"),
    ]) == 0  # fmt: skip
    assert f"  {FS} " in capsys.readouterr().out


def test_series_has_tied_parameters_in_each_record() -> None:
    """With what it is given makes no difference; a shared one was once counted among the shared estimates."""
    days = [bench(seed=seed) for seed in (0, 1)]
    given = {name: value for name, value in GIVEN.items() if name != "law"}
    tie, shared = f"{FS}=11/7*{FC}", [f"{VS}=0.01", SIGMA2]
    among = [
        ps.fit_series(days, law="Stribeck", changing=[FC, *own], shared=[*both, *shared], **given)
        for own, both in (([tie], []), ([], [tie]))
    ]
    for found in among:
        assert list(found.changing) == [FC] and list(found.shared) == [VS, SIGMA2]
        assert all(one.low < 7.0 < one.high for one in found.changing[FC])
        assert not found.moves[FC]
    assert among[0].changing == among[1].changing


def test_plan_has_tied_parameters() -> None:
    """What follows from others is no parameter to be found, and has its value in the imagined experiment."""
    given: dict[str, Any] = {"law": "Stribeck", "duration": 2.0, "step": 0.02, "progress": False}
    words = [f"{FC}=7", f"{VS}=0.01", f"{SIGMA2}=40"]
    tied = ps.plan(fit=[*words, f"{FS}=11/7*{FC}"], experiment="motion", **given)
    free = ps.plan(fit=[*words, f"{FS}=11"], experiment="motion", **given)
    assert list(tied.values) == [FC, VS, SIGMA2] and list(free.values) == [FC, VS, SIGMA2, FS]
    half = {plan: plan_of.best.half[VS] for plan, plan_of in (("tied", tied), ("free", free))}
    assert 0.0 < half["tied"] < half["free"]
    rig = {**given, "duration": 1.0, "step": 0.01}
    constant = ps.plan(fit=[f"{FC}=7", f"{FS}=24+0*{FC}"], **rig)
    fixed = ps.plan(fit=[f"{FC}=7"], settings={FS: 24.0}, **rig)
    assert constant.best.half[FC] == pytest.approx(fixed.best.half[FC], rel=1e-9)


def test_rival_of_an_experiment_that_tells_laws_apart_keeps_its_ties() -> None:
    """It may move what was free, and no more."""
    found = fit([FC, VS, SIGMA2, "ratio=1.5:1:3", f"{FS}=ratio*{FC}"])
    kind, free = discrimination._side(found)
    assert [one.name for one in free] == [FC, VS, SIGMA2, "ratio"]
    assert kind.tied({one.name: one.start for one in free}) == pytest.approx(found.values, rel=1e-12)
