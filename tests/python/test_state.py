"""Reset, saved states and serialized states repeat a run bit for bit."""

import json
import subprocess
import sys
from pathlib import Path

import pytest
from client import Client
from shared import LAWS, run

OUTPUTS = ["position", "velocity", "frictionForce", "chamberA.pressure", "chamberB.pressure", "valve.spool", "sticking"]
HALF, END, STEP = 0.6, 1.0, 1e-3


def trajectory(client: Client, first: float, stop: float) -> list[list[float]]:
    return [client.get(OUTPUTS) for _ in run(client, stop, STEP, first)]


@pytest.mark.parametrize("law", LAWS)
def test_reset_repeats_the_run(client: Client, law: str) -> None:
    runs = []
    for _ in range(2):
        client.start({"friction.law": law})
        runs.append(trajectory(client, 0.0, END))
        client.slave.reset()
    assert runs[0] == runs[1]


def test_reset_restores_defaults(client: Client) -> None:
    client.start({"friction.law": "LuGre", "cylinder.stroke": 0.4, "valveVoltage": 7.0})
    client.slave.reset()
    assert client.get(["friction.law", "cylinder.stroke", "valveVoltage"]) == [7.0, 0.5, 5.0]


@pytest.mark.parametrize("law", LAWS)
def test_restored_state_repeats_the_run(client: Client, law: str) -> None:
    client.start({"friction.law": law})
    trajectory(client, 0.0, HALF)
    state = client.slave.getFMUstate()
    expected = trajectory(client, HALF, END)
    client.slave.setFMUstate(state)
    client.time = HALF
    assert trajectory(client, HALF, END) == expected
    client.slave.freeFMUstate(state)


@pytest.mark.parametrize("law", LAWS)
def test_serialized_state_goes_on_in_another_process(client: Client, fmu: Path, tmp_path: Path, law: str) -> None:
    client.start({"friction.law": law})
    trajectory(client, 0.0, HALF)
    state = client.slave.getFMUstate()
    saved = tmp_path / "state.bin"
    saved.write_bytes(client.slave.serializeFMUstate(state))
    client.slave.freeFMUstate(state)
    expected = trajectory(client, HALF, END)
    script = Path(__file__).with_name("continue_run.py")
    arguments = [sys.executable, str(script), str(fmu), str(saved), str(HALF), str(END), str(STEP), *OUTPUTS]
    answer = subprocess.run(arguments, capture_output=True, text=True, check=True)
    assert json.loads(answer.stdout) == expected


def test_damaged_state_is_refused(client: Client) -> None:
    client.start()
    trajectory(client, 0.0, 0.1)
    state = client.slave.getFMUstate()
    good = client.slave.serializeFMUstate(state)
    client.slave.freeFMUstate(state)
    for damaged in (good[:-1], good[:10], bytes([good[0] ^ 1]) + good[1:], good[:-1] + bytes([good[-1] ^ 1])):
        with pytest.raises(Exception, match="fmi2DeSerializeFMUstate"):
            client.slave.deSerializeFMUstate(damaged)
    assert client.get(["position"])[0] > 0.0
