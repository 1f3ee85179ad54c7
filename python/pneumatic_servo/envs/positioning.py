"""Positioning environments of Gymnasium: a single plant, and many that are stepped together."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import gymnasium
import numpy as np
from gymnasium import spaces
from gymnasium.vector import AutoresetMode, VectorEnv
from numpy.typing import NDArray

from pneumatic_servo import _native
from pneumatic_servo.checks import whole_number
from pneumatic_servo.envs.task import OBSERVED, Array, Task, observations, rewards, voltages
from pneumatic_servo.model import Model, available_cores

Observation = NDArray[np.float32]
ACTION = spaces.Box(-1.0, 1.0, (1,), np.float32)
# No legal parameters lead further: the end stops yield by millimetres, and supplies beyond 100 bar are no pneumatics.
OBSERVATION = spaces.Box(
    np.array([-2.0, -1.0, -50.0, 0.0, 0.0], dtype=np.float32),
    np.array([2.0, 2.0, 50.0, 10.0, 10.0], dtype=np.float32),
)


class Positioning(gymnasium.Env[Observation, NDArray[np.float32]]):
    """Move the carriage to a target and keep it there, with the valve voltage as the action.

    An action of shape (1,) from -1 to 1 is a voltage from 0 to 10 V. An observation of shape (5,) is the error and
    the position in units of the stroke, the velocity in m/s and both pressures in 10 bar. The reward of a step is
    ``-|error| / 0.1 m - effort * action^2``. Episodes are truncated after ``duration`` and never terminate.

    Parameters
    ----------
    **task
        The fields of `Task`, for example ``law="LuGre"`` or ``laws=[...]`` and ``ranges={...}``.
    """

    metadata: dict[str, Any] = {"render_modes": []}  # noqa: RUF012 - as Gymnasium declares it

    def __init__(self, render_mode: str | None = None, **task: Any) -> None:
        self.render_mode = render_mode
        self.action_space = ACTION
        self.observation_space = OBSERVATION
        self._fleet = _Fleet(Task(**task), 1, 1)

    def reset(
        self, *, seed: int | None = None, options: Mapping[str, Any] | None = None
    ) -> tuple[Observation, dict[str, Any]]:
        """Begin an episode; a seed makes it and those after it reproducible, bit for bit."""
        super().reset(seed=seed)
        self._fleet.restart({0: self.np_random})
        return self._fleet.observe()[0], self._info()

    def step(self, action: NDArray[np.float32]) -> tuple[Observation, float, bool, bool, dict[str, Any]]:
        """Hold an action for one period."""
        seen, reward = self._fleet.step(np.asarray(action, dtype=np.float64).reshape(1))
        return seen[0], float(reward[0]), False, bool(self._fleet.is_over()[0]), self._info()

    def _info(self) -> dict[str, Any]:
        return {"target": float(self._fleet.targets[0]), **self._fleet.settings[0]}


class VectorPositioning(VectorEnv[Observation, NDArray[np.float32], NDArray[Any]]):
    """Many plants that are stepped together on all cores; each as in `Positioning`.

    Actions have the shape (num_envs, 1), observations (num_envs, 5). An episode that is over begins anew at the next
    step, whose action it does not use.

    Parameters
    ----------
    num_envs : int
        Number of plants.
    workers : int, optional
        Number of threads; by default one per core that this process may use.
    **task
        The fields of `Task`.
    """

    metadata: dict[str, Any] = {"render_modes": [], "autoreset_mode": AutoresetMode.NEXT_STEP}  # noqa: RUF012

    def __init__(
        self, num_envs: int = 1, render_mode: str | None = None, workers: int | None = None, **task: Any
    ) -> None:
        self.num_envs = whole_number("num_envs", num_envs, least=1)
        threads = available_cores() if workers is None else whole_number("workers", workers, least=1)
        self.render_mode = render_mode
        self.single_action_space = ACTION
        self.single_observation_space = OBSERVATION
        self.action_space = gymnasium.vector.utils.batch_space(ACTION, num_envs)
        self.observation_space = gymnasium.vector.utils.batch_space(OBSERVATION, num_envs)
        self._fleet = _Fleet(Task(**task), num_envs, threads)
        self._randoms: list[np.random.Generator] = []

    def reset(
        self, *, seed: int | Sequence[int | None] | None = None, options: Mapping[str, Any] | None = None
    ) -> tuple[Observation, dict[str, Any]]:
        """Begin an episode of every plant; a seed counts up from plant to plant."""
        if seed is not None or not self._randoms:
            seeds = [seed + index for index in range(self.num_envs)] if isinstance(seed, int) else seed
            self._randoms = [np.random.default_rng(own) for own in seeds or [None] * self.num_envs]
        self._fleet.restart(dict(enumerate(self._randoms)))
        return self._fleet.observe(), self._info()

    def step(
        self, actions: NDArray[np.float32]
    ) -> tuple[Observation, NDArray[Any], NDArray[Any], NDArray[Any], dict[str, Any]]:
        """Hold each plant's action for one period, or begin its next episode."""
        over = self._fleet.is_over()
        seen, reward = self._fleet.step(np.asarray(actions, dtype=np.float64).reshape(self.num_envs))
        if over.any():
            self._fleet.restart({int(index): self._randoms[index] for index in np.flatnonzero(over)})
            seen = self._fleet.observe()
            reward = np.where(over, 0.0, reward)
        never = np.zeros(self.num_envs, dtype=np.bool_)
        return seen, reward, never, self._fleet.is_over(), self._info()

    def _info(self) -> dict[str, Any]:
        return {"target": self._fleet.targets.copy(), "_target": np.ones(self.num_envs, dtype=np.bool_)}


class _Fleet:
    """Plants with their targets, and how far their episodes have come."""

    def __init__(self, task: Task, number: int, workers: int) -> None:
        task.check()
        self.task = task
        model = Model("PneumaticServoCylinder")
        self.stroke = float(task.parameters.get("cylinder.stroke", model.parameters["cylinder.stroke"].default or 1.0))
        self.native = _native.Fleet(model._native, number, task.settings(), "valveVoltage", OBSERVED, workers)
        self.targets = np.zeros(number)
        self.settings: list[dict[str, Any]] = [{} for _ in range(number)]
        self.counts = np.zeros(number, dtype=np.int64)

    def restart(self, randoms: Mapping[int, np.random.Generator]) -> None:
        """Draw and begin episodes of some plants."""
        fresh = []
        for index, random in randoms.items():
            self.targets[index], settings = self.task.draw(random)
            self.settings[index] = dict(settings)
            self.counts[index] = 0
            fresh.append((index, settings))
        self.native.restart(fresh)

    def observe(self) -> Observation:
        """Observe all plants."""
        return observations(self.stroke, self.native.observe(), self.targets)

    def step(self, actions: Array) -> tuple[Observation, Array]:
        """Hold actions for one period; return observations and rewards."""
        task = self.task
        seen = self.native.step(voltages(actions), task.period / task.substeps, task.substeps)
        self.counts += 1
        return observations(self.stroke, seen, self.targets), rewards(task, seen, self.targets, actions)

    def is_over(self) -> NDArray[np.bool_]:
        """Whether each episode has come to its end."""
        return np.asarray(self.counts >= self.task.steps)
