"""Operating conditions left out in turn, on data whose truth is known."""

from __future__ import annotations

import json
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pneumatic_servo as ps
import pytest
from bounds import assert_close
from numpy.typing import NDArray
from pneumatic_servo.cli import main
from pneumatic_servo.identification.conditions import Condition, conditions
from pneumatic_servo.identification.records import Record
from pneumatic_servo.identification.signals import Units
from test_identification import RIG, RIG_COLUMNS
from test_identification_force import axis

Array = NDArray[np.float64]
Data = dict[str, Array]

F0, KAPPA, AREA = 3.4, 2e-6, 4.95e-4
PRESSURES = (1e5, 3e5, 5e5, 7e5)


def seal(pressure: float, factor: float = 1.0, seed: int = 0, amplitude: float = 0.02) -> Data:
    """A seal under a pressure, whose friction differs by a factor from the law."""
    rng = np.random.default_rng(seed)
    time = np.arange(0.0, 4.0, 0.02)
    position = amplitude * np.sin(2.0 * np.pi * 0.5 * time)
    course = pressure * (1.0 + 0.002 * rng.standard_normal(len(time)))
    way = np.sign(np.append(0.0, np.diff(position)))
    force = AREA * course + factor * F0 * (1.0 + KAPPA * course) * way + 0.05 * rng.standard_normal(len(time))
    return {"time": time, "position": position, "pressure": course, "force": force}


def fit(data: list[Data], **options: object) -> ps.Fit:
    given = {"experiment": "motion", "law": "Coulomb", "fit": "friction.coulomb.Fc,friction.kappaA,area", "play": 0.0,
             "settings": {"friction.coulomb.sigma2": 0.0}, "starts": 0, "progress": False, **options}  # fmt: skip
    return ps.fit(data, **given)  # type: ignore[arg-type]


def test_law_that_is_right_predicts_what_is_left_out() -> None:
    found = fit([seal(p, seed=k) for k, p in enumerate(PRESSURES)], cross_validate="pressure")
    assert found.cross_validation is not None
    cases = found.cross_validation.cases
    assert [case.condition.value for case in cases] == pytest.approx(PRESSURES, rel=1e-3)
    for case, pressure in zip(cases, PRESSURES, strict=True):
        told, true = case.friction, F0 * (1.0 + KAPPA * pressure)
        assert told is not None and case.holds and case.samples > 150
        # Three others tell the two parameters of a line, and little of how far friction is from one.
        assert told.low < true < told.high < 3.0 * told.low
        assert told.predicted == pytest.approx(true, rel=0.02)
        assert told.measured_low < true < told.measured_high
        assert told.measured == pytest.approx(true, rel=0.01) and told.spread < 0.03
        assert case.rms["force"] == pytest.approx(0.05, rel=0.2) == case.fitted["force"]
    assert [bool(case.beyond) for case in cases] == [True, False, False, True]
    assert "pressure reaches 7" in cases[-1].beyond[0]
    assert found.verdict.light == "green" and "4 of 4 conditions are predicted" in found.verdict.text
    # Each condition has a row: the range and the middle of what is predicted, and what is measured.
    [axis] = found.cross_validation.plot().axes
    assert [text.get_text() for text in axis.get_yticklabels()] == [case.condition.name for case in cases]
    assert axis.get_xlabel() == "friction (N)" and axis.yaxis_inverted()
    *drawn, predicted, measured = axis.get_lines()
    for place, case in enumerate(cases):
        told = case.friction
        assert told is not None
        around, middle, dot = drawn[3 * place : 3 * place + 3]
        assert around.get_xydata().tolist() == [[told.low, place], [told.high, place]]
        assert middle.get_xydata().tolist() == [[told.predicted, place]]
        assert dot.get_xydata().tolist() == [[told.measured, place]]
        assert (around.get_color(), dot.get_color()) == (predicted.get_color(), measured.get_color())
    assert [line.get_label() for line in (predicted, measured)] == ["predicted by the others, 95 %", "measured"]


def test_law_that_does_not_hold_at_a_pressure_is_said_to() -> None:
    """The line of the three lower pressures is left at the highest, by half again."""
    factors = (1.0, 1.0, 1.0, 1.5)
    found = fit([seal(p, f, k) for k, (p, f) in enumerate(zip(PRESSURES, factors, strict=True))],
                cross_validate="pressure")  # fmt: skip
    assert found.cross_validation is not None
    last = found.cross_validation.cases[-1]
    assert last.friction is not None and last.friction.high < last.friction.measured
    assert last.friction.measured == pytest.approx(1.5 * F0 * (1.0 + KAPPA * 7e5), rel=0.01)
    assert found.verdict.light == "red"
    assert any("The law does not hold at pressure 7" in one.text for one in found.verdict.findings)
    head, *lines = str(found.cross_validation).splitlines()
    failed = [not case.holds for case in found.cross_validation.cases]
    assert failed[-1] and head.endswith(f"the law holds in {failed.count(False)} of 4")
    assert [line.endswith(": the law does not hold there") for line in lines] == failed


def test_intervals_contain_what_differs_from_condition_to_condition() -> None:
    """Friction is off by 10 % in each condition: of 48 intervals of 95 %, fewer than 42 hold one time in 50."""
    rng, held = np.random.default_rng(5), 0
    for repetition in range(12):
        factors = np.exp(0.1 * rng.standard_normal(len(PRESSURES)))
        data = [seal(p, f, 10 * repetition + k) for k, (p, f) in enumerate(zip(PRESSURES, factors, strict=True))]
        found = fit(data, cross_validate="pressure").cross_validation
        assert found is not None
        held += found.holds
        spreads = [case.friction.spread for case in found.cases if case.friction is not None]
        assert 0.01 < np.median(spreads) < 0.3
    assert held >= 42


def test_conditions_are_told_apart_by_what_is_asked() -> None:
    data = [seal(p, seed=k, amplitude=a) for k, (p, a) in enumerate([(1e5, 0.01), (3e5, 0.01), (3.1e5, 0.02)])]
    found = fit(data, cross_validate=["record", "pressure", "amplitude"]).cross_validation
    assert found is not None
    groups = [(case.condition.quantity, case.condition.windows) for case in found.cases]
    assert groups == [
        ("record", (0,)), ("record", (1,)), ("record", (2,)), ("pressure", (0,)), ("pressure", (1, 2)),
        ("amplitude", (0, 1)), ("amplitude", (2,)),
    ]  # fmt: skip


def test_what_a_law_is_expected_to_be_off_by_widens_the_intervals() -> None:
    """With three pressures the others tell little of it, so that what is expected counts."""
    data = [seal(p, seed=k) for k, p in enumerate(PRESSURES[:3])]
    widths = []
    for law_error in (0.01, 0.2, 1.0):
        found = fit(data, cross_validate="pressure", law_error=law_error).cross_validation
        assert found is not None
        told = [case.friction for case in found.cases if case.friction is not None]
        widths.append(np.array([np.log(one.high / one.low) for one in told]))
    assert len(widths[0]) == 3 and np.all(2.0 * widths[0] < widths[1]) and np.all(widths[1] < widths[2])
    with pytest.raises(ValueError, match=r"law_error=0\.0: it must be positive"):
        fit(data, law_error=0.0)


@pytest.mark.parametrize(
    ("quantity", "words"),
    [
        ("colour", "it must be record, pressure, load, supplyPressure, amplitude, speed"),
        ("load", "normalForce was not measured"),
        ("amplitude", "there is only one condition, amplitude 0.02 m"),
        ("record", "there is only one condition"),
    ],
)
def test_what_cannot_be_left_out_is_refused(quantity: str, words: str) -> None:
    with pytest.raises(ValueError, match=f"cross_validate='{quantity}'.*{words}"):
        fit([seal(3e5)], cross_validate=quantity)


def test_axes_moved_by_a_force_are_left_out_too() -> None:
    """Windows begin as suits them; friction of 15 N and 60 N s/m is predicted and measured as it is."""
    names = ("time", "position", "force")
    halves = [{name: axis()[name][part] for name in names} for part in (slice(0, 1000), slice(1000, 2000))]
    found = ps.fit(halves, experiment="force", law="Coulomb", fit="mass,friction.coulomb.Fc,friction.coulomb.sigma2",
                   starts=0, cross_validate="record", progress=False).cross_validation  # fmt: skip
    assert found is not None
    for case, half in zip(found.cases, halves, strict=True):
        speed = np.abs(np.gradient(half["position"], half["time"]))
        told = case.friction
        assert told is not None
        assert told.measured == pytest.approx(15.0 + 60.0 * float(np.mean(speed)), rel=0.1)
        # One other condition tells nothing of how far the law is off: 95 % of products of two normal numbers are below
        # 2.18, and of what both conditions are off by below 0.2*sqrt(2) times that, which makes ends 3.4 times apart.
        assert told.low < told.measured < told.high < 3.5 * told.low
        assert case.rms["position"] < 1.5 * case.fitted["position"] < 2e-5


# A record that is there twice has no noise of its own, so that what is left of both is the same.
@pytest.mark.filterwarnings("ignore:again.csv has the samples of rig.csv")
def test_rig_tells_what_is_left_of_each_signal(tmp_path: Path) -> None:
    again = tmp_path / "again.csv"
    again.write_bytes(RIG.read_bytes())
    known = {"supplyPressure": 6e5, "valve.deadZone": 0.065, "valve.C": 4.4e-9, "friction.stribeck.Fs": 12.4,
             "friction.stribeck.vs": 0.018, "friction.stribeck.sigma2": 38.0}  # fmt: skip
    found = ps.fit([RIG, again], experiment="rig", law="Stribeck", fit="friction.stribeck.Fc", columns=RIG_COLUMNS,
                   settings=known, starts=0, cross_validate="record", progress=False).cross_validation  # fmt: skip
    assert found is not None and [case.friction for case in found.cases] == [None] * len(found.cases)
    assert found.holds == len(found.cases)
    assert set(found.cases[0].rms) == {"position", "chamberA.pressure", "chamberB.pressure"}
    assert "rms if left out" in found.plot().axes[0].get_xlabel()


def test_command_line_and_files_have_the_table(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    files = []
    for k, pressure in enumerate((1e5, 3e5, 5e5)):
        data = seal(pressure, seed=k)
        files.append(tmp_path / f"{k}.csv")
        np.savetxt(files[-1], np.column_stack(list(data.values())), delimiter=",", header=",".join(data), comments="")
    code = main([
        "fit", *map(str, files), "--experiment", "motion", "--law", "Coulomb", "--set", "friction.coulomb.sigma2=0",
        "--fit", "friction.coulomb.Fc,friction.kappaA,area", "--play", "0", "--starts", "0", "--cross-validate",
        "pressure", "--json", str(tmp_path / "a.json"), "--report", str(tmp_path / "a.html"),
    ])  # fmt: skip
    assert code == 0
    assert "each condition left out in turn: the law holds in 3 of 3" in capsys.readouterr().out
    rows = json.loads((tmp_path / "a.json").read_text(encoding="utf-8"))["crossValidation"]
    assert [row["left out"] for row in rows] == ["pressure 1e+05 Pa", "pressure 3e+05 Pa", "pressure 5e+05 Pa"]
    assert all(row["low"] < row["friction predicted (N)"] < row["high"] for row in rows)
    page = (tmp_path / "a.html").read_text(encoding="utf-8")
    assert (
        "Each condition predicted by the others" in page and "An extrapolation. pressure 5e+05 Pa: pressure r" in page
    )


def test_table_is_written(tmp_path: Path) -> None:
    found = fit([seal(p, seed=k) for k, p in enumerate(PRESSURES[:3])], cross_validate="pressure").cross_validation
    assert found is not None
    found.to_csv(tmp_path / "a.csv")
    lines = (tmp_path / "a.csv").read_text(encoding="utf-8").splitlines()
    assert lines[0].startswith("left out,samples,signal,rms predicted") and len(lines) == 4
    assert "<table" in found._repr_html_()


def split(quantity: str, *records: Record, signals: tuple[str, ...], is_rotating: bool = False) -> list[Condition]:
    """Conditions of windows that are halves of records."""
    windows = [
        SimpleNamespace(record=record.part(first, first + len(record.time) // 2))
        for record in records
        for first in (0, len(record.time) // 2)
    ]
    experiment = SimpleNamespace(signals=frozenset(signals), units=Units(is_rotating))
    problem: Any = SimpleNamespace(windows=windows, experiment=experiment)
    return conditions(problem, list(records), quantity)


def course(name: str, begin: float = 0.0, **signals: float) -> Record:
    """A record of 100 samples; positions swing about 1 by what is given, and all else is as it is given."""
    time = np.arange(100) * 0.01
    swing = np.sin(2.0 * np.pi * time)
    courses = {signal: value * np.ones(100) for signal, value in signals.items()}
    if "position" in signals:
        courses["position"] = 1.0 + signals["position"] * swing
    return Record(name, time, begin, courses)


@pytest.mark.parametrize(
    ("quantity", "signal", "values", "expected"),
    [
        # By less than a tenth of the larger from one to the next they are one.
        ("pressure", "pressure", (3e5, 1e5, 1.105e5, 2.72e5),
         [(1.0525e5, "pressure 1.052e+05 Pa", (2, 3, 4, 5)), (2.86e5, "pressure 2.86e+05 Pa", (0, 1, 6, 7))]),
        ("load", "normalForce", (-5.0, 5.0), [(-5.0, "load -5 N", (0, 1)), (5.0, "load 5 N", (2, 3))]),
        ("supplyPressure", "supplyPressure", (6e5, 6.7e5),
         [(6e5, "supplyPressure 6e+05 Pa", (0, 1)), (6.7e5, "supplyPressure 6.7e+05 Pa", (2, 3))]),
        ("amplitude", "position", (0.5, 0.3), [(0.3, "amplitude 0.3 rad", (2, 3)), (0.5, "amplitude 0.5 rad", (0, 1))]),
        ("speed", "velocity", (2.0, 1.0), [(1.0, "speed 1 rad/s", (2, 3)), (2.0, "speed 2 rad/s", (0, 1))]),
    ],
)  # fmt: skip
def test_conditions_are_by_what_whole_records_have(
    quantity: str, signal: str, values: tuple[float, ...], expected: list[tuple[float, str, tuple[int, ...]]]
) -> None:
    """Also of two records of one table, of which the second begins after a gap."""
    records = [course("a.csv", 5.0 * place, **{signal: value}) for place, value in enumerate(values)]
    found = split(quantity, *records, signals=("time", signal), is_rotating=True)
    assert [(one.quantity, one.name, one.windows) for one in found] == [(quantity, *rest) for _, *rest in expected]
    assert_close([one.value for one in found], [value for value, *_ in expected], rel=1e-14, what="means")


def test_conditions_by_record_are_those_of_its_table() -> None:
    found = split("record", course("a"), course("b"), course("a", 5.0), signals=("time",))
    assert found == [Condition("record", 1.0, "a", (0, 1, 4, 5)), Condition("record", 2.0, "b", (2, 3))]
    with pytest.raises(ValueError, match=r"^cross_validate='record': there is only one condition, a$"):
        split("record", course("a"), course("a", 5.0), signals=("time",))
    with pytest.raises(ValueError, match=r"^cross_validate='speed': position or velocity was not measured$"):
        split("speed", course("a"), signals=("time", "force"))
    text = "cross_validate='p': it must be record, pressure, load, supplyPressure, amplitude, speed"
    with pytest.raises(ValueError, match=f"^{text}$"):
        split("p", course("a"), signals=("time", "p"))
