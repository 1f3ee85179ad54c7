"""Inputs as users write them, checked and brought into the form that the extension module takes."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from reprlib import repr as shortened
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pneumatic_servo import values
from pneumatic_servo.argument_names import quoted
from pneumatic_servo.checks import mapping
from pneumatic_servo.chosen_columns import Column, columns_of
from pneumatic_servo.columns import Table
from pneumatic_servo.errors import Refused, warn
from pneumatic_servo.grid import Grid
from pneumatic_servo.names import did_you_mean
from pneumatic_servo.plant_warnings import warn_ends, warn_saturation
from pneumatic_servo.run import Run, between_rows, held_from
from pneumatic_servo.tables import is_counted, numbers, of_arrays, read_table, table_of
from pneumatic_servo.units import in_unit, is_quantity, magnitude, to_si
from pneumatic_servo.variables import Value, Variable, Variables

Array = NDArray[np.float64]

Input = Any
"""An input over time: a constant, points ``(t, u)`` or ``(t, u, "bar")``, a function of time in s, an array with the
columns t and u, or a pandas Series over time. A constant may have a unit, ``"6 bar"`` or ``(6, "bar")``.

Points are joined by straight lines; beyond them the value at the end holds; of points at the same time the last counts,
so that a pair of them makes a step. ``{"hold": points}`` holds the value of each point until the next one instead, as
measured commands are, and ``{"lines": points}`` says by name what points do anyway. An input that is true or false
(``coil[1]``) is always held.

As a host applies it to an FMU, the value at each communication point is held over the step that begins there.
"""
FORMS_OF_POINTS = ("hold", "lines")
ULPS = 8.0
"""Units in the last place by which held points count earlier, since communication points are rounded."""
Values = Any
"""A value that all runs share, or one per run; with a unit as for one."""
Inputs = Mapping[str, Input]


def inputs_of(
    argument: str, variables: Variables, given: object, columns: str | Mapping[str, str] | None = None,
    begin: float = 0.0,
) -> dict[str, Input]:  # fmt: skip
    """Return inputs by name, from a mapping, a table in a file, a DataFrame, or a run whose inputs are to be replayed.

    Of tables and runs only the columns of inputs are taken; what else the model has is ignored. `columns` say which
    those of a table are, and `begin` when the run begins, in s.
    """
    table = None
    if isinstance(given, str | Path):
        table = read_table(given)
    elif not isinstance(given, Run):
        table = table_of(given, "the DataFrame")
    if table is None and columns is not None and isinstance(given, Mapping) and _are_columns(given):
        table = of_arrays(Path("the inputs"), given)
    if table is not None:
        return of_table(variables, table, columns, begin)[0]
    if columns is not None:
        raise ValueError(f"{quoted('columns')}: these inputs are no table, so that they have no columns")
    if isinstance(given, Run):
        return replayed(variables, given)
    named: dict[str, Input] = mapping(argument, given)  # type: ignore[arg-type]
    for name in named:
        _refuse_parameter(argument, variables, name)
    return named


def _are_columns(given: Mapping[str, object]) -> bool:
    return all(np.ndim(values) == 1 for values in given.values() if not is_quantity(values))  # type: ignore[arg-type]


def _refuse_parameter(argument: str, variables: Variables, name: str) -> None:
    """Refuse a parameter in the place of an input, and say where it belongs."""
    role = variables[name].role if isinstance(name, str) and name in variables else ""
    if role == "tunable":
        raise ValueError(
            f"{argument}: {name} is a parameter, not an input: give it among the parameters; to change it in a run, "
            f"set it between steps: plant = model.start(...), plant[{name!r}] = ..."
        )
    if role == "fixed":
        raise ValueError(f"{argument}: {name} is a parameter, not an input: give it among the parameters")


def replayed(variables: Variables, run: Run) -> dict[str, Input]:
    """Return the inputs of a run as they were given: a row has the values up to it."""
    names = [name for name in run.variables if variables.get(name) is not None and variables[name].role == "input"]
    if not names:
        raise ValueError(f"the run has no input among what it recorded: {', '.join(run.variables)}")
    return {name: run.replayed(name) for name in names}


def has_lines(given: object) -> bool:
    """Tell whether inputs are a run whose inputs ran on straight lines from row to row."""
    return isinstance(given, Run) and given.has_lines


def of_table(
    variables: Variables, table: Table, columns: str | Mapping[str, str] | None = None, begin: float = 0.0
) -> tuple[dict[str, Input], float]:
    """Return the inputs of a table, and its last time in s; errors name file, line, column, variable and value.

    A table that begins after the run is counted from its first time on, which a warning tells.
    """
    chosen = _by_name(variables, table) if columns is None else _as_said(variables, table, columns)
    if not len(table.values):
        raise ValueError(f"{table.file}: there are no rows below the header")
    at, own = chosen.pop("time")
    main = _times(table, at, own.unit)
    late = max(0.0, float(main[0]) - begin)
    if late > 0.0:
        warn(f"{table.file}: its first time is {main[0]:g} s, which counts as {begin:g} s, where the run starts")
    if between := [table.names[place] for place, _ in chosen.values() if table.names[place] in table.between]:
        raise ValueError(f"{table.file}: {between_rows(between)}")
    inputs: dict[str, Input] = {}
    for name, (place, column) in chosen.items():
        variable = variables[name]
        if variable.kind == "boolean" and not np.isnan(table.values[:, place]).any():
            found = np.ascontiguousarray(table.values[:, place])
        else:
            column.is_calibrated(table.units[place], f"{table.file}:{table.first}, column {table.names[place]}")
            unit = column.unit or table.units[place] or variable.unit
            found = table.in_si(place, unit, variable.unit, has_gaps=columns is not None)
        found = -found if column.turned else found
        if table.is_recorded:
            found = held_from(found)
        clock = table.clocks.get(place, at) if table.clocks else at
        times = main if clock == at else _times(table, clock, None)
        # A channel that is slower than others, or has a clock of its own, has fewer samples.
        known = np.flatnonzero(~np.isnan(found)) if place in table.gaps or table.clocks else np.arange(len(times))
        if not len(known):
            raise ValueError(f"{table.file}: {table.names[place]} has no sample")
        _check_column(variable, found[known], table, place, known)
        inputs[name] = (times[known] - late, found[known])
    return inputs, float(main[-1]) - late


def _times(table: Table, place: int, unit: str | None) -> Array:
    """Return the samples of a clock, in s; refuse times that fall."""
    times = table.in_si(place, unit or table.units[place] or "s", "s")
    times = times[np.isfinite(times)] if table.clocks else times
    falls = np.flatnonzero(np.diff(times) < 0.0)
    if len(falls):
        row = int(falls[0]) + 1
        raise ValueError(f"{table.where(row, place)}: time falls from {times[row - 1]} s to {times[row]} s")
    return times


def _as_said(variables: Variables, table: Table, columns: str | Mapping[str, str]) -> dict[str, tuple[int, Column]]:
    """Return places and columns by the names of inputs, and of time, as somebody chose them."""
    known = ["time", *(name for name in variables if variables[name].role == "input")]
    chosen = {name: column.place(name, table) for name, column in columns_of(columns, known).items()}
    if len(chosen) == 1:
        raise ValueError(f"{quoted('columns')}: no column is given for an input; the inputs are {', '.join(known[1:])}")
    return chosen


def _by_name(variables: Variables, table: Table) -> dict[str, tuple[int, Column]]:
    """Return the same of columns with the names of inputs."""
    place = f"{table.file}:{table.first}"
    for number, name in enumerate(table.names):
        if name and table.names.index(name) != number:
            raise ValueError(f"{place}, column {number + 1}: {name} is there twice")
    if "time" not in table.names:
        hint = did_you_mean("time", table.names) or (
            f"; did you mean {table.names[0]}?" if "t" in table.names[:1] else ""
        )
        raise ValueError(
            f"{place}: there is no column `time`, only {', '.join(filter(None, table.names)) or 'an empty line'}{hint}"
        )
    inputs = [name for name in variables if variables[name].role == "input"]
    chosen = {name: (number, Column(name, None)) for number, name in enumerate(table.names) if name in inputs}
    for number, name in enumerate(table.names, start=1):
        # A column without a name holds the numbers of the rows, as pandas writes them.
        if name and name != "time" and name not in variables:
            raise ValueError(
                f"{place}, column {number}: {name} is not an input{did_you_mean(name, variables)}; "
                f"the inputs are {', '.join(inputs)}"
            )
    if not len(table.values):
        raise ValueError(f"{table.file}: there are no rows below the header")
    if not chosen:
        raise ValueError(f"{place}: there is no column of an input; the inputs are {', '.join(inputs)}")
    return {"time": (table.names.index("time"), Column("time", None)), **chosen}


def _check_column(variable: Variable, column: Array, table: Table, place: int, rows: NDArray[np.int64]) -> None:
    wrong = _illegal(variable, column)
    if wrong is not None:
        try:
            values.check_range(variable, float(column[wrong]))
        except Refused as error:
            raise ValueError(
                f"{table.where(int(rows[wrong]), place)}: {column[wrong]} {variable.unit} is refused: {error.reason}"
            ) from None


def _illegal(variable: Variable, column: Array) -> int | None:
    legal = np.isfinite(column)
    if variable.kind == "boolean":
        legal &= np.isin(column, (0.0, 1.0))
    if variable.minimum is not None:
        legal &= column >= variable.minimum
    if variable.maximum is not None:
        legal &= column <= variable.maximum
    return None if legal.all() else int(np.argmin(legal))


def course(inputs: Variables, name: str, given: Input) -> float | tuple[Array, Array] | Callable[[float], float]:
    """Check one input of a single run."""
    variable = _find(inputs, name)
    given = _as_points_of(variable, given)
    if callable(given):
        return lambda time: _at(variable, given, time)
    if _is_constant_with_unit(given):
        return values.number(variable, given)
    if isinstance(given, tuple):
        times, column = points(variable, given)
        if column.ndim != 1:
            raise ValueError(
                f"{name}: values have the shape {column.shape}, but one run takes as many as there are times"
            )
        return times, column
    return _constant(variable, given)


def courses(
    inputs: Variables, name: str, given: Input | ArrayLike, number: int, grid: Grid
) -> float | Array | tuple[Array, Array]:
    """Check one input of many runs; a function is called once per communication point, for all runs."""
    variable = _find(inputs, name)
    given = _as_points_of(variable, given)
    if callable(given):
        times = grid.points()
        rows = np.array([[_at(variable, given, time) for time in times.tolist()]])
        return times, rows
    if _is_constant_with_unit(given):
        return values.number(variable, given)
    if isinstance(given, tuple) and len(given) == 2 and isinstance(given[1], str):
        return _one_per_run(variable, _numbers(variable, given[0], given[1]), number)
    if isinstance(given, tuple):
        times, column = points(variable, given)
        rows = column.reshape(1, -1) if column.ndim == 1 else column
        if rows.shape[0] not in (1, number):
            raise ValueError(f"{name}: values have the shape {column.shape}, but there are {number} runs")
        return times, np.ascontiguousarray(rows)
    if len(shape(name, given)) == 0:
        return _constant(variable, given)
    return _one_per_run(variable, _numbers(variable, given), number)


def first_of(driven: Mapping[str, Any]) -> dict[str, float]:
    """Return the first value of inputs of one run, as `course` returns them; of functions of time none."""
    columns = {name: one[1][:1] if isinstance(one, tuple) else one for name, one in driven.items() if not callable(one)}
    return {name: float(np.squeeze(one)) for name, one in columns.items()}


def extremes_of(driven: Mapping[str, Any]) -> dict[str, tuple[float, float]]:
    """Return the least and the largest value of inputs, as `courses` returns them; functions of time have none."""
    columns = {name: one[1] if isinstance(one, tuple) else one for name, one in driven.items() if not callable(one)}
    return {name: (float(np.min(one)), float(np.max(one))) for name, one in columns.items()}


def tell_unusual(variables: Variables, driven: Mapping[str, Any], grid: Grid) -> None:
    """Warn of inputs, as `course` and `courses` return them, that end early or begin late, or saturate."""
    for name, given in driven.items():
        variable = variables[name]
        if callable(given):
            continue
        if isinstance(given, tuple):
            warn_ends(variable, given[0], grid)
        column = given[1] if isinstance(given, tuple) else given
        warn_saturation(variable, float(np.min(column)), float(np.max(column)))


def _one_per_run(variable: Variable, column: Array, number: int) -> Array:
    if column.shape != (number,):
        hint = "; points of several runs are (t, u) with u of shape (runs, times)" if column.ndim > 1 else ""
        raise ValueError(
            f"{variable.name}: there are {number} runs, but the values have the shape {column.shape}{hint}"
        )
    for run, value in enumerate(column):
        try:
            values.check_range(variable, float(value))
        except ValueError as error:
            raise ValueError(f"run {run} of {number}: {error}") from None
    return column


def _as_points_of(variable: Variable, given: Any) -> Any:
    try:
        return _as_points(given)
    except (TypeError, ValueError) as error:
        raise ValueError(f"{variable.name}: {error}") from None


def _as_points(given: Any) -> Any:
    """Return points for a Series over time and for an array with two columns; all else as it is."""
    if isinstance(given, Mapping):
        return _formed(given)
    if hasattr(given, "index") and hasattr(given, "to_numpy"):
        if is_counted(given.index):
            raise ValueError("a Series must have times as its index; one of values alone is series.to_numpy()")
        return seconds_of(given.index), given.to_numpy()
    if isinstance(given, np.ndarray) and given.ndim == 2 and given.shape[1] == 2:
        return given[:, 0], given[:, 1]
    return given


def _formed(given: Mapping[str, Any]) -> tuple[Any, ...]:
    """Return the points of ``{"hold": points}`` or ``{"lines": points}``, joined by lines."""
    form = next(iter(given), None)
    if len(given) != 1 or form not in FORMS_OF_POINTS:
        raise ValueError(
            f"an input {shortened(dict(given))} is refused: it must be {{'hold': (t, u)}} or {{'lines': (t, u)}}"
        )
    pair = _as_points(given[form])
    pair = _with_one_unit(pair) if isinstance(pair, tuple) else pair
    if not isinstance(pair, tuple) or len(pair) not in (2, 3) or np.ndim(pair[0]) != 1 or isinstance(pair[1], str):
        raise ValueError(f"an input {{{form!r}: {shortened(given[form])}}} is refused: it must have points (t, u)")
    return held(pair) if form == "hold" else pair


def held(points: tuple[Any, ...]) -> tuple[Any, ...]:
    """Return points whose straight lines hold each value until the next point."""
    times = magnitude(points[0], "s", "time") if is_quantity(points[0]) else seconds_of(points[0])
    ends = times[1:] - ULPS * np.spacing(np.abs(times[1:]))
    stepped = np.repeat(times, 2)[:-1]
    stepped[1::2] = stepped[2::2] = ends
    places = np.repeat(np.arange(len(times)), 2)[:-1]
    if is_quantity(points[1]) and isinstance(points[1], list):
        return (stepped, [points[1][place] for place in places], *points[2:])
    values = points[1] if is_quantity(points[1]) else np.asanyarray(points[1])
    return (stepped, values[..., places], *points[2:])


def seconds_of(times: Any) -> Any:
    """Return times in s; of dates the seconds since the first, of durations their seconds, else the given values."""
    if getattr(times, "tz", None) is not None:
        times = times.tz_convert(None)
    return numbers(times)


def _is_constant_with_unit(given: Any) -> bool:
    """Tell whether something is ``"6 bar"``, ``(6, "bar")``, or a single quantity of pint."""
    if isinstance(given, str):
        return any(letter.isalpha() for letter in given)
    if isinstance(given, tuple):
        return len(given) == 2 and isinstance(given[1], str) and np.ndim(given[0]) == 0
    return is_quantity(given) and not isinstance(given, list) and np.ndim(getattr(given, "magnitude", given)) == 0


def points(variable: Variable, given: tuple[Any, ...]) -> tuple[Array, Array]:
    """Check times and values; the last axis of the values is the time. True and false are held between the points."""
    given = _with_one_unit(given)
    unit = given[2] if len(given) == 3 and isinstance(given[2], str) else None
    if len(given) != 2 and unit is None:
        raise ValueError(f"{variable.name}: points are a pair of times and values, not {len(given)} arrays")
    if np.ndim(given[0]) == 0 and not is_quantity(given[0]):
        raise ValueError(
            f"{variable.name} = {shortened(given)} is refused: points are arrays of times and values, ([0, 1], "
            "[5, 6]); one value for each of several runs is a list or an array, [5, 6]"
        )
    moments = given[0]
    if is_quantity(moments):
        moments = magnitude(moments, "s", "time")
    elif not isinstance(moments, np.ma.MaskedArray) and np.asarray(moments).dtype.kind in "mMOU":
        moments = _seconds(variable, moments)
    times = _numbers(variable, moments)
    column = _numbers(variable, given[1], unit)
    if times.ndim != 1 or not len(times) or column.ndim not in (1, 2) or column.shape[-1] != len(times):
        raise ValueError(f"{variable.name}: times of shape {times.shape} do not fit values of shape {column.shape}")
    wrong = np.flatnonzero(~np.isfinite(times))
    if len(wrong):
        raise ValueError(f"{variable.name}: time {wrong[0]} is {times[wrong[0]]}")
    back = np.flatnonzero(np.diff(times) < 0.0)
    if len(back):
        raise ValueError(
            f"{variable.name}: time falls from {times[back[0]]} s to {times[back[0] + 1]} s at point {back[0] + 1}"
        )
    bad = _illegal(variable, column.reshape(-1))
    if bad is not None:
        place = np.unravel_index(bad, column.shape)
        values.check_range(variable, float(column[place]), float(times[place[-1]]))
    if variable.kind == "boolean":
        times, column = held((times, column))
        return times, np.ascontiguousarray(column)
    return times, column


def _with_one_unit(given: tuple[Any, ...]) -> tuple[Any, ...]:
    """Return points as ``(t, u)`` or ``(t, u, unit)`` with t in s, also of ``((t, "ms"), (u, "mV"))``."""
    if given and _has_unit_behind(given[0]):
        in_s = [to_si(float(one), given[0][1], "s", "time") for one in np.ravel(given[0][0])]
        given = (np.array(in_s), *given[1:])
    return (given[0], *given[1]) if len(given) == 2 and _has_unit_behind(given[1]) else given


def _has_unit_behind(given: Any) -> bool:
    """Tell whether something is numbers with one unit, ``([0, 100], "ms")``."""
    return isinstance(given, tuple) and len(given) == 2 and isinstance(given[1], str) and not isinstance(given[0], str)


def _seconds(variable: Variable, moments: Any) -> Array:
    try:
        return np.asarray(seconds_of(moments))
    except (TypeError, ValueError) as error:
        raise ValueError(f"{variable.name}: the times {shortened(moments)} are refused: {error}") from None


FORMS = "a constant, a pair (t, u) of times and values, or a function of time"


def _constant(variable: Variable, given: Any) -> float:
    """Return the value of an input that stays the same."""
    if variable.kind == "boolean":
        return values.flag(variable, given)
    if not values.is_number(given):
        raise ValueError(
            f"{variable.name} = {shortened(given)} is refused: it must be {FORMS}, in {variable.unit} or with a unit"
        )
    values.check_range(variable, float(given))
    return float(given)


def shape(name: str, given: Any) -> tuple[int, ...]:
    """Return the shape of a given input."""
    try:
        return np.shape(given)
    except ValueError as error:
        raise ValueError(f"{name} = {shortened(given)} is refused: {error}") from None


def _at(variable: Variable, given: Callable[[float], float], time: float) -> float:
    """Return the values of a function of time."""
    value = given(time)
    if type(value) is not float:
        value = value.item() if getattr(value, "size", 0) == 1 and hasattr(value, "item") else value
        if variable.kind == "boolean" and isinstance(value, bool):
            return float(value)
        if not values.is_number(value):
            raise ValueError(f"at t = {time:g} s {variable.name} = {shortened(value)} is refused: it must be a number")
        value = float(value)
    values.check_range(variable, value, time)
    return value


def _numbers(variable: Variable, given: Any, unit: str | None = None) -> Array:
    """Return an array of numbers in SI units."""
    if is_quantity(given):
        given = magnitude(given, variable.unit, variable.name)
    _check_kind(variable, given)
    try:
        found = np.ascontiguousarray(given, dtype=float)
    except (TypeError, ValueError) as error:
        raise ValueError(
            f"{variable.name} = {shortened(given)} is refused: it must be numbers in {variable.unit}, or "
            f"(t, u, unit); {error}"
        ) from None
    if unit is None:
        return found
    convert = np.vectorize(lambda value: to_si(value, unit, variable.unit, variable.name), otypes=[float])
    return np.asarray(convert(found))


KINDS = {"b": "true and false", "c": "complex", "m": "durations", "M": "dates"}


def _check_kind(variable: Variable, given: Any) -> None:
    """Refuse arrays that NumPy makes numbers of, though they are none, and those with masked values."""
    if isinstance(given, np.ma.MaskedArray) and np.ma.is_masked(given):
        masked = np.argwhere(given.mask)[0].tolist()
        raise ValueError(
            f"{variable.name}: value {masked[0] if len(masked) == 1 else masked} is masked; fill it, or leave it out"
        )
    try:
        kind = np.asarray(given).dtype.kind
    except ValueError:
        return
    if kind in KINDS and not (kind == "b" and variable.kind == "boolean"):
        raise ValueError(
            f"{variable.name} = {shortened(given)} is refused: the values are {KINDS[kind]}; they must be numbers"
            f"{in_unit(variable.unit)}"
        )


def settings_of_runs(
    variables: Variables, parameters: Any, number: int | None, of_one: Callable[[Any, str], dict[str, Value]]
) -> list[dict[str, Value]]:
    """Return the settings of each of many runs, from a list of them or from arrays that hold one value per run.

    `of_one` reads the settings of one run.
    """
    if hasattr(parameters, "columns") and hasattr(parameters, "iloc"):
        parameters = {str(name): parameters[name].tolist() for name in parameters.columns}
    if isinstance(parameters, str) or not isinstance(parameters, Mapping | Sequence):
        hint = "; what all runs share is given by common=" if hasattr(parameters, "settings") else ""
        raise TypeError(f"parameters must be mappings of names to values, not {shortened(parameters)}{hint}")
    if isinstance(parameters, list) and not parameters and number is None:
        raise ValueError("parameters is empty: there are no runs; `number` says how many of the same there are")
    if not isinstance(parameters, Mapping) and len(parameters):
        return [_settings_of_run(of_one, own, run, len(parameters)) for run, own in enumerate(parameters)]
    several: dict[str, list[object]] = {}
    shared: dict[str, Value] = {}
    for name, value in parameters.items() if isinstance(parameters, Mapping) else ():
        each = _per_run(value)
        if each is None:
            shared[name] = values.value_of(variables, name, value)
        elif each:
            several[name] = each
        else:
            raise ValueError(f"parameters: {name} is empty: there are no runs")
    lengths = {name: len(every) for name, every in several.items()}
    counts = set(lengths.values()) | (set() if number is None else {number})
    if len(counts) > 1:
        told = "" if number is None else f" The inputs, or `number`, are for {number} runs,"
        raise ValueError(f"how many runs?{told} The parameters have values for {lengths}".replace(", The", ", the"))
    runs = range(counts.pop() if counts else 1)
    own = {name: _each(variables, name, every) for name, every in several.items()}
    return [shared | {name: every[run] for name, every in own.items()} for run in runs]


def _each(variables: Variables, name: str, given: Sequence[object]) -> list[Value]:
    """Return the values of a parameter in each run; a refusal tells which run it is."""
    found: list[Value] = []
    for run, value in enumerate(given):
        try:
            one = values.value_of(variables, name, value)
            if isinstance(one, float) and name in variables:
                values.check_range(variables[name], one)
        except ValueError as error:
            raise ValueError(f"run {run} of {len(given)}: {error}") from None
        found.append(one)
    return found


def _settings_of_run(
    of_one: Callable[[Any, str], dict[str, Value]], given: Any, run: int, number: int
) -> dict[str, Value]:
    """Return the settings of one run; a refusal tells which it is."""
    try:
        return of_one(given, f"parameters[{run}]")
    except ValueError as error:
        raise ValueError(f"run {run} of {number}: {error}") from None


def _per_run(value: Any) -> list[object] | None:
    """Return the values of all runs, or nothing for one that they share."""
    if isinstance(value, bool | int | float | str):
        return None
    if isinstance(value, tuple) and len(value) == 2 and isinstance(value[1], str) and _is_unit(value):
        return None if np.ndim(value[0]) == 0 else [(one, value[1]) for one in value[0]]
    if is_quantity(value):
        return None if np.ndim(value.magnitude) == 0 else list(value)
    return None if np.ndim(value) == 0 else list(value)


def _is_unit(pair: tuple[Any, Any]) -> bool:
    """Tell whether a pair is numbers with a unit, and not two names, for example of laws."""
    return not isinstance(pair[0], str)


def _find(inputs: Variables, name: str) -> Variable:
    if name not in inputs:
        raise ValueError(f"{name} is not an input{did_you_mean(str(name), inputs)}; the inputs are {', '.join(inputs)}")
    return inputs[name]
