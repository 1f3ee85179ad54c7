"""The arm that the cylinder lifts as an environment for Gymnasium."""

from __future__ import annotations

import copy
import pickle
import warnings
from pathlib import Path
from typing import Any

import gymnasium
import numpy as np
import pneumatic_servo.envs as envs
import pytest

NAME = "pneumatic_servo/LiftedArm-v0"
REFERENCE = Path(__file__).parents[1] / "reference" / "arm.csv"


@pytest.mark.parametrize("law", ["Stribeck", "LuGre"])
def test_checker_of_gymnasium_is_content(law: str) -> None:
    from gymnasium.utils.env_checker import check_env

    with warnings.catch_warnings():
        warnings.simplefilter("error")
        check_env(gymnasium.make(NAME, law=law).unwrapped)


@pytest.mark.parametrize("number", [1, 7])
def test_arm_moves_as_one_system_with_the_cylinder(number: int) -> None:
    """Against arm and cylinder integrated as one, with rests on the way."""
    reference = np.genfromtxt(REFERENCE, delimiter=",", names=True)
    fleet = envs.VectorPositioning(number, arm=envs.Arm(), duration=10.0)
    fleet.reset(seed=1)
    inner = fleet._fleet
    inner.native.restart([(index, [("position0", 0.2)]) for index in range(number)])
    position = []
    for index in range(2400):
        voltage = 5.46 if index < 1600 else 6.5 if index < 1900 else 4.2
        fleet.step(np.full((number, 1), (voltage - 5.0) / 5.0))
        position.append(inner.native.observe()[:, 0])
    distance = np.abs(np.array(position)[9::10] - reference["position"][:, None])
    assert np.ptp(reference["position"]) > 0.1 and distance.max() < 2e-5


def test_many_have_the_bits_of_one_and_a_seed_repeats_them() -> None:
    task: dict[str, Any] = {"laws": ["Stribeck", "LuGre"], "ranges": envs.RANDOM, "duration": 0.05, "substeps": 2}
    task |= {"period": 2e-3, "targets": (0.05, 0.45)}
    actions = np.random.default_rng(0).uniform(-1.0, 1.0, (20, 5, 1)).astype(np.float32)

    def many(workers: int) -> list[np.ndarray]:
        fleet = gymnasium.make_vec(NAME, num_envs=5, workers=workers, **task)
        return [fleet.reset(seed=3)[0], *(fleet.step(one)[0] for one in actions)]

    expected = many(1)
    for one, other in zip(expected, many(3), strict=True):
        assert one.tobytes() == other.tobytes()
    for index in range(5):
        alone = gymnasium.make(NAME, **task)
        seen = [alone.reset(seed=3 + index)[0], *(alone.step(one[index])[0] for one in actions)]
        for one, other in zip(expected, seen, strict=True):
            assert one[index].tobytes() == other.tobytes()


def test_copy_goes_on_like_the_original() -> None:
    one = envs.Positioning(arm=envs.Arm(mass=2.0))
    one.reset(seed=2)
    one.step(np.array([0.1], dtype=np.float32))
    for other in (copy.deepcopy(one), pickle.loads(pickle.dumps(one))):
        kept = copy.deepcopy(one)
        for _ in range(30):
            action = np.array([0.2], dtype=np.float32)
            assert kept.step(action)[0].tobytes() == other.step(action)[0].tobytes()


def test_arm_may_have_units_and_is_drawn() -> None:
    one = envs.Positioning(arm=envs.Arm(radius="300 mm", mass="1500 g"), render_mode="rgb_array")
    other = envs.Positioning(arm=envs.Arm())
    assert one.reset(seed=1)[0].tobytes() == other.reset(seed=1)[0].tobytes()
    action = np.zeros(1, dtype=np.float32)
    assert one.step(action)[0].tobytes() == other.step(action)[0].tobytes()
    assert one.render().shape == (180, 640, 3)


@pytest.mark.parametrize(
    ("task", "error", "words"),
    [
        ({"arm": envs.Arm(radius=0.2)}, ValueError, "arm: radius = 0.2 m is refused: the carriage moves up to 0.26 m"),
        ({"arm": envs.Arm(mass=-1.0)}, ValueError, "arm: mass = -1 kg is refused: it must be positive"),
        ({"arm": envs.Arm(mass="2 mm")}, ValueError, "arm: mass"),
        ({"arm": envs.Arm(outwards=0.0, upwards=0.0)}, ValueError, "the load must be away from the hinge"),
        ({"arm": 1.5}, TypeError, "arm = 1.5 is refused: it must be an envs.Arm"),
        ({"arm": envs.Arm(), "parameters": {"externalForce": 3.0}}, ValueError, "externalForce is refused"),
    ],
)
def test_impossible_arms_are_refused(task: dict[str, Any], error: type[Exception], words: str) -> None:
    with pytest.raises(error, match=words):
        envs.Positioning(**task)


def test_derivatives_of_a_plant_with_an_arm_are_refused() -> None:
    fleet = envs.VectorPositioning(2, arm=envs.Arm())
    fleet.reset(seed=1)
    with pytest.raises(ValueError, match="transitions is refused: a plant with an arm has none"):
        fleet.transitions(np.zeros((2, 1), dtype=np.float32))
