"""A configured machine as an FMU of its own, through FMPy and the package itself."""

from __future__ import annotations

import json
import subprocess
import sys
import zipfile
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import fmpy
import numpy as np
import pneumatic_servo as ps
import pytest
from check import check
from fmpy import read_model_description, simulate_fmu
from fmpy.validation import validate_fmu

MACHINE = {
    "friction.law": "LuGre", "friction.lugre.Fc": 21.0, "friction.lugre.Fs": 34.5, "cylinder.bore": 0.04,
    "mass.moving": 3.1, "supplyPressure": 6.5e5, "position0": 0.1, "valve.hysteresis": 0.003,
}  # fmt: skip
STEP = 2.0**-10
"""Communication step in s whose multiples are exact, as hosts add them or multiply."""
TIME = STEP * np.arange(400)
VOLTAGE = np.full_like(TIME, 6.5)


@pytest.fixture(params=["", "fmi3"])
def source(fmus: Path, request: pytest.FixtureRequest) -> Path:
    """The FMU of the cylinder in each version."""
    return fmus / request.param / "PneumaticServoCylinder.fmu"


def exported(folder: Path, source: Path, **options: Any) -> Path:
    options.setdefault("settings", MACHINE)
    return ps.export_fmu(folder / "axis7.fmu", source=source, **options)[0]


def run(fmu: Path, fmi_type: str = "CoSimulation", **options: Any) -> Any:
    signals = np.rec.fromarrays([TIME, VOLTAGE], names="time,valveVoltage")
    return simulate_fmu(
        str(fmu), stop_time=TIME[-1], step_size=STEP, output_interval=STEP, input=signals, fmi_type=fmi_type, **options
    )


@pytest.mark.parametrize("preset", ["minimal", "rig", "all"])
def test_variant_has_no_findings_and_keeps_its_size(tmp_path: Path, source: Path, preset: str) -> None:
    fmu = exported(tmp_path, source, preset=preset, name="Axis 7")
    assert validate_fmu(str(fmu)) == []
    assert check(fmu) == 0
    assert fmu.stat().st_size <= 1.01 * source.stat().st_size
    assert read_model_description(str(fmu)).modelName == "Axis 7"


@pytest.mark.parametrize("preset", ["minimal", "rig", "all"])
def test_run_in_fmpy_is_that_of_the_package_to_the_bit(tmp_path: Path, source: Path, preset: str) -> None:
    fmu = exported(tmp_path, source, preset=preset)
    names = ["position", "velocity", "chamberA.pressure", "chamberB.pressure", "pressureForce", "frictionForce"]
    seen = run(fmu, output=names)
    own = ps.Model().simulate(
        MACHINE, inputs={"valveVoltage": (TIME, VOLTAGE)}, stop=TIME[-1], step=STEP, outputs=names
    )
    for name in names:
        assert np.array_equal(seen[name], own[name]), name
    assert np.ptp(seen["position"]) > 1e-3


def test_model_exchange_starts_with_the_described_states(tmp_path: Path, source: Path) -> None:
    fmu = exported(tmp_path, source, preset="minimal", settings=MACHINE | {"friction.law": "Stribeck"})
    seen = run(fmu, "ModelExchange", output=["position"], relative_tolerance=1e-6)
    inside = run(fmu, output=["position"])
    assert seen["position"][0] == 0.1
    assert seen["position"][-1] == pytest.approx(inside["position"][-1], abs=2e-5)


def test_description_states_what_an_instance_starts_with(tmp_path: Path, source: Path) -> None:
    fmu = exported(tmp_path, source, preset="all", default_experiment={"stop": "2 s", "step": 1e-3})
    description = read_model_description(str(fmu))
    assert (description.defaultExperiment.stopTime, description.defaultExperiment.stepSize) == ("2.0", "0.001")
    starts = {it.name: it.start for it in description.modelVariables}
    assert float(starts["friction.lugre.Fs"]) == 34.5
    assert starts["friction.law"] == "14"
    assert float(starts["position"]) == 0.1
    assert float(starts["supplyPressure"]) == 6.5e5


def test_only_the_chosen_variables_are_left(tmp_path: Path, source: Path) -> None:
    fmu = exported(
        tmp_path, source, inputs=["valveVoltage", "supplyPressure"], outputs=["position"], parameters=["mass.moving"]
    )
    variables = read_model_description(str(fmu)).modelVariables
    named = {causality: [it.name for it in variables if it.causality == causality] for causality in
             ("input", "output", "parameter")}  # fmt: skip
    assert named == {
        "input": ["valveVoltage", "supplyPressure"], "output": ["position"], "parameter": ["mass.moving"]
    }  # fmt: skip
    references = {it.name: it.valueReference for it in read_model_description(str(source)).modelVariables}
    assert all(references[it.name] == it.valueReference for it in variables)
    assert run(fmu, output=["position"], start_values={"mass.moving": 4.0})["position"][-1] != pytest.approx(
        run(fmu, output=["position"])["position"][-1], abs=1e-9
    )


def test_terminals_lead_to_variables_that_are_left(tmp_path: Path, fmus: Path) -> None:
    fmu = exported(tmp_path, fmus / "fmi3" / "PneumaticServoCylinder.fmu", inputs=["valveVoltage", "supplyPressure"])
    with zipfile.ZipFile(fmu) as archive:
        root = ElementTree.fromstring(archive.read("terminalsAndIcons/terminalsAndIcons.xml"))
    assert [it.get("name") for it in root.iter("Terminal")] == ["valve"]


def test_page_shows_the_machine(tmp_path: Path, source: Path) -> None:
    fmu = exported(tmp_path, source, preset="minimal", name="Axis7")
    with zipfile.ZipFile(fmu) as archive:
        page = archive.read("documentation/index.html").decode()
    assert "<h2>Axis7: the configured machine</h2>" in page
    assert "<td><code>friction.lugre.Fs</code></td><td>34.5</td><td>N</td>" in page
    assert '<a href="#configured">' in page


@pytest.mark.parametrize(
    ("options", "reason"),
    [
        ({"inputs": ["valveVolts"]}, "there is no variable valveVolts"),
        ({"inputs": ["position"]}, "position is no input"),
        ({"outputs": ["valveVoltage"]}, "valveVoltage is no output"),
        ({"parameters": ["mass.moving", "mass.moving"]}, "mass.moving is listed twice"),
        ({"inputs": ["externalForce"]}, "valveVoltage is left out of the inputs"),
        ({"settings": {"motion": "Imposed"}, "inputs": ["valveVoltage"]}, "imposedPosition is left out"),
        ({"settings": {"actuation": "TwoValves"}, "inputs": ["valveVoltageA"]}, "valveVoltageB is left out"),
        ({"settings": {"cylinder.bore": -0.03}}, "cylinder.bore = -0.03"),
        ({"settings": {"mass.moving": 1.0, "mass.carriage": 2.0}}, "mass.carriage = 2"),
        ({"settings": {"friction.law": "Sticky"}}, "Sticky"),
        ({"preset": "tiny"}, "there is no preset tiny; it must be one of minimal, rig, all"),
        ({"name": "a/b"}, "the name"),
        ({"default_experiment": {"stop": -1.0}}, "stops at"),
        ({"default_experiment": {"end": 1.0}}, "there is no 'end'"),
    ],
)
def test_wrong_request_is_refused_and_writes_nothing(
    tmp_path: Path, fmu: Path, options: dict[str, Any], reason: str
) -> None:
    with pytest.raises(ValueError, match=reason.replace("(", r"\(")):
        exported(tmp_path, fmu, **options)
    assert list(tmp_path.iterdir()) == []


def test_source_must_be_a_released_fmu(tmp_path: Path, fmu: Path, fmus: Path) -> None:
    variant = exported(tmp_path, fmu)
    with pytest.raises(ValueError, match="a variant already"):
        ps.export_fmu(tmp_path / "again.fmu", {}, source=variant)
    text = tmp_path / "text.fmu"
    text.write_text("no archive")
    with pytest.raises(ValueError, match="cannot be read"):
        ps.export_fmu(tmp_path / "again.fmu", {}, source=text)


def test_changed_values_are_refused_at_instantiation(tmp_path: Path, source: Path) -> None:
    fmu = exported(tmp_path, source)
    folder = Path(fmpy.extract(str(fmu), unzipdir=str(tmp_path / "unzipped")))
    file = folder / "resources" / "variant.txt"
    file.write_text(file.read_text().replace("34.5", "35.5"))
    messages: list[str] = []
    with pytest.raises(Exception, match="instantiate"):
        simulate_fmu(str(folder), stop_time=0.1, logger=lambda *said: messages.append(str(said[-1])))
    assert "variant.txt is refused" in messages[0]


def test_package_runs_a_variant_as_a_model(tmp_path: Path, fmu: Path) -> None:
    model = ps.Model(str(exported(tmp_path, fmu, preset="minimal")))
    seen = model.simulate(inputs={"valveVoltage": (TIME, VOLTAGE)}, stop=TIME[-1], step=STEP)
    own = ps.Model().simulate(
        MACHINE, inputs={"valveVoltage": (TIME, VOLTAGE)}, stop=TIME[-1], step=STEP, outputs=["position"]
    )
    assert np.array_equal(seen["position"], own["position"])


def test_files_for_other_tools(tmp_path: Path, fmu: Path) -> None:
    files = ps.export_fmu(tmp_path / "axis7.fmu", MACHINE, source=fmu, preset="minimal", beside=True)
    assert [file.name for file in files] == ["axis7.fmu", "axis7.json", "axis7.m", "axis7.mo"]

    assert json.loads(files[1].read_text())["values"]["friction.law"] == "LuGre"
    assert 'parameter Real cylinder_bore(unit="m") = 0.04' in files[3].read_text()


COMMAND = [sys.executable, "-c", "import sys; from pneumatic_servo.cli import main; sys.exit(main())"]


def command(folder: Path, *arguments: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run([*COMMAND, "fmu", *arguments], cwd=folder, capture_output=True, text=True, check=False)


def test_command_writes_what_python_writes(tmp_path: Path, fmu: Path) -> None:
    (tmp_path / "python").mkdir()
    settings = {"friction.law": "LuGre", "cylinder.bore": 0.04}
    own = ps.export_fmu(
        tmp_path / "python" / "axis7.fmu", settings, source=fmu, name="Axis7", inputs=["valveVoltage"],
        outputs=["position", "chamberA.pressure"], default_experiment={"stop": 2.0},
    )[0]  # fmt: skip
    done = command(
        tmp_path, "--set", "friction.law=LuGre,cylinder.bore=40 mm", "--name", "Axis7", "--inputs", "valveVoltage",
        "--outputs", "position,chamberA.pressure", "--stop", "2", "--source", str(fmu), "--out", "axis7.fmu",
    )  # fmt: skip
    assert (done.returncode, done.stdout) == (0, "axis7.fmu\n"), done.stderr
    assert (tmp_path / "axis7.fmu").read_bytes() == own.read_bytes()


@pytest.mark.parametrize(
    ("arguments", "reason"),
    [
        (["--name", "Axis7", "--out", "."], "give --out a file"),
        (["--set", "cylinder.bore=-1", "--out", "a.fmu"], "cylinder.bore"),
        (["--inputs", "valveVolts", "--out", "a.fmu"], "valveVolts"),
        (["--set", "cylinder.bore=0.04", "--out", "a.ssp"], "must begin with plant. or controller."),
    ],
)
def test_wrong_command_is_refused_and_writes_nothing(
    tmp_path: Path, fmu: Path, arguments: list[str], reason: str
) -> None:
    done = command(tmp_path, "--source", str(fmu), *arguments)
    assert done.returncode == 2
    assert reason in done.stderr
    assert list(tmp_path.iterdir()) == []


def test_fitted_machine_has_its_fit_on_its_page(tmp_path: Path, fmu: Path) -> None:
    found = ps.fit(
        Path(__file__).parents[2] / "examples" / "rig.csv", experiment="rig", law="Stribeck",
        settings={"supplyPressure": 6e5}, fit=["friction.stribeck.Fc", "valve.deadZone"], starts=1,
        columns="time=t,valveVoltage=u,position=x_mm[mm]",
    )  # fmt: skip
    file = found.to_fmu(tmp_path / "axis7.fmu", preset="minimal", source=fmu)[0]
    assert validate_fmu(str(file)) == []
    assert file.stat().st_size <= 1.01 * fmu.stat().st_size
    with zipfile.ZipFile(file) as archive:
        page = archive.read("documentation/index.html").decode()
    estimate = found.parameters["valve.deadZone"]
    assert f"<td>{estimate.value:.6g}</td><td>{estimate.low:.6g}</td><td>{estimate.high:.6g}</td>" in page
    assert f"<b>{found.verdict.light.capitalize()}.</b>" in page
    assert "rig.csv" in page
    assert page.count("data:image/png") >= 1
    starts = {it.name: it.start for it in read_model_description(str(file)).modelVariables}
    assert float(starts["position"]) == found.settings["position0"]


def test_drive_starts_with_the_values_of_its_components(tmp_path: Path, fmus: Path) -> None:
    source = fmus / "PneumaticServoDrive.ssp"
    drive = ps.export_drive(
        tmp_path / "drive.ssp", {"plant.friction.law": "GMS", "controller.gain.position": 31.0}, source=source
    )
    assert check(drive) == 0
    with zipfile.ZipFile(drive) as archive:
        assert not [name for name in archive.namelist() if name.endswith(".ssv")]
        archive.extractall(tmp_path)
    starts = {
        model: {
            it.name: it.start
            for it in read_model_description(str(tmp_path / "resources" / f"{model}.fmu")).modelVariables
        }
        for model in ("PneumaticServoCylinder", "PositionController")
    }
    assert starts["PneumaticServoCylinder"]["friction.law"] == "16"
    assert float(str(starts["PositionController"]["gain.position"])) == 31.0
    with pytest.raises(ValueError, match="is of no component"):
        ps.export_drive(tmp_path / "other.ssp", {"gain.position": 1.0}, source=source)
    assert not (tmp_path / "other.ssp").exists()


def test_few_ports_leave_no_input_to_be_missed(tmp_path: Path, fmu: Path, capsys: pytest.CaptureFixture[str]) -> None:
    run(fmu, output=["position"])
    assert "missing input" in capsys.readouterr().out
    run(exported(tmp_path, fmu, preset="minimal"), output=["position"])
    assert "missing input" not in capsys.readouterr().out


def test_sources_in_c_go_with_what_names_them(tmp_path: Path, source: Path) -> None:
    released = tmp_path / "with_sources.fmu"
    with zipfile.ZipFile(source) as old, zipfile.ZipFile(released, "w", zipfile.ZIP_DEFLATED) as new:
        for item in old.infolist():
            data = old.read(item)
            if item.filename == "modelDescription.xml":
                named = b' canRunAsynchronuously="false"><SourceFiles><File name="all.c"/></SourceFiles></CoSimulation>'
                data = data.replace(b' canRunAsynchronuously="false"/>', named)
            new.writestr(item, data)
        new.writestr("sources/all.c", "int never_compiled;")
        new.writestr("sources/buildDescription.xml", "<fmiBuildDescription/>")
    fmu = exported(tmp_path, released, preset="minimal")
    with zipfile.ZipFile(fmu) as archive:
        assert not [name for name in archive.namelist() if name.startswith("sources/")]
        assert b"SourceFiles" not in archive.read("modelDescription.xml")
    assert validate_fmu(str(fmu)) == []
