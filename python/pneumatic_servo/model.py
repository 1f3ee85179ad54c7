"""A model of the library, ready to run."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from typing import NoReturn

import numpy as np
from numpy.typing import ArrayLike

from pneumatic_servo import _native, progress
from pneumatic_servo.checks import mapping, names, seconds, whole_number
from pneumatic_servo.comparison import RECORDED, Comparison, check_laws
from pneumatic_servo.errors import Interrupted, SimulationError
from pneumatic_servo.grid import Grid
from pneumatic_servo.inputs import Input, Inputs, Values, course, courses, settings_of_runs, shape
from pneumatic_servo.linear import Linearisation, linearise
from pneumatic_servo.run import Run, Runs
from pneumatic_servo.simulation import Simulation
from pneumatic_servo.variables import Value, Variable, Variables

Parameters = Mapping[str, Value]
"""Parameters and start values of inputs, by name, in SI units; items of enumerations by name."""


class Model:
    """A model: its variables, and the ways to run it.

    Parameters
    ----------
    name : str
        One of `models`, for example ``PneumaticServoCylinder``.

    Attributes
    ----------
    parameters, inputs, outputs, variables : Variables
        What can be set before a run, what is set while running, what is meant to be watched, and everything.
    stop, step : float
        Duration and step size in s of the default experiment.
    """

    def __init__(self, name: str = "PneumaticServoCylinder") -> None:
        self._native = _native.Model(name)
        self.name = self._native.name
        self.description = self._native.description
        self.variables = Variables(Variable.of(description) for description in self._native.variables())
        self.parameters = self._with_roles("fixed", "tunable")
        self.inputs = self._with_roles("input")
        self.outputs = self._with_roles("output")
        self.stop, self.step = self._native.experiment

    def _with_roles(self, *roles: str) -> Variables:
        return Variables(variable for variable in self.variables.values() if variable.role in roles)

    def __repr__(self) -> str:
        return f"Model({self.name!r})"

    def __reduce__(self) -> tuple[type[Model], tuple[str]]:
        return Model, (self.name,)

    def start(self, parameters: Parameters | None = None, *, time: float = 0.0) -> Simulation:
        """Start a run that goes step by step.

        Parameters
        ----------
        parameters : mapping, optional
            Parameters and start values of inputs.
        time : float
            Start time in s.
        """
        return Simulation(self._native.start(list(mapping("parameters", parameters).items()), seconds("time", time)))

    def simulate(
        self,
        parameters: Parameters | None = None,
        *,
        inputs: Inputs | None = None,
        stop: float | None = None,
        step: float | None = None,
        start: float = 0.0,
        outputs: Sequence[str] | None = None,
        every: int = 1,
        progress: progress.Progress = False,
    ) -> Run:
        """Run the model once.

        The results are, bit for bit, those of the FMU driven at the same communication points.

        Parameters
        ----------
        parameters : mapping, optional
            Parameters and start values of inputs that stay the same.
        inputs : mapping, optional
            Inputs over time: constants, points ``(t, u)`` with t in s, or functions of time. Each value is held over
            a step.
        stop, step, start : float, optional
            End, size of the communication steps, and begin in s; by default those of the default experiment.
        outputs : sequence of str, optional
            Variables to record; by default the inputs given and all outputs of the model.
        every : int
            Steps per recorded row.
        progress : bool or callable
            Whether to show progress on a terminal, or what is called with steps done and steps in all.

        Returns
        -------
        Run

        Raises
        ------
        ValueError
            For an unknown variable or a value that is refused; the message names both.
        SimulationError
            When the solver cannot go on; its ``finished`` is the run until then.
        Interrupted
            On Ctrl-C; its ``finished`` is the run until then.
        """
        grid = self._grid(start, stop, step, every)
        settings, inputs = mapping("parameters", parameters), mapping("inputs", inputs)
        self._refuse_twice(settings, inputs)
        recorded = self._recorded(outputs, inputs)
        driven = [(name, course(self.inputs, name, given)) for name, given in inputs.items()]
        with _shown(progress, f"{self.name}", grid.count, " steps") as tell:
            values, rows, failure, ended = _native.simulate(
                self._native, list(settings.items()), driven, grid.numbers, list(recorded), tell
            )
        run = Run(grid.times()[:rows], values[:, :rows], recorded, settings)
        if ended is not None:
            _raise(ended, run)
        if failure is not None:
            error = SimulationError(failure)
            error.finished = run
            raise error
        return run

    def simulate_many(
        self,
        parameters: Sequence[Parameters] | Mapping[str, Values] = (),
        *,
        inputs: Mapping[str, Input | ArrayLike] | None = None,
        common: Parameters | None = None,
        number: int | None = None,
        stop: float | None = None,
        step: float | None = None,
        start: float = 0.0,
        outputs: Sequence[str] | None = None,
        every: int = 1,
        workers: int | None = None,
        keep_failures: bool = False,
        progress: progress.Progress = True,
    ) -> Runs:
        """Run the model many times on all cores, each run with the same bits as alone.

        Parameters
        ----------
        parameters : sequence of mappings, or mapping
            The parameters of each run, or arrays of shape (runs,) by name beside values that all runs share.
        inputs : mapping, optional
            Inputs over time: as for `simulate`, and besides arrays of shape (runs,) with a constant for each run, and
            points ``(t, u)`` with u of shape (runs, times). Functions are called once for all runs.
        common : mapping, optional
            Parameters and start values that all runs share.
        number : int, optional
            Number of runs, where nothing else tells it.
        stop, step, start : float, optional
            End, size of the communication steps, and begin in s.
        outputs : sequence of str, optional
            Variables to record; memory grows with them: 8 bytes for each run, variable and row.
        every : int
            Steps per recorded row.
        workers : int, optional
            Number of threads; by default one per core that this process may use.
        keep_failures : bool
            Whether runs that cannot go on are left with fewer rows instead of raising an error.
        progress : bool or callable
            Whether to show progress on a terminal, or what is called with runs done and runs in all.

        Returns
        -------
        Runs

        Raises
        ------
        ValueError, SimulationError, Interrupted
            As `simulate`; ``finished`` are all runs, those that were not finished with fewer rows.
        """
        grid = self._grid(start, stop, step, every)
        inputs, shared = mapping("inputs", inputs), mapping("common", common)
        threads = available_cores() if workers is None else whole_number("workers", workers, least=1)
        number = _number_of_inputs(inputs) if number is None else whole_number("number", number, least=1)
        runs = settings_of_runs(parameters, number)
        if number is not None and number != len(runs):
            raise ValueError(f"the inputs are for {number} runs, the parameters for {len(runs)}")
        for settings in runs:
            self._refuse_twice(settings, inputs)
        recorded = self._recorded(outputs, inputs)
        driven = [(name, courses(self.inputs, name, given, len(runs), grid)) for name, given in inputs.items()]
        with _shown(progress, self.name, len(runs), " runs") as tell:
            values, reached, ended = _native.simulate_many(
                self._native,
                list(shared.items()),
                [list(settings.items()) for settings in runs],
                driven,
                grid.numbers,
                list(recorded),
                threads,
                tell,
            )
        rows = np.array([count for count, _ in reached], dtype=np.int64)
        failures = {run: failure for run, (_, failure) in enumerate(reached) if failure is not None}
        finished = Runs(grid.times(), values, recorded, [shared | settings for settings in runs], rows, failures)
        if ended is not None:
            _raise(ended, finished)
        if failures and not keep_failures:
            run, failure = next(iter(failures.items()))
            error = ValueError if rows[run] == 0 else SimulationError
            problem = error(f"run {run} of {len(runs)}: {failure}")
            if isinstance(problem, SimulationError):
                problem.finished = finished
            raise problem
        return finished

    def compare(
        self,
        laws: Sequence[str],
        parameters: Parameters | None = None,
        *,
        inputs: Inputs | None = None,
        stop: float | None = None,
        step: float | None = None,
        outputs: Sequence[str] = (),
        progress: progress.Progress = True,
    ) -> Comparison:
        """Run one experiment under several friction laws.

        Parameters
        ----------
        laws : sequence of str
            Friction laws; the first is the one the others are compared with.
        parameters, inputs, stop, step, progress
            As for `simulate_many`, the same for all laws.
        outputs : sequence of str
            Variables to record besides those of the table.

        Returns
        -------
        Comparison
            With one table and one figure.
        """
        laws = check_laws(laws)
        given, inputs = mapping("parameters", parameters), mapping("inputs", inputs)
        for name in ("friction.law", "friction.lawNumber"):
            if name in given:
                raise ValueError(f"the law is given twice, among the laws and as {name} among the parameters")
        runs = self.simulate_many(
            [{"friction.law": law} for law in laws],
            common=given,
            inputs=inputs,
            stop=stop,
            step=step,
            outputs=list(dict.fromkeys([*inputs, *RECORDED, *names("outputs", outputs)])),
            progress=progress,
        )
        return Comparison(laws, runs)

    def linearise(
        self,
        at: Parameters | None = None,
        *,
        states: Sequence[str] | None = None,
        inputs: Sequence[str] = ("valveVoltage",),
        outputs: Sequence[str] = ("position", "velocity"),
        trim: bool = True,
    ) -> Linearisation:
        """Linearise the model at an operating point; the matrices are exact derivatives of its equations.

        Parameters
        ----------
        at : mapping, optional
            The operating point: states, inputs and parameters. A given velocity means steady motion with it.
        states : sequence of str, optional
            States to keep; by default all that are integrated under the law and rig.
        inputs, outputs : sequence of str
            Inputs and outputs of the linear system.
        trim : bool
            Whether the states and those of `inputs` that `at` does not give are chosen so that nothing else moves;
            otherwise they have the values with which a run starts.

        Returns
        -------
        Linearisation
            ``A, B, C, D = plant.linearise(...)``, with labels; ``scaled()`` and ``to_control()``.

        Raises
        ------
        TrimError
            When no such point is found. While a set-valued law sticks, position and velocity do not react, and within
            the play of ``valve.hysteresis`` the valve does not: give a velocity, and the hysteresis as 0.
        """
        kept = None if states is None else names("states", states)
        driven, seen = names("inputs", inputs), names("outputs", outputs)
        return linearise(self, mapping("at", at), kept, driven, seen, trim)

    def _grid(self, start: float, stop: float | None, step: float | None, every: int) -> Grid:
        return Grid.of(start, self.stop if stop is None else stop, self.step if step is None else step, every)

    def _recorded(self, outputs: Sequence[str] | None, inputs: Mapping[str, object]) -> Variables:
        chosen = [*inputs, *self.outputs] if outputs is None else names("outputs", outputs)
        if not chosen:
            raise ValueError("outputs is empty: name at least one variable to record")
        unknown = next((name for name in chosen if name not in self.variables), None)
        if unknown is not None:
            try:
                self.variables[unknown]
            except KeyError as error:
                raise ValueError(error.args[0]) from None
        twice = next((name for name in chosen if chosen.count(name) > 1), None)
        if twice is not None:
            raise ValueError(f"outputs has {twice} twice")
        return Variables(self.variables[name] for name in chosen)

    def _refuse_twice(self, settings: Mapping[str, object], inputs: Mapping[str, object]) -> None:
        twice = next((name for name in settings if name in inputs), None)
        if twice is not None:
            raise ValueError(f"{twice} is given twice, among the parameters and among the inputs")


_shown = progress.shown


def models() -> list[str]:
    """Return the names of all models."""
    return _native.models()


def available_cores() -> int:
    """Return how many cores this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def _number_of_inputs(inputs: Mapping[str, Input | ArrayLike]) -> int | None:
    """Return how many runs the arrays among the inputs are for, if there are any."""
    for name, given in inputs.items():
        if isinstance(given, tuple):
            ends = shape(name, given[1]) if len(given) == 2 else ()
            if len(ends) == 2:
                return ends[0]
        elif not callable(given) and len(ends := shape(name, given)) == 1:
            return ends[0]
    return None


def _raise(ended: BaseException, finished: Run | Runs) -> NoReturn:
    """Raise what ended a run, with what was finished."""
    if isinstance(ended, KeyboardInterrupt):
        interrupted = Interrupted("interrupted")
        interrupted.finished = finished
        raise interrupted from None
    raise ended
