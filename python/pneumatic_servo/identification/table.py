"""Measured tables: which column is which signal, and the numbers in SI units."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pneumatic_servo import _native
from pneumatic_servo.argument_names import quoted
from pneumatic_servo.chosen_columns import Column
from pneumatic_servo.columns import Table
from pneumatic_servo.errors import warn
from pneumatic_servo.identification.signals import SIGNALS, si_of
from pneumatic_servo.names import did_you_mean
from pneumatic_servo.run import Run, between_rows, held_from
from pneumatic_servo.tables import numbers, read_table, table_of
from pneumatic_servo.units import is_quantity, magnitude, scale

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Measured:
    """Signals in SI units, as they were measured.

    Attributes
    ----------
    name : str
        File of the table.
    signals : dict
        Arrays by name, ``time`` among them.
    where : callable
        Says where a sample of a signal stands, for people.
    written : dict
        Name and unit of the column of each signal, as they stand in the table.
    stated : dict
        The SI unit of each signal whose unit somebody wrote, and where.
    """

    name: str
    signals: Mapping[str, Array]
    where: Callable[[str, int], str]
    written: Mapping[str, tuple[str, str]] = field(default_factory=dict)
    stated: Mapping[str, tuple[str, str]] = field(default_factory=dict)


EXAMPLES = ("velocity=v[mm/s],frictionForce=F[N]", "time=t,position=x[mm]")
"""Columns of points, and of a course over time."""
LONG, FINE = 200_000, 1e-3
"""Samples from which on a record is thinned, to intervals in s that show how a carriage breaks away."""


def measured(
    number: int,
    source: Any,
    columns: Mapping[str, Column] | None,
    encoding: str | None = None,
    *,
    required: Sequence[str] = ("time",),
) -> Measured:
    """Return the signals of a source; a long one that is finer than 1 ms is thinned, which a warning tells.

    `required` are the signals of the experiment, of which ``time`` makes its tables courses over time.
    """
    found = _measured(number, source, columns, encoding, required)
    time = found.signals["time"] if "time" in found.signals else np.empty(0)
    if len(time) <= LONG:
        return found
    every = int(FINE / max(float(np.median(np.diff(time))), 1e-12) * (1.0 + 1e-9))
    if not 1 < every <= len(time) // 10:
        return found
    warn(
        f"{found.name}: of {len(time)} samples, {1e3 * FINE / every:.3g} ms apart, one of {every} is used; thin the "
        "table yourself for another choice"
    )
    thinned = {signal: np.ascontiguousarray(values[::every]) for signal, values in found.signals.items()}
    return replace(found, signals=thinned, where=lambda signal, row: found.where(signal, row * every))


def _measured(
    number: int, source: Any, columns: Mapping[str, Column] | None, encoding: str | None, required: Sequence[str]
) -> Measured:
    """Return the signals of a file, a table of pandas, a run, or a mapping of arrays."""
    if isinstance(source, Run):
        return _of_run(number, source)
    if isinstance(source, str | Path):
        return _of_table(read_table(source, encoding), Path(source).name, columns, required)
    if (table := table_of(source, f"record {number}")) is not None:
        return _of_table(table, f"record {number}", columns, required)
    if isinstance(source, Mapping):
        return _of_mapping(number, source, columns)
    raise TypeError(
        f"data must be a file, a DataFrame, a run, a mapping of arrays, or a list of those, not {type(source).__name__}"
    )


def _of_run(number: int, run: Run) -> Measured:
    signals, between = {"time": run.time}, run.inputs_between_rows()
    for name in run.variables:
        if name in SIGNALS:
            if name in between:
                raise ValueError(f"record {number}: {between_rows([name])}")
            signals[name] = run.given(name)
    return Measured(f"record {number}", signals, lambda signal, row: f"record {number}, sample {row} of {signal}")


def _of_mapping(number: int, source: Mapping[str, Any], columns: Mapping[str, Column] | None) -> Measured:
    name = f"record {number}"
    header = [str(key) for key in source]
    names, units = _native.names_and_units(header)
    meant = {signal: column.among(header, names)[0] for signal, column in (columns or {}).items()}
    if columns is None or (set(names) <= set(SIGNALS) and not all(meant.values())):
        unknown = next((key for key in names if key not in SIGNALS), None)
        if unknown is not None:
            raise ValueError(
                f"there is no signal {unknown}{did_you_mean(str(unknown), SIGNALS)}; there are {', '.join(SIGNALS)}; "
                "`columns` says which of the arrays is which signal"
            )
        columns = {key: Column(key, None) for key in names}
    signals, stated, arrays = {}, {}, list(source.values())
    for signal, given in columns.items():
        found, column = given.among(header, names)
        _check_unit(signal, column)
        if not found:
            raise ValueError(
                f"{quoted('columns')}: there is no array {column.name} for {signal}"
                f"{did_you_mean(column.name, names)}; there are {', '.join(header)}"
            )
        if len(found) > 1:
            raise ValueError(f"{name}: there are {len(found)} arrays {column.name}; which is {signal}?")
        where = f"{name}, {header[found[0]]}"
        unit = _unit_of(units[found[0]], signal, column, where)
        times, offset, array = 1.0, 0.0, arrays[found[0]]
        if is_quantity(array):
            array = magnitude(array, SIGNALS[signal], where)
        elif unit is not None:
            si = si_of(signal, unit, where)
            times, offset = scale(unit, si, signal, is_above_ambient=signal == _native.ABOVE_AMBIENT)
            stated[signal] = (si, quoted("columns", f"{signal}={column.name}[{column.unit}]") if column.unit else where)
        values = times * _numbers(header[found[0]], array) + offset
        signals[signal] = -values if column.turned else values
    places = {signal: columns[signal].name for signal in signals}
    return Measured(name, signals, lambda signal, row: f"{name}, sample {row} of {places[signal]}", stated=stated)


def _numbers(name: str, values: Any) -> Array:
    try:
        return numbers(values)
    except (TypeError, ValueError) as error:
        raise ValueError(f"{name} is refused: it must be numbers; {error}") from None


def _of_table(table: Table, name: str, columns: Mapping[str, Column] | None, required: Sequence[str]) -> Measured:
    found = {
        signal: column.place(signal, table)
        for signal, column in (_by_name(table, required) if columns is None else columns).items()
    }
    for signal, (_, column) in found.items():
        _check_unit(signal, column)
    places = {signal: place for signal, (place, _) in found.items()}
    chosen = {signal: column for signal, (_, column) in found.items()}
    if not len(table.values):
        raise ValueError(f"{table.file}: there are no rows below the header")
    wanted, written, stated = [], {}, {}
    for signal, column in chosen.items():
        place = places[signal]
        if table.names[place] in table.between:
            raise ValueError(f"{table.file}: {between_rows([table.names[place]])}")
        where = f"{table.file}:{table.first}, column {place + 1} ({table.names[place]})"
        unit = _unit_of(table.units[place], signal, column, where)
        si = SIGNALS[signal] if unit is None else si_of(signal, unit, where)
        wanted.append((signal, place, unit or si, si, column.turned))
        written[signal] = (column.name, unit or si)
        if unit is not None:
            stated[signal] = (si, where)
    signals, others = table.signals(wanted)
    if others:
        warn(
            f"{name}: {', '.join(others)} {'was' if len(others) == 1 else 'were'} read at other times than "
            f"{chosen['time'].name}; commands are held and readings run on straight lines between their samples"
        )
    # Recorded values of inputs are in force up to each row.
    for signal in _native.COMMANDS if table.is_recorded else ():
        if signal in signals:
            signals[signal] = held_from(signals[signal])
    return Measured(name, signals, lambda signal, row: table.where(row, places[signal]), written, stated)


def _by_name(table: Table, required: Sequence[str]) -> dict[str, Column]:
    """Return the columns that have the names of signals; without any, those with usual ones, which a warning tells."""
    found = {name: Column(name, None) for name in table.names if name in SIGNALS}
    first = required[0]
    if found.keys() <= {first}:
        usual = _native.proposed_columns(table.names, table.units, list(SIGNALS))
        if len(usual) > 1 and first in [signal for signal, *_ in usual]:
            told = ", ".join(f"{table.header[place]} for {signal}" for signal, place, _ in usual)
            warn(
                f"{table.file}:{table.first}: by their names columns are taken, {told}; {quoted('columns')} says others"
            )
            # A unit in the table is said there.
            return {
                signal: Column(table.names[place], None if unit == table.units[place] else unit)
                for signal, place, unit in usual
            }
    if first not in found:
        there = ", ".join(table.header)
        proposed = {signal for signal, *_ in _native.proposed_columns(table.names, table.units, list(SIGNALS))}
        is_of_points = {"velocity"} < proposed and not proposed & {"time", "position"}
        hint = "; points without a time are fitted as experiment points" if is_of_points else ""
        raise ValueError(
            f"{table.file}:{table.first}: there is no column `{first}`, only {there}; {quoted('columns')} "
            f"says which column is which signal, for example {EXAMPLES[first == 'time']}{hint}"
        )
    return found


def _unit_of(written: str | None, signal: str, column: Column, where: str) -> str | None:
    """Return the unit of a column, as given or else as written in the table; None without either.

    A given unit that differs from the written one counts, and a warning tells; one of another quantity is refused.
    """
    # Behind a pressure it is a chamber.
    if written == "A" and signal != "force":
        written = None
    if column.unit is None:
        if written is not None:
            try:
                si_of(signal, written, where)
            except ValueError as error:
                raise ValueError(
                    f"{error}; {quoted('columns')} says which it is, {signal}={column.name}[{SIGNALS[signal]}]"
                ) from None
        return written
    if column.is_calibrated(written, where):
        return column.unit
    if written is not None and not _is_same_unit(written, column.unit, signal, where):
        if _is_of_another(written, column.unit, signal, where):
            raise ValueError(f"{where}: the table says {written}, {quoted('columns')} {column.unit}; which is it?")
        warn(f"{where}: the table says {written}, {quoted('columns')} {column.unit}, which counts")
    return column.unit


def _is_of_another(one: str, other: str, signal: str, where: str) -> bool:
    """Tell whether two units of a signal are of different quantities, as m and deg."""
    try:
        return si_of(signal, one, where) != si_of(signal, other, where)
    except ValueError:
        return False


def _is_same_unit(one: str, other: str, signal: str, where: str) -> bool:
    """Tell whether two units of a signal are the same; an unknown one is not."""
    try:
        si = si_of(signal, one, where)
        return scale(one, si, where) == scale(other, si, where)
    except ValueError:
        return False


def _check_unit(signal: str, column: Column) -> None:
    """Refuse a given unit that the signal does not have."""
    if column.unit is not None:
        si_of(signal, column.unit, quoted("columns", f"{signal}={column.typed}"))


def listed(data: Any) -> Sequence[Any]:
    """Return a list of sources; a single one is one of them, also one of no kind, which is refused by itself."""
    is_single = isinstance(data, str | Path | Mapping | Run | np.ndarray) or hasattr(data, "columns")
    is_single = is_single or hasattr(data, "to_pandas")
    return list(data) if isinstance(data, Iterable) and not is_single else [data]
