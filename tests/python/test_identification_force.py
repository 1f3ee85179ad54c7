"""Axes that a measured force moves, with the truth known, and sensors with a gain and an offset."""

from __future__ import annotations

import json
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pneumatic_servo as ps
import pytest
from numpy.typing import NDArray
from pneumatic_servo.cli import main
from test_identification import RIG, RIG_COLUMNS

Array = NDArray[np.float64]
STEP = 2e-3
TRUE = {"mass": 20.0, "friction.coulomb.Fc": 15.0, "friction.coulomb.sigma2": 60.0}
FREE = list(TRUE)
GRAVITY = 9.80665
SLOPE = 0.2


@cache
def axis(incline: float = 0.0) -> dict[str, Array]:
    """An axis in closed loop, integrated by itself in steps of 0.02 ms: dry and viscous friction, the force held."""
    rng = np.random.default_rng(3)
    mass, dry, viscous = TRUE.values()
    time = np.arange(0.0, 4.0, STEP)
    target = 0.1 * np.sin(3.0 * time) + 0.02 * np.sin(11.0 * time)
    weight, substeps = mass * GRAVITY * np.sin(incline), 100
    position, velocity, force = (np.zeros(len(time)) for _ in range(3))
    x = v = 0.0
    for k in range(len(time)):
        position[k], velocity[k] = x, v
        force[k] = 3000.0 * (target[k] - x) - 300.0 * v
        push = force[k] - weight
        for _ in range(substeps):
            if v == 0.0 and abs(push) <= dry:
                continue
            way = np.sign(v) if v != 0.0 else np.sign(push)
            fast = v + STEP / substeps * (push - viscous * v - dry * way) / mass
            fast = 0.0 if v * fast < 0.0 else fast
            x, v = x + 0.5 * STEP / substeps * (v + fast), fast
    return {
        "time": time, "position": position + 5e-6 * rng.standard_normal(len(time)),
        "velocity": velocity + 1e-4 * rng.standard_normal(len(time)), "force": force,
    }  # fmt: skip


def fit(data: dict[str, Array], **options: object) -> ps.Fit:
    given = {"experiment": "force", "law": "Coulomb", "starts": 0, "progress": False, **options}
    return ps.fit(data, **given)  # type: ignore[arg-type]


def chosen(*names: str, **changed: Array) -> dict[str, Array]:
    return {name: changed.get(name, axis()[name]) for name in ("time", *names)}


def holds(found: ps.Fit, truth: dict[str, float], within: float) -> None:
    """Twice the interval of 95 % holds all of them but for one time in 2,000."""
    for name, value in truth.items():
        estimate = found.parameters[name]
        half = 0.5 * (estimate.high - estimate.low)
        assert abs(estimate.value - value) < 2.0 * half < 2.0 * within * abs(value), (name, estimate)


def test_search_starts_near_what_a_regression_gives() -> None:
    """Mass, spring and offset, or the gain of a current where the mass is known: what smoothing leaves is 5 %."""
    mass = TRUE["mass"]
    problem = fit(chosen("position", "force"), fit=FREE[1:], settings={"mass": mass}).problem

    def guess(
        values: dict[str, float], gain: float = 1.0, spring: float = 0.0, offset: float = 0.0
    ) -> dict[str, float]:
        windows = [
            replace(one, driven={**one.driven, "force": (one.driven["force"] + spring * one.driven["position"]) / gain
                                                        + offset})
            for one in problem.windows
        ]  # fmt: skip
        return problem.experiment.native.guess([one.native for one in windows], values)

    assert guess({"mass": 1.0}) == {"mass": pytest.approx(mass, rel=0.05), "gain.force": 1.0}
    found = guess({"mass": 1.0, "spring": 100.0, "offset.force": 0.0}, spring=400.0, offset=3.0)
    assert found == {
        "mass": pytest.approx(mass, rel=0.05), "gain.force": 1.0, "spring": pytest.approx(400.0, rel=0.05),
        "offset.force": pytest.approx(3.0, abs=0.5),
    }  # fmt: skip
    # A gain that is given beside a free mass stays, and the mass is in its units.
    found = guess({"mass": 1.0, "gain.force": 20.0}, gain=20.0)
    assert found == {"mass": pytest.approx(mass, rel=0.05), "gain.force": 20.0}
    found = guess({"gain.force": 1.0, "spring": 100.0}, gain=20.0, spring=400.0)
    assert found["gain.force"] == pytest.approx(20.0, rel=0.05)
    assert found["spring"] == pytest.approx(400.0, rel=0.05) and found["mass"] == pytest.approx(mass, rel=1e-12)


def test_axis_gives_mass_friction_and_the_offset_of_its_force() -> None:
    found = fit(chosen("position", "force", force=axis()["force"] - 3.2), fit=[*FREE, "offset.force"], validation=0.25)
    holds(found, {**TRUE, "offset.force": -3.2}, within=0.06)
    assert found.converged and not found.not_identifiable
    # In windows of 0.15 s the path is met to the noise, also where it was not fitted.
    assert found.rms["position"] < 1e-5 and found.validation_rms["position"] < 1e-3


def test_velocity_alone_or_beside_does_as_well() -> None:
    holds(fit(chosen("velocity", "force"), fit=FREE), TRUE, within=0.06)
    holds(fit(chosen("position", "velocity", "force"), fit=FREE), TRUE, within=0.06)


def test_what_is_free_by_default_is_the_mass_too() -> None:
    found = fit(chosen("position", "force"))
    assert set(found.parameters) == set(FREE)
    known = fit(chosen("position", "force"), settings={"mass": "20 kg"})
    assert set(known.parameters) == set(FREE) - {"mass"}


def test_current_is_a_force_with_a_gain() -> None:
    current = chosen("position", "force", force=axis()["force"] / 50.0)
    found = fit(current, settings={"mass": 20.0}, fit=[*FREE[1:], "gain.force=40"])
    holds(found, {"gain.force": 50.0, **{name: TRUE[name] for name in FREE[1:]}}, within=0.06)
    same = fit(current, settings={"gain.force": 50.0}, fit=FREE)
    assert same.values == pytest.approx(fit(chosen("position", "force"), fit=FREE).values, rel=1e-4)
    # Twice the gain is twice the mass and twice the friction.
    both = fit(current, fit=[*FREE, "gain.force=40"])
    assert "gain.force" in both.not_identifiable and "mass" in both.not_identifiable


def test_weight_on_a_slope_counts() -> None:
    data = {name: axis(SLOPE)[name] for name in ("time", "position", "force")}
    holds(fit(data, settings={"incline": "11.459156 deg"}, fit=FREE), TRUE, within=0.06)
    found = fit(data, settings={"mass": 20.0}, fit=[*FREE[1:], "incline"])
    holds(found, {"incline": SLOPE}, within=0.15)


def test_spring_is_found_beside_the_mass() -> None:
    """A spring of 500 N/m, at rest at 20 mm, needs so much more force for the same motion."""
    position = axis()["position"]
    force = axis()["force"] + 500.0 * (position - 0.02)
    data = chosen("position", "force", force=force)
    found = fit(data, fit=[*FREE, "spring", "springRest"])
    holds(found, {**TRUE, "spring": 500.0, "springRest": 0.02}, within=0.2)
    known = fit(data, fit=FREE, settings={"spring": 500.0, "springRest": 0.02})
    holds(known, TRUE, within=0.1)
    assert fit(data, fit=FREE).rms["position"] > 2.0 * known.rms["position"]
    assert not fit(data, fit=[*FREE, "spring", "offset.force"]).not_identifiable
    with pytest.raises(ValueError, match="settings='spring': a spring needs a column for position"):
        fit(chosen("velocity", "force"), settings={"spring": 500.0})
    with pytest.raises(ValueError, match="spring"):
        fit(chosen("velocity", "force"), fit=[*FREE, "spring"])


def test_command_line_has_it(tmp_path: Path) -> None:
    file = tmp_path / "axis.csv"
    rows = zip(axis()["time"], 1e3 * axis()["position"], axis()["force"] / 50.0, strict=True)
    file.write_text("t,x,i\n" + "".join(f"{t:.3f},{x:.6f},{i:.6f}\n" for t, x, i in rows), encoding="utf-8")
    assert main([
        "fit", str(file), "--experiment", "force", "--law", "Coulomb", "--columns", "time=t,position=x[mm],force=i",
        "--set", "gain.force=50", "--fit", "mass,friction.coulomb.Fc,friction.coulomb.sigma2,offset.force",
        "--starts", "0", "--json", str(tmp_path / "a.json"),
    ]) == 0  # fmt: skip
    found = json.loads((tmp_path / "a.json").read_text(encoding="utf-8"))["parameters"]
    assert found["mass"]["unit"] == "kg" and found["mass"]["value"] == pytest.approx(20.0, rel=0.02)


@pytest.mark.parametrize(
    ("names", "options", "words"),
    [
        (("force",), {}, ["experiment='force'", "position or velocity"]),
        (("position",), {}, ["needs columns for time, force", "force is missing"]),
        (("position", "force"), {"fit": "friction.coulomb.Fc"}, ["mass has no default", "free, or fixed by settings"]),
        (("position", "force"), {"fit": "gain.valveVoltage"}, ["valveVoltage is not compared or driving here"]),
        (("position", "force"), {"fit": "delay.velocity"}, ["velocity is not compared or driving here, only position"]),
        (("position", "force"), {"settings": {"offset.chamberA.pressure": 1.0}}, ["only sensors of position, force"]),
        (("position", "force"), {"settings": {"gain.force": "2 N"}}, ["gain.force", "N"]),
        (("position", "force"), {"settings": {"incline": "1 m"}}, ["incline", "rad"]),
    ],
)
def test_what_has_no_part_in_it_is_refused(
    names: tuple[str, ...], options: dict[str, object], words: list[str]
) -> None:
    with pytest.raises(ValueError, match=r".") as caught:
        fit(chosen(*names), **options)
    assert all(word in str(caught.value) for word in words), str(caught.value)


def test_offset_of_the_voltage_and_gain_of_a_pressure_of_a_rig_are_found() -> None:
    """The inputs of a rig are read by sensors, too: 0.2 V too much, and a pressure 3 % too low."""
    table = np.genfromtxt(RIG, delimiter=",", names=True)
    data = {"time": table["t"], "valveVoltage": table["u"] + 0.2, "position": 1e-3 * table["x_mm"],
            "chamberA.pressure": 0.97e5 * table["pa_bar"], "chamberB.pressure": 1e5 * table["pb_bar"]}  # fmt: skip
    known = {"supplyPressure": 6e5, "valve.deadZone": 0.065, "valve.C": 4.4e-9, "friction.stribeck.Fs": 12.4,
             "friction.stribeck.vs": 0.018, "friction.stribeck.sigma2": 38.0}  # fmt: skip
    found = ps.fit(
        data, experiment="rig", law="Stribeck", settings=known, starts=0, progress=False,
        fit=["friction.stribeck.Fc", "offset.valveVoltage", "gain.chamberA.pressure"],
    )  # fmt: skip
    holds(found, {"friction.stribeck.Fc": 7.6, "offset.valveVoltage": 0.2, "gain.chamberA.pressure": 1 / 0.97}, 0.02)
    columns = RIG_COLUMNS.replace("valveVoltage=u", "valveVoltage=-u")
    # The true voltage is within the range of the valve, and there is nothing to warn of.
    turned = ps.fit(
        RIG, experiment="rig", law="Stribeck", settings={**known, "gain.valveVoltage": -1.0}, columns=columns,
        fit=["friction.stribeck.Fc"], starts=0, progress=False,
    )  # fmt: skip
    assert turned.values["friction.stribeck.Fc"] == pytest.approx(7.6, rel=0.02)
