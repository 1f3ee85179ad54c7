"""Runs in a closed loop: a controller sees the outputs at its samples and sets inputs."""

from __future__ import annotations

import copy
from collections import deque
from collections.abc import Callable, Iterator, Mapping, Sequence
from reprlib import repr as shortened
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pneumatic_servo import values
from pneumatic_servo.checks import mapping
from pneumatic_servo.errors import warn
from pneumatic_servo.grid import Grid
from pneumatic_servo.model_description import ModelDescription
from pneumatic_servo.names import did_you_mean
from pneumatic_servo.run_errors import SimulationError
from pneumatic_servo.simulation import Simulation
from pneumatic_servo.variables import Value, Variables

Array = NDArray[np.float64]
Controller = Any
"""A function of the time in s and a mapping of the plant's variables, which returns inputs by name, or the value of the
plant's first input; or the name of a model that is a controller, ``"PositionController"``, or the pair of such a name
and its parameters. Inputs that only a controller has, such as ``referencePosition``, are given among the inputs."""


class Measured(Mapping[str, float]):
    """The plant's variables at a sample: its outputs are listed, any other can be asked for."""

    def __init__(self, plant: Simulation, outputs: Sequence[str]) -> None:
        self._plant, self._outputs = plant, outputs

    def __getitem__(self, name: str) -> float:
        return self._plant.get_one(name)

    def __iter__(self) -> Iterator[str]:
        return iter(self._outputs)

    def __len__(self) -> int:
        return len(self._outputs)


class OfModel:
    """A model of the library as a controller; it is started at its first sample."""

    def __init__(self, model: ModelDescription, parameters: Mapping[str, Value], period: float) -> None:
        self._model, self._parameters, self._period = model, dict(parameters), period
        self._running: Simulation | None = None

    def __call__(self, now: Mapping[str, float], measured: Mapping[str, float], shared: Sequence[str],
                 driven: Sequence[str]) -> dict[str, float]:  # fmt: skip
        """Return the plant's inputs after a sample."""
        seen = {**{name: measured[name] for name in self._model.inputs if name in shared}, **now}
        if self._running is None:
            native = self._model._native.start([*{**self._parameters, **seen}.items()], 0.0)
            self._running = Simulation(native, self._model, self._parameters)
        self._running._put(seen)
        self._running.step(self._period)
        return {name: self._running.get_one(name) for name in driven}


class Loop:
    """A controller in its loop: the inputs that it sets, with their steps."""

    def __init__(
        self, model: ModelDescription, controller: Controller, grid: Grid, period: float | None, delay: float
    ) -> None:
        self.period = grid.step if period is None else values.seconds("period", period)
        self.samples = _steps("period", self.period, grid.step, least=1)
        self.delay = _steps("delay", values.seconds("delay", delay), grid.step, least=0)
        self.model, self.grid = model, grid
        whole = grid.count * grid.step
        for argument, value in (("period", self.period), ("delay", self.delay * grid.step)):
            if grid.count and value >= whole and (argument == "delay" or value > whole):
                warn(f"{argument} = {value:g} s: the run ends after {whole:g} s, before the controller acts for it")
        self.of_model: OfModel | None = None
        self.own_inputs: Variables | None = None
        self.controller = controller
        name, parameters = controller if isinstance(controller, tuple) and len(controller) == 2 else (controller, {})
        if isinstance(name, str):
            other = ModelDescription(name)
            self.driven = [output for output in other.outputs if output in model.inputs]
            if not self.driven:
                raise ValueError(
                    f"controller = {name!r} is refused: {', '.join(other.outputs)} are no inputs of {model.name}"
                )
            given = values.settings("controller", other.variables, mapping("controller", parameters))
            if "sampleTime" in other.parameters:
                given.setdefault("sampleTime", self.period)
            self.of_model = OfModel(other, given, self.period)
            self.own_inputs = Variables(v for v in other.inputs.values() if v.name not in model.inputs)
        elif not callable(controller):
            raise TypeError(
                f"controller must be a function of time and outputs, or a model's name, not {shortened(controller)}"
            )

    def run(
        self, start: Callable[[Mapping[str, float]], Simulation], driven: Mapping[str, Array], own: Mapping[str, Array],
        outputs: Sequence[str], tell: Callable[[int], object] | None,
    ) -> tuple[Array, Array, dict[str, Array], BaseException | None]:  # fmt: skip
        """Return times, values, the inputs of each step, and the error that ended the run early.

        `driven` are the plant's inputs at each step, `own` the controller's.
        """
        grid = self.grid
        # Until the first sample is taken, which the plant then starts with, as in a replay of a record.
        first = {name: float(course[0]) for name, course in driven.items() if grid.count}
        plant = start(first)
        controller = copy.deepcopy(self.of_model or self.controller)
        every = self.grid.every
        measured = Measured(plant, list(self.model.outputs))
        pending: deque[tuple[int, dict[str, float]]] = deque()
        rows = [plant.get(outputs)]
        history = {name: np.empty(grid.count) for name in self.model.inputs}
        ended: BaseException | None = None
        reached = 0
        try:
            for index in range(grid.count):
                for name, course in driven.items():
                    plant.set_one(name, float(course[index]))
                if index % self.samples == 0:
                    time = grid.start + index * grid.step
                    made = self._sample(controller, time, measured, {name: float(c[index]) for name, c in own.items()})
                    self._check(made, driven, time)
                    pending.append((index + self.delay, made))
                due: dict[str, float] = {}
                while pending and pending[0][0] <= index:
                    due |= pending.popleft()[1]
                if index == 0:
                    plant = start({**first, **due})
                    measured = Measured(plant, list(self.model.outputs))
                    rows[0] = plant.get(outputs)
                for name, value in due.items():
                    plant.set_one(name, value)
                for name, course in history.items():
                    course[index] = plant.get_one(name)
                # Each step ends at its point plus its size, as in runs without a controller.
                plant.step(index * grid.step + grid.start + grid.step - plant.time)
                reached = index + 1
                if reached % every == 0 or reached == grid.count:
                    rows.append(plant.get(outputs))
                if tell is not None and reached % 1000 == 0:
                    tell(reached)
        except (SimulationError, KeyboardInterrupt) as error:
            ended = error
        found = np.array(rows).T.reshape(len(outputs), len(rows))
        return grid.times()[: len(rows)], found, {name: c[:reached] for name, c in history.items()}, ended

    def _sample(self, controller: Any, time: float, measured: Measured, own: Mapping[str, float]) -> dict[str, float]:
        if self.of_model is not None:
            return controller(own, measured, list(self.model.variables), self.driven)  # type: ignore[no-any-return]
        made = controller(time, measured)
        if made is None:
            return {}
        return dict(made) if isinstance(made, Mapping) else {next(iter(self.model.inputs)): made}

    def _check(self, made: dict[str, float], driven: Mapping[str, Array], time: float) -> None:
        for name, value in made.items():
            if name not in self.model.inputs:
                raise ValueError(
                    f"at t = {time:g} s the controller sets {name}, which is no input"
                    f"{did_you_mean(str(name), self.model.inputs)}; the inputs are {', '.join(self.model.inputs)}"
                )
            if name in driven:
                raise ValueError(f"{name} is given twice, among the inputs and by the controller")
            if self.model.inputs[name].kind == "boolean":
                made[name] = values.flag(self.model.inputs[name], value)
                continue
            if not values.is_number(value):
                raise ValueError(
                    f"at t = {time:g} s the controller sets {name} = {shortened(value)}: it must be a number"
                )
            made[name] = float(value)
            values.check_range(self.model.inputs[name], made[name], time)


def _steps(argument: str, duration: float, step: float, least: int) -> int:
    """Return how many communication steps a duration is."""
    count = round(duration / step)
    if count < least or abs(duration / step - count) > 1e-6:
        raise ValueError(
            f"{argument} = {duration:g} is refused: it must be a whole number of steps of {step:g} s, at least {least}"
        )
    return count
