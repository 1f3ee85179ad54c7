"""Tables as the world writes them: CSV of any kind, Parquet and MATLAB files, as columns with names and units.

What is understood of a CSV: commas, semicolons, tabs or blanks between the values; decimal commas where no comma
separates; a byte order mark; lines that are empty or begin with ``#``, ``%`` or ``//``; units behind the names, as
``x[mm]`` or ``x (mm)``, or in a row of their own below them.
"""

from __future__ import annotations

import csv
import re
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pneumatic_servo.errors import MissingPackage
from pneumatic_servo.files import opened
from pneumatic_servo.numerals import finite
from pneumatic_servo.run import Run
from pneumatic_servo.units import TO_SI, scale

Array = NDArray[np.float64]

COMMENTS = ("#", "%", "//")
DECIMAL_COMMA = re.compile(r"[-+]?\d+,\d+([eE][-+]?\d+)?")
WITH_UNIT = re.compile(r"(.+?)\s*(?:\[\s*([^\[\]]*?)\s*\]|\(\s*([^()]*?)\s*\))")
SEPARATORS = {"\t": "tabs", ";": "semicolons", ",": "commas", " ": "blanks"}


@dataclass(frozen=True)
class Table:
    """Columns of numbers.

    Attributes
    ----------
    file : Path
        Where they come from.
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
    """

    file: Path
    header: list[str]
    names: list[str]
    units: list[str | None]
    values: Array
    lines: NDArray[np.int64]
    first: int
    is_recorded: bool = False

    def where(self, row: int, column: int) -> str:
        """Return where a value stands, for people."""
        return f"{self.file}:{self.lines[row]}, column {column + 1} ({self.names[column]})"

    def in_si(self, column: int, unit: str, si: str) -> Array:
        """Return a column whose values are in a unit, in an SI unit."""
        times, offset = scale(unit, si, f"{self.file}:{self.first}, column {column + 1} ({self.names[column]})")
        if times == 1.0 and offset == 0.0:
            return np.ascontiguousarray(self.values[:, column])
        inverse = round(1.0 / times)
        is_exact = times < 1.0 and abs(inverse * times - 1.0) < 1e-14
        column_values = self.values[:, column]
        scaled = column_values / inverse if is_exact else column_values * times
        return np.ascontiguousarray(scaled + offset)

    def find(self, name: str) -> list[int]:
        """Return the columns of a name: as it is written, or without the unit behind it."""
        exact = [place for place, header in enumerate(self.header) if header == name]
        return exact or [place for place, own in enumerate(self.names) if own == name]


def read_table(file: str | Path) -> Table:
    """Read a table; errors name file, line, column and value."""
    file = Path(file)
    if file.is_dir():
        raise IsADirectoryError(f"{file}: it is a folder; name a table in it")
    if not file.exists():
        raise FileNotFoundError(f"{file}: there is no such file")
    if file.suffix.lower() == ".parquet":
        return _of_parquet(file)
    if file.suffix.lower() == ".mat":
        return _of_mat(file)
    try:
        return _of_text(file)
    except csv.Error as error:
        raise ValueError(f"{file}: {error}") from None


def header_of(file: str | Path) -> list[str]:
    """Return the names of the columns of a table, without units."""
    return read_table(file).names


def _of_text(file: Path) -> Table:
    with opened(file) as stream:
        lines = [(number, line) for number, line in enumerate(stream.read().splitlines(), start=1) if _counts(line)]
    if not lines:
        raise ValueError(f"{file}: it is empty; a table has a line with the names of its columns, and rows of numbers")
    first, head = lines[0]
    separator = next((each for each in SEPARATORS if each in head.strip()), ",")
    header = [cell.strip() for cell in _cells(head, separator)]
    names, units = _names_and_units(header)
    body = lines[1:]
    if body and _is_units(cells := _cells(body[0][1], separator), len(header)):
        units = [own or _unit(cell) for own, cell in zip(units, cells, strict=True)]
        body = body[1:]
    has_comma = separator != "," and any(
        DECIMAL_COMMA.fullmatch(cell.strip()) for _, line in body[:20] for cell in _cells(line, separator)
    )
    numbers = np.array([number for number, _ in body], dtype=np.int64)
    values = _fast(body, separator, has_comma, len(header))
    if values is None:
        values = _slow(file, body, separator, has_comma, names)
    return Table(file, header, names, units, values, numbers, first)


def _counts(line: str) -> bool:
    stripped = line.strip()
    return bool(stripped) and not stripped.startswith(COMMENTS)


def _cells(line: str, separator: str) -> list[str]:
    if separator == " ":
        return line.split()
    return next(csv.reader([line], delimiter=separator), [])


def _fast(body: Sequence[tuple[int, str]], separator: str, has_comma: bool, columns: int) -> Array | None:
    """Return the numbers of a table without faults; nothing if it has some, which have to be found line by line."""
    if not body:
        return np.zeros((0, columns))
    text = (line.replace(",", ".") if has_comma else line for _, line in body)
    try:
        values = np.loadtxt(text, delimiter=None if separator == " " else separator, ndmin=2, comments=None,
                            quotechar='"')  # fmt: skip
    except ValueError:
        return None
    return values if values.shape == (len(body), columns) and np.isfinite(values).all() else None


def _slow(file: Path, body: Sequence[tuple[int, str]], separator: str, has_comma: bool, names: list[str]) -> Array:
    rows = []
    for number, line in body:
        cells = _cells(line, separator)
        place = f"{file}:{number}"
        if len(cells) != len(names):
            hint = _other_separator(line, separator)
            raise ValueError(f"{place}: {len(cells)} values, but the header has {len(names)} columns{hint}")
        if has_comma:
            cells = [cell.replace(",", ".") for cell in cells]
        rows.append([
            finite(cell, f"{place}, column {at} ({name})")
            for at, (name, cell) in enumerate(zip(names, cells, strict=True), start=1)
        ])  # fmt: skip
    return np.array(rows)


def _other_separator(line: str, separator: str) -> str:
    for other, name in SEPARATORS.items():
        if other != separator and other in line.strip():
            return f"; the header is separated by {SEPARATORS[separator]}, but this line has {name}"
    return ""


def _names_and_units(header: Sequence[str]) -> tuple[list[str], list[str | None]]:
    names: list[str] = []
    units: list[str | None] = []
    for text in header:
        match = WITH_UNIT.fullmatch(text)
        unit = _unit(match[2] if match[2] is not None else match[3]) if match else None
        # `friction.gms.alpha[1]` has no unit, but a number.
        names.append(match[1] if match and unit is not None else text)
        units.append(unit)
    return names, units


def _unit(text: str) -> str | None:
    """Return a unit that is written so, if it is one."""
    text = text.strip().strip("[]()")
    for si in dict.fromkeys(si for si, _, _ in TO_SI.values()):
        try:
            scale(text, si, "")
        except ValueError:
            continue
        return text
    return None


def _is_units(cells: Sequence[str], columns: int) -> bool:
    """Tell whether a row holds units: at least one, and nothing that is neither a unit nor empty."""
    if len(cells) != columns:
        return False
    stripped = [cell.strip().strip("[]()") for cell in cells]
    return any(_unit(cell) for cell in stripped) and all(_unit(cell) or cell in ("", "-", "1") for cell in stripped)


def _of_parquet(file: Path) -> Table:
    try:
        import pandas
    except ImportError as error:
        raise MissingPackage("pandas and pyarrow for Parquet files", "parquet") from error
    try:
        frame = pandas.read_parquet(file)
    except ImportError as error:
        raise MissingPackage("pyarrow, which pandas reads Parquet files with", "parquet") from error
    except (ValueError, OSError) as error:
        raise ValueError(f"{file}: it cannot be read: {error}") from None
    return of_frame(frame, file)


def of_frame(frame: Any, file: Path) -> Table:
    """Return the table of a pandas DataFrame; an index that is called ``time`` is a column.

    What a run has recorded says so by itself, also after it was kept in a Parquet file.
    """
    is_recorded = bool(frame.attrs.get(Run.RECORDED, False))
    if frame.index.name is not None and frame.index.name not in frame.columns:
        frame = frame.reset_index()
    # By place, since a name may be there twice, which is refused where somebody asks for it.
    columns = [np.asarray(frame.iloc[:, place]) for place in range(len(frame.columns))]
    return replace(_of_columns(file, [str(name) for name in frame.columns], columns), is_recorded=is_recorded)


def numbers(column: Any) -> NDArray[np.float64]:
    """Return a column as numbers; of dates and times the seconds since the first."""
    found = np.asarray(column)
    if found.dtype.kind == "M":
        found = found - found[:1]
    if found.dtype.kind == "m":
        return np.asarray(found / np.timedelta64(1, "s"), dtype=float)
    # Of texts of its own NumPy would say the name that it has for them.
    return np.asarray(found.tolist() if found.dtype.kind == "U" else found, dtype=float)


def _of_mat(file: Path) -> Table:
    try:
        from scipy.io import loadmat
    except ImportError as error:
        raise MissingPackage("SciPy", "identification") from error
    try:
        found = {name: np.squeeze(value) for name, value in loadmat(file).items() if not name.startswith("__")}
    except (NotImplementedError, ValueError) as error:
        raise ValueError(f"{file}: it cannot be read: {error}") from None
    columns = {name: value for name, value in found.items() if value.ndim == 1 and value.dtype.kind in "fiub"}
    if not columns:
        raise ValueError(f"{file}: there are no vectors of numbers in it, only {', '.join(found) or 'nothing'}")
    return _of_columns(file, list(columns), list(columns.values()))


def _of_columns(file: Path, header: list[str], columns: Sequence[NDArray[Any]]) -> Table:
    lengths = {name: len(values) for name, values in zip(header, columns, strict=True)}
    if len(set(lengths.values())) > 1:
        raise ValueError(f"{file}: the columns have different lengths: {lengths}")
    values = np.array([
        _column(file, number, name, column)
        for number, (name, column) in enumerate(zip(header, columns, strict=True), start=1)
    ]).T  # fmt: skip
    names, units = _names_and_units(header)
    table = Table(file, header, names, units, values, np.arange(len(values)), 0)
    wrong = np.argwhere(~np.isfinite(values))
    if len(wrong):
        row, column = wrong[0]
        raise ValueError(f"{table.where(row, column)}: {values[row, column]} is not finite")
    return table


def _column(file: Path, number: int, name: str, column: NDArray[Any]) -> Array:
    try:
        return numbers(column)
    except (TypeError, ValueError) as error:
        place = f"column {number} ({name})"
        for row, value in enumerate(column.tolist()):
            finite(str(value), f"{file}:{row}, {place}")
        raise ValueError(f"{file}, {place}: {error}") from None
