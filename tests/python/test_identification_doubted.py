"""The whole text of what is said of data that cannot be what they are taken for, and where it begins to be said."""

from __future__ import annotations

import re
from typing import Any

import numpy as np
import pneumatic_servo as ps
import pytest
from bounds import assert_close
from numpy.typing import NDArray
from pneumatic_servo.identification.experiments import EXPERIMENTS, Experiment, Options
from pneumatic_servo.identification.plausibility import (
    assumed,
    check_known_pressures,
    checked,
    judged,
    outliers,
)
from pneumatic_servo.identification.signals import Units
from pneumatic_servo.identification.table import Measured

Array = NDArray[np.float64]

TIME = np.arange(201) * 1e-3
TURNING = Units(is_rotating=True)


def experiment(name: str = "rig", units: Units | None = None, **settings: Any) -> Experiment:
    known = {key.replace("__", "."): value for key, value in settings.items()}
    return EXPERIMENTS[name]("Stribeck", known, Options(), units or Units())


def swing(low: float, high: float) -> Array:
    """A signal that goes from the higher value to the lower and back."""
    return low + (high - low) * np.abs(np.linspace(-1.0, 1.0, len(TIME)))


def record(signals: dict[str, Array]) -> Measured:
    """Signals of a table whose position has a column x."""
    given = {"time": TIME, **signals}
    written = {"time": "t in s", "position": "x in m"}
    return Measured("a.csv", given, lambda signal, row: f"row {row} of {signal}", written)


def whole(text: str) -> str:
    """The expression of a text and nothing else."""
    return f"^{re.escape(text)}$"


def look(of: Experiment, signal: str, low: float, high: float) -> None:
    checked(of, [record({signal: swing(low, high)})], "linear")


ABSOLUTE = ", but pressures are absolute"
STROKE = ", but cylinder.stroke = 0.5 m, which is its default"
PUSHED = "; give the stroke, and count the position from the end of the instroke"


@pytest.mark.parametrize(
    ("of", "signal", "low", "high", "text"),
    [
        (experiment(), "position", 100, 300,
         f"(column x in m) is from 100 to 300 m{STROKE}; in mm it would be 0.1 to 0.3 m: write position=...[mm]"),
        (experiment(), "position", -11, 511,
         f"(column x in m) is from -11 to 511 m{STROKE}; in mm it would be -0.011 to 0.511 m: write position=...[mm]"),
        (experiment(), "position", 100, 520, f"(column x in m) is from 100 to 520 m{STROKE}{PUSHED}"),
        (experiment(), "position", -12, 500, f"(column x in m) is from -12 to 500 m{STROKE}{PUSHED}"),
        (experiment(), "position", 0.1, 0.52, f"(column x in m) is from 0.1 to 0.52 m{STROKE}{PUSHED}"),
        (experiment(), "position", -0.012, 0.5, f"(column x in m) is from -0.012 to 0.5 m{STROKE}{PUSHED}"),
        (experiment(cylinder__stroke=0.2), "position", 0.1, 0.3,
         f"(column x in m) is from 0.1 to 0.3 m, but cylinder.stroke = 0.2 m{PUSHED}"),
        (experiment(), "position", -0.51, 0.01,
         "(column x in m) is from -0.51 to 0.01 m, below the end of the instroke; is its sign turned? then write "
         "position=-column"),
        (experiment("pneumatic"), "position", -0.52, -0.1, f"(column x in m) is from -0.52 to -0.1 m{STROKE}{PUSHED}"),
        (experiment("motion"), "position", -5, 6,
         "(column x in m) is from -5 to 6 m; in mm it would be -0.005 to 0.006 m: write position=...[mm]"),
        (experiment(), "chamberA.pressure", 0.4, 6,
         f"is from 0.4 to 6 Pa{ABSOLUTE}; are these bar? then write chamberA.pressure=...[bar]; barg counts from the "
         "atmosphere"),
        (experiment(), "chamberB.pressure", 0, 6,
         f"is from 0 to 6 Pa{ABSOLUTE}; are these bar? then write chamberB.pressure=...[barg]; barg counts from the "
         "atmosphere"),
        (experiment(), "supplyPressure", 101, 600,
         f"is from 101 to 600 Pa{ABSOLUTE}; are these kPa? then write supplyPressure=...[kPa]; kPag counts from the "
         "atmosphere"),
        (experiment(), "supplyPressure", 2, 600,
         f"is from 2 to 600 Pa{ABSOLUTE}; are these kPa? then write supplyPressure=...[kPag]; kPag counts from the "
         "atmosphere"),
        (experiment(), "chamberA.pressure", 0, 5e5,
         f"is from 0 to 5e+05 Pa{ABSOLUTE}; do these count from the atmosphere? then write [barg] or [kPag] behind "
         "the column, or add 101325 Pa"),
        (experiment(), "chamberA.pressure", 1e5, 2e8,
         f"is from 1e+05 to 2e+08 Pa{ABSOLUTE} and below 1e+08 Pa; is the unit right?"),
    ],
)  # fmt: skip
def test_range_that_cannot_be_is_refused(of: Experiment, signal: str, low: float, high: float, text: str) -> None:
    with pytest.raises(ValueError, match=whole(f"a.csv: {signal} {text}")):
        look(of, signal, low, high)


@pytest.mark.parametrize(
    ("of", "signal", "low", "high"),
    [
        # A fiftieth of the stroke and 1 mm may be errors of sensors.
        (experiment(), "position", -0.0109, 0.5109),
        (experiment("motion"), "position", 0.0, 9.9),
        (experiment("force", TURNING), "position", 0.0, 1000.0),
        (experiment(), "chamberA.pressure", 3e4, 9e7),
        (experiment(gain__chamberA__pressure=1e5), "chamberA.pressure", 1.0, 6.0),
        (experiment(), "valveVoltage", 0.0, 10.0),
        (experiment(gain__valveVoltage=0.1), "valveVoltage", 0.0, 100.0),
        # The pressure of a test bench is one above ambient.
        (experiment("motion"), "pressure", 0.0, 10.0),
    ],
)
def test_range_that_may_be_is_not_doubted(of: Experiment, signal: str, low: float, high: float) -> None:
    look(of, signal, low, high)


TAKES = ", but the valve takes 0 to 10 V and saturates beyond"
SATURATES = "it saturates at 0 and 10 V, and does no more beyond"


@pytest.mark.parametrize(
    ("of", "low", "high", "text"),
    [
        (experiment(), 0, 7000,
         f"a.csv: valveVoltage is from 0 to 7000 V{TAKES}; are these mV? then write valveVoltage=...[mV]"),
        (experiment(), 0, 100, f"a.csv: valveVoltage is from 0 to 100 V{TAKES}; is it in percent? then "
         "settings={'gain.valveVoltage': 0.1} makes volts of it"),
        (experiment(), -5, 5, f"a.csv: valveVoltage is from -5 to 5 V{TAKES}; does it count from the middle? then "
         "settings={'offset.valveVoltage': -5} moves it"),
        (experiment(), -0.2, 5, f"valveVoltage = -0.2 V: {SATURATES}"),
        (experiment(), -5, 6, f"valveVoltage = -5 V: {SATURATES}"),
        (experiment(), 2, 12, f"valveVoltage = 12 V: {SATURATES}"),
        (experiment(gain__valveVoltage=0.1), 0, 120, f"valveVoltage = 12 V: {SATURATES}"),
        (experiment(offset__valveVoltage=-5), -6, 3, f"valveVoltage = -1 V: {SATURATES}"),
    ],
)  # fmt: skip
def test_voltage_beyond_the_valve_is_told(of: Experiment, low: float, high: float, text: str) -> None:
    with pytest.warns(ps.PlantWarning) as told:
        look(of, "valveVoltage", low, high)
    assert [str(one.message) for one in told] == [text]


def sampled(name: str, step: float) -> None:
    of = experiment(name)
    checked(of, [Measured("b", {"time": np.arange(50) * step}, lambda *_: "", {"time": "t in ms"})], "linear")


@pytest.mark.parametrize(("name", "step"), [("rig", 0.099), ("rig", 2e-6), ("motion", 0.49), ("force", 0.49)])
def test_samples_that_are_close_enough_are_not_doubted(name: str, step: float) -> None:
    sampled(name, step)


FAR = "s apart, too far to see the carriage start and stop; is it in ms? then write time=...[ms]"


@pytest.mark.parametrize(("name", "step", "said"), [("rig", 0.2, "0.2"), ("rig", 0.49, "0.49"), ("motion", 3.0, "3")])
def test_samples_that_are_far_apart_are_told(name: str, step: float, said: str) -> None:
    with pytest.warns(ps.PlantWarning) as told:
        sampled(name, step)
    assert [str(one.message) for one in told] == [f"b: time (t in ms): samples are {said} {FAR}"]


@pytest.mark.parametrize(
    ("step", "text"),
    [
        (0.6, f"0.6 {FAR}"),
        (9e-7, "9e-07 s apart, which no rig does; is the unit right? time=...[s] or [ms] says it"),
    ],
)
def test_samples_that_no_rig_has_are_refused(step: float, text: str) -> None:
    with pytest.raises(ValueError, match=whole(f"b: time (t in ms): samples are {text}")):
        sampled("rig", step)
    with pytest.raises(ValueError, match=r"^b: time \(in s\): samples are 1e-09 s apart"):
        checked(experiment("motion"), [Measured("b", {"time": np.arange(9) * 1e-9}, lambda *_: "")], "linear")


def test_samples_far_off_are_named_or_bridged() -> None:
    """Seven readings of a position that are none; a voltage may be a pulse."""
    ramp = 0.1 + 1e-3 * np.arange(201)
    wrong = [20, 40, 60, 80, 100, 120, 140]
    faulty, pulse = ramp.copy(), np.full(201, 5.0)
    faulty[wrong] = 0.45
    pulse[30] = 9.0
    pressure = 3e5 + 10.0 * (np.arange(201) % 2)
    pressure[8] = 9e6
    source = record({"position": faulty, "valveVoltage": pulse, "chamberA.pressure": pressure})
    first = ", ".join(f"row {row} of position = 0.45 m" for row in wrong[:5])
    told = f"a.csv: position is far off all samples around it at {first} and 2 more"
    advice = "; correct or remove what is no measurement, or let a robust loss bridge it, loss='soft_l1'"
    with pytest.raises(ValueError, match=whole(told + advice)):
        checked(experiment(), [source], "linear")
    [found], notes = checked(experiment(), [source], "huber")
    pressures = "a.csv: chamberA.pressure is far off all samples around it at row 8 of chamberA.pressure = 9e+06 Pa"
    assert notes == [f"{told}; it is bridged", f"{pressures}; it is bridged"]
    # By the median of five neighbours, of which the wrong one is the largest.
    assert_close(found.signals["position"], np.where(faulty == ramp, ramp, ramp + 1e-3), within=1e-15, what="bridged")
    assert set(found.signals["chamberA.pressure"]) == {3e5, 3e5 + 10.0} and found.signals["valveVoltage"] is pulse
    assert found.name == "a.csv" and source.signals["position"] is faulty


def test_outlier_is_off_by_more_than_noise_and_by_half_of_the_range() -> None:
    noisy = np.random.default_rng(1).standard_normal(500)
    ramp = np.arange(500) / 499.0
    for values, least, most in ((noisy, 18.0, 24.0), (ramp, 0.47, 0.51)):
        for row in (0, 1, 250, 498, 499):
            for size in (-most, -least, least, most):
                faulty = values.copy()
                faulty[row] = size + (0.0 if values is noisy else values[row])
                # What comes before the first and after the last is not known: a leap there may be a step.
                is_wrong = abs(size) == most and 0 < row < 499
                assert outliers(faulty)[0].tolist() == [row] * is_wrong, (row, size)


@pytest.mark.parametrize(("number", "expected"), [(19, []), (20, [9])])
def test_outliers_are_looked_for_among_twenty_samples(number: int, expected: list[int]) -> None:
    values = np.arange(number) / number
    values[9] = 50.0
    found, usual = outliers(values)
    assert found.tolist() == expected and len(usual) == number


def test_what_lasts_or_is_climbed_to_is_no_outlier() -> None:
    values = np.zeros(100)
    values[50:53] = 100.0
    assert outliers(values)[0].tolist() == []
    values = 0.01 * np.arange(100) % 0.02
    # A peak whose flank was seen: the leap is less than three times the step before.
    values[50:52] = [40.0, 100.0]
    assert outliers(values)[0].tolist() == [50, 51]
    values[49] = 15.0
    assert outliers(values)[0].tolist() == []
    assert outliers(np.full(40, 7.0))[0].tolist() == []


def test_what_nobody_gave_is_told() -> None:
    with pytest.warns(ps.PlantWarning) as told:
        notes = assumed(experiment(cylinder__bore=0.04), ["mass.moving"])
    assert [str(one.message) for one in told] == [
        "supplyPressure = 500000 Pa is assumed, since it was neither measured nor given; give it by settings, for "
        "example supplyPressure = 6 bar"
    ]
    assert notes == [
        "not given, so that the default counts: cylinder.rod = 0.006 m, cylinder.stroke = 0.5 m, "
        "valve.C = 3.93e-09 m3/(s.Pa)"
    ]


def test_what_is_known_is_not_told() -> None:
    machine = {"cylinder__bore": 0.04, "cylinder__rod": 0.01, "cylinder__stroke": 0.4}
    measured = experiment("pneumatic", **machine)
    measured.signals = frozenset(["supplyPressure"])
    assert assumed(measured, ["valve.C"]) == assumed(experiment("force", mass=2.0), []) == []
    assert assumed(experiment("motion"), []) == []
    assert assumed(experiment("force"), []) == ["not given, so that the default counts: mass = 1 kg"]
    assert assumed(experiment("mechanical", cylinder__bore=0.04), ["cylinder.rod"]) == [
        "not given, so that the default counts: mass.moving = 0.88 kg"
    ]


def test_signal_that_is_not_described_is_told(recwarn: pytest.WarningsRecorder) -> None:
    """Of a spread of 2; half of it is the limit."""
    signal = np.array([-2.0, 2.0] * 4)
    force = experiment("force", TURNING)
    for rms in ({"force": 0.99}, {"force": np.nan}, {"force": np.inf}, {}):
        judged(force, {"force": signal, "position": np.ones(3)}, {**rms, "position": 1.0})
    assert not recwarn.list
    judged(force, {"position": np.ones(3), "force": signal}, {"position": 1.0, "force": 1.23456})
    assert [str(one.message) for one in recwarn.list] == [
        "the fitted model does not describe force: it leaves 1.235 N.m rms of a signal that varies by 2 N.m rms; look "
        "at units, signs, what was assumed, and what is free"
    ]


def test_supply_that_nobody_has_is_refused() -> None:
    text = "settings={'supplyPressure': 6}: pressures are absolute and in Pa; did you mean 6 bar, which is 600000 Pa?"
    with pytest.raises(ValueError, match=whole(text)):
        check_known_pressures(experiment(supplyPressure=6))
    for fine in (experiment(supplyPressure=2.1e4), experiment(), experiment("motion", supplyPressure=6)):
        check_known_pressures(fine)
