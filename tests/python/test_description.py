"""The description of the FMU as a host reads it before a run."""

import zipfile
from pathlib import Path
from xml.etree import ElementTree

import pytest
from fmpy import read_model_description
from fmpy.model_description import ModelDescription, ScalarVariable
from fmpy.validation import validate_fmu


def variable(description: ModelDescription, name: str) -> ScalarVariable:
    return next(v for v in description.modelVariables if v.name == name)


def test_fmpy_finds_nothing_wrong(fmu: Path) -> None:
    assert validate_fmu(str(fmu)) == []


def test_archive_has_what_hosts_look_for(fmu: Path) -> None:
    with zipfile.ZipFile(fmu) as archive:
        assert archive.testzip() is None
        names = archive.namelist()
    assert names == sorted(names)
    assert {"modelDescription.xml", "documentation/index.html", "model.png"} <= set(names)
    licences = {
        f"documentation/licenses/{name}.txt" for name in ("license", "LICENSE-APACHE", "LICENSE-MIT", "third-party")
    }
    assert licences <= set(names)
    assert [name for name in names if name.startswith("binaries/")]
    assert all(Path(n).stem == "PneumaticServoCylinder" for n in names if n.startswith("binaries/"))


def test_capabilities(description: ModelDescription) -> None:
    capabilities = description.coSimulation
    assert capabilities.modelIdentifier == description.modelName == "PneumaticServoCylinder"
    assert capabilities.canHandleVariableCommunicationStepSize
    assert capabilities.canInterpolateInputs
    assert capabilities.maxOutputDerivativeOrder == 1
    assert capabilities.canGetAndSetFMUstate
    assert capabilities.canSerializeFMUstate
    assert capabilities.providesDirectionalDerivative
    assert not capabilities.canBeInstantiatedOnlyOncePerProcess
    assert not capabilities.needsExecutionTool


def test_model_exchange(description: ModelDescription, fmu: Path) -> None:
    exchange = description.modelExchange
    assert exchange.modelIdentifier == "PneumaticServoCylinder"
    assert not exchange.completedIntegratorStepNotNeeded
    assert exchange.canGetAndSetFMUstate
    assert exchange.canSerializeFMUstate
    assert exchange.providesDirectionalDerivative
    assert description.numberOfEventIndicators == 12
    states = {v.derivative.name for v in description.modelVariables if v.derivative}
    assert len(states) == 48
    # FMPy reads no such attribute.
    with zipfile.ZipFile(fmu) as archive:
        variables = ElementTree.fromstring(archive.read("modelDescription.xml")).iterfind(
            "ModelVariables/ScalarVariable"
        )
    assert {v.get("name") for v in variables if v.find("Real[@reinit='true']") is not None} == states
    controller = read_model_description(str(fmu.with_name("PositionController.fmu")))
    assert controller.modelExchange is None


def test_default_experiment(description: ModelDescription) -> None:
    experiment = description.defaultExperiment
    assert float(experiment.startTime) == 0.0
    assert float(experiment.stopTime) == 3.0
    assert float(experiment.tolerance) == 1e-6
    assert float(experiment.stepSize) == 1e-3


@pytest.mark.parametrize(
    ("name", "unit", "display", "start"),
    [
        ("valveVoltage", "V", None, 5.0),
        ("externalForce", "N", None, 0.0),
        ("supplyPressure", "Pa", "bar", 5e5),
        ("cylinder.bore", "m", "mm", 0.016),
        ("cylinder.stroke", "m", "mm", 0.5),
        ("valve.C", "m3/(s.Pa)", "dm3/(s.bar)", 3.93e-9),
        ("valve.bandwidth", "Hz", None, 115.0),
        ("chamberA.pressure0", "Pa", "bar", 101325.0),
        ("friction.stribeck.Fs", "N", None, 11.0),
        ("friction.dahl.sigma0", "N/m", None, 8e6),
    ],
)
def test_units_and_defaults(
    description: ModelDescription, name: str, unit: str, display: str | None, start: float
) -> None:
    found = variable(description, name)
    assert (found.unit, found.displayUnit, float(found.start)) == (unit, display, start)
    assert found.description


def test_outputs(description: ModelDescription) -> None:
    outputs = [v.name for v in description.modelVariables if v.causality == "output"]
    expected = [
        *("position", "velocity", "acceleration", "rodForce", "pressureForce", "frictionForce"),
        *(f"chamber{c}.{q}" for q in ("pressure", "temperature", "massFlow") for c in "AB"),
        *("valve.spool", "sticking", "frictionForceLimit.low", "frictionForceLimit.high"),
        *("supply.massFlow", "supply.consumed", "supply.consumedVolume"),
        *("sensor.end[1]", "sensor.end[2]"),
        *(f"sensor.{quantity}.reading" for quantity in ("position", "pressureA", "pressureB", "force")),
    ]
    assert sorted(outputs) == sorted(expected)


def test_friction_laws_keep_their_numbers(description: ModelDescription) -> None:
    items = {item.name: int(item.value) for item in variable(description, "friction.law").declaredType.items}
    expected = [
        *("None", "Coulomb", "CoulombStiction", "SmoothCoulomb", "VelocityBased", "StribeckRegularised"),
        *("Stribeck", "Karnopp", "Polito", "Dahl", "Bristle", "ResetIntegrator", "Armstrong", "LuGre"),
        *("Leuven", "GMS", "MaxwellSlip", "DNLRX", "BlimanSorine", "ElastoPlastic", "StepRegularised"),
        *("SineRegularised", "StickSlipSpring", "StickSlipCreep", "Table", "RevisedLuGre"),
    ]
    assert {name: items.get(name) for name in expected} == {
        name: number for number, name in enumerate(expected, start=1)
    }


def test_value_references_are_unique(description: ModelDescription) -> None:
    references = [v.valueReference for v in description.modelVariables]
    assert len(set(references)) == len(references)


def test_every_variable_is_described(description: ModelDescription) -> None:
    assert [v.name for v in description.modelVariables if not v.description] == []


def test_start_values_are_in_range(description: ModelDescription) -> None:
    for v in description.modelVariables:
        if v.start is None or v.type not in ("Real", "Integer"):
            continue
        assert v.min is None or float(v.min) <= float(v.start), v.name
        assert v.max is None or float(v.start) <= float(v.max), v.name


def test_bar_and_normal_litres_have_the_right_size(description: ModelDescription) -> None:
    factors = {(u.name, d.name): float(d.factor) for u in description.unitDefinitions for d in u.displayUnits}
    assert factors["Pa", "bar"] == 1e-5
    # ISO 8778: the reference atmosphere has 1.185 kg/m3.
    assert factors["kg/s", "l/min(ANR)"] == pytest.approx(1000.0 * 60.0 / 1.185, rel=1e-15)


def test_no_output_depends_directly_on_the_voltage(description: ModelDescription) -> None:
    voltage = variable(description, "valveVoltage")
    for unknown in description.outputs:
        assert unknown.dependencies is not None
        assert voltage not in unknown.dependencies, unknown.variable.name
