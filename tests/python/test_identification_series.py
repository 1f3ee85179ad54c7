"""One machine over months: what moves is found, what does not is not."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pneumatic_servo as ps
import pytest
from bounds import assert_close
from numpy.typing import NDArray
from pneumatic_servo.cli import main
from pneumatic_servo.figures import GREY
from scipy.stats import norm
from shared import is_styled
from test_identification import COLUMNS, write
from test_identification_interrupt import stopping_in_the_second
from test_identification_posterior import FC, SIGMA2, line
from test_identification_solve import hurried

Array = NDArray[np.float64]
GIVEN: dict[str, Any] = {"experiment": "motion", "play": 0.0, "starts": 0, "progress": False}
STRIBECK = {name: f"friction.stribeck.{name}" for name in ("Fs", "Fc", "vs", "sigma2")}


def day(kinetic: float, seed: int, peak: float = 11.0) -> dict[str, Array]:
    """Friction by the equation of the Stribeck law, with a noise of 0.05 N."""
    rng = np.random.default_rng(seed)
    time = np.arange(0.0, 10.0, 0.01)
    position = 0.02 * np.sin(2.0 * np.pi * 0.3 * time) + 0.004 * np.sin(2.0 * np.pi * 1.1 * time)
    speed = np.append(0.0, np.diff(position) / 0.01)
    force = np.sign(speed) * (kinetic + (peak - kinetic) * np.exp(-((speed / 0.012) ** 2))) + 25.0 * speed
    return {"time": time, "position": position, "frictionForce": force + 0.05 * rng.standard_normal(len(time))}


def test_joint_fit_of_lines_is_that_of_one_regression() -> None:
    lines = [line(seed) for seed in range(3)]
    found = ps.fit_series([data for data, _ in lines], law="Coulomb", changing=FC, shared=SIGMA2, **GIVEN)
    assert found.converged and found.labels == (1, 2, 3) and len(found.fits) == 3
    rows, forces, weights = [], [], []
    for place, ((data, design), fit) in enumerate(zip(lines, found.fits, strict=True)):
        used = fit.problem.windows[0].used
        own = np.zeros((int(np.sum(used)), 4))
        own[:, 0], own[:, 1 + place] = design[used, 1], design[used, 0]
        noise = fit.problem.sensors["frictionForce"].noise
        rows.append(own / noise)
        forces.append(data["frictionForce"][used] / noise)
        weights.append(noise)
    matrix = np.vstack(rows)
    best = np.linalg.lstsq(matrix, np.concatenate(forces))[0]
    deviations = np.sqrt(np.diag(np.linalg.inv(matrix.T @ matrix)))
    values = [found.shared[SIGMA2].value, *(one.value for one in found.changing[FC])]
    # The springs of parameters without bounds are felt by far less than the noise.
    assert np.all(np.abs(values - best) < 1e-2 * deviations)
    halves = [0.5 * (one.high - one.low) for one in (found.shared[SIGMA2], *found.changing[FC])]
    # Never narrower than for independent residuals; sixty blocks make them up to 1.3 times as wide.
    assert np.all((1.9 * deviations < halves) & (halves < 1.3 * 2.1 * deviations)), halves / deviations


def test_records_that_share_nothing_are_fitted_as_each_alone() -> None:
    names = [STRIBECK[name] for name in ("Fs", "Fc", "sigma2")]
    found = ps.fit_series([day(7.0, seed) for seed in range(2)], law="Stribeck", changing=names,
                          settings={STRIBECK["vs"]: 0.012}, **GIVEN)  # fmt: skip
    assert found.shared == {} and list(found.changing) == names == list(found.p)
    for name, course in found.changing.items():
        errors = []
        for one, fit in zip(course, found.fits, strict=True):
            own = fit.parameters[name]
            assert_close(one.value, own.value, rel=1e-7, what="values", why="searches end by their cost")
            # Forty blocks of both tell a deviation from one to the other.
            assert_close(one.high - one.low, own.high - own.low, rel=0.1, what="intervals")
            assert one.low < one.value < one.high and one.unit == own.unit
            errors.append(0.5 * (one.high - one.low) / 1.96)
        apart = (course[1].value - course[0].value) / np.hypot(*errors)
        assert_close(found.p[name], 2.0 * norm.sf(abs(apart)), within=2e-4, what="p")
    for rms, fit in zip(found.rms, found.fits, strict=True):
        assert_close(rms["frictionForce"], fit.rms["frictionForce"], rel=1e-14, what="rms")


def test_wear_is_found_and_what_stays_stays() -> None:
    """Sliding friction grows by 2 % in half a year, which is 8 times what an interval is wide; nothing else does."""
    days = {f"2026-{month:02d}-01": day(7.0 + 0.02 * month, month) for month in (1, 3, 5, 7)}
    found = ps.fit_series(days, law="Stribeck", changing=[STRIBECK["Fc"], STRIBECK["Fs"], STRIBECK["sigma2"]],
                          shared=STRIBECK["vs"], **GIVEN)  # fmt: skip
    assert found.converged and not found.doubtful
    assert found.moves == {STRIBECK["Fc"]: True, STRIBECK["Fs"]: False, STRIBECK["sigma2"]: False}
    for month, one in zip((1, 3, 5, 7), found.changing[STRIBECK["Fc"]], strict=True):
        # Four intervals of 95 %: half as wide again holds all of them but for one time in 100.
        assert abs(one.value - 7.0 - 0.02 * month) < 0.75 * (one.high - one.low) < 0.05
    assert found.shared[STRIBECK["vs"]].low < 0.012 < found.shared[STRIBECK["vs"]].high
    figure = found.plot()
    assert is_styled(figure)
    titles = [axis.get_title(loc="left") for axis in figure.axes]
    assert titles == [f"{name}: {'moves' if moves else 'does not move'}" for name, moves in found.moves.items()]
    labels = [axis.get_ylabel() for axis in figure.axes]
    assert labels == ["Fc (N)", "Fs (N)", "sigma2 (N.s/m)"]
    assert figure.axes[-1].get_xlabel() == "record; dashed: the first"
    for axis, course in zip(figure.axes, found.changing.values(), strict=True):
        points, *_ = axis.containers[0]
        assert points.get_ydata().tolist() == [one.value for one in course]
        [intervals] = [lines for lines in axis.collections if len(lines.get_segments()) == 4]
        ends = [[low[1], high[1]] for low, high in intervals.get_segments()]
        assert_close(np.array(ends), np.array([[one.low, one.high] for one in course]), rel=1e-14, what="intervals")
        first = axis.get_lines()[-1]
        assert (first.get_ydata(), first.get_color(), first.get_linestyle()) == ([course[0].value] * 2, GREY, "--")
    colours = [axis.containers[0][0].get_color() for axis in figure.axes]
    assert colours[1] == colours[2] != colours[0], "what moves is red"
    plain = {"friction.stribeck.delta": [replace(one, unit="1") for one in found.changing[STRIBECK["Fs"]]]}
    [axis] = replace(found, changing=plain, moves={"friction.stribeck.delta": False}).plot().axes
    assert axis.get_ylabel() == "delta"


def test_nothing_is_said_to_move_where_nothing_does() -> None:
    """In 95 of 100 series at least; of 20, four false alarms or more would come one time in 60."""
    alarms = 0
    for seed in range(20):
        days = [line(1000 + 3 * seed + place)[0] for place in range(3)]
        found = ps.fit_series(days, law="Coulomb", changing=[FC, SIGMA2], **GIVEN)
        alarms += any(found.moves.values())
    assert alarms < 4


def test_what_is_shared_but_moves_is_said() -> None:
    days = {month: day(7.0, month, peak=11.0 + 0.1 * month) for month in (1, 2, 3)}
    found = ps.fit_series(days, law="Stribeck", changing=STRIBECK["Fc"], shared=[STRIBECK["Fs"], STRIBECK["sigma2"]],
                          settings={STRIBECK["vs"]: 0.012}, **GIVEN)  # fmt: skip
    assert STRIBECK["Fs"] in found.doubtful
    assert "friction.stribeck.Fs is shared, but differs among the records" in repr(found)


def test_leakage_of_a_rig_is_told_from_its_friction() -> None:
    """A rig of this library, with noise: between two days the leakage of its valve doubles, friction stays."""
    time = np.arange(0.0, 2.0, 2e-3)
    voltage = 5.0 + np.sin(2.0 * np.pi * 0.6 * time) + 0.6 * np.sin(2.0 * np.pi * 1.7 * time)
    days = {}
    for label, leakage in (("new", 0.002), ("worn", 0.004)):
        run = ps.Model().simulate(
            {"friction.law": "Coulomb", "valve.leakage": leakage, "supplyPressure": 6e5},
            inputs={"valveVoltage": (time, voltage)}, stop=time[-1], step=2e-3,
            outputs=["position", "chamberA.pressure", "chamberB.pressure"], progress=False,
        )  # fmt: skip
        rng = np.random.default_rng(round(1e3 * leakage))
        noises = {"position": 1e-5, "chamberA.pressure": 500.0, "chamberB.pressure": 500.0}
        seen = {name: run[name] + noise * rng.standard_normal(len(time)) for name, noise in noises.items()}
        days[label] = {"time": time, "valveVoltage": voltage, **seen}
    found = ps.fit_series(days, experiment="rig", law="Coulomb", changing=["valve.leakage", FC], shared="valve.C",
                          settings={"supplyPressure": 6e5}, inputs="lines", starts=0, progress=False)  # fmt: skip
    assert found.moves == {"valve.leakage": True, FC: False}


def test_command_tells_what_moves(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    files = [write(tmp_path / f"2026-0{month}-01.csv", day(7.0 + 0.1 * month, month)) for month in (1, 2)]
    code = main([
        "series", *map(str, files), "--experiment", "motion", "--law", "Stribeck", "--columns", COLUMNS, "--play", "0",
        "--changing", STRIBECK["Fc"], "--shared", f"{STRIBECK['Fs']},{STRIBECK['vs']},{STRIBECK['sigma2']}",
        "--starts", "0", "--out", str(tmp_path / "wear.csv"), "--plot", str(tmp_path / "wear.png"),
    ])  # fmt: skip
    assert code == 0
    assert "friction.stribeck.Fc      moves" in capsys.readouterr().out
    rows = (tmp_path / "wear.csv").read_text(encoding="utf-8").splitlines()
    assert rows[0] == "record,parameter,value,low,high,unit,moves,p"
    assert [row.split(",")[:2] for row in rows[1:]] == [[f"2026-0{m}-01", STRIBECK["Fc"]] for m in (1, 2)]
    assert (tmp_path / "wear.png").read_bytes().startswith(b"\x89PNG")


def test_series_that_does_not_come_to_an_end_fails_and_says_so(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr("pneumatic_servo.identification.fitting.search", hurried)
    # A tenth more, which would move beyond doubt.
    files = [write(tmp_path / f"{month}.csv", day(7.0 + 0.7 * month, month)) for month in (1, 2)]
    given = ["--experiment", "motion", "--law", "Stribeck", "--columns", COLUMNS, "--play", "0", "--starts", "0"]
    wear = tmp_path / "wear.csv"
    code = main(["series", *map(str, files), *given, "--changing", STRIBECK["Fc"], "--out", str(wear)])
    told = capsys.readouterr()
    assert (code, told.err.splitlines()[-1]) == (1, "error: the fit has not converged")
    assert "moves" not in told.out and "not known, since the search has not ended" in told.out
    # The results until then are written all the same.
    assert wear.is_file()


def test_options_of_the_command_reach_it(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    from pneumatic_servo import identification

    taken: dict[str, Any] = {}

    def fit_series(records: Any, **options: Any) -> Any:
        taken.update(options, records=records)
        raise ValueError("enough")

    monkeypatch.setattr(identification, "fit_series", fit_series)
    code = main([
        "series", "a.csv", "b.csv", "--experiment", "motion", "--law", "Coulomb", "--changing", FC, "--seed", "3",
        "--starts", "4", "--rated", "5", "--segment", "0.6", "--set", f"{SIGMA2}=7",
    ])  # fmt: skip
    assert code == 2 and list(taken["records"]) == ["a", "b"]
    assert {name: taken[name] for name in ("seed", "starts", "rated", "segment")} == {
        "seed": 3, "starts": 4, "rated": 5.0, "segment": 0.6,
    }  # fmt: skip
    assert taken["settings"] == {SIGMA2: 7.0}


def test_bad_series_is_refused_by_name(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    given = GIVEN | {"law": "Coulomb", "changing": FC}
    with pytest.raises(ValueError, match="1 record is refused: a series has at least two"):
        ps.fit_series([line()[0]], **given)
    with pytest.raises(TypeError, match="no option validation"):
        ps.fit_series([line()[0], line()[0]], **given, validation=0.3)
    with pytest.raises(ValueError, match=r"record march: .*too short"):
        ps.fit_series({"may": line()[0], "march": {name: x[:20] for name, x in line()[0].items()}}, **given)
    with pytest.raises(ValueError, match="name what may change"):
        ps.fit_series([line()[0], line()[0]], **given | {"changing": ""})
    for name in ("changing", "shared"):
        with pytest.raises(TypeError, match=f"{name} must be"):
            ps.fit_series([line()[0], line()[0]], **given | {name: 3})
    with pytest.raises(ValueError, match=r"friction\.coulomb\.Fc is given twice"):
        ps.fit_series([line()[0], line()[0]], **given, shared=FC)
    assert main(["series", "a/x.csv", "b/x.csv", "--experiment", "motion", "--law", "Coulomb", "--changing", FC]) == 2
    assert "x: two files have this name" in capsys.readouterr().err


def test_interrupt_leaves_the_records_that_are_done() -> None:
    tell = stopping_in_the_second()
    with pytest.raises(ps.Interrupted, match=r"^interrupted$") as caught:
        ps.fit_series([day(7.0, 1), day(7.0, 2)], law="Stribeck", changing=STRIBECK["Fc"], **GIVEN | {"progress": tell})
    assert isinstance(caught.value.finished, list) and [fit.converged for fit in caught.value.finished] == [True]
