"""Sensors of what drives a model that lag: the delay is found in every experiment, also where windows are short."""

from __future__ import annotations

import numpy as np
import pneumatic_servo as ps
import pytest
from named_mistakes import record
from numpy.typing import NDArray
from test_identification import bench
from test_identification_force import FREE, TRUE, chosen, holds
from test_identification_force import axis as moved
from test_identification_force import fit as fit_force

Array = NDArray[np.float64]
KNOWN = {"supplyPressure": 6e5, "valve.deadZone": 0.065, "valve.C": 4.4e-9, "friction.stribeck.Fs": 12.4,
         "friction.stribeck.vs": 0.018, "friction.stribeck.sigma2": 38.0}  # fmt: skip


def later(course: Array, samples: int) -> Array:
    """A course read a number of samples late; before that it has its first value."""
    return np.concatenate([np.full(samples, course[0]), course[:-samples]])


def of_rig(experiment: str, fit: list[str], known: dict[str, float] = KNOWN, **changed: Array) -> ps.Fit:
    data = {**record(), **changed}
    return ps.fit(data, experiment=experiment, law="Stribeck", settings=dict(known), starts=0, progress=False, fit=fit)


def test_delay_of_a_voltage_is_found() -> None:
    """6 ms of a rig sampled each ms, whole and in windows; ignored, it would leave much of the position."""
    late = later(record()["valveVoltage"], 6)
    free = ["friction.stribeck.Fc", "delay.valveVoltage"]
    found = of_rig("rig", free, valveVoltage=late)
    holds(found, {"friction.stribeck.Fc": 7.6, "delay.valveVoltage": 6e-3}, within=0.03)
    known = of_rig("rig", free[:1], {**KNOWN, "delay.valveVoltage": 6e-3}, valveVoltage=late)
    holds(known, {"friction.stribeck.Fc": 7.6}, within=0.02)
    ignored = of_rig("rig", free[:1], valveVoltage=late)
    assert ignored.rms["position"] > 2.0 * found.rms["position"]


def test_delays_of_voltage_and_position_are_found_from_the_pressures() -> None:
    late = {"valveVoltage": later(record()["valveVoltage"], 4), "position": later(record()["position"], 9) + 0.01}
    known = {name: value for name, value in KNOWN.items() if name != "valve.C"}
    free = ["valve.C", "delay.valveVoltage", "delay.position", "offset.position"]
    found = of_rig("pneumatic", free, known, **late)
    holds(found, {"valve.C": 4.4e-9, "delay.valveVoltage": 4e-3, "delay.position": 9e-3}, within=0.1)
    holds(found, {"offset.position": 0.01}, within=0.1)


def test_delay_of_a_pressure_is_found_from_the_motion() -> None:
    """Windows of 0.15 s: what is read after the end of one belongs to it."""
    late = {name: later(record()[name], 8) for name in ("chamberA.pressure", "chamberB.pressure")}
    known = {**KNOWN, "delay.chamberB.pressure": 8e-3}
    found = of_rig("mechanical", ["friction.stribeck.Fc", "delay.chamberA.pressure"], known, **late)
    holds(found, {"friction.stribeck.Fc": 7.6, "delay.chamberA.pressure": 8e-3}, within=0.2)


def test_delay_of_a_force_is_found() -> None:
    """3 samples of 2 ms in windows of 0.15 s."""
    data = chosen("position", "force", force=later(moved()["force"], 3))
    found = fit_force(data, fit=[*FREE, "delay.force"])
    holds(found, {**TRUE, "delay.force": 6e-3}, within=0.1)
    known = fit_force(data, fit=FREE, settings={"delay.force": 6e-3})
    holds(known, TRUE, within=0.06)


def test_delays_and_gains_of_motion_and_load_are_found() -> None:
    """A position read 30 ms late, and a load that is read as half of what it is, 50 ms late."""
    data = bench()
    load = 10.0 + 5.0 * np.sin(2.0 * np.pi * 0.13 * data["time"])
    free = [f"friction.stribeck.{name}" for name in ("Fs", "Fc", "vs", "sigma2")]
    true = {"friction.stribeck.Fs": 11.0, "friction.stribeck.Fc": 7.0, "friction.stribeck.vs": 0.012,
            "friction.stribeck.sigma2": 25.0}  # fmt: skip
    # The load is a factor of dry friction, not of what is viscous; it is held until the next sample.
    viscous = 25.0 * np.append(0.0, np.diff(data["position"]) / 0.01)
    seen = {**data, "position": later(data["position"], 3), "normalForce": later(0.5 * load, 5),
            "frictionForce": (data["frictionForce"] - viscous) * later(load, 1) / 10.0 + viscous}  # fmt: skip
    given = {"experiment": "motion", "law": "Stribeck", "play": 0.0, "starts": 64, "rated": 10.0, "progress": False}
    found = ps.fit(
        seen, fit=[*free, "delay.position", "delay.normalForce"], settings={"gain.normalForce": 2.0}, **given
    )
    holds(found, {**true, "delay.position": 0.03, "delay.normalForce": 0.05}, within=0.2)
    # The path in steps of half a millimetre.
    half = ps.fit({**data, "position": 0.5 * data["position"]}, fit=free, settings={"gain.position": 2.0}, **given)
    assert half.values == pytest.approx(ps.fit(data, fit=free, **given).values, rel=1e-6)


def test_offset_and_gain_of_a_velocity_count_where_it_gives_the_motion() -> None:
    data = bench()
    speed = np.gradient(data["position"], data["time"])
    free = [f"friction.stribeck.{name}" for name in ("Fs", "Fc", "vs", "sigma2")]
    given = {"experiment": "motion", "law": "Stribeck", "play": 0.0, "starts": 0, "progress": False, "fit": free}
    plain = {"time": data["time"], "frictionForce": data["frictionForce"]}
    right = ps.fit({**plain, "velocity": speed}, **given)
    other = ps.fit({**plain, "velocity": 0.25 * speed + 0.001}, **given,
                   settings={"gain.velocity": 4.0, "offset.velocity": 0.001})  # fmt: skip
    assert other.values == pytest.approx(right.values, rel=1e-4)
