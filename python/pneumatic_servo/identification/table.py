"""Measured tables: which column is which signal, and the numbers in SI units."""

from __future__ import annotations

import csv
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from pneumatic_servo.files import opened
from pneumatic_servo.identification.units import factor
from pneumatic_servo.numerals import finite

Array = NDArray[np.float64]

SIGNALS = {
    "time": "s",
    "position": "m",
    "velocity": "m/s",
    "frictionForce": "N",
    "force": "N",
    "normalForce": "N",
    "pressure": "Pa",
    "valveVoltage": "V",
    "supplyPressure": "Pa",
    "externalForce": "N",
    "chamberA.pressure": "Pa",
    "chamberB.pressure": "Pa",
}
"""What can be measured, and its SI unit. `pressure` is that of a test bench above ambient, those of the chambers are
absolute, as everywhere in the model."""


@dataclass(frozen=True)
class Column:
    """A column of a table: its name, its unit, and whether its sign is the opposite of ours."""

    name: str
    unit: str
    turned: bool = False

    @staticmethod
    def of(signal: str, text: str) -> Column:
        """Read `column`, `column[unit]`, or either with a minus before it."""
        if signal not in SIGNALS:
            raise ValueError(f"--columns {signal}={text}: there is no signal {signal}; there are {', '.join(SIGNALS)}")
        match = re.fullmatch(r"(-?)(.+?)(?:\[([^\[\]]*)\])?", text.strip())
        if match is None:
            raise ValueError(f"--columns {signal}={text}: it must be {signal}=column or {signal}=column[unit]")
        unit = SIGNALS[signal] if match[3] is None else match[3]
        factor(unit, SIGNALS[signal], f"--columns {signal}={text}")
        return Column(match[2], unit, bool(match[1]))


def columns_of(given: str | Mapping[str, str]) -> dict[str, Column]:
    """Read which column is which signal, from `signal=column[unit],...` or a mapping."""
    if isinstance(given, str):
        pairs = [word.partition("=") for word in given.split(",") if word]
        wrong = next((word for word, equals, _ in pairs if not equals), None)
        if wrong is not None:
            raise ValueError(f"--columns {wrong}: it must be signal=column or signal=column[unit]")
        names = [name.strip() for name, _, _ in pairs]
        twice = next((name for name in names if names.count(name) > 1), None)
        if twice is not None:
            raise ValueError(f"--columns: {twice} is given twice")
        given = {name.strip(): text for name, _, text in pairs}
    columns = {signal: Column.of(signal, text) for signal, text in given.items()}
    if "time" not in columns:
        raise ValueError("--columns: no column is given for time, for example time=t")
    return columns


def read(file: Path, columns: Mapping[str, Column]) -> dict[str, Array]:
    """Return the signals of a table in SI units; errors name file, line, column and value."""
    with opened(file) as stream:
        reader = csv.reader(stream)
        header = [name.strip() for name in next(reader, [])]
        places = {signal: _place(file, header, signal, column) for signal, column in columns.items()}
        rows: list[list[float]] = []
        for cells in reader:
            if cells:
                rows.append(_row(f"{file}:{reader.line_num}", header, cells, places))
                _check_time(f"{file}:{reader.line_num}", rows, list(places).index("time"), columns["time"])
    if not rows:
        raise ValueError(f"{file}: there are no rows below the header")
    values = np.array(rows).T
    return {signal: _scaled(signal, column, row) for (signal, column), row in zip(columns.items(), values, strict=True)}


def _scaled(signal: str, column: Column, values: Array) -> Array:
    scale = factor(column.unit, SIGNALS[signal], signal)
    return -scale * values if column.turned else scale * values


def _place(file: Path, header: Sequence[str], signal: str, column: Column) -> int:
    if column.name not in header:
        there = ", ".join(header) or "an empty line"
        raise ValueError(f"{file}:1: there is no column {column.name} for {signal}, only {there}")
    if header.count(column.name) > 1:
        raise ValueError(f"{file}:1: there are {header.count(column.name)} columns {column.name}; which is {signal}?")
    return header.index(column.name)


def _row(where: str, header: Sequence[str], cells: Sequence[str], places: Mapping[str, int]) -> list[float]:
    if len(cells) != len(header):
        raise ValueError(f"{where}: {len(cells)} values, but the header has {len(header)} columns")
    return [finite(cells[place], f"{where}, column {place + 1} ({header[place]})") for place in places.values()]


def _check_time(where: str, rows: Sequence[Sequence[float]], place: int, column: Column) -> None:
    if len(rows) > 1 and rows[-1][place] <= rows[-2][place]:
        later, earlier = rows[-1][place], rows[-2][place]
        raise ValueError(
            f"{where}, column {column.name}: time must rise, but {later} {column.unit} follows {earlier} {column.unit}"
        )
