"""Karnopp."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from .hybrid import Contact, Law, Regime, Stribeck, Undirected, sign


@dataclass(frozen=True)
class Karnopp:
    """Friction with a band of velocities within which the mass stands still."""

    steady: Stribeck
    band: float
    sigma2: float

    def law(self) -> Law:
        return Law(self.choose)

    def choose(self, c: Contact) -> Regime:
        if abs(c.v) > self.band:
            return KarnoppSliding(self, sign(c.v))
        return self.inside(c)

    def inside(self, c: Contact) -> Regime:
        if abs(c.applied) <= c.level * self.steady.fs:
            return KarnoppStuck(self)
        push = sign(c.applied)
        if push * c.v >= self.band:
            return KarnoppSliding(self, push)
        return KarnoppLeaving(self, push)


@dataclass(frozen=True)
class KarnoppStuck(Undirected):
    """Within the band, balanced: the velocity state keeps its value."""

    friction: Karnopp
    held = True
    sticking = True

    def force(self, c: Contact) -> float:
        return c.applied

    def margins(self, c: Contact) -> Sequence[float]:
        return (c.level * self.friction.steady.fs - abs(c.applied),)

    def expired(self, c: Contact, which: int) -> Regime:
        push = sign(c.applied)
        if push * c.v >= self.friction.band:
            return KarnoppSliding(self.friction, push)
        return KarnoppLeaving(self.friction, push)


@dataclass(frozen=True)
class KarnoppLeaving(Undirected):
    """Within the band, the applied force exceeding break-away: the velocity state moves."""

    friction: Karnopp
    push: int
    held = True
    sticking = True

    def force(self, c: Contact) -> float:
        return self.push * c.level * self.friction.steady.fs

    def margins(self, c: Contact) -> Sequence[float]:
        return (
            self.push * c.applied - c.level * self.friction.steady.fs,
            self.friction.band - self.push * c.v,
        )

    def expired(self, c: Contact, which: int) -> Regime:
        if which == 0:
            return KarnoppStuck(self.friction)
        return KarnoppSliding(self.friction, self.push)


@dataclass(frozen=True)
class KarnoppSliding(Undirected):
    """Outside the band."""

    friction: Karnopp
    sense: int

    def force(self, c: Contact) -> float:
        sliding = self.friction.steady(self.sense * c.v)
        return self.sense * c.level * sliding + self.friction.sigma2 * c.v

    def margins(self, c: Contact) -> Sequence[float]:
        return (self.sense * c.v - self.friction.band,)

    def expired(self, c: Contact, which: int) -> Regime:
        return self.friction.inside(c)
