"""Measured friction as a table, and what a run makes of it."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pneumatic_servo as ps
import pytest
from bounds import assert_close

SPEEDS = np.array([0.0, 0.02, 0.05, 0.1, 0.2, 0.4])
OUTWARDS = np.array([11.0, 8.6, 8.4, 9.5, 12.4, 18.3])
INWARDS = np.array([14.0, 10.1, 9.8, 11.0, 14.1, 20.0])
VELOCITIES = np.concatenate([-SPEEDS[:0:-1], SPEEDS])
FORCES = np.concatenate([-INWARDS[:0:-1], OUTWARDS])


def steady(settings: dict[str, Any], velocity: float) -> float:
    """Friction in N that the bench has at a velocity in m/s."""
    run = ps.Model("FrictionBench").simulate(
        {**settings, "bench.drive": "PrescribedMotion", "driveVelocity": velocity}, stop=0.1, outputs=["frictionForce"]
    )
    return float(run["frictionForce"][-1])


def test_run_has_the_measured_friction() -> None:
    settings = ps.friction_table(VELOCITIES, FORCES)
    for velocity, force in zip(VELOCITIES, FORCES, strict=True):
        if velocity != 0.0:
            assert_close(steady(settings, float(velocity)), float(force), rel=1e-14, what=f"force at {velocity} m/s")


@pytest.mark.parametrize("separator", [",", ";"])
def test_file_may_have_units_and_either_sign(tmp_path: Path, separator: str) -> None:
    file = tmp_path / "friction.csv"
    rows = [f"{1e3 * v:.12g}{separator}{abs(f):.12g}" for v, f in zip(VELOCITIES, FORCES, strict=True)]
    rows[5] = f"0{separator}12"
    file.write_text("\n".join([separator.join(["velocity [mm/s]", "friction force (N)"]), *rows]), encoding="utf-8")
    both = [-12.0, 12.0]
    found = ps.friction_table(file)
    expected = ps.friction_table([*VELOCITIES[:5], 0.0, 0.0, *VELOCITIES[6:]], [*FORCES[:5], *both, *FORCES[6:]])
    assert found.keys() == expected.keys()
    for name, value in expected.items():
        assert found[name] == value or abs(found[name] - value) <= 1e-12 * abs(value), name


def test_mapping_and_one_direction() -> None:
    settings = ps.friction_table({"velocity": SPEEDS, "force": OUTWARDS})
    assert_close(steady(settings, -0.1), -9.5, rel=1e-14, what="force of the other direction")


def test_points_are_rows_of_velocity_and_force() -> None:
    points = np.column_stack([VELOCITIES, FORCES])
    assert ps.friction_table(points) == ps.friction_table(points.tolist()) == ps.friction_table(VELOCITIES, FORCES)
    with pytest.raises(TypeError, match=r"points of velocity and force, of shape \(rows, 2\)"):
        ps.friction_table([1.0, 2.0])


def test_row_of_a_file_is_named_by_its_line(tmp_path: Path) -> None:
    file = tmp_path / "friction.csv"
    file.write_text("# a rig\nv;F\n0,1;9\n0,2;-8,5\n", encoding="utf-8")
    with pytest.raises(ValueError, match=r"friction\.csv:4: the friction outwards, -8\.5 N at 0\.2 m/s, drives"):
        ps.friction_table(file)


def test_samples_become_eleven_points() -> None:
    """Of a Stribeck curve with noise: the mean error is far below the noise."""
    random = np.random.default_rng(7)
    speeds = random.uniform(0.0, 0.3, 20_000)
    true = 8.0 + 3.0 * np.exp(-speeds / 0.05) + 20.0 * speeds
    settings = ps.friction_table(speeds, true + random.normal(0.0, 0.3, len(speeds)))
    assert settings["friction.table.outwards.points"] == 11
    for speed in (0.005, 0.03, 0.1, 0.2, 0.29):
        expected = 8.0 + 3.0 * np.exp(-speed / 0.05) + 20.0 * speed
        assert abs(steady(settings, speed) - expected) < 0.05


@pytest.mark.parametrize(
    ("given", "words"),
    [
        (([0.1, 0.2], [1.0, -2.0]), "the friction outwards, -2 N at 0.2 m/s, drives"),
        (([0.1, 0.2], [1.0]), "velocity has 2 rows and force 1"),
        (([0.1, float("nan")], [1.0, 2.0]), "velocity is refused: it must be a row of finite numbers in m/s"),
        (([0.1, 0.1], [1.0, 2.0]), "the friction outwards has one velocity, 0.1 m/s"),
        (([], []), "velocity has no rows: a curve of friction needs two velocities"),
        (({"time": [0.0], "force": [1.0]},), "columns time, force: one of them must be velocity"),
        (({"v": [0.0], "F": [1.0], "friction": [1.0]},), "2 columns of force, F, friction: it must have one"),
    ],
)
def test_what_is_no_curve_is_refused(given: tuple[Any, ...], words: str) -> None:
    with pytest.raises(ValueError, match=words):
        ps.friction_table(*given)
