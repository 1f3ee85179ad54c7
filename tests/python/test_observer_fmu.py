"""The observer as an FMU: the bits of `ps.Observer`, saved states, and refusals.

`cargo xtask test` packs it, and compares its default experiment with the model itself.
"""

from __future__ import annotations

import shutil
from collections.abc import Iterator
from pathlib import Path

import fmpy
import numpy as np
import pneumatic_servo as ps
import pytest
from client import Client
from fmpy import read_model_description
from fmpy.fmi3 import FMU3Slave
from fmpy.validation import validate_fmu

PERIOD = 1e-3
NOISE = 20e-6
SAMPLES = 300
LAW = "LuGre"
SETTINGS: dict[str, ps.Value] = {"friction.law": LAW, "supplyPressure": 6e5}
SHOWN = ["position", "velocity", "chamberA.pressure", "chamberB.pressure", "frictionForce"]
DEVIATIONS = [f"deviation.{name}" for name in SHOWN]


@pytest.fixture(scope="module")
def observers(fmus: Path) -> dict[str, Path]:
    """The FMUs by their version."""
    folder = fmus.parent / "own" / "fmu"
    files = {"2.0": folder / "FrictionObserver.fmu", "3.0": folder / "fmi3" / "FrictionObserver.fmu"}
    for file in files.values():
        assert file.is_file(), f"{file} is missing: `cargo xtask test` packs it by a program in fmu/observer"
    return files


@pytest.fixture(scope="module")
def record() -> dict[str, np.ndarray]:
    """Voltage and noisy position of a plant at each sample, and the true velocity."""
    noise = np.random.default_rng(2)
    times = np.arange(SAMPLES) * PERIOD
    voltages = 5.0 + 1.5 * np.sin(30.0 * times)
    plant = ps.Model().start({**SETTINGS, "valveVoltage": voltages[0]})
    rows = []
    for voltage in voltages:
        rows.append((voltage, plant["position"] + NOISE * noise.standard_normal(), plant["velocity"]))
        plant["valveVoltage"] = voltage
        plant.step(PERIOD)
    return dict(zip(["valveVoltage", "position", "velocity"], np.array(rows).T, strict=True))


@pytest.fixture(scope="module")
def expected(record: dict[str, np.ndarray]) -> np.ndarray:
    """What the observer of the package finds after each sample but the first, of which there is nothing to tell."""
    settings = {**SETTINGS, "valveVoltage": record["valveVoltage"][0]}
    observer = ps.Observer(settings, measured={"position": NOISE}, period=PERIOD)
    rows = []
    for voltage, position in zip(record["valveVoltage"][:-1], record["position"][1:], strict=True):
        found = observer.update({"valveVoltage": voltage}, {"position": position})
        rows.append([*(found[name] for name in SHOWN), *(observer.deviation[name] for name in SHOWN)])
    return np.array(rows)


def started(client: Client, record: dict[str, np.ndarray]) -> None:
    client.start({**SETTINGS, "valveVoltage": record["valveVoltage"][0]})


def samples(client: Client, record: dict[str, np.ndarray], first: int = 0) -> Iterator[list[float]]:
    """What the FMU tells after each sample."""
    for index in range(first, SAMPLES):
        client.set({"valveVoltage": record["valveVoltage"][index], "measured.position": record["position"][index]})
        client.advance((index + 1) * PERIOD)
        yield client.get([*SHOWN, *DEVIATIONS])


@pytest.mark.parametrize("version", ["2.0", "3.0"])
def test_nothing_is_wrong_with_the_fmu(observers: dict[str, Path], version: str) -> None:
    assert validate_fmu(str(observers[version])) == []
    description = read_model_description(str(observers[version]))
    assert (description.fmiVersion, description.modelName) == (version, "FrictionObserver")
    assert description.modelExchange is None
    assert description.coSimulation.canGetAndSetFMUstate and description.coSimulation.canSerializeFMUstate


def test_estimates_have_the_bits_of_the_observer_of_the_package(
    observers: dict[str, Path], record: dict[str, np.ndarray], expected: np.ndarray
) -> None:
    with Client(observers["2.0"]) as client:
        started(client, record)
        found = np.array(list(samples(client, record)))
        assert client.get(["samples"]) == [SAMPLES]
    assert np.array_equal(found[1:], expected)
    velocity = found[1:, SHOWN.index("velocity")] - record["velocity"][1:]
    # The position is known to 20 um, a thousand times a second.
    assert np.sqrt(np.mean(velocity[100:] ** 2)) < 2e-3 < 0.1 * np.ptp(record["velocity"])


def test_fmi_3_gives_the_same_bits(
    observers: dict[str, Path], record: dict[str, np.ndarray], expected: np.ndarray
) -> None:
    description = read_model_description(str(observers["3.0"]))
    variables = {variable.name: variable for variable in description.modelVariables}
    law = next(item.value for item in variables["friction.law"].declaredType.items if item.name == LAW)
    folder = fmpy.extract(str(observers["3.0"]))
    slave = FMU3Slave(
        guid=description.guid,
        unzipDirectory=folder,
        modelIdentifier=description.coSimulation.modelIdentifier,
        instanceName="observer",
    )
    references = {name: variable.valueReference for name, variable in variables.items()}
    driven = [references[name] for name in ("valveVoltage", "measured.position")]
    slave.instantiate()
    try:
        slave.setInt64([references["friction.law"]], [int(law)])
        slave.setFloat64([references["supplyPressure"]], [6e5])
        slave.setFloat64(driven[:1], [record["valveVoltage"][0]])
        slave.enterInitializationMode(startTime=0.0)
        slave.exitInitializationMode()
        for index in range(SAMPLES):
            slave.setFloat64(driven, [record["valveVoltage"][index], record["position"][index]])
            slave.doStep(index * PERIOD, (index + 1) * PERIOD - index * PERIOD)
            if index:
                found = slave.getFloat64([references[name] for name in [*SHOWN, *DEVIATIONS]])
                assert list(found) == expected[index - 1].tolist(), index
    finally:
        slave.terminate()
        slave.freeInstance()
        shutil.rmtree(folder, ignore_errors=True)


def test_a_saved_state_goes_on_in_another_instance(observers: dict[str, Path], record: dict[str, np.ndarray]) -> None:
    with Client(observers["2.0"]) as client:
        started(client, record)
        run = samples(client, record)
        for _ in range(120):
            next(run)
        state = client.slave.getFMUstate()
        saved = client.slave.serializeFMUstate(state)
        ended = list(run)
    with Client(observers["2.0"]) as other:
        started(other, record)
        other.slave.setFMUstate(other.slave.deSerializeFMUstate(saved))
        other.time = 120 * PERIOD
        assert list(samples(other, record, 120)) == ended


def test_a_sample_without_measurements_goes_on_without_them(
    observers: dict[str, Path], record: dict[str, np.ndarray]
) -> None:
    with Client(observers["2.0"]) as client:
        started(client, record)
        run = samples(client, record)
        for _ in range(50):
            next(run)
        [known] = client.get(["deviation.position"])
        client.set({"measured.valid": False})
        for _ in range(50):
            next(run)
        assert client.get(["innovation.position", "normalisedSquare"]) == [0.0, 0.0]
        [unknown] = client.get(["deviation.position"])
        client.set({"measured.valid": True})
        for _ in range(50):
            next(run)
        assert known < client.get(["deviation.position"])[0] < 0.5 * NOISE < NOISE < unknown


@pytest.mark.parametrize(
    ("values", "words"),
    [
        ({"noise.position": 0.0}, "noise.position"),
        ({"noise.position": -1e-5}, "noise.position"),
        ({"process.velocity": -1.0}, "process.velocity"),
        ({"observer.period": 0.0}, "observer.period"),
        ({"cylinder.rod": 0.02}, "cylinder.rod"),
    ],
)
def test_bad_settings_are_refused_by_name(observers: dict[str, Path], values: dict[str, float], words: str) -> None:
    with Client(observers["2.0"]) as client:
        with pytest.raises(fmpy.fmi1.FMICallException):
            client.start(values)
        assert any(words in message for message in client.messages), client.messages


def test_the_package_runs_it_as_a_model(observers: dict[str, Path], record: dict[str, np.ndarray]) -> None:
    """Beside a plant, with its parameters by name."""
    observer = ps.Model(observers["2.0"]).start({**SETTINGS, "valveVoltage": record["valveVoltage"][0]})
    for voltage, position in zip(record["valveVoltage"], record["position"], strict=True):
        observer.set({"valveVoltage": voltage, "measured.position": position})
        observer.step(PERIOD)
    assert abs(observer["velocity"] - record["velocity"][-1]) < 4.0 * observer["deviation.velocity"] + 1e-3
