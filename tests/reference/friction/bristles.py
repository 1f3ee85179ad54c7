"""Bristle laws whose equations depend on the sign of the velocity and nothing else."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass

from .hybrid import Contact, Law, Regime, Stribeck, direction_of_motion


class BristleLaw(ABC):
    """Friction with internal states, smooth in each direction of motion."""

    units: tuple[float, ...]

    @abstractmethod
    def rates(self, c: Contact, direction: int) -> Sequence[float]:
        """The derivatives of the internal states."""

    @abstractmethod
    def force(self, c: Contact, direction: int) -> float:
        """The friction force."""

    def law(self) -> Law:
        return Law(lambda c: BristleSliding(self, direction_of_motion(c, self.force(c, 1))), self.units)


@dataclass(frozen=True)
class BristleSliding(Regime):
    """Motion in one direction under a bristle law."""

    friction: BristleLaw
    direction: int

    def force(self, c: Contact) -> float:
        return self.friction.force(c, self.direction)

    def rates(self, c: Contact) -> Sequence[float]:
        return self.friction.rates(c, self.direction)

    def at_rest(self, c: Contact) -> Regime:
        return BristleSliding(self.friction, -self.direction)


@dataclass(frozen=True)
class Dahl(BristleLaw):
    fc: float
    sigma0: float
    n: float
    sigma2: float
    units = (1e-6,)

    def rates(self, c: Contact, direction: int) -> Sequence[float]:
        gap = 1.0 - direction * self.sigma0 * c.z[0] / (c.level * self.fc)
        return (c.v * math.copysign(abs(gap) ** self.n, gap),)

    def force(self, c: Contact, direction: int) -> float:
        return self.sigma0 * c.z[0] + self.sigma2 * c.v


@dataclass(frozen=True)
class LuGre(BristleLaw):
    steady: Stribeck
    sigma0: float
    sigma1: float
    sigma2: float
    vd: float
    units = (1e-6,)

    def rates(self, c: Contact, direction: int) -> Sequence[float]:
        speed = direction * c.v
        return (c.v - self.sigma0 * speed * c.z[0] / (c.level * self.steady(speed)),)

    def force(self, c: Contact, direction: int) -> float:
        damping = self.sigma1 * math.exp(-((c.v / self.vd) ** 2))
        (dz,) = self.rates(c, direction)
        return self.sigma0 * c.z[0] + damping * dz + self.sigma2 * c.v


@dataclass(frozen=True)
class RevisedLuGre(BristleLaw):
    """LuGre on a lubricant film: deflection z[0] and film thickness z[1]."""

    fs: float
    fc: float
    vs: float
    delta: float
    sigma0: float
    sigma1: float
    sigma2: float
    vb: float
    growth: float
    decline: float
    dwell: float
    rest: float
    vd: float
    units = (1e-6, 0.1)

    def rates(self, c: Contact, direction: int) -> Sequence[float]:
        speed = max(direction * c.v, 0.0)
        z, h = c.z
        stribeck = math.exp(-((speed / self.vs) ** self.delta))
        level = c.level * (self.fc * (1.0 - stribeck) + (1.0 - h) * self.fs * stribeck)
        full = 1.0 - self.fc / self.fs
        moving = 1.0 - math.exp(-((speed / self.rest) ** 2))
        missing = full * moving * min(1.0, speed / self.vb) ** (2.0 / 3.0) - h
        squeezing = (1.0 - moving) / self.dwell + moving / self.decline
        film_rate = squeezing if missing < 0.0 else 1.0 / self.growth
        return (c.v * (1.0 - direction * self.sigma0 * z / level), missing * film_rate)

    def force(self, c: Contact, direction: int) -> float:
        damping = self.sigma1 * math.exp(-((c.v / self.vd) ** 2))
        return self.sigma0 * c.z[0] + damping * self.rates(c, direction)[0] + self.sigma2 * c.v


@dataclass(frozen=True)
class BlimanSorine(BristleLaw):
    f1: float
    f2: float
    eta: float
    xe: float
    sigma2: float
    units = (1.0, 1.0)

    def rates(self, c: Contact, direction: int) -> Sequence[float]:
        speed = direction * c.v
        return (
            speed * (c.level * self.f1 * direction - c.z[0]) / (self.eta * self.xe),
            speed * (-c.level * self.f2 * direction - c.z[1]) / self.xe,
        )

    def force(self, c: Contact, direction: int) -> float:
        return c.z[0] + c.z[1] + self.sigma2 * c.v


@dataclass(frozen=True)
class ElastoPlastic(BristleLaw):
    steady: Stribeck
    sigma0: float
    sigma1: float
    sigma2: float
    zba_ratio: float
    units = (1e-6,)

    def rates(self, c: Contact, direction: int) -> Sequence[float]:
        z_max = c.level * self.steady(direction * c.v) / self.sigma0
        plastic = self._plastic_share(direction * c.z[0], z_max, c.level)
        return (c.v * (1.0 - plastic * direction * c.z[0] / z_max),)

    def force(self, c: Contact, direction: int) -> float:
        (dz,) = self.rates(c, direction)
        return self.sigma0 * c.z[0] + self.sigma1 * dz + self.sigma2 * c.v

    def _plastic_share(self, strain: float, z_max: float, level: float) -> float:
        z_ba = self.zba_ratio * level * self.steady.fc / self.sigma0
        if strain <= z_ba:
            return 0.0
        if strain >= z_max:
            return 1.0
        return 0.5 * math.sin(math.pi * (strain - 0.5 * (z_max + z_ba)) / (z_max - z_ba)) + 0.5
