"""The parameter sets inside the FMU, as a host reads them, and those that the package writes."""

from __future__ import annotations

import json
import zipfile
from pathlib import Path

import pneumatic_servo as ps
import pytest
from check import VALUES, errors, invalid_sets
from client import Client, Value
from fmpy.ssp.ssd import read_ssv
from lxml import etree
from pneumatic_servo.ssv import ssv

SOURCE = Path(__file__).parents[2] / "modelDescription" / "parameter_sets.json"
SETS = {s["name"]: s["values"] for s in json.loads(SOURCE.read_text()) if s["of"] == "PneumaticServoCylinder"}
READ = {"Real": float, "Integer": int, "Enumeration": str}


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


def test_sets_that_the_package_writes_are_valid(tmp_path: Path) -> None:
    ps.DataSheet(bore=32, rod=12, stroke=200, mass=5, qn=700).to_ssv(tmp_path / "sheet.ssv")
    of_all_kinds = {"friction.law": "LuGre", "mass.moving": 1.5, "valve.polarity": -1, "balance.enabled": True}
    text = ssv("Kinds", 'of <all> "kinds" & more', ps.Model(), of_all_kinds)
    assert ps.read_ssv(tmp_path / "sheet.ssv")["cylinder.bore"] == 0.032
    for written in ((tmp_path / "sheet.ssv").read_text(encoding="utf-8"), text):
        assert errors(etree.fromstring(written.encode()), VALUES) == []
    broken = etree.fromstring(text.replace("<ssv:Integer", "<ssv:Whole").encode())
    assert any("Whole" in error for error in errors(broken, VALUES))
