"""Friction laws as hybrid automata.

A law is a set of regimes.  Within a regime the friction force and the rates of the internal states
are smooth functions, valid while the velocity keeps the regime's direction and every margin stays
positive.  The end of a regime is located as an event, and the regime names its successor.  So no
sign function, saturation or stick condition is ever integrated across.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

from scipy.optimize import brentq  # type: ignore[import-untyped]


class Contact(NamedTuple):
    """What a friction law sees of the mass at one instant."""

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
    """Whether the mass stands still, whatever its velocity state."""
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
        return _sign(c.v)
    return _sign(c.applied - force)


# Smooth laws


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
        return level * steady(abs(v)) * _clamp(v / eps, -1.0, 1.0) + sigma2 * v

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


# Set-valued laws: Coulomb, CoulombStiction, Stribeck


@dataclass(frozen=True)
class DryFriction:
    """Friction with a break-away force and a sliding curve."""

    breakaway: float
    sliding: Callable[[float], float]
    sigma2: float

    def law(self) -> Law:
        return Law(lambda c: self.rest(c) if c.v == 0.0 else Sliding(self, _sign(c.v)))

    def rest(self, c: Contact) -> Regime:
        """The regime of a mass that has just come to rest."""
        if abs(c.applied) <= c.level * self.breakaway:
            return Stuck(self.breakaway, lambda direction: Sliding(self, direction))
        return Sliding(self, _sign(c.applied))


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
        return self.slide(_sign(c.applied))


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


# Stribeck with a memory of its rest


@dataclass(frozen=True)
class Ageing:
    """Stribeck friction whose static part grows at rest, and with the load at a pace of its own."""

    steady: Stribeck
    rested: float
    gamma: float
    ratio: float
    sigma2: float

    def law(self) -> Law:
        return Law(lambda c: AgeingStuck(self, -math.inf) if c.v == 0.0 else AgeingSliding(self, _sign(c.v)))

    def rest(self, c: Contact) -> Regime:
        """The regime of a mass that has just come to rest."""
        stuck = AgeingStuck(self, c.time)
        return stuck if stuck.margins(c)[0] >= 0.0 else AgeingSliding(self, _sign(c.applied))

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
        return AgeingSliding(self.friction, _sign(c.applied))


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


# Karnopp


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
            return KarnoppSliding(self, _sign(c.v))
        return self.inside(c)

    def inside(self, c: Contact) -> Regime:
        if abs(c.applied) <= c.level * self.steady.fs:
            return KarnoppStuck(self)
        push = _sign(c.applied)
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
        push = _sign(c.applied)
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


# Polito


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
        return Law(lambda c: self.rest(c) if c.v == 0.0 else PolitoAccelerating(self, _sign(c.v)))

    def rest(self, c: Contact) -> Regime:
        if abs(c.applied) <= c.level * self.fs:
            return Stuck(self.fs, lambda direction: PolitoAccelerating(self, direction))
        return PolitoAccelerating(self, _sign(c.applied))

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


# Bristle laws whose equations depend on the sign of the velocity and nothing else


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


# Generalised Maxwell slip and Maxwell slip


class MaxwellElements(ABC):
    """Parallel spring-slider elements whose forces are the internal states."""

    stiffness: tuple[float, ...]
    sigma2: float

    @abstractmethod
    def slip_rate(self, c: Contact, direction: int, element: int) -> float:
        """The rate of the force of a slipping element."""

    @abstractmethod
    def reserve(self, c: Contact, direction: int, element: int) -> float:
        """What a stuck element can still take before it slips."""

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


# Reset integrator


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


# Stick-slip with an anchored spring


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
        return SpringSlip(self.friction, _sign(c.v))


@dataclass(frozen=True)
class SpringSlip(Regime):
    """The mass slides."""

    friction: StickSlipSpring
    direction: int

    def force(self, c: Contact) -> float:
        return self.direction * c.level * self.friction.fc + self.friction.sigma2 * c.v

    def at_rest(self, c: Contact) -> Regime:
        return SpringStick(self.friction, c.x - self.force(c) / self.friction.stiffness)


# Stick-slip with a bounded stiction displacement


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
        share = cubic_ramp(_clamp((self.vd - abs(c.v)) / (self.vd - self.vs), 0.0, 1.0))
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


# Modified Leuven


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
        strain_direction = direction * _sign(yielding)
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
        """Where the current branch meets the one it came from: its start or the virgin curve."""
        if len(self.turning_points) > 1:
            return self.turning_points[-2].z
        return -self.turning_points[0].z


# Construction from parameters

Settings = Mapping[str, float]


@dataclass(frozen=True)
class Entry:
    """A law of the enumeration: its parameter group, defaults and constructor."""

    group: str
    defaults: Settings
    build: Callable[[Settings], Law]


STRIBECK_DEFAULTS: Settings = {"Fs": 11.0, "Fc": 8.3, "vs": 0.01, "delta": 2.0}
TRANSITION_DEFAULTS: Settings = {"Fs": 11.0, "Fc": 8.3, "vs": 1e-3, "vd": 1e-2, "sigma2": 30.0}


def _steady(p: Settings) -> Stribeck:
    return Stribeck(p["Fs"], p["Fc"], p["vs"], p["delta"])


def _stribeck(p: Settings) -> Law:
    if p["FsInf"] == 0.0 and p["kappaRatio"] == 1.0:
        return DryFriction(p["Fs"], _steady(p), p["sigma2"]).law()
    return Ageing(_steady(p), p["FsInf"], p["gamma"], p["kappaRatio"], p["sigma2"]).law()


LAWS: dict[str, Entry] = {
    "None": Entry("none", {}, lambda p: none()),
    "Coulomb": Entry(
        "coulomb",
        {"Fc": 8.3, "sigma2": 30.0},
        lambda p: DryFriction(p["Fc"], lambda speed: p["Fc"], p["sigma2"]).law(),
    ),
    "CoulombStiction": Entry(
        "coulombStiction",
        {"Fs": 11.0, "Fc": 8.3, "sigma2": 30.0},
        lambda p: DryFriction(p["Fs"], lambda speed: p["Fc"], p["sigma2"]).law(),
    ),
    "SmoothCoulomb": Entry(
        "smoothCoulomb",
        {"Fc": 8.3, "vd": 1e-3, "sigma2": 30.0},
        lambda p: smooth_coulomb(p["Fc"], p["vd"], p["sigma2"]),
    ),
    "VelocityBased": Entry(
        "velocityBased",
        {"Fs": 11.0, "Fc": 8.3, "vs": 0.01, "E": 0.0, "sigma2": 30.0},
        lambda p: velocity_based(p["Fs"], p["Fc"], p["vs"], p["E"], p["sigma2"]),
    ),
    "StribeckRegularised": Entry(
        "stribeckRegularised",
        {**STRIBECK_DEFAULTS, "eps": 1e-3, "sigma2": 30.0},
        lambda p: stribeck_regularised(_steady(p), p["eps"], p["sigma2"]),
    ),
    "Stribeck": Entry(
        "stribeck",
        {**STRIBECK_DEFAULTS, "sigma2": 30.0, "FsInf": 0.0, "gamma": 0.1, "kappaRatio": 1.0},
        _stribeck,
    ),
    "Karnopp": Entry(
        "karnopp",
        {**STRIBECK_DEFAULTS, "DV": 1e-4, "sigma2": 30.0},
        lambda p: Karnopp(_steady(p), p["DV"], p["sigma2"]).law(),
    ),
    "Polito": Entry(
        "polito",
        {
            "Fs": 10.8,
            "Fc1": 7.8,
            "Fc2": 7.8,
            "vs": 0.01,
            "c1": 33.0,
            "c2": 25.0,
            "delta": 2.0,
        },
        lambda p: Polito(p["Fs"], p["Fc1"], p["Fc2"], p["vs"], p["c1"], p["c2"], p["delta"]).law(),
    ),
    "Dahl": Entry(
        "dahl",
        {"Fc": 10.6, "sigma0": 8e6, "n": 1.0, "sigma2": 0.0},
        lambda p: Dahl(p["Fc"], p["sigma0"], p["n"], p["sigma2"]).law(),
    ),
    "ResetIntegrator": Entry(
        "resetIntegrator",
        {"sigma0": 1e6, "z0": 8.3e-6, "a": 0.325, "sigma1": 1000.0, "sigma2": 30.0},
        lambda p: ResetIntegrator(p["sigma0"], p["sigma1"], p["sigma2"], p["z0"], p["a"]).law(),
    ),
    "LuGre": Entry(
        "lugre",
        {**STRIBECK_DEFAULTS, "sigma0": 1e6, "sigma1": 1e3, "sigma2": 30.0, "vd": 1e-2},
        lambda p: LuGre(_steady(p), p["sigma0"], p["sigma1"], p["sigma2"], p["vd"]).law(),
    ),
    "Leuven": Entry(
        "leuven",
        {
            **STRIBECK_DEFAULTS,
            "n": 1.0,
            "k1": 1.483e6,
            "f1": 5.595,
            "f2": 5.631e5,
            "sigma1": 0.0,
            "sigma2": 30.0,
        },
        lambda p: Leuven(_steady(p), p["n"], p["k1"], p["f1"], p["f2"], p["sigma1"], p["sigma2"]).law(),
    ),
    "GMS": Entry(
        "gms",
        {**STRIBECK_DEFAULTS, "C": 500.0, "sigma2": 30.0},
        lambda p: GeneralisedMaxwellSlip(_steady(p), (4e5, 3e5, 2e5, 1e5), (0.25,) * 4, p["C"], p["sigma2"]).law(),
    ),
    "MaxwellSlip": Entry(
        "maxwellSlip",
        {"sigma2": 30.0},
        lambda p: MaxwellSlip((8e5, 4e5, 2e5, 1e5), (2.075,) * 4, p["sigma2"]).law(),
    ),
    "BlimanSorine": Entry(
        "blimanSorine",
        {"f1": 24.6, "f2": 16.3, "eta": 0.5, "xe": 1e-5, "sigma2": 30.0},
        lambda p: BlimanSorine(p["f1"], p["f2"], p["eta"], p["xe"], p["sigma2"]).law(),
    ),
    "ElastoPlastic": Entry(
        "elastoPlastic",
        {
            **STRIBECK_DEFAULTS,
            "sigma0": 1e6,
            "sigma1": 1000.0,
            "sigma2": 30.0,
            "zbaRatio": 0.7,
        },
        lambda p: ElastoPlastic(_steady(p), p["sigma0"], p["sigma1"], p["sigma2"], p["zbaRatio"]).law(),
    ),
    "StepRegularised": Entry(
        "stepRegularised",
        TRANSITION_DEFAULTS,
        lambda p: transition_regularised(cubic_ramp, p["Fs"], p["Fc"], p["vs"], p["vd"], p["sigma2"]),
    ),
    "SineRegularised": Entry(
        "sineRegularised",
        TRANSITION_DEFAULTS,
        lambda p: transition_regularised(sine_ramp, p["Fs"], p["Fc"], p["vs"], p["vd"], p["sigma2"]),
    ),
    "StickSlipSpring": Entry(
        "stickSlipSpring",
        {"Fs": 11.0, "Fc": 8.3, "k": 1e5, "d": 300.0, "sigma2": 30.0},
        lambda p: StickSlipSpring(p["Fs"], p["Fc"], p["k"], p["d"], p["sigma2"]).law(),
    ),
    "StickSlipCreep": Entry(
        "stickSlipCreep",
        {
            "Fs": 11.0,
            "Fc": 8.3,
            "Delta": 1e-5,
            "vs": 1e-3,
            "vd": 1e-2,
            "sigma1": 1000.0,
            "sigma2": 30.0,
        },
        lambda p: StickSlipCreep(p["Fs"], p["Fc"], p["Delta"], p["vs"], p["vd"], p["sigma1"], p["sigma2"]).law(),
    ),
}


def _sign(value: float) -> int:
    return 1 if value > 0.0 else -1


def _clamp(value: float, low: float, high: float) -> float:
    return min(max(value, low), high)
