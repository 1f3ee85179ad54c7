"""Points of a seal bench, velocity, load and friction without a time, against closed forms of steady curves."""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any

import numpy as np
import pneumatic_servo as ps
import pytest
from bounds import assert_close
from numpy.typing import NDArray
from pneumatic_servo.cli import main

Array = NDArray[np.float64]

SPEEDS = 1e-3 * np.array([0.2, 0.5, 1.0, 2.0, 4.0, 7.0, 12.0, 20.0, 35.0, 60.0, 100.0])
BOTH = np.concatenate([-SPEEDS[::-1], SPEEDS])
CURVE = {"Fs": 12.0, "Fc": 8.0, "vs": 0.01, "sigma2": 40.0}


def stribeck(speed: Array, level: Array | float = 1.0) -> Array:
    """Return the steady curve of Stribeck and of LuGre with the exponent 2, whose viscous part no load multiplies."""
    dry = CURVE["Fc"] + (CURVE["Fs"] - CURVE["Fc"]) * np.exp(-((speed / CURVE["vs"]) ** 2))
    return level * dry * np.sign(speed) + CURVE["sigma2"] * speed


def points(seed: int, repeats: int = 3, noise: float = 0.1) -> dict[str, Array]:
    """Return points of the curve in an arbitrary order, each speed several times."""
    random = np.random.default_rng(seed)
    speed = random.permutation(np.tile(BOTH, repeats))
    return {"velocity": speed, "frictionForce": stribeck(speed) + noise * random.standard_normal(len(speed))}


def of_points(data: Any, law: str = "Stribeck", **more: Any) -> ps.Fit:
    return ps.fit(data, experiment="points", law=law, **{"starts": 4, "progress": False, **more})


def assert_within(found: ps.Fit, truth: dict[str, float]) -> None:
    """Truths lie within intervals, or next to them: one interval in twenty misses."""
    for name, value in truth.items():
        one = found[name]
        assert abs(one.value - value) < 0.8 * (one.high - one.low) < 0.8 * abs(value), f"{name}: {one}, not {value}"


@pytest.mark.parametrize("law", ["Stribeck", "LuGre"])
def test_steady_curve_is_found(law: str) -> None:
    """Stiffness and damping of the bristles have no part in it, and are not estimated."""
    found = of_points(points(1), law)
    group = f"friction.{law.lower()}"
    assert found.converged and set(found.parameters) == {f"{group}.{name}" for name in CURVE}
    assert_within(found, {f"{group}.{name}": value for name, value in CURVE.items()})
    assert_close(found.rms["frictionForce"], 0.1, rel=0.25, what="rms")
    assert found.not_identifiable == {} and found.verdict.light == "green", found.verdict


def test_coulomb_friction_is_a_line() -> None:
    """Its estimates are those of linear least squares."""
    random = np.random.default_rng(2)
    force = 8.0 * np.sign(BOTH) + 40.0 * BOTH + 0.05 * random.standard_normal(len(BOTH))
    found = of_points({"velocity": BOTH, "frictionForce": force}, "Coulomb", starts=0)
    (coulomb, viscous), *_ = np.linalg.lstsq(np.column_stack([np.sign(BOTH), BOTH]), force, rcond=None)
    assert_close(found.values["friction.coulomb.Fc"], float(coulomb), rel=1e-4, what="Fc")
    assert_close(found.values["friction.coulomb.sigma2"], float(viscous), rel=1e-3, what="sigma2")
    assert_within(found, {"friction.coulomb.Fc": 8.0, "friction.coulomb.sigma2": 40.0})


def test_order_of_the_points_says_nothing() -> None:
    data = points(3)
    order = np.argsort(data["velocity"], kind="stable")
    one, other = of_points(data), of_points({name: values[order] for name, values in data.items()})
    for name, value in one.values.items():
        assert_close(other.values[name], value, rel=1e-3, what=name)


def test_pressure_loads_the_dry_part() -> None:
    """With a measured friction force, and with a force that includes the pressure on an area."""
    random = np.random.default_rng(4)
    speed, pressure = (grid.ravel() for grid in np.meshgrid(BOTH, 1e5 * np.arange(0.0, 7.0, 2.0)))
    friction = stribeck(speed, 1.0 + 2e-6 * pressure) + 0.05 * random.standard_normal(len(speed))
    free = [f"friction.stribeck.{name}" for name in CURVE]
    truth = {f"friction.stribeck.{name}": value for name, value in CURVE.items()} | {"friction.kappaA": 2e-6}
    seal = {"velocity": speed, "pressure": pressure}
    assert_within(of_points({**seal, "frictionForce": friction}, fit=[*free, "friction.kappaA=1e-7"]), truth)
    found = of_points({**seal, "force": friction + 2e-4 * pressure}, fit=[*free, "friction.kappaA=1e-7", "area"])
    assert_within(found, {**truth, "area": 2e-4})


def test_normal_force_and_direction_load_it() -> None:
    random = np.random.default_rng(5)
    speed, load = (grid.ravel() for grid in np.meshgrid(BOTH, [50.0, 100.0, 150.0]))
    level = load / 100.0 * np.where(speed > 0.0, 1.3, 1.0)
    data = {"velocity": speed, "normalForce": load,
            "frictionForce": stribeck(speed, level) + 0.05 * random.standard_normal(len(speed))}  # fmt: skip
    free = [*(f"friction.stribeck.{name}" for name in CURVE), "friction.direction.factor=1"]
    found = of_points(data, fit=free, rated=100.0)
    truth = {f"friction.stribeck.{name}": value for name, value in CURVE.items()}
    assert_within(found, {**truth, "friction.direction.factor": 1.3})


def test_parameters_without_effect_are_not_identifiable() -> None:
    found = of_points(points(6), "LuGre", fit=["friction.lugre.Fc", "friction.lugre.sigma0", "friction.lugre.sigma1"],
                      settings={f"friction.lugre.{name}": CURVE[name] for name in ("Fs", "vs", "sigma2")})  # fmt: skip
    assert set(found.not_identifiable) == {"friction.lugre.sigma0", "friction.lugre.sigma1"}
    assert_within(found, {"friction.lugre.Fc": 8.0})
    assert "sigma0" in found.verdict.text and found.verdict.light == "yellow"


def test_repeated_points_tell_their_noise() -> None:
    """So that a law that misses the curve is not taken for noise; readings at velocity 0 are no part of it."""
    data = points(7)
    found = of_points(data, "Coulomb", starts=0)
    assert found.verdict.light == "yellow" and "times the noise of its sensor" in found.verdict.text
    ranking = ps.compare_fits(data, ["Coulomb", "Stribeck"], experiment="points", starts=0, progress=False)
    assert ranking.best.law == "Stribeck"
    rests = {"velocity": np.append(data["velocity"], [0.0, 0.0]),
             "frictionForce": np.append(data["frictionForce"], [3.0, -2.0])}  # fmt: skip
    still = of_points(rests)
    assert any("2 of 68 points are left out: at velocity 0" in note for note in still.notes)
    for name, value in of_points(data).values.items():
        assert_close(still.values[name], value, rel=1e-3, what=name)


def test_validation_data_are_the_last_rows() -> None:
    found = of_points(points(8), validation=0.3)
    assert_close(found.validation_rms["frictionForce"], 0.1, rel=0.5, what="validation rms")
    pressed = [{**points(seed), "pressure": np.full(66, 1e5 * seed)} for seed in (1, 2, 3)]
    by_pressure = of_points(pressed, cross_validate="pressure", starts=0).cross_validation
    assert by_pressure is not None and by_pressure.holds == 3


def test_headers_of_laboratories_are_read(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """With German names, units and decimal commas; by columns; on the command line, with a report."""
    data = points(9)
    rows = [f"{1e3 * v:.6f};{f:.6f};2,5".replace(".", ",") for v, f in zip(*data.values(), strict=True)]
    german = tmp_path / "seal.csv"
    german.write_text("\n".join(["Geschwindigkeit [mm/s];Reibkraft [N];Druck [bar]", *rows]), encoding="utf-8")
    with pytest.warns(ps.PlantWarning, match=re.escape("Geschwindigkeit [mm/s] for velocity")):
        found = of_points(german)
    assert_close(found.ranges.limits["pressure"][0], 2.5e5, rel=1e-12, what="pressure")
    exact = of_points(data)
    for name, value in exact.values.items():
        assert_close(found.values[name], value, rel=1e-3, what=name)
    columns = "velocity=Geschwindigkeit[mm/s],frictionForce=Reibkraft"
    fit = of_points(german, columns=columns, fit={"friction.stribeck.Fc": "8 N", "friction.stribeck.vs": "9 mm/s"})
    assert set(fit.parameters) == {"friction.stribeck.Fc", "friction.stribeck.vs"}
    made = [str(tmp_path / name) for name in ("fit.ssv", "fit.json", "fit.html")]
    told = ["fit", str(german), "--experiment", "points", "--law", "Stribeck", "--columns", columns, "--starts", "0",
            "--out", made[0], "--json", made[1], "--report", made[2]]  # fmt: skip
    assert main(told) == 0
    assert "friction.stribeck.Fs" in capsys.readouterr().out
    assert json.loads(Path(made[1]).read_text(encoding="utf-8"))["converged"] is True
    assert "friction.stribeck.Fs" in Path(made[2]).read_text(encoding="utf-8")


def test_points_are_drawn_over_the_velocity() -> None:
    found = of_points(points(10), starts=0)
    upper, lower = found.plot().axes
    assert lower.get_xlabel() == "velocity (mm/s)" and upper.get_ylabel() == "frictionForce (N)"
    assert_close(float(np.max(upper.lines[0].get_xdata())), 100.0, rel=1e-12, what="fastest")
    with pytest.raises(ValueError, match=r"simulate is refused: points have no course over time"):
        found.simulate()


def refused(match: str, data: dict[str, Any] | Path, law: str = "Stribeck", **more: Any) -> None:
    with pytest.raises(ValueError, match=match):
        of_points(data, law, **more)


def test_mistakes_are_refused_by_name(tmp_path: Path) -> None:
    data = points(11)
    speed, force = data["velocity"], data["frictionForce"]
    time = np.arange(float(len(speed)))
    refused("takes points without a time.*leave it out.*motion", {"time": time, **data})
    refused("needs a column for frictionForce or force", {"velocity": speed})
    refused("needs columns for velocity; velocity is missing", {"frictionForce": force})
    refused("velocity = 0 m/s at all points", {**data, "velocity": 0.0 * speed})
    refused("frictionForce is NaN at point 3", {**data, "frictionForce": np.where(time == 3.0, np.nan, force)})
    refused("too few points, 4; at least 5", {name: values[:4] for name, values in data.items()})
    refused("too short: 7 samples.* 4 ", {name: values[:7] for name, values in data.items()})
    bench = tmp_path / "bench.csv"
    bench.write_text("v [mm/s];F [N]\n1;8\n2;9\n")
    with pytest.raises(
        ValueError, match=r"there is no column `time`.*points without a time are fitted as experiment points"
    ):
        ps.fit(bench, experiment="motion", law="Stribeck")
    refused("law = Polito is refused: it has one curve for rising", data, "Polito")
    refused("law = Bristle is refused: its bonds break", data, "Bristle")
    refused("segment is refused: experiment=.points. has no course", data, segment=0.5)
    refused("inputs is refused: experiment=.points. has no course", data, inputs="lines")
    refused("frictionForce = 8 N all the time", {**data, "frictionForce": np.full(len(speed), 8.0)})
    refused("delay.velocity", data, fit=["friction.stribeck.Fc", "delay.velocity"])
    refused("area needs the columns force and pressure", data, fit=["area"])
    unit = tmp_path / "unit.csv"
    unit.write_text("velocity [mm],frictionForce [N]\n" + "1,2\n" * 9, encoding="utf-8")
    refused("the unit mm is refused", unit)
    none = tmp_path / "none.csv"
    none.write_text("a,b\n" + "1,2\n" * 9, encoding="utf-8")
    refused(r"there is no column `velocity`, only a, b; .*velocity=v\[mm/s\]", none)
    badly = pytest.warns(ps.PlantWarning, match="the fitted model does not describe frictionForce")
    with badly, pytest.warns(ps.PlantWarning, match="frictionForce works against friction"):
        of_points({**data, "frictionForce": -force}, starts=0)


def test_exact_derivatives_are_replaced_with_a_warning() -> None:
    with pytest.warns(ps.PlantWarning, match="each point is a run of its own"):
        found = of_points(points(12), jac="exact", starts=0)
    assert_within(found, {f"friction.stribeck.{name}": value for name, value in CURVE.items()})


def test_intervals_cover_the_truth() -> None:
    """Of 40 tables, 33 points and 4 parameters each: 95 % are promised, and fewer than 85 % are no chance."""
    covered = dict.fromkeys(CURVE, 0)
    number = 40
    for seed in range(number):
        random = np.random.default_rng(100 + seed)
        speed = np.tile(SPEEDS, 3)
        data = {"velocity": speed, "frictionForce": stribeck(speed) + 0.1 * random.standard_normal(len(speed))}
        found = of_points(data, starts=0)
        for name, truth in CURVE.items():
            one = found[f"friction.stribeck.{name}"]
            covered[name] += one.low <= truth <= one.high
    print(f"of {number} tables the intervals contain", ", ".join(f"{name} {count}" for name, count in covered.items()))
    assert min(covered.values()) >= 0.85 * number, covered
