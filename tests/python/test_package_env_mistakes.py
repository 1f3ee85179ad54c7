"""Environments refuse what cannot be meant, and can be copied."""

from __future__ import annotations

import copy
import pickle
from typing import Any

import gymnasium
import numpy as np
import pneumatic_servo  # noqa: F401 - it makes the environments known
import pytest
from pneumatic_servo.envs import Positioning, VectorPositioning

NAME = "pneumatic_servo/Positioning-v0"


@pytest.mark.parametrize(("task", "told"), [
    ({"laws": []}, "laws is empty"),
    ({"law": "LuGre", "laws": ["Dahl"]}, "given twice, by laws and by law"),
    ({"law": "LuGre", "parameters": {"friction.law": "Dahl"}}, "given twice, by law and by friction.law"),
    ({"parameters": {"position0": 0.2}}, "position0 is refused: each episode draws where it begins"),
    ({"parameters": {"valveVoltage": 6.0}}, "valveVoltage is refused: actions are the voltage"),
    ({"duration": 5e-4}, "duration = 0.0005 s is refused: it is less than a period of 0.001 s"),
    ({"period": 1, "duration": 1500}, "period = 1 s is refused: .* milliseconds are '1 ms'"),
    ({"effort": -1.0}, "effort = -1.0 is refused"),
    ({"targets": ("0.1", "0.4")}, r"targets: the text '0\.1' has no unit; write 0\.1 or '0\.1 m'"),
])  # fmt: skip
def test_tasks_that_contradict_themselves_are_refused(task: dict[str, Any], told: str) -> None:
    with pytest.raises(ValueError, match=told):
        gymnasium.make(NAME, **task)


@pytest.mark.parametrize("action", [[[0.5]], [0.5, 0.5], "0.5", [np.nan], [True]])
def test_actions_of_another_kind_are_refused(action: object) -> None:
    environment = Positioning()
    environment.reset(seed=1)
    with pytest.raises(ValueError, match="action"):
        environment.step(action)  # type: ignore[arg-type]


def test_target_as_text_is_refused() -> None:
    with pytest.raises(ValueError, match=r"target = '0.3' is refused"):
        Positioning().reset(options={"target": "0.3"})


@pytest.mark.parametrize("copied", [copy.deepcopy, lambda environment: pickle.loads(pickle.dumps(environment))])
def test_copy_of_an_environment_goes_on_with_the_same_bits(copied: Any) -> None:
    single = Positioning(laws=["LuGre", "Stribeck"], ranges={"mass.moving": (0.8, 1.6)}, duration=0.05)
    several = VectorPositioning(3, laws=["LuGre", "Stribeck"], duration=0.02)
    for environment, action in ((single, np.array([0.4])), (several, np.full((3, 1), 0.4))):
        environment.reset(seed=3)
        for _ in range(10):
            environment.step(action)
        other = copied(environment)
        for _ in range(30):
            assert np.array_equal(environment.step(action)[0], other.step(action)[0])
        assert np.array_equal(environment.reset()[0], other.reset()[0])


def test_specification_tells_the_steps_of_an_episode() -> None:
    environment = gymnasium.make(NAME, duration=0.02)
    assert environment.spec is not None and environment.spec.max_episode_steps == 20
    assert gymnasium.make(NAME, duration=3.0).unwrapped.spec.max_episode_steps == 3000  # type: ignore[union-attr]
    again = gymnasium.make(environment.spec)
    again.reset(seed=1)
    ends = [again.step(again.action_space.sample())[3] for _ in range(20)]
    assert ends == [False] * 19 + [True]
