"""Columns of numbers with names and units, wherever they come from."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from pneumatic_servo.units import TO_SI, scale

Array = NDArray[np.float64]

WITH_UNIT = re.compile(r"(.+?)\s*(?:\[\s*([^\[\]]*?)\s*\]|\(\s*([^()]*?)\s*\)|(?:/\s*|\s+in\s+)(\S+|\([^()]*\)))")

ELEMENT = re.compile(r".*\S\[\d+\]")


@dataclass(frozen=True)
class Table:
    """Columns of numbers.

    Attributes
    ----------
    file : Path
        File of the columns.
    header : list of str
        Names as they are written there.
    names : list of str
        The same without units.
    units : list of str or None
        Units, where some are written.
    values : ndarray of shape (rows, columns)
        The numbers as written.
    lines : ndarray of shape (rows,)
        The line of each row.
    first : int
        The line of the header.
    is_recorded : bool
        Whether a run recorded it, whose inputs stand in each row as they were in force up to it.
    faults : dict
        By the place of a column what is wrong with it: it is NaN in `values`, and refused where somebody asks for it.
    """

    file: Path
    header: list[str]
    names: list[str]
    units: list[str | None]
    values: Array
    lines: NDArray[np.int64]
    first: int
    is_recorded: bool = False
    faults: Mapping[int, str] = field(default_factory=dict)

    def where(self, row: int, column: int) -> str:
        """Return where a value stands, for people."""
        return f"{self.file}:{self.lines[row]}, column {column + 1} ({self.names[column]})"

    def in_si(self, column: int, unit: str, si: str) -> Array:
        """Return a column whose values are in a unit, in an SI unit."""
        if column in self.faults:
            raise ValueError(self.faults[column])
        times, offset = scale(unit, si, f"{self.file}:{self.first}, column {column + 1} ({self.names[column]})")
        if times == 1.0 and offset == 0.0:
            return np.ascontiguousarray(self.values[:, column])
        inverse = round(1.0 / times)
        is_exact = times < 1.0 and abs(inverse * times - 1.0) < 1e-14
        column_values = self.values[:, column]
        scaled = column_values / inverse if is_exact else column_values * times
        return np.ascontiguousarray(scaled + offset)


def names_and_units(header: Sequence[str]) -> tuple[list[str], list[str | None]]:
    """Return the names in a header without the units behind them, and the units."""
    names: list[str] = []
    units: list[str | None] = []
    for text in header:
        match = WITH_UNIT.fullmatch(text)
        # `friction.gms.alpha[1]` is an element, `reading [1]` has the unit 1.
        if ELEMENT.fullmatch(text):
            match = None
        unit = unit_of(next(text for text in match.groups()[1:] if text is not None)) if match else None
        names.append(match[1] if match and unit is not None else text)
        units.append(unit)
    return names, units


def unit_of(text: str) -> str | None:
    """Return a unit that is written so, if it is one."""
    text = text.strip().strip("[]()")
    for si in dict.fromkeys(si for si, _, _ in TO_SI.values()):
        try:
            scale(text, si, "")
        except ValueError:
            continue
        return text
    return None
