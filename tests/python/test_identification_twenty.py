"""Twenty mistakes in a record of a whole rig, one at a time: how many are named rightly before anything is fitted."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
import pneumatic_servo as ps
import pytest
from numpy.typing import NDArray
from pneumatic_servo.identification.smoothing import slope
from test_identification import RIG
from test_identification_interrupt import stopping

Array = NDArray[np.float64]
Data = dict[str, Array]


def record() -> Data:
    table = np.genfromtxt(RIG, delimiter=",", names=True)
    return {"time": table["t"], "valveVoltage": table["u"], "position": 1e-3 * table["x_mm"],
            "chamberA.pressure": 1e5 * table["pa_bar"], "chamberB.pressure": 1e5 * table["pb_bar"]}  # fmt: skip


def told(data: Mapping[str, Array], settings: Mapping[str, object]) -> str:
    """What is said of a record before a second vector is looked at."""
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        try:
            ps.fit(data, experiment="rig", law="Stribeck", settings=dict(settings), starts=0, progress=stopping(0))
        except ps.Interrupted:
            pass
        except ValueError as error:
            return str(error)
    return " ".join(str(one.message) for one in caught)


def scaled(name: str, factor: float, offset: float = 0.0) -> Callable[[Data], Data]:
    return lambda data: {**data, name: factor * data[name] + offset}


def swapped(data: Data) -> Data:
    a, b = "chamberA.pressure", "chamberB.pressure"
    return {**data, a: data[b], b: data[a]}


def with_velocity(factor: float) -> Callable[[Data], Data]:
    return lambda data: {**data, "velocity": factor * slope(data["position"], 1e-3, 0.02)}


def spoilt(name: str, value: float) -> Callable[[Data], Data]:
    def change(data: Data) -> Data:
        course = data[name].copy()
        course[700] = value
        return {**data, name: course}

    return change


MISTAKES: dict[str, tuple[Callable[[Data], Data], list[str]]] = {
    "position in mm": (scaled("position", 1e3), ["position is from", "write position=...[mm]"]),
    "position turned": (scaled("position", -1.0), ["position is from", "sign turned", "position=-column"]),
    "position from the other end": (
        scaled("position", -1.0, 0.5), ["does the position count from the other end?", "position=-column"]
    ),
    "position from its middle": (scaled("position", 1.0, -0.25), ["position is from", "end of the instroke"]),
    "pressure A in bar": (scaled("chamberA.pressure", 1e-5), ["chamberA.pressure is from", "are these bar?"]),
    "pressure B in kPa": (scaled("chamberB.pressure", 1e-3), ["chamberB.pressure is from", "are these kPa?"]),
    "pressure A from the atmosphere": (
        scaled("chamberA.pressure", 1.0, -101325.0), ["chamberA.pressure is from", "count from the atmosphere"]
    ),
    "pressure B from the atmosphere, in bar": (
        scaled("chamberB.pressure", 1e-5, -1.01325), ["chamberB.pressure is from", "barg"]
    ),
    "chambers swapped": (swapped, ["chambers swapped"]),
    "voltage in percent": (scaled("valveVoltage", 10.0), ["valveVoltage is from", "in percent?"]),
    "voltage in mV": (scaled("valveVoltage", 1e3), ["valveVoltage is from", "are these mV?"]),
    "voltage about 0": (scaled("valveVoltage", 1.0, -5.0), ["valveVoltage is from", "count from the middle?"]),
    "voltage turned": (scaled("valveVoltage", -1.0, 10.0), ["falls when valveVoltage is above 5 V", "turned"]),
    "time in ms": (scaled("time", 1e3), ["samples are 1 s apart", "[ms]"]),
    "time in Ms": (scaled("time", 1e-6), ["samples are 1e-09 s apart"]),
    "a word that was lost": (spoilt("chamberA.pressure", 9.99e6), ["far off all samples around it", "9.99e+06 Pa"]),
    "a sample that is missing": (spoilt("position", np.nan), ["position is nan", "sample 700"]),
    "a sensor that is dead": (scaled("chamberB.pressure", 0.0, 2e5), ["chamberB.pressure = 200000 Pa all the time"]),
    "velocity in mm/s": (with_velocity(1e3), ["times the slope of position", "velocity=column[mm/s]"]),
    "velocity turned": (with_velocity(-1.0), ["times the slope of position", "velocity=-column"]),
}  # fmt: skip


def test_right_record_is_not_doubted() -> None:
    assert told(record(), {"supplyPressure": 6e5}) == ""
    assert told(with_velocity(1.0)(record()), {"supplyPressure": 6e5}) == ""


@pytest.mark.parametrize("name", MISTAKES)
def test_mistake_is_named(name: str) -> None:
    change, words = MISTAKES[name]
    said = told(change(record()), {"supplyPressure": 6e5})
    assert all(word in said for word in words), said


def test_supply_in_bar_is_refused() -> None:
    said = told(record(), {"supplyPressure": 6})
    assert "supplyPressure" in said and "did you mean 6 bar, which is 600000 Pa?" in said


def test_what_the_words_advise_is_right() -> None:
    """A position from the other end, and a voltage about 0, given as the warnings say: the same values are found."""
    data = record()
    given = {"experiment": "rig", "law": "Stribeck", "starts": 0, "progress": False, "fit": "friction.stribeck.Fc"}
    known = {"supplyPressure": 6e5, "valve.deadZone": 0.065, "valve.C": 4.4e-9, "friction.stribeck.Fs": 12.4,
             "friction.stribeck.vs": 0.018, "friction.stribeck.sigma2": 38.0}  # fmt: skip
    expected = ps.fit(data, settings=known, **given).values["friction.stribeck.Fc"]
    other = {**data, "position": 0.5 - data["position"], "valveVoltage": data["valveVoltage"] - 5.0}
    sensors = {"gain.position": -1.0, "offset.position": 0.5, "offset.valveVoltage": -5.0}
    found = ps.fit(other, settings={**known, **sensors}, **given).values["friction.stribeck.Fc"]
    assert found == pytest.approx(expected, rel=1e-4)


def test_sign_of_a_force_is_doubted() -> None:
    time = np.arange(0, 4, 0.005)
    speed = 0.1 * np.cos(3 * time)
    data: dict[str, Any] = {
        "time": time,
        "position": np.sin(3 * time) / 30,
        "force": -(9 * np.sign(speed) + 50 * speed),
    }
    with (
        pytest.warns(ps.PlantWarning, match="force works against friction.*force=-column"),
        pytest.raises(ps.Interrupted),
    ):
        ps.fit(data, experiment="force", law="Coulomb", starts=0, progress=stopping(0))
