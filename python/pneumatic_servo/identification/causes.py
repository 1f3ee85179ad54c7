"""Causes of residuals: fixed settings, choices, a clock and sensors that would explain what a fit leaves.

A supply given gauge for absolute, a voltage that is recorded late, a pressure behind the filter of a recorder: each has
its own effect on the residuals. The crate `fit` tests them; the page does the same.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pneumatic_servo import _native
from pneumatic_servo.identification.fitted import Estimate, Fitted
from pneumatic_servo.identification.residuals import Residuals
from pneumatic_servo.identification.signals import ROTATING


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
    if fit.problem.other_form is not None:
        return (_told(fit.problem.other_form),)
    experiment = fit.problem.experiment
    beside = [(rms, residuals.noise(signal)) for signal, rms in fit.rms.items()]
    trained = fit.problem.trained()
    # Start values of windows are the fitted ones.
    x = np.concatenate([fit.x, np.zeros(sum(trained.loose))])
    units = {**(ROTATING if experiment.units.is_rotating else {}), **experiment.beside}
    return tuple(_told(cause) for cause in trained.native.causes(x, units, beside))


def _told(cause: _native.Told) -> Cause:
    """Return a cause that the crate tells."""
    name, text, fixed, estimate, signal, share, gain, alike, is_sensor = cause
    found = estimate if isinstance(estimate, str) else Estimate(*estimate)
    return Cause(name, fixed, found, signal, share, gain, tuple(alike), is_sensor, f"{text}.")
