"""A start for the parameters of a law, found from the data."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from pneumatic_servo import _native
from pneumatic_servo.identification.experiments import Window
from pneumatic_servo.identification.experiments.motion import Motion
from pneumatic_servo.identification.parameters import VISCOUS, Free, group_of
from pneumatic_servo.identification.problem import Problem
from pneumatic_servo.identification.signals import ROTATING
from pneumatic_servo.identification.smoothing import fastest

Array = NDArray[np.float64]

BELOW = 0.8
"""Share of a static friction that is not free with which sliding friction starts at most."""
DAMPING = ("N.s/m", ROTATING["N.s/m"])
"""Units of viscous friction."""
ELEMENTS = 10
"""Elements of the laws that have several."""


def started(problem: Problem) -> Problem:
    """Return the problem with starts from the data for parameters without a given start."""
    values = {free.name: free.start for free in problem.free}
    if "area" in values and np.isnan(values["area"]):
        values["area"] = _area(problem)
    values |= problem.experiment.guess(problem.windows, values)
    values |= _levels(problem, values)
    if isinstance(problem.experiment, Motion):
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
    fast = fastest(speed)
    sliding = (np.abs(speed) > 0.1 * fast) & (level > 1e-3)
    if fast == 0.0 or np.sum(sliding) < 10:
        return {}
    pace, dry = np.abs(speed[sliding]), force[sliding] * np.sign(speed[sliding]) / level[sliding]
    coulomb, viscous = _line(own, pace, dry, 0.3 * fast)
    # Sliding friction beyond a static friction that stays as it is would be refused.
    static = f"{group}Fs"
    if static in problem.experiment.table.variables and static not in {free.name for free in own}:
        coulomb = min(coulomb, BELOW * problem.experiment.value(static, {}))
    excess = dry - coulomb - viscous * pace
    statics = coulomb + min(max(float(np.quantile(excess, 0.98)), 0.1 * coulomb), 2.0 * coulomb)
    length = _length(problem)
    levels = {
        "Fc": coulomb, "Fc1": coulomb, "Fc2": coulomb, "Fs": statics, "FsInf": statics, "f1": 0.6 * coulomb,
        "vs": 0.1 * fast, "sigma0": coulomb / length, "k1": 0.3 * coulomb / length, "f2": 3.0 / length,
        "vd": fast, "deltaS": length, "z0": length, "Delta": length, "xe": length,
    }  # fmt: skip
    if problem.experiment.law == "Armstrong":
        # There it is the excess of static over sliding friction.
        levels["FsInf"] = statics - coulomb
    if problem.experiment.law == "BlimanSorine":
        levels |= {"f1": 3.0 * coulomb, "f2": 2.0 * coulomb}
    if problem.experiment.law == "Bristle":
        bristles = problem.experiment.value(f"{group}N", values)
        levels["sigma0"] = 1.5 * coulomb / (bristles * length)
    starts = {}
    for free in own:
        kind = free.name.rsplit(".", 1)[1].partition("[")[0]
        if free.name.endswith("stribeck.FsInf"):
            starts[free.name] = 1.2 * statics
        elif kind in levels:
            starts[free.name] = levels[kind]
        elif kind in VISCOUS:
            starts[free.name] = max(viscous, 0.05 * coulomb / fast)
        elif kind == "sigma1":
            starts[free.name] = 0.1 * levels["sigma0"] * length / fast
        elif kind == "k":
            starts[free.name] = coulomb / length / 4.0
        elif kind == "W":
            starts[free.name] = coulomb / 4.0
    return starts


def _line(own: Sequence[Free], pace: Array, dry: Array, least: float) -> tuple[float, float]:
    """Friction at speed 0 and its growth, from the faster samples; no growth under a law without a free one."""
    middle = max(float(np.median(dry)), 1e-9)
    fast = pace > least
    if not any(free.unit in DAMPING for free in own) or np.sum(fast) < 10:
        return middle, 0.0
    slope, coulomb = np.polyfit(pace[fast], dry[fast], 1)
    if slope <= 0.0 or coulomb < 0.1 * middle:
        return middle, 0.0
    return float(coulomb), float(slope)


def _length(problem: Problem) -> float:
    """Presliding length in m: a fiftieth of the stroke, as far as nothing better is known."""
    strokes = [np.ptp(window.record.signals["position"]) for window in problem.windows
               if "position" in window.record.signals]  # fmt: skip
    return max(float(max(strokes, default=1e-3)) / 50.0, 1e-7)


def lengths(problem: Problem, number: int = ELEMENTS) -> Array:
    """Deflections in m at which elements slip, spread over the stroke on a logarithmic scale."""
    strokes = [np.ptp(window.driven["position"]) for window in problem.windows]
    return np.geomspace(max(strokes) / 100.0, max(strokes), number)


def _elements(problem: Problem, values: dict[str, float]) -> dict[str, float]:
    """Stiffnesses of parallel elements by non-negative least squares, with fixed deflections at which they slip."""
    law = problem.experiment.law
    if law not in ("MaxwellSlip", "GMS", "Leuven", "DNLRX"):
        return {}
    group = group_of(law, problem.experiment.table) + "."
    number = int(problem.experiment.value(f"{group}N", values)) if law != "Leuven" else ELEMENTS
    ends = lengths(problem, number)
    stiffness, offset = springs(problem, ends, values)
    signal = problem.experiment.compared[0]
    found = {f"offset.{signal}": offset}
    # An element that the data do not need keeps a little stiffness, since a logarithm is free.
    least = 1e-4 * float(np.max(stiffness, initial=1.0))
    stiffness = np.maximum(stiffness, least)
    limits = stiffness * ends
    total = float(np.sum(limits))
    if law == "Leuven":
        found |= _leuven(group, ends, stiffness, total)
    # The shares of GMS belong to its level, where that is not free.
    is_free = any(free.name == f"{group}Fc" for free in problem.free)
    level = total if is_free or law != "GMS" else problem.experiment.value(f"{group}Fc", {})
    for index in range(number if law != "Leuven" else 0):
        found[f"{group}k[{index + 1}]"] = found[f"{group}chi0[{index + 1}]"] = float(stiffness[index])
        found[f"{group}W[{index + 1}]"] = float(limits[index])
        found[f"{group}limit[{index + 1}]"] = float(ends[index])
        found[f"{group}alpha[{index + 1}]"] = float(limits[index] / level)
    if law == "GMS":
        found |= {f"{group}Fc": level, f"{group}Fs": 1.02 * level}
    return found


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
    position = window.driven["position"]
    course = np.empty_like(position)
    deflected, last = 0.0, position[0]
    for index, place in enumerate(position):
        deflected = min(max(deflected + place - last, -end), end)
        course[index], last = deflected, place
    return np.interp(window.record.time, window.record.grid, course)


def _leuven(group: str, ends: Array, stiffness: Array, total: float) -> dict[str, float]:
    """Return presliding nearly as linear as under Maxwell elements, with an end about as sharp as their slip."""
    return {f"{group}k1": float(np.sum(stiffness)), f"{group}f1": 0.05 * total, f"{group}f2": 1.0 / float(ends[-1]),
            f"{group}Fs": 1.02 * total, f"{group}Fc": total, f"{group}n": 5.0}  # fmt: skip
