"""Figures of a fit."""

from __future__ import annotations

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray

from pneumatic_servo.figures import BLUE, GREY, HEIGHT, STYLE, VERMILION, WIDTH, Drawing
from pneumatic_servo.identification.fitted import Fitted
from pneumatic_servo.identification.kinds import measured_speed
from pneumatic_servo.identification.residuals import Residuals
from pneumatic_servo.identification.steady import steady

Array = NDArray[np.float64]

POINTS = 4000
"""Points that a line of a figure has at most."""
SHOWN = 60
"""Samples before and after the worst misfit that its picture has."""
UNITS = {"m": ("mm", 1e3), "m/s": ("mm/s", 1e3), "Pa": ("bar", 1e-5)}
"""Units of figures in place of SI units."""


def shown(unit: str) -> tuple[str, float]:
    """Return the unit in which figures show an SI unit, and the factor to it."""
    return UNITS.get(unit, (unit, 1.0))


def overlay(residuals: Residuals) -> Figure:
    """Draw measured and simulated signals over each other, and residuals, one pair of panels per signal."""
    signals = residuals.signals
    if residuals.problem.experiment.is_steady:
        return over_velocity(residuals)
    with mpl.rc_context(STYLE):
        figure = Drawing(figsize=(WIDTH, 0.6 + HEIGHT * 2 * len(signals)), layout="constrained")
        axes = figure.subplots(2 * len(signals), 1, sharex=True, squeeze=False)[:, 0]
        for place, signal in enumerate(signals):
            unit, factor = shown(residuals.unit(signal))
            upper, lower = axes[2 * place], axes[2 * place + 1]
            for course in residuals.courses(signal):
                cut = slice(None, None, max(1, len(course.time) // POINTS))
                upper.plot(course.time[cut], factor * course.measured[cut], color=GREY, lw=2.0)
                upper.plot(course.time[cut], factor * (course.measured - course.difference)[cut], color=BLUE, lw=1.0)
                lower.plot(course.time[cut], factor * course.difference[cut], color=VERMILION, lw=0.7)
            upper.set_ylabel(f"{signal} ({unit})")
            lower.set_ylabel(f"rest ({unit})")
        axes[0].plot([], [], color=GREY, lw=2.0, label="measured")
        axes[0].plot([], [], color=BLUE, label="fitted")
        axes[0].legend(ncols=2, loc="upper right")
        axes[-1].set_xlabel("time (s), records one after the other")
    return figure


def over_velocity(residuals: Residuals) -> Figure:
    """Draw measured and fitted points, and residuals, over the velocity."""
    signal = residuals.signals[0]
    (unit, factor), (pace, times) = shown(residuals.unit(signal)), shown(residuals.unit("velocity"))
    courses = list(residuals.courses(signal))
    measured = np.concatenate([course.measured for course in courses])
    rest = np.concatenate([course.difference for course in courses])
    speed = times * np.concatenate([window.record.signals["velocity"] for window in residuals.windows])
    with mpl.rc_context(STYLE):
        figure = Drawing(figsize=(WIDTH, 0.6 + HEIGHT * 2), layout="constrained")
        upper, lower = figure.subplots(2, 1, sharex=True)
        upper.plot(speed, factor * measured, "o", ms=4.0, color=GREY, label="measured")
        upper.plot(speed, factor * (measured - rest), "x", ms=4.0, color=BLUE, label="fitted")
        lower.plot(speed, factor * rest, "o", ms=3.0, color=VERMILION)
        upper.set_ylabel(f"{signal} ({unit})")
        lower.set(xlabel=f"velocity ({pace})", ylabel=f"rest ({unit})")
        upper.legend(ncols=2, loc="best")
    return figure


def worst_misfit(residuals: Residuals) -> Figure | None:
    """Draw the signal that is missed most about the place where it is, with the velocity there; nothing of points."""
    worst = residuals.worst()
    if worst is None or residuals.problem.experiment.is_steady:
        return None
    window, course = residuals.windows[worst.window], list(residuals.courses(worst.signal))[worst.window]
    record, (unit, factor) = window.record, shown(residuals.unit(worst.signal))
    near = slice(max(0, worst.sample - SHOWN), worst.sample + SHOWN + 1)
    time = record.begin + record.time[near]
    with mpl.rc_context(STYLE):
        figure = Drawing(figsize=(WIDTH, 3.2), layout="constrained")
        upper, lower = figure.subplots(2, 1, sharex=True, height_ratios=(2, 1))
        upper.plot(time, factor * course.measured[near], color=GREY, lw=2.0, label="measured")
        upper.plot(time, factor * (course.measured - course.difference)[near], color=BLUE, lw=1.0, label="fitted")
        upper.set_ylabel(f"{worst.signal} ({unit})")
        upper.set_title(f"{record.name}: worst at {record.begin + record.time[worst.sample]:.4g} s")
        upper.legend(ncols=2, loc="best")
        pace, times = shown(residuals.unit("velocity"))
        lower.plot(time, times * measured_speed(record)[near], color=VERMILION, lw=1.0)
        lower.set(xlabel="time of the record (s)", ylabel=f"velocity ({pace})")
        for axis in (upper, lower):
            axis.axvline(record.begin + record.time[worst.sample], color=GREY, lw=0.7, ls=":")
    return figure


def against(residuals: Residuals) -> Figure:
    """Draw residuals against velocity and position, and their autocorrelation."""
    signal = residuals.signals[0]
    unit, factor = shown(residuals.unit(signal))
    with mpl.rc_context(STYLE):
        figure = Drawing(figsize=(WIDTH, 2.8), layout="constrained")
        first, second, third = figure.subplots(1, 3)
        rest = residuals.all(signal)
        cut = slice(None, None, max(1, len(rest) // POINTS))
        (pace, by_pace), (way, by_way) = (shown(residuals.unit(name)) for name in ("velocity", "position"))
        second_axis = f"position ({way})"
        if residuals.problem.experiment.is_steady:
            second_axis, by_way = "number of the point", 1.0
        first.plot(by_pace * residuals.velocity[cut], factor * rest[cut], ".", ms=1.5, color=VERMILION)
        first.set(xlabel=f"velocity ({pace})", ylabel=f"rest of {signal} ({unit})")
        second.plot(by_way * residuals.position[cut], factor * rest[cut], ".", ms=1.5, color=VERMILION)
        second.set(xlabel=second_axis)
        white = residuals.correlation(signal)
        third.plot(np.arange(len(white)), white, color=BLUE)
        third.axhspan(-residuals.limit(signal), residuals.limit(signal), color=GREY, alpha=0.3)
        third.set(xlabel="lag (samples)", ylabel="autocorrelation")
    return figure


def friction_map(fit: Fitted) -> Figure | None:
    """Draw friction against velocity, as the data alone and as the fitted law have it."""
    experiment, values = fit.problem.experiment, fit.values
    maps = [found for window in fit.problem.windows if (found := experiment.forces(window, values)) is not None]
    if not maps:
        return None
    speed, force, level = (np.concatenate(parts) for parts in zip(*maps, strict=True))
    loaded = level > 1e-3
    with mpl.rc_context(STYLE):
        figure = Drawing(figsize=(WIDTH, 3.2), layout="constrained")
        axis = figure.subplots()
        cut = slice(None, None, max(1, int(np.sum(loaded)) // (2 * POINTS)))
        unit, factor = shown(fit.units.of_signal("velocity"))
        axis.plot(
            factor * speed[loaded][cut], (force[loaded] / level[loaded])[cut], ".", ms=1.5, color=GREY, label="data"
        )
        curve = steady(fit, float(np.max(np.abs(speed), initial=1e-6)))
        if curve is not None:
            axis.plot(factor * curve[0], curve[1], color=BLUE, label=f"{fit.law}, steady")
        axis.set(xlabel=f"velocity ({unit})", ylabel=f"friction at load factor 1 ({fit.units.of('N')})")
        axis.legend()
    return figure
