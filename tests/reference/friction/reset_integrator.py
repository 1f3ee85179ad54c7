"""The reset integrator."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from .hybrid import Contact, Law, Regime, Undirected


@dataclass(frozen=True)
class ResetIntegrator:
    sigma0: float
    sigma1: float
    sigma2: float
    z0: float
    a: float

    def law(self) -> Law:
        return Law(lambda c: ResetStraining(self), (1e-6,))


@dataclass(frozen=True)
class ResetStraining(Undirected):
    """The integrator follows the motion; the strain differs from it by what a varying limit made."""

    friction: ResetIntegrator
    offset: float = 0.0

    def force(self, c: Contact) -> float:
        f = self.friction
        return (1.0 + f.a) * f.sigma0 * self._strain(c) + (f.sigma1 + f.sigma2) * c.v

    def rates(self, c: Contact) -> Sequence[float]:
        return (c.v,)

    def margins(self, c: Contact) -> Sequence[float]:
        limit = c.level * self.friction.z0
        return (limit - self._strain(c), limit + self._strain(c))

    def expired(self, c: Contact, which: int) -> Regime:
        return ResetSliding(self.friction, 1 if which == 0 else -1)

    def _strain(self, c: Contact) -> float:
        return c.z[0] + self.offset


@dataclass(frozen=True)
class ResetSliding(Regime):
    """The strain is at its limit, and the integrator rests."""

    friction: ResetIntegrator
    direction: int

    def force(self, c: Contact) -> float:
        return self.friction.sigma0 * self._strain(c) + self.friction.sigma2 * c.v

    def rates(self, c: Contact) -> Sequence[float]:
        return (0.0,)

    def at_rest(self, c: Contact) -> Regime:
        return ResetStraining(self.friction, self._strain(c) - c.z[0])

    def _strain(self, c: Contact) -> float:
        return self.direction * c.level * self.friction.z0
