"""Which column of a table is which signal, as users say it."""

from __future__ import annotations

import re
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field, replace

from pneumatic_servo import _native
from pneumatic_servo.argument_names import quoted
from pneumatic_servo.columns import Table
from pneumatic_servo.names import did_you_mean


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
    def of(signal: str, text: str, known: Collection[str]) -> Column:
        """Read `column`, `column[unit]`, or either with a minus before it."""
        where = quoted("columns", f"{signal}={text}")
        if signal not in known:
            raise ValueError(
                f"{where}: there is no signal {signal}{did_you_mean(signal, known)}; there are {', '.join(known)}"
            )
        match = re.fullmatch(r"(-?)\s*(.+?)\s*(?:\[([^\[\]]*)\])?", text.strip())
        if match is None:
            raise ValueError(f"{where}: it must be {signal}=column or {signal}=column[unit]")
        return Column(match[2], match[3], bool(match[1]), text.strip())

    def among(self, header: Sequence[str], names: Sequence[str]) -> tuple[list[int], Column]:
        """Return the places of the columns that are meant, and this as it is meant there.

        The whole text may stand in the header; otherwise its name does, with a unit behind it or without.
        """
        for text in (self.typed, self.typed.removeprefix("-").lstrip()):
            exact = [place for place, one in enumerate(header) if text and one == text]
            if exact:
                return exact, replace(self, name=text, unit=None, turned=text != self.typed)
        for known in (header, names):
            found = [place for place, one in enumerate(known) if one == self.name]
            if found:
                return found, self
        return [], self

    def is_calibrated(self, written: str | None, where: str) -> bool:
        """Tell whether the unit is a calibration; refuse one of readings in another unit than a table says."""
        calibrated = None if self.unit is None else _native.calibrated_reading(self.unit, written)
        if calibrated is None:
            return False
        reading, is_same = calibrated
        if not is_same:
            raise ValueError(
                f"{where}: the table says {written}, but the calibration of {quoted('columns')} reads "
                f"{reading or 'counts'}; which is it?"
            )
        return True

    def place(self, signal: str, table: Table) -> tuple[int, Column]:
        """Return the place of the column of a table, and this as it is meant there; refuse none and several."""
        found, column = self.among(table.header, table.names)
        where = f"{table.file}:{table.first}"
        if not found:
            hint = did_you_mean(column.name, table.names)
            raise ValueError(
                f"{where}: there is no column {column.name} for {signal}{hint}; there are {', '.join(table.header)}"
            )
        if len(found) > 1:
            raise ValueError(f"{where}: there are {len(found)} columns {column.name}; which is {signal}?")
        return found[0], column


def columns_of(given: str | Mapping[str, str], known: Collection[str], *, has_time: bool = True) -> dict[str, Column]:
    """Read which column is which of the known signals, from `signal=column[unit],...` or a mapping."""
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
    columns = {signal: Column.of(signal, str(text), known) for signal, text in given.items()}
    seen: dict[str, str] = {}
    for signal, column in columns.items():
        first = seen.setdefault(column.typed.removeprefix("-").lstrip(), signal)
        if first != signal:
            raise ValueError(f"{quoted('columns')}: {column.name} is given for {first} and for {signal}; which is it?")
    if has_time and "time" not in columns:
        raise ValueError(f"{quoted('columns')}: no column is given for time, for example time=t")
    return columns
