"""Positioning environments of Gymnasium: a single plant, and many that are stepped together."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from reprlib import repr as shortened
from typing import Any

import gymnasium
import numpy as np
from gymnasium import spaces
from gymnasium.error import ResetNeeded
from gymnasium.vector import AutoresetMode, VectorEnv
from numpy.typing import NDArray

from pneumatic_servo import _native
from pneumatic_servo.checks import names, whole_number
from pneumatic_servo.constant_voltage import AtRest
from pneumatic_servo.constant_voltage import check as check_at_rest
from pneumatic_servo.envs.arm import Arm
from pneumatic_servo.envs.drawing import Drawing, Frame, Window
from pneumatic_servo.envs.task import MASS, OBSERVED, Array, Task, observations, rewards, voltages
from pneumatic_servo.model import Model
from pneumatic_servo.names import did_you_mean
from pneumatic_servo.sensitivities import Transition
from pneumatic_servo.simulation import SavedState, Simulation
from pneumatic_servo.tasks import available_cores
from pneumatic_servo.units import has_unit
from pneumatic_servo.values import number_in, value_of
from pneumatic_servo.variables import Value

Observation = NDArray[np.float32]
OPTIONS = ("target",)
"""Options of a reset; of many plants also the mask of plants to restart."""
MASK = "reset_mask"
FPS = 25
"""Pictures per second of the plant's time."""


def action_space() -> Any:
    """Return the space of actions: one for each environment, since spaces have seeds."""
    return spaces.Box(-1.0, 1.0, (1,), np.float32)


def observation_space() -> Any:
    """Return the space of observations: one for each environment."""
    # Nothing legal leads further: the end stops yield by millimetres, and supplies beyond 100 bar are no pneumatics.
    return spaces.Box(
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

    Examples
    --------
    >>> import pneumatic_servo.envs as envs
    >>> environment = envs.Positioning(law="LuGre", duration=0.5)
    >>> observation, _ = environment.reset(seed=1)
    >>> observation, reward, terminated, truncated, _ = environment.step(environment.action_space.sample())
    >>> observation.shape, reward <= 0.0, terminated
    ((5,), True, False)
    """

    metadata: dict[str, Any] = {"render_modes": ["human", "rgb_array"], "render_fps": FPS}  # noqa: RUF012 - as declared

    def __init__(self, render_mode: str | None = None, **task: Any) -> None:
        self.render_mode = _render_mode(render_mode, self.metadata)
        self.action_space = action_space()
        self.observation_space = observation_space()
        self._fleet = _Fleet(Task.of(task), 1, 1)
        self._begun = False
        self._drawing: Drawing | None = None
        self._window: Window | None = None
        self._drawn = 0

    def __setattr__(self, name: str, value: Any) -> None:
        # Gymnasium gives it the specification of all environments of the name, which knows no duration.
        if name == "spec" and value is not None:
            value = replace(value, max_episode_steps=self._fleet.task.steps)
        super().__setattr__(name, value)

    def reset(
        self, *, seed: int | None = None, options: Mapping[str, Any] | None = None
    ) -> tuple[Observation, dict[str, Any]]:
        """Begin an episode; a seed makes it and those after it reproducible, bit for bit.

        ``options={"target": 0.3}`` asks for a target in m, within the stroke.
        """
        targets = self._fleet.asked(options, OPTIONS)
        super().reset(seed=_seed(seed))
        self._fleet.restart({0: self.np_random}, targets)
        self._begun = True
        seen = self._fleet.observe()[0]
        self._drawn = -1
        self._show()
        return seen, self._info()

    def step(self, action: NDArray[np.float32]) -> tuple[Observation, float, bool, bool, dict[str, Any]]:
        """Hold an action for one period."""
        if not self._begun:
            raise ResetNeeded("step was called before reset")
        seen, reward = self._fleet.step(_actions("action", action, [(1,), ()]))
        self._show()
        return seen[0], float(reward[0]), False, bool(self._fleet.is_over()[0]), self._info()

    def render(self) -> Any:
        """Return a picture of shape (180, 640, 3) with ``rgb_array``; with ``human`` there is a window, and no need."""
        if self.render_mode != "rgb_array":
            return None
        if not self._begun:
            raise ResetNeeded("render was called before reset")
        self._drawing = Drawing() if self._drawing is None else self._drawing
        self._fleet.draw(self._drawing, 0)
        return self._drawing.frame()

    def __getstate__(self) -> dict[str, Any]:
        # A copy draws into a window of its own.
        return {**self.__dict__, "_window": None, "_drawing": None}

    def close(self) -> None:
        """Close the window, if there is one."""
        if self._window is not None:
            self._window.close()
            self._window = None

    def _show(self) -> None:
        """Move the window on, as often as a screen shows it."""
        frame = int(self._fleet.counts[0] * self._fleet.task.period * FPS)
        if self.render_mode != "human" or frame == self._drawn:
            return
        self._drawn = frame
        self._window = Window() if self._window is None else self._window
        self._fleet.draw(self._window.drawing, 0)
        self._window.update()

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

    Examples
    --------
    >>> import pneumatic_servo.envs as envs
    >>> fleet = envs.VectorPositioning(8, laws=["Stribeck", "LuGre"], ranges={"supplyPressure": ("5 bar", "7 bar")})
    >>> observations, _ = fleet.reset(seed=1)
    >>> observations, rewards, *_ = fleet.step(fleet.action_space.sample())
    >>> observations.shape, rewards.shape
    ((8, 5), (8,))
    """

    metadata: dict[str, Any] = {  # noqa: RUF012
        "render_modes": ["rgb_array"], "render_fps": FPS, "autoreset_mode": AutoresetMode.NEXT_STEP,
    }  # fmt: skip

    def __init__(
        self, num_envs: int = 1, render_mode: str | None = None, workers: int | None = None, **task: Any
    ) -> None:
        self.num_envs = whole_number("num_envs", num_envs, least=1)
        threads = available_cores() if workers is None else whole_number("workers", workers, least=1)
        self.render_mode = _render_mode(render_mode, self.metadata)
        self.single_action_space = action_space()
        self.single_observation_space = observation_space()
        self.action_space = gymnasium.vector.utils.batch_space(self.single_action_space, self.num_envs)
        self.observation_space = gymnasium.vector.utils.batch_space(self.single_observation_space, self.num_envs)
        self._fleet = _Fleet(Task.of(task), self.num_envs, threads)
        self._randoms: list[np.random.Generator] = []
        self._drawings: list[Drawing] = []

    def reset(
        self, *, seed: int | Sequence[int | None] | None = None, options: Mapping[str, Any] | None = None
    ) -> tuple[Observation, dict[str, Any]]:
        """Begin an episode of every plant; a seed counts up from plant to plant, or there is one for each.

        ``options={"target": ...}`` asks for targets in m, one for all or one for each; ``{"reset_mask": ...}`` of shape
        (num_envs,) says which plants begin anew, the others go on.
        """
        chosen = self._chosen(options)
        targets = self._fleet.asked(options, (*OPTIONS, MASK))
        seeds = self._seeds(seed)
        if not self._randoms:
            self._randoms = [np.random.default_rng(own) for own in seeds]
        elif seed is not None:
            for index in chosen:
                self._randoms[index] = np.random.default_rng(seeds[index])
        self._fleet.restart({index: self._randoms[index] for index in chosen}, targets)
        return self._fleet.observe(), self._info()

    def _seeds(self, given: int | Sequence[int | None] | None) -> list[int | None]:
        if given is None:
            return [None] * self.num_envs
        if isinstance(given, Sequence | np.ndarray):
            if len(given) != self.num_envs:
                raise ValueError(f"seed has {len(given)} numbers, but there are {self.num_envs} plants")
            return [_seed(own) for own in given]
        first = whole_number("seed", given, least=0)
        return [first + index for index in range(self.num_envs)]

    def _chosen(self, options: Mapping[str, Any] | None) -> list[int]:
        """Return which plants begin anew."""
        mask = (options or {}).get(MASK)
        if mask is None:
            return list(range(self.num_envs))
        mask = np.asarray(mask)
        if mask.shape != (self.num_envs,) or mask.dtype != np.bool_:
            raise ValueError(f"options: {MASK} must be true or false for each of {self.num_envs} plants, not {mask!r}")
        if not mask.all() and not self._randoms:
            raise ResetNeeded("a part of the plants cannot begin anew before all have begun")
        return [int(index) for index in np.flatnonzero(mask)]

    def step(
        self, actions: NDArray[np.float32]
    ) -> tuple[Observation, NDArray[Any], NDArray[Any], NDArray[Any], dict[str, Any]]:
        """Hold each plant's action for one period, or begin its next episode."""
        if not self._randoms:
            raise ResetNeeded("step was called before reset")
        over = self._fleet.is_over()
        seen, reward = self._fleet.step(_actions("actions", actions, [(self.num_envs, 1), (self.num_envs,)]))
        if over.any():
            self._fleet.restart({int(index): self._randoms[index] for index in np.flatnonzero(over)})
            seen = self._fleet.observe()
            reward = np.where(over, 0.0, reward)
        never = np.zeros(self.num_envs, dtype=np.bool_)
        return seen, reward, never, self._fleet.is_over(), self._info()

    def transitions(
        self,
        actions: NDArray[np.float32],
        *,
        parameters: Sequence[str] = (),
        outputs: Sequence[str] = (),
        at_rest: AtRest = "mean",
    ) -> list[tuple[Transition, ...]]:
        """Return the transition of the next period under actions, exact through stick and slip.

        The plants stay where they are; `step` with the same actions makes these very steps, unless an episode is over.

        Parameters
        ----------
        actions : ndarray of shape (num_envs, 1)
            As for `step`.
        parameters, outputs, at_rest
            As for `pneumatic_servo.Simulation.transition`.

        Returns
        -------
        list of tuple of Transition
            For each plant a transition for each of its ``substeps``, in SI units: what changes with the voltage does so
            per V, and an action of 1 is 5 V. States differ from law to law, and so do shapes.

        Raises
        ------
        ValueError
            For a name that is none of these.
        SimulationError
            When the solver cannot go on; it tells which plant is meant, by its number.
        """
        if not self._randoms:
            raise ResetNeeded("transitions was called before reset")
        check_at_rest(at_rest)
        by, of = names("parameters", parameters), names("outputs", outputs)
        given = _actions("actions", actions, [(self.num_envs, 1), (self.num_envs,)])
        return self._fleet.transitions(given, by, of, at_rest)

    def render(self) -> tuple[Frame, ...] | None:
        """Return a picture of each plant, as in `Positioning`, with ``rgb_array``."""
        if self.render_mode is None:
            return None
        if not self._randoms:
            raise ResetNeeded("render was called before reset")
        self._drawings = self._drawings or [Drawing() for _ in range(self.num_envs)]
        for index, drawing in enumerate(self._drawings):
            self._fleet.draw(drawing, index)
        return tuple(drawing.frame() for drawing in self._drawings)

    def __getstate__(self) -> dict[str, Any]:
        return {**self.__dict__, "_drawings": []}

    def _info(self) -> dict[str, Any]:
        info: dict[str, Any] = {"target": self._fleet.targets.copy(), "_target": np.ones(self.num_envs, dtype=np.bool_)}
        for name in self._fleet.settings[0]:
            info[name] = np.array([own[name] for own in self._fleet.settings])
            info[f"_{name}"] = np.ones(self.num_envs, dtype=np.bool_)
        return info


def _render_mode(given: str | None, metadata: Mapping[str, Any]) -> str | None:
    """Return a known way to draw."""
    known = metadata["render_modes"]
    if given is not None and given not in known:
        raise ValueError(f"render_mode = {given!r} is refused: it must be None or {' or '.join(map(repr, known))}")
    return given


def _actions(argument: str, given: Any, shapes: Sequence[tuple[int, ...]]) -> Array:
    """Return actions as a vector; refuse another shape, or values that are not numbers."""
    try:
        actions = np.asarray(given, dtype=np.float64)
    except (TypeError, ValueError):
        actions = np.array([np.nan])
    if isinstance(given, str) or np.asarray(given).dtype.kind not in "fiu" or np.isnan(actions).any():
        raise ValueError(f"{argument} = {shortened(given)} is refused: it must be numbers from -1 to 1")
    if actions.shape not in shapes:
        raise ValueError(f"{argument} has the shape {actions.shape} and is refused: it must have the shape {shapes[0]}")
    return actions.reshape(-1)


def _seed(given: int | None) -> int | None:
    """Return a seed, of NumPy's numbers too, as Gymnasium takes it."""
    return None if given is None else whole_number("seed", given, least=0)


class _Fleet:
    """Plants with their targets, and how far their episodes have come."""

    def __init__(self, task: Task, number: int, workers: int) -> None:
        model = Model("PneumaticServoCylinder")
        task = task.in_si(model)
        task.check(model)
        self.task = task
        task.tell(model)
        self.stroke = task.stroke(model)
        self.mass = float(
            value_of(model.variables, MASS, task.settings(model).get(MASS, model.parameters[MASS].default))
        )
        self.inputs = list(model.inputs)
        self.number, self.workers = number, workers
        self.native = self._plants(model)
        self.pushes = np.full(number, np.nan)
        """Force of an arm on each carriage at the last step in N, NaN before the first."""
        self.targets = np.zeros(number)
        self.settings: list[dict[str, Any]] = [{} for _ in range(number)]
        self.counts = np.zeros(number, dtype=np.int64)

    def _plants(self, model: Model) -> _native.Fleet:
        common = self._loaded(list(self.task.settings(model).items()))
        observed = OBSERVED if self.task.arm is None else [*OBSERVED, "acceleration"]
        return _native.Fleet(model._native, self.number, common, "valveVoltage", observed, self.workers)

    def _loaded(self, settings: list[tuple[str, Value]]) -> list[tuple[str, Value]]:
        """Return settings whose moving mass includes the level arm."""
        arm = self.task.arm
        if arm is None:
            return settings
        return [(name, float(value) + arm.reflected if name == MASS else value) for name, value in settings]

    def __getstate__(self) -> dict[str, Any]:
        states = [state.to_bytes() for state in self.native.save()]
        return {**self.__dict__, "native": states}

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__dict__.update(state)
        states = [_native.SavedState.from_bytes(data) for data in state["native"]]
        self.native = self._plants(Model("PneumaticServoCylinder"))
        self.native.restart([(index, self._loaded(list(own.items()))) for index, own in enumerate(self.settings)])
        self.native.restore(states)

    def asked(self, options: Mapping[str, Any] | None, known: Sequence[str]) -> Array | None:
        """Return the given targets in m, if any; unknown options are refused."""
        for name in options or {}:
            if name not in known:
                raise ValueError(
                    f"options: there is no {name}{did_you_mean(str(name), known)}; there is {', '.join(known)}"
                )
        given = (options or {}).get("target")
        if given is None:
            return None
        if has_unit(given):
            given = number_in("m", "options: target", given)
        elif isinstance(given, list):
            given = [number_in("m", "options: target", one) for one in given]
        try:
            if np.asarray(given).dtype.kind not in "fiu":
                raise TypeError
            targets = np.broadcast_to(np.asarray(given, dtype=float), self.targets.shape)
        except (TypeError, ValueError):
            raise ValueError(f"options: target = {given!r} is refused: it must be one in m, or one per plant") from None
        if not ((targets >= 0.0) & (targets <= self.stroke)).all():
            raise ValueError(
                f"options: target = {given} is refused: it must be within the stroke, 0 to {self.stroke:g} m"
            )
        return targets

    def restart(self, randoms: Mapping[int, np.random.Generator], targets: Array | None = None) -> None:
        """Draw and begin episodes of some plants, of which targets may be asked for."""
        fresh = []
        for index, random in randoms.items():
            drawn, settings = self.task.draw(random)
            self.targets[index] = drawn if targets is None else targets[index]
            self.settings[index] = dict(settings)
            self.counts[index] = 0
            self.pushes[index] = np.nan
            fresh.append((index, self._loaded(settings)))
        self.native.restart(fresh)

    def observe(self) -> Observation:
        """Observe all plants."""
        return observations(self.stroke, self.native.observe(), self.targets)

    def step(self, actions: Array) -> tuple[Observation, Array]:
        """Hold actions for one period; return observations and rewards."""
        task = self.task
        size, count = task.period / task.substeps, task.substeps
        if task.arm is None:
            seen = self.native.step(voltages(actions), size, count)
        else:
            for _ in range(count):
                self._push(task.arm)
                seen = self.native.step(voltages(actions), size, 1)
        self.counts += 1
        return observations(self.stroke, seen, self.targets), rewards(task, seen, self.targets, actions)

    def _push(self, arm: Arm) -> None:
        """Let an arm push each carriage over the next step, with the force that it has in the middle of it.

        The plant has the mass of the level arm; what the arm has more or less, and its weight, are external forces.
        """
        seen = self.native.observe()
        resting, against = arm.resistance(seen[:, 0], seen[:, 1])
        more = resting - arm.reflected
        self.native.set("externalForce", -against)
        # Without the inertia of `more`; a carriage that this force does not move rests.
        acceleration = self.native.observe()[:, 4]
        mass = np.array([own.get(MASS, self.mass) for own in self.settings], dtype=np.float64) + arm.reflected
        push = -against - more * acceleration * mass / (mass + more)
        self.native.set("externalForce", push + np.where(np.isnan(self.pushes), 0.0, 0.5 * (push - self.pushes)))
        self.pushes = push

    def transitions(
        self, actions: Array, by: list[str], of: list[str], at_rest: AtRest
    ) -> list[tuple[Transition, ...]]:
        """Return the transitions of a period under actions, substep by substep."""
        if self.task.arm is not None:
            raise ValueError("transitions is refused: a plant with an arm has none, since the arm is beside it")
        size, count = self.task.period / self.task.substeps, self.task.substeps
        told = self.native.transitions(voltages(actions), size, count, by, of)
        found = [tuple(Transition._of(step, self.inputs, by, of) for step in steps) for steps in told]
        resting = [index for index, steps in enumerate(found) if any(step.lost for step in steps)]
        if at_rest == "refuse" or not resting:
            return found
        # Each of these alone, since it is made again with a little more voltage, and with less.
        model, states = Model("PneumaticServoCylinder"), self.native.save()
        for index in resting:
            settings = {**self.task.settings(model), **self.settings[index]}
            alone = Simulation(model._native.start(list(settings.items()), 0.0), model, settings)
            alone.restore(SavedState(states[index]))
            alone.set_one("valveVoltage", float(voltages(actions)[index]))
            found[index] = tuple(
                alone.transition(size, parameters=by, outputs=of, at_rest=at_rest) for _ in range(count)
            )
        return found

    def draw(self, drawing: Drawing, index: int) -> None:
        """Draw a plant as it is."""
        law = self.settings[index].get("friction.law", self.task.law)
        drawing.show(self.stroke, self.native.observe()[index, : len(OBSERVED)], float(self.targets[index]), str(law))

    def is_over(self) -> NDArray[np.bool_]:
        """Whether each episode has come to its end."""
        return np.asarray(self.counts >= self.task.steps)
