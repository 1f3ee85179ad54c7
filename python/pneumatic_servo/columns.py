"""Columns of numbers with names and units, wherever they come from."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from collections.abc import Set as AbstractSet
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from pneumatic_servo import _native
from pneumatic_servo.units import scale

Array = NDArray[np.float64]


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
        return _native.scaled(self.values[:, column], times, offset)

    def signals(self, chosen: Sequence[tuple[str, int, str, str, bool]]) -> tuple[dict[str, Array], list[str]]:
        """Return chosen columns in SI units at the samples of that for ``time``, and those of other clocks.

        Commands are held and readings run on straight lines between their samples. A chosen column is signal, place,
        unit, SI unit, and whether its sign is turned.
        """
        table = (
            str(self.file), self.names, self.units, self.values, self.lines, self.first, dict(self.faults),
            dict(self.clocks), set(self.gaps),
        )  # fmt: skip
        samples, others = _native.table_signals(table, chosen)
        return {signal: values for (signal, *_), values in zip(chosen, samples, strict=True)}, others
