"""The drive: cylinder and controller as an SSP, through FMPy, libcosim and Ecos."""

from __future__ import annotations

import shutil
import zipfile
from pathlib import Path
from xml.etree import ElementTree

import drive
import numpy as np
import pytest
from bounds import assert_close, largest
from check import invalid_sets, invalid_systems
from client import Client
from fmpy.ssp.simulation import simulate_ssp
from fmpy.ssp.ssd import read_ssv
from pyssp_standard.ssp import SSP

STEPS = 2500
"""Of 1 ms: over several rests of the dry carriage."""

AGREEMENT = 1e-6
"""In m. Hosts count time differently, in the last bits; sticking and slipping multiply that by orders of magnitude."""


@pytest.fixture(scope="module")
def ssp(fmu: Path) -> Path:
    return fmu.with_name("PneumaticServoDrive.ssp")


@pytest.fixture(scope="module")
def second(ssp: Path) -> Path:
    """By SSP 2.0, of the FMUs for FMI 3.0."""
    return ssp.parent / "fmi3" / ssp.name


@pytest.fixture(scope="module")
def unpacked(ssp: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The SSP with the description for hosts that know components alone as its only one."""
    folder = tmp_path_factory.mktemp("ssp")
    with zipfile.ZipFile(ssp) as archive:
        archive.extractall(folder)
    (folder / "Components.ssd").replace(folder / "SystemStructure.ssd")
    return folder


def test_files_obey_the_schemas(ssp: Path) -> None:
    assert invalid_systems(ssp) == []
    assert invalid_sets(ssp) == []
    assert drive.sets(ssp) == ["Dry", "Lubricated"]


VARIANTS = ["Components", "ComponentsLubricated", "SystemStructure"]


@pytest.mark.parametrize("version", ["1.0", "2.0"])
def test_another_implementation_reads_every_description_and_set(ssp: Path, second: Path, version: str) -> None:
    """pyssp-standard has schemas and rules for connections of its own, those of SSP 2.0 too."""
    with SSP(ssp if version == "1.0" else second, mode="r") as archive:
        assert sorted(archive.variants) == VARIANTS
        for variant in VARIANTS:
            with archive.variants[variant] as ssd:
                assert ssd.version == version
                ssd.__check_compliance__()
                assert len(ssd.system.elements) == 2
        assert len(archive.ssv) == 2
        for ssv in archive.ssv:
            with ssv as values:
                assert values.version == version
                values.__check_compliance__()


def test_both_versions_state_the_same_system(ssp: Path, second: Path) -> None:
    """SSP 2.0 keeps the namespaces; its types of connectors and values are those of FMI 3.0, and so are the FMUs."""

    def stated(archive: zipfile.ZipFile, name: str) -> list[tuple[str, dict[str, str]]]:
        of_the_version = {"version", "generationDateAndTime"}
        return [
            (element.tag, {key: value for key, value in element.attrib.items() if key not in of_the_version})
            for element in ElementTree.fromstring(archive.read(name)).iter()
        ]

    def renamed(tag: str) -> str:
        namespace, name = tag.split("}")
        return f"{namespace}}}{ {'Real': 'Float64', 'Integer': 'Int32'}.get(name, name) }"

    with zipfile.ZipFile(ssp) as one, zipfile.ZipFile(second) as two:
        assert one.namelist() == two.namelist()
        for name in one.namelist():
            if name.endswith((".ssd", ".ssv")):
                assert [(renamed(tag), values) for tag, values in stated(one, name)] == stated(two, name), name
            elif name.endswith(".fmu"):
                assert two.read(name) == (second.parent / Path(name).name).read_bytes()


def test_descriptions_have_different_names_and_bind_one_set_each(ssp: Path) -> None:
    """OMSimulator refuses equal names; libcosim takes the first of several sets at a place and OMSimulator the last."""
    with zipfile.ZipFile(ssp) as archive:
        roots = [ElementTree.fromstring(archive.read(f"{variant}.ssd")) for variant in VARIANTS]
    assert len({root.get("name") for root in roots}) == len(VARIANTS)
    for root in roots:
        assert len(list(root.iter("{http://ssp-standard.org/SSP1/SystemStructureDescription}ParameterBinding"))) == 1
        [annotation] = root.iter("{http://ssp-standard.org/SSP1/SystemStructureCommon}Annotation")
        assert annotation.get("type") == "org.openmodelica"


def test_pressures_and_sticking_are_seen_from_outside(ssp: Path) -> None:
    result = drive.simulate(ssp, "Dry")
    assert np.all(result["pressureA"][10:] > 1e5) and np.all(result["pressureB"][10:] > 1e5)
    assert set(result["sticking"].tolist()) == {False, True}
    assert np.all(result["velocity"][1:][result["sticking"][1:]] == 0.0)


def test_undriven_drive_stays_where_it_is(ssp: Path) -> None:
    """The sets of parameters start the reference where the carriage starts."""
    for name in drive.sets(ssp):
        parameters = read_ssv(str(ssp), f"resources/{name}.ssv")
        starts = {p.name: float(p.value) for p in parameters.parameters}
        held = {
            connector: lambda _, value=starts[connector]: value for connector in ("referencePosition", "externalForce")
        }
        result = simulate_ssp(str(ssp), stop_time=2.0, step_size=drive.STEP, parameter_set=parameters, input=held)
        assert np.ptp(result["position"][10:]) == 0.0, name


def test_schemas_would_find_mistakes(ssp: Path, tmp_path: Path) -> None:
    broken = tmp_path / "broken.ssp"
    with zipfile.ZipFile(ssp) as source, zipfile.ZipFile(broken, "w") as target:
        for name in ["SystemStructure.ssd", "Components.ssd"]:
            text = source.read(name).decode()
            target.writestr(name, text.replace('kind="input"', 'kind="inlet"').replace("ssv:Real", "ssv:Complex"))
    assert any("inlet" in finding for finding in invalid_systems(broken))
    assert any("Complex" in finding for finding in invalid_sets(broken))


def test_dry_carriage_sticks_and_slips_and_the_lubricated_one_follows(ssp: Path) -> None:
    dry, lubricated = drive.simulate(ssp, "Dry"), drive.simulate(ssp, "Lubricated")
    # Both start from rest at the beginning of each ramp; only the dry one stops again on the way, about ten times.
    assert len(drive.rests(dry)) > 12
    assert len(drive.rests(lubricated)) <= 3
    error = {name: run["referencePosition"] - run["position"] for name, run in [("d", dry), ("l", lubricated)]}
    on_the_ramp = (dry["time"] > 1.0) & (dry["time"] < 3.4)
    assert largest(error["d"][on_the_ramp]) > 2e-3
    assert_close(error["l"][on_the_ramp], 0.0, within=0.5e-3, what="error of the lubricated carriage")
    for run in (dry, lubricated):
        assert_close(run["position"][-1], 0.25, within=4e-3, what="end")
        assert np.all((run["valveVoltage"] >= 0.0) & (run["valveVoltage"] <= 10.0))


def stepped(ssp: Path, folder: Path, name: str) -> np.ndarray:
    """Positions of both FMUs stepped by hand: each step starts with the outputs at its communication point."""
    parameters = read_ssv(str(ssp), f"resources/{name}.ssv").parameters
    values = {p.name.removeprefix("plant."): float(p.value) for p in parameters if p.name.startswith("plant.")}
    times, references = drive.reference(ssp)
    positions = []
    fmus = folder / "resources"
    with Client(fmus / "PneumaticServoCylinder.fmu") as plant, Client(fmus / "PositionController.fmu") as controller:
        plant.start(values)
        controller.start()
        for step in range(STEPS):
            position, velocity = plant.get(["position", "velocity"])
            [voltage] = controller.get(["valveVoltage"])
            wanted = float(np.interp(step * drive.STEP, times, references))
            controller.set({"referencePosition": wanted, "position": position, "velocity": velocity})
            plant.set({"valveVoltage": voltage})
            for fmu in (plant, controller):
                fmu.advance((step + 1) * drive.STEP)
            positions += plant.get(["position"])
    return np.array(positions)


@pytest.mark.parametrize("name", ["Dry", "Lubricated"])
def test_fmpy_agrees_with_stepping_by_hand(ssp: Path, unpacked: Path, name: str) -> None:
    """FMPy hands all values on one step late at the start, and then like the others."""
    expected = stepped(ssp, unpacked, name)
    found = drive.simulate(ssp, name)["position"][:STEPS]
    # The system input, too, reaches the controller a step later: 20 um at 20 mm/s, and the control error it causes.
    rms = np.sqrt(np.mean((found - expected) ** 2))
    assert_close(rms, 0.0, within=5e-4 if name == "Dry" else 1e-4, what=name)


@pytest.mark.parametrize(("name", "description"), [("Dry", "Components"), ("Lubricated", "ComponentsLubricated")])
def test_ecos_runs_the_components(ssp: Path, unpacked: Path, tmp_path: Path, name: str, description: str) -> None:
    from ecospy import EcosSimulation

    folder = tmp_path / "drive"
    shutil.copytree(unpacked, folder)
    with zipfile.ZipFile(ssp) as archive:
        (folder / "SystemStructure.ssd").write_bytes(archive.read(f"{description}.ssd"))
    times, references = drive.reference(ssp)
    found = []
    with EcosSimulation(ssp_path=str(folder), step_size=drive.STEP) as simulation:
        simulation.init(parameter_set=name)
        for step in range(STEPS):
            wanted = float(np.interp(step * drive.STEP, times, references))
            simulation.set_real("controller::referencePosition", wanted)
            simulation.step()
            found.append(simulation.get_real("plant::position"))
    assert_close(found, stepped(ssp, unpacked, name), within=AGREEMENT, what=name, why="hosts count time differently")


def test_libcosim_runs_the_components(ssp: Path, unpacked: Path) -> None:
    """With the set of parameters that is bound."""
    from libcosimpy.CosimExecution import CosimExecution
    from libcosimpy.CosimManipulator import CosimManipulator
    from libcosimpy.CosimObserver import CosimObserver

    execution = CosimExecution.from_ssp_file(ssp_path=str(unpacked), step_size=round(1e9 * drive.STEP))
    plant, controller = (execution.slave_index_from_instance_name(name) for name in ("plant", "controller"))
    manipulator, observer = CosimManipulator.create_override(), CosimObserver.create_last_value()
    execution.add_manipulator(manipulator)
    execution.add_observer(observer)
    fmus = unpacked / "resources"
    with Client(fmus / "PneumaticServoCylinder.fmu") as cylinder, Client(fmus / "PositionController.fmu") as positioner:
        position = [cylinder.variables["position"].valueReference]
        wanted = [positioner.variables["referencePosition"].valueReference]
    times, references = drive.reference(ssp)
    found = []
    for step in range(STEPS):
        manipulator.slave_real_values(controller, wanted, [float(np.interp(step * drive.STEP, times, references))])
        assert execution.step()
        found += observer.last_real_values(plant, position)
    assert_close(found, stepped(ssp, unpacked, "Dry"), within=AGREEMENT, what="Dry", why="hosts count time differently")
