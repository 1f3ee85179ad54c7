"""Every model as a host sees it: valid, runnable under every law, and the same from a restored state."""

import struct
import zipfile
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest
from client import Client
from experiment import laws_of, simulate
from fmpy import simulate_fmu
from fmpy.validation import validate_fmu

DESCRIPTIONS = Path(__file__).parents[2] / "modelDescription"
MODELS = sorted(file.stem for file in DESCRIPTIONS.glob("*.xml"))
"""Every model, by the committed descriptions."""

SYSTEMS = ["DrivenSlider", "Festoon", "VibroImpact"]
"""The systems of the friction literature."""

POSITION = {"DrivenSlider": "position", "Festoon": "trolley[1].position", "VibroImpact": "internal.position"}


@pytest.mark.parametrize("model", MODELS)
def test_fmpy_finds_nothing_wrong(fmus: Path, model: str) -> None:
    assert validate_fmu(str(fmus / f"{model}.fmu")) == []


def test_every_model_has_a_picture_of_its_own(fmus: Path) -> None:
    pictures = []
    for model in MODELS:
        with zipfile.ZipFile(fmus / f"{model}.fmu") as archive:
            pictures.append(archive.read("model.png"))
        # The header of a PNG: its signature, then width and height.
        assert pictures[-1].startswith(b"\x89PNG")
        assert struct.unpack(">II", pictures[-1][16:24]) == (256, 256), model
    assert len(set(pictures)) == len(MODELS)


@pytest.mark.parametrize("model", SYSTEMS)
def test_laws_of_every_kind_run_with_every_status_ok(fmus: Path, model: str) -> None:
    """The client raises an exception for every status other than OK.

    Every law of every model runs in a small C host for `cargo xtask test --platforms`, and for the gallery.
    """
    fmu = fmus / f"{model}.fmu"
    assert len(laws_of(fmu)) == 26
    # Set-valued, with one bristle, with elements in parallel, sampled, and with a delay.
    for law in ["Stribeck", "LuGre", "GMS", "DNLRX", "Armstrong"]:
        columns = simulate(fmu, law).columns
        for name, column in columns.items():
            assert np.all(np.isfinite(column)), f"{law}: {name}"
        assert np.ptp(columns[POSITION[model]]) > 1e-5, law


@pytest.mark.parametrize("model", SYSTEMS)
def test_restored_state_continues_bit_for_bit(fmus: Path, model: str) -> None:
    with Client(fmus / f"{model}.fmu") as client:
        inputs = dict.fromkeys(client.names("input"), 0.2)
        client.start({**inputs, "friction.law": "ElastoPlastic"})
        names = client.names("output") + client.names("local")
        client.advance(0.2)
        saved = client.slave.getFMUState()
        data = client.slave.serializeFMUstate(saved)
        client.advance(0.4)
        first = client.get(names)
        client.slave.setFMUState(saved)
        client.time = 0.2
        client.advance(0.4)
        assert client.get(names) == first
        client.slave.freeFMUState(saved)
        with Client(fmus / f"{model}.fmu") as other:
            other.start()
            state = other.slave.deSerializeFMUstate(data)
            other.slave.setFMUState(state)
            other.slave.freeFMUState(state)
            other.time = 0.2
            other.advance(0.4)
            assert other.get(names) == first


def test_simulate_fmu_runs_the_slider(fmus: Path) -> None:
    """A tray below the threshold of static friction carries the slider along."""
    result = simulate_fmu(
        str(fmus / "DrivenSlider.fmu"),
        stop_time=0.2,
        step_size=1e-3,
        output_interval=1e-3,
        start_values={"tray.velocityAmplitude": 0.031},
        output=["velocity", "tray.velocity", "sticking"],
    )
    assert np.array_equal(result["velocity"], result["tray.velocity"])
    assert np.all(result["sticking"] == 1)


@pytest.mark.parametrize("model", SYSTEMS)
def test_units_and_display_units_are_declared(model: str) -> None:
    root = ElementTree.parse(DESCRIPTIONS / f"{model}.xml").getroot()
    units = {unit.get("name"): {d.get("name") for d in unit.iter("DisplayUnit")} for unit in root.iter("Unit")}
    for variable in root.iter("ScalarVariable"):
        real = variable.find("Real")
        if real is not None:
            assert real.get("unit") in units, variable.get("name")
            assert real.get("displayUnit") in {None, *units[real.get("unit")]}, variable.get("name")
