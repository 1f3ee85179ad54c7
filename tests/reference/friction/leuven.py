"""The modified Leuven model."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

from .hybrid import Contact, Law, Regime, Stribeck, direction_of_motion, sign


class TurningPoint(NamedTuple):
    z: float
    force: float


@dataclass(frozen=True)
class Leuven:
    steady: Stribeck
    n: float
    k1: float
    f1: float
    f2: float
    sigma1: float
    sigma2: float

    REVERSAL_THRESHOLD = 1e-10
    """The relative overshoot of the hysteresis force that counts as a reversal of z.

    In steady sliding z is at rest up to rounding, which must not be taken for reversals.
    """

    def law(self) -> Law:
        return Law(self._start, (1e-6,))

    def virgin(self, z: float, level: float) -> float:
        size = abs(z)
        return math.copysign(self.k1 * size - level * self.f1 * math.expm1(-self.f2 * size), z)

    def yielding(self, force: float, v: float, level: float, direction: int) -> float:
        """The share of the motion that the internal state still follows."""
        q = direction * force / (level * self.steady(direction * v))
        return 1.0 - math.copysign(abs(q) ** self.n, q)

    def _start(self, c: Contact) -> Regime:
        direction = direction_of_motion(c, 0.0)
        return LeuvenSliding(self, direction, direction, ())


@dataclass(frozen=True)
class LeuvenSliding(Regime):
    """Motion in one direction along one branch of the hysteresis force."""

    friction: Leuven
    direction: int
    strain_direction: int
    turning_points: tuple[TurningPoint, ...]

    def force(self, c: Contact) -> float:
        f = self.friction
        return self.hysteresis(c) + f.sigma1 * self.rates(c)[0] + f.sigma2 * c.v

    def rates(self, c: Contact) -> Sequence[float]:
        yielding = self.friction.yielding(self.hysteresis(c), c.v, c.level, self.direction)
        return (c.v * yielding,)

    def margins(self, c: Contact) -> Sequence[float]:
        f = self.friction
        yielding = f.yielding(self.hysteresis(c), c.v, c.level, self.direction)
        onward = self.strain_direction * self.direction * yielding + f.REVERSAL_THRESHOLD
        if not self.turning_points:
            return (onward,)
        return onward, self.strain_direction * (self._loop_closure() - c.z[0])

    def expired(self, c: Contact, which: int) -> Regime:
        if which == 0:
            return replace(
                self,
                strain_direction=-self.strain_direction,
                turning_points=self._turned(c),
            )
        return replace(self, turning_points=self.turning_points[:-2])

    def at_rest(self, c: Contact) -> Regime:
        direction = -self.direction
        yielding = self.friction.yielding(self.hysteresis(c), 0.0, c.level, direction)
        strain_direction = direction * sign(yielding)
        turned = strain_direction != self.strain_direction
        return LeuvenSliding(
            self.friction,
            direction,
            strain_direction,
            self._turned(c) if turned else self.turning_points,
        )

    def hysteresis(self, c: Contact) -> float:
        z = c.z[0]
        if not self.turning_points:
            return self.friction.virgin(z, c.level)
        turn = self.turning_points[-1]
        return turn.force + 2.0 * self.friction.virgin(0.5 * (z - turn.z), c.level)

    def _turned(self, c: Contact) -> tuple[TurningPoint, ...]:
        return (*self.turning_points, TurningPoint(c.z[0], self.hysteresis(c)))

    def _loop_closure(self) -> float:
        """Point at which the current branch meets the one before: its start or the virgin curve."""
        if len(self.turning_points) > 1:
            return self.turning_points[-2].z
        return -self.turning_points[0].z
