"""Tests of fixed settings, such as a supply given gauge for absolute, as explanations of the residuals of a fit.

For every setting of the machine that is neither free nor measured the residuals are asked how much less would be left
if it were free (a score test, as for sensors in `doubts`). Those that promise most, and every other thermal model, are
fitted along with all that is free: a pressure off by an atmosphere, or a bore by a quarter, is no small change.
"""

from __future__ import annotations

from collections.abc import Iterator
from copy import copy
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from pneumatic_servo import effects
from pneumatic_servo.identification.experiments import Experiment
from pneumatic_servo.identification.fitted import Estimate, Fitted
from pneumatic_servo.identification.intervals import certainty
from pneumatic_servo.identification.parameters import OF_LOAD, SPAN, Free, free_of, usual
from pneumatic_servo.identification.problem import Problem
from pneumatic_servo.identification.residuals import Residuals
from pneumatic_servo.identification.sensor import Sensor
from pneumatic_servo.identification.sensor_faults import MUCH, explains_nothing, most_explained, without
from pneumatic_servo.identification.solve import ROUGH, refine, sensitivities

Array = NDArray[np.float64]

GAS = (
    "supplyPressure", "cylinder.bore", "cylinder.rod", "chamberA.deadVolume", "chamberB.deadVolume", "valve.C",
    "valve.b", "valve.deadZone", "valve.leakage",
)  # fmt: skip
SETTINGS = {
    "rig": (*GAS, "mass.moving", "wireForce", "friction.direction.factor"),
    "pneumatic": GAS,
    "mechanical": ("cylinder.bore", "cylinder.rod", "mass.moving", "wireForce", "friction.direction.factor"),
    "force": ("mass", "friction.direction.factor"),
    "motion": ("friction.direction.factor",),
}
"""Settings that a machine may have otherwise than given."""
MODELS = ("EnergyBalance", "Isothermal", "Polytropic", "PolytropicServo")
"""Thermal models that are tried for each other."""
CLOCKED = ("rig", "pneumatic", "mechanical", "force")
"""Experiments in which more than friction depends on time."""
STEP, CLOCK, ROUNDS = 0.05, 0.01, 2
"""Tried change of a setting: a logarithm, or a share of its magnitude; of a clock; and the number of refinements."""
SURE, OFF = 10.0, 0.005
"""Half intervals, and share, by which a clock is off that is named although little more than noise is left."""
SAME = 0.95
"""Share of what a cause explains from which on another one explains as much."""
FITTED, PROMISING = 4, 0.05
"""Settings that are fitted along: all that promise to explain more than this share."""
ATMOSPHERE, NEAR = 101325.0, 0.2
"""Offset of a pressure in Pa, within this share of it, that counts from the atmosphere."""


@dataclass(frozen=True)
class Suspect:
    """A fixed setting that would explain what is left.

    Attributes
    ----------
    name : str
        Its name.
    given : float or str
        Its fixed value.
    estimate : Estimate or str
        Its estimate, with its interval; of a model its name.
    gain : float
        By how much the sum of squares falls, in units of the noise.
    signal : str
        The signal that is missed less with it.
    share : float
        Share of the sum of its squares that is gone.
    alike : tuple of str
        Other settings that would explain as much: with time the mass that goes with its square, for example.
    """

    name: str
    given: float | str
    estimate: Estimate | str
    gain: float
    signal: str
    share: float
    alike: tuple[str, ...] = ()

    def __str__(self) -> str:
        others = ", ".join(self.alike)
        return self._cause() + (f" As much would be gone with another {others}." if others else "")

    def _cause(self) -> str:
        gone = f"{100.0 * self.share:.0f} % of the squared residual of {self.signal} would be gone if {self.name}"
        if self.name == "time" and isinstance(self.estimate, Estimate):
            times = str(self.estimate).removesuffix(" 1")
            return f"{gone} were {times} times what was recorded: check the clock and the sample rate."
        if isinstance(self.estimate, str):
            return f"{gone} were {self.estimate} in place of {self.given}: is the setting right?"
        off = self.estimate.value - float(self.given)
        is_gauge = self.estimate.unit == "Pa" and abs(off - ATMOSPHERE) < NEAR * ATMOSPHERE
        unit = "" if self.estimate.unit == "1" else f" {self.estimate.unit}"
        hint = "was it given above ambient pressure? Pressures are absolute" if is_gauge else "check it, or free it"
        estimate = str(self.estimate).removesuffix(" 1")
        return f"{gone}, fixed at {self.given:.6g}{unit}, were {estimate}: {hint}."


def suspect(fit: Fitted, residuals: Residuals) -> Suspect | None:
    """Return the fixed setting that explains the most of what a fit leaves, if it is much."""
    is_quiet = explains_nothing(fit, residuals)
    if is_quiet and fit.problem.experiment.name not in CLOCKED:
        return None
    problem = fit.problem.trained()
    x = np.concatenate([fit.x, np.zeros(sum(problem.loose))])
    before = problem.residuals([x])[0]
    if not np.all(np.isfinite(before)):
        return None
    if is_quiet:
        # The conductance of a valve makes up for most of a wrong clock, and inertia shows the rest.
        return next((one for one in _clock(problem, x, before, OFF) if _is_sure(one)), None)
    found = [*_real(problem, x, before), *_models(problem, x, before), *_clock(problem, x, before)]
    best = max(found, key=lambda one: one.gain, default=None)
    if best is None or not best.share > MUCH:
        return None
    alike = tuple(one.name for one in found if one is not best and one.gain > SAME * best.gain)
    return replace(best, alike=alike)


def _real(problem: Problem, x: Array, before: Array) -> Iterator[Suspect]:
    """Yield the settings that are numbers, of those that promise most."""
    for free, given in _promising(problem, x):
        more = problem.with_free([*problem.free, free]).bounded()
        number = len(problem.free)
        end = _refined(more, np.concatenate([x[:number], [free.inner(free.start)], x[number:]]))
        sure = certainty(more, end)
        estimate = Estimate(
            free.outer(float(end[number])), float(sure.low[number]), float(sure.high[number]), free.unit
        )
        yield _judged(problem, free.name, given, estimate, before, more.residuals([end])[0])


def _models(problem: Problem, x: Array, before: Array) -> Iterator[Suspect]:
    """Yield the other thermal models."""
    experiment = problem.experiment
    if experiment.name not in ("rig", "pneumatic"):
        return
    given = str(experiment.settings.get("thermal.model", experiment.table.variables["thermal.model"].default))
    if any(free.name.startswith("thermal.") for free in problem.free) or given not in MODELS:
        return
    for model in MODELS:
        if model != given:
            other = copy(experiment)
            other.settings = {**experiment.settings, "thermal.model": model}
            changed = replace(problem, experiment=other).bounded()
            end = _refined(changed, x)
            yield _judged(problem, "thermal.model", given, model, before, changed.residuals([end])[0])


def _is_sure(clock: Suspect) -> bool:
    """Tell whether a clock is off by much more than its interval."""
    estimate = clock.estimate
    assert isinstance(estimate, Estimate)
    return abs(estimate.value - 1.0) > max(SURE * (estimate.high - estimate.value), OFF)


def _clock(problem: Problem, x: Array, before: Array, least: float = 0.0) -> Iterator[Suspect]:
    """Yield the time that fits best, if another one promises much and is off by at least a share."""
    if problem.experiment.name not in CLOCKED:
        return
    clock, half = 1.0, np.inf
    for number in range(ROUNDS):
        slopes, differences = sensitivities(problem, x)
        weights = problem.by_sensor(Sensor.weights, differences)
        columns = slopes * weights[:, None]
        basis = np.linalg.qr(columns / np.maximum(np.linalg.norm(columns, axis=0), 1e-300))[0]
        left = without(basis, differences * weights)
        run = replace(problem, clock=clock * (1.0 + CLOCK)).stacked([x])[0]
        own = without(basis, (run - differences) * weights)
        size = float(own @ own)
        if not (np.isfinite(size) and size > 0.0):
            return
        if number == 0 and float(own @ left) ** 2 < PROMISING * size * float(left @ left):
            return
        step = CLOCK * float(np.clip(-float(own @ left) / size, -20.0, 20.0))
        if number == 0 and abs(step) < least:
            return
        clock *= 1.0 + step
        problem = replace(problem, clock=clock).bounded()
        x = refine(problem, x, effort=ROUGH).x
        half = 1.96 * clock * CLOCK * float(np.sqrt(left @ left / len(left) / size))
    estimate = Estimate(clock, clock - half, clock + half, "1")
    yield _judged(problem, "time", 1.0, estimate, before, problem.residuals([x])[0])


def _refined(problem: Problem, x: Array) -> Array:
    """Return the better end of two searches: from where the wrong setting has led, and from the first start."""
    return min((refine(problem, start, effort=ROUGH) for start in (x, problem.start)), key=lambda end: end.cost).x


def _judged(
    problem: Problem, name: str, given: float | str, estimate: Estimate | str, before: Array, after: Array
) -> Suspect:
    signal, share = most_explained(problem, before, after)
    return Suspect(name, given, estimate, float(before @ before - after @ after), signal, share)


def _promising(problem: Problem, x: Array) -> list[tuple[Free, float]]:
    """Return the settings whose small changes explain most, with what they are fixed at."""
    slopes, differences = sensitivities(problem, x)
    weights = problem.by_sensor(Sensor.weights, differences)
    columns = slopes * weights[:, None]
    basis = np.linalg.qr(columns / np.maximum(np.linalg.norm(columns, axis=0), 1e-300))[0]
    left = without(basis, differences * weights)
    promises = []
    for name in _names(problem):
        experiment = problem.experiment
        given = experiment.beside_value(name, {}, 1.0) if name in OF_LOAD else experiment.value(name, {})
        free = _free(experiment, name, given)
        if free is None:
            continue
        changed = experiment.with_value(name, free.outer(free.inner(given) + STEP))
        run = replace(problem, experiment=changed).stacked([x])[0]
        own = without(basis, (run - differences) * weights)
        size = float(own @ own)
        if np.isfinite(size) and size > 0.0:
            promises.append(((float(own @ left) ** 2) / size, free, given))
    promises = [one for one in promises if one[0] > PROMISING * float(left @ left)]
    promises.sort(key=lambda one: -one[0])
    return [(free, given) for _, free, given in promises[:FITTED]]


def _free(experiment: Experiment, name: str, given: float) -> Free | None:
    """Return a setting as something free; None for one that is off, as a volume of 0."""
    if name in experiment.table.inputs:
        unit = experiment.table.variables[name].unit
        return Free(name, unit, given, given / SPAN, given * SPAN, 0.0) if given > 0.0 else None
    free = free_of(name, experiment.table, experiment.compared, experiment.beside, name)
    if free.is_logarithmic and not given > 0.0:
        return None
    return replace(free, unit=experiment.units.of(free.unit)).at(given)


def _names(problem: Problem) -> list[str]:
    experiment = problem.experiment
    table = experiment.table
    names = [*SETTINGS[experiment.name], *usual(experiment.law, table, experiment.settings)]
    known = {free.name for free in problem.free} | experiment.signals
    settings = {**experiment.settings, "friction.law": experiment.law}
    return [
        name
        for name in dict.fromkeys(names)
        if (name in table.variables or name in OF_LOAD) and name not in known
        and not effects.reason_for(table.variables, settings, name)
        and not (experiment.name == "pneumatic" and name.startswith("friction."))
    ]  # fmt: skip
