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
