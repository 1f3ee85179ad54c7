"""Measured tables: which column is which signal, and the numbers in SI units."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pneumatic_servo.argument_names import quoted
from pneumatic_servo.columns import Table, names_and_units
from pneumatic_servo.identification.signals import SIGNALS, si_of
from pneumatic_servo.names import did_you_mean
from pneumatic_servo.run import Run, held_from
from pneumatic_servo.tables import numbers, of_frame, read_table
from pneumatic_servo.units import scale

Array = NDArray[np.float64]

DRIVEN = ("valveVoltage", "supplyPressure", "externalForce")
"""Recorded values of inputs, in force up to each row."""


@dataclass(frozen=True)
class Column:
    """A column of a table: its name, its unit if one is given, and whether its sign is the opposite of ours.

    `typed` is how somebody wrote it, which may be what stands in the table, with the unit there.
    """

    name: str
    unit: str | None
    turned: bool = False
    typed: str = field(default="", compare=False)

    @staticmethod
    def of(signal: str, text: str) -> Column:
        """Read `column`, `column[unit]`, or either with a minus before it."""
        where = quoted("columns", f"{signal}={text}")
        if signal not in SIGNALS:
            raise ValueError(
                f"{where}: there is no signal {signal}{did_you_mean(signal, SIGNALS)}; there are {', '.join(SIGNALS)}"
            )
        match = re.fullmatch(r"(-?)\s*(.+?)\s*(?:\[([^\[\]]*)\])?", text.strip())
        if match is None:
            raise ValueError(f"{where}: it must be {signal}=column or {signal}=column[unit]")
        return Column(match[2], match[3], bool(match[1]), text.strip())

    def among(self, signal: str, header: Sequence[str], names: Sequence[str]) -> tuple[list[int], Column]:
        """Return the places of the columns that are meant, and this as it is meant there.

        The whole text may stand in the header; otherwise its name does, with a unit behind it or without.
        """
        for text in (self.typed, self.typed.removeprefix("-").lstrip()):
            exact = [place for place, one in enumerate(header) if text and one == text]
            if exact:
                return exact, replace(self, name=text, unit=None, turned=text != self.typed)
        if self.unit is not None:
            si_of(signal, self.unit, quoted("columns", f"{signal}={self.typed}"))
        for known in (header, names):
            found = [place for place, one in enumerate(known) if one == self.name]
            if found:
                return found, self
        return [], self


def columns_of(given: str | Mapping[str, str]) -> dict[str, Column]:
    """Read which column is which signal, from `signal=column[unit],...` or a mapping."""
    if isinstance(given, str):
        pairs = [word.partition("=") for word in given.split(",") if word]
        wrong = next((word for word, equals, _ in pairs if not equals), None)
        if wrong is not None:
            raise ValueError(f"{quoted('columns', wrong)}: it must be signal=column or signal=column[unit]")
        names = [name.strip() for name, _, _ in pairs]
        twice = next((name for name in names if names.count(name) > 1), None)
        if twice is not None:
            raise ValueError(f"{quoted('columns')}: {twice} is given twice")
        given = {name.strip(): text for name, _, text in pairs}
    if not isinstance(given, Mapping):
        raise TypeError(f"columns must be a text or a mapping of signals to columns, not {given!r}")
    columns = {signal: Column.of(signal, str(text)) for signal, text in given.items()}
    seen: dict[str, str] = {}
    for signal, column in columns.items():
        first = seen.setdefault(column.typed.removeprefix("-").lstrip(), signal)
        if first != signal:
            raise ValueError(f"{quoted('columns')}: {column.name} is given for {first} and for {signal}; which is it?")
    if "time" not in columns:
        raise ValueError(f"{quoted('columns')}: no column is given for time, for example time=t")
    return columns


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
        Column and unit of each signal as they stand in the table, for people.
    stated : dict
        The SI unit of each signal whose unit somebody wrote, and where.
    """

    name: str
    signals: Mapping[str, Array]
    where: Callable[[str, int], str]
    written: Mapping[str, str] = field(default_factory=dict)
    stated: Mapping[str, tuple[str, str]] = field(default_factory=dict)


def measured(number: int, source: Any, columns: Mapping[str, Column] | None, encoding: str | None = None) -> Measured:
    """Return the signals of a file, a table of pandas, a run, or a mapping of arrays."""
    if isinstance(source, Run):
        return _of_run(number, source)
    if isinstance(source, str | Path):
        return _of_table(read_table(source, encoding), Path(source).name, columns)
    if hasattr(source, "columns") and hasattr(source, "iloc"):
        return _of_table(of_frame(source, Path(f"record {number}")), f"record {number}", columns)
    if isinstance(source, Mapping):
        return _of_mapping(number, source, columns)
    raise TypeError(
        f"data must be a file, a DataFrame, a run, a mapping of arrays, or a list of those, not {type(source).__name__}"
    )


def _of_run(number: int, run: Run) -> Measured:
    signals = {"time": run.time}
    for name in run.variables:
        if name in SIGNALS:
            signals[name] = run.given(name)
    return Measured(f"record {number}", signals, lambda signal, row: f"record {number}, sample {row} of {signal}")


def _of_mapping(number: int, source: Mapping[str, Any], columns: Mapping[str, Column] | None) -> Measured:
    name = f"record {number}"
    header = [str(key) for key in source]
    names, units = names_and_units(header)
    meant = {signal: column.among(signal, header, names)[0] for signal, column in (columns or {}).items()}
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
        found, column = given.among(signal, header, names)
        if not found:
            raise ValueError(
                f"{quoted('columns')}: there is no array {column.name} for {signal}"
                f"{did_you_mean(column.name, names)}; there are {', '.join(header)}"
            )
        if len(found) > 1:
            raise ValueError(f"{name}: there are {len(found)} arrays {column.name}; which is {signal}?")
        where = f"{name}, {header[found[0]]}"
        unit = _unit_of(units[found[0]], signal, column, where)
        times, offset = 1.0, 0.0
        if unit is not None:
            si = si_of(signal, unit, where)
            times, offset = scale(unit, si, signal)
            stated[signal] = (si, quoted("columns", f"{signal}={column.name}[{column.unit}]") if column.unit else where)
        values = times * _numbers(header[found[0]], arrays[found[0]]) + offset
        signals[signal] = -values if column.turned else values
    places = {signal: columns[signal].name for signal in signals}
    return Measured(name, signals, lambda signal, row: f"{name}, sample {row} of {places[signal]}", stated=stated)


def _numbers(name: str, values: Any) -> Array:
    try:
        return numbers(values)
    except (TypeError, ValueError) as error:
        raise ValueError(f"{name} is refused: it must be numbers; {error}") from None


def _of_table(table: Table, name: str, columns: Mapping[str, Column] | None) -> Measured:
    found = {
        signal: _place(table, signal, column)
        for signal, column in (_by_name(table) if columns is None else columns).items()
    }
    places = {signal: place for signal, (place, _) in found.items()}
    chosen = {signal: column for signal, (_, column) in found.items()}
    if not len(table.values):
        raise ValueError(f"{table.file}: there are no rows below the header")
    signals, written, stated = {}, {}, {}
    for signal, column in chosen.items():
        place = places[signal]
        where = f"{table.file}:{table.first}, column {place + 1} ({table.names[place]})"
        unit = _unit_of(table.units[place], signal, column, where)
        si = SIGNALS[signal] if unit is None else si_of(signal, unit, where)
        values = table.in_si(place, unit or si, si)
        signals[signal] = -values if column.turned else values
        written[signal] = f"{column.name} in {unit or si}"
        if unit is not None:
            stated[signal] = (si, where)
    for signal in DRIVEN if table.is_recorded else ():
        if signal in signals:
            signals[signal] = held_from(signals[signal])
    _check_time(table, places["time"], chosen["time"])
    return Measured(name, signals, lambda signal, row: table.where(row, places[signal]), written, stated)


def _by_name(table: Table) -> dict[str, Column]:
    """Return the columns that have the names of signals."""
    found = {name: Column(name, None) for name in table.names if name in SIGNALS}
    if "time" not in found:
        there = ", ".join(table.header)
        raise ValueError(
            f"{table.file}:{table.first}: there is no column `time`, only {there}; {quoted('columns')} says "
            "which column is which signal, for example time=t,position=x[mm]"
        )
    return found


def _unit_of(written: str | None, signal: str, column: Column, where: str) -> str | None:
    """Return the unit of a column: as given or as written in the table, which must agree; None without either."""
    # Behind a pressure it is a chamber.
    if written == "A" and signal != "force":
        written = None
    if written is None or column.unit is None:
        return column.unit or written
    si = si_of(signal, written, where)
    if si != si_of(signal, column.unit, where) or scale(written, si, where) != scale(column.unit, si, where):
        raise ValueError(f"{where}: the table says {written}, {quoted('columns')} {column.unit}; which is it?")
    return column.unit


def _place(table: Table, signal: str, column: Column) -> tuple[int, Column]:
    found, column = column.among(signal, table.header, table.names)
    place = f"{table.file}:{table.first}"
    if not found:
        hint = did_you_mean(column.name, table.names)
        raise ValueError(
            f"{place}: there is no column {column.name} for {signal}{hint}; there are {', '.join(table.header)}"
        )
    if len(found) > 1:
        raise ValueError(f"{place}: there are {len(found)} columns {column.name}; which is {signal}?")
    return found[0], column


def _check_time(table: Table, place: int, column: Column) -> None:
    times = table.values[:, place]  # as written, for the message
    falls = np.flatnonzero(np.diff(times) <= 0.0)
    if len(falls):
        row = int(falls[0]) + 1
        unit = column.unit or table.units[place] or "s"
        raise ValueError(
            f"{table.file}:{table.lines[row]}, column {column.name}: time must rise, "
            f"but {times[row]} {unit} follows {times[row - 1]} {unit}"
        )


def listed(data: Any) -> Sequence[Any]:
    """Return a list of sources; a single one is one of them, also one of no kind, which is refused by itself."""
    is_single = isinstance(data, str | Path | Mapping | Run) or (hasattr(data, "columns") and hasattr(data, "iloc"))
    return list(data) if isinstance(data, Iterable) and not is_single else [data]
