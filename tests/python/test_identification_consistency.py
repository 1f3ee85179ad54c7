"""Messages about signals that do not fit one another, before anything is fitted."""

from __future__ import annotations

import re
import warnings
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pneumatic_servo as ps
import pytest
from numpy.typing import NDArray
from pneumatic_servo.cli import main
from pneumatic_servo.identification.experiments import Experiment, Options
from pneumatic_servo.identification.fitting import make_experiment
from pneumatic_servo.identification.plausibility import compare
from pneumatic_servo.identification.records import Record
from pneumatic_servo.identification.signals import Units
from test_identification import bench
from test_identification_plausible import second_of_a_rig, signals

Array = NDArray[np.float64]

CHAMBERS = (
    "the pressures work against the motion: the position falls when chamberA.pressure is the higher one; are the "
    "chambers swapped, or does the position count from the other end? then exchange the columns of "
    "chamberA.pressure and chamberB.pressure, or give settings={'gain.position': -1, 'offset.position': 0.5}"
)
VOLTAGE = (
    "the position falls when valveVoltage is above 5 V: is the sign of one of them turned, or are the hoses crossed? "
    "then give settings={'gain.valveVoltage': -1, 'offset.valveVoltage': 10}"
)
PERCENT = (
    "record 1: valveVoltage is from 30 to 70 V, but the valve takes 0 to 10 V and saturates beyond; is it in "
    "percent? then give settings={'gain.valveVoltage': 0.1}"
)
CENTRED = (
    "record 1: valveVoltage is from -2 to 2 V, but the valve takes 0 to 10 V and saturates beyond; does it "
    "count from the middle? then give settings={'offset.valveVoltage': -5}"
)


@pytest.fixture(scope="module")
def data() -> dict[str, Array]:
    return signals(second_of_a_rig())


def told(data: dict[str, Array], **given: object) -> list[str]:
    """Warnings before a fit is made; warnings about its residuals do not concern the data."""
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
    assert "then give --set offset.valveVoltage=-5" in capsys.readouterr().err
    assert main(["fit", str(tmp_path / "a.csv"), "--experiment", "rig", *words[:-1], "supplyPressure=6"]) != 0
    assert "--set supplyPressure: supplyPressure = 6 Pa, but pressures are absolute" in capsys.readouterr().err


def test_sign_is_asked_of_a_velocity_alone() -> None:
    data = bench()
    speed = np.gradient(data.pop("position"), data["time"])
    turned = {**data, "velocity": speed, "frictionForce": -data["frictionForce"]}
    given = {"experiment": "motion", "law": "Stribeck", "fit": "friction.stribeck.Fc", "play": 0.0}
    [text] = told(turned, **given)
    assert text.startswith("frictionForce works against friction: it gives back more energy than it takes over a cycle")
    assert text.endswith("then write frictionForce=-column")
    assert told({**data, "velocity": speed}, **given) == []


def seen(position: Array, *, is_rotating: bool = False, **signals: Array) -> tuple[Experiment, list[Record]]:
    """A force that moves a machine, in two parts of a record."""
    given = {"position": position, **signals}
    experiment = make_experiment("force", "Coulomb", None, Options(), Units(is_rotating))
    experiment.use(["time", "force", *given])
    time = 0.01 * np.arange(len(position))
    parts = [slice(0, 200), slice(200, None)]
    return experiment, [
        Record("a.csv", time[part] - time[part][0], 0.0, {k: x[part] for k, x in given.items()}) for part in parts
    ]


WAY = np.sin(0.05 * np.arange(600))
SPEED = 5.0 * np.cos(0.05 * np.arange(600))


@pytest.mark.parametrize(
    ("factor", "is_rotating", "text"),
    [
        (1000.0, False, "velocity is 1000 times the slope of position, in m/s and m; is it in mm/s? then write "
                        "velocity=...[mm/s]"),
        (-1.0, False, "velocity is -1 times the slope of position, in m/s and m; is its sign turned? then write "
                      "velocity=-column"),
        (1.6, False, "velocity is 1.6 times the slope of position, in m/s and m"),
        (0.6, False, "velocity is 0.6 times the slope of position, in m/s and m"),
        (57.3, True, "velocity is 57.3 times the slope of position, in rad/s and rad; is it in deg/s? then write "
                     "velocity=...[deg/s]"),
        (9.55, True, "velocity is 9.55 times the slope of position, in rad/s and rad; is it in rpm? then write "
                     "velocity=...[rpm]"),
        # A machine that slides has no rpm, and one that rotates no mm/s.
        (9.55, False, "velocity is 9.55 times the slope of position, in m/s and m"),
        (1000.0, True, "velocity is 1000 times the slope of position, in rad/s and rad"),
    ],
)  # fmt: skip
def test_velocity_that_is_not_the_slope_of_its_position_is_refused(factor: float, is_rotating: bool, text: str) -> None:
    with pytest.raises(ValueError, match=r"^velocity is ") as caught:
        compare(*seen(WAY, is_rotating=is_rotating, velocity=factor * SPEED))
    # Parabolas over 0.04 s flatten the slope of this sine by a part in 10,000.
    found = str(caught.value)
    number = found.split()[2]
    assert float(number) == pytest.approx(factor, rel=2e-3)
    assert found.replace(number, f"{factor:g}") == text


@pytest.mark.parametrize("velocity", [1.45 * SPEED, 0.7 * SPEED, np.roll(1000.0 * SPEED, 31), 0.0 * SPEED])
def test_velocity_that_is_about_the_slope_or_of_something_else_is_left(velocity: Array) -> None:
    """A quarter of a period late it is of something else."""
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        compare(*seen(WAY, velocity=velocity, force=SPEED))


def test_force_that_works_against_friction_is_asked_for_its_sign() -> None:
    text = (
        "force works against friction: it gives back more energy than it takes over a cycle; is its sign or "
        "the sign of the motion turned? then write force=-column"
    )
    with pytest.warns(ps.PlantWarning, match="^" + re.escape(text) + "$"):
        compare(*seen(WAY, force=-SPEED))
    experiment, records = seen(WAY, force=-SPEED)
    resting = [replace(record, signals={"force": record.signals["force"]}) for record in records]
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        # A force that a mass takes and gives back is none, nor is anything told of no motion.
        compare(*seen(WAY, force=WAY - 0.01 * SPEED))
        compare(experiment, resting)
