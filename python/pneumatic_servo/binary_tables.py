"""Binary files of recorders and of MATLAB, by the libraries that read them, which are imported when they are needed."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pneumatic_servo.columns import Table
from pneumatic_servo.errors import MissingPackage

Array = NDArray[np.float64]


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


def of_tdms(file: Path) -> Channels:
    """Return the channels of a file of LabVIEW or DIAdem, by npTDMS."""
    try:
        from nptdms import TdmsFile
    except ImportError as error:
        raise MissingPackage("npTDMS", "recorders") from error
    found = Channels()
    with TdmsFile.open(file) as opened:
        channels = [channel for group in opened.groups() for channel in group.channels() if len(channel)]
        twice = _twice([channel.name for channel in channels])
        # Each channel has a start of its own, which may be another's: a channel that was begun later is later.
        waves = [channel.properties for channel in channels if "wf_increment" in channel.properties]
        begun = [told["wf_start_time"] for told in waves if "wf_start_time" in told]
        if 0 < len(begun) < len(waves):
            raise ValueError(
                f"{file}: {len(begun)} of {len(waves)} channels with wf_increment have wf_start_time: nobody knows "
                "when the others began; write the property to all channels or to none"
            )
        for channel in channels:
            name = f"{channel.group_name}/{channel.name}" if channel.name in twice else channel.name
            told = channel.properties
            clock = 0
            if "wf_increment" in told:
                start = told.get("wf_start_offset", 0.0)
                if begun:
                    start += (told["wf_start_time"] - min(begun)) / np.timedelta64(1, "s")
                clock = found.add_clock(start + told["wf_increment"] * np.arange(len(channel)), "s")
            unit = str(told.get("unit_string", "")).strip()
            found.add(name, unit or None, channel[:], clock)
    return found


def of_mdf(file: Path) -> Channels:
    """Return the channels of a measurement file of ASAM (MDF 3 and 4), by asammdf; each group has its clock."""
    try:
        from asammdf import MDF
    except ImportError as error:
        raise MissingPackage("asammdf", "recorders") from error
    found = Channels()
    with MDF(file) as opened:
        masters = opened.masters_db
        groups: Any = opened.groups
        channels = [
            opened.get(group=group, index=index)
            for group, of_group in enumerate(groups)
            for index in range(len(of_group.channels))
            if masters.get(group) != index
        ]
    numbers = [channel for channel in channels if channel.samples.ndim == 1 and channel.samples.dtype.kind in "fiub"]
    twice = _twice([channel.name for channel in numbers])
    for number, channel in enumerate(numbers):
        clock = found.add_clock(np.asarray(channel.timestamps, dtype=float), "s")
        name = f"{channel.name} {number + 1}" if channel.name in twice else channel.name
        found.add(name, channel.unit or None, channel.samples, clock)
    return found


def _twice(names: list[str]) -> set[str]:
    return {name for name in names if names.count(name) > 1}


def of_matlab(file: Path) -> dict[str, Any]:
    """Return the variables of a .mat file of any version; structures are mappings, arrays of them lists."""
    try:
        from scipy.io import loadmat
    except ImportError as error:
        raise MissingPackage("SciPy", "identification") from error
    with file.open("rb") as opened:
        is_hdf5 = b"\x89HDF\r\n" in opened.read(1024)
    if is_hdf5:
        return _of_hdf5(file)
    try:
        read = loadmat(file, simplify_cells=True)
    except ValueError as error:
        raise ValueError(f"{file}: it cannot be read: {error}") from None
    return {name: value for name, value in read.items() if not name.startswith("__")}


def _of_hdf5(file: Path) -> dict[str, Any]:
    """Return the variables of a file of version 7.3, which is HDF5 with transposed arrays."""
    try:
        import h5py
    except ImportError as error:
        raise MissingPackage("h5py for files of version 7.3", "recorders") from error

    def value(item: Any) -> Any:
        if isinstance(item, h5py.Group):
            return {name: value(one) for name, one in item.items()}
        numbers = item[()]
        if item.attrs.get("MATLAB_class") == b"char":
            return "".join(chr(code) for code in np.ravel(numbers.T))
        if numbers.dtype == h5py.ref_dtype:
            return [value(opened[one]) for one in np.ravel(numbers.T)]
        return np.squeeze(np.transpose(numbers))

    with h5py.File(file) as opened:
        return {name: value(item) for name, item in opened.items() if not name.startswith("#")}


def columns_of(found: Mapping[str, Any]) -> Iterator[tuple[str, str | None, Any]]:
    """Yield name, unit and vector of what a .mat file has: vectors, structures, and what Simulink and dSPACE write."""
    matrices = [name for name, value in found.items() if _is_matrix(value)]
    for name, value in found.items():
        if isinstance(value, Mapping):
            prefix = "" if len(found) == 1 else f"{name}."
            for own, unit, column in _of_structure(value):
                yield f"{prefix}{own}", unit, column
        elif np.ndim(value) == 1 and np.asarray(value).dtype.kind in "fiubmM":
            yield name, None, np.asarray(value)
        elif name in matrices:
            # To File writes a row for each signal, the first one has the times.
            rows = np.asarray(value) if np.shape(value)[0] < np.shape(value)[1] else np.asarray(value).T
            is_alone = len(matrices) == 1 and not any(np.ndim(own) == 1 for own in found.values())
            for number, row in enumerate(rows, start=1):
                yield str(number) if is_alone else f"{name} {number}", None, row


def _is_matrix(value: Any) -> bool:
    return (
        not isinstance(value, Mapping | list | str) and np.ndim(value) == 2 and np.asarray(value).dtype.kind in "fiub"
    )


def _of_structure(value: Mapping[str, Any]) -> Iterator[tuple[str, str | None, Any]]:
    if {"time", "signals"} <= value.keys():
        yield "time", "s", np.asarray(value["time"])
        signals = value["signals"] if isinstance(value["signals"], list) else [value["signals"]]
        for number, signal in enumerate(signals, start=1):
            label = signal.get("label")
            name = label if isinstance(label, str) and label else f"signal {number}"
            columns = np.asarray(signal["values"])
            if columns.ndim == 1:
                yield name, None, columns
            else:
                for place in range(columns.shape[-1]):
                    yield f"{name} {place + 1}", None, columns[:, place]
    elif {"X", "Y"} <= value.keys() and isinstance(_listed(value["Y"])[0], Mapping):
        # ControlDesk of dSPACE.
        axes = _listed(value["X"])
        yield "time", _unit(axes[0]) or "s", np.asarray(axes[0]["Data"])
        for signal in _listed(value["Y"]):
            yield str(signal["Name"]), _unit(signal), np.asarray(signal["Data"])
    else:
        for name, own in value.items():
            if isinstance(own, Mapping):
                for inner, unit, column in _of_structure(own):
                    yield f"{name}.{inner}", unit, column
            elif np.ndim(own) == 1 and np.asarray(own).dtype.kind in "fiubmM":
                yield name, None, np.asarray(own)


def _listed(value: Any) -> list[Any]:
    return list(value) if isinstance(value, list | np.ndarray) else [value]


def _unit(value: Mapping[str, Any]) -> str | None:
    unit = value.get("Unit")
    return unit.strip() or None if isinstance(unit, str) else None
