"""The parameter sets inside the FMU, as a host reads them, and those that the package writes."""

from __future__ import annotations

import csv
import json
import re
import zipfile
from pathlib import Path

import numpy as np
import pneumatic_servo as ps
import pytest
from check import check, invalid_sets
from client import Client, Value
from fmpy.ssp.ssd import read_ssv
from pneumatic_servo.ssv import ssv

ROOT = Path(__file__).parents[2]
SOURCE = ROOT / "modelDescription" / "parameter_sets.json"
SETS = {s["name"]: s["values"] for s in json.loads(SOURCE.read_text()) if s["of"] == "PneumaticServoCylinder"}
READ = {"Real": float, "Integer": int, "Enumeration": str, "Boolean": "true".__eq__}


def test_sets_are_valid_and_complete(fmu: Path) -> None:
    assert invalid_sets(fmu) == []
    with zipfile.ZipFile(fmu) as archive:
        files = {name for name in archive.namelist() if name.startswith("resources/")}
    assert files == {f"resources/{name}.{suffix}" for name in SETS for suffix in ("json", "ssv")}


@pytest.mark.parametrize("name", SETS)
def test_set_is_taken_by_the_fmu(fmu: Path, client: Client, name: str) -> None:
    """JSON and SSV say the same; the FMU starts with it, has its values and moves."""
    with zipfile.ZipFile(fmu) as archive:
        values: dict[str, Value] = json.loads(archive.read(f"resources/{name}.json"))["values"]
    parameters = read_ssv(str(fmu), f"resources/{name}.ssv").parameters
    assert {p.name: READ[p.type](p.value) for p in parameters} == values == SETS[name]
    client.start(values)
    for variable, value in values.items():
        expected = client.items(variable)[value] if isinstance(value, str) else value
        assert client.get([variable]) == [expected]
    before = client.get(["position"])
    client.set({"supplyPressure": 7e5, "valveVoltage": 6.0})
    client.advance(1.0)
    assert client.get(["position"]) != before


def test_page_has_all_sets_with_their_laws() -> None:
    text = (ROOT / "docs" / "parameters.md").read_text(encoding="utf-8").partition("## Identified sets")[2]
    told = {}
    for line in text.splitlines():
        names, _, rest = line.strip("| ").partition(" | ")
        laws = rest.partition(" | ")[0].split(", ")
        own = re.findall(r"`(\w+)`", names) if line.startswith("| `") else []
        told |= dict(zip(own, laws * len(own) if len(laws) == 1 else laws, strict=False))
    assert told == {name: values["friction.law"] for name, values in SETS.items()}


SEALS = {"O-ring": "SealORing", "NAPN": "SealNAPN", "NAP310": "SealNAP310", "PK": "SealPK", "KDN": "SealKDN"}


@pytest.mark.filterwarnings("ignore::pneumatic_servo.PlantWarning")
@pytest.mark.parametrize("ring", SEALS)
def test_seal_has_the_friction_of_its_records(ring: str) -> None:
    """Slid out and in at 15 mm/s under each pressure of the records, and passive over the whole cycle."""
    with (ROOT / "docs" / "identification" / "seals_left_out.csv").open(encoding="utf-8") as file:
        rows = [row for row in csv.DictReader(file) if row["ring"] == ring]
    assert len(rows) == 4
    errors = []
    for row in rows:
        pressure, measured = 1e5 * float(row["pressure left out (bar)"]), float(row["measured (N)"])
        time = np.arange(0.0, 4.001, 1e-3)
        place = 0.02 + 0.01 * np.sin(0.5 * np.pi * time)
        settings = {name: value for name, value in SETS[SEALS[ring]].items() if name != "position0"}
        run = ps.Model().simulate(
            {**settings, "motion": "Imposed", "actuation": "PressureRegulator", "regulator.C": 1e-6,
             "supplyPressure": 1.2e6, "regulator.pMax": 1e6, "chamberA.pressure0": pressure + 101_325.0},
            inputs={"imposedPosition": (time, place), "imposedVelocity": (time, np.gradient(place, time)),
                    "valveVoltage": 10.0 * (pressure + 1325.0) / 9e5},
            stop=4.0, step=1e-3, outputs=["position", "frictionForce"],
        )  # fmt: skip
        force = run["frictionForce"]
        errors.append((force.max() - force.min()) / (2.0 * measured) - 1.0)
        work = np.sum(0.5 * (force[1:] + force[:-1]) * np.diff(run["position"]))
        # A path of 40 mm against friction, less what bristles of 0.2 mm give back at two reversals.
        assert 0.95 * 0.04 * force.max() < work < 0.04 * force.max()
    # A line over pressure, of records that are not on one.
    assert max(map(abs, errors)) < 0.17 and abs(np.mean(errors)) < 0.05, errors


def test_sets_that_the_package_writes_are_valid(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    ps.DataSheet(bore=32, rod=12, stroke=200, mass=5, qn=700).to_ssv(tmp_path / "sheet.ssv")
    of_all_kinds = {"friction.law": "LuGre", "mass.moving": 1.5, "valve.polarity": -1, "balance.enabled": True}
    text = ssv("Kinds", 'of <all> "kinds" & more', ps.Model(), of_all_kinds)
    (tmp_path / "kinds.ssv").write_text(text, encoding="utf-8")
    assert ps.read_ssv(tmp_path / "sheet.ssv")["cylinder.bore"] == 0.032
    for name in ("sheet.ssv", "kinds.ssv"):
        assert check(tmp_path / name) == 0
    (tmp_path / "broken.ssv").write_text(text.replace("<ssv:Integer", "<ssv:Whole"), encoding="utf-8")
    assert check(tmp_path / "broken.ssv") > 0
    assert "Whole" in capsys.readouterr().err


def test_sets_that_the_package_writes_have_units(tmp_path: Path) -> None:
    """A host that counts masses in grams knows what is meant."""
    text = ssv("Kinds", "", ps.Model(), {"mass.moving": 1.5, "supplyPressure": 6e5, "friction.law": "LuGre"})
    (tmp_path / "kinds.ssv").write_text(text, encoding="utf-8")
    assert [(p.name, p.type, p.value, p.unit) for p in read_ssv(str(tmp_path / "kinds.ssv")).parameters] == [
        ("mass.moving", "Real", "1.5", "kg"),
        ("supplyPressure", "Real", "600000.0", "Pa"),
        ("friction.law", "Enumeration", "LuGre", None),
    ]
    assert '<ssc:Unit name="Pa">\n      <ssc:BaseUnit kg="1" m="-1" s="-2"/>' in text


@pytest.mark.parametrize(
    ("settings", "words"),
    [
        ({"mass.moving": -1.0}, "mass.moving = -1"),
        ({"friction.law": "Sticky"}, "friction.law = "),
        ({"position": 0.1}, "position cannot be set: it is computed"),
        ({"mass.movin": 1.0}, "there is no variable mass.movin; did you mean mass.moving"),
    ],
)
def test_what_a_model_cannot_have_is_not_written(settings: dict[str, Value], words: str) -> None:
    with pytest.raises(ValueError, match=words):
        ssv("Wrong", "", ps.Model(), settings)
