"""Residuals of a fit in each kind of motion, and tests of whether they look like noise there.

A test over all samples says little where a carriage rests for most of a record: what is missed at break-away drowns. So
each kind of motion is tested alone, by the portmanteau test of G. M. Ljung and G. E. P. Box ("On a measure of lack of
fit in time series models", Biometrika, 1978), over pairs of samples that both belong to it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.stats import chi2

from pneumatic_servo.identification.residuals import Residuals

Array = NDArray[np.float64]

FEWEST = 20
"""Samples, and pairs of samples, without which nothing is said of a regime."""
LAGS = 20
"""Lags in samples at which residuals are correlated."""
DOUBT = 1e-3
"""Probability below which noise is no explanation: five regimes of three signals are rarely doubted by chance."""
WEAK = 0.2
"""Autocorrelations below this are not worth a word, however sure many samples make them."""


@dataclass(frozen=True)
class Regime:
    """Residuals of a signal in one kind of motion.

    Attributes
    ----------
    name : str
        ``at rest``, ``at break-away``, ``at reversals``, ``in slow motion`` or ``in fast motion``.
    samples : int
        Number of its samples.
    rms : float
        RMS residual, in SI units.
    is_white : bool
        Whether it looks like noise.
    """

    name: str
    samples: int
    rms: float
    is_white: bool


def regimes(residuals: Residuals, signal: str) -> tuple[Regime, ...]:
    """Return the residual of a signal in each kind of motion with enough samples."""
    step = residuals.problem.sensors[signal].step
    found = []
    for name, masks in residuals.kinds.items():
        courses = [
            np.where(inside, course.difference, np.nan)
            for course, inside in zip(residuals.courses(signal), masks, strict=True)
        ]
        rest = np.concatenate(courses)
        rest = rest[np.isfinite(rest)]
        if len(rest) < FEWEST:
            continue
        rms = float(np.sqrt(np.mean(rest**2)))
        # A converter rounds a nearly constant signal always to the same side, which is no fault of the law.
        found.append(Regime(name, len(rest), rms, rms <= 0.5 * step or is_white(courses)))
    return tuple(found)


def is_white(courses: list[Array]) -> bool:
    """Tell whether courses look like noise about 0; NaN values are omitted, with all their pairs."""
    every = np.concatenate(courses)
    power = float(np.nanmean(every**2))
    if power == 0.0:
        return True
    # A gap as long as the largest distance keeps courses apart.
    apart = np.full(LAGS, np.nan)
    whole = np.concatenate([part for course in courses for part in (course, apart)])
    correlations, pairs = [], []
    for lag in range(1, LAGS + 1):
        products = whole[lag:] * whole[:-lag]
        products = products[np.isfinite(products)]
        if len(products) >= FEWEST:
            correlations.append(float(np.mean(products)) / power)
            pairs.append(len(products))
    if not pairs or np.max(np.abs(correlations)) < WEAK:
        return True
    return bool(chi2.sf(np.sum(np.array(pairs) * np.array(correlations) ** 2), len(pairs)) >= DOUBT)
