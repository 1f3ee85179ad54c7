"""A start for the parameters of a law, found from the data."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pneumatic_servo import _native
from pneumatic_servo.identification.experiments import Window
from pneumatic_servo.identification.parameters import group_of
from pneumatic_servo.identification.problem import Problem
from pneumatic_servo.identification.records import plain

Array = NDArray[np.float64]

ELEMENTS = 10
"""Elements of the laws that have several."""


def started(problem: Problem) -> Problem:
    """Return the problem with starts from the data for parameters without a given start."""
    values = {free.name: free.start for free in problem.free}
    if "area" in values and np.isnan(values["area"]):
        values["area"] = _area(problem)
    values |= problem.experiment.guess(problem.windows, values)
    values |= _levels(problem, values)
    if problem.experiment.name == "motion":
        values |= _elements(problem, values)
    return problem.with_free([free.at(values[free.name]) for free in problem.free])


def _area(problem: Problem) -> float:
    """Force over pressure, of all samples: friction has both signs."""
    parts = [(window.record.signals["pressure"][window.used], window.record.signals["force"][window.used])
             for window in problem.windows]  # fmt: skip
    pressure, force = (np.concatenate(values) for values in zip(*parts, strict=True))
    return float(pressure @ force / max(pressure @ pressure, 1e-300))


def _levels(problem: Problem, values: dict[str, float]) -> dict[str, float]:
    """Friction levels from a map of mean force against speed."""
    group = group_of(problem.experiment.law, problem.experiment.table) + "."
    own = [free for free in problem.free if free.name.startswith(group)]
    maps = [found for window in problem.windows if (found := problem.experiment.forces(window, values)) is not None]
    if not own or not maps:
        return {}
    speed, force, level = (np.concatenate(parts) for parts in zip(*maps, strict=True))
    experiment, variables = problem.experiment, problem.experiment.table.variables
    static, bristles = f"{group}Fs", f"{group}N"
    is_fixed = static in variables and static not in {free.name for free in own}
    return _native.friction_levels(
        experiment.law, group, experiment.value(static, {}) if is_fixed else None,
        experiment.value(bristles, values) if bristles in variables else 0.0,
        [(free.name, free.unit) for free in own], speed, force, level, _length(problem),
    )  # fmt: skip


def _length(problem: Problem) -> float:
    """Presliding length in m: a fiftieth of the stroke, as far as nothing better is known."""
    strokes = [np.ptp(window.record.signals["position"]) for window in problem.windows
               if "position" in window.record.signals]  # fmt: skip
    return _native.presliding(max(map(float, strokes), default=None))


def _elements(problem: Problem, values: dict[str, float]) -> dict[str, float]:
    """Stiffnesses of parallel elements by non-negative least squares, with fixed deflections at which they slip."""
    law = problem.experiment.law
    if law not in ("MaxwellSlip", "GMS", "Leuven", "DNLRX"):
        return {}
    group = group_of(law, problem.experiment.table) + "."
    number = int(problem.experiment.value(f"{group}N", values)) if law != "Leuven" else ELEMENTS
    stroke = max(float(np.ptp(window.driven["position"])) for window in problem.windows)
    ends = _native.element_ends(stroke, number)
    stiffness, offset = springs(problem, ends, values)
    # The shares of GMS belong to its level, where that is not free.
    is_fixed = law == "GMS" and all(free.name != f"{group}Fc" for free in problem.free)
    level = problem.experiment.value(f"{group}Fc", {}) if is_fixed else None
    found = _native.element_starts(law, group, ends, stiffness, level)
    return {**found, f"offset.{problem.experiment.compared[0]}": offset}


def springs(problem: Problem, ends: Array, values: dict[str, float]) -> tuple[Array, float]:
    """Return the stiffnesses in N/m of elements that slip at deflections, and the constant force beside them."""
    rows, forces = [], []
    for window in problem.windows:
        parts = problem.experiment.forces(window, values | {f"offset.{problem.experiment.compared[0]}": 0.0})
        if parts is None:
            continue
        _, force, level = parts
        plays = np.array([deflection(window, end) for end in ends])
        use = window.used & ~window.held
        rows.append(np.vstack([plays[:, use] * level, np.ones(int(np.sum(use))), -np.ones(int(np.sum(use)))]).T)
        forces.append(force)
    solution = np.array(_native.nonnegative(np.concatenate(rows), np.concatenate(forces)))
    return solution[:-2], float(solution[-2] - solution[-1])


def deflection(window: Window, end: float) -> Array:
    """Return the deflection of an element that slips at an end, at the samples."""
    course = _native.deflection(plain(window.driven["position"]), end)
    return np.interp(window.record.time, window.record.grid, course)
