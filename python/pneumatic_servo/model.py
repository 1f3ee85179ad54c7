"""A model of the library, ready to run."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import Executor, ProcessPoolExecutor, ThreadPoolExecutor
from pathlib import Path
from typing import TYPE_CHECKING, Any, NoReturn, Protocol, runtime_checkable

from pneumatic_servo import _native, defaults, effects, plant_warnings, progress, values
from pneumatic_servo.checks import names, submits, whole_number
from pneumatic_servo.closed_loop import Controller, Loop, Record
from pneumatic_servo.closed_many import ClosedWork
from pneumatic_servo.comparison import COUNTED, RECORDED, Comparison, check_laws
from pneumatic_servo.errors import Refused, warn
from pneumatic_servo.fmu import nothing
from pneumatic_servo.grid import Grid, courses_of
from pneumatic_servo.inputs import (
    Input,
    Inputs,
    Values,
    course,
    courses,
    extremes_of,
    first_of,
    has_lines,
    inputs_of,
    settings_of_runs,
    shape,
    tell_unusual,
)
from pneumatic_servo.iosys import to_iosys
from pneumatic_servo.linear import LeftOut, Linearisation, linearise
from pneumatic_servo.many import Done, Work
from pneumatic_servo.model_description import ModelDescription
from pneumatic_servo.names import did_you_mean
from pneumatic_servo.run import COUNTS, Run, Runs, Steps
from pneumatic_servo.run_errors import Interrupted, SimulationError
from pneumatic_servo.sensitivities import Replay, Sensitivities
from pneumatic_servo.simulation import Simulation
from pneumatic_servo.solver_log import COUNTERS, SolverLog
from pneumatic_servo.ssv import read_ssv
from pneumatic_servo.tasks import available_cores
from pneumatic_servo.trim import TrimError
from pneumatic_servo.variables import Value, Variables

if TYPE_CHECKING:
    import control


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
        effects.tell(self, given)
        effects.tell_notices(self, native.notices(), given)
        return Simulation(native, self, settings, defaults.followers(self.variables, given, settings))

    def simulate(
        self,
        parameters: Parameters | None = None,
        *,
        inputs: Inputs | None = None,
        columns: str | Mapping[str, str] | None = None,
        stop: float | None = None,
        step: float | None = None,
        start: float = 0.0,
        outputs: Sequence[str] | None = None,
        every: int = 1,
        sensitivities: Sequence[str] = (),
        controller: Controller | None = None,
        period: float | None = None,
        delay: float = 0.0,
        record: Record = (),
        solver_log: bool = False,
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
            run give all their inputs; their other columns are ignored. A table that begins after ``start`` is counted
            from its first time on, which a warning tells.
        columns : str or mapping, optional
            Which columns of such a table are the time and the inputs, as `fit` takes it:
            ``"time=t,valveVoltage=u,supplyPressure=p[bar]"``; by default those with their names.
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
            returns inputs by name or the value of the first one. Or the name of a controller's model, or the path of
            its FMU, as ``"PositionController.fmu"``, or the pair of it and its parameters:
            ``("PositionController", {"gain.position": 10})``; its own inputs, as ``referencePosition``, are given among
            the inputs. Each run has a copy of its own, of objects, of
            functions and the variables that they close over; ``run.controller`` is this copy in its final state. A
            function without parameters is a factory, which is called for the controller of each run.
        record : sequence of str, or mapping
            Names of what the controller returns beside inputs, which become columns of the run; a mapping gives their
            units: ``{"error": "m"}``. Of a controller's model any of its variables. A row has the values of the last
            sample before it.
        solver_log : bool
            Whether ``run.solver_log`` is to have the steps and events of the solver: see `SolverLog`.
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
        inputs = inputs_of("inputs", self.variables, inputs, columns, grid.start)
        if isinstance(parameters, HasSettings):
            # A sheet, a fit or a run has start values of inputs, which those over time replace.
            settings = {name: value for name, value in settings.items() if name not in inputs}
        self._refuse_twice(settings, inputs)
        if solver_log and (self._is_fmu or COUNTERS[0] not in self.variables):
            raise ValueError(
                f"solver_log: {'an FMU tells no events' if self._is_fmu else f'{self.name} has no solver'}"
            )
        if self._is_fmu and controller is None:
            if sensitivities:
                raise ValueError(f"a run of an FMU has no sensitivities; {_native.OWN_MODULE}")
            controller = nothing
        if controller is not None:
            if sensitivities:
                raise ValueError("sensitivities need given inputs; a run with a controller has none")
            loop = Loop(self, controller, grid, period, delay, record)
            with _shown(progress, f"{self.name}", grid.count, " steps") as tell:
                run = self._closed(loop, settings, inputs, outputs, tell, logs=solver_log)
            effects.tell_outputs(self, [settings], outputs)
            return run
        if period is not None or delay != 0.0:
            raise ValueError("period and delay are for a controller, and none is given")
        if record:
            raise ValueError("record is for a controller, and none is given; name variables among the outputs")
        driven = [(name, course(self.inputs, name, given)) for name, given in inputs.items()]
        recorded = self._recorded(outputs, inputs)
        by = names("sensitivities", sensitivities)
        given, settings = settings, self._fitted(settings, first_of(dict(driven)))
        followers = defaults.followers(self.variables, given, settings)
        followed = {name: follows for name, follows in followers.items() if follows[0] in by and name not in by}
        with _shown(progress, f"{self.name}", grid.count, " steps") as tell, self._with_units():
            found, rows, failure, ended, notices, extremes, told, logged = _native.simulate(
                self._native, list(settings.items()), driven, grid.numbers, list(recorded),
                [*by, *followed], tell, lines, list(COUNTERS) if solver_log else None,
            )  # fmt: skip
        slopes = None if told is None else Sensitivities.of(by, followed, recorded, grid.times()[:rows], told)
        replay = None if lines else Replay(self._native, settings, driven, grid, list(self.inputs), followers)
        steps = None if grid.every == 1 else Steps(grid, dict(driven))
        run = Run(
            grid.times()[:rows], found[:, :rows], recorded, settings, slopes, replay, has_lines=lines, steps=steps,
            solver_log=None if logged is None else SolverLog.of(grid.times()[:rows], logged),
        )  # fmt: skip
        if isinstance(ended, Refused):
            raise self._in_unit(ended) from None
        if ended is not None:
            _raise(ended, run)
        self._tell_saturated(settings)
        effects.tell(self, given)
        effects.tell_by(self, given, by)
        effects.tell_inputs(self, [settings], dict(zip(inputs, extremes, strict=True)))
        effects.tell_outputs(self, [settings], outputs)
        for name, (low, high) in zip(inputs, extremes, strict=True):
            plant_warnings.warn_saturation(self.inputs[name], low, high)
        largest = {name: max(ends, key=abs) for name, ends in zip(inputs, extremes, strict=True)}
        plant_warnings.warn_size(self.variables, [{**settings, **largest}])
        self._warn_ends(driven, grid)
        effects.tell_notices(self, notices, given)
        if failure is not None:
            error = SimulationError(failure)
            error.finished = run
            raise error
        return run

    def _closed(
        self, loop: Loop, settings: Mapping[str, Value], inputs: Mapping[str, Input], outputs: Sequence[str] | None,
        tell: Callable[[int], None] | None, *, logs: bool = False,
    ) -> Run:  # fmt: skip
        """Make one run in a closed loop."""
        grid = loop.grid
        own = {name: given for name, given in inputs.items() if name in (loop.own_inputs or ())}
        given = {name: course(self.inputs, name, one) for name, one in inputs.items() if name not in own}
        of_controller = {name: course(loop.own_inputs or self.inputs, name, one) for name, one in own.items()}
        recorded = self._recorded(outputs, {name: None for name in self.inputs if name not in settings})
        fitted = self._fitted(settings)
        effects.tell(self, settings)
        one = loop.run(
            fitted, courses_of(given, grid), courses_of(of_controller, grid), list(recorded), tell, logs=logs
        )
        history, ended = one.held, one.ended
        begins = grid.points()[: len(next(iter(history.values())))]
        held = [(name, (begins, own)) for name, own in history.items()]
        followers = defaults.followers(self.variables, settings, fitted)
        replay = None if self._is_fmu else Replay(self._native, fitted, held, grid, list(self.inputs), followers)
        steps = None if grid.every == 1 else Steps(grid, dict(held))
        shown = Variables([*recorded.values(), *loop.record.values()])
        run = Run(
            one.times, one.values, shown, fitted, None, replay, steps=steps,
            controller=None if one.controller is nothing else one.controller,
            solver_log=None if one.log is None else SolverLog.of(one.times, one.log),
        )  # fmt: skip
        moved = {name: (float(own.min()), float(own.max())) for name, own in history.items() if len(own)}
        effects.tell_inputs(self, [fitted], moved)
        for name, (low, high) in moved.items():
            plant_warnings.warn_saturation(self.inputs[name], low, high)
        largest = {name: max(ends, key=abs) for name, ends in moved.items()}
        plant_warnings.warn_size(self.variables, [{**fitted, **largest}])
        effects.tell_notices(self, one.noticed, settings)
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
        columns: str | Mapping[str, str] | None = None,
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
        record: Record = (),
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
        columns : str or mapping, optional
            Which columns of a table are the time and the inputs: see `simulate`.
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
            Number of threads; by default one per core that this process may use. Runs with a controller in Python,
            which one interpreter makes one after the other, are divided among as many processes, by default among
            none: the controller is pickled for them, as a function of a module or an object of its classes can be.
        executor : concurrent.futures.Executor, optional
            Executor of the runs: a ``ProcessPoolExecutor``, ``client.get_executor()`` of a Dask cluster, or any
            other. The bits are the same.
        keep_failures : bool
            Whether runs that cannot go on are left with fewer rows instead of raising an error.
        resume : Runs, optional
            The ``finished`` of an interrupted call with the same arguments, which may have been pickled: what is
            complete there is not made again.
        controller, period, delay, record : optional
            Controller of each run: see `simulate`. A controller of the library, as ``"PositionController"``, or one
            in an FMU runs beside the plant on all cores, without a step through Python.
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
        inputs = inputs_of("inputs", self.variables, inputs, columns, grid.start)
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
        loop = None if controller is None else Loop(self, controller, grid, period, delay, record)
        if loop is None and (period is not None or delay != 0.0):
            raise ValueError("period and delay are for a controller, and none is given")
        if loop is None and record:
            raise ValueError("record is for a controller, and none is given; name variables among the outputs")
        runs = self._all_fitted(shared, runs)
        known = self.inputs if loop is None else Variables({**self.inputs, **(loop.own_inputs or {})}.values())
        driven = {name: courses(known, name, one, len(runs), grid) for name, one in inputs.items()}
        if loop is None:
            recorded = self._recorded(outputs, inputs)
            work = Work(self.name, shared, runs, driven, grid.numbers, list(recorded), lines=lines)
        else:
            of_plant = self._recorded(outputs, {name: None for name in self.inputs if name not in given[0]})
            recorded = Variables([*of_plant.values(), *loop.record.values()])
            work = ClosedWork(self.name, shared, runs, driven, grid.numbers, list(recorded), loop=loop)
        number = len(runs) if resume is None else len(work.missing(resume))
        is_one_by_one = loop is not None and not loop.runs_beside
        with _shown(progress, self.name, number, " runs") as tell:

            def make(part: Work) -> Done:
                if executor is not None:
                    return part.make_by(executor, tell)
                if is_one_by_one and workers is not None and threads > 1:
                    with ProcessPoolExecutor(threads) as processes:
                        return part.make_by(processes, tell)
                return part.make(threads, tell)

            done = make(work) if resume is None else work.beside(resume, make)
        found = self._runs_of(work, done, grid, recorded, keep_failures=keep_failures)
        for run, name, value, remark in done.noticed:
            own = {**shared, **runs[run]}
            effects.tell_notices(self, [(name, value, remark)], own, f"run {run} of {len(runs)}: ")
        tell_unusual(known, driven, grid)
        effects.tell_runs(self, given)
        effects.tell_inputs(self, given, {**extremes_of(driven), **done.extremes})
        effects.tell_outputs(self, given, outputs)
        for name, (low, high) in done.extremes.items():
            if name not in driven:
                plant_warnings.warn_saturation(self.inputs[name], low, high)
        largest = {name: max(ends, key=abs) for name, ends in done.extremes.items()}
        plant_warnings.warn_size(self.variables, [{**shared, **own, **largest} for own in runs])
        return found

    def _runs_of(self, work: Work, done: Done, grid: Grid, recorded: Variables, *, keep_failures: bool) -> Runs:
        """Return runs that were made; unless failures are to be kept, the first of them is raised."""
        settings = [{**work.shared, **own} for own in work.runs]
        finished = Runs(
            grid.times(),
            done.values,
            recorded,
            settings,
            done.rows,
            done.failures,
            inputs=work.inputs,
            grid=grid,
            controlled=work.loop.text if isinstance(work, ClosedWork) else None,
            lines=work.lines,
        )
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
        left_out: LeftOut = "residualise",
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
        left_out : str
            What becomes of states that are not kept: ``residualise`` lets them follow at once, so that the static gain
            stays; ``hold`` keeps them at their values. A position that is left out is held in both cases, since it
            comes to no rest of its own.

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
            When an input has no effect at the point, since the valve is in its dead zone or the carriage sticks; and
            when it loses its effect with a state that is held.

        Examples
        --------
        >>> import pneumatic_servo as ps
        >>> A, B, C, D = ps.Model().linearise({"velocity": 0.05, "valve.hysteresis": 0})
        >>> A.shape, B.shape
        ((8, 8), (8, 1))
        >>> four = ["position", "velocity", "chamberA.pressure", "chamberB.pressure"]
        >>> slow = ps.Model().linearise({"velocity": 0.05, "valve.hysteresis": 0}, states=four)
        >>> bool(slow.B[2, 0] > 0 > slow.B[3, 0])
        True
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
        return linearise(self, self.start, self._settings(at, "at"), kept, driven, seen, trim, left_out)

    def linearise_many(
        self,
        points: Sequence[Parameters],
        *,
        shared: Parameters | None = None,
        states: Sequence[str] | None = None,
        inputs: Sequence[str] = ("valveVoltage",),
        outputs: Sequence[str] = ("position", "velocity"),
        trim: bool = True,
        left_out: LeftOut = "residualise",
        workers: int | None = None,
    ) -> list[Linearisation]:
        """Linearise the model at many operating points on all cores, for a gain schedule.

        Parameters
        ----------
        points : sequence of mapping
            The operating points: see `linearise`.
        shared : mapping, optional
            Parameters, states and inputs of all points that do not give them themselves.
        states, inputs, outputs, trim, left_out
            As for `linearise`.
        workers : int, optional
            Number of threads; by default one per core that this process may use.

        Returns
        -------
        list of Linearisation
            One for each point, with the same bits as by `linearise`.

        Raises
        ------
        TrimError
            When a point is not found; the message begins with its number.

        Examples
        --------
        >>> import pneumatic_servo as ps
        >>> speeds = [{"velocity": velocity} for velocity in (0.05, 0.1, 0.2)]
        >>> schedule = ps.Model().linearise_many(speeds, shared={"valve.hysteresis": 0})
        >>> [round(float(point.u[0]), 1) for point in schedule]
        [5.5, 5.6, 5.8]
        """
        if isinstance(points, Mapping) or not isinstance(points, Sequence):
            raise TypeError("points must be a list of mappings, one for each operating point")
        threads = available_cores() if workers is None else whole_number("workers", workers, least=1)
        common = self._settings(shared, "shared")

        def make(number: int) -> Linearisation:
            try:
                return self.linearise(
                    {**common, **self._settings(points[number], "points")}, states=states, inputs=inputs,
                    outputs=outputs, trim=trim, left_out=left_out,
                )  # fmt: skip
            except TrimError as error:
                raise TrimError(f"point {number} of {len(points)}: {error}") from error

        with ThreadPoolExecutor(threads) as executor:
            return list(executor.map(make, range(len(points))))

    def to_iosys(
        self,
        parameters: Parameters | None = None,
        *,
        inputs: Sequence[str] = ("valveVoltage",),
        outputs: Sequence[str] = ("position", "velocity"),
        period: float = 1e-3,
    ) -> control.NonlinearIOSystem:
        """Return the plant as a nonlinear system of python-control, sampled, with its inputs held over each period.

        Stick and slip, and other events, happen within the periods: a response has the bits of the same steps of a
        `Simulation`. Modes follow the states that the system has come to; a state that nobody has come to has those of
        the start.

        Parameters
        ----------
        parameters : mapping, path or Linearisation, optional
            Parameters and start values, as for `start`; of a `Linearisation` its operating point.
        inputs, outputs : sequence of str
            Inputs and outputs of the system; dots in their names become ``_``. Other inputs stay as they start.
        period : float
            Period in s.

        Returns
        -------
        control.NonlinearIOSystem
            ``system.x0`` is the state at the start, of shape (states,), in SI units.

        Raises
        ------
        ValueError
            For an unknown variable or a value that is refused.

        Examples
        --------
        >>> import control
        >>> import numpy as np
        >>> import pneumatic_servo as ps
        >>> system = ps.Model().to_iosys({"supplyPressure": "6 bar"}, period=1e-3)
        >>> t = np.arange(200) * 1e-3
        >>> response = control.input_output_response(system, t, np.full(200, 7.0), system.x0)
        >>> bool(response.outputs[0, -1] > response.outputs[0, 0])
        True
        """
        if self._is_fmu:
            raise ValueError(f"a run of an FMU is no system of python-control; {_native.OWN_MODULE}")
        step = values.seconds("period", period)
        if step <= 0.0:
            raise ValueError(f"period = {step:g} is refused: it must be positive")
        return to_iosys(self.start(parameters), names("inputs", inputs), names("outputs", outputs), step)

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
