"""A sample of the independent reference trajectories, through the packaged FMU."""

import csv
import json
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from bounds import assert_close
from client import Client
from numpy.typing import NDArray

FOLDER = Path(__file__).parents[1] / "reference"
COLUMNS = {
    "position": "position",
    "pressureA": "chamberA.pressure",
    "pressureB": "chamberB.pressure",
    "frictionForce": "frictionForce",
}
SAMPLE = ["default-Stribeck", "lugre-stiff", "end-stops-Stribeck"]
"""Events, a stiff law, and end stops. The library meets all trajectories in tests/plant/reference.rs."""


def signal(definition: Any, time: float) -> float:
    """A constant, or a sine around an offset."""
    if not isinstance(definition, dict):
        return float(definition)
    angle = 2.0 * math.pi * definition["frequency"] * time
    return float(definition["offset"] + definition["amplitude"] * math.sin(angle))


def rows_of(fmu: Path, case: dict[str, Any], tolerance: float) -> tuple[NDArray, NDArray]:
    """Found and expected values, of shape (columns, rows)."""
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
    return np.array(found).T, np.array([[row[name] for name in COLUMNS] for row in rows]).T


@pytest.fixture(scope="module")
def cases() -> dict[str, dict[str, Any]]:
    return {case["name"]: case for case in json.loads((FOLDER / "cases.json").read_text())}


@pytest.mark.parametrize("name", SAMPLE)
def test_tight_tolerance(fmu: Path, cases: dict[str, dict[str, Any]], name: str) -> None:
    found, expected = rows_of(fmu, cases[name], 1e-10)
    for column, bound in {"position": 1e-9, "pressureA": 4e-3, "pressureB": 4e-3}.items():
        place = list(COLUMNS).index(column)
        assert_close(found[place], expected[place], within=bound, what=column.rstrip("AB"))
    friction = list(COLUMNS).index("frictionForce")
    rms = np.sqrt(np.mean((found[friction] - expected[friction]) ** 2))
    assert_close(rms, 0.0, within=5e-6, what="frictionForce (rms)")


@pytest.mark.parametrize("name", SAMPLE)
def test_default_tolerance(fmu: Path, cases: dict[str, dict[str, Any]], name: str) -> None:
    """To 1 um and 1 Pa, as README.md promises."""
    found, expected = rows_of(fmu, cases[name], 1e-6)
    for column, bound in {"position": 1e-6, "pressureA": 1.0, "pressureB": 1.0}.items():
        place = list(COLUMNS).index(column)
        assert_close(found[place], expected[place], within=bound, what=column.rstrip("AB"), why="promised")
