"""Measured friction over velocity as parameters of the law ``Table``."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pneumatic_servo.units import factor

Array = NDArray[np.float64]

POINTS = 11
"""Points that a direction may have."""
NAMES = {"velocity": ("velocity", "speed", "v"), "force": ("force", "friction", "frictionforce", "friction force", "f")}
UNITS = {"velocity": "m/s", "force": "N"}
SIDES = (("outwards", 1.0), ("inwards", -1.0))


def friction_table(velocity: Any, force: Any = None) -> dict[str, Any]:
    """Return the settings of the friction law ``Table`` for measured friction over velocity.

    A direction of at most eleven velocities has them as its points. More, as the samples of a recorder, are fitted by a
    line with eleven corners, which are closer where the carriage is slow. The force at the least velocity breaks away.
    A direction without data takes the points of the other direction.

    Parameters
    ----------
    velocity : path, table or array of shape (rows,)
        Velocities in m/s, positive outwards; or a file, DataFrame or mapping with the columns ``velocity`` and
        ``force``, whose units may stand behind their names, as in ``velocity [mm/s]``.
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
    >>> measured = ps.friction_table([-0.2, -0.02, 0.0, 0.05, 0.2], [-14.0, -9.0, 11.0, 8.5, 12.0])
    >>> measured["friction.table.outwards.force[2]"]
    8.5
    """
    if force is None:
        velocity, force = _columns(velocity)
    speeds, forces = (_numbers(name, given) for name, given in (("velocity", velocity), ("force", force)))
    if len(speeds) != len(forces):
        raise ValueError(f"velocity has {len(speeds)} rows and force {len(forces)}: they must have as many")
    is_unsigned = bool(np.all(forces >= 0.0) and np.any(speeds < 0.0))
    if is_unsigned:
        # At rest such a force counts for both directions.
        rests = speeds == 0.0
        forces = np.concatenate([np.where(speeds < 0.0, -forces, forces), -forces[rests]])
        speeds = np.concatenate([speeds, speeds[rests]])
    side = np.where(speeds != 0.0, np.sign(speeds), np.where(forces < 0.0, -1.0, 1.0))
    curves = {name: _curve(name, np.abs(speeds[side == sign]), sign * forces[side == sign]) for name, sign in SIDES}
    known = next((curve for curve in curves.values() if curve is not None), None)
    if known is None:
        raise ValueError("velocity has no rows: a curve of friction needs two velocities")
    settings: dict[str, Any] = {"friction.law": "Table", "friction.table.sigma2": 0.0}
    for name, curve in curves.items():
        own = known if curve is None else curve
        settings[f"friction.table.{name}.points"] = len(own[0])
        for place, (speed, level) in enumerate(zip(*own, strict=True), start=1):
            settings[f"friction.table.{name}.speed[{place}]"] = float(speed)
            settings[f"friction.table.{name}.force[{place}]"] = float(level)
    return settings


def _columns(given: Any) -> tuple[Any, Any]:
    """Return velocity in m/s and force in N of a file or a table."""
    if isinstance(given, str | Path):
        from pneumatic_servo.delimited import read_text

        table = read_text(Path(given))
        found = {}
        for quantity, si in UNITS.items():
            place = _place(quantity, table.names, str(given))
            found[quantity] = table.in_si(place, table.units[place] or si, si)
        return found["velocity"], found["force"]
    if not isinstance(given, Mapping) and not hasattr(given, "columns"):
        raise TypeError(
            f"velocity = {type(given).__name__} without force is refused: it must be a file or a table with both"
        )
    from pneumatic_servo.columns import names_and_units

    headers = [str(name) for name in (given.columns if hasattr(given, "columns") else given)]
    names, units = names_and_units(headers)
    found = {}
    for quantity, si in UNITS.items():
        place = _place(quantity, names, "the table")
        times = factor(units[place] or si, si, headers[place])
        found[quantity] = np.asarray(given[headers[place]], dtype=np.float64) * times
    return found["velocity"], found["force"]


def _place(quantity: str, names: list[str], where: str) -> int:
    known = [place for place, name in enumerate(names) if name.strip().lower() in NAMES[quantity]]
    if len(known) != 1:
        raise ValueError(f"{where} has the columns {', '.join(names)}: one of them must be {quantity}")
    return known[0]


def _numbers(name: str, given: Any) -> Array:
    try:
        values = np.asarray(given, dtype=np.float64)
    except (TypeError, ValueError):
        raise TypeError(f"{name} is refused: it must be numbers in {UNITS[name]}") from None
    if values.ndim != 1 or not np.all(np.isfinite(values)):
        raise ValueError(f"{name} is refused: it must be a row of finite numbers in {UNITS[name]}")
    return values


def _curve(name: str, speeds: Array, forces: Array) -> tuple[Array, Array] | None:
    """Return points of rising speed, if there are two."""
    different = np.unique(speeds)
    if len(different) == 0:
        return None
    if len(different) == 1:
        raise ValueError(f"the friction {name} has one velocity, {different[0]:g} m/s: a curve needs two")
    if len(different) <= POINTS:
        found = np.array([np.mean(forces[speeds == speed]) for speed in different])
        if np.any(found < 0.0):
            place = int(np.argmin(found))
            raise ValueError(
                f"the friction {name}, {found[place]:g} N at {different[place]:g} m/s, drives: it must have the sign "
                "of the velocity"
            )
        return different, found
    corners = np.linspace(np.sqrt(different[0]), np.sqrt(different[-1]), POINTS) ** 2
    corners[0], corners[-1] = different[0], different[-1]
    hats = np.stack([np.interp(speeds, corners, unit) for unit in np.eye(POINTS)], axis=1)
    # A corner without data beside it is none.
    told = np.flatnonzero(np.max(hats, axis=0) > 0.0)
    hats = np.stack([np.interp(speeds, corners[told], unit) for unit in np.eye(len(told))], axis=1)
    found = np.linalg.lstsq(hats, forces, rcond=None)[0]
    if np.any(found < 0.0):
        raise ValueError(f"the friction {name} scatters so much that its curve falls below 0: average it before")
    return corners[told], found
