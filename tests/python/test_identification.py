"""Fits to data whose truth is known, and data that cannot be fitted."""

from __future__ import annotations

import json
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pneumatic_servo as ps
import pytest
from bounds import assert_close
from numpy.typing import NDArray
from pneumatic_servo.cli import main
from pneumatic_servo.identification.experiments import EXPERIMENTS, Options
from pneumatic_servo.identification.parameters import parse, usual

Array = NDArray[np.float64]
COLUMNS = "time=t,position=x[mm],frictionForce=f"


def bench(seed: int = 0) -> dict[str, Array]:
    """Friction by the equation of the Stribeck law, with a noise of 0.05 N, on a path that is known."""
    rng = np.random.default_rng(seed)
    time = np.arange(0.0, 10.0, 0.01)
    position = 0.02 * np.sin(2.0 * np.pi * 0.3 * time) + 0.004 * np.sin(2.0 * np.pi * 1.1 * time)
    speed = np.append(0.0, np.diff(position) / 0.01)
    force = np.sign(speed) * (7.0 + 4.0 * np.exp(-((speed / 0.012) ** 2))) + 25.0 * speed
    return {"time": time, "position": position, "frictionForce": force + 0.05 * rng.standard_normal(len(time))}


def write(file: Path, data: dict[str, Array]) -> Path:
    rows = zip(data["time"], 1e3 * data["position"], data["frictionForce"], strict=True)
    lines = [f"{t:.3f},{x:.9f},{f:.5f}" for t, x, f in rows]
    file.write_text("\n".join(["t,x,f", *lines, ""]), encoding="utf-8")
    return file


def test_stribeck_curve_is_found_within_its_intervals(tmp_path: Path) -> None:
    file = write(tmp_path / "bench.csv", bench())
    free = "friction.stribeck.Fs,friction.stribeck.Fc,friction.stribeck.vs,friction.stribeck.sigma2"
    code = main([
        "fit", str(file), "--experiment", "motion", "--law", "Stribeck", "--fit", free, "--columns", COLUMNS,
        "--play", "0", "--validation", "0.3", "--starts", "16", "--out", str(tmp_path / "a.ssv"),
        "--json", str(tmp_path / "a.json"), "--report", str(tmp_path / "a.html"),
    ])  # fmt: skip
    assert code == 0
    found = json.loads((tmp_path / "a.json").read_text(encoding="utf-8"))
    assert found["converged"] is True and found["law"] == "Stribeck" and found["not_identifiable"] == []
    truth = {"Fs": 11.0, "Fc": 7.0, "vs": 0.012, "sigma2": 25.0}
    for name, value in truth.items():
        estimate = found["parameters"][f"friction.stribeck.{name}"]
        # Four intervals of 95 %: half as wide again holds all of them but for one time in 500.
        half = 0.75 * (estimate["high"] - estimate["low"])
        assert abs(estimate["value"] - value) < half < 0.2 * value, name
    assert_close(found["rms"]["frictionForce"], 0.05, rel=0.02, what="rms")
    assert_close(found["validation_rms"]["frictionForce"], 0.05, rel=0.15, what="rms of validation data")
    values = ElementTree.parse(tmp_path / "a.ssv").getroot()
    names = {element.get("name") for element in values.iter() if element.tag.endswith("}Parameter")}
    assert names == {"friction.law", *(f"friction.stribeck.{name}" for name in truth)}
    assert "<img" in (tmp_path / "a.html").read_text(encoding="utf-8")


def test_wrong_law_is_known_by_what_it_predicts() -> None:
    ranking = ps.compare_fits(bench(), ["Coulomb", "Stribeck"], experiment="motion", validation=0.3, play=0.0, starts=8)
    assert ranking.best.law == "Stribeck"
    wrong = ranking["Coulomb"].validation_rms["frictionForce"]
    assert wrong > 5.0 * ranking.best.validation_rms["frictionForce"]


def test_offset_and_delay_of_the_force_are_found() -> None:
    data = bench()
    data["frictionForce"] = np.interp(data["time"] - 0.03, data["time"], data["frictionForce"]) + 0.8
    words = [*(f"friction.stribeck.{name}" for name in ("Fs", "Fc", "vs", "sigma2")), "offset.frictionForce",
             "delay.frictionForce"]  # fmt: skip
    found = ps.fit(data, experiment="motion", law="Stribeck", fit=words, play=0.0, starts=64)
    assert_close(found.values["offset.frictionForce"], 0.8, within=0.02, what="offset")
    assert_close(found.values["delay.frictionForce"], 0.03, within=5e-5, what="delay")


def test_parameters_that_the_data_do_not_determine_are_named() -> None:
    free = ["friction.lugre.Fs", "friction.lugre.Fc", "friction.lugre.sigma2", "friction.lugre.vd"]
    found = ps.fit(bench(), experiment="motion", law="LuGre", fit=free, play=0.0, starts=0)
    assert "friction.lugre.vd" in found.not_identifiable


HEADER = "t,x,f"
ROWS = [f"{0.01 * k:.2f},{k * k % 97},1.0" for k in range(100)]


@pytest.mark.parametrize(
    ("lines", "options", "words"),
    [
        ([HEADER, *ROWS], {"--columns": "time=t,position=y,frictionForce=f"}, ["data.csv:1", "no column y"]),
        ([HEADER, *ROWS], {"--columns": "time=t,position=x[inhc],frictionForce=f"}, ["inhc", "mm"]),
        ([HEADER, *ROWS], {"--columns": "time=t,position=x"}, ["frictionForce"]),
        ([HEADER, *ROWS], {"--columns": "position=x,frictionForce=f"}, ["time"]),
        ([HEADER, *ROWS], {"--columns": "time=t,place=x"}, ["place", "position"]),
        ([HEADER, *ROWS, "0.5,1,1"], {}, ["data.csv:102", "time must rise"]),
        ([HEADER, *ROWS, "1.0,nan,1"], {}, ["data.csv:102", "column 2 (x)", "nan"]),
        ([HEADER, *ROWS, "1.0,1m,1"], {}, ["data.csv:102", "column 2 (x)", "1m"]),
        ([HEADER, *ROWS, "1.0,1"], {}, ["data.csv:102", "2 values"]),
        ([HEADER, *ROWS[:20]], {}, ["too short", "20 samples"]),
        ([HEADER], {}, ["no rows"]),
        ([HEADER, *(f"{0.01 * k:.2f},5,1" for k in range(100))], {}, ["all at rest"]),
        ([HEADER, *ROWS], {"--fit": "friction.coulomb.Fx"}, ["friction.coulomb.Fx", "did you mean"]),
        ([HEADER, *ROWS], {"--fit": "friction.coulomb.Fc:3:1"}, ["lower bound 3"]),
        ([HEADER, *ROWS], {"--fit": "offset.position"}, ["position is not compared"]),
        ([HEADER, *ROWS], {"--law": "Magic"}, ["Magic", "Coulomb"]),
        ([HEADER, *ROWS], {"--law": "Coulomb,Stribeck,Coulomb"}, ["Coulomb is given twice"]),
        ([HEADER, *ROWS], {"--law": "Coulomb,"}, ["--laws Coulomb,", "empty"]),
        ([HEADER, *ROWS], {"--validation": "1.5"}, ["1.5"]),
        ([HEADER, *ROWS], {"--inputs": "curves"}, ["--inputs curves", "hold, lines, smooth"]),
        ([HEADER, *ROWS], {"--starts": "-3"}, ["--starts -3"]),
        ([HEADER, *ROWS], {"--seed": "-3"}, ["--seed -3"]),
        ([HEADER, *ROWS], {"--segment": "0"}, ["--segment 0.0"]),
        ([HEADER, *ROWS], {"--segment": "0.02"}, ["--segment 0.02 s", "10 samples", "0.01 s apart"]),
        ([HEADER, *ROWS], {"--play": "-1"}, ["--play -1.0"]),
        ([HEADER, *ROWS], {"--fit": "friction.coulomb.Fc=-2"}, ["the start -2 is not within 0 to"]),
    ],
)  # fmt: skip
def test_bad_input_is_named_and_leaves_nothing(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], lines: list[str], options: dict[str, str], words: list[str]
) -> None:
    file = tmp_path / "data.csv"
    file.write_text("\n".join([*lines, ""]), encoding="utf-8")
    given = {"--experiment": "motion", "--law": "Coulomb", "--columns": "time=t,position=x[mm],frictionForce=f",
             "--fit": "friction.coulomb.Fc", "--json": str(tmp_path / "a.json"), **options}  # fmt: skip
    assert main(["fit", str(file), *(word for pair in given.items() for word in pair)]) == 2
    told = capsys.readouterr().err
    assert all(word in told for word in words), told
    assert [left.name for left in tmp_path.iterdir()] == ["data.csv"]


def test_position_that_only_jitters_is_at_rest() -> None:
    rng = np.random.default_rng(0)
    time = np.arange(0.0, 1.0, 1e-3)
    data = {"time": time, "valveVoltage": 5.0 + np.sin(time), "position": 0.25 + 1e-5 * rng.standard_normal(len(time))}
    with pytest.raises(ValueError, match="all at rest"):
        ps.fit(data, experiment="rig", law="Stribeck", starts=0)


def test_what_is_free_by_default_has_an_effect() -> None:
    """Growth of static friction at rest is off by default: its level, 0, is no start for anything."""
    found = usual("motion", "Stribeck", ps.Model("FrictionBench"), {})
    assert found == [f"friction.stribeck.{name}" for name in ("Fs", "Fc", "vs", "sigma2")]


@pytest.mark.parametrize(
    ("law", "settings", "expected"),
    [
        # Forces, lengths, and coefficients per metre.
        ("Leuven", {}, "Fs Fc vs sigma2 n k1 f1 f2 sigma1"),
        ("Polito", {}, "Fs Fc1 vs Fc2 c1 c2"),
        # Not the speed that counts as rest.
        ("RevisedLuGre", {}, "Fs Fc vs sigma2 sigma0 sigma1 vb vd"),
        # Of the elements those that there are, and the shares in place of the level.
        ("GMS", {"friction.gms.N": 2}, "Fs vs sigma2 k[1] k[2] alpha[1] alpha[2]"),
        ("MaxwellSlip", {"friction.maxwellSlip.N": 1}, "sigma2 k[1] W[1]"),
    ],
)
def test_free_by_default_is_what_shapes_the_law(law: str, settings: dict[str, ps.Value], expected: str) -> None:
    found = usual("motion", law, ps.Model("FrictionBench"), settings)
    assert [name.rsplit(".", 1)[1] for name in found] == expected.split()


@pytest.mark.parametrize(
    ("start", "low", "high"),
    [
        # By default from 5e-5 to 10 m; a start within that keeps it, as far as it is within three decades.
        ("", 5e-5, 10.0),
        ("=5e-4", 5e-5, 0.5),
        ("=1", 1e-3, 10.0),
        # Outside only what is legal limits it, from 1e-6 m on.
        ("=2e-5", 1e-6, 0.02),
    ],
)
def test_bounds_follow_a_start_that_is_given(start: str, low: float, high: float) -> None:
    experiment = EXPERIMENTS["rig"]("Coulomb", {}, Options())
    experiment.use(["time", "valveVoltage", "position"])
    free = parse(f"friction.position.period{start}", experiment)
    assert (free.low, free.high) == (low, high) and free.low < free.start < free.high
    assert free.legal == (1e-6, 10.0)


def test_plan_says_what_it_will_determine(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    code = main([
        "plan", "--experiment", "motion", "--law", "Stribeck", "--duration", "4", "--step", "0.01",
        "--fit", "friction.stribeck.Fc,friction.stribeck.sigma2", "--out", str(tmp_path / "plan.csv"),
    ])  # fmt: skip
    assert code == 0
    printed = capsys.readouterr().out
    assert "friction.stribeck.Fc = 8.3 +- " in printed and "not identifiable" not in printed
    assert (tmp_path / "plan.csv").read_text(encoding="utf-8").startswith("time,prescribedPosition\n")


ROOT = Path(__file__).parents[2]
RIG = ROOT / "examples" / "rig.csv"
RIG_COLUMNS = "time=t,valveVoltage=u,position=x_mm[mm],chamberA.pressure=pa_bar[bar],chamberB.pressure=pb_bar[bar]"
TRUE_FRICTION = {"Fs": 12.4, "Fc": 7.6, "vs": 0.018, "sigma2": 38.0}
"""Settings of docs/studies/synthetic_rig.py for the table."""


def test_whole_rig_gives_its_friction_and_its_valve() -> None:
    free = [f"friction.stribeck.{name}" for name in TRUE_FRICTION]
    begin = ["position0", "chamberA.pressure0", "chamberB.pressure0"]
    found = ps.fit(
        RIG, experiment="rig", law="Stribeck", fit=[*free, "valve.deadZone", "valve.C", *begin], columns=RIG_COLUMNS,
        settings={"supplyPressure": 6e5}, starts=8,
    )  # fmt: skip
    truth = {f"friction.stribeck.{name}": value for name, value in TRUE_FRICTION.items()}
    truth |= {"valve.deadZone": 0.065, "valve.C": 4.4e-9}
    assert found.converged and not found.not_identifiable
    for name, value in truth.items():
        estimate = found.parameters[name]
        # Twice the interval of 95 % holds all six but for one time in 2,000.
        assert abs(estimate.value - value) < estimate.high - estimate.low < 0.5 * value, (name, estimate)
    # Error by noise and converters.
    assert_close(found.rms["position"], 0.0, within=5e-5, what="position (rms)")
    assert_close(found.rms["chamberA.pressure"], 0.0, within=550.0, what="pressure (rms)")


def test_gas_half_alone_gives_the_valve() -> None:
    found = ps.fit(
        RIG, experiment="pneumatic", law="None", fit=["valve.deadZone", "valve.C"], columns=RIG_COLUMNS,
        settings={"supplyPressure": 6e5}, starts=0,
    )  # fmt: skip
    assert_close(found.values["valve.deadZone"], 0.065, rel=3e-4, what="valve.deadZone")
    assert_close(found.values["valve.C"], 4.4e-9, rel=1e-3, what="valve.C")


def test_mechanical_half_alone_gives_mass_and_friction() -> None:
    free = [*(f"friction.stribeck.{name}" for name in TRUE_FRICTION), "mass.moving"]
    found = ps.fit(RIG, experiment="mechanical", law="Stribeck", fit=free, columns=RIG_COLUMNS, starts=0)
    # The noise of the pressures, 0.1 N, pushes the simulated carriage: tenths of a percent remain.
    assert_close(found.values["mass.moving"], 0.88, rel=6e-4, what="mass")
    assert_close(found.values["friction.stribeck.Fc"], 7.6, rel=6e-3, what="Fc")
    assert_close(found.values["friction.stribeck.Fs"], 12.4, rel=1e-3, what="Fs")
    # And the intervals know it: twice the interval of 95 % holds all five but for one time in 2,000.
    truth = {"mass.moving": 0.88} | {f"friction.stribeck.{name}": value for name, value in TRUE_FRICTION.items()}
    for name, value in truth.items():
        estimate = found.parameters[name]
        assert abs(estimate.value - value) < estimate.high - estimate.low, (name, estimate)


def test_intervals_contain_the_truth_as_often_as_they_say(monkeypatch: pytest.MonkeyPatch) -> None:
    """Ten records of a rig that is integrated independently, with other noise: a small identification_coverage.py."""
    monkeypatch.syspath_prepend(str(ROOT / "docs/studies"))
    from identification_coverage import estimates, rows
    from synthetic_rig import truth

    true = truth("Coulomb", duration=1.0)
    table = rows("Coulomb", [estimates(("Coulomb", true, seed)) for seed in range(10)])
    assert len(table) == 4
    for _, name, _, _, covered, error, half in table:
        # Of ten true intervals of 95 % fewer than seven hold once in a thousand; of half as wide ones, once in four.
        assert covered >= 7, name
        # Not by being wider than they need: the mean error of a normal distribution is 0.41 of its half interval.
        assert float(half) < 6.0 * float(error), name


def test_rounded_rest_does_not_pass_into_the_parameters() -> None:
    """The position rests for a fifth of the time, up to half a step of 122 um beside what its converter says."""
    free = ["friction.stribeck.Fs", "valve.deadZone", "valve.C"]
    known = {"supplyPressure": 6e5, "friction.stribeck.Fc": 7.6, "friction.stribeck.vs": 0.018,
             "friction.stribeck.sigma2": 38.0}  # fmt: skip
    found = ps.fit(RIG, experiment="rig", law="Stribeck", fit=free, columns=RIG_COLUMNS, settings=known, starts=0)
    assert found.problem.sensors["position"].is_coarse
    # The true noise, 10 um, is a twelfth of the step that hides it.
    assert_close(found.problem.sensors["position"].noise, 1e-5, rel=0.03, what="noise")
    for name, value in {"friction.stribeck.Fs": 12.4, "valve.deadZone": 0.065, "valve.C": 4.4e-9}.items():
        estimate = found.parameters[name]
        assert abs(estimate.value - value) < estimate.high - estimate.low < 0.01 * value, (name, estimate)


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (["--set", "supplyPressure=-1"], ["supplyPressure = -1 Pa", "at least 0 Pa"]),
        (
            ["--law", "LuGre", "--fit", "friction.lugre.Fs", "--set", "solver.scheme=ExplicitEuler,solver.step=1e-3"],
            ["no excitation", "diverges"],
        ),
        (["--experiment", "motion", "--stroke", "0"], ["--stroke 0.0 m", "positive"]),
        (["--experiment", "motion", "--stroke", "-1"], ["--stroke -1.0 m", "positive"]),
    ],
)
def test_plan_that_cannot_be_made_says_why(
    capsys: pytest.CaptureFixture[str], options: list[str], words: list[str]
) -> None:
    assert main(["plan", "--law", "Stribeck", "--fit", "friction.stribeck.Fs", *options]) == 2
    told = capsys.readouterr().err
    assert all(word in told for word in words), told


def test_parameter_that_is_named_for_all_laws_may_be_one_of_a_law() -> None:
    ranking = ps.compare_fits(bench(), ["Coulomb", "Stribeck"], experiment="motion", play=0.0, starts=0,
                              fit="friction.coulomb.Fc=5:1:20",
                              fit_of={"Stribeck": "friction.stribeck.Fs"})  # fmt: skip
    assert list(ranking["Coulomb"].parameters).count("friction.coulomb.Fc") == 1
