"""Kind of machine from written units, and start values of free parameters that belong to no law."""

from __future__ import annotations

import math
import re
from dataclasses import replace
from typing import Any

import pytest
from pneumatic_servo.identification.experiments import EXPERIMENTS, Experiment, Options
from pneumatic_servo.identification.fitting import units_beside
from pneumatic_servo.identification.parameters import Free, parse
from pneumatic_servo.identification.signals import SIGNALS, Units, told_units

COLUMN = "columns='x'"


@pytest.mark.parametrize(
    ("stated", "given", "expected"),
    [
        ({}, {}, Units()),
        ({"position": "m", "force": "N"}, {}, Units()),
        ({"position": "rad"}, {}, Units(is_rotating=True)),
        ({"velocity": "rad/s", "force": "N.m"}, {}, Units(is_rotating=True)),
        # A torque alone is one of a machine that rotates; beside a way it drives a spindle.
        ({"force": "N.m"}, {}, Units(is_rotating=True)),
        ({"position": "m", "force": "N.m"}, {}, Units(readings={"force": "N.m"})),
        ({"position": "rad", "force": "N"}, {}, Units(is_rotating=True, readings={"force": "N"})),
        ({"position": "rad", "force": "A"}, {}, Units(is_rotating=True, readings={"force": "A"})),
        ({"force": "A"}, {}, Units(readings={"force": "A"})),
        ({}, {"mass": "0.1 kg.m2"}, Units(is_rotating=True)),
        ({}, {"friction.coulomb.Fc": (0.1, "N.m")}, Units(is_rotating=True)),
        # An angle may be an incline, and a number is of no unit.
        ({}, {"incline": "0.1 rad", "mass": 0.1, "friction.coulomb.Fc": "7 N"}, Units()),
    ],
)
def test_units_tell_the_machine(stated: dict[str, str], given: dict[str, Any], expected: Units) -> None:
    assert told_units("force", [(signal, si, COLUMN) for signal, si in stated.items()], given) == expected


@pytest.mark.parametrize(
    ("experiment", "stated", "given", "text"),
    [
        (
            "motion",
            [("position", "rad")],
            {},
            "columns='x': position is in rad, which only the experiment force takes; motion takes m, cm, mm, um, nm, "
            "in, ft",
        ),
        (
            "force",
            [("position", "m"), ("velocity", "rad/s")],
            {},
            "columns='x': position is in m, but velocity in rad/s: a machine slides or it rotates; which is it?",
        ),
        (
            "force",
            [("position", "m")],
            {"mass": "0.1 kg.m2"},
            "mass = 0.1 kg.m2 is of a rotating machine, but position is in m; which is it?",
        ),
        (
            "force",
            [("force", "N"), ("force", "A")],
            {},
            "force is in A and in N in different records; which is it?",
        ),
    ],
)
def test_units_of_two_machines_are_refused(
    experiment: str, stated: list[tuple[str, str]], given: dict[str, str], text: str
) -> None:
    with pytest.raises(ValueError, match="^" + re.escape(text) + "$"):
        told_units(experiment, [(signal, si, COLUMN) for signal, si in stated], given)


def test_readings_have_the_units_of_the_machine() -> None:
    """A gain of a reading becomes a force of the machine; time has neither gain nor offset."""
    sliding, turning, motor = Units(), Units(is_rotating=True), Units(readings={"force": "A"})
    for units, offset, gain in ((sliding, "N", "1"), (turning, "N.m", "1"), (motor, "A", "N/A")):
        beside = units_beside("force", units)
        assert (beside["offset.force"], beside["gain.force"]) == (offset, gain)
    beside = units_beside("motion", sliding)
    for signal in SIGNALS:
        is_read = signal != "time"
        assert (f"gain.{signal}" in beside, f"offset.{signal}" in beside) == (is_read, is_read)
        assert not is_read or beside[f"offset.{signal}"] == SIGNALS[signal]
    assert units_beside("force", turning)["offset.normalForce"] == "N"


INF = math.inf


def used(name: str, *signals: str) -> Experiment:
    """An experiment with measured signals."""
    experiment = EXPERIMENTS[name]("Coulomb", {}, Options())
    experiment.use(["time", *signals])
    return experiment


@pytest.mark.parametrize(
    "expected",
    [
        Free("gain.force", "1", 1.0, -INF, INF, 1.0),
        # An offset moves by a step that hardly matters: 0.1 mm, 1 N, 10 mbar.
        Free("offset.position", "m", 0.0, -INF, INF, 1e-4),
        Free("offset.force", "N", 0.0, -INF, INF, 1.0),
        Free("offset.chamberA.pressure", "Pa", 0.0, -INF, INF, 1e3),
        Free("delay.position", "s", 0.0, -0.5, 0.5, 0.02),
        # Neither a lag nor a spring is negative.
        Free("lag.position", "s", 0.0, 0.0, 0.5, 0.02, legal=(0.0, INF)),
        Free("spring", "N/m", 100.0, 0.0, INF, 100.0, legal=(0.0, INF)),
        Free("springRest", "m", 0.0, -INF, INF, 0.01),
        # From upright to upright.
        Free("incline", "rad", 0.0, -math.pi / 2, math.pi / 2, 0.1, legal=(-math.pi / 2, math.pi / 2)),
    ],
    ids=lambda free: free.name,
)
def test_parameter_of_no_law_begins_where_nothing_is_assumed(expected: Free) -> None:
    is_of_gas = expected.name == "offset.chamberA.pressure"
    signals = ("position", "chamberA.pressure", "chamberB.pressure") if is_of_gas else ("position", "force")
    bench = used("mechanical" if is_of_gas else "force", *signals)
    assert parse(expected.name, bench) == expected
    given = f"{expected.name}=0.25"
    assert parse(given, bench) == replace(expected, start=0.25, is_given=True)
    low = parse(f"{expected.name}:0.1:0.4", bench)
    assert (low.low, low.high, low.is_bounded, low.is_given) == (0.1, 0.4, True, False)
    # A start outside of the bounds that are given moves to the nearer one.
    assert low.start == min(max(expected.start, 0.1), 0.4)


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("gain.velocity", "velocity is not compared or driving here, only position, force"),
        ("offset.chamberB.pressure", "chamberB.pressure is not compared or driving here, only position, force"),
        ("lag.force", "force is not compared here, only position"),
    ],
)  # fmt: skip
def test_sensor_without_a_part_is_refused(name: str, text: str) -> None:
    with pytest.raises(ValueError, match="^" + re.escape(f"fit={name!r}: {text}") + "$"):
        parse(name, used("force", "position", "force"))
