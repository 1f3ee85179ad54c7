"""A sample of the independent reference trajectories, through the packaged FMU."""

import csv
import json
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from client import Client

FOLDER = Path(__file__).parents[1] / "reference"
COLUMNS = {
    "position": "position",
    "pressureA": "chamberA.pressure",
    "pressureB": "chamberB.pressure",
    "frictionForce": "frictionForce",
}
SAMPLE = [
    *("default-Stribeck", "default-Polito", "default-Dahl", "default-LuGre", "default-Karnopp"),
    *("sliding2-Polito", "lugre-stiff", "stribeck-delta-half", "end-stops-Stribeck"),
]


def signal(definition: Any, time: float) -> float:
    """A constant, or a sine around an offset."""
    if not isinstance(definition, dict):
        return float(definition)
    angle = 2.0 * math.pi * definition["frequency"] * time
    return float(definition["offset"] + definition["amplitude"] * math.sin(angle))


def deviations(fmu: Path, case: dict[str, Any], tolerance: float) -> tuple[float, float, float]:
    """Largest deviation in position and pressure, and rms deviation in friction force."""
    with (FOLDER / case["file"]).open(newline="") as stream:
        rows = [{name: float(value) for name, value in row.items()} for row in csv.DictReader(stream)]
    step, per_row = case["communicationStep"], round(case["outputStep"] / case["communicationStep"])
    found = []
    with Client(fmu) as client:
        inputs = {name: signal(definition, 0.0) for name, definition in case["inputs"].items()}
        client.start({"solver.relativeTolerance": tolerance, **case["parameters"], **inputs})
        found.append(client.get(list(COLUMNS.values())))
        for index in range((len(rows) - 1) * per_row):
            client.set({name: signal(definition, index * step) for name, definition in case["inputs"].items()})
            client.advance((index + 1) * step)
            if (index + 1) % per_row == 0:
                found.append(client.get(list(COLUMNS.values())))
    assert client.time == pytest.approx(case["stopTime"], abs=1e-9)
    difference = np.array(found) - np.array([[row[name] for name in COLUMNS] for row in rows])
    position, pressure_a, pressure_b, _ = np.max(np.abs(difference), axis=0)
    return position, max(pressure_a, pressure_b), math.sqrt(np.mean(difference[:, 3] ** 2))


@pytest.fixture(scope="module")
def cases() -> dict[str, dict[str, Any]]:
    return {case["name"]: case for case in json.loads((FOLDER / "cases.json").read_text())}


@pytest.mark.parametrize("name", SAMPLE)
def test_tight_tolerance(fmu: Path, cases: dict[str, dict[str, Any]], name: str) -> None:
    position, pressure, friction = deviations(fmu, cases[name], 1e-10)
    assert position < 2e-6
    assert pressure < 5.0
    assert friction < 0.05


@pytest.mark.parametrize("name", SAMPLE)
def test_default_tolerance(fmu: Path, cases: dict[str, dict[str, Any]], name: str) -> None:
    position, pressure, _ = deviations(fmu, cases[name], 1e-6)
    assert position < 1e-4
    assert pressure < 300.0
