"""The verdict on a fit: a paragraph and a traffic light."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pneumatic_servo import _native
from pneumatic_servo.identification.causes import Cause
from pneumatic_servo.identification.fitted import Fitted
from pneumatic_servo.identification.free_form import FreeForm
from pneumatic_servo.identification.ranges import Ranges, held_of
from pneumatic_servo.identification.regimes import Regime, regimes
from pneumatic_servo.identification.residuals import Residuals

Array = NDArray[np.float64]

HEADS = dict(_native.lights())
"""Lights and their meaning, the worst last."""
LIGHTS = tuple(HEADS)
WORSE = 1.5
"""Ratio of a regime's RMS residual to the overall one from which it is named."""
MUCH = 0.3
"""Share of what a law leaves of friction that a better one of the same variables would not."""
LARGE = 9.0
"""Size of a single residual, in units of its noise, that is named with its time."""


@dataclass(frozen=True)
class Finding:
    """Something that a fit is to be judged by: its light, and a sentence."""

    light: str
    text: str


@dataclass(frozen=True)
class Verdict:
    """Verdict on a fit.

    Attributes
    ----------
    findings : tuple of Finding
        Reasons of the verdict, the worst first.
    """

    findings: tuple[Finding, ...]

    @property
    def light(self) -> str:
        """The worst of the findings: ``green``, ``yellow`` or ``red``."""
        return max((finding.light for finding in self.findings), key=LIGHTS.index, default="green")

    @property
    def text(self) -> str:
        """All findings in one paragraph."""
        return " ".join([f"{HEADS[self.light]}.", *(finding.text for finding in self.findings)])

    def __str__(self) -> str:
        return f"{self.light}: {self.text}"


def verdict(
    fit: Fitted, residuals: Residuals, ranges: Ranges, free_form: FreeForm | None, causes: Sequence[Cause]
) -> Verdict:
    """Judge a fit by what it leaves, where, how it predicts, and what the data tell."""
    found = [*_of_search(fit), *_of_misfit(fit, residuals), *_of_prediction(fit, ranges), *_of_conditions(fit),
             *_of_free_form(fit, free_form), *(Finding("yellow", cause.text) for cause in causes)]  # fmt: skip
    return Verdict(tuple(sorted(found, key=lambda finding: -LIGHTS.index(finding.light))))


def _of_search(fit: Fitted) -> Iterator[Finding]:
    if not fit.converged:
        yield Finding("red", f"The search did not converge ({fit.message}).")
    bounded = dict(fit.problem.native.at_bounds(fit.x))
    untold = ", ".join(name for name in fit.not_identifiable if name not in bounded)
    if untold:
        yield Finding("yellow", f"{untold}: not identifiable from these data. Fix it, or measure what determines it.")
    for name, bound in bounded.items():
        estimate = fit.parameters[name]
        yield Finding(
            "yellow", f"{name} has run to its bound, {bound:.6g} {estimate.unit}: the data draw it beyond. Widen the "
            "bound, or ask what else it stands for."
        )  # fmt: skip


def _of_misfit(fit: Fitted, residuals: Residuals) -> Iterator[Finding]:
    for signal, rms in fit.rms.items():
        unit = fit.units.of_signal(signal)
        measured = np.concatenate([course.measured for course in residuals.courses(signal)])
        spread, noise = float(np.std(measured)), residuals.noise(signal)
        own = regimes(residuals, signal)
        residual = f"RMS residual of {signal}: {rms:.3g} {unit}"
        where = _worst(own, float(np.sqrt(np.mean(residuals.all(signal) ** 2))))
        tied = _listed([one.name for one in own if not one.is_white])
        light = _native.residual_light(rms, spread, noise)
        if light == "red":
            yield Finding(
                "red",
                f"{residual}, and the signal varies by {spread:.3g} {unit}{where}: look at signs, units and what was "
                "assumed.",
            )
        elif light == "yellow":
            yield Finding(
                "yellow",
                f"{residual}, {rms / noise:.2g} times the noise of its sensor{where}: the law, or a fixed parameter, "
                "misses something.",
            )
        elif loud := [f"{one.name} ({one.rms:.3g})" for one in own if _is_loud(one, noise)]:
            yield Finding(
                "yellow",
                f"{residual}, about the noise of its sensor, but more {_listed(loud)}: there the law misses something.",
            )
        elif tied or not residuals.is_white(signal):
            when = f" {tied}" if tied else where
            yield Finding("green", f"{residual}, about the noise of its sensor, but autocorrelated{when}.")
        else:
            yield Finding("green", f"{residual}, looks like noise.")
    yield from _worst_place(residuals)


def _is_loud(regime: Regime, noise: float) -> bool:
    """Tell whether the law misses something in a kind of motion."""
    return not regime.is_white and _native.residual_light(regime.rms, np.inf, noise) != "green"


def _worst_place(residuals: Residuals) -> Iterator[Finding]:
    """Say where a misfit is that noise cannot be."""
    worst = residuals.worst()
    if worst is not None and worst.size > LARGE:
        record = residuals.windows[worst.window].record
        if residuals.problem.experiment.is_steady:
            speed = f"{record.signals['velocity'][worst.sample]:.4g} {residuals.unit('velocity')}"
            yield Finding("green", f"The residual of {worst.signal} is largest at {speed} of {record.name}.")
            return
        time = record.begin + record.time[worst.sample]
        yield Finding("green", f"The residual of {worst.signal} is largest at {time:.4g} s of {record.name}.")


def _of_prediction(fit: Fitted, ranges: Ranges) -> Iterator[Finding]:
    if not fit.validation_rms:
        yield Finding("green", "There are no validation data, so that no prediction was tested.")
    for signal, rms in fit.validation_rms.items():
        ratio = rms / max(fit.rms[signal], 1e-300)
        light = _native.prediction_light(ratio)
        unit = fit.units.of_signal(signal)
        yield Finding(
            light,
            f"RMS residual of the validation data of {signal}: {rms:.3g} {unit}, {ratio:.2g} times the residual of the "
            "fitted data.",
        )
    for text in ranges.beyond(held_of(fit.problem, fit.x)).values():
        yield Finding("yellow", f"What was predicted is an extrapolation: {text}.")


def _of_conditions(fit: Fitted) -> Iterator[Finding]:
    if fit.cross_validation is None:
        return
    cases = fit.cross_validation.cases
    for case in cases:
        name, told = case.condition.name, case.friction
        if not case.holds:
            friction = "" if told is None else "friction is "
            yield Finding("red", f"The law does not hold at {name}: from the others {friction}{case.said(fit.units)}.")
        elif told is not None and told.is_wide:
            yield Finding(
                "yellow", f"The others hardly tell {name}: friction there is predicted as {told.low:.3g} to "
                f"{told.high:.3g} {fit.units.of('N')}."
            )  # fmt: skip
    spreads = [case.friction.spread for case in cases if case.friction is not None]
    spreads = [spread for spread in spreads if np.isfinite(spread)]
    apart = f"; between them friction differs from the law by {100.0 * np.median(spreads):.2g} %" if spreads else ""
    yield Finding(
        "green", f"Left out one after the other, {fit.cross_validation.holds} of {len(cases)} conditions are predicted "
        f"as well as that is told{apart}."
    )  # fmt: skip


def _of_free_form(fit: Fitted, found: FreeForm | None) -> Iterator[Finding]:
    """Say what any law could still gain; where friction is measured, much of it is a fault of this one."""
    if found is not None:
        is_much = fit.problem.experiment.name == "motion" and found.gain(found.family) > MUCH
        yield Finding("yellow" if is_much else "green", str(found))


def _worst(regimes: Sequence[Regime], whole: float) -> str:
    """Name the kind of motion in which most is missed, if one stands out."""
    worst = max(regimes, key=lambda one: one.rms, default=None)
    if worst is None or not worst.rms > WORSE * whole:
        return ""
    return f", most of it {worst.name} ({worst.rms:.3g})"


def _listed(names: Sequence[str]) -> str:
    return " and ".join([", ".join(names[:-1]), names[-1]] if len(names) > 1 else names)
