"""Set-valued laws: Coulomb, CoulombStiction, Stribeck, and Stribeck with a memory of its rest."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

from .hybrid import Contact, Law, Regime, Stribeck, Undirected, sign


@dataclass(frozen=True)
class DryFriction:
    """Friction with a break-away force and a sliding curve."""

    breakaway: float
    sliding: Callable[[float], float]
    sigma2: float

    def law(self) -> Law:
        return Law(lambda c: self.rest(c) if c.v == 0.0 else Sliding(self, sign(c.v)))

    def rest(self, c: Contact) -> Regime:
        """The regime of a mass that has just come to rest."""
        if abs(c.applied) <= c.level * self.breakaway:
            return Stuck(self.breakaway, lambda direction: Sliding(self, direction))
        return Sliding(self, sign(c.applied))


@dataclass(frozen=True)
class Stuck(Undirected):
    """The mass is held: friction equals the applied force, up to the break-away force."""

    breakaway: float
    slide: Callable[[int], Regime]
    held = True
    sticking = True

    def force(self, c: Contact) -> float:
        return c.applied

    def margins(self, c: Contact) -> Sequence[float]:
        return (c.level * self.breakaway - abs(c.applied),)

    def expired(self, c: Contact, which: int) -> Regime:
        return self.slide(sign(c.applied))


@dataclass(frozen=True)
class Sliding(Regime):
    """The mass slides along the sliding curve."""

    friction: DryFriction
    direction: int

    def force(self, c: Contact) -> float:
        sliding = self.friction.sliding(self.direction * c.v)
        return self.direction * c.level * sliding + self.friction.sigma2 * c.v

    def at_rest(self, c: Contact) -> Regime:
        return self.friction.rest(c)


@dataclass(frozen=True)
class Ageing:
    """Stribeck friction whose static part grows at rest, and with the load at a pace of its own."""

    steady: Stribeck
    rested: float
    gamma: float
    ratio: float
    sigma2: float

    def law(self) -> Law:
        return Law(lambda c: AgeingStuck(self, -math.inf) if c.v == 0.0 else AgeingSliding(self, sign(c.v)))

    def rest(self, c: Contact) -> Regime:
        """The regime of a mass that has just come to rest."""
        stuck = AgeingStuck(self, c.time)
        return stuck if stuck.margins(c)[0] >= 0.0 else AgeingSliding(self, sign(c.applied))

    def static_level(self, level: float) -> float:
        return max(0.0, 1.0 - self.ratio + self.ratio * level)


@dataclass(frozen=True)
class AgeingStuck(Undirected):
    """At rest since a time."""

    friction: Ageing
    since: float
    held = True
    sticking = True

    def force(self, c: Contact) -> float:
        return c.applied

    def margins(self, c: Contact) -> Sequence[float]:
        law, rest = self.friction, c.time - self.since
        grown = 1.0 if math.isinf(rest) else rest / (rest + law.gamma)
        rested = law.rested if law.rested > 0.0 else law.steady.fs
        force = (1.0 - grown) * law.steady.fs + grown * rested
        return (max(law.static_level(c.level) * force, c.level * law.steady.fc) - abs(c.applied),)

    def expired(self, c: Contact, which: int) -> Regime:
        return AgeingSliding(self.friction, sign(c.applied))


@dataclass(frozen=True)
class AgeingSliding(Regime):
    """The mass slides along a Stribeck curve between levels that grow apart."""

    friction: Ageing
    direction: int

    def force(self, c: Contact) -> float:
        law = self.friction
        static, coulomb = law.static_level(c.level) * law.steady.fs, c.level * law.steady.fc
        curve = replace(law.steady, fs=max(static, coulomb), fc=coulomb)
        return self.direction * curve(self.direction * c.v) + law.sigma2 * c.v

    def at_rest(self, c: Contact) -> Regime:
        return self.friction.rest(c)
