"""The arm of MuJoCo that the cylinder lifts, against both as one system."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pytest

ROOT = Path(__file__).parents[2]
sys.path.insert(0, str(ROOT / "examples"))

import mujoco_arm  # noqa: E402

REFERENCE = np.genfromtxt(ROOT / "tests" / "reference" / "arm.csv", delimiter=",", names=True)


def distance(lift: mujoco_arm.Lift) -> float:
    """Largest distance in m from the system as one."""
    return float(np.abs(lift.position[9::10] - REFERENCE["position"]).max())


@pytest.mark.parametrize(("way", "step", "bound"), [("mean", 1e-4, 2e-6), ("mean", 1e-3, 2e-5), ("held", 1e-3, 1e-4)])
def test_coupled_arm_moves_as_one_system(way: str, step: float, bound: float) -> None:
    lift = mujoco_arm.driven(way, step)
    assert distance(lift) < bound
    # The arm rests and breaks away where the whole system does.
    assert np.array_equal(lift.sticking[9::10], REFERENCE["sticking"])


def test_energy_of_the_coupling_is_accounted_for() -> None:
    """The cylinder gives the energy that the arm takes; the error shrinks with the square of the step."""
    errors = [abs(lift.given - lift.taken) for lift in (mujoco_arm.driven("mean", step) for step in (1e-3, 2.5e-4))]
    assert errors[0] < 1e-4 and errors[1] < 0.15 * errors[0]
    assert mujoco_arm.driven("mean", 1e-3).taken > 1.0


def test_spring_between_both_is_off_by_a_multiple() -> None:
    assert 1e-4 < distance(mujoco_arm.sprung(1e-3)) < 1e-3
