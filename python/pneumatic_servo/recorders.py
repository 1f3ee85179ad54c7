"""Texts that a plain table is none of: LabVIEW .lvm, TwinCAT Scope, Tektronix, tables of Modelica.

Each gives lists of names, units, columns and, where channels have clocks of their own, which column that is.
"""

from __future__ import annotations

import csv
import re
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from pneumatic_servo.columns import Table
from pneumatic_servo.numerals import finite

Array = NDArray[np.float64]
Lines = Sequence[str]

WORDS = {
    "second": "s", "seconds": "s", "sec": "s", "sekunde": "s", "sekunden": "s", "volt": "V", "volts": "V",
    "ampere": "A", "amperes": "A", "amp": "A", "amps": "A", "newton": "N", "newtons": "N", "pascal": "Pa",
    "meter": "m", "meters": "m", "metre": "m", "metres": "m", "millimeter": "mm", "millimetre": "mm",
}  # fmt: skip
"""Units that recorders write as words."""
END = "***End_of_Header***"
MATRIX = re.compile(r"\s*(?:double|float)\s+(\w+)\s*\(\s*(\d+)\s*,\s*(\d+)\s*\)\s*(?:#\s*(.*?)\s*)?")
"""Head of a table of Modelica: its name, its rows and columns, and what is said about it."""


@dataclass
class Channels:
    """Columns of a recorder, each with its clock.

    Attributes
    ----------
    header, names : list of str
        Names as they stand in the file, and as they are chosen without saying so: ``time`` of the first clock.
    units : list of str or None
        Their units.
    columns : list of ndarray
        Their samples; clocks of their own may have other lengths.
    clocks : dict
        By the place of a column the place of its clock, where that is not the first one.
    """

    header: list[str] = field(default_factory=list)
    names: list[str] = field(default_factory=list)
    units: list[str | None] = field(default_factory=list)
    columns: list[Array] = field(default_factory=list)
    clocks: dict[int, int] = field(default_factory=dict)

    def add_clock(self, times: Array, unit: str, header: str = "time") -> int:
        """Return the place of a clock: of one that is there with the same times, or of a new one."""
        for place, (name, own) in enumerate(zip(self.names, self.columns, strict=True)):
            if name.startswith("time") and self.units[place] == unit and np.array_equal(own, times):
                return place
        number = sum(name.startswith("time") for name in self.names)
        behind = "" if number == 0 else f" {number + 1}"
        return self._add(f"{header}{behind}", f"time{behind}", unit, times)

    def add(self, name: str, unit: str | None, values: Array, clock: int) -> None:
        """Add a channel."""
        place = self._add(name, name, unit, values)
        if clock != 0:
            self.clocks[place] = clock

    def table(self, file: Path) -> Table:
        """Return the table; columns are NaN behind their last sample, those that are no numbers are refused later."""
        if not self.columns:
            raise ValueError(f"{file}: there are no channels of numbers in it")
        number = max(len(column) for column in self.columns)
        values, faults = np.full((number, len(self.columns)), np.nan), {}
        for at, column in enumerate(self.columns):
            place = f"{file}, column {at + 1} ({self.names[at]})"
            if np.asarray(column).dtype.kind not in "fiu":
                faults[at] = f"{place}: it is no numbers"
                continue
            values[: len(column), at] = column
            wrong = np.flatnonzero(~np.isfinite(values[: len(column), at]))
            if len(wrong):
                faults[at] = f"{place}: value {wrong[0]} is {values[wrong[0], at]}"
        lines = np.arange(number)
        return Table(file, self.header, self.names, self.units, values, lines, 0, faults=faults, clocks=self.clocks)

    def _add(self, header: str, name: str, unit: str | None, values: Array) -> int:
        self.header.append(header)
        self.names.append(name)
        self.units.append(unit)
        self.columns.append(values)
        return len(self.columns) - 1


def of_recorder(file: Path, lines: Lines) -> Channels | None:
    """Return the channels of a text, if it is one of these."""
    first = lines[0].strip() if lines else ""
    if first.startswith("LabVIEW Measurement"):
        return _of_labview(file, lines)
    if any(line.startswith("Starttime of export") for line in lines[:8]):
        return _of_twincat(file, lines)
    if first == "#1":
        return _of_combi_table(file, lines)
    cells = _cells(first, ",")
    if first.startswith("Record Length") and len(cells) > 4 and _is_number(cells[3]) and _is_number(cells[4]):
        return _of_tektronix(file, lines)
    return None


def _cells(line: str, separator: str) -> list[str]:
    return [cell.strip() for cell in next(csv.reader([line], delimiter=separator), [])]


def _is_number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return True


def _numbers(file: Path, rows: Sequence[tuple[int, list[str]]], place: int, name: str, has_comma: bool) -> Array:
    """Return a column of rows with their line numbers, without its empty cells."""
    found = []
    for number, cells in rows:
        text = cells[place] if place < len(cells) else ""
        if text:
            where = f"{file}:{number}, column {place + 1} ({name})"
            found.append(finite(text.replace(",", ".") if has_comma else text, where))
    return np.array(found)


def _of_labview(file: Path, lines: Lines) -> Channels:
    """Read LabVIEW's text: a header, and segments with a header each; times may be columns or a start and a step."""
    separator = "," if any(line.startswith("Separator") and "Comma" in line for line in lines[:20]) else "\t"
    first = next((at for at, line in enumerate(lines) if line.startswith(END)), None)
    if first is None:
        raise ValueError(f"{file}: there is no {END}, with which the header of LabVIEW ends")
    told = {cells[0]: cells[1] for line in lines[:first] if len(cells := _cells(line, separator)) > 1}
    has_comma = told.get("Decimal_Separator") == "," and separator != ","
    kind = told.get("X_Columns", "One")
    meta: dict[str, list[str]] = {}
    header: list[str] = []
    segments: list[tuple[dict[str, list[str]], list[tuple[int, list[str]]]]] = []
    is_head = True
    for number, line in enumerate(lines[first + 1 :], start=first + 2):
        cells = _cells(line, separator)
        if not any(cells):
            continue
        if cells[0] == "Channels":
            meta, is_head = {}, True
        if cells[0].startswith(END):
            is_head = False
        elif cells[0] == "X_Value":
            header = header or cells
            is_head = False
            segments.append((meta, []))
        elif is_head:
            meta[cells[0]] = cells[1:]
        elif segments:
            segments[-1][1].append((number, cells))
    if not header:
        raise ValueError(f"{file}: there is no line with X_Value, below which LabVIEW writes the numbers")
    step = 2 if kind == "Multi" else 1
    last = len(header) - (header[-1] == "Comment")
    found = Channels()
    for channel, place in enumerate(range(1, last, step)):
        times, values = [], []
        for own, rows in segments:
            column = _numbers(file, rows, place, header[place], has_comma)
            if kind == "No":
                start, by = (
                    finite(own[key][channel].replace(",", "."), f"{file}, {key}") if key in own else usual
                    for key, usual in (("X0", 0.0), ("Delta_X", np.nan))
                )
                if not by > 0.0:
                    raise ValueError(
                        f"{file}: X_Columns is No, and Delta_X of {header[place]} is {by}: there is no time"
                    )
                times.append(start + by * np.arange(len(column)))
            else:
                at = place - 1 if kind == "Multi" else 0
                times.append(_numbers(file, rows, at, "X_Value", has_comma)[: len(column)])
            values.append(column)
        label = segments[0][0].get("Y_Unit_Label", [])
        unit = label[channel] if channel < len(label) else ""
        clock = found.add_clock(np.concatenate(times), "s", "X_Value")
        found.add(header[place], WORDS.get(unit.lower(), unit) or None, np.concatenate(values), clock)
    return found


def _of_twincat(file: Path, lines: Lines) -> Channels:
    """Read an export of TwinCAT Scope: above the numbers rows of properties, whose names stand above clocks in ms."""
    line = next(line for line in lines if line.startswith("Starttime of export"))
    separator = line[len("Starttime of export") :][:1]
    at = next((at for at in range(8, len(lines)) if lines[at].startswith("Unit Offset")), None)
    names = [_cells(line, separator) for line in lines if line.startswith("Name" + separator)]
    if at is None or len(names) < 2:
        raise ValueError(f"{file}: it is an export of TwinCAT Scope without its rows Name and Unit Offset")
    header = names[-1]
    units = next((_cells(line, separator) for line in lines if line.startswith("Unit" + separator)), [])
    rows = [(number, _cells(line, separator)) for number, line in enumerate(lines[at + 1 :], start=at + 2)]
    rows = [(number, cells) for number, cells in rows if any(cells) and cells[0] != "EOF"]
    has_comma = separator != "," and any("," in cell for _, cells in rows[:1000] for cell in cells)
    found = Channels()
    clock, times = 0, np.empty(0)
    for place, name in enumerate(header):
        if name == "Name":
            times = _numbers(file, rows, place, "time", has_comma)
            clock = found.add_clock(times, "ms")
            continue
        values = _numbers(file, rows, place, name, has_comma)
        if len(values) != len(times):
            raise ValueError(f"{file}, column {place + 1} ({name}): {len(values)} values at {len(times)} times")
        unit = units[place].partition(" ")[0] if place < len(units) else ""
        found.add(name, None if unit in ("", "(None)", "None") else unit, values, clock)
    return found


def _of_tektronix(file: Path, lines: Lines) -> Channels:
    """Read Tektronix' text, whose preamble stands in the first columns beside times and voltages."""
    rows = [(number, _cells(line, ",")) for number, line in enumerate(lines, start=1) if line.strip()]
    told = {cells[0]: cells[1] for _, cells in rows if cells[0] and len(cells) > 1}
    found = Channels()
    unit, over = told.get("Vertical Units", ""), told.get("Horizontal Units", "s")
    clock = found.add_clock(_numbers(file, rows, 3, "time", False), WORDS.get(over.lower(), over))
    name = told.get("Source", "CH1")
    found.add(name, WORDS.get(unit.lower(), unit) or None, _numbers(file, rows, 4, name, False), clock)
    return found


def _of_combi_table(file: Path, lines: Lines) -> Channels:
    """Read a table of Modelica: columns have numbers, the first is the time; names may stand behind the head."""
    heads = [(at, match) for at, line in enumerate(lines) if (match := MATRIX.fullmatch(line))]
    if not heads:
        raise ValueError(f"{file}: below #1 there is no head of a table, such as `double table(100,3)`")
    if len(heads) > 1:
        named = ", ".join(match[1] for _, match in heads)
        raise ValueError(f"{file}: there are {len(heads)} tables in it, {named}; leave the one that is meant")
    [(at, match)] = heads
    count, width = int(match[2]), int(match[3])
    header = [str(place) for place in range(1, width + 1)]
    names = [name.strip() for name in (match[4] or "").split(",")]
    if len(names) != width or not all(names):
        names = ["time", *header[1:]]
    body = [(number, line.partition("#")[0]) for number, line in enumerate(lines[at + 1 :], start=at + 2)]
    # A row may go on in the next line.
    cells = [(number, cell) for number, line in body for cell in re.split(r"[\s,;]+", line.strip()) if cell]
    if len(cells) != count * width:
        raise ValueError(f"{file}:{at + 1}: {match[1]} is to have {count} x {width} numbers, but has {len(cells)}")
    found = Channels()
    for place, (head, name) in enumerate(zip(header, names, strict=True)):
        column = [finite(cell, f"{file}:{number}, column {place + 1} ({name})") for number, cell in cells[place::width]]
        if place == 0:
            found.add_clock(np.array(column), "s", head)
        else:
            found.add(name, None, np.array(column), 0)
            found.header[-1] = head
    return found
