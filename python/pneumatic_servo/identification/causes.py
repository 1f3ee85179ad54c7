"""Causes of residuals: fixed settings, choices, a clock and sensors that would explain what a fit leaves.

A supply given gauge for absolute, a voltage that is recorded late, a pressure behind the filter of a recorder: each has
its own effect on the residuals. The crate `fit` tests them; the page does the same. Here is what may be a cause of the
residuals of an experiment, and how its simulation changes.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from pneumatic_servo import _native
from pneumatic_servo.identification.fitted import Estimate, Fitted
from pneumatic_servo.identification.parameters import Free, free_of
from pneumatic_servo.identification.residuals import Residuals


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
    is_noise = _native.is_quiet([(rms, residuals.noise(signal)) for signal, rms in fit.rms.items()])
    own, names, choices, has_clock = fit.problem.suspects()
    fixed = {name: item for name, item, _ in choices}
    if fit.problem.other_form is not None:
        return (_told(fit.problem.other_form, {}, fixed),)
    if is_noise and not has_clock:
        return ()
    problem = fit.problem.trained().bounded()
    # Start values of windows are the fitted ones.
    x = np.concatenate([fit.x, np.zeros(sum(problem.loose))])
    settings = {numbers[0]: Free.of(numbers, experiment.units.of(numbers[1])) for numbers in own}
    sensors = {name: free_of(name, experiment, name) for name in names}

    found = problem.native.causes(
        x, [free.numbers for free in settings.values()], [free.numbers for free in sensors.values()], choices,
        has_clock, is_noise,
    )  # fmt: skip
    every = {**settings, **sensors}
    return tuple(_told(cause, every, fixed) for cause in found)


def _told(cause: _native.Told, free: Mapping[str, Free], fixed: Mapping[str, str]) -> Cause:
    """Return a cause that the crate tells, of free parameters that start at their fixed values, or of fixed items."""
    name, text, interval, item, signal, share, gain, alike, is_sensor = cause
    given: float | str = free[name].start if name in free else 1.0
    estimate: Estimate | str
    if interval is None:
        given, estimate = fixed[name], str(item)
    else:
        estimate = Estimate(*interval, free[name].unit if name in free else "1")
    return Cause(name, given, estimate, signal, share, gain, tuple(alike), is_sensor, f"{text}.")
