"""Hoses, flow controls, end cushions and the vessel of the supply.

A hose is a chain of volumes, described by the mass of air in each, and of columns between them, described
by their mass flow; all of it has the temperature of the surroundings.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from itertools import pairwise

from gas import GAS_CONSTANT, Gas, Stream, orifice

VISCOSITY = 1.813e-5
COLUMNS = 3


@dataclass(frozen=True)
class Restriction:
    """Restriction between the end of a hose and its chamber: a one-way flow control, a cushion, or both.

    A check valve opens with the difference of the pressures, and is open from 0.5 % of it on.
    """

    into: float
    out: float
    critical_ratio: float
    cushion_length: float
    cushion_conductance: float

    def stream(self, hose: Gas, chamber: Gas, distance: float) -> Stream:
        into, out = self.into, self._out(distance)
        higher, lower = max(hose.pressure, chamber.pressure), min(hose.pressure, chamber.pressure)
        open_share = min((higher - lower) / (0.005 * higher), 1.0)
        way = into if hose.pressure >= chamber.pressure else out
        conductance = open_share * way + (1.0 - open_share) * min(into, out)
        return orifice(conductance, self.critical_ratio, hose, chamber)

    def _out(self, distance: float) -> float:
        if distance >= self.cushion_length:
            return self.out
        tight = min(self.out, self.cushion_conductance)
        way = min((self.cushion_length - distance) / (0.1 * self.cushion_length), 1.0)
        return (1.0 - way) * self.out + way * tight


@dataclass(frozen=True)
class Hose:
    """The states are the masses in the volumes (four if a restriction follows, else three), then the flows."""

    length: float
    diameter: float
    temperature: float
    restriction: Restriction | None

    @property
    def area(self) -> float:
        return math.pi * self.diameter**2 / 4.0

    @property
    def volumes(self) -> list[float]:
        """The volumes of the hose itself; without a restriction the last sixth belongs to the chamber."""
        whole = self.area * self.length
        shares = [1.0 / 6.0, 1.0 / 3.0, 1.0 / 3.0, 1.0 / 6.0]
        return [share * whole for share in shares[: 3 if self.restriction is None else 4]]

    @property
    def lent_volume(self) -> float:
        return self.area * self.length / 6.0 if self.restriction is None else 0.0

    def start(self, pressure: float) -> list[float]:
        gas = GAS_CONSTANT * self.temperature
        return [pressure * volume / gas for volume in self.volumes] + [0.0] * COLUMNS

    def gas(self, states: list[float], number: int) -> Gas:
        pressure = states[number] * GAS_CONSTANT * self.temperature / self.volumes[number]
        return Gas(pressure, self.temperature)

    def outflow(self, states: list[float], chamber: Gas, distance: float) -> Stream:
        """Flow from the hose into the chamber."""
        if self.restriction is not None:
            return self.restriction.stream(self.gas(states, COLUMNS), chamber, distance)
        flow = self._passing(states, chamber)[-1]
        return Stream(flow, self.temperature if flow > 0.0 else chamber.temperature)

    def rates(self, states: list[float], inflow: float, out: Stream, chamber: Gas) -> list[float]:
        count = len(self.volumes)
        through = [inflow, *self._passing(states, chamber), out.mass_flow][: count + 1]
        masses = [before - after for before, after in pairwise(through)]
        return masses + self._accelerations(states, chamber)

    @property
    def _sound(self) -> float:
        """The isothermal speed of sound."""
        return math.sqrt(GAS_CONSTANT * self.temperature)

    def _pressures(self, states: list[float], chamber: Gas) -> list[float]:
        pressures = [self.gas(states, number).pressure for number in range(len(self.volumes))]
        return pressures + ([chamber.pressure] if self.restriction is None else [])

    def _choked(self, flow: float, before: float, after: float) -> float:
        """A flow limited to the speed of sound in the volume that it leaves."""
        source = before if flow > 0.0 else after
        return math.copysign(min(abs(flow), self.area * source / self._sound), flow)

    def _passing(self, states: list[float], chamber: Gas) -> list[float]:
        """Flow of each column: its own, and the part that sound brings across the hose in the time of its width."""
        flows, pressures = states[len(self.volumes) :], self._pressures(states, chamber)
        rates = self._accelerations(states, chamber)
        ends = zip(flows, rates, pairwise(pressures), strict=True)
        return [self._choked(flow + self.diameter / self._sound * rate, *own) for flow, rate, own in ends]

    def _accelerations(self, states: list[float], chamber: Gas) -> list[float]:
        """Rate by which a column loses its excess over the speed of sound, in the time of sound across the hose."""
        flows, pressures = states[len(self.volumes) :], self._pressures(states, chamber)
        return [
            self._acceleration(flow, *own) - (flow - self._choked(flow, *own)) * self._sound / self.diameter
            for flow, own in zip(flows, pairwise(pressures), strict=True)
        ]

    def _acceleration(self, flow: float, before: float, after: float) -> float:
        """The rate of the mass flow of a column: Newton's law with the loss of Darcy and Weisbach."""
        length = self.length / COLUMNS
        density = 0.5 * (before + after) / (GAS_CONSTANT * self.temperature)
        velocity = flow / (density * self.area)
        reynolds = density * abs(velocity) * self.diameter / VISCOSITY
        loss = 0.0
        if reynolds > 0.0:
            factor = max(64.0 / reynolds, 0.3164 / reynolds**0.25)
            loss = factor * length / self.diameter * 0.5 * density * velocity * abs(velocity)
        return self.area / length * (before - after - loss)


@dataclass(frozen=True)
class Vessel:
    """A vessel between supply and valve; its state is the mass in it."""

    volume: float
    conductance: float
    critical_ratio: float
    temperature: float

    def start(self, pressure: float) -> list[float]:
        return [pressure * self.volume / (GAS_CONSTANT * self.temperature)]

    def gas(self, mass: float) -> Gas:
        return Gas(mass * GAS_CONSTANT * self.temperature / self.volume, self.temperature)

    def filling(self, mass: float, supply_pressure: float) -> float:
        supply = Gas(supply_pressure, self.temperature)
        return orifice(self.conductance, self.critical_ratio, supply, self.gas(mass)).mass_flow


def hose(parameters: Mapping[str, float | str], side: str) -> Hose | None:
    """The hose to a chamber, if there is one."""

    def number(name: str) -> float:
        return float(parameters[name])

    length = number(f"hose{side}.length")
    if length == 0.0:
        return None
    throttle, free = number(f"throttle{side}.C"), number("throttle.free")
    throttled = throttle if throttle > 0.0 else free
    meters_out = parameters["throttle.direction"] == "MeterOut"
    restriction = None
    if throttle > 0.0 or number("cushion.length") > 0.0:
        restriction = Restriction(
            free if meters_out else throttled,
            throttled if meters_out else free,
            number("throttle.b"),
            number("cushion.length"),
            number("cushion.C"),
        )
    return Hose(length, number(f"hose{side}.diameter"), number("ambientTemperature"), restriction)


def vessel(parameters: Mapping[str, float | str]) -> Vessel | None:
    """The vessel of the supply, if there is one."""
    names = ("supply.volume", "supply.C", "supply.b", "supplyTemperature")
    volume, conductance, ratio, temperature = (float(parameters[name]) for name in names)
    return Vessel(volume, conductance, ratio, temperature) if volume > 0.0 else None
