"""A model of the library, ready to run."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import Executor
from pathlib import Path
from typing import Any, NoReturn, Protocol, runtime_checkable

import numpy as np

from pneumatic_servo import _native, defaults, effects, plant_warnings, progress, values
from pneumatic_servo.checks import names, submits, whole_number
from pneumatic_servo.closed_loop import Controller, Loop
from pneumatic_servo.comparison import COUNTED, RECORDED, Comparison, check_laws
from pneumatic_servo.errors import Refused, warn
from pneumatic_servo.fmu import OWN, nothing
from pneumatic_servo.grid import Grid, courses_of
from pneumatic_servo.inputs import (
    Input,
    Inputs,
    Values,
    course,
    courses,
    extremes_of,
    has_lines,
    inputs_of,
    settings_of_runs,
    shape,
    tell_unusual,
)
from pneumatic_servo.linear import Linearisation, linearise
from pneumatic_servo.many import Done, Work, check_same, unfinished
from pneumatic_servo.model_description import ModelDescription
from pneumatic_servo.names import did_you_mean
from pneumatic_servo.run import COUNTS, Run, Runs
from pneumatic_servo.run_errors import Interrupted, SimulationError
from pneumatic_servo.sensitivities import Replay, Sensitivities
from pneumatic_servo.simulation import Simulation
from pneumatic_servo.ssv import read_ssv
from pneumatic_servo.tasks import available_cores
from pneumatic_servo.variables import Value, Variables


@runtime_checkable
class HasSettings(Protocol):
    """Source of parameters by name: a `DataSheet`, a `Fit`, a `Linearisation`, an earlier `Run`."""

    @property
    def settings(self) -> Mapping[str, Any]:
        """Parameters and start values by name, as every run takes them."""
        ...


Parameters = Mapping[str, Any] | str | Path | HasSettings
"""Parameters and start values of inputs: numbers in SI units, ``"6 bar"``, ``(6, "bar")`` or quantities of pint; items
of enumerations by name; true or false. Or the name of an SSV file that has them, or what has ``settings``: a
`DataSheet`, a `Fit`, a `Linearisation`, an earlier `Run`."""


class Model(ModelDescription):
    """A model: its variables, and the ways to run it.

    Parameters
    ----------
    name : str or Path
        One of `models`, for example ``PneumaticServoCylinder``, or the file of an FMU 2.0 of this library: a model of
        your own. Its runs, steps, saved states and partial derivatives come from the FMU. It has no sensitivities,
        transitions, gradients and fits, which a module of its crate has (``docs/own-packing.md``).

    Attributes
    ----------
    parameters, inputs, outputs, variables : Variables
        Parameters, inputs, outputs, and all variables.
    stop, step : float
        Duration and step size in s of the default experiment.

    Examples
    --------
    >>> import pneumatic_servo as ps
    >>> plant = ps.Model("PneumaticServoCylinder")
    >>> plant.parameters["valve.C"].unit
    'm3/(s.Pa)'
    >>> list(plant.inputs)[:3]
    ['valveVoltage', 'externalForce', 'supplyPressure']
    """

    def start(self, parameters: Parameters | None = None, *, time: float = 0.0) -> Simulation:
        """Start a run that goes step by step.

        Parameters
        ----------
        parameters : mapping or path, optional
            Parameters and start values of inputs: see `simulate`. With a `Linearisation` the run begins at its
            operating point, with all states and inputs of it.
        time : float
            Start time in s.

        Returns
        -------
        Simulation

        Raises
        ------
        ValueError
            For an unknown variable or a value that is refused; the message names variable, value and unit.

        Examples
        --------
        >>> import pneumatic_servo as ps
        >>> simulation = ps.Model().start({"friction.law": "LuGre", "supplyPressure": "6 bar"})
        >>> simulation["valveVoltage"] = 7.0
        >>> for _ in range(100):
        ...     simulation.step(1e-3)
        >>> round(simulation.time, 6)
        0.1
        """
        begin = values.seconds("time", time)
        if isinstance(parameters, Linearisation) and parameters._start is not None:
            own, state = parameters._start
            simulation = Simulation(self._native.start(list(own.items()), begin), self, own)
            simulation.restore(state)
            return simulation
        given = self._settings(parameters)
        settings = self._fitted(given)
        with self._with_units():
            native = self._native.start(list(settings.items()), begin)
        self._tell_saturated(settings)
        effects.tell(self.variables, given)
        plant_warnings.warn_notices(self.variables, native.notices(), given)
        return Simulation(native, self, settings, defaults.followers(self.variables, given, settings))

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
        sensitivities: Sequence[str] = (),
        controller: Controller | None = None,
        period: float | None = None,
        delay: float = 0.0,
        progress: progress.Progress = False,
    ) -> Run:
        """Run the model once.

        The results equal, bit for bit, the FMU's at the same communication points.

        Parameters
        ----------
        parameters : mapping or path, optional
            Parameters and start values of inputs that stay the same: numbers in SI units, or with their unit as
            ``"6 bar"``, ``(6, "bar")`` or a quantity of pint; or the name of an SSV file. A measured friction curve
            becomes such a mapping by `friction_table`, a maker's data by `DataSheet`. What nobody gave has its default,
            which a warning names where it had to give way to what was given.
        inputs : mapping, path, DataFrame or Run, optional
            Inputs over time: constants, points ``(t, u)`` or ``(t, u, "bar")`` with t in s, arrays with the columns t
            and u, pandas Series over time, or functions of time. Points are joined by straight lines;
            ``{"hold": (t, u)}`` holds each until the next one, as measured commands are, and as `fit` takes them. The
            value at the begin of each communication step is held over it. Before the first point its value holds, and
            after the last one the last, which a warning tells; a
            valve voltage saturates at 0 and 10 V, which one tells, too. A table in a file, a DataFrame or an earlier
            run give all their inputs; their other columns are ignored.
        stop, step, start : float, optional
            End, size of the communication steps, and begin in s; by default as in the default experiment.
        outputs : sequence of str, optional
            Variables to record; by default the inputs given and all outputs of the model.
        every : int
            Steps per recorded row.
        sensitivities : sequence of str
            Real parameters, inputs (a constant added to it all along) and continuous states (its value at the begin)
            by which all that is recorded is differentiated, exactly through events: see `Run.sensitivities`. The
            values are the same bits with and without; the run takes longer, and 8 bytes more for each of these,
            variable and row, of 2 GiB at most.
        controller : callable or str, optional
            Controller of a closed loop: a function of the time in s and a mapping of the plant's variables, which
            returns inputs by name or the value of the first one. Or the name of a controller's model, or the pair of
            it and its parameters: ``("PositionController", {"gain.position": 10})``; its own inputs, as
            ``referencePosition``, are given among the inputs. It is copied for each run, so that objects may have
            a state.
        period, delay : float, optional
            Time in s between its samples, by default a communication step, and from a sample until what it sets is
            applied; both whole numbers of communication steps.
        progress : bool or callable
            Whether to show progress on a terminal, or what is called with steps done and steps in all.

        Returns
        -------
        Run

        Raises
        ------
        ValueError
            For an unknown variable or a value that is refused; the message names variable, value and unit.
        MemoryError
            When the record does not fit into memory.
        SimulationError
            When the solver cannot go on; its ``finished`` is the run until then.
        Interrupted
            On Ctrl-C; its ``finished`` is the run until then.

        Warns
        -----
        PlantWarning
            For what is accepted, but hardly meant: a supply of 6 Pa, a voltage of 50 V, an input that ends early.

        Examples
        --------
        >>> import numpy as np
        >>> import pneumatic_servo as ps
        >>> t = np.arange(0, 0.5, 1e-3)
        >>> run = ps.Model().simulate({"friction.law": "LuGre", "supplyPressure": "6 bar"},
        ...                           inputs={"valveVoltage": (t, 5 + np.sin(6 * t))}, stop=0.5, step=1e-3)
        >>> run["position"].shape
        (501,)
        """
        grid = self._grid(start, stop, step, every)
        settings = self._settings(parameters)
        lines = has_lines(inputs)
        inputs = inputs_of("inputs", self.variables, inputs)
        if isinstance(parameters, HasSettings):
            # A sheet, a fit or a run has start values of inputs, which those over time replace.
            settings = {name: value for name, value in settings.items() if name not in inputs}
        self._refuse_twice(settings, inputs)
        if self._is_fmu and controller is None:
            if sensitivities:
                raise ValueError(f"a run of an FMU has no sensitivities; {OWN}")
            controller = nothing
        if controller is not None:
            if sensitivities:
                raise ValueError("sensitivities need given inputs; a run with a controller has none")
            loop = Loop(self, controller, grid, period, delay)
            with _shown(progress, f"{self.name}", grid.count, " steps") as tell:
                run = self._closed(loop, settings, inputs, outputs, tell)
            effects.tell_outputs(self.variables, [settings], outputs)
            return run
        if period is not None or delay != 0.0:
            raise ValueError("period and delay are for a controller, and none is given")
        driven = [(name, course(self.inputs, name, given)) for name, given in inputs.items()]
        recorded = self._recorded(outputs, inputs)
        by = names("sensitivities", sensitivities)
        given, settings = settings, self._fitted(settings)
        followers = defaults.followers(self.variables, given, settings)
        followed = {name: follows for name, follows in followers.items() if follows[0] in by and name not in by}
        with _shown(progress, f"{self.name}", grid.count, " steps") as tell, self._with_units():
            found, rows, failure, ended, notices, extremes, told = _native.simulate(
                self._native, list(settings.items()), driven, grid.numbers, list(recorded),
                [*by, *followed], tell, lines,
            )  # fmt: skip
        slopes = None if told is None else Sensitivities.of(by, followed, recorded, grid.times()[:rows], told)
        replay = None if lines else Replay(self._native, settings, driven, grid, list(self.inputs), followers)
        run = Run(grid.times()[:rows], found[:, :rows], recorded, settings, slopes, replay, has_lines=lines)
        if isinstance(ended, Refused):
            raise self._in_unit(ended) from None
        if ended is not None:
            _raise(ended, run)
        self._tell_saturated(settings)
        effects.tell(self.variables, given)
        effects.tell_by(self.variables, given, by)
        effects.tell_inputs(self.variables, [settings], dict(zip(inputs, extremes, strict=True)))
        effects.tell_outputs(self.variables, [settings], outputs)
        for name, (low, high) in zip(inputs, extremes, strict=True):
            plant_warnings.warn_saturation(self.inputs[name], low, high)
        largest = {name: max(ends, key=abs) for name, ends in zip(inputs, extremes, strict=True)}
        plant_warnings.warn_size(self.variables, [{**settings, **largest}])
        self._warn_ends(driven, grid)
        plant_warnings.warn_notices(self.variables, notices, given)
        if failure is not None:
            error = SimulationError(failure)
            error.finished = run
            raise error
        return run

    def _begun(self, settings: Mapping[str, Value], time: float) -> Simulation:
        """Start a run with values in SI units, without warnings."""
        with self._with_units():
            return Simulation(self._native.start(list(settings.items()), time), self, settings)

    def _closed(
        self, loop: Loop, settings: Mapping[str, Value], inputs: Mapping[str, Input], outputs: Sequence[str] | None,
        tell: Callable[[int], object] | None,
    ) -> Run:  # fmt: skip
        """Make one run in a closed loop."""
        grid = loop.grid
        own = {name: given for name, given in inputs.items() if name in (loop.own_inputs or ())}
        given = {name: course(self.inputs, name, one) for name, one in inputs.items() if name not in own}
        of_controller = {name: course(loop.own_inputs or self.inputs, name, one) for name, one in own.items()}
        recorded = self._recorded(outputs, {name: None for name in self.inputs if name not in settings})
        fitted = self._fitted(settings)
        effects.tell(self.variables, settings)
        times, found, history, ended = loop.run(
            lambda first: self._begun({**fitted, **first}, grid.start), courses_of(given, grid),
            courses_of(of_controller, grid),
            list(recorded), tell,
        )  # fmt: skip
        begins = grid.points()[: len(next(iter(history.values())))]
        held = [(name, (begins, one)) for name, one in history.items()]
        followers = defaults.followers(self.variables, settings, fitted)
        replay = None if self._is_fmu else Replay(self._native, fitted, held, grid, list(self.inputs), followers)
        run = Run(times, found, recorded, fitted, None, replay)
        moved = {name: (float(one.min()), float(one.max())) for name, one in history.items() if len(one)}
        effects.tell_inputs(self.variables, [fitted], moved)
        for name, one in history.items():
            if len(one):
                plant_warnings.warn_saturation(self.inputs[name], float(one.min()), float(one.max()))
        largest = {name: float(one[np.argmax(np.abs(one))]) for name, one in history.items() if len(one)}
        plant_warnings.warn_size(self.variables, [{**fitted, **largest}])
        plant_warnings.warn_notices(self.variables, self._begun(fitted, grid.start)._native.notices(), settings)
        self._warn_ends([*given.items(), *of_controller.items()], grid, loop.own_inputs)
        if isinstance(ended, SimulationError):
            ended.finished = run
            raise ended
        if ended is not None:
            _raise(ended, run)
        return run

    def simulate_many(
        self,
        parameters: Sequence[Parameters] | Mapping[str, Values] = (),
        *,
        inputs: Mapping[str, Input] | None = None,
        common: Parameters | None = None,
        number: int | None = None,
        stop: float | None = None,
        step: float | None = None,
        start: float = 0.0,
        outputs: Sequence[str] | None = None,
        every: int = 1,
        workers: int | None = None,
        executor: Executor | None = None,
        keep_failures: bool = False,
        resume: Runs | None = None,
        controller: Controller | None = None,
        period: float | None = None,
        delay: float = 0.0,
        progress: progress.Progress = True,
    ) -> Runs:
        """Run the model many times on all cores, each run with the same bits as alone.

        Parameters
        ----------
        parameters : sequence of mappings, mapping or DataFrame
            The parameters of each run, or arrays of shape (runs,) by name beside values that all runs share; with
            units as for `simulate`, an array as ``([5, 6], "bar")``. A DataFrame has a row for each run.
        inputs : mapping, optional
            Inputs over time: as for `simulate`, and besides arrays of shape (runs,) with a constant for each run, and
            points ``(t, u)`` with u of shape (runs, times). Functions are called once for all runs.
        common : mapping, optional
            Parameters and start values that all runs share, as far as a run has none of its own.
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
        executor : concurrent.futures.Executor, optional
            Executor of the runs: a ``ProcessPoolExecutor``, ``client.get_executor()`` of a Dask cluster, or any
            other. The bits are the same.
        keep_failures : bool
            Whether runs that cannot go on are left with fewer rows instead of raising an error.
        resume : Runs, optional
            The ``finished`` of an interrupted call with the same arguments, which may have been pickled: what is
            complete there is not made again.
        controller, period, delay : optional
            Controller of each run: see `simulate`. Such runs are made one after the other, and inputs are
            the same for all.
        progress : bool or callable
            Whether to show progress on a terminal, or what is called with runs done and runs in all.

        Returns
        -------
        Runs

        Raises
        ------
        ValueError, SimulationError, Interrupted
            As `simulate`; ``finished`` are all runs, those that were not finished with fewer rows.

        Examples
        --------
        >>> import pneumatic_servo as ps
        >>> runs = ps.Model().simulate_many({"supplyPressure": ([5, 6, 7], "bar")}, inputs={"valveVoltage": 6},
        ...                                 stop=0.2, step=1e-3, outputs=["position"])
        >>> runs["position"].shape
        (3, 201)
        """
        grid = self._grid(start, stop, step, every)
        shared = self._settings(common, "common")
        lines = has_lines(inputs)
        inputs = inputs_of("inputs", self.variables, inputs)
        threads = available_cores() if workers is None else whole_number("workers", workers, least=1)
        number = _number_of_inputs(inputs) if number is None else whole_number("number", number, least=1)
        submits("executor", executor)
        runs = settings_of_runs(self.variables, parameters, number, self._settings)
        if number is not None and number != len(runs):
            raise ValueError(f"the inputs are for {number} runs, the parameters for {len(runs)}")
        for settings in runs:
            self._refuse_twice(settings, inputs)
        given = [{**shared, **own} for own in runs]
        if self._is_fmu and controller is None:
            controller = nothing
        if controller is not None:
            loop = Loop(self, controller, grid, period, delay)
            if executor is not None or workers is not None:
                raise ValueError("workers and executor are for runs without a controller")
            made = self._many_closed(loop, given, inputs, outputs, progress, resume, keep_failures=keep_failures)
            effects.tell_outputs(self.variables, given, outputs)
            return made
        if period is not None or delay != 0.0:
            raise ValueError("period and delay are for a controller, and none is given")
        runs = self._all_fitted(shared, runs)
        driven = {name: courses(self.inputs, name, given, len(runs), grid) for name, given in inputs.items()}
        recorded = self._recorded(outputs, inputs)
        work = Work(self.name, shared, runs, driven, grid.numbers, list(recorded), lines=lines)
        number = len(runs) if resume is None else len(work.missing(resume))
        with _shown(progress, self.name, number, " runs") as tell:

            def make(part: Work) -> Done:
                return part.make(threads, tell) if executor is None else part.make_by(executor, tell)

            done = make(work) if resume is None else work.beside(resume, make)
        found = self._runs_of(work, done, grid, recorded, keep_failures=keep_failures)
        for run, name, value, remark in done.noticed:
            own = {**shared, **runs[run]}
            plant_warnings.warn_notices(self.variables, [(name, value, remark)], own, f"run {run} of {len(runs)}: ")
        tell_unusual(self.inputs, driven, grid)
        effects.tell_runs(self.variables, given)
        effects.tell_inputs(self.variables, given, extremes_of(driven))
        effects.tell_outputs(self.variables, given, outputs)
        plant_warnings.warn_size(self.variables, [{**shared, **own} for own in runs])
        return found

    def _many_closed(
        self, loop: Loop, runs: Sequence[Mapping[str, Value]], inputs: Mapping[str, Input],
        outputs: Sequence[str] | None, progress: progress.Progress, earlier: Runs | None, *, keep_failures: bool,
    ) -> Runs:  # fmt: skip
        """Make many runs in closed loops, one after the other."""
        recorded = self._recorded(outputs, {name: None for name in self.inputs if name not in runs[0]})
        values_ = np.full((len(runs), len(recorded), loop.grid.rows), np.nan)
        rows = np.zeros(len(runs), dtype=np.int64)
        failures: dict[int, str] = {}
        missing = list(range(len(runs)))
        if earlier is not None:
            check_same(earlier, runs, list(recorded))
            if earlier.time.tobytes() != loop.grid.times().tobytes():
                raise ValueError("resume: the earlier runs have other times")
            missing, failures = unfinished(earlier), dict(earlier.failures)
            values_[:], rows[:] = earlier._values, earlier.rows
        ended: BaseException | None = None
        with _shown(progress, self.name, len(missing), " runs") as tell:
            for done, number in enumerate(missing, start=1):
                run: object = None
                try:
                    run = self._closed(loop, runs[number], inputs, list(recorded), None)
                    if tell is not None:
                        tell(done)
                except SimulationError as error:
                    run, failures[number] = error.finished, str(error)
                    ended = None if keep_failures else error
                except KeyboardInterrupt as error:
                    run, ended = getattr(error, "finished", run), error
                if isinstance(run, Run):
                    rows[number] = len(run)
                    values_[number, :, : len(run)] = [run[name] for name in recorded]
                if ended is not None:
                    break
        found = Runs(loop.grid.times(), values_, recorded, runs, rows, failures)
        if isinstance(ended, SimulationError):
            problem = SimulationError(f"run {number} of {len(runs)}: {ended}")
            problem.finished = found
            raise problem
        if ended is not None:
            _raise(KeyboardInterrupt(), found)
        return found

    def _runs_of(self, work: Work, done: Done, grid: Grid, recorded: Variables, *, keep_failures: bool) -> Runs:
        """Return runs that were made; unless failures are to be kept, the first of them is raised."""
        settings = [{**work.shared, **own} for own in work.runs]
        finished = Runs(grid.times(), done.values, recorded, settings, done.rows, done.failures, inputs=work.inputs)
        if done.ended is not None:
            _raise(done.ended, finished)
        if done.failures and not keep_failures:
            run, failure = next(iter(done.failures.items()))
            where = f"run {run} of {len(work.runs)}: "
            if done.rows[run] == 0:
                # An exception from another thread has lost its unit.
                self._check(settings[run], where)
                raise ValueError(where + failure)
            problem = SimulationError(where + failure)
            problem.finished = finished
            raise problem
        return finished

    def _run_many(
        self,
        runs: Sequence[Mapping[str, Value]],
        *,
        common: Mapping[str, Value],
        inputs: Mapping[str, Any],
        stop: float,
        step: float,
        outputs: Sequence[str],
        workers: int | None = None,
        most: int | None = None,
        lines: bool = False,
    ) -> Runs:
        """Make runs of values that are known to be in SI units, without warnings and without defaults that give way."""
        grid = self._grid(0.0, stop, step, 1)
        work = Work(self.name, common, runs, inputs, grid.numbers, list(outputs), most, lines)
        done = work.make(available_cores() if workers is None else workers)
        recorded = Variables(self.variables[name] for name in outputs)
        return self._runs_of(work, done, grid, recorded, keep_failures=True)

    def compare(
        self,
        laws: Sequence[str],
        parameters: Parameters | None = None,
        *,
        inputs: Inputs | None = None,
        stop: float | None = None,
        step: float | None = None,
        outputs: Sequence[str] = (),
        executor: Executor | None = None,
        controller: Controller | None = None,
        period: float | None = None,
        delay: float = 0.0,
        progress: progress.Progress = True,
    ) -> Comparison:
        """Run one experiment under several friction laws.

        Parameters
        ----------
        laws : sequence of str
            Friction laws; the first is the one the others are compared with.
        parameters, inputs, stop, step, executor, controller, period, delay, progress
            As for `simulate_many`, the same for all laws.
        outputs : sequence of str
            Variables to record besides the table's.

        Returns
        -------
        Comparison
            With one table and one figure.

        Raises
        ------
        ValueError, SimulationError
            As `simulate_many`.
        Interrupted
            On Ctrl-C; its ``finished`` is a comparison of the laws until then, those that were not finished with fewer
            rows.

        Examples
        --------
        >>> import pneumatic_servo as ps
        >>> found = ps.Model().compare(["Stribeck", "LuGre"], inputs={"valveVoltage": 6}, stop=0.2, step=1e-3)
        >>> [law for law, *_ in found.rows()]
        ['Stribeck', 'LuGre']
        """
        laws = check_laws(laws)
        known = self.parameters.get("friction.law")
        for law in laws:
            if known is not None:
                values.checked(known, law)
        given, named = self._settings(parameters), inputs_of("inputs", self.variables, inputs)
        for name in ("friction.law", "friction.lawNumber"):
            if name in given:
                raise ValueError(f"the law is given twice, among the laws and as {name} among the parameters")
        unlike = effects.unlike(self.variables, laws, given)
        seen = [*(named if controller is None else self.inputs), *([COUNTED] if given.get(COUNTS) else [])]
        try:
            runs = self.simulate_many(
                [{"friction.law": law} for law in laws],
                common=given,
                inputs=inputs,
                stop=stop,
                step=step,
                outputs=list(dict.fromkeys([*seen, *RECORDED, *names("outputs", outputs)])),
                executor=executor,
                controller=controller,
                period=period,
                delay=delay,
                progress=progress,
            )
        except Interrupted as interrupted:
            if isinstance(interrupted.finished, Runs):
                interrupted.finished = Comparison.of_begun(laws, interrupted.finished, unlike)
            raise
        effects.tell_laws(self.variables, laws, given)
        return Comparison(laws, runs, tuple(unlike))

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
            Whether the states and `inputs` not in `at` are chosen so that nothing else moves;
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

        Warns
        -----
        PlantWarning
            When an input has no effect at the point, since the valve is in its dead zone or the carriage sticks.

        Examples
        --------
        >>> import pneumatic_servo as ps
        >>> A, B, C, D = ps.Model().linearise({"velocity": 0.05, "valve.hysteresis": 0})
        >>> A.shape, B.shape
        ((8, 8), (8, 1))
        """
        kept = None if states is None else names("states", states)
        driven, seen = names("inputs", inputs), names("outputs", outputs)
        for argument, chosen in (("states", kept), ("inputs", driven), ("outputs", seen)):
            if chosen is not None and not chosen:
                raise ValueError(f"{argument} is empty: name at least one")
            twice = next((name for name in chosen or () if (chosen or []).count(name) > 1), None)
            if twice is not None:
                raise ValueError(f"{argument} has {twice} twice")
        for name, chosen in (("states", kept or []), ("outputs", seen)):
            unknown = next((one for one in chosen if one not in self.variables), None)
            if unknown is not None:
                raise ValueError(f"{name}: there is no variable {unknown}{did_you_mean(unknown, self.variables)}")
        return linearise(self, self.start, self._settings(at, "at"), kept, driven, seen, trim)

    def _settings(self, given: Parameters | None, argument: str = "parameters") -> dict[str, Value]:
        """Return values by name as the plant takes them, from a mapping or from an SSV file."""
        if isinstance(given, Path) or (isinstance(given, str) and given.lower().endswith(".ssv")):
            given = read_ssv(given, self)
        elif isinstance(given, HasSettings):
            given = given.settings
        return values.settings(argument, self.variables, given)  # type: ignore[arg-type]

    def _fitted(
        self, settings: Mapping[str, Value], shared: Mapping[str, Value] | None = None,
        tell: Callable[[str], object] = warn,
    ) -> dict[str, Value]:  # fmt: skip
        """Return settings with the defaults that follow them."""
        every = {**(shared or {}), **settings}
        if not defaults.is_in_doubt(self.variables, every):
            return dict(settings)
        with self._with_units():
            found = defaults.fitted(self.variables, every, self._try, tell)
        return {**settings, **{name: value for name, value in found.items() if name not in every}}

    def _all_fitted(self, shared: Mapping[str, Value], runs: Sequence[Mapping[str, Value]]) -> list[dict[str, Value]]:
        told: dict[str, str] = {}
        found = []
        for number, own in enumerate(runs):
            try:
                found.append(self._fitted(own, shared, lambda text: told.setdefault(text.partition(" = ")[0], text)))
            except Refused:
                # The warning is reported with the run.
                found.append(dict(own))
            for name, text in list(told.items()):
                if not text.startswith("run "):
                    told[name] = f"run {number} of {len(runs)}: {text}"
        for text in told.values():
            warn(text)
        return found

    def _try(self, settings: Mapping[str, Value]) -> None:
        self._native.start(list(settings.items()), 0.0)

    def _check(self, settings: Mapping[str, Value], where: str) -> None:
        """Raise the refusal of a start, with units."""
        try:
            self._try(settings)
        except Refused as refused:
            raise ValueError(f"{where}{self._in_unit(refused)}") from None

    def _warn_ends(self, driven: Sequence[tuple[str, Any]], grid: Grid, more: Variables | None = None) -> None:
        for name, given in driven:
            if isinstance(given, tuple):
                plant_warnings.warn_ends(
                    self.inputs[name] if name in self.inputs else (more or self.inputs)[name], given[0], grid
                )

    def _grid(self, start: float, stop: float | None, step: float | None, every: int) -> Grid:
        return Grid.of(start, self.stop if stop is None else stop, self.step if step is None else step, every)

    def _recorded(self, outputs: Sequence[str] | None, inputs: Mapping[str, object]) -> Variables:
        chosen = [*inputs, *self.outputs] if outputs is None else names("outputs", outputs)
        if not chosen:
            raise ValueError("outputs is empty: name at least one variable to record")
        unknown = next((name for name in chosen if name not in self.variables), None)
        if unknown is not None:
            raise ValueError(f"outputs: there is no variable {unknown}{did_you_mean(unknown, self.variables)}")
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
    """Return the names of all models.

    Examples
    --------
    >>> import pneumatic_servo as ps
    >>> ps.models()[0]
    'PneumaticServoCylinder'
    """
    return _native.models()


def _number_of_inputs(inputs: Mapping[str, Input]) -> int | None:
    """Return how many runs the arrays among the inputs are for, if there are any."""
    for name, given in inputs.items():
        if isinstance(given, tuple):
            per_run = len(given) == 2 and isinstance(given[1], str)
            ends = shape(name, given[0] if per_run else given[1]) if len(given) > 1 else ()
            if len(ends) == (1 if per_run else 2):
                return ends[0]
        elif hasattr(given, "index") and hasattr(given, "to_numpy"):
            continue
        elif not callable(given) and len(ends := shape(name, given)) == 1:
            return ends[0]
    return None


def _raise(ended: BaseException, finished: Run | Runs) -> NoReturn:
    """Raise the error that ended a run, with its finished part."""
    if isinstance(ended, KeyboardInterrupt):
        interrupted = Interrupted("interrupted")
        interrupted.finished = finished
        raise interrupted from None
    raise ended
