"""Stick-slip with an anchored spring, and with a bounded stiction displacement."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from .hybrid import Contact, Law, Regime, Undirected, clamp, sign
from .smooth import cubic_ramp


@dataclass(frozen=True)
class StickSlipSpring:
    fs: float
    fc: float
    stiffness: float
    damping: float
    sigma2: float

    def law(self) -> Law:
        return Law(lambda c: SpringStick(self, c.x))


@dataclass(frozen=True)
class SpringStick(Undirected):
    """The mass hangs on a spring-damper."""

    friction: StickSlipSpring
    anchor: float
    sticking = True

    def force(self, c: Contact) -> float:
        return self.friction.stiffness * (c.x - self.anchor) + self.friction.damping * c.v

    def margins(self, c: Contact) -> Sequence[float]:
        return (c.level * self.friction.fs - abs(self.force(c)),)

    def expired(self, c: Contact, which: int) -> Regime:
        return SpringSlip(self.friction, sign(c.v))


@dataclass(frozen=True)
class SpringSlip(Regime):
    """The mass slides."""

    friction: StickSlipSpring
    direction: int

    def force(self, c: Contact) -> float:
        return self.direction * c.level * self.friction.fc + self.friction.sigma2 * c.v

    def at_rest(self, c: Contact) -> Regime:
        return SpringStick(self.friction, c.x - self.force(c) / self.friction.stiffness)


@dataclass(frozen=True)
class StickSlipCreep:
    fs: float
    fc: float
    delta: float
    vs: float
    vd: float
    sigma1: float
    sigma2: float

    def law(self) -> Law:
        return Law(lambda c: CreepStraining(self), (1e-6,))

    def force(self, c: Contact, displacement_rate: float) -> float:
        stiction = c.level * self.fs * c.z[0] / self.delta + self.sigma1 * displacement_rate
        kinetic = c.level * math.copysign(self.fc, c.v)
        share = cubic_ramp(clamp((self.vd - abs(c.v)) / (self.vd - self.vs), 0.0, 1.0))
        return share * stiction + (1.0 - share) * kinetic + self.sigma2 * c.v


@dataclass(frozen=True)
class CreepStraining(Undirected):
    """The stiction displacement follows the motion."""

    friction: StickSlipCreep

    def force(self, c: Contact) -> float:
        return self.friction.force(c, c.v)

    def rates(self, c: Contact) -> Sequence[float]:
        return (c.v,)

    def margins(self, c: Contact) -> Sequence[float]:
        return (self.friction.delta - c.z[0], self.friction.delta + c.z[0])

    def expired(self, c: Contact, which: int) -> Regime:
        return CreepSaturated(self.friction, 1 if which == 0 else -1)


@dataclass(frozen=True)
class CreepSaturated(Regime):
    """The stiction displacement rests at its limit."""

    friction: StickSlipCreep
    direction: int

    def force(self, c: Contact) -> float:
        return self.friction.force(c, 0.0)

    def rates(self, c: Contact) -> Sequence[float]:
        return (0.0,)

    def at_rest(self, c: Contact) -> Regime:
        return CreepStraining(self.friction)
