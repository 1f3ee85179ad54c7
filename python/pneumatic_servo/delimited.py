"""Tables in text files.

Understood are commas, semicolons, tabs or blanks between the values, also behind the last one; decimal commas where no
comma separates; UTF-8, UTF-16 with a byte order mark, and Windows-1252; lines that are empty or begin with ``#``, ``%``
or ``//``, of which the last may have the names; lines of a recorder above the names; units behind the names, as
``x[mm]``, ``x (mm)``, ``x / mm`` or ``x in mm``, or in a row of their own below them; times of the clock; columns
without names, which have numbers, ``1`` the first; empty cells of slow channels; what `recorders` reads.
"""

from __future__ import annotations

import csv
import re
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from pneumatic_servo.clock import is_clock, seconds_since_first
from pneumatic_servo.columns import Table, names_and_units, unit_of
from pneumatic_servo.files import text_of
from pneumatic_servo.numerals import finite
from pneumatic_servo.recorders import WORDS, of_recorder

Array = NDArray[np.float64]

COMMENTS = ("#", "%", "//")
DECIMAL_COMMA = re.compile(r"[-+]?\d+,\d+([eE][-+]?\d+)?")
DECIMAL_POINT = re.compile(r"[-+]?\d+\.\d+([eE][-+]?\d+)?")
THOUSANDS = re.compile(r"[-+]?[1-9]\d{0,2}(,\d{3})+")
NUMBER = re.compile(r"[-+]?(?:\d+[.,]?\d*|[.,]\d+)(?:[eE][-+]?\d+)?|[-+]?(?:nan|inf)", re.IGNORECASE)
SEPARATORS = {"\t": "tabs", ";": "semicolons", ",": "commas", " ": "blanks"}
MOST_ABOVE = 200
"""Lines above the numbers of a table, at most."""


def read_text(file: Path, encoding: str | None = None) -> Table:
    """Read a table; errors name file, line, column and value."""
    try:
        return _of_text(file, encoding)
    except csv.Error as error:
        raise ValueError(f"{file}: {error}") from None


def _of_text(file: Path, encoding: str | None) -> Table:
    text = text_of(file, encoding).splitlines()
    if (found := of_recorder(file, text)) is not None:
        return found.table(file)
    every = [(number, line) for number, line in enumerate(text, start=1)]
    every = [(number, line) for number, line in every if line.strip()]
    lines = [(number, line) for number, line in every if not line.strip().startswith(COMMENTS)]
    if not lines:
        raise ValueError(f"{file}: it is empty; a table has a line with the names of its columns, and rows of numbers")
    place, separator = _header(lines)
    (first, head), body = lines[place], lines[place + 1 :]
    count = len(_trimmed(_cells(head, separator)))
    if _is_row(head, separator) and not (body and _is_units(_trimmed(_cells(body[0][1], separator)), count)):
        # Without names columns have numbers.
        numbered = (first, separator.join(str(number) for number in range(1, count + 1)))
        first, head = _named_by_comment(every, first, count, separator) or numbered
        body = lines[place:]
    header = [cell.strip() for cell in _trimmed(_cells(head, separator))]
    names, units = names_and_units(header)
    if _is_units(header, len(header)) and all(cell.lower() in WORDS for cell in header):
        units = [_unit(cell) for cell in header]
    body = [(number, _without_end(line, separator, len(header))) for number, line in body]
    if body and _is_units(cells := _cells(body[0][1], separator), len(header)):
        units = [own or _unit(cell) for own, cell in zip(units, cells, strict=True)]
        numbers_from = next((at for at, (_, line) in enumerate(body[1:4], start=1) if _is_row(line, separator)), 1)
        body = body[numbers_from:]
    is_quoted = any('"' in line for _, line in body[:MOST_ABOVE])
    has_comma = (separator != "," or is_quoted) and _has_decimal_commas(file, body, separator, names)
    numbers = np.array([number for number, _ in body], dtype=np.int64)
    # Decimal commas in quotes are not those between the cells.
    values = None if has_comma and separator == "," else _fast(body, separator, has_comma, len(header))
    if values is not None:
        return Table(file, header, names, units, values, numbers, first)
    rows = _rows(file, body, separator, names)
    columns = [[row[at] for row in rows] for at in range(len(names))]
    read = [
        _of_texts(cells, [f"{file}:{number}, column {at} ({name})" for number, _ in body], has_comma=has_comma)
        for at, (name, cells) in enumerate(zip(names, columns, strict=True), start=1)
    ]
    for at, (_, fault) in enumerate(read):
        units[at] = "s" if fault is None and is_clock(columns[at][0]) else units[at]
    faults = {at: fault for at, (_, fault) in enumerate(read) if fault}
    # A column that is numbers but for empty cells is of a slower channel.
    slow = {at: _of_slow(columns[at], has_comma) for at in faults if not all(cell.strip() for cell in columns[at])}
    gaps = {at for at, column in slow.items() if column is not None}
    every_column = [column if at not in gaps else slow[at] for at, (column, _) in enumerate(read)]
    return Table(
        file, header, names, units, np.array(every_column, dtype=float).T, numbers, first, faults=faults, gaps=gaps
    )


def _header(lines: Sequence[tuple[int, str]]) -> tuple[int, str]:
    """Return the place of the line with the names, and the separator of its cells.

    It is the first one, unless others stand above rows of numbers: then the last of as many cells as these have, of
    which none is a number.
    """
    texts = [line for _, line in lines[:MOST_ABOVE]]
    usual = next((each for each in SEPARATORS if each in texts[0].strip()), ",")
    for at, line in enumerate(texts):
        for separator in SEPARATORS:
            if separator != "," and separator not in line.strip():
                continue
            below = texts[at + 1] if at + 1 < len(texts) else line
            count = len(_trimmed(_cells(line, separator)))
            if not _is_row(line, separator) or not _is_row(below, separator):
                continue
            if count != len(_trimmed(_cells(below, separator))):
                continue
            if (named := _above_units_and_texts(texts, at, separator, count)) is not None:
                return named, separator
            for above in range(at - 1, -1, -1):
                cells = _trimmed(_cells(texts[above], separator))
                if above < at - 1 and _is_units(_trimmed(_cells(texts[at - 1], separator)), count):
                    # Names above units may be numbers of channels; an oscilloscope may write nothing but units.
                    numbers = [cell.strip() for cell in cells if NUMBER.fullmatch(cell.strip())]
                    is_named = above == at - 2 and len(cells) == count and all(cell.isdigit() for cell in numbers)
                    return (above if is_named else at - 1), separator
                has_number = any(NUMBER.fullmatch(cell.strip()) or is_clock(cell) for cell in cells)
                if len(cells) == count and not has_number and not _is_units(cells, count):
                    return above, separator
            return 0, usual
    return 0, usual


def _above_units_and_texts(texts: Sequence[str], first: int, separator: str, count: int) -> int | None:
    """Return the place of names above a row of units with descriptions below it, above the first row of numbers."""
    rows = [_trimmed(_cells(text, separator)) for text in texts[max(0, first - 4) : first]]
    for below in range(1, min(3, len(rows) - 1)):
        units, names = rows[-1 - below], rows[-2 - below]
        are_texts = not any(_is_units(row, count) for row in rows[-below:])
        if are_texts and _is_units(units, count) and len(names) == count and not _is_units(names, count):
            return first - 2 - below
    return None


def _is_row(line: str, separator: str) -> bool:
    """Tell whether a line is a row of numbers: more than half of its cells are numbers or times."""
    cells = [cell.strip() for cell in _trimmed(_cells(line, separator))]
    known = [cell for cell in cells if (NUMBER.fullmatch(cell) and not (separator == "," and "," in cell)) or
             is_clock(cell)]  # fmt: skip
    return 2 * len(known) > len(cells)


def _named_by_comment(
    every: Sequence[tuple[int, str]], first: int, count: int, separator: str
) -> tuple[int, str] | None:
    """Return the last comment above the numbers, if it has as many cells: names, as NumPy writes them."""
    above = [(number, line.strip().lstrip("#%/ ")) for number, line in every if number < first]
    if above and len(_trimmed(_cells(above[-1][1], separator))) == count and not _is_row(above[-1][1], separator):
        return above[-1]
    return None


def _cells(line: str, separator: str) -> list[str]:
    if separator == " ":
        return line.split()
    return next(csv.reader([line], delimiter=separator), [])


def _trimmed(cells: list[str]) -> list[str]:
    """Return cells without the empty ones at the end."""
    last = len(cells)
    while last > 1 and not cells[last - 1].strip():
        last -= 1
    return cells[:last]


def _without_end(line: str, separator: str, columns: int) -> str:
    """Return a line without separators behind its last cell."""
    while separator != " " and line.count(separator) >= columns and line.rstrip(" ").endswith(separator):
        line = line.rstrip(" ")[:-1]
    return line


def _fast(body: Sequence[tuple[int, str]], separator: str, has_comma: bool, columns: int) -> Array | None:
    """Return the numbers of a table without faults; nothing if it has some, which have to be found one by one."""
    if not body:
        return np.zeros((0, columns))
    text = (line.replace(",", ".") if has_comma else line for _, line in body)
    try:
        values = np.loadtxt(text, delimiter=None if separator == " " else separator, ndmin=2, comments=None,
                            quotechar='"')  # fmt: skip
    except ValueError:
        return None
    return values if values.shape == (len(body), columns) and np.isfinite(values).all() else None


def _rows(file: Path, body: Sequence[tuple[int, str]], separator: str, names: list[str]) -> list[list[str]]:
    rows = []
    for number, line in body:
        cells = _cells(line, separator)
        if len(cells) != len(names):
            hint = _other_separator(line, separator)
            raise ValueError(f"{file}:{number}: {len(cells)} values, but the header has {len(names)} columns{hint}")
        rows.append(cells)
    return rows


def _of_texts(cells: Sequence[str], places: Sequence[str], *, has_comma: bool) -> tuple[list[float], str | None]:
    """Return a column as numbers, or its fault."""
    try:
        if is_clock(cells[0]) and (clock := _clock(cells, places)):
            return clock, None
        texts = [cell.replace(",", ".") for cell in cells] if has_comma else cells
        return [finite(text, place) for text, place in zip(texts, places, strict=True)], None
    except ValueError as error:
        # An input may be true or false.
        logical = {"true": 1.0, "false": 0.0}
        return [logical.get(cell.strip().lower(), np.nan) for cell in cells], str(error)


def _of_slow(cells: Sequence[str], has_comma: bool) -> list[float] | None:
    """Return a column with NaN for its empty cells, if the others are numbers."""
    try:
        return [finite(cell.replace(",", ".") if has_comma else cell, "") if cell.strip() else np.nan for cell in cells]
    except ValueError:
        return None


def _clock(cells: Sequence[str], places: Sequence[str]) -> list[float] | None:
    try:
        return seconds_since_first(cells)
    except ValueError as error:
        raise ValueError(f"{places[0]}: {error}") from None


def _other_separator(line: str, separator: str) -> str:
    for other, name in SEPARATORS.items():
        if other != separator and other in line.strip():
            return f"; the header is separated by {SEPARATORS[separator]}, but this line has {name}"
    return ""


def _has_decimal_commas(file: Path, body: Sequence[tuple[int, str]], separator: str, names: Sequence[str]) -> bool:
    """Tell whether commas are decimal marks; refuse a table in which commas or points may separate thousands.

    A number as 101,131 is one of thousands, or of decimals, which the points of other cells leave open.
    """
    with_comma = [(number, line) for number, line in body if "," in line]
    if not any("." in line for _, line in body):
        return any(DECIMAL_COMMA.fullmatch(cell.strip()) for _, line in with_comma for cell in _cells(line, separator))
    first: dict[str, str] = {}
    for number, line in with_comma:
        for at, cell in enumerate(_cells(line, separator)):
            text = cell.strip()
            if DECIMAL_COMMA.fullmatch(text):
                name = names[at] if at < len(names) else ""
                first.setdefault("comma", f"{text!r} (line {number}, column {at + 1} ({name}))")
                if THOUSANDS.fullmatch(text):
                    first.setdefault("either", f"{text!r} (line {number}, column {at + 1} ({name}))")
        if "either" in first:
            break
    if "comma" not in first:
        return False
    for number, line in body if "either" in first else ():
        for at, cell in enumerate(_cells(line, separator)):
            if DECIMAL_POINT.fullmatch(cell.strip()):
                name = names[at] if at < len(names) else ""
                raise ValueError(
                    f"{file}:{number}, column {at + 1} ({name}): {cell.strip()!r} has a decimal point, and "
                    f"{first['either']} a comma, which may separate thousands; write numbers with one mark, without "
                    "separators of thousands"
                )
    return True


def _is_units(cells: Sequence[str], columns: int) -> bool:
    """Tell whether a row holds units: at least one, and nothing that is neither a unit nor empty.

    What stands in square brackets is a unit; one that is not known is refused where somebody asks for its column.
    """
    if len(cells) != columns:
        return False
    stripped = [cell.strip().strip("()") for cell in cells]
    is_known = any(_unit(cell.strip("[]")) for cell in stripped)
    return is_known and all(_unit(cell) or cell.strip("[]") in ("", "-", "1") for cell in stripped)


def _unit(text: str) -> str | None:
    """Return a unit that is known, written as a word, or in square brackets."""
    text = text.strip()
    bracketed = text[1:-1].strip() if text.startswith("[") and text.endswith("]") else ""
    known = WORDS.get((bracketed or text).lower()) or unit_of(bracketed or text)
    return known or (None if bracketed in ("", "-", "1") else bracketed)
