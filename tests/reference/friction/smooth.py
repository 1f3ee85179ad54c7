"""Friction that is a function of velocity alone."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

from scipy.optimize import brentq  # type: ignore[import-untyped]

from .hybrid import Contact, Law, Stribeck, Undirected, clamp


@dataclass(frozen=True)
class Smooth(Undirected):
    """Friction that is a function of velocity alone."""

    law: Callable[[float, float], float]
    """The force at a velocity and a friction level."""

    def force(self, c: Contact) -> float:
        return self.law(c.v, c.level)


def smooth(law: Callable[[float, float], float]) -> Law:
    return Law(lambda c: Smooth(law))


def none() -> Law:
    return smooth(lambda v, level: 0.0)


def smooth_coulomb(fc: float, vd: float, sigma2: float) -> Law:
    return smooth(lambda v, level: level * fc * math.tanh(v / vd) + sigma2 * v)


def velocity_based(fs: float, fc: float, vs: float, e: float, sigma2: float) -> Law:
    shape = 2.0 - (2.0 / math.pi) * math.asin(fc / fs)
    peak = math.tan(math.pi / (2.0 * shape))
    argument = brentq(lambda q: q - e * (q - math.atan(q)) - peak, 0.0, 1e6, xtol=1e-15)
    stiffness = argument / vs

    def law(v: float, level: float) -> float:
        q = stiffness * v
        angle = shape * math.atan(q - e * (q - math.atan(q)))
        return level * fs * math.sin(angle) + sigma2 * v

    return smooth(law)


def stribeck_regularised(steady: Stribeck, eps: float, sigma2: float) -> Law:
    def law(v: float, level: float) -> float:
        return level * steady(abs(v)) * clamp(v / eps, -1.0, 1.0) + sigma2 * v

    return smooth(law)


def transition_regularised(
    ramp: Callable[[float], float], fs: float, fc: float, vs: float, vd: float, sigma2: float
) -> Law:
    """Friction that climbs to Fs up to ``vs`` and falls to Fc up to ``vd`` along ``ramp``."""

    def law(v: float, level: float) -> float:
        speed = abs(v)
        if speed <= vs:
            size = fs * ramp(speed / vs)
        else:
            beyond = min((speed - vs) / (vd - vs), 1.0)
            size = fs + (fc - fs) * ramp(beyond)
        return level * math.copysign(size, v) + sigma2 * v

    return smooth(law)


def cubic_ramp(q: float) -> float:
    return q * q * (3.0 - 2.0 * q)


def sine_ramp(q: float) -> float:
    return 0.5 * (1.0 - math.cos(math.pi * q))
