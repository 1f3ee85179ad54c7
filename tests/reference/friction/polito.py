"""Polito."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from .dry import Stuck
from .hybrid import Contact, Law, Regime, Stribeck, sign


@dataclass(frozen=True)
class Polito:
    """Set-valued friction with one sliding curve for rising and one for falling speed."""

    fs: float
    fc1: float
    fc2: float
    vs: float
    c1: float
    c2: float
    delta: float

    def law(self) -> Law:
        return Law(lambda c: self.rest(c) if c.v == 0.0 else PolitoAccelerating(self, sign(c.v)))

    def rest(self, c: Contact) -> Regime:
        if abs(c.applied) <= c.level * self.fs:
            return Stuck(self.fs, lambda direction: PolitoAccelerating(self, direction))
        return PolitoAccelerating(self, sign(c.applied))

    def accelerating(self, speed: float, level: float) -> float:
        return level * Stribeck(self.fs, self.fc1, self.vs, self.delta)(speed) + self.c1 * speed

    def decelerating(self, speed: float, level: float) -> float:
        return level * self.fc2 + self.c2 * speed


@dataclass(frozen=True)
class PolitoSliding(Regime):
    """Sliding on one of the curves or between them."""

    friction: Polito
    direction: int

    def at_rest(self, c: Contact) -> Regime:
        return self.friction.rest(c)

    def upper(self, c: Contact) -> float:
        return self.friction.accelerating(self.direction * c.v, c.level)

    def lower(self, c: Contact) -> float:
        return self.friction.decelerating(self.direction * c.v, c.level)

    def drive(self, c: Contact) -> float:
        return self.direction * c.applied


class PolitoAccelerating(PolitoSliding):
    """On the curve of rising speed."""

    def force(self, c: Contact) -> float:
        return self.direction * self.upper(c)

    def margins(self, c: Contact) -> Sequence[float]:
        return (self.drive(c) - self.upper(c),)

    def expired(self, c: Contact, which: int) -> Regime:
        if self.lower(c) <= self.upper(c):
            return PolitoCruising(self.friction, self.direction)
        return PolitoDecelerating(self.friction, self.direction)


class PolitoDecelerating(PolitoSliding):
    """On the curve of falling speed."""

    def force(self, c: Contact) -> float:
        return self.direction * self.lower(c)

    def margins(self, c: Contact) -> Sequence[float]:
        return (self.lower(c) - self.drive(c),)

    def expired(self, c: Contact, which: int) -> Regime:
        if self.lower(c) <= self.upper(c):
            return PolitoCruising(self.friction, self.direction)
        return PolitoAccelerating(self.friction, self.direction)


class PolitoCruising(PolitoSliding):
    """Between the curves: friction balances the applied force and the speed is constant."""

    def force(self, c: Contact) -> float:
        return c.applied

    def margins(self, c: Contact) -> Sequence[float]:
        return (self.upper(c) - self.drive(c), self.drive(c) - self.lower(c))

    def expired(self, c: Contact, which: int) -> Regime:
        if which == 0:
            return PolitoAccelerating(self.friction, self.direction)
        return PolitoDecelerating(self.friction, self.direction)
