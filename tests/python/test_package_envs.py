"""The environments for Gymnasium."""

from __future__ import annotations

import warnings

import gymnasium
import numpy as np
import pneumatic_servo.envs as envs
import pytest

NAME = "pneumatic_servo/Positioning-v0"


@pytest.mark.parametrize("law", ["Stribeck", "LuGre"])
def test_checker_of_gymnasium_is_content(law: str) -> None:
    from gymnasium.utils.env_checker import check_env

    with warnings.catch_warnings():
        warnings.simplefilter("error")
        check_env(gymnasium.make(NAME, law=law).unwrapped)


def test_seed_reproduces_bits() -> None:
    def play() -> list[np.ndarray]:
        fleet = gymnasium.make_vec(NAME, num_envs=8, laws=["Stribeck", "GMS"], ranges=envs.RANDOM, duration=0.05)
        seen = [fleet.reset(seed=5)[0]]
        random = np.random.default_rng(0)
        for _ in range(120):
            seen.append(fleet.step(random.uniform(-1, 1, (8, 1)).astype(np.float32))[0])
        return seen

    for one, other in zip(play(), play(), strict=True):
        assert one.tobytes() == other.tobytes()


@pytest.mark.parametrize(
    ("arguments", "error", "words"),
    [
        ({"laws": "LuGre"}, TypeError, "laws must be a list of names, not the text 'LuGre'"),
        ({"workers": -1}, ValueError, "workers = -1 is refused: it must be at least 1"),
        ({"num_envs": 2.5}, ValueError, "num_envs = 2.5 is refused: it must be a whole number"),
        ({"substeps": 0.5}, ValueError, "substeps = 0.5 is refused: it must be a whole number"),
    ],
)
def test_wrong_argument_is_named(arguments: dict[str, object], error: type[Exception], words: str) -> None:
    with pytest.raises(error, match=words):
        envs.VectorPositioning(**arguments)


def test_observations_are_in_units_of_the_stroke_that_is_set() -> None:
    plant = gymnasium.make(NAME, parameters={"cylinder.stroke": 0.8}, targets=(0.1, 0.7))
    (error, position, *_), info = plant.reset(seed=3)
    # Drawn in one go, uniformly between the targets.
    target, start = np.random.default_rng(3).uniform(0.1, 0.7, 2)
    assert info["target"] == target
    assert [0.8 * position, 0.8 * error] == pytest.approx([start, target - start], abs=1e-7)


def test_vector_of_plants_does_what_single_ones_do() -> None:
    fleet = gymnasium.make_vec(NAME, num_envs=3, law="LuGre")
    observations, _ = fleet.reset(seed=[11, 12, 13])
    singles = [gymnasium.make(NAME, law="LuGre").unwrapped for _ in range(3)]
    # Both draw from NumPy's default generator, seeded alike.
    alone = [single.reset(seed=seed)[0] for single, seed in zip(singles, [11, 12, 13], strict=True)]
    assert np.array(alone).tobytes() == observations.tobytes()
    actions = np.array([[0.3], [-0.2], [0.0]], dtype=np.float32)
    for _ in range(50):
        observations, rewards, *_ = fleet.step(actions)
        steps = [single.step(action) for single, action in zip(singles, actions, strict=True)]
        assert np.array([step[0] for step in steps]).tobytes() == observations.tobytes()
        assert [step[1] for step in steps] == rewards.tolist()


def test_episodes_end_and_begin_anew() -> None:
    fleet = gymnasium.make_vec(NAME, num_envs=2, duration=0.003)
    fleet.reset(seed=1)
    still = np.zeros((2, 1), dtype=np.float32)
    ends = [fleet.step(still)[3].tolist() for _ in range(8)]
    # Three steps, and one that only begins the next episode.
    assert ends == [[False] * 2, [False] * 2, [True] * 2, [False] * 2] * 2


def test_laws_and_parameters_vary_within_their_ranges() -> None:
    environment = gymnasium.make(NAME, laws=["Stribeck", "LuGre"], ranges={"mass.moving": (1.0, 2.0)})
    drawn = [environment.reset(seed=seed)[1] for seed in range(20)]
    assert {info["friction.law"] for info in drawn} == {"Stribeck", "LuGre"}
    masses = [info["mass.moving"] for info in drawn]
    assert 1.0 <= min(masses) < max(masses) <= 2.0


@pytest.mark.parametrize("stroke", [None, 0.8])
def test_baseline_solves_the_task(stroke: float | None) -> None:
    task = {} if stroke is None else {"parameters": {"cylinder.stroke": stroke}}
    fleet = gymnasium.make_vec(NAME, num_envs=16, laws=["Stribeck", "LuGre", "GMS"], ranges=envs.RANDOM, **task)
    baseline = envs.PositionControllers(16, stroke=stroke)
    observations, _ = fleet.reset(seed=3)
    before = np.abs(observations[:, 0]).mean()
    for _ in range(1500):
        observations, *_ = fleet.step(baseline(observations))
    # In units of the stroke, 0.5 m by default: from 80 mm on average to a few millimetres.
    assert before > 0.1 and np.abs(observations[:, 0]).mean() < 0.01


@pytest.mark.parametrize(
    ("task", "word"),
    [
        ({"law": "Lugre"}, "Lugre"),
        ({"targets": (0.4, 0.1)}, "targets"),
        ({"duration": -1.0}, "duration"),
        ({"ranges": {"mass.moving": (2.0, 1.0)}}, "mass.moving"),
        ({"ranges": {"cylinder.stroke": (0.5, 0.8)}}, "cylinder.stroke"),
        ({"parameters": {"valve.c": 1.0}}, "valve.c"),
    ],
)
def test_bad_tasks_are_refused(task: dict[str, object], word: str) -> None:
    with pytest.raises(ValueError, match=word):
        gymnasium.make(NAME, **task)
