"""Verdicts of fits on data whose faults are known."""

from __future__ import annotations

import json
import re
from pathlib import Path

import numpy as np
import pneumatic_servo as ps
import pytest
from numpy.typing import NDArray
from pneumatic_servo.cli import main
from test_identification import COLUMNS, bench, write

GIVEN = {"experiment": "motion", "play": 0.0, "starts": 0, "progress": False, "validation": 0.3}


def fit(data: dict[str, NDArray[np.float64]], law: str = "Stribeck", **options: object) -> ps.Fit:
    return ps.fit(data, law=law, **{**GIVEN, **options})  # type: ignore[arg-type]


def test_right_law_is_green() -> None:
    found = fit(bench()).verdict
    assert found.light == "green" and "describes the data" in found.text
    assert any("looks like noise" in finding.text for finding in found.findings)
    assert any(re.search(r"validation data of frictionForce: 0\.0(4[5-9]|5)", one.text) for one in found.findings)
    assert str(found).startswith("green: ")


def test_wrong_law_is_not_and_says_where() -> None:
    """Coulomb friction has no peak at low speed."""
    found = fit(bench(), "Coulomb").verdict
    assert found.light == "yellow"
    [finding] = [finding for finding in found.findings if "times the noise" in finding.text]
    assert "most of it at reversals" in finding.text or "most of it in slow motion" in finding.text


def test_turned_sign_is_red() -> None:
    data = bench()
    data["frictionForce"] = -data["frictionForce"]
    with pytest.warns(ps.PlantWarning):
        found = fit(data).verdict
    assert found.light == "red" and "look at signs, units" in found.text


def test_friction_that_changes_after_the_fit_is_told() -> None:
    data = bench()
    late = data["time"] > 7.0
    data["frictionForce"] = np.where(late, 1.3, 1.0) * data["frictionForce"]
    found = fit(data).verdict
    assert found.light == "red"
    assert any(finding.light == "red" and "validation data" in finding.text for finding in found.findings)


def test_what_the_data_do_not_tell_is_yellow() -> None:
    data = bench()
    found = fit(data, "LuGre", fit=[f"friction.lugre.{name}" for name in ("Fs", "Fc", "sigma2", "vd")]).verdict
    assert found.light in ("yellow", "red") and "not identifiable" in found.text and "friction.lugre.vd" in found.text


def test_command_line_and_files_have_it(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = write(tmp_path / "bench.csv", bench())
    files = ["--json", str(tmp_path / "a.json"), "--report", str(tmp_path / "a.html")]
    given = ["--experiment", "motion", "--law", "Stribeck", "--columns", COLUMNS, "--play", "0", "--starts", "0"]
    assert main(["fit", str(file), *given, *files]) == 0
    printed = capsys.readouterr().out
    told = json.loads((tmp_path / "a.json").read_text(encoding="utf-8"))["verdict"]
    assert told["light"] == "green" and f"verdict: green: {told['text']}" in printed
    assert "no prediction was tested" in told["text"]
    assert "<p class=green><b>Green.</b>" in (tmp_path / "a.html").read_text(encoding="utf-8")


def rotor(noise: float) -> ps.Fit:
    """An inertia of 0.5 kg.m2 under a torque of 1.45 N.m rms, whose angle has a noise in rad."""
    time = np.arange(0.0, 4.0, 2e-3)
    torque = 2.0 * np.sin(4.0 * time) + 0.6 * np.sin(11.0 * time)
    settings = {"mass": 0.5, "friction.law": "Coulomb", "friction.coulomb.Fc": 0.2, "friction.coulomb.sigma2": 0.05,
                "bench.drive": "Free"}  # fmt: skip
    run = ps.Model("FrictionBench").simulate(
        settings, inputs={"appliedForce": (time, torque)}, stop=float(time[-1]), step=2e-3
    )
    angle = run["position"] + noise * np.random.default_rng(3).standard_normal(len(time))
    return ps.fit(
        {"time": time, "position": angle, "force": torque}, experiment="force", law="Coulomb", starts=0, progress=False,
        columns="time=time,position=position[rad],force=force[N.m]", settings={"mass": "0.5 kg.m2"},
        fit=["friction.coulomb.Fc", "friction.coulomb.sigma2"],
    )  # fmt: skip


def test_friction_that_the_noise_of_an_angle_hides_is_not_spoken_of() -> None:
    """Its second derivative times the inertia is torques of several N.m, of which no law is the reason."""
    clear, noisy = rotor(2e-5), rotor(0.01)
    assert clear.free_form is not None and clear.free_form.law < 0.15
    assert noisy.converged and noisy.free_form is None and "free curve" not in noisy.verdict.text


def test_value_whose_interval_reaches_beyond_what_is_possible_is_not_identifiable() -> None:
    time = np.arange(0.0, 4.0, 1e-2)
    position, speed = 1e-3 * np.sin(3.0 * time), 3e-3 * np.cos(3.0 * time)
    force = 7.0 * np.sign(speed) + 20.0 * speed + 2.0 * np.random.default_rng(0).standard_normal(len(time))
    data = {"time": time, "position": position, "frictionForce": force}
    found = fit(data, "Coulomb", fit=["friction.coulomb.Fc", "friction.coulomb.sigma2"])
    assert found.parameters["friction.coulomb.sigma2"].low < 0.0
    assert list(found.not_identifiable) == ["friction.coulomb.sigma2"] and found.verdict.light == "yellow"


@pytest.mark.parametrize("seed", [0, 1])
def test_bound_that_physics_sets_is_not_to_be_widened(seed: int) -> None:
    """A valve without leakage: its best estimate is 0, and less there is not."""
    time, rng = np.arange(0.0, 1.0, 2e-3), np.random.default_rng(seed)
    voltage = 5.0 - np.sin(2.0 * np.pi * time) + 0.8 * np.sin(20.0 * time)
    run = ps.Model().simulate(
        {"valve.leakage": 0.0, "supplyPressure": 6e5}, inputs={"valveVoltage": {"hold": (time, voltage)}},
        stop=float(time[-1]), step=2e-3,
    )  # fmt: skip
    data = {"time": time, "valveVoltage": voltage, "position": run["position"]}
    for signal in ("chamberA.pressure", "chamberB.pressure"):
        data[signal] = run[signal] + 500.0 * rng.standard_normal(len(time))
    given = {"experiment": "pneumatic", "law": "None", "starts": 0, "progress": False,
             "settings": {"supplyPressure": 6e5}}  # fmt: skip
    found = ps.fit(data, fit=["valve.C", "valve.leakage"], **given)
    assert found.values["valve.leakage"] == pytest.approx(0.0, abs=1e-9) and found.verdict.light == "green"
    chosen = ps.fit(data, fit=["valve.C", "valve.leakage=0.02:0.01:0.1"], **given)
    assert chosen.verdict.light != "green" and "Widen the bound" in chosen.verdict.text
