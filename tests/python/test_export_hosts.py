"""Configured FMUs and drives in libcosim, Ecos and FMPy: they run as the released files with the same values set."""

from __future__ import annotations

import zipfile
from collections.abc import Callable
from pathlib import Path

import drive
import numpy as np
import pneumatic_servo as ps
import pytest
from client import Client
from fmpy.ssp.simulation import simulate_ssp

MACHINE = {"friction.law": "LuGre", "mass.moving": 3.1, "position0": 0.1, "supplyPressure": 6.5e5}
NANOSECONDS = 1_953_125
STEP = NANOSECONDS / 1e9
"""Communication step in s, 1/512, whose multiples are exact in every way in which hosts count."""
STEPS, VOLTAGE = 200, 6.5
OUTPUTS = ["position", "velocity", "chamberA.pressure", "chamberB.pressure", "frictionForce"]


@pytest.fixture(scope="module")
def axis(fmu: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("axis")
    return ps.export_fmu(folder / "axis7.fmu", MACHINE, preset="minimal", source=fmu)[0]


@pytest.fixture(scope="module")
def expected() -> list[float]:
    """Outputs of the package after all steps."""
    run = ps.Model().simulate(MACHINE, inputs={"valveVoltage": VOLTAGE}, stop=STEPS * STEP, step=STEP, outputs=OUTPUTS)
    assert np.ptp(run["position"]) > 1e-2
    return [float(run[name][-1]) for name in OUTPUTS]


def test_libcosim_finds_the_bits_of_the_package(axis: Path, expected: list[float]) -> None:
    from libcosimpy.CosimExecution import CosimExecution
    from libcosimpy.CosimObserver import CosimObserver
    from libcosimpy.CosimSlave import CosimLocalSlave

    with Client(axis) as client:
        voltage, *outputs = [client.variables[name].valueReference for name in ["valveVoltage", *OUTPUTS]]
    execution = CosimExecution.from_step_size(step_size=NANOSECONDS)
    plant = execution.add_local_slave(CosimLocalSlave(fmu_path=str(axis), instance_name="plant"))
    assert execution.real_initial_value(plant, voltage, VOLTAGE)
    observer = CosimObserver.create_last_value()
    execution.add_observer(observer)
    for _ in range(STEPS):
        assert execution.step()
    assert list(observer.last_real_values(plant, outputs)) == expected


def test_ecos_finds_the_bits_of_the_package(axis: Path, expected: list[float]) -> None:
    from ecospy import EcosSimulation, EcosSimulationStructure

    with EcosSimulationStructure() as structure:
        structure.add_model("plant", axis)
        structure.add_parameter_set("voltage", {"plant::valveVoltage": VOLTAGE})
        with EcosSimulation(structure=structure, step_size=STEP) as simulation:
            simulation.init(parameter_set="voltage")
            for _ in range(STEPS):
                simulation.step()
            assert [simulation.get_real(f"plant::{name}") for name in OUTPUTS] == expected


@pytest.fixture(scope="module")
def released(fmus: Path) -> Path:
    return fmus / "PneumaticServoDrive.ssp"


@pytest.fixture(scope="module")
def own(released: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """With the values of the set `Dry`, which the released drive is bound to."""
    return ps.export_drive(tmp_path_factory.mktemp("own") / "drive.ssp", source=released)


def unpacked(ssp: Path, folder: Path) -> Path:
    with zipfile.ZipFile(ssp) as archive:
        archive.extractall(folder)
    return (folder / "Components.ssd").replace(folder / "SystemStructure.ssd").parent


def by_ecos(folder: Path, parameter_set: str | None, times: np.ndarray, references: np.ndarray) -> list[float]:
    from ecospy import EcosSimulation

    found = []
    with EcosSimulation(ssp_path=str(folder), step_size=drive.STEP) as simulation:
        simulation.init(**({} if parameter_set is None else {"parameter_set": parameter_set}))
        for step in range(STEPS):
            wanted = float(np.interp(1.0 + step * drive.STEP, times, references))
            simulation.set_real("controller::referencePosition", wanted)
            simulation.step()
            found.append(simulation.get_real("plant::position"))
    return found


def by_libcosim(folder: Path, _: str | None, times: np.ndarray, references: np.ndarray) -> list[float]:
    from libcosimpy.CosimExecution import CosimExecution
    from libcosimpy.CosimManipulator import CosimManipulator
    from libcosimpy.CosimObserver import CosimObserver

    execution = CosimExecution.from_ssp_file(ssp_path=str(folder), step_size=round(1e9 * drive.STEP))
    plant, controller = (execution.slave_index_from_instance_name(name) for name in ("plant", "controller"))
    manipulator, observer = CosimManipulator.create_override(), CosimObserver.create_last_value()
    execution.add_manipulator(manipulator)
    execution.add_observer(observer)
    with Client(folder / "resources" / "PneumaticServoCylinder.fmu") as cylinder:
        position = [cylinder.variables["position"].valueReference]
    with Client(folder / "resources" / "PositionController.fmu") as positioner:
        reference = [positioner.variables["referencePosition"].valueReference]
    found: list[float] = []
    for step in range(STEPS):
        wanted = float(np.interp(1.0 + step * drive.STEP, times, references))
        manipulator.slave_real_values(controller, reference, [wanted])
        assert execution.step()
        found += observer.last_real_values(plant, position)
    return found


Host = Callable[[Path, str | None, np.ndarray, np.ndarray], list[float]]


@pytest.mark.parametrize("host", [by_ecos, by_libcosim])
def test_drive_runs_as_the_released_one_with_its_set(released: Path, own: Path, tmp_path: Path, host: Host) -> None:
    times, references = drive.reference(released)
    found = host(unpacked(own, tmp_path / "own"), None, times, references)
    assert found == host(unpacked(released, tmp_path / "released"), "Dry", times, references)
    assert np.ptp(found) > 1e-3


def test_drive_runs_in_fmpy_as_the_released_one_with_its_set(released: Path, own: Path) -> None:
    times, references = drive.reference(released)
    seen = simulate_ssp(
        str(own), stop_time=times[-1], step_size=drive.STEP,
        input={"referencePosition": lambda time: float(np.interp(time, times, references))},
    )  # fmt: skip
    expected = drive.simulate(released, "Dry")
    for name in drive.OUTPUTS:
        assert np.array_equal(seen[name], expected[name]), name
