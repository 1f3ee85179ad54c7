"""Refusals: messages say why something cannot be accepted."""

import math
from pathlib import Path

import pytest
from client import Client, Value
from fmpy.fmi1 import FMICallException


@pytest.mark.parametrize(
    ("values", "parts"),
    [
        ({"cylinder.bore": -0.016}, ["cylinder.bore", "-0.016"]),
        ({"valve.b": 1.5}, ["valve.b", "1.5"]),
        ({"friction.law": 99}, ["friction.law", "99", "FrictionLaw"]),
        ({"friction.lawNumber": 99}, ["friction.lawNumber", "99"]),
        ({"friction.stribeck.Fs": 5.0, "friction.stribeck.Fc": 8.0}, ["friction.stribeck", "8"]),
        ({"cylinder.rod": 0.02}, ["cylinder.rod", "0.02", "cylinder.bore"]),
        ({"position0": 0.7}, ["position0", "0.7", "cylinder.stroke"]),
        ({"mass.moving": 0.5}, ["mass.carriage = 0.75", "mass.moving = 0.5", "its default: give mass.carriage"]),
        ({"friction.law": 9, "friction.polito.Fs": 5.0}, ["friction.polito.Fc1", "Fs = 5", "its default"]),
        ({"cylinder.stroke": 0.2}, ["position0 = 0.25", "cylinder.stroke = 0.2", "give position0"]),
        ({"supplyPressure": -1.0}, ["supplyPressure", "-1"]),
        ({"valveVoltage": math.nan}, ["valveVoltage", "NaN"]),
        ({"externalForce": math.inf}, ["externalForce", "inf"]),
    ],
)
def test_values_are_refused_by_name_and_value(client: Client, values: dict[str, Value], parts: list[str]) -> None:
    with pytest.raises(FMICallException):
        client.start(values)
    message = "\n".join(client.messages)
    assert all(part in message for part in parts), message


def test_fixed_parameter_cannot_change_while_running(client: Client) -> None:
    client.start()
    client.advance(1e-3)
    with pytest.raises(FMICallException):
        client.set({"cylinder.bore": 0.02})
    assert "cylinder.bore" in "\n".join(client.messages)
    assert client.get(["cylinder.bore"]) == [0.016]


def test_tunable_parameter_can_change_while_running(client: Client) -> None:
    client.start()
    client.advance(1e-3)
    client.set({"friction.stribeck.Fc": 7.0, "wireForce": 1.0})
    client.advance(2e-3)
    assert client.get(["friction.stribeck.Fc", "wireForce"]) == [7.0, 1.0]


def test_output_cannot_be_set(client: Client) -> None:
    client.start()
    with pytest.raises(FMICallException):
        client.set({"position": 0.1})
    assert "position" in "\n".join(client.messages)


def test_wrong_guid_gives_no_instance(fmu: Path) -> None:
    with pytest.raises(RuntimeError, match=r"\{wrong\}"):
        Client(fmu, guid="{wrong}")


def test_step_of_no_length_is_refused(client: Client) -> None:
    client.start()
    for step in (0.0, -1e-3, math.nan):
        with pytest.raises(FMICallException):
            client.slave.doStep(0.0, step)
    assert client.messages


def test_step_from_another_time_is_refused(client: Client) -> None:
    client.start()
    client.advance(1e-3)
    with pytest.raises(FMICallException):
        client.slave.doStep(0.5, 1e-3)
    message = "\n".join(client.messages)
    assert "0.5" in message and "0.001" in message
