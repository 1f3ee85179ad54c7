"""What is said of signals that do not fit one another, before anything is fitted."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pneumatic_servo as ps
import pytest
from numpy.typing import NDArray
from pneumatic_servo.cli import main
from pneumatic_servo.identification.consistency import _share
from test_identification import bench
from test_identification_plausible import second_of_a_rig, signals

Array = NDArray[np.float64]

CHAMBERS = (
    "the pressures work against the motion: the position falls when chamberA.pressure is the higher one; are the "
    "chambers swapped, or does the position count from the other end? Then write position=-column, and by settings "
    "offset.position = -cylinder.stroke"
)
VOLTAGE = (
    "the position falls when valveVoltage is above 5 V: is the sign of one of them turned, or are the hoses crossed? "
    "settings={'gain.valveVoltage': -1, 'offset.valveVoltage': 10} turns the voltage"
)
PERCENT = (
    "record 1: valveVoltage is from 30 to 70 V, but the valve takes 0 to 10 V and saturates beyond; is it in "
    "percent? then settings={'gain.valveVoltage': 0.1} makes volts of it"
)
CENTRED = (
    "record 1: valveVoltage is from -2 to 2 V, but the valve takes 0 to 10 V and saturates beyond; does it "
    "count from the middle? then settings={'offset.valveVoltage': -5} moves it"
)


@pytest.fixture(scope="module")
def data() -> dict[str, Array]:
    return signals(second_of_a_rig())


def told(data: dict[str, Array], **given: object) -> list[str]:
    """What a fit warns of before it is made; what it leaves then is told, too, but is nothing of the data."""
    with warnings.catch_warnings(record=True) as said:
        warnings.simplefilter("always")
        ps.fit(data, starts=0, progress=False, **given)  # type: ignore[arg-type]
    return [text for one in said if "does not describe" not in (text := str(one.message))]


def swapped(data: dict[str, Array]) -> dict[str, Array]:
    return {**data, "chamberA.pressure": data["chamberB.pressure"], "chamberB.pressure": data["chamberA.pressure"]}


def with_voltage(factor: float, offset: float) -> Callable[[dict[str, Array]], dict[str, Array]]:
    return lambda data: {**data, "valveVoltage": factor * data["valveVoltage"] + offset}


@pytest.mark.parametrize(
    ("change", "expected"),
    [
        (lambda data: data, []),
        (swapped, [CHAMBERS]),
        (with_voltage(-1.0, 10.0), [VOLTAGE]),
        (with_voltage(10.0, 0.0), [PERCENT]),
        (with_voltage(1.0, -5.0), [CENTRED]),
    ],
)
def test_rig_that_is_connected_otherwise_is_told(
    data: dict[str, Array], change: Callable[[dict[str, Array]], dict[str, Array]], expected: list[str]
) -> None:
    given = {"experiment": "rig", "law": "Coulomb", "fit": "friction.coulomb.Fc", "settings": {"supplyPressure": 6e5}}
    assert told(change(data), **given) == expected


def test_command_says_it_by_its_options(
    data: dict[str, Array], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    data = with_voltage(1.0, -5.0)(data)
    np.savetxt(tmp_path / "a.csv", np.transpose(list(data.values())), delimiter=",", header=",".join(data), comments="")
    words = ["--law", "Coulomb", "--fit", "friction.coulomb.Fc", "--starts", "0", "--set", "supplyPressure=6e5"]
    main(["fit", str(tmp_path / "a.csv"), "--experiment", "rig", *words])
    assert "then --set offset.valveVoltage=-5 moves it" in capsys.readouterr().err
    assert main(["fit", str(tmp_path / "a.csv"), "--experiment", "rig", *words[:-1], "supplyPressure=6"]) != 0
    assert "--set supplyPressure=6.0: pressures are absolute and in Pa" in capsys.readouterr().err


def test_sign_is_asked_of_a_velocity_alone() -> None:
    data = bench()
    speed = np.gradient(data.pop("position"), data["time"])
    turned = {**data, "velocity": speed, "frictionForce": -data["frictionForce"]}
    given = {"experiment": "motion", "law": "Stribeck", "fit": "friction.stribeck.Fc", "play": 0.0}
    [text] = told(turned, **given)
    assert text.startswith("frictionForce works against friction: it gives back more than it takes on a way to and fro")
    assert text.endswith("A minus before a column turns it, frictionForce=-column")
    assert told({**data, "velocity": speed}, **given) == []


def test_work_says_something_of_signs_on_a_way_to_and_fro() -> None:
    """100 m one way and 60 m back, which is 40 of 160 m from the start: 0.3 of it may be missing, 100 of 160 m not."""
    force = np.array([1.0, 1.0])
    assert _share(force, np.array([100.0, -60.0]), 1.0) == 40.0 / 160.0
    assert _share(-force, np.array([100.0, -60.0]), 0.5) == -40.0 / 160.0
    assert _share(-force, np.array([100.0, -20.0]), 1.0) == 1.0
    assert _share(-force, np.zeros(2), 1.0) == 1.0
