"""Tables as the world writes them: text, files of recorders, and DataFrames, as columns with names and units.

A column that is no numbers is refused when somebody asks for it.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from datetime import timedelta
from pathlib import Path
from typing import Any
from zipfile import BadZipFile

import numpy as np
from numpy.typing import NDArray

from pneumatic_servo import _native, binary_tables
from pneumatic_servo.columns import Table
from pneumatic_servo.errors import MissingPackage
from pneumatic_servo.files import text_bytes
from pneumatic_servo.numerals import finite
from pneumatic_servo.run import Run
from pneumatic_servo.units import is_quantity

Array = NDArray[np.float64]


def read_table(file: str | Path, encoding: str | None = None) -> Table:
    """Read a table; errors name file, line, column and value."""
    file = Path(file)
    if file.is_dir():
        raise IsADirectoryError(f"{file}: it is a folder; name a table in it")
    if not file.exists():
        raise FileNotFoundError(f"{file}: there is no such file")
    suffix = file.suffix.lower()
    if suffix in (".parquet", ".pq", ".feather", ".arrow"):
        return _of_arrow(file, "read_parquet" if suffix in (".parquet", ".pq") else "read_feather")
    if suffix == ".mat":
        return _of_mat(file)
    if suffix == ".npz":
        return of_arrays(file, _loaded(file))
    if suffix == ".npy":
        return _of_structured(file, _loaded(file))
    if suffix == ".tdms":
        return binary_tables.of_tdms(file).table(file)
    if suffix in (".mf4", ".mdf"):
        return binary_tables.of_mdf(file).table(file)
    return read_text(file, encoding)


def _loaded(file: Path) -> Any:
    """Return the array of a file of NumPy, or all by name."""
    try:
        found = np.load(file)
        if isinstance(found, np.ndarray):
            return found
        with found:
            return dict(found)
    except (ValueError, OSError, EOFError, BadZipFile):
        raise ValueError(f"{file}: it is damaged, or has Python objects; save arrays of numbers") from None


def of_arrays(file: Path, arrays: Mapping[str, Any]) -> Table:
    """Return the table of arrays by their names, or of one matrix."""
    for name, array in arrays.items():
        if is_quantity(array):
            raise ValueError(f"{file}, {name}: it has a unit of its own; give numbers, and their unit behind the name")
    found = [np.asarray(array) for array in arrays.values()]
    if len(found) == 1 and found[0].ndim == 2:
        return _of_structured(file, found[0])
    return _of_columns(file, [str(name) for name in arrays], found)


def read_text(file: Path, encoding: str | None = None) -> Table:
    """Read a table in a text; errors name file, line, column and value."""
    header, names, units, columns, lines, first, faults, clocks, gaps = _native.read_table(
        str(file), text_bytes(file, encoding)
    )
    return Table(file, header, names, units, columns.T, lines, first, faults=faults, clocks=clocks, gaps=gaps)


def table_of(source: Any, name: str) -> Table | None:
    """Return the table of a DataFrame, of what becomes one (polars, pyarrow, xarray), or of a structured array."""
    if hasattr(source, "columns") and hasattr(source, "iloc"):
        return of_frame(source, Path(name))
    is_polars = type(source).__module__.partition(".")[0] == "polars"
    if is_polars and hasattr(source, "collect"):
        source = source.collect()
    if is_polars and hasattr(source, "columns"):
        # Its own conversion needs pyarrow.
        return _of_columns(Path(name), list(source.columns), [source[column].to_numpy() for column in source.columns])
    if isinstance(source, np.ndarray) and source.dtype.names:
        return _of_structured(Path(name), source)
    if hasattr(source, "to_pandas"):
        frame = source.to_pandas()
        table = of_frame(frame if hasattr(frame, "columns") else frame.to_frame(), Path(name))
        told = _units_of(source)
        return replace(table, units=[own or told.get(of) for of, own in zip(table.header, table.units, strict=True)])
    return None


def _units_of(source: Any) -> dict[str, str]:
    """Return the units that the variables of xarray have as attributes."""
    if not hasattr(source, "coords"):
        return {}
    variables = source.variables if hasattr(source, "data_vars") else {source.name: source, **source.coords}
    return {str(name): str(own.attrs["units"]) for name, own in variables.items() if own.attrs.get("units")}


def _of_structured(file: Path, array: NDArray[Any]) -> Table:
    if array.dtype.names is None:
        header = [str(number) for number in range(1, array.shape[-1] + 1)] if array.ndim == 2 else []
        if not header:
            raise ValueError(f"{file}: it has an array of shape {array.shape}; a table has names or columns")
        return _of_columns(file, header, list(array.T))
    return _of_columns(file, list(array.dtype.names), [array[name] for name in array.dtype.names])


def _of_arrow(file: Path, reader: str) -> Table:
    try:
        import pandas
    except ImportError as error:
        raise MissingPackage("pandas and pyarrow for Parquet files", "parquet") from error
    try:
        frame = getattr(pandas, reader)(file)
    except ImportError as error:
        raise MissingPackage("pyarrow, which pandas reads Parquet files with", "parquet") from error
    except (ValueError, OSError) as error:
        raise ValueError(f"{file}: it cannot be read: {error}") from None
    return of_frame(frame, file)


def of_frame(frame: Any, file: Path) -> Table:
    """Return the table of a pandas DataFrame; its index is a column, if it has a name or consists of times.

    What a run has recorded says so by itself, also after it was kept in a Parquet file.
    """
    is_recorded, between = bool(frame.attrs.get(Run.RECORDED, False)), frame.attrs.get(Run.BETWEEN, ())
    if frame.index.name is None and "time" not in frame.columns and frame.index.dtype.kind in "mMf":
        frame = frame.rename_axis("time")
    if frame.index.name is not None and frame.index.name not in frame.columns:
        frame = frame.reset_index()
    # By place, since a name may be there twice, which is refused where somebody asks for it.
    columns = [_array(frame.iloc[:, place]) for place in range(len(frame.columns))]
    return replace(
        _of_columns(file, [str(name) for name in frame.columns], columns), is_recorded=is_recorded, between=between
    )


def is_counted(index: Any) -> bool:
    """Tell whether an index of pandas only counts the rows."""
    return type(index).__name__ == "RangeIndex" and index.name is None


def _array(series: Any) -> NDArray[Any]:
    """Return the values of a Series; times with a zone as UTC."""
    is_zoned = getattr(series.dtype, "tz", None) is not None
    return np.asarray(series.dt.tz_convert(None) if is_zoned else series)


def numbers(column: Any) -> NDArray[np.float64]:
    """Return a column as numbers; of dates and times, also as text, the seconds since the first.

    Raises
    ------
    TypeError, ValueError
        For what is no number, though NumPy makes one of it: true and false, masked values, complex numbers.
    """
    if isinstance(column, np.ma.MaskedArray) and np.ma.is_masked(column):
        raise ValueError(f"value {np.argwhere(column.mask)[0][0]} is masked; fill it, or leave it out")
    found = np.asarray(column)
    if found.dtype.kind in KINDS:
        raise ValueError(f"the values are {KINDS[found.dtype.kind]}")
    if found.dtype.kind == "M":
        found = found - found[:1]
    if found.dtype.kind == "m":
        return np.asarray(found / np.timedelta64(1, "s"), dtype=float)
    # Of texts of its own NumPy would say the name that it has for them.
    listed = found.tolist() if found.dtype.kind in "OUT" else None
    if listed and isinstance(listed[0], timedelta):
        return np.array([one.total_seconds() for one in listed])
    if listed and found.ndim == 1 and not isinstance(listed[0], int | float):
        clock = _native.seconds_since_first([str(one) for one in listed])
        if clock is not None:
            return np.array(clock)
    return np.asarray(found if listed is None else listed, dtype=float)


KINDS = {"b": "true and false", "c": "complex"}


def _of_mat(file: Path) -> Table:
    found = binary_tables.of_matlab(file)
    columns = list(binary_tables.columns_of(found))
    if not columns:
        raise ValueError(f"{file}: there are no vectors of numbers in it, only {', '.join(found) or 'nothing'}")
    table = _of_columns(file, [name for name, _, _ in columns], [column for _, _, column in columns])
    return replace(table, units=[unit or own for (_, unit, _), own in zip(columns, table.units, strict=True)])


def _of_columns(file: Path, header: list[str], columns: Sequence[NDArray[Any]]) -> Table:
    names, units = _native.names_and_units(header)
    columns = [np.atleast_1d(column) for column in columns]
    lengths = [len(values) for values in columns]
    # A vector of another length is refused where somebody asks for it.
    usual = max(lengths, key=lengths.count, default=0)
    if "time" in names:
        usual = lengths[names.index("time")]
    values = np.full((usual, len(columns)), np.nan)
    faults: dict[int, str] = {}
    for at, column in enumerate(columns):
        if len(column) != usual:
            faults[at] = f"{file}, column {at + 1} ({names[at]}): it has {len(column)} values, others have {usual}"
            continue
        if column.ndim > 1:
            faults[at] = f"{file}, column {at + 1} ({names[at]}): it has the shape {column.shape}; a column is a vector"
            continue
        try:
            values[:, at] = _column(file, at + 1, names[at], column)
        except ValueError as error:
            faults[at] = str(error)
            if column.dtype.kind == "b":
                # An input may be true or false.
                values[:, at] = column
        if at not in faults and not np.issubdtype(column.dtype, np.number) and _are_times(column):
            units[at] = "s"
    return Table(file, header, names, units, values, np.arange(len(values)), 0, faults=faults)


def _are_times(column: NDArray[Any]) -> bool:
    return column.dtype.kind in "mM" or (len(column) > 0 and _native.is_clock(str(column[0])))


def _column(file: Path, number: int, name: str, column: NDArray[Any]) -> Array:
    place = f"column {number} ({name})"
    try:
        found = numbers(column)
    except (TypeError, ValueError) as error:
        if column.dtype.kind not in KINDS:
            for row, value in enumerate(column.tolist()):
                finite(str(value), f"{file}:{row}, {place}")
        raise ValueError(f"{file}, {place}: {error}") from None
    wrong = np.flatnonzero(~np.isfinite(found))
    if len(wrong):
        raise ValueError(f"{file}:{wrong[0]}, {place}: {found[wrong[0]]} is not finite")
    return found
