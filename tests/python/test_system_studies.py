"""The studies of slider, vibro-impact system and festoon, run at a small size: they find what they are about."""

import csv
import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

STUDIES = Path(__file__).parents[2] / "docs/studies"


def run(script: str, output: Path) -> str:
    command = [sys.executable, str(STUDIES / script), "--small", "--output", str(output)]
    process = subprocess.run(
        command, capture_output=True, text=True, env=os.environ | {"MPLBACKEND": "Agg"}, timeout=300, check=False
    )
    assert process.returncode == 0, process.stderr
    return process.stdout


def pictures(folder: Path) -> set[str]:
    return {file.stem for file in folder.glob("*.png") if file.stat().st_size > 10_000}


def test_vibro_impact(tmp_path: Path) -> None:
    text = run("vibro_impact.py", tmp_path)
    assert pictures(tmp_path) == {f"VibroImpact_{kind}" for kind in ("progression", "bifurcation", "basins")}
    rows = {float(level): row.split() for level, row in re.findall(r"([\d.]+) N:(.*)", text)}
    # The same force ratio of 1.19: forward at low friction, backward at high friction.
    assert float(rows[2.3][3]) > 1.0
    assert float(rows[13.6][3]) < -0.5
    assert re.search(r"irregular: \d", text), "some motions of the diagrams never repeat"
    assert re.search(r"direction changes at f_r = \d", text)


def test_driven_slider(tmp_path: Path) -> None:
    text = run("driven_slider.py", tmp_path)
    assert pictures(tmp_path) == {"DrivenSlider_period", "DrivenSlider_acceleration"}
    assert float(re.search(r"from period to period by ([\d.]+)", text)[1]) > 0.1, "no two periods are the same"
    with (tmp_path / "DrivenSlider_period.csv").open(encoding="utf-8") as file:
        rows = {row["velocity of"]: row for row in csv.DictReader(file)}
    assert "nan" not in text and all(cell != "nan" for row in rows.values() for cell in row.values())
    assert rows["stick-free attractor, flight factor 1.0"]["apart from the walk (mm/s rms)"] == ""
    walk = rows["walk, flight factor 1.0"]
    # Slower than the tray at 35 mm/s, and behind it, like the slider under the law.
    assert 20.0 < float(walk["amplitude (mm/s)"]) < float(rows["CoulombStiction"]["amplitude (mm/s)"]) < 35.0
    assert float(walk["delay (deg)"]) > 5.0


@pytest.fixture(scope="module")
def festoon(tmp_path_factory: pytest.TempPathFactory) -> dict[str, dict[str, str]]:
    folder = tmp_path_factory.mktemp("festoon")
    run("festoon.py", folder)
    assert pictures(folder) == {"Festoon_laws"}
    with (folder / "Festoon.csv").open(encoding="utf-8") as file:
        return {row["law"]: row for row in csv.DictReader(file)}


def test_festoon_shows_who_creeps(festoon: dict[str, dict[str, str]]) -> None:
    creep = {law: row["creep (um/min)"] for law, row in festoon.items()}
    assert creep["Stribeck"] == "0"
    assert float(creep["StribeckRegularised"]) > 100.0


def test_festoon_shows_break_away_and_stick_slip(festoon: dict[str, dict[str, str]]) -> None:
    stribeck = festoon["Stribeck"]
    assert (stribeck["moved by 5 N (mm)"], stribeck["moved by 10 N (mm)"]) == ("0", "0")
    assert float(stribeck["moved by 12 N (mm)"]) > 1.0
    assert int(stribeck["slips"]) > 5
    assert int(stribeck["sign changes"]) > 3
