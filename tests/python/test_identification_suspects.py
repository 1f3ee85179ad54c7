"""Settings that are given wrong: the verdict names them before any sensor.

The record was integrated independently of this library (docs/studies/synthetic_rig.py), with the bore, the mass and the
thermal model that are the defaults, and a supply of 6 bar.
"""

from __future__ import annotations

import numpy as np
import pneumatic_servo as ps
import pytest
from numpy.typing import NDArray
from pneumatic_servo.identification.fitted import Estimate
from test_identification import RIG, RIG_COLUMNS

Array = NDArray[np.float64]
FREE = [*(f"friction.stribeck.{name}" for name in ("Fs", "Fc", "vs", "sigma2")), "valve.deadZone", "valve.C"]


@pytest.mark.filterwarnings("ignore::pneumatic_servo.PlantWarning")
@pytest.mark.parametrize(
    ("name", "wrong", "right"),
    [
        ("supplyPressure", 6e5 - 101325.0, 6e5),
        ("cylinder.bore", 0.02, 0.016),
        ("mass.moving", 1.76, 0.88),
        # Without the load that is on it.
        ("mass.moving", 0.11, 0.88),
        ("thermal.model", "Polytropic", "EnergyBalance"),
        ("thermal.model", "Isothermal", "EnergyBalance"),
    ],
)
def test_wrong_setting_is_named_before_any_sensor(name: str, wrong: float | str, right: float | str) -> None:
    found = ps.fit(
        RIG, experiment="rig", law="Stribeck", columns=RIG_COLUMNS, fit=FREE, starts=0, progress=False,
        settings={"supplyPressure": 6e5, name: wrong},
    )  # fmt: skip
    suspect = found.suspect
    assert suspect is not None and suspect.name == name and suspect.given == wrong
    if isinstance(right, str):
        assert suspect.estimate == right
    else:
        assert isinstance(suspect.estimate, Estimate)
        half = 0.5 * (suspect.estimate.high - suspect.estimate.low)
        assert abs(suspect.estimate.value - right) < 2.0 * half < 0.2 * right
    assert suspect.share > 0.9
    causes = [finding.text for finding in found.verdict.findings if "would be gone" in finding.text]
    assert name in causes[0] and found.verdict.light != "green"
    assert ("above ambient" in causes[0]) is (name == "supplyPressure")


@pytest.mark.filterwarnings("ignore::pneumatic_servo.PlantWarning")
@pytest.mark.parametrize(("supply", "item"), [(6e5, "atmosphere"), (6e5 - 101325.0, "atmosphere, like the supply")])
def test_gauge_pressures_of_a_pressurised_record_are_named(supply: float, item: str) -> None:
    """From 0.5 s on no chamber is near the atmosphere, so that no reading is an impossible one."""
    table = np.genfromtxt(RIG, delimiter=",", names=True)[500:1500]
    data = {"time": table["t"], "valveVoltage": table["u"], "position": 1e-3 * table["x_mm"],
            "chamberA.pressure": 1e5 * table["pa_bar"] - 101325.0,
            "chamberB.pressure": 1e5 * table["pb_bar"] - 101325.0}  # fmt: skip
    given = {"experiment": "rig", "law": "Stribeck", "starts": 0, "progress": False}
    free = ["friction.stribeck.Fs", "friction.stribeck.Fc", "valve.C"]
    known = {"friction.stribeck.vs": 0.018, "friction.stribeck.sigma2": 38.0, "valve.deadZone": 0.065}
    found = ps.fit(data, fit=free, settings={**known, "supplyPressure": supply}, **given)
    suspect = found.suspect
    assert suspect is not None and suspect.name == "the pressures of both chambers", str(suspect)
    assert suspect.given == "absolute" and suspect.estimate == f"from the {item}" and suspect.share > 0.9
    assert f"from the {item}: give them in barg" in found.verdict.text and found.verdict.light != "green"
    # Who obeys has a far better fit; the record begins in motion, with gas that is not at the temperature outside.
    for chamber in ("chamberA.pressure", "chamberB.pressure"):
        data[f"{chamber} [barg]"] = 1e-5 * data.pop(chamber)
    right = "4.98675 barg" if supply < 6e5 else supply
    obeyed = ps.fit(data, fit=free, settings={**known, "supplyPressure": right}, **given)
    rms = {signal: obeyed.rms[signal] / left for signal, left in found.rms.items()}
    assert rms["chamberA.pressure"] < 0.2 and rms["position"] < 0.4, rms


def test_right_settings_are_not_suspected() -> None:
    found = ps.fit(
        RIG, experiment="rig", law="Stribeck", columns=RIG_COLUMNS, fit=FREE, starts=0, progress=False,
        settings={"supplyPressure": 6e5},
    )  # fmt: skip
    assert found.suspect is None and found.verdict.light == "green"


def test_mass_of_an_axis_is_suspected() -> None:
    """An inertia that is given twice is no fault of the force."""
    time = np.arange(0.0, 4.0, 2e-3)
    amplitude, rate = 0.05, 2.0 * np.pi
    position = amplitude * np.sin(rate * time)
    speed, acceleration = amplitude * rate * np.cos(rate * time), -(rate**2) * position
    force = 20.0 * acceleration + 60.0 * speed + 15.0 * np.sign(speed)
    noise = 5e-6 * np.random.default_rng(1).standard_normal(len(time))
    data = {"time": time, "position": position + noise, "force": force}
    found = ps.fit(data, experiment="force", law="Coulomb", settings={"mass": 40.0}, starts=0, progress=False)
    assert found.suspect is not None and found.suspect.name == "mass"
    assert isinstance(found.suspect.estimate, Estimate)
    assert found.suspect.estimate.value == pytest.approx(20.0, rel=0.05)


def test_friction_that_differs_by_direction_is_named_before_an_offset_of_the_force() -> None:
    """+10 N outwards and -6 N inwards are no sensor's offset of 2 N: freed, the factor gives both."""
    time = np.arange(0.0, 6.0, 2e-3)
    position = 0.02 * np.sin(2.0 * time) + 0.006 * np.sin(7.0 * time)
    speed = np.append(0.0, np.diff(position) / 2e-3)
    friction = np.where(speed > 0.0, 10.0, -6.0) + 30.0 * speed
    data = {"time": time, "position": position,
            "frictionForce": friction + 0.05 * np.random.default_rng(3).standard_normal(len(time))}  # fmt: skip
    given = {"experiment": "motion", "law": "Coulomb", "play": 0.0, "starts": 0, "progress": False}
    free = ["friction.coulomb.Fc", "friction.coulomb.sigma2"]
    found = ps.fit(data, fit=free, **given)
    suspect = found.suspect
    assert suspect is not None and suspect.name == "friction.direction.factor"
    assert isinstance(suspect.estimate, Estimate) and suspect.estimate.value == pytest.approx(10.0 / 6.0, rel=0.02)
    causes = [finding.text for finding in found.verdict.findings if "would be gone" in finding.text]
    assert "friction.direction.factor" in causes[0] and "estimate it" in causes[0] and found.verdict.light != "green"
    freed = ps.fit(data, fit=[*free, "friction.direction.factor"], **given)
    inwards, factor = freed.values["friction.coulomb.Fc"], freed.values["friction.direction.factor"]
    assert inwards == pytest.approx(6.0, rel=0.01) and factor * inwards == pytest.approx(10.0, rel=0.01)
    assert freed.verdict.light == "green" and freed.suspect is None


def pushed_axis(outwards: float, inwards: float) -> dict[str, Array]:
    """A carriage of 2 kg in closed loop, integrated in steps of 0.02 ms; its friction differs by direction."""
    step, substeps, mass, viscous = 1e-3, 50, 2.0, 30.0
    time = np.arange(0.0, 3.0, step)
    target = 0.25 + 0.05 * np.sin(4.0 * time) + 0.01 * np.sin(13.0 * time)
    position, force = np.zeros(len(time)), np.zeros(len(time))
    x, v = 0.25, 0.0
    for k in range(len(time)):
        position[k], force[k] = x, 1500.0 * (target[k] - x) - 60.0 * v
        for _ in range(substeps):
            if v == 0.0 and -inwards <= force[k] <= outwards:
                break
            towards = v if v != 0.0 else force[k]
            dry = outwards if towards > 0.0 else -inwards
            fast = v + step / substeps * (force[k] - viscous * v - dry) / mass
            fast = 0.0 if v * fast < 0.0 else fast
            x, v = x + 0.5 * step / substeps * (v + fast), fast
    noise = 2e-6 * np.random.default_rng(5).standard_normal(len(time))
    return {"time": time, "position": position + noise, "force": force}


@pytest.mark.parametrize("experiment", ["force", "mechanical"])
def test_friction_by_direction_is_named_and_found_where_forces_move_a_mass(experiment: str) -> None:
    """+10 N outwards and -6 N inwards: an offset of 2 N would make a plant that has +-8 N."""
    data, mass = pushed_axis(10.0, 6.0), "mass" if experiment == "force" else "mass.moving"
    if experiment == "mechanical":
        model = ps.Model()
        bore, rod = (
            0.25 * np.pi * float(model.parameters[f"cylinder.{name}"].default) ** 2 for name in ("bore", "rod")
        )
        # Pressures are taken to be on lines between samples, and the force was held.
        force = data.pop("force")
        held = 0.5 * (np.append(force[:1], force[:-1]) + force)
        data["chamberB.pressure"] = 3e5 + 1e3 * np.sin(data["time"])
        data["chamberA.pressure"] = (held + data["chamberB.pressure"] * (bore - rod) + 101325.0 * rod) / bore
    given = {"experiment": experiment, "law": "Coulomb", "starts": 0, "progress": False, "settings": {mass: 2.0}}
    free = ["friction.coulomb.Fc", "friction.coulomb.sigma2"]
    found = ps.fit(data, fit=free, **given)
    suspect = found.suspect
    # A dead load of 2 N beside friction of 8 N is the same machine.
    assert suspect is not None and "friction.direction.factor" in (suspect.name, *suspect.alike), str(suspect)
    assert suspect.name in ("friction.direction.factor", "wireForce")
    causes = [finding.text for finding in found.verdict.findings if "would be gone" in finding.text]
    assert "friction.direction.factor" in causes[0] and found.verdict.light != "green"
    freed = ps.fit(data, fit=[*free, "friction.direction.factor"], **given)
    inwards, factor = freed.values["friction.coulomb.Fc"], freed.values["friction.direction.factor"]
    assert inwards == pytest.approx(6.0, rel=0.02) and factor * inwards == pytest.approx(10.0, rel=0.02)


def test_clock_is_named_that_the_conductance_makes_up_for() -> None:
    """Little more than noise is left, and the values are off: what inertia does with time says it."""
    table = np.genfromtxt(RIG, delimiter=",", names=True)
    data = {"time": 1.01 * table["t"], "valveVoltage": table["u"], "position": 1e-3 * table["x_mm"],
            "chamberA.pressure": 1e5 * table["pa_bar"], "chamberB.pressure": 1e5 * table["pb_bar"]}  # fmt: skip
    found = ps.fit(
        data, experiment="rig", law="Stribeck", fit=FREE, settings={"supplyPressure": 6e5}, starts=0, progress=False
    )
    assert found.suspect is not None and found.suspect.name == "time" and found.verdict.light == "yellow"
    assert isinstance(found.suspect.estimate, Estimate)
    assert found.suspect.estimate.value == pytest.approx(1.0 / 1.01, rel=1e-3)


@pytest.mark.parametrize("fast", [1.01, 1.05])
def test_clock_that_runs_fast_is_named(fast: float) -> None:
    """Where the masses are known, and friction is no function of time, nothing else can be 1 or 5 % off."""
    table = np.genfromtxt(RIG, delimiter=",", names=True)
    data = {"time": fast * table["t"], "valveVoltage": table["u"], "position": 1e-3 * table["x_mm"],
            "chamberA.pressure": 1e5 * table["pa_bar"], "chamberB.pressure": 1e5 * table["pb_bar"]}  # fmt: skip
    known = {"supplyPressure": 6e5, "valve.deadZone": 0.065, "valve.C": 4.4e-9}
    found = ps.fit(data, experiment="rig", law="Stribeck", fit=FREE[:4], settings=known, starts=0, progress=False)
    suspect = found.suspect
    assert suspect is not None and found.verdict.light != "green"
    assert "time" in (suspect.name, *suspect.alike)
    causes = [finding.text for finding in found.verdict.findings if "would be gone" in finding.text]
    assert "time" in causes[0]
    if suspect.name == "time":
        assert isinstance(suspect.estimate, Estimate) and suspect.estimate.value == pytest.approx(1.0 / fast, rel=5e-3)


def test_gain_of_a_sensor_is_told_as_large_as_it_is() -> None:
    """Fitted along with all that is free, with an interval: one step in proportion made 0.99 of 0.98."""
    table = np.genfromtxt(RIG, delimiter=",", names=True)
    data = {"time": table["t"], "valveVoltage": table["u"], "position": 1e-3 * table["x_mm"],
            "chamberA.pressure": 1e5 * table["pa_bar"] / 0.98, "chamberB.pressure": 1e5 * table["pb_bar"]}  # fmt: skip
    known = {"supplyPressure": 6e5, "valve.deadZone": 0.065, "valve.C": 4.4e-9}
    found = ps.fit(data, experiment="rig", law="Stribeck", fit=FREE[:4], settings=known, starts=0, progress=False)
    doubt = found.doubt
    assert doubt is not None and doubt.name == "gain.chamberA.pressure"
    size = doubt.estimate
    assert isinstance(size, Estimate) and abs(size.value - 0.98) < size.high - size.low < 0.01
    assert f"{size.value:.5g} [" in str(doubt)
