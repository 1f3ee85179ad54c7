"""The same run through other hosts than FMPy: libcosim, Ecos, and the checker of the FMU manipulation toolbox.

All hold the input over steps of 1 ms. They compute the times of the steps in different ways (products, sums, integer
nanoseconds), which differ in the last bits; so may the results, by a thousand times that.
"""

from __future__ import annotations

import subprocess
import sys
from itertools import pairwise
from pathlib import Path

import pytest
from bounds import assert_close
from client import Client

VOLTAGE = 7.0
STEPS = 200
OUTPUTS = ["position", "velocity", "chamberA.pressure", "chamberB.pressure", "frictionForce"]
ROUNDING = 1e-9
"""Relative."""


LAWS = {"by default": 0, "Dahl": 10, "LuGre": 14}
"""Numbers of laws; 0 leaves the choice to the enumeration, which is at Stribeck."""


@pytest.fixture(scope="module")
def expected(fmu: Path) -> dict[str, list[float]]:
    """What FMPy finds under each law, chosen by its name.

    After 5 V while initializing, 7 V move the carriage through the middle of its stroke.
    """
    return {law: found_by_fmpy(fmu, "Stribeck" if number == 0 else law) for law, number in LAWS.items()}


def found_by_fmpy(fmu: Path, law: str) -> list[float]:
    with Client(fmu) as client:
        client.start({"friction.law": law})
        client.set({"valveVoltage": VOLTAGE})
        for step in range(STEPS):
            client.advance((step + 1) * 1e-3)
        return client.get(OUTPUTS)


def test_laws_are_told_apart(expected: dict[str, list[float]]) -> None:
    """By a hundred thousand times what the hosts may differ: positions by 0.1 mm and more."""
    positions = sorted(found[0] for found in expected.values())
    assert min(b - a for a, b in pairwise(positions)) > 1e-4, positions


@pytest.mark.parametrize("law", LAWS)
def test_libcosim_gives_the_same_results(fmu: Path, expected: dict[str, list[float]], law: str) -> None:
    from libcosimpy.CosimExecution import CosimExecution
    from libcosimpy.CosimManipulator import CosimManipulator
    from libcosimpy.CosimObserver import CosimObserver
    from libcosimpy.CosimSlave import CosimLocalSlave

    with Client(fmu) as client:
        names = ["friction.lawNumber", "valveVoltage", *OUTPUTS]
        number, voltage, *outputs = [client.variables[name].valueReference for name in names]
    execution = CosimExecution.from_step_size(step_size=1_000_000)  # ns
    plant = execution.add_local_slave(CosimLocalSlave(fmu_path=str(fmu), instance_name="plant"))
    assert execution.integer_initial_value(plant, number, LAWS[law])
    manipulator, observer = CosimManipulator.create_override(), CosimObserver.create_last_value()
    execution.add_manipulator(manipulator)
    execution.add_observer(observer)
    manipulator.slave_real_values(plant, [voltage], [VOLTAGE])
    for _ in range(STEPS):
        assert execution.step()
    assert_close(
        observer.last_real_values(plant, outputs),
        expected[law],
        rel=ROUNDING,
        what="outputs",
        why="hosts count time differently",
    )


@pytest.mark.parametrize("law", LAWS)
def test_ecos_gives_the_same_results(fmu: Path, expected: dict[str, list[float]], law: str) -> None:
    from ecospy import EcosSimulation, EcosSimulationStructure

    with EcosSimulationStructure() as structure:
        structure.add_model("plant", fmu)
        structure.add_parameter_set("law", {"plant::friction.lawNumber": LAWS[law]})
        with EcosSimulation(structure=structure, step_size=1e-3) as simulation:
            simulation.init(parameter_set="law")
            simulation.set_real("plant::valveVoltage", VOLTAGE)
            for _ in range(STEPS):
                simulation.step()
            found = [simulation.get_real(f"plant::{name}") for name in OUTPUTS]
    assert_close(found, expected[law], rel=ROUNDING, what="outputs", why="hosts count time differently")


@pytest.mark.parametrize("model", ["PneumaticServoCylinder", "PositionController"])
def test_toolbox_finds_no_error(fmu: Path, model: str) -> None:
    tool = Path(sys.executable).with_name("fmutool")
    answer = subprocess.run(
        [tool, "-input", fmu.with_name(f"{model}.fmu"), "-check"], capture_output=True, text=True, check=True
    )
    text = answer.stdout + answer.stderr
    assert "seems to be compliant with FMI-2.0" in text, text
    assert "No semantic error" in text, text
    assert "ERROR" not in text, text
