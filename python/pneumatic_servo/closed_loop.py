"""Runs in a closed loop: a controller sees the outputs at its samples and sets inputs."""

from __future__ import annotations

import math
import pickle
from collections import deque
from collections.abc import Callable, Container, Iterator, Mapping, Sequence
from dataclasses import dataclass
from reprlib import repr as shortened
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pneumatic_servo import _native, values
from pneumatic_servo.checks import mapping, names
from pneumatic_servo.errors import Refused, warn
from pneumatic_servo.fmu import FmuModel
from pneumatic_servo.fresh import described, fresh
from pneumatic_servo.grid import Grid
from pneumatic_servo.model_description import ModelDescription
from pneumatic_servo.names import did_you_mean
from pneumatic_servo.run_errors import SimulationError
from pneumatic_servo.simulation import Simulation
from pneumatic_servo.solver_log import COUNTERS, Logged
from pneumatic_servo.variables import Unit, Value, Variable, Variables

Array = NDArray[np.float64]
Record = Sequence[str] | Mapping[str, str]
"""Names of what a controller returns beside inputs, or these with their units."""
Controller = Any
"""A function of the time in s and a mapping of the plant's variables, which returns inputs by name, or the value of the
plant's first input; or the name of a model that is a controller, ``"PositionController"``, or the pair of such a name
and its parameters. Inputs that only a controller has, such as ``referencePosition``, are given among the inputs. Each
run has a controller of its own: see `fresh`."""


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
        self.model, self.parameters, self._period = model, dict(parameters), period
        self._running: Simulation | None = None
        self.variables = model.variables

    @property
    def running(self) -> Simulation | None:
        """The controller once it has taken a sample."""
        return self._running

    def __call__(self, now: Mapping[str, float], measured: Mapping[str, float], shared: Container[str],
                 driven: Sequence[str]) -> dict[str, float]:  # fmt: skip
        """Return the plant's inputs after a sample."""
        seen = {**{name: measured[name] for name in self.model.inputs if name in shared}, **now}
        if self._running is None:
            native = self.model._native.start([*{**self.parameters, **seen}.items()], 0.0)
            self._running = Simulation(native, self.model, self.parameters)
        self._running._put(seen)
        self._running.step(self._period)
        return {name: self._running.get_one(name) for name in driven}


@dataclass(frozen=True)
class LoopRun:
    """A run in a closed loop.

    Attributes
    ----------
    times : ndarray of shape (rows,)
        Times in s.
    values : ndarray of shape (variables, rows)
        Recorded outputs of the plant; what the controller records is behind them.
    held : dict
        Inputs of the plant over each step, of shape (steps,).
    controller : object
        The controller in its final state.
    ended : exception or None
        The error that ended the run early.
    noticed : list of tuple
        Warnings of the plant: variable, value and remark.
    log : tuple or None
        Counters and events of the solver, if they were asked for.
    """

    times: Array
    values: Array
    held: dict[str, Array]
    controller: object
    ended: BaseException | None
    noticed: list[tuple[str, float, str]]
    log: Logged | None = None


def begun(model: ModelDescription, settings: Mapping[str, Value], time: float) -> Simulation:
    """Start a run with values in SI units, without warnings."""
    with model._with_units():
        return Simulation(model._native.start(list(settings.items()), time), model, settings)


class Loop:
    """A controller in its loop: the inputs that it sets, with their steps. It can be pickled."""

    def __init__(
        self, model: ModelDescription, controller: Controller, grid: Grid, period: float | None, delay: float,
        record: Record = (),
    ) -> None:  # fmt: skip
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
        self.record = self._noted(record)

    def _noted(self, record: Record) -> Variables:
        """Return the variables that the controller records beside the inputs that it sets."""
        units = dict(record) if isinstance(record, Mapping) else dict.fromkeys(names("record", record), "1")
        of_model = {} if self.of_model is None else self.of_model.variables
        for name, unit in units.items():
            if name in self.model.variables:
                raise ValueError(f"record: {name} is a variable of {self.model.name}; name it among the outputs")
            if self.of_model is not None and name not in of_model:
                raise ValueError(f"record: the controller has no variable {name}{did_you_mean(name, of_model)}")
            if not isinstance(unit, str):
                raise TypeError(f"record: the unit of {name} is {shortened(unit)}; it must be a text, such as 'm'")
        return Variables(
            of_model[name] if name in of_model else Variable(
                name=name, role="local", kind="real", unit=unit, default=None, minimum=None, maximum=None, nominal=None,
                shown=Unit(unit), items={}, ids={}, derivative_of=None, text="Recorded by the controller",
            )
            for name, unit in units.items()
        )  # fmt: skip

    def __getstate__(self) -> dict[str, object]:
        # cloudpickle would send closures, too, but gives each function a copy of the variables that they share.
        try:
            return {**self.__dict__, "controller": pickle.dumps(self.controller)}
        except (pickle.PicklingError, AttributeError, TypeError) as error:
            raise TypeError(
                f"controller = {shortened(self.controller)} cannot be sent to other processes ({error}): give a "
                "function of a module, or one without parameters that makes the controller, or an object of a class"
            ) from error

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__dict__.update(state, controller=pickle.loads(state["controller"]))

    @property
    def runs_beside(self) -> bool:
        """Whether plant and controller run side by side without a step through Python."""
        return self.of_model is not None and not self.model._is_fmu

    @property
    def native(self) -> tuple[Any, ...]:
        """The controller as the extension module takes it, behind its inputs over time, and its sampling."""
        assert self.of_model is not None
        measured = [name for name in self.of_model.model.inputs if name in self.model.variables]
        given = list(self.of_model.parameters.items())
        native = self.of_model.model._native
        if isinstance(native, FmuModel):
            native = native.library
        return native, given, measured, self.driven, list(self.record)

    @property
    def sampling(self) -> tuple[float, int, int]:
        """Period in s and in steps, and steps from a sample until it acts."""
        return self.period, self.samples, self.delay

    def refuse_twice(self, given: Mapping[str, object]) -> None:
        """Refuse inputs of the plant that a controller of the library sets."""
        twice = next((name for name in given if self.of_model is not None and name in self.driven), None)
        if twice is not None:
            raise ValueError(f"{twice} is given twice, among the inputs and by the controller")

    @property
    def text(self) -> str:
        """Controller and sampling, by which a resumed study is recognised."""
        return f"{described(self.controller)} {self.samples} {self.delay}"

    def run(
        self, settings: Mapping[str, Value], driven: Mapping[str, Array], own: Mapping[str, Array],
        outputs: Sequence[str], tell: Callable[[int], None] | None = None, *, logs: bool = False,
    ) -> LoopRun:  # fmt: skip
        """Make a run; a row has what the controller records of the last sample before it.

        Parameters
        ----------
        settings : mapping
            Parameters and start values of the plant.
        driven, own : mapping
            The plant's and the controller's inputs at each step, of shape (steps,).
        outputs : sequence of str
            Recorded variables of the plant.
        tell : callable, optional
            What is called with the number of finished steps.
        logs : bool
            Whether the solver's work is logged.
        """
        if self.runs_beside:
            return self._run_beside(settings, driven, own, outputs, tell, logs)
        grid = self.grid
        # Until the first sample is taken, which the plant then starts with, as in a replay of a record.
        first = {name: float(course[0]) for name, course in driven.items() if grid.count}
        plant = begun(self.model, {**settings, **first}, grid.start)
        noticed = plant._native.notices()
        controller = fresh(self.of_model or self.controller)
        every = self.grid.every
        measured = Measured(plant, list(self.model.outputs))
        pending: deque[tuple[int, dict[str, float]]] = deque()
        noted = dict.fromkeys(self.record, math.nan)

        def read(names: Sequence[str]) -> list[float]:
            # Names that are known.
            native = plant._native
            return [native.get(name) for name in names]

        def row() -> list[float]:
            return [*read(outputs), *noted.values()]

        counters = list(COUNTERS) if logs else []
        rows, counts = [row()], [read(counters)]
        if logs:
            plant._native.log_events()
        inputs = list(self.model.inputs)
        history = np.empty((grid.count, len(inputs)))
        ended: BaseException | None = None
        reached = 0
        try:
            for index in range(grid.count):
                for name, course in driven.items():
                    plant.set_one(name, float(course[index]))
                if index % self.samples == 0:
                    time = grid.start + index * grid.step
                    made = self._sample(controller, time, measured, {name: float(c[index]) for name, c in own.items()})
                    noted |= self._record(controller, made, time)
                    self._check(made, driven, time)
                    pending.append((index + self.delay, made))
                due: dict[str, float] = {}
                while pending and pending[0][0] <= index:
                    due |= pending.popleft()[1]
                if index == 0:
                    plant = begun(self.model, {**settings, **first, **due}, grid.start)
                    if logs:
                        plant._native.log_events()
                    measured = Measured(plant, list(self.model.outputs))
                    rows[0], counts[0] = row(), read(counters)
                for name, value in due.items():
                    plant.set_one(name, value)
                history[index] = read(inputs)
                # Each step ends at its point plus its size, as in runs without a controller.
                plant.step(index * grid.step + grid.start + grid.step - plant.time)
                reached = index + 1
                if reached % every == 0 or reached == grid.count:
                    rows.append(row())
                    counts.append(read(counters))
                if tell is not None and reached % 1000 == 0:
                    tell(reached)
        except (SimulationError, KeyboardInterrupt) as error:
            ended = error
        found = np.array(rows).T.reshape(len(outputs) + len(noted), len(rows))
        held = dict(zip(inputs, history[:reached].T.copy(), strict=True))
        last = controller.running if isinstance(controller, OfModel) else controller
        log = (np.array(counts), plant._native.logged_events()) if logs else None
        return LoopRun(grid.times()[: len(rows)], found, held, last, ended, noticed, log)

    def _run_beside(
        self, settings: Mapping[str, Value], driven: Mapping[str, Array], own: Mapping[str, Array],
        outputs: Sequence[str], tell: Callable[[int], None] | None, logs: bool,
    ) -> LoopRun:  # fmt: skip
        """Make a run with a controller of the library."""
        self.refuse_twice(driven)
        assert self.of_model is not None
        points = self.grid.points()[: max(self.grid.count, 1)]
        of_plant, of_controller = (
            [(name, (points, one[np.newaxis])) for name, one in inputs.items() if len(one)] for inputs in (driven, own)
        )
        model, given, *names = self.native
        with self.model._with_units():
            found, [(rows, failure)], ended, noticed, _, kept = _native.simulate_closed(
                self.model._native, list(settings.items()), [[]], of_plant, (model, given, of_controller, *names),
                self.sampling, self.grid.numbers, list(outputs), 1, tell, True, list(COUNTERS) if logs else None,
            )  # fmt: skip
        if isinstance(ended, Refused):
            raise self.model._in_unit(ended) from None
        assert kept is not None
        history, native, log = kept
        controller = None if native is None else Simulation(native, self.of_model.model, self.of_model.parameters)
        held = dict(zip(self.model.inputs, history, strict=True))
        if failure is not None:
            ended = SimulationError(failure)
        told = [notice for _, notice in noticed]
        return LoopRun(self.grid.times()[:rows], found[0, :, :rows], held, controller, ended, told, log)

    def _record(self, controller: Any, made: dict[str, Any], time: float) -> dict[str, float]:
        """Take out of what a controller has returned what it records."""
        if self.of_model is not None:
            return {name: controller.running.get_one(name) for name in self.record}
        found = {name: made.pop(name) for name in self.record if name in made}
        for name, value in found.items():
            if not values.is_number(value):
                raise ValueError(f"at t = {time:g} s the controller records {name} = {shortened(value)}: no number")
        return {name: float(value) for name, value in found.items()}

    def _sample(self, controller: Any, time: float, measured: Measured, own: Mapping[str, float]) -> dict[str, float]:
        if self.of_model is not None:
            return controller(own, measured, self.model.variables, self.driven)  # type: ignore[no-any-return]
        made = controller(time, measured)
        if made is None:
            return {}
        return dict(made) if isinstance(made, Mapping) else {next(iter(self.model.inputs)): made}

    def _check(self, made: dict[str, float], driven: Mapping[str, Array], time: float) -> None:
        for name, value in made.items():
            if name not in self.model.inputs:
                raise ValueError(
                    f"at t = {time:g} s the controller sets {name}, which is no input"
                    f"{did_you_mean(str(name), self.model.inputs)}; the inputs are {', '.join(self.model.inputs)}. "
                    f"What it returns beside them is recorded by record=[{str(name)!r}]"
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
