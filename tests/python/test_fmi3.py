"""FMI 3.0: co-simulation with and without event mode, and model exchange, against FMI 2.0 of the same build."""

from __future__ import annotations

import zipfile
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest
from bounds import assert_close, largest
from fmpy import read_model_description, simulate_fmu
from fmpy.model_description import ModelDescription
from numpy.typing import NDArray

OUTPUTS = ["position", "velocity", "chamberA.pressure", "chamberB.pressure", "frictionForce", "sticking"]
LAWS = {"Coulomb": 2, "Stribeck": 7, "Dahl": 10, "LuGre": 14, "GMS": 16, "ElastoPlastic": 20}
STOP = 0.6


@pytest.fixture(scope="module")
def fmu3(fmus: Path) -> Path:
    """The FMU of FMI 3.0."""
    file = fmus / "fmi3" / "PneumaticServoCylinder.fmu"
    assert file.is_file(), f"{file} is missing: run `cargo xtask package` first"
    return file


@pytest.fixture(scope="module")
def description3(fmu3: Path) -> ModelDescription:
    """Its model description as FMPy reads it."""
    return read_model_description(str(fmu3))


def run(fmu: Path, law: int, **settings: object) -> NDArray:
    """The carriage starts at rest, under a constant voltage, at tight tolerances."""
    return simulate_fmu(
        str(fmu),
        stop_time=STOP,
        output_interval=1e-3,
        start_values={"friction.law": law, "valveVoltage": 6.0, "solver.relativeTolerance": 1e-9},
        output=OUTPUTS,
        **settings,
    )


def last_at_each_instant(result: NDArray) -> NDArray:
    """FMPy records both sides of events; of values at one instant the last counts."""
    _, last = np.unique(result["time"][::-1], return_index=True)
    return result[::-1][last]


@pytest.mark.parametrize(("law", "number"), LAWS.items())
def test_co_simulation_gives_the_bits_of_fmi_2(fmu: Path, fmu3: Path, law: str, number: int) -> None:
    two, three = (run(file, number, fmi_type="CoSimulation") for file in (fmu, fmu3))
    assert two.tobytes() == three.tobytes(), law


@pytest.mark.parametrize(("law", "number"), LAWS.items())
def test_event_mode_returns_at_break_away_and_changes_nothing_else(fmu3: Path, law: str, number: int) -> None:
    plain = run(fmu3, number, fmi_type="CoSimulation")
    events = run(fmu3, number, fmi_type="CoSimulation", use_event_mode=True, early_return_allowed=True)
    merged = last_at_each_instant(events)
    between = merged[np.isin(merged["time"], plain["time"])]
    for name, bound in [("position", 5e-15), ("chamberA.pressure", 4e-9), ("chamberB.pressure", 4e-9)]:
        assert_close(between[name], plain[name], within=bound, what=name.rpartition(".")[2])
    # The instant of break-away is recorded twice: still sticking, and sliding.
    away = np.flatnonzero(np.diff(events["sticking"].astype(int)) == -1)
    for index in away:
        assert events["time"][index] == events["time"][index + 1], law
        assert events["time"][index] not in plain["time"], law
    assert len(away) > 0 or not plain["sticking"].any(), law


@pytest.mark.parametrize(("law", "number"), LAWS.items())
def test_cvode_outside_agrees_with_the_solver_inside(fmu3: Path, law: str, number: int) -> None:
    inside = run(fmu3, number, fmi_type="CoSimulation")
    outside = run(fmu3, number, fmi_type="ModelExchange", solver="CVode", relative_tolerance=1e-9)
    merged = last_at_each_instant(outside)
    for name, bound in [("position", 1e-7), ("chamberA.pressure", 0.2), ("chamberB.pressure", 0.2)]:
        found = np.interp(inside["time"], merged["time"], merged[name])
        assert_close(found, inside[name], within=bound, what=name.rpartition(".")[2])


def test_both_descriptions_tell_of_the_same_variables(
    description: ModelDescription, description3: ModelDescription
) -> None:
    elements = {}
    for variable in description3.modelVariables:
        count = int(variable.dimensions[0].start) if variable.dimensions else 1
        for index in range(count):
            elements[variable.valueReference + index] = (variable, index if count > 1 else None)
    for variable in description.modelVariables:
        other, index = elements.pop(variable.valueReference)
        array, _, end = variable.name.rpartition(f"[{(index or 0) + 1}]")
        assert other.name == (variable.name if index is None else array + end)
        assert (other.causality, other.variability, other.unit) == (
            variable.causality,
            variable.variability,
            variable.unit,
        )
        starts = other.start.split() if other.start else [other.start]
        assert variable.start == starts[index or 0], variable.name
    indicators = {unknown.variable for unknown in description3.eventIndicators}
    # FMI 2.0 needs no variable for the time.
    assert {variable for variable, _ in elements.values() if variable.causality != "independent"} == indicators
    assert len(indicators) == description.numberOfEventIndicators


def test_arrays_are_set_as_a_whole(fmu3: Path) -> None:
    stiffness = np.array([4e5, 3e5, 2e5, 1e5, 1e5, 1e5, 1e5, 1e5, 1e5, 1e5])
    forces = [
        simulate_fmu(
            str(fmu3),
            stop_time=0.1,
            output_interval=1e-3,
            start_values={"friction.law": 16, "valveVoltage": 6.0, "friction.gms.k": factor * stiffness},
            output=["frictionForce"],
        )["frictionForce"]
        for factor in (1.0, 0.5)
    ]
    assert largest(forces[0] - forces[1]) > 1e-3


def test_terminals_name_variables_and_icons_are_there(fmu3: Path, description3: ModelDescription) -> None:
    with zipfile.ZipFile(fmu3) as archive:
        tree = ElementTree.fromstring(archive.read("terminalsAndIcons/terminalsAndIcons.xml"))
        assert archive.read("terminalsAndIcons/icon.png").startswith(b"\x89PNG")
        assert b"<svg" in archive.read("terminalsAndIcons/icon.svg")
        folders = {name.split("/")[1] for name in archive.namelist() if name.startswith("binaries/")}
    terminals = {
        terminal.get("name"): {member.get("memberName"): member.get("variableName") for member in terminal}
        for terminal in tree.iter("Terminal")
    }
    assert terminals["valve"] == {"voltage": "valveVoltage", "supply": "supplyPressure"}
    assert terminals["carriage"] == {"position": "position", "velocity": "velocity", "force": "externalForce"}
    assert all(len(folder.split("-")) == 2 for folder in folders), folders
    assert {name for members in terminals.values() for name in members.values()} <= {
        variable.name for variable in description3.modelVariables
    }


def test_types_have_no_description(fmus: Path) -> None:
    """FMPy 0.3.19 and 0.3.20, which other tools depend on, raise a TypeError for a type that has one."""
    for fmu in sorted((fmus / "fmi3").glob("*.fmu")):
        with zipfile.ZipFile(fmu) as archive:
            types = ElementTree.fromstring(archive.read("modelDescription.xml")).iterfind("TypeDefinitions/*")
        assert [one.get("name") for one in types if one.get("description") is not None] == [], fmu.name
