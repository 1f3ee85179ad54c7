"""Causes of residuals: fixed settings, choices, a clock and sensors that would explain what a fit leaves.

A supply given gauge for absolute, a voltage that is recorded late, a pressure behind the filter of a recorder: each has
its own effect on the residuals. The crate `fit` tests them; the page does the same. Here is what may be a cause of the
residuals of an experiment, and how its simulation changes.
"""

from __future__ import annotations

from copy import copy
from dataclasses import dataclass, replace

import numpy as np

from pneumatic_servo import _native, effects
from pneumatic_servo.identification.experiments import Experiment
from pneumatic_servo.identification.fitted import Estimate, Fitted
from pneumatic_servo.identification.parameters import DAMPING_SPEED, OF_LOAD, SPAN, Free, free_of, usual
from pneumatic_servo.identification.problem import Problem
from pneumatic_servo.identification.residuals import Residuals
from pneumatic_servo.identification.solve import native

MODEL = "thermal.model"


@dataclass(frozen=True)
class Cause:
    """A fixed setting, a choice, a clock or a sensor that would explain the residuals.

    Attributes
    ----------
    name : str
        Name of the setting or of the property of a sensor; ``time`` of a clock.
    given : float or str
        Its fixed value.
    estimate : Estimate or str
        Its estimate, with its interval; of a choice, as of a thermal model, the item.
    signal : str
        The signal of whose squared residual it explains most.
    share : float
        Share of this squared residual that would be gone.
    gain : float
        By how much the sum of squares would fall, in units of the noise.
    alike : tuple of str
        Other settings that would explain as much: with time the mass that goes with its square, for example.
    is_sensor : bool
        Whether it is a fault of a sensor.
    text : str
        All this in a sentence.
    """

    name: str
    given: float | str
    estimate: Estimate | str
    signal: str
    share: float
    gain: float
    alike: tuple[str, ...]
    is_sensor: bool
    text: str

    def __str__(self) -> str:
        return self.text


def causes(fit: Fitted, residuals: Residuals) -> tuple[Cause, ...]:
    """Return at most one setting and one sensor that explain much of what a fit leaves, the best first."""
    experiment = fit.problem.experiment
    names, has_clock = _native.suspected(experiment.name)
    is_noise = _native.is_quiet([(rms, residuals.noise(signal)) for signal, rms in fit.rms.items()])
    if is_noise and not has_clock:
        return ()
    problem = fit.problem.trained().bounded()
    # Start values of windows are the fitted ones.
    x = np.concatenate([fit.x, np.zeros(sum(problem.loose))])
    settings = {free.name: free for name in _settings(problem, names) if (free := _freed(experiment, name)) is not None}
    sensors = {name: free_of(name, experiment.table, experiment.compared, experiment.beside, name)
               for name in _sensors(problem)}  # fmt: skip
    choices = _choices(problem)

    def changed(kind: str, name: str, item: str, clock: float) -> _native.LeastSquares:
        if kind == "clock":
            return native(replace(problem, clock=clock))
        if kind == "chosen":
            other = copy(experiment)
            other.settings = {**experiment.settings, name: item if name == MODEL else float(item)}
            return native(replace(problem, experiment=other))
        return native(problem.with_free([*problem.free, settings.get(name) or sensors[name]]))

    found = native(problem).causes(
        x, experiment.compared, [free.numbers for free in settings.values()],
        [free.numbers for free in sensors.values()], choices, has_clock, is_noise, changed,
    )  # fmt: skip
    fixed = {name: item for name, item, _ in choices}
    every = {**settings, **sensors}
    causes = []
    for name, text, interval, item, signal, share, gain, alike, is_sensor in found:
        given: float | str = every[name].start if name in every else 1.0
        estimate: Estimate | str
        if interval is None:
            given, estimate = fixed[name], str(item)
        else:
            estimate = Estimate(*interval, every[name].unit if name in every else "1")
        causes.append(Cause(name, given, estimate, signal, share, gain, tuple(alike), is_sensor, f"{text}."))
    return tuple(causes)


def _choices(problem: Problem) -> list[tuple[str, str, list[str]]]:
    """Return choices that are fixed: name, item, and the other items."""
    experiment = problem.experiment
    variables, settings = experiment.table.variables, experiment.settings
    free = [free.name for free in problem.free]
    found = []
    if experiment.name in ("rig", "pneumatic") and not any(name.startswith("thermal.") for name in free):
        model = str(settings.get(MODEL, variables[MODEL].default))
        found.append((MODEL, model, [item for item in variables[MODEL].items if item != model]))
    if experiment.law == "LuGre" and experiment.name != "pneumatic" and DAMPING_SPEED not in free:
        speed = experiment.value(DAMPING_SPEED, {})
        other = variables[DAMPING_SPEED].default if speed == 0.0 else 0.0
        found.append((DAMPING_SPEED, f"{speed:g}", [f"{other:g}"]))
    return found


def _freed(experiment: Experiment, name: str) -> Free | None:
    """Return a setting as something free that starts at its fixed value; None for one that is off, as a volume of 0."""
    given = experiment.beside_value(name, {}, 1.0) if name in OF_LOAD else experiment.value(name, {})
    if name in experiment.table.inputs:
        unit = experiment.table.variables[name].unit
        return Free(name, unit, given, given / SPAN, given * SPAN, 0.0) if given > 0.0 else None
    free = free_of(name, experiment.table, experiment.compared, experiment.beside, name)
    if free.is_logarithmic and not given > 0.0:
        return None
    return replace(free, unit=experiment.units.of(free.unit)).at(given)


def _settings(problem: Problem, names: list[str]) -> list[str]:
    """Return the settings of the machine and its law that are fixed and have an effect."""
    experiment = problem.experiment
    table = experiment.table
    law = [] if experiment.name == "pneumatic" else usual(experiment.law, table, experiment.settings)
    known = {free.name for free in problem.free} | experiment.signals
    settings = {**experiment.settings, "friction.law": experiment.law}
    return [
        name
        for name in dict.fromkeys([*names, *law])
        if (name in table.variables or name in OF_LOAD) and name not in known
        and not effects.reason_for(table.variables, settings, name)
    ]  # fmt: skip


def _sensors(problem: Problem) -> list[str]:
    """Return the gains, offsets, delays and lags that are neither free nor given."""
    known = {*problem.experiment.settings, *(free.name for free in problem.free)}
    return [name for name in problem.experiment.beside if "." in name and name not in known]
