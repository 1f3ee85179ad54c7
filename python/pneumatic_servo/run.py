"""Recorded runs."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from html import escape
from pathlib import Path
from reprlib import repr as shortened
from typing import TYPE_CHECKING, Any, overload

import numpy as np
from numpy.typing import NDArray

from pneumatic_servo import checks
from pneumatic_servo.checks import mapping
from pneumatic_servo.constant_voltage import AtRest
from pneumatic_servo.errors import MissingPackage, warn
from pneumatic_servo.gases import AIR, CONSTANT, relative_density
from pneumatic_servo.grid import Grid, courses_of
from pneumatic_servo.names import did_you_mean
from pneumatic_servo.sensitivities import Gradient, Replay, Sensitivities
from pneumatic_servo.solver_log import SolverLog
from pneumatic_servo.units import REFERENCE_DENSITY
from pneumatic_servo.variables import Variables

if TYPE_CHECKING:
    import pandas
    import xarray
    from matplotlib.figure import Figure

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Consumption:
    """Gas that a run has drawn from its supply.

    Attributes
    ----------
    mass : float
        Mass in kg.
    duration : float
        From the first to the last row in s.
    density : float
        Density in kg/m3 of the gas at the reference conditions of ISO 8778 (ANR).
    """

    mass: float
    duration: float
    density: float = REFERENCE_DENSITY

    @property
    def volume(self) -> float:
        """Volume in m3 at the reference conditions of ISO 8778 (ANR, air of 1.185 kg/m3)."""
        return self.mass / self.density

    @property
    def mean_flow(self) -> float:
        """Mean mass flow in kg/s; 1 l/min (ANR) of air is 1.975e-5 kg/s."""
        return self.mass / self.duration


def held_from(recorded: Array) -> Array:
    """Return the values from each row on, of the values up to it."""
    return np.append(recorded[1:], recorded[-1:])


class Steps:
    """Inputs of a run at each communication step, where a row stands for several; worked out when they are asked for.

    Parameters
    ----------
    grid : Grid
        Steps and rows.
    driven : mapping or None
        Inputs that were given over time, as `courses_of` takes them; others are constant. Nothing where a controller
        set them, and nobody recorded the steps.
    """

    def __init__(self, grid: Grid, driven: Mapping[str, Any] | None) -> None:
        self.every, self._grid, self._driven = grid.every, grid, driven

    def __getstate__(self) -> dict[str, object]:
        # Functions stay in their process.
        known = self._driven is not None and not any(map(callable, self._driven.values()))
        return {**self.__dict__, "_driven": self._driven if known else None}

    def replayed(self, name: str) -> tuple[Array, Array] | None:
        """Return the times in s at which the steps begin, and an input over each; nothing if nobody knows it."""
        if self._driven is None or name not in self._driven:
            return None
        return self._grid.points()[:-1], courses_of({name: self._driven[name]}, self._grid)[name]

    def fit_rows(self, name: str, recorded: Array) -> bool:
        """Tell whether an input is known to be constant over the steps of each row."""
        if self._driven is None:
            return False
        if not isinstance(self._driven.get(name, 0.0), tuple) and not callable(self._driven.get(name)):
            return True
        held, steps = np.repeat(recorded[1:], self.every), courses_of({name: self._driven[name]}, self._grid)[name]
        count = min(len(held), len(steps))
        return bool(np.array_equal(held[:count], steps[:count]))


class Run:
    """A run: ``run.time`` in s and, by name, the recorded variables in SI units.

    The row at t shows the inputs that were in force up to t, so that a recorded input lags the given one by a row.
    Given to `simulate`, `simulate_many`, `compare` or `fit` a run has its inputs as they were given, and so have its
    tables. Inputs are held over a step but in runs of a fit with ``has_lines``: there they run on straight lines from
    row to row, which tables do not tell.

    Attributes
    ----------
    time : ndarray of shape (rows,)
        Times in s.
    settings : dict
        Parameters and start values that were given.
    variables : Variables
        Recorded variables.
    sensitivities : Sensitivities or None
        Derivatives of the recorded variables, if they were asked for.
    has_lines : bool
        Whether its inputs ran on straight lines from row to row.
    controller : object
        The controller of a closed loop in its final state: the object or function that the run had as its own, or the
        `Simulation` of a controller's model; None without one, and of a run that comes from another process.
    solver_log : SolverLog or None
        Steps and events of the solver, if they were asked for.

    Examples
    --------
    >>> import pneumatic_servo as ps
    >>> run = ps.Model().simulate(inputs={"valveVoltage": 7}, stop=0.2, step=1e-3)
    >>> run.time.shape, run["position"].shape, run.variables["position"].unit
    ((201,), (201,), 'm')
    >>> run[["position", "velocity"]].to_csv("run.csv")
    """

    def __init__(
        self,
        time: Array,
        values: Array,
        variables: Variables,
        settings: Mapping[str, object],
        sensitivities: Sensitivities | None = None,
        replay: Replay | None = None,
        *,
        has_lines: bool = False,
        steps: Steps | None = None,
        controller: object = None,
        solver_log: SolverLog | None = None,
    ) -> None:
        self.time = time
        self.solver_log = solver_log
        self.controller = controller
        self._steps = steps
        self._replay = replay
        self.has_lines = has_lines
        self.sensitivities = sensitivities
        self.settings = dict(settings)
        self.variables = variables
        self._values = values

    def __getstate__(self) -> dict[str, object]:
        # Functions are not known to other processes: a run that is sent there has no `vjp`, and no controller.
        return {**self.__dict__, "_replay": None, "controller": None}

    RECORDED = "pneumatic_servo: inputs are those in force up to each row"
    """Among the ``attrs`` of a DataFrame of an earlier version: its inputs lag the given ones by a row."""

    @overload
    def __getitem__(self, name: str) -> Array: ...
    @overload
    def __getitem__(self, name: list[str] | tuple[str, ...]) -> Run: ...
    def __getitem__(self, name: str | list[str] | tuple[str, ...]) -> Array | Run:
        """Return a recorded variable, of shape (rows,), in its SI unit; of a list of names the run with these alone."""
        if isinstance(name, list | tuple) and all(isinstance(one, str) for one in name):
            return self.select(name)
        if not isinstance(name, str):
            raise TypeError(f"a run is asked for names, run['position'][0], not for {shortened(name)}")
        if name == "time" and name not in self.variables:
            return self.time
        row: Array = self._values[_place(self.variables, name)]
        return row

    def select(self, names: Sequence[str]) -> Run:
        """Return the run with some of its variables."""
        chosen = checks.names("names", names)
        places = [_place(self.variables, name) for name in chosen]
        variables = Variables(self.variables[name] for name in chosen)
        return Run(
            self.time, self._values[places], variables, self.settings, replay=self._replay, has_lines=self.has_lines,
            steps=self._steps, controller=self.controller, solver_log=self.solver_log,
        )  # fmt: skip

    def __iter__(self) -> Iterator[str]:
        return iter(self.variables)

    def __contains__(self, name: object) -> bool:
        return name in self.variables

    if not TYPE_CHECKING:

        def __getattr__(self, name: str) -> Any:
            known = () if name.startswith("_") else self.__dict__.get("variables", ())
            hint = f"; write run[{name!r}]" if name in known else did_you_mean(name, [*known, *MEANT])
            raise AttributeError(f"a run has no attribute {name}{'' if name.startswith('_') else hint}")

    def __array__(self, *_: Any, **__: Any) -> Any:
        raise TypeError("a run is no array; write run['position'], or run.to_pandas() for all of it")

    def items(self) -> list[tuple[str, Array]]:
        """Return the recorded variables by name."""
        return [(name, self[name]) for name in self.variables]

    def keys(self) -> list[str]:
        """Return the names of the recorded variables, so that ``dict(run)`` has them all."""
        return list(self.variables)

    def __len__(self) -> int:
        """Return the number of rows."""
        return len(self.time)

    def __repr__(self) -> str:
        end = f" to {self.time[-1]:g} s" if len(self) else ""
        return f"<Run of {len(self)} rows{end}: {', '.join(self.variables)}>"

    def _repr_html_(self) -> str:
        cells = (
            [name, f"{np.min(self[name]):.6g}", f"{np.max(self[name]):.6g}", variable.unit]
            for name, variable in self.variables.items()
        )
        return f"<p>{escape(repr(self).strip('<>').partition(':')[0])}</p>" + table(
            ["", "least", "most", "unit"], cells
        )

    def _repr_png_(self) -> bytes | None:
        return self.plot()._repr_png_() if len(self) > 1 else None  # type: ignore[attr-defined]

    def _ipython_key_completions_(self) -> list[str]:
        return list(self.variables)

    def to_pandas(self) -> pandas.DataFrame:
        """Return a table with a column per variable and the time in s as its index.

        Inputs belong to the step that begins at each row, as in `to_csv`, so that the table can be simulated and
        fitted as it is, also after it was edited or written by pandas. Of a run with ``has_lines`` the table has them
        at its rows, which a warning tells: a simulation of the table holds them.
        """
        try:
            import pandas
        except ImportError as error:
            raise MissingPackage("pandas", "pandas") from error
        self._tell_lines()
        frame = pandas.DataFrame(
            np.array(self._given()).T.reshape(len(self), len(self.variables)),
            index=pandas.Index(self.time, name="time"),
            columns=list(self.variables),
        )
        if between := self.inputs_between_rows():
            frame.attrs[self.BETWEEN] = between
        return frame

    BETWEEN = "pneumatic_servo: inputs that changed between the rows"
    """Among the ``attrs`` of a DataFrame: names of inputs that it does not have as they were."""

    def inputs_between_rows(self) -> list[str]:
        """Return the recorded inputs that changed between rows, or may have, where ``every`` was above 1."""
        if self._steps is None:
            return []
        inputs = [name for name, variable in self.variables.items() if variable.role == "input"]
        return [name for name in inputs if not self._steps.fit_rows(name, self[name])]

    def replayed(self, name: str) -> tuple[Array, Array]:
        """Return times in s and values of an input, one for each communication step.

        Raises
        ------
        ValueError
            When a row stands for several steps, between which the input may have changed.
        """
        if self._steps is None or self._steps.fit_rows(name, self[name]):
            return self.time, self.given(name)
        found = self._steps.replayed(name)
        if found is None:
            raise ValueError(between_rows([name], self._steps.every))
        return found

    def _tell_lines(self) -> None:
        """Warn of a table that says less than the run."""
        if self._steps is not None and (between := self.inputs_between_rows()):
            warn(f"a table of this run does not repeat it: {between_rows(between, self._steps.every)}")
        if self.has_lines:
            warn(
                "the inputs of this run are on straight lines from row to row, and a simulation of its table holds "
                "them: give the run itself as inputs"
            )

    def _given(self) -> list[Array]:
        """Return the columns of all variables, inputs as they were given."""
        return [self.given(name) for name in self.variables]

    def given(self, name: str) -> Array:
        """Return a variable, of shape (rows,); of an input that was held, the values that hold from each row on.

        Where a row stands for several steps, an input has the value of the last of them; see `inputs_between_rows`.
        """
        column = self[name]
        is_held = self.variables[name].role == "input" and not self.has_lines
        return held_from(column) if is_held else column

    def to_csv(self, file: str | Path) -> None:
        """Write a table with a column per variable; the file appears as a whole or not at all.

        Inputs are written as they were given: each holds from its row on. So the table can be simulated and fitted as
        it is, and gives the same bits where every step was recorded. Of a run with ``has_lines`` the table has them at
        its rows, which a warning tells: a simulation of the table holds them.
        """
        from pneumatic_servo.files import write_csv

        self._tell_lines()
        columns = [self.time, *self._given()]
        write_csv(Path(file), ["time", *self.variables], zip(*(column.tolist() for column in columns), strict=True))

    def to_mat(self, file: str | Path) -> None:
        """Write a .mat file for MATLAB and Simulink; it needs SciPy.

        ``time`` and each variable are column vectors; ``chamberA.pressure`` is a field of the structure ``chamberA``.
        Inputs are as `to_csv` has them.
        """
        from pneumatic_servo.run_files import write_mat

        self._tell_lines()
        write_mat(Path(file), dict(zip(["time", *self.variables], [self.time, *self._given()], strict=True)))

    def to_combi_table(self, file: str | Path, *, name: str = "run") -> None:
        """Write a table for Modelica's ``Modelica.Blocks.Sources.CombiTimeTable`` (``tableOnFile``, ``tableName``).

        Its first column is the time, the others are the variables in their order, which the first line tells. Inputs
        are as `to_csv` has them: held from row on to row, which ``Smoothness.ConstantSegments`` repeats.
        """
        from pneumatic_servo.run_files import write_combi_table

        self._tell_lines()
        columns = dict(zip(["time", *self.variables], [self.time, *self._given()], strict=True))
        write_combi_table(Path(file), columns, name)

    def vjp(
        self, cotangents: Mapping[str, Any], *, parameters: Sequence[str] = (), at_rest: AtRest = "mean"
    ) -> Gradient:
        """Return how a scalar of the run changes with all its inputs at each step, its start and parameters.

        The scalar is the sum over rows and variables of what was recorded times its cotangents. The run is made again,
        and then backwards, step by step: that takes as long with thousands of inputs as with one. It needs memory for
        the transitions of 64 steps, a saved state for each 64, and the inputs, of which functions are called again.

        Parameters
        ----------
        cotangents : mapping
            By the names of computed variables arrays of shape (rows,), or a number for all rows.
        parameters : sequence of str
            Real parameters by which it is differentiated, too.
        at_rest : str
            Choice of the derivative by a voltage that is constant from one step to the next, whose left and right
            derivatives differ under valve hysteresis: their ``mean``, with which a search can begin, and which takes
            three times as long; ``zero``; or ``refuse``, an error.

        Returns
        -------
        Gradient

        Raises
        ------
        ValueError
            For a variable that is not computed or no real number, or cotangents that do not fit; for a run that
            `simulate` has not made, or that has not come to its end.
        NoDerivative
            When the run comes through a point at which there is none.

        Examples
        --------
        >>> import pneumatic_servo as ps
        >>> run = ps.Model().simulate(inputs={"valveVoltage": 6.5}, stop=0.2, step=1e-3, outputs=["position"])
        >>> end = [0.0] * 200 + [1.0]
        >>> run.vjp({"position": end}).inputs["valveVoltage"].shape
        (200,)
        """
        if self._replay is None:
            raise ValueError(
                "only runs that `simulate` has made, one by one, with inputs held over each step, have gradients"
            )
        for name in mapping("cotangents", cotangents):
            if _kind(self.variables, name) != "real":
                raise ValueError(f"{name} is no real number, and has no derivative")
        return self._replay.gradient(cotangents, checks.names("parameters", parameters), len(self), at_rest)

    def consumption(self) -> Consumption:
        """Return the air that is drawn from the supply between the first and the last row.

        Returns
        -------
        Consumption
            Mass, volume (ANR) and mean flow.

        Raises
        ------
        ValueError
            When the run has not counted the air, for which it needs ``consumption.enabled``, or has a single row.
        KeyError
            When ``supply.consumed`` was not recorded.

        Examples
        --------
        >>> import pneumatic_servo as ps
        >>> run = ps.Model().simulate({"consumption.enabled": True}, inputs={"valveVoltage": 7}, stop=0.5, step=1e-2)
        >>> f"{run.consumption().volume * 1e3:.3f} l (ANR)"
        '0.312 l (ANR)'
        """
        consumed = self["supply.consumed"]
        if not self.settings.get(COUNTS):
            raise ValueError(f"the run has not counted its air: give it {COUNTS} = True")
        if len(self) < 2:
            raise ValueError("the run has a single row, and so no duration")
        given = self.settings.get(CONSTANT)
        density = REFERENCE_DENSITY * relative_density(given if isinstance(given, int | float) else AIR.constant)
        return Consumption(float(consumed[-1] - consumed[0]), float(self.time[-1] - self.time[0]), density)

    def plot(self, *names: str | Sequence[str]) -> Figure:
        """Draw variables over time, one panel per unit; shaded where the mass sticks, if that is recorded.

        Parameters
        ----------
        *names : str
            Variables to draw, one by one or as a list; by default position, valve voltage, pressures and friction
            force, as far as recorded.

        Returns
        -------
        matplotlib.figure.Figure
            With units on its axes.
        """
        from pneumatic_servo.figures import draw_run

        chosen = [one for name in names for one in ([name] if isinstance(name, str) else checks.names("names", name))]
        for name in chosen:
            _place(self.variables, name)
        return draw_run(self, chosen)

    def plot_friction(self) -> Figure:
        """Draw friction against velocity, as a whole and near standstill.

        Returns
        -------
        matplotlib.figure.Figure
            With units on its axes.

        Raises
        ------
        KeyError
            When velocity or friction force of the contact was not recorded.
        """
        from pneumatic_servo.figures import draw_friction

        return draw_friction(self)


def between_rows(names: Sequence[str], every: int | None = None) -> str:
    """Return the text of a refusal of inputs that changed between the rows of a record."""
    of = "several steps" if every is None else f"{every} steps"
    return (
        f"{', '.join(names)} changed between rows, or may have, since each row stands for {of}: record every step "
        "(every=1), or give the inputs that the run was given"
    )


COUNTS = "consumption.enabled"
"""The parameter with which a run counts the air that it draws."""
MEANT = (
    "time", "settings", "variables", "sensitivities", "solver_log", "consumption", "plot", "plot_friction", "to_csv",
    "to_pandas", "vjp",
)  # fmt: skip
"""Meanings of misspelt attributes of a run."""


class Runs(Sequence[Run]):
    """Many runs of one model over the same times.

    Attributes
    ----------
    time : ndarray of shape (rows,)
        Times in s.
    rows : ndarray of shape (runs,)
        Rows that each run has; fewer than ``len(time)`` where it could not go on, and NaN behind them.
    failures : dict
        Why runs stopped early, by their number.
    variables : Variables
        What is recorded.
    numbers : list of int
        The number of each run: in a part of a study, its number in the study.
    inputs : dict or None
        Inputs of the runs, by which a resumed study is recognised.

    Examples
    --------
    >>> import pneumatic_servo as ps
    >>> runs = ps.Model().simulate_many({"mass.moving": [0.8, 1.2]}, inputs={"valveVoltage": 7}, stop=0.1, step=1e-3)
    >>> runs["position"].shape, runs.parameters, runs[1].settings["mass.moving"]
    ((2, 101), {'mass.moving': [0.8, 1.2]}, 1.2)
    """

    def __init__(
        self,
        time: Array,
        values: Array,
        variables: Variables,
        settings: Sequence[Mapping[str, object]],
        rows: NDArray[np.int64],
        failures: Mapping[int, str],
        numbers: Sequence[int] | None = None,
        inputs: Mapping[str, Any] | None = None,
        grid: Grid | None = None,
        controlled: str | None = None,
        lines: bool = False,
    ) -> None:
        self.inputs = inputs
        self._grid = grid
        self._controlled = controlled
        self._lines = lines
        self.numbers = list(range(len(values))) if numbers is None else list(numbers)
        self.time = time
        self.variables = variables
        self.rows = rows
        self.failures = dict(failures)
        self._values = values
        self._settings = settings

    def __len__(self) -> int:
        return len(self._values)

    def __iter__(self) -> Iterator[Run]:
        return (self._run(index) for index in range(len(self)))

    @overload
    def __getitem__(self, key: str) -> Array: ...
    @overload
    def __getitem__(self, key: int) -> Run: ...
    @overload
    def __getitem__(self, key: slice) -> list[Run]: ...
    def __getitem__(self, key: str | int | slice) -> Array | Run | list[Run]:
        """Return a variable of all runs, of shape (runs, rows), by its name, or one run by its number."""
        if isinstance(key, str):
            return self._of_all(key)
        if isinstance(key, slice):
            return [self._run(index) for index in range(*key.indices(len(self)))]
        return self._run(self._place(key))

    def _place(self, key: Any) -> int:
        if isinstance(key, bool | np.bool_) or not hasattr(key, "__index__"):
            raise TypeError(f"runs are asked for a number or a name, runs[0] or runs['position'], not for {key!r}")
        if not -len(self) <= key < len(self):
            raise IndexError(f"there are {len(self)} runs, and none of number {key}")
        return int(key) % len(self)

    def __contains__(self, name: object) -> bool:
        return name in self.variables if isinstance(name, str) else super().__contains__(name)

    def __array__(self, *_: Any, **__: Any) -> Any:
        raise TypeError("runs are no array; write runs['position'], of shape (runs, rows)")

    def of(self, numbers: Sequence[int] | NDArray[Any]) -> Runs:
        """Return the runs in these places; their table keeps the numbers that they have here.

        Places are numbers, or true and false for each run, as `is_complete` has them.
        """
        chosen = np.atleast_1d(np.asarray(numbers))
        if chosen.dtype == np.bool_:
            if chosen.shape != (len(self),):
                raise ValueError(f"of: there are {len(self)} runs, but {len(chosen)} times true or false")
            chosen = np.flatnonzero(chosen)
        numbers = [self._place(number) for number in chosen.tolist()]
        failures = {new: self.failures[old] for new, old in enumerate(numbers) if old in self.failures}
        settings = [self._settings[number] for number in numbers]
        places = list(numbers)
        return Runs(
            self.time,
            self._values[places],
            self.variables,
            settings,
            self.rows[places],
            failures,
            [self.numbers[place] for place in places],
            None if self.inputs is None else {name: _each(one, places, len(self)) for name, one in self.inputs.items()},
            self._grid,
            self._controlled,
            self._lines,
        )

    def _of_all(self, name: str) -> Array:
        values: Array = self._values[:, _place(self.variables, name)]
        return values

    def _run(self, index: int) -> Run:
        rows, steps = int(self.rows[index]), None
        if self._grid is not None and self._grid.every > 1:
            own = {name: of_run(course, index, len(self)) for name, course in (self.inputs or {}).items()}
            steps = Steps(self._grid, None if self._controlled else own)
        return Run(self.time[:rows], self._values[index, :, :rows], self.variables, self._settings[index], steps=steps)

    @property
    def is_complete(self) -> NDArray[np.bool_]:
        """Whether each run came to its end, of shape (runs,)."""
        return np.asarray(self.rows == len(self.time))

    def to_pandas(self) -> pandas.DataFrame:
        """Return one table of all runs: a column per variable; run and time in s are its index.

        Behind the variables it has a column for each parameter that differs between the runs: see `parameters`. A run
        that could not go on has fewer rows.
        """
        try:
            import pandas
        except ImportError as error:
            raise MissingPackage("pandas", "pandas") from error
        table = pandas.concat([run.to_pandas() for run in self], keys=self.numbers, names=["run", "time"])
        for name, column in self.parameters.items():
            if name not in table:
                table[name] = np.repeat(np.array(column), self.rows)
        return table

    @property
    def parameters(self) -> dict[str, list[Any]]:
        """Parameters and start values that differ between the runs: by name a list of a value for each run.

        A run that was not given one has None.
        """
        every = dict.fromkeys(name for settings in self._settings for name in settings)
        columns = {name: [settings.get(name) for settings in self._settings] for name in every}
        return {name: column for name, column in columns.items() if any(one != column[0] for one in column)}

    def plot(self, *names: str) -> Figure:
        """Draw variables of all runs over time, one panel per variable; by default position, velocity and friction.

        Up to six runs are lines; of more there are the median, the band of 5 to 95 % and the extent.

        Parameters
        ----------
        *names : str
            Variables to draw.

        Returns
        -------
        matplotlib.figure.Figure
            With units on its axes.

        Examples
        --------
        >>> import numpy as np
        >>> import pneumatic_servo as ps
        >>> masses = {"mass.moving": np.linspace(0.8, 1.2, 20)}
        >>> runs = ps.Model().simulate_many(masses, inputs={"valveVoltage": 6}, stop=0.1, step=1e-3)
        >>> runs.plot("position").savefig("band.png")
        """
        from pneumatic_servo.figures import draw_runs

        usual = [name for name in ("position", "velocity", "frictionForce") if name in self.variables]
        chosen = list(names) or usual or list(self.variables)[:3]
        for name in chosen:
            _place(self.variables, name)
        begun = [run for run in self if len(run)]
        if not begun:
            raise ValueError("none of the runs has begun, and there is nothing to draw")
        return draw_runs(begun, chosen)

    def to_xarray(self) -> xarray.Dataset:
        """Return a dataset of xarray: variables over run and time, with their units.

        Parameters that differ between the runs are coordinates along ``run``, those that all share are attributes.
        Rows that a run does not have are NaN. Inputs are those in force up to each row.

        Examples
        --------
        >>> import pneumatic_servo as ps
        >>> masses = {"mass.moving": [0.8, 1.2]}
        >>> runs = ps.Model().simulate_many(masses, inputs={"valveVoltage": 6}, stop=0.1, step=1e-3)
        >>> data = runs.to_xarray()
        >>> dict(data.sizes), data["position"].attrs["units"]
        ({'run': 2, 'time': 101}, 'm')
        >>> heavy = data.swap_dims(run="mass.moving").sel({"mass.moving": 1.2})
        """
        try:
            import xarray
        except ImportError as error:
            raise MissingPackage("xarray", "xarray") from error
        differing = self.parameters
        data = {
            name: (("run", "time"), self._of_all(name), {"units": variable.unit, "long_name": variable.text})
            for name, variable in self.variables.items()
        }
        of_runs = {name: ("run", column) for name, column in differing.items() if name not in data}
        coordinates = {"run": self.numbers, "time": ("time", self.time, {"units": "s"}), **of_runs}
        shared = self._settings[0] if self._settings else {}
        common = {name: value for name, value in shared.items() if name not in differing}
        return xarray.Dataset(data, coordinates, common)

    def _repr_html_(self) -> str:
        cells = (
            [name, f"{np.nanmin(self._of_all(name)):.6g}", f"{np.nanmax(self._of_all(name)):.6g}", variable.unit]
            for name, variable in self.variables.items()
        )
        head = f"<p>{len(self)} runs of {len(self.time)} rows; {len(self.failures)} could not go on</p>"
        return head + table(["", "least", "most", "unit"], cells)

    def _ipython_key_completions_(self) -> list[str]:
        return list(self.variables)

    def __repr__(self) -> str:
        return f"<{len(self)} runs of {len(self.time)} rows: {', '.join(self.variables)}>"


def _each(course: Any, places: Sequence[int], count: int) -> Any:
    """Return an input of some of many runs: a constant, one per run, or times and rows."""
    if isinstance(course, tuple):
        return course if len(course[1]) != count else (course[0], course[1][list(places)])
    return course[list(places)] if isinstance(course, np.ndarray) else course


def of_run(course: Any, index: int, count: int) -> Any:
    """Return an input of one of many runs."""
    if isinstance(course, tuple):
        times, rows = course
        return times, rows[index if len(rows) == count else 0]
    return float(course[index]) if isinstance(course, np.ndarray) else course


def table(head: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """Return a table for notebooks."""
    first = "".join(f"<th>{escape(cell)}</th>" for cell in head)
    others = ("<tr>" + "".join(f"<td>{escape(cell)}</td>" for cell in row) + "</tr>" for row in rows)
    return f"<table><tr>{first}</tr>{''.join(others)}</table>"


def _kind(variables: Variables, name: str) -> str:
    _place(variables, name)
    return variables[name].kind


def _place(variables: Variables, name: str) -> int:
    if name not in variables:
        raise KeyError(f"{name} was not recorded{did_you_mean(str(name), variables)}; there are {', '.join(variables)}")
    return list(variables).index(name)
