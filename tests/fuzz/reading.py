"""Task of the readers of the Python package with any file: read it, or refuse it by name with a `ValueError`."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pneumatic_servo as ps
from pneumatic_servo import ssv, tables

MODEL = ps.Model("PneumaticServoCylinder")


def check(data: bytes, folder: Path) -> None:
    """Read bytes as a file; the first tells which one."""
    file = folder / ("input.ssv" if data[:1] < b"\x80" else "input.csv")
    file.write_bytes(data[1:])
    try:
        read(file)
    except ValueError as error:
        if str(file) not in str(error):
            raise AssertionError(f"{error!r} does not name the file") from error


def read(file: Path) -> None:
    """Read the file as what its name says, and look at what comes of it."""
    if file.suffix == ".ssv":
        for name, value in ssv.read_ssv(file, MODEL).items():
            assert name in MODEL.variables
            assert isinstance(value, str) or np.isfinite(value), f"{name} = {value}"
    else:
        table = tables.read_table(file)
        assert table.values.shape == (len(table.lines), len(table.header)), table
        sound = [place for place in range(len(table.names)) if place not in table.faults]
        assert np.isfinite(table.values[:, sound]).all(), table
