"""Consistency of signals with one another: signs, chambers, velocities; reported before anything is fitted."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from pneumatic_servo.argument_names import quoted
from pneumatic_servo.errors import warn
from pneumatic_servo.identification.experiments import OF_CYLINDER, Experiment, Window
from pneumatic_servo.identification.smoothing import slope, smooth

Array = NDArray[np.float64]

AGAINST = -0.2
"""Share of the work that a force gives back in a cycle, below which its sign is in doubt; or a correlation."""
AWAY = 0.3
"""A cycle ends within this share of its length from its start: a weight gives its work back."""
UNLIKE = 1.5
"""Ratio of a velocity to the slope of its position, or its inverse, that shows another unit."""
MISTAKEN = (("mm/s", 1e3), ("deg/s", 57.3), ("rpm", 9.55))
"""Units of a velocity that are mistaken for the SI unit, with the factor of the error."""
WIDTH = 0.04
"""Width in s of the parabolas that give velocities here."""
CENTRE = 5.0
"""Voltage in V at which the valve is closed."""


def compare(experiment: Experiment, windows: Sequence[Window]) -> None:
    """Refuse a velocity that is not the slope of its position, and warn of signs that are likely turned."""
    _check_velocity(experiment, windows)
    known = {signal for window in windows for signal in window.record.signals}
    if "position" not in known and "velocity" not in known:
        return
    speed = np.concatenate([_speed(experiment, window) for window in windows])
    step = windows[0].record.step
    if experiment.name in OF_CYLINDER:
        _check_chambers(experiment, windows, speed, step)
        _check_voltage(experiment, windows, speed)
        return
    signal = "force" if experiment.name == "force" else experiment.compared[0]
    if experiment.name in ("force", "motion") and not (signal == "force" and "pressure" in known):
        force = np.concatenate([_grid(experiment, window, signal) for window in windows])
        if _share(force, speed, step) < AGAINST:
            warn(
                f"{signal} works against friction: it gives back more energy than it takes over a cycle; is its sign "
                f"or the sign of the motion turned? A minus before a column turns it, {signal}=-column"
            )


def _check_velocity(experiment: Experiment, windows: Sequence[Window]) -> None:
    both = [window for window in windows if {"position", "velocity"} <= window.record.signals.keys()]
    if not both:
        return
    seen = np.concatenate([_grid(experiment, window, "velocity") for window in both])
    true = np.concatenate([slope(_grid(experiment, w, "position"), w.record.step, _width(w)) for w in both])
    ratio = float(seen @ true / max(float(true @ true), 1e-300))
    likeness = float(seen @ true / max(float(np.linalg.norm(seen) * np.linalg.norm(true)), 1e-300))
    if abs(likeness) > 0.8 and not 1.0 / UNLIKE < ratio < UNLIKE:
        meant = "; is its sign turned? then write velocity=-column" if ratio < 0.0 else ""
        other = next((unit for unit, times in MISTAKEN if 0.5 * times < ratio < 2.0 * times), None)
        units = experiment.units
        if other is not None and (other == "mm/s") != units.is_rotating:
            meant = f"; is it in {other}? then write velocity=column[{other}]"
        raise ValueError(
            f"{both[0].record.name}: velocity is {ratio:.4g} times the slope of position, in "
            f"{units.of_signal('velocity')} and {units.of_signal('position')}{meant}"
        )


def _check_chambers(experiment: Experiment, windows: Sequence[Window], speed: Array, step: float) -> None:
    needed = {"position", "chamberA.pressure", "chamberB.pressure"}
    if not all(needed <= window.record.signals.keys() for window in windows):
        return
    force = np.concatenate([experiment.pressure_force(window, {}) for window in windows])
    if _share(force, speed, step) < AGAINST:
        warn(
            "the pressures work against the motion: the position falls when chamberA.pressure is the higher one; are "
            "the chambers swapped, or does the position count from the other end? Then write position=-column, and by "
            f"{quoted('settings')} offset.position = -cylinder.stroke"
        )


def _check_voltage(experiment: Experiment, windows: Sequence[Window], speed: Array) -> None:
    if not all("valveVoltage" in window.record.signals for window in windows):
        return
    opening = np.concatenate([_grid(experiment, window, "valveVoltage") for window in windows]) - CENTRE
    size = float(np.linalg.norm(opening) * np.linalg.norm(speed))
    if size > 0.0 and float(opening @ speed) / size < AGAINST:
        warn(
            "the position falls when valveVoltage is above 5 V: is the sign of one of them turned, or are the hoses "
            f"crossed? {quoted('settings', {'gain.valveVoltage': -1, 'offset.valveVoltage': 10})} turns the voltage"
        )


def _share(force: Array, speed: Array, step: float) -> float:
    """Return the work of a force as a share of all that it gives and takes; 1 where it says nothing of signs."""
    way = float(np.sum(np.abs(speed)) * step)
    if way <= 0.0 or abs(float(np.sum(speed)) * step) > AWAY * way:
        return 1.0
    return float(force @ speed) / max(float(np.abs(force) @ np.abs(speed)), 1e-300)


def _width(window: Window) -> float:
    return max(WIDTH, 5.0 * window.record.step)


def _speed(experiment: Experiment, window: Window) -> Array:
    record = window.record
    if "position" in record.signals:
        return slope(_grid(experiment, window, "position"), record.step, _width(window))
    return smooth(_grid(experiment, window, "velocity"), record.step, _width(window))


def _grid(experiment: Experiment, window: Window, signal: str) -> Array:
    return experiment.true(signal, window.record.on_grid(signal), {})
