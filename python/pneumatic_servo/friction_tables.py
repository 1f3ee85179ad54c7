"""Measured friction over velocity as parameters of the law ``Table``."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pneumatic_servo import _native
from pneumatic_servo.units import factor, is_quantity, magnitude

Array = NDArray[np.float64]

UNITS = {"velocity": "m/s", "force": "N"}


def friction_table(velocity: Any, force: Any = None) -> dict[str, Any]:
    """Return the settings of the friction law ``Table`` for measured friction over velocity.

    A direction of at most eleven velocities has them as its points. More, as the samples of a recorder, are fitted by a
    line with eleven corners, which are closer where the carriage is slow. The force at the least velocity breaks away.
    A direction without data takes the points of the other direction. Rows may be in any order. The page in the browser
    reads the same files by the same rules.

    Parameters
    ----------
    velocity : path, table or array of shape (rows,) or (rows, 2)
        Velocities in m/s, positive outwards; or points, a velocity and a force in each row; or a file, DataFrame or
        mapping with the columns ``velocity`` and ``force``, whose units may stand behind their names, as in
        ``velocity [mm/s]``. ``v``, ``speed`` and ``friction`` are such names, too.
    force : array of shape (rows,), optional
        Friction forces in N, with the sign of the velocity, or all positive. At velocity 0 the sign is the direction;
        of forces that are all positive the one there counts for both.

    Returns
    -------
    dict
        Parameters by name, for any run. Viscous friction ``friction.table.sigma2`` is 0, since the table has it.

    Raises
    ------
    ValueError
        For columns that are not there, numbers that are not finite, less than two velocities, and friction that drives.
        Single samples of many may do so.

    Examples
    --------
    >>> import pneumatic_servo as ps
    >>> measured = ps.friction_table([(-0.2, -14.0), (-0.02, -9.0), (0.0, 11.0), (0.05, 8.5), (0.2, 12.0)])
    >>> measured["friction.table.outwards.force[2]"]
    8.5
    >>> run = ps.Model().simulate({**measured, "mass.moving": 1.2}, inputs={"valveVoltage": 6.0}, stop=0.1)
    """
    origin = None
    if force is None:
        velocity, force, origin = _columns(velocity)
    speeds, forces = (_numbers(name, given) for name, given in (("velocity", velocity), ("force", force)))
    settings: dict[str, Any] = {"friction.law": "Table"}
    for name, value in _native.friction_table(speeds, forces, origin):
        settings[name] = int(value) if name.endswith(".points") else value
    return settings


def _columns(given: Any) -> tuple[Any, Any, tuple[str, NDArray[np.int64]] | None]:
    """Return velocity in m/s and force in N of a file, a table or points; of a file also its name and lines."""
    if isinstance(given, str | Path):
        from pneumatic_servo.tables import read_text

        table = read_text(Path(given))
        places = _native.friction_columns(str(given), table.names)
        found = [
            table.in_si(place, table.units[place] or si, si) for place, si in zip(places, UNITS.values(), strict=True)
        ]
        return found[0], found[1], (str(given), table.lines)
    if isinstance(given, Mapping) or hasattr(given, "columns"):
        headers = [str(name) for name in (given.columns if hasattr(given, "columns") else given)]
        names, units = _native.names_and_units(headers)
        found = []
        for place, si in zip(_native.friction_columns("the table", names), UNITS.values(), strict=True):
            column = given[headers[place]]
            if is_quantity(column):
                found.append(np.asarray(magnitude(column, si, headers[place]), dtype=np.float64))
                continue
            found.append(np.asarray(column, dtype=np.float64) * factor(units[place] or si, si, headers[place]))
        return found[0], found[1], None
    try:
        points = np.asarray(given, dtype=np.float64)
    except (TypeError, ValueError):
        points = np.empty(0)
    if points.ndim != 2 or points.shape[1] != 2:
        raise TypeError(
            f"velocity = {type(given).__name__} without force is refused: it must be a file or a table with both, or "
            "points of velocity and force, of shape (rows, 2)"
        )
    return points[:, 0], points[:, 1], None


def _numbers(name: str, given: Any) -> Array:
    if is_quantity(given):
        given = magnitude(given, UNITS[name], name)
    try:
        values = np.asarray(given, dtype=np.float64)
    except (TypeError, ValueError):
        raise TypeError(f"{name} is refused: it must be numbers in {UNITS[name]}") from None
    if values.ndim != 1 or not np.all(np.isfinite(values)):
        raise ValueError(f"{name} is refused: it must be a row of finite numbers in {UNITS[name]}")
    return values
