"""Columns of numbers with names and units, wherever they come from."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from collections.abc import Set as AbstractSet
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from pneumatic_servo import _native
from pneumatic_servo.units import scale

Array = NDArray[np.float64]

WITH_UNIT = re.compile(
    r"(.+?)\s*(?:\[\s*([^\[\]]*?)\s*\]|\(\s*([^()]*?(?:\([^()]*\))?)\s*\)|(?:/\s*|\s+in\s+)(\S+|\([^()]*\)))"
)

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
    between : sequence of str
        Inputs that changed between the rows of the run that recorded it, so that the table does not have them.
    faults : dict
        By the place of a column what is wrong with it: it is NaN in `values`, and refused where somebody asks for it.
    clocks : dict
        By the place of a column the place of its own clock. Such columns are NaN behind their last sample.
    gaps : set of int
        Columns with empty cells, which are NaN: a channel that is slower than others.
    """

    file: Path
    header: list[str]
    names: list[str]
    units: list[str | None]
    values: Array
    lines: NDArray[np.int64]
    first: int
    is_recorded: bool = False
    between: Sequence[str] = ()
    faults: Mapping[int, str] = field(default_factory=dict)
    clocks: Mapping[int, int] = field(default_factory=dict)
    gaps: AbstractSet[int] = frozenset()

    def where(self, row: int, column: int) -> str:
        """Return where a value stands, for people."""
        return f"{self.file}:{self.lines[row]}, column {column + 1} ({self.names[column]})"

    def in_si(
        self, column: int, unit: str, si: str, *, is_above_ambient: bool = False, has_gaps: bool = False
    ) -> Array:
        """Return a column whose values are in a unit, in an SI unit; NaN in empty cells, if it may have them."""
        if column in self.faults and not (has_gaps and column in self.gaps):
            raise ValueError(self.faults[column])
        place = f"{self.file}:{self.first}, column {column + 1} ({self.names[column]})"
        times, offset = scale(unit, si, place, is_above_ambient=is_above_ambient)
        if times == 1.0 and offset == 0.0:
            return np.ascontiguousarray(self.values[:, column])
        inverse = round(1.0 / times)
        is_exact = times < 1.0 and abs(inverse * times - 1.0) < 1e-14
        column_values = self.values[:, column]
        scaled = column_values / inverse if is_exact else column_values * times
        return np.ascontiguousarray(scaled + offset)


def names_and_units(header: Sequence[str]) -> tuple[list[str], list[str | None]]:
    """Return the names in a header without the units behind them, and the units.

    What stands in brackets is a unit, and so is what is written otherwise and is like a known one: an unknown unit is
    refused where somebody asks for its column.
    """
    names: list[str] = []
    units: list[str | None] = []
    for text in header:
        match = WITH_UNIT.fullmatch(text)
        # `friction.gms.alpha[1]` is an element, `reading [1]` has the unit 1.
        if ELEMENT.fullmatch(text):
            match = None
        unit = _unit_in(match) if match else None
        names.append(match[1] if match and unit is not None else text)
        units.append(unit)
    return names, units


def _unit_in(match: re.Match[str]) -> str | None:
    bracketed, *others = match.groups()[1:]
    text = next(text for text in (bracketed, *others) if text is not None).strip()
    if text == "1":
        return text
    is_known, near = _native.unit_like(text)
    # A letter behind a name is a chamber, a number one of several; a ratio is no unit.
    is_name = len(text) < 2 or text.isdigit()
    return text if is_known or (not is_name and (near is not None or bracketed is not None)) else None


def unit_of(text: str) -> str | None:
    """Return a unit that is written so, if it is a known one."""
    text = text.strip()
    for bare in (text, text.strip("[]()")):
        if _native.unit_like(bare)[0]:
            return bare
    return None
