"""Generalised Maxwell slip and Maxwell slip."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass, replace

from .hybrid import Contact, Law, Regime, Stribeck, direction_of_motion


class MaxwellElements(ABC):
    """Parallel spring-slider elements whose forces are the internal states."""

    stiffness: tuple[float, ...]
    sigma2: float

    @abstractmethod
    def slip_rate(self, c: Contact, direction: int, element: int) -> float:
        """The rate of the force of a slipping element."""

    @abstractmethod
    def reserve(self, c: Contact, direction: int, element: int) -> float:
        """Remaining force of a stuck element before it slips."""

    def law(self) -> Law:
        stuck = (False,) * len(self.stiffness)
        return Law(
            lambda c: MaxwellSliding(self, direction_of_motion(c, 0.0), stuck),
            (1.0,) * len(self.stiffness),
        )


@dataclass(frozen=True)
class MaxwellSliding(Regime):
    """Motion in one direction with a given set of elements slipping."""

    friction: MaxwellElements
    direction: int
    slipping: tuple[bool, ...]

    def force(self, c: Contact) -> float:
        return sum(c.z) + self.friction.sigma2 * c.v

    def rates(self, c: Contact) -> Sequence[float]:
        return tuple(
            self.friction.slip_rate(c, self.direction, i) if slips else self.friction.stiffness[i] * c.v
            for i, slips in enumerate(self.slipping)
        )

    def margins(self, c: Contact) -> Sequence[float]:
        return tuple(self.friction.reserve(c, self.direction, i) for i in self._stuck())

    def expired(self, c: Contact, which: int) -> Regime:
        element = self._stuck()[which]
        slipping = (*self.slipping[:element], True, *self.slipping[element + 1 :])
        return replace(self, slipping=slipping)

    def at_rest(self, c: Contact) -> Regime:
        return replace(self, direction=-self.direction, slipping=(False,) * len(self.slipping))

    def _stuck(self) -> list[int]:
        return [i for i, slips in enumerate(self.slipping) if not slips]


@dataclass(frozen=True)
class GeneralisedMaxwellSlip(MaxwellElements):
    steady: Stribeck
    stiffness: tuple[float, ...]
    alpha: tuple[float, ...]
    attraction: float
    sigma2: float

    def slip_rate(self, c: Contact, direction: int, element: int) -> float:
        steady = c.level * self.steady(direction * c.v)
        return self.attraction * (self.alpha[element] * direction - c.z[element] / steady)

    def reserve(self, c: Contact, direction: int, element: int) -> float:
        steady = c.level * self.steady(direction * c.v)
        return self.alpha[element] * steady - abs(c.z[element])


@dataclass(frozen=True)
class MaxwellSlip(MaxwellElements):
    """Elements with constant limits; slipping ones would have to follow a varying level."""

    stiffness: tuple[float, ...]
    limits: tuple[float, ...]
    sigma2: float

    def slip_rate(self, c: Contact, direction: int, element: int) -> float:
        return 0.0

    def reserve(self, c: Contact, direction: int, element: int) -> float:
        if c.level != 1.0:
            raise ValueError("MaxwellSlip is not implemented for pressure-dependent friction")
        return self.limits[element] - direction * c.z[element]
