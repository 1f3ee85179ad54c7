"""The FMU of a model from outside this repository: the quarter car of `examples/own`.

What packs it has compared its default experiment in FMI 2.0, the CSV beside it, with the model itself bit by bit.
"""

from __future__ import annotations

import csv
import shutil
from pathlib import Path

import fmpy
import numpy as np
import pytest
from bounds import assert_close
from experiment import course
from fmpy import read_model_description, simulate_fmu
from fmpy.fmi3 import FMU3Slave
from fmpy.validation import validate_fmu
from numpy.typing import NDArray

OUTPUTS = ["distance", "velocity", "wheelSpeed", "deflection", "slip", "frictionCoefficient", "locked"]
BRAKE = course({"Steps": [[0.0, 0.0], [0.5, 1400.0], [2.0, 500.0]]})
"""Brake torque of the default experiment in N.m."""


@pytest.fixture(scope="module")
def own(fmus: Path) -> dict[str, Path]:
    """The FMUs by their version."""
    folder = fmus.parent / "own" / "fmu"
    files = {"2.0": folder / "QuarterCar.fmu", "3.0": folder / "fmi3" / "QuarterCar.fmu"}
    for file in files.values():
        assert file.is_file(), f"{file} is missing: `cargo xtask test` packs it by a program in examples/own/model"
    return files


@pytest.fixture(scope="module")
def expected(own: dict[str, Path]) -> dict[str, NDArray]:
    """The default experiment."""
    with own["2.0"].with_suffix(".csv").open(encoding="utf-8", newline="") as file:
        names, *rows = csv.reader(file)
    return dict(zip(names, np.array(rows, dtype=float).T, strict=True))


@pytest.mark.parametrize("version", ["2.0", "3.0"])
def test_nothing_is_wrong_with_the_fmu(own: dict[str, Path], version: str) -> None:
    assert validate_fmu(str(own[version])) == []
    description = read_model_description(str(own[version]))
    assert (description.fmiVersion, description.modelName) == (version, "QuarterCar")
    for way in (description.coSimulation, description.modelExchange):
        assert way.canGetAndSetFMUstate and way.canSerializeFMUstate


def test_co_simulation_of_fmi_3_gives_the_bits_of_fmi_2(own: dict[str, Path], expected: dict[str, NDArray]) -> None:
    description = read_model_description(str(own["3.0"]))
    references = {variable.name: variable.valueReference for variable in description.modelVariables}
    folder = fmpy.extract(str(own["3.0"]))
    slave = FMU3Slave(
        guid=description.guid,
        unzipDirectory=folder,
        modelIdentifier=description.coSimulation.modelIdentifier,
        instanceName="car",
    )
    slave.instantiate()
    try:
        slave.enterInitializationMode(startTime=0.0)
        slave.exitInitializationMode()
        times = expected["time"]
        for index, time in enumerate(times):
            slave.setFloat64([references["brakeTorque"]], [BRAKE(time)])
            found = slave.getFloat64([references[name] for name in OUTPUTS[:-1]])
            assert list(found) == [expected[name][index] for name in OUTPUTS[:-1]], time
            locked = slave.getBoolean([references["locked"]])
            assert float(locked[0]) == expected["locked"][index], time
            if index + 1 < len(times):
                slave.doStep(time, times[index + 1] - time)
    finally:
        slave.terminate()
        slave.freeInstance()
        shutil.rmtree(folder, ignore_errors=True)


def test_wheel_locks_stands_exactly_and_rolls_again(expected: dict[str, NDArray]) -> None:
    locked = expected["locked"] == 1.0
    assert np.all(expected["wheelSpeed"][locked] == 0.0)
    assert np.all(expected["slip"][locked & (expected["velocity"] > 0.0)] == 1.0)
    between = (expected["time"] > 1.0) & (expected["time"] < 2.0)
    assert np.all(locked[between])
    assert not locked[expected["time"] == 2.5].any()


@pytest.mark.parametrize("version", ["2.0", "3.0"])
def test_cvode_outside_agrees_with_the_solver_inside(own: dict[str, Path], version: str) -> None:
    """Under a constant brake, which locks the wheel; at tight tolerances."""
    settings = {
        "stop_time": 2.0,
        "output_interval": 1e-2,
        "start_values": {"brakeTorque": 1400.0, "solver.relativeTolerance": 1e-9},
        "output": OUTPUTS,
    }
    inside = simulate_fmu(str(own[version]), fmi_type="CoSimulation", **settings)
    outside = simulate_fmu(
        str(own[version]), fmi_type="ModelExchange", solver="CVode", relative_tolerance=1e-9, **settings
    )
    # FMPy records both sides of events; of values at one instant the last counts.
    _, last = np.unique(outside["time"][::-1], return_index=True)
    outside = outside[::-1][last]
    for name, bound in [("distance", 1e-6), ("velocity", 1e-6), ("deflection", 5e-10)]:
        found = np.interp(inside["time"], outside["time"], outside[name])
        assert_close(found, inside[name], within=bound, what=name)
    assert inside["locked"][-1] and outside["locked"][-1]
    assert outside["wheelSpeed"][-1] == 0.0
