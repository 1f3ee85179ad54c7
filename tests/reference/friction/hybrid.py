"""A friction law as regimes and their ends."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import NamedTuple


class Contact(NamedTuple):
    """State of the mass for a friction law at one instant."""

    x: float
    v: float
    z: Sequence[float]
    applied: float
    """The sum of all other forces on the mass."""
    level: float
    """The factor on the force-valued parameters of the law."""
    time: float


class Regime(ABC):
    """One smooth regime of a friction law."""

    direction: int
    """The sign of the velocity throughout the regime; 0 if the regime does not depend on it."""
    held: bool = False
    """Whether the mass stands still; its velocity state may differ from 0."""
    sticking: bool = False
    """Whether the model reports the mass as sticking."""

    @abstractmethod
    def force(self, c: Contact) -> float:
        """The friction force, positive against positive velocity."""

    def rates(self, c: Contact) -> Sequence[float]:
        """The derivatives of the internal states."""
        return ()

    def margins(self, c: Contact) -> Sequence[float]:
        """Quantities that are positive while the regime lasts, besides direction * v."""
        return ()

    def expired(self, c: Contact, which: int) -> Regime:
        """The successor when margin ``which`` has reached zero."""
        raise NotImplementedError

    def at_rest(self, c: Contact) -> Regime:
        """The successor when the velocity has reached zero."""
        raise NotImplementedError


class Undirected(Regime):
    """A regime in which the velocity may have either sign."""

    direction = 0


@dataclass(frozen=True)
class Law:
    """A friction law ready to run."""

    start: Callable[[Contact], Regime]
    """The initial regime, from the contact with all internal states zero."""
    units: tuple[float, ...] = ()
    """The natural size of each internal state."""


@dataclass(frozen=True)
class Stribeck:
    """The steady friction level as a function of speed."""

    fs: float
    fc: float
    vs: float
    delta: float

    def __call__(self, speed: float) -> float:
        # A trial stage of the integrator may lie just beyond a reversal.
        ratio: float = max(speed, 0.0) / self.vs
        return self.fc + (self.fs - self.fc) * math.exp(-(ratio**self.delta))


def direction_of_motion(c: Contact, force: float) -> int:
    """The sign of the velocity, or of the acceleration where the mass is at rest."""
    if c.v != 0.0:
        return sign(c.v)
    return sign(c.applied - force)


def sign(value: float) -> int:
    return 1 if value > 0.0 else -1


def clamp(value: float, low: float, high: float) -> float:
    return min(max(value, low), high)
