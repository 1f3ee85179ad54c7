"""The pneumatic servo cylinder without its friction: air, valve, regulator, forces.

The air in a chamber is described by its mass ``m`` and internal energy ``U``; pressure and
temperature follow from ``p = (gamma - 1) U / V`` and ``T = U / (m c_v)``.  A model written in
pressure and temperature integrates different equations, so agreement between the two is evidence
for both.  All quantities are SI.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import NamedTuple

from actuator import Actuator
from gas import CP, CV, GAMMA, GAS_CONSTANT, Gas, Stream, orifice
from lines import Hose, hose, vessel
from scipy.interpolate import PchipInterpolator  # type: ignore[import-untyped]
from switching import SwitchingValves

GRAVITY = 9.80665

Value = float | str
Parameters = Mapping[str, Value]

DEFAULTS: dict[str, Value] = {
    "cylinder.bore": 0.016,
    "cylinder.rod": 0.006,
    "cylinder.stroke": 0.5,
    "cylinder.stopStiffness": 1e6,
    "cylinder.stopDamping": 0.75,
    "chamberA.deadVolume": 5e-6,
    "chamberB.deadVolume": 5e-6,
    "chamberA.pressure0": 101325.0,
    "chamberB.pressure0": 101325.0,
    "chamberB.tankVolume": 0.0,
    "mass.moving": 0.88,
    "position0": 0.25,
    "velocity0": 0.0,
    "ambientPressure": 101325.0,
    "ambientTemperature": 293.15,
    "supplyTemperature": 293.15,
    "thermal.model": "EnergyBalance",
    "thermal.heatTransfer": 60.0,
    "thermal.exponent": 1.2,
    "incline": 0.0,
    "wireForce": 0.0,
    "piston.leakage": 0.0,
    "actuation": "ProportionalValve",
    "valve.C": 3.93e-9,
    "valve.b": 0.3,
    "valve.deadZone": 0.08,
    "valve.leakage": 0.002,
    "valve.bandwidth": 115.0,
    "valve.damping": 0.7071067811865476,
    "valve.hysteresis": 0.004,
    "valve.polarity": 1.0,
    "valve.offset": 0.0,
    "valve.PA.factor": 1.0,
    "valve.PB.factor": 1.0,
    "valve.AR.factor": 1.0,
    "valve.BR.factor": 1.0,
    "valve.PA.b": -1.0,
    "valve.PB.b": -1.0,
    "valve.AR.b": -1.0,
    "valve.BR.b": -1.0,
    "valve.characteristic": "Linear",
    **{
        f"valve.table{side}.{name}": value
        for side in "AB"
        for name, value in [
            ("points", 11.0),
            *((f"spool[{k + 1}]", k / 10.0) for k in range(11)),
            *((f"opening[{k + 1}]", k / 10.0) for k in range(11)),
        ]
    },
    "regulator.pMin": 1e5,
    "regulator.pMax": 8.8e5,
    "regulator.tau": 0.02,
    "regulator.C": 4e-9,
    "regulator.b": 0.3,
    "switching.C": 3.93e-9,
    "switching.b": 0.3,
    "switching.centre": "Vented",
    "switching.frequency": 100.0,
    "switching.openingDelay": 1e-3,
    "switching.closingDelay": 1e-3,
    "switching.travelTime": 5e-4,
    "friction.kappaA": 0.0,
    "friction.kappaB": 0.0,
    "friction.kappaDifference": 0.0,
    "friction.kappaDriving": 0.0,
    "friction.kappaResisting": 0.0,
    "friction.position.points": 0,
    **{f"friction.position.at[{k}]": 0.0625 * (k - 1) for k in range(1, 10)},
    **{f"friction.position.factor[{k}]": 1.0 for k in range(1, 10)},
    "friction.position.amplitude": 0.0,
    "friction.position.period": 0.05,
    "cylinder.rodA": 0.0,
    "chamberB.open": 0.0,
    "load.stiffness": 0.0,
    "load.rest": 0.0,
    "hoseA.length": 0.0,
    "hoseA.diameter": 4e-3,
    "hoseB.length": 0.0,
    "hoseB.diameter": 4e-3,
    "throttleA.C": 0.0,
    "throttleB.C": 0.0,
    "throttle.free": 1e-8,
    "throttle.b": 0.3,
    "throttle.direction": "MeterOut",
    "cushion.length": 0.0,
    "cushion.C": 2e-10,
    "supply.volume": 0.0,
    "supply.C": 1e-8,
    "supply.b": 0.3,
}


class Inputs(NamedTuple):
    """The inputs of the model, held constant over one communication step."""

    voltage: float
    external_force: float
    supply_pressure: float


class Plant:
    """Everything that accelerates the carriage except friction.

    State vector: position, velocity, mass and energy of chamber A, mass and energy of chamber B,
    the two states of the actuator, then of the hoses A and B and of the vessel, where there are any.
    """

    OWN = 8

    def __init__(self, parameters: Parameters) -> None:
        bore, rod = _number(parameters, "cylinder.bore"), _number(parameters, "cylinder.rod")
        piston_area = math.pi * bore**2 / 4.0
        rod_a = _number(parameters, "cylinder.rodA")
        area_a = piston_area - math.pi * rod_a**2 / 4.0
        area_b = piston_area - math.pi * rod**2 / 4.0
        self.stroke = _number(parameters, "cylinder.stroke")
        self.stop_stiffness = _number(parameters, "cylinder.stopStiffness")
        self.stop_damping = _number(parameters, "cylinder.stopDamping")
        self.mass = _number(parameters, "mass.moving")
        self.ambient_pressure = _number(parameters, "ambientPressure")
        self.leakage = _number(parameters, "piston.leakage")
        self.kappa_a = _number(parameters, "friction.kappaA")
        self.kappa_b = _number(parameters, "friction.kappaB")
        self.constant_load = (
            _number(parameters, "wireForce")
            + self.mass * GRAVITY * math.sin(_number(parameters, "incline"))
            + self.ambient_pressure * (area_a - area_b)
        )
        self.hoses = {side: hose(parameters, side) for side in "AB"}
        self.vessel = vessel(parameters)
        lent = {side: line.lent_volume if line else 0.0 for side, line in self.hoses.items()}
        self.chamber_a = _chamber(parameters, "chamberA", area_a, 0.0, lent["A"])
        self.chamber_b = _chamber(
            parameters,
            "chamberB",
            area_b,
            _number(parameters, "chamberB.tankVolume"),
            lent["B"],
        )
        self.is_open = bool(_number(parameters, "chamberB.open"))
        self.kappa_difference = _number(parameters, "friction.kappaDifference")
        self.kappa_driving = _number(parameters, "friction.kappaDriving")
        self.kappa_resisting = _number(parameters, "friction.kappaResisting")
        self.profile = _profile(parameters)
        self.waviness = _number(parameters, "friction.position.amplitude")
        self.wave_length = _number(parameters, "friction.position.period")
        self.spring_stiffness = _number(parameters, "load.stiffness")
        self.spring_rest = _number(parameters, "load.rest")
        self.actuator = _actuator(parameters)
        self.start_position = _number(parameters, "position0")
        self.start_velocity = _number(parameters, "velocity0")

    def start(self, command: float, supply_pressure: float) -> list[float]:
        """The initial state, with ``command`` what the actuator is told at t = 0."""
        x = self.start_position
        lines = []
        for line, chamber in zip(self.hoses.values(), (self.chamber_a, self.chamber_b), strict=True):
            lines += line.start(chamber.start_pressure) if line else []
        lines += self.vessel.start(supply_pressure) if self.vessel else []
        return [
            x,
            self.start_velocity,
            *self.chamber_a.start(x),
            *self.chamber_b.start(self.stroke - x),
            *self.actuator.start(command),
            *lines,
        ]

    def units(self) -> list[float]:
        """The natural size of each state, by which its absolute tolerance is set.

        The velocity unit is small because sliding starts from exactly zero velocity.
        """
        start = self.start(0.0, 1e5)
        lines = [value if value > 0.0 else 1e-4 for value in start[self.OWN :]]
        return [1e-2, 1e-3, *start[2:6], *self.actuator.units, *lines]

    def gases(self, state: list[float]) -> tuple[Gas, Gas]:
        """The air in chambers A and B."""
        x = state[0]
        outside = Gas(self.ambient_pressure, self.chamber_b.ambient_temperature)
        return (
            self.chamber_a.gas(state[2], state[3], x),
            outside if self.is_open else self.chamber_b.gas(state[4], state[5], self.stroke - x),
        )

    def applied_force(self, x: float, v: float, a: Gas, b: Gas, external_force: float) -> float:
        """The sum of all forces on the carriage except friction."""
        return (
            a.pressure * self.chamber_a.area
            - b.pressure * self.chamber_b.area
            - self.constant_load
            - self.spring_stiffness * (x - self.spring_rest)
            + external_force
            + self._stop_force(x, v)
        )

    def inertia(self, x: float) -> float:
        """Accelerated mass in kg at a position."""
        return self.mass

    def friction_level(self, x: float, a: Gas, b: Gas, towards: float) -> float:
        """The factor by which chamber pressures and place scale the friction forces of a motion or a push to a side."""
        driving, resisting = (a, b) if towards > 0.0 else (b, a)
        level = (
            1.0
            + self.kappa_a * (a.pressure - self.ambient_pressure)
            + self.kappa_b * (b.pressure - self.ambient_pressure)
            + self.kappa_difference * abs(a.pressure - b.pressure)
            + self.kappa_driving * (driving.pressure - self.ambient_pressure)
            + self.kappa_resisting * (resisting.pressure - self.ambient_pressure)
        )
        wave = math.sin(2.0 * math.pi * x / self.wave_length)
        return max(0.0, level) * (1.0 + self.waviness * wave) * self.profile(x)

    def rates(
        self,
        state: list[float],
        v: float,
        acceleration: float,
        a: Gas,
        b: Gas,
        command: float,
        supply_pressure: float,
        time: float,
    ) -> list[float]:
        """The derivatives of the state, with ``v`` the velocity the carriage really has."""
        x = state[0]
        actuator = state[6:8]
        supplied = supply_pressure
        own = self._split(state)
        if self.vessel:
            supply_pressure = self.vessel.gas(own["supply"][0]).pressure
        port_a, port_b = (
            line.gas(own[side], 0) if line else chamber
            for (side, line), chamber in zip(self.hoses.items(), (a, b), strict=True)
        )
        streams_a, streams_b = self.actuator.streams(self.actuator.at(time, actuator), port_a, port_b, supply_pressure)
        # The first stream of each chamber comes from the supply.
        drawn = sum(stream.mass_flow for stream in [*streams_a[:1], *streams_b[:1]])
        if self.actuator.vents_to_surroundings:
            drawn = max(drawn, 0.0)
        rates = []
        streams_a = self._through(self.hoses["A"], own["A"], streams_a, a, x, rates)
        streams_b = self._through(self.hoses["B"], own["B"], streams_b, b, self.stroke - x, rates)
        if self.vessel:
            rates.append(self.vessel.filling(own["supply"][0], supplied) - drawn)
        if self.leakage > 0.0:
            cross = self._cross_leakage(a, b)
            streams_a.append(Stream(-cross.mass_flow, cross.temperature))
            streams_b.append(cross)
        return [
            v,
            acceleration,
            *self.chamber_a.rates(a, streams_a, x, v),
            *self.chamber_b.rates(b, streams_b, self.stroke - x, -v),
            *self.actuator.rates(actuator, command),
            *rates,
        ]

    def _split(self, state: list[float]) -> dict[str, list[float]]:
        """The states of the hoses and of the vessel."""
        parts, first = {}, self.OWN
        for side, line in self.hoses.items():
            count = len(line.start(1.0)) if line else 0
            parts[side] = state[first : first + count]
            first += count
        return parts | {"supply": state[first : first + 1]}

    @staticmethod
    def _through(
        line: Hose | None,
        states: list[float],
        streams: list[Stream],
        chamber: Gas,
        distance: float,
        rates: list[float],
    ) -> list[Stream]:
        """Flow into a chamber from the valve's flow; adds the rates of the hose to ``rates``."""
        if line is None:
            return streams
        out = line.outflow(states, chamber, distance)
        rates += line.rates(states, sum(stream.mass_flow for stream in streams), out, chamber)
        return [out]

    def _stop_force(self, x: float, v: float) -> float:
        if x < 0.0:
            depth = _hardened(-x, self.chamber_a.fixed_volume / self.chamber_a.area)
            return max(0.0, self.stop_stiffness * depth * (1.0 - self.stop_damping * v))
        if x > self.stroke:
            depth = _hardened(x - self.stroke, self.chamber_b.fixed_volume / self.chamber_b.area)
            return -max(0.0, self.stop_stiffness * depth * (1.0 + self.stop_damping * v))
        return 0.0

    def _cross_leakage(self, a: Gas, b: Gas) -> Stream:
        """The laminar leakage past the piston, from chamber A into chamber B."""
        mass_flow = self.leakage * (a.pressure**2 - b.pressure**2)
        return Stream(mass_flow, a.temperature if mass_flow > 0.0 else b.temperature)


@dataclass(frozen=True)
class Chamber(ABC):
    """A chamber of variable length; ``fixed_volume`` is dead volume plus tank, ``tank_volume`` the latter alone."""

    area: float
    fixed_volume: float
    tank_volume: float
    bore: float
    start_pressure: float
    ambient_temperature: float

    def volume(self, length: float) -> float:
        return self.fixed_volume + self.area * length

    def start(self, length: float) -> tuple[float, float]:
        """Mass and energy at the initial pressure and ambient temperature."""
        energy_per_kelvin = CV * self.start_pressure * self.volume(length) / GAS_CONSTANT
        return energy_per_kelvin / (CV * self.ambient_temperature), energy_per_kelvin

    @abstractmethod
    def gas(self, mass: float, energy: float, length: float) -> Gas:
        """Pressure and temperature from the conserved quantities."""

    @abstractmethod
    def rates(self, gas: Gas, streams: list[Stream], length: float, speed: float) -> tuple[float, float]:
        """The derivatives of mass and energy while the chamber lengthens at ``speed``."""


@dataclass(frozen=True)
class EnergyBalanceChamber(Chamber):
    """Air that exchanges enthalpy with its ports and heat with its wall."""

    heat_transfer: float

    def gas(self, mass: float, energy: float, length: float) -> Gas:
        return Gas((GAMMA - 1.0) * energy / self.volume(length), energy / (mass * CV))

    def rates(self, gas: Gas, streams: list[Stream], length: float, speed: float) -> tuple[float, float]:
        enthalpy = CP * sum(stream.mass_flow * stream.temperature for stream in streams)
        wall = 2.0 * self.area + math.pi * self.bore * max(length, 0.0) + self._tank_wall()
        heat = self.heat_transfer * wall * (self.ambient_temperature - gas.temperature)
        work = gas.pressure * self.area * speed
        return sum(stream.mass_flow for stream in streams), enthalpy + heat - work

    def _tank_wall(self) -> float:
        """The wall of a closed cylinder twice as long as wide that has the volume of the tank."""
        diameter = (2.0 * self.tank_volume / math.pi) ** (1.0 / 3.0)
        return math.pi * diameter * (2.0 * diameter) + 2.0 * math.pi * diameter**2 / 4.0


@dataclass(frozen=True)
class PolytropicChamber(Chamber):
    """Air whose pressure follows its density as p ~ rho^n; n = 1 is isothermal.

    The energy is not an independent quantity here, and its state stays where it started.
    """

    exponent: float

    def gas(self, mass: float, energy: float, length: float) -> Gas:
        start_density = self.start_pressure / (GAS_CONSTANT * self.ambient_temperature)
        compression = mass / (start_density * self.volume(length))
        return Gas(
            self.start_pressure * compression**self.exponent,
            self.ambient_temperature * compression ** (self.exponent - 1.0),
        )

    def rates(self, gas: Gas, streams: list[Stream], length: float, speed: float) -> tuple[float, float]:
        return sum(stream.mass_flow for stream in streams), 0.0


@dataclass(frozen=True)
class PolytropicServoChamber(Chamber):
    """Air at ambient temperature whose pressure answers flow and motion with the factor n.

    In place of the energy stands ``p * V**n``, which only flow changes.
    """

    exponent: float

    def start(self, length: float) -> tuple[float, float]:
        volume = self.volume(length)
        mass = self.start_pressure * volume / (GAS_CONSTANT * self.ambient_temperature)
        return mass, self.start_pressure * volume**self.exponent

    def gas(self, mass: float, energy: float, length: float) -> Gas:
        return Gas(energy / self.volume(length) ** self.exponent, self.ambient_temperature)

    def rates(self, gas: Gas, streams: list[Stream], length: float, speed: float) -> tuple[float, float]:
        carried = GAS_CONSTANT * sum(stream.mass_flow * stream.temperature for stream in streams)
        growth = self.exponent * self.volume(length) ** (self.exponent - 1.0) * carried
        return sum(stream.mass_flow for stream in streams), growth


class ProportionalValve(Actuator):
    """A spool valve: play on the command, second-order spool, four metering edges."""

    units = (1.0, 1e2)

    def __init__(self, parameters: Parameters) -> None:
        self._edges = {name: Edge.of(parameters, name) for name in ("PA", "PB", "AR", "BR")}
        self._tables = (
            {side: _table(parameters, side) for side in "AB"} if parameters["valve.characteristic"] == "Table" else None
        )
        self._offset = _number(parameters, "valve.offset")
        self._dead_zone = _number(parameters, "valve.deadZone")
        self._leakage = _number(parameters, "valve.leakage")
        self._frequency = 2.0 * math.pi * _number(parameters, "valve.bandwidth")
        self._damping = _number(parameters, "valve.damping")
        self._half_play = _number(parameters, "valve.hysteresis")
        self._polarity = _number(parameters, "valve.polarity")
        self._exhaust = Gas(_number(parameters, "ambientPressure"), _number(parameters, "ambientTemperature"))
        self._supply_temperature = _number(parameters, "supplyTemperature")
        self._played: float = 0.0

    def command(self, voltage: float, time: float) -> float:
        u = self._polarity * _clamp((voltage + self._offset - 5.0) / 5.0, -1.0, 1.0)
        # The play narrows towards the ends, where it leaves nothing: there the command is the set point.
        below = min(self._half_play, 1.0 - u)
        above = min(self._half_play, 1.0 + u)
        self._played = _clamp(self._played, u - below, u + above)
        return self._played

    def start(self, command: float) -> tuple[float, float]:
        return 0.0, 0.0

    def rates(self, state: list[float], command: float) -> tuple[float, float]:
        spool, speed = state
        wn = self._frequency
        return speed, wn * (wn * (command - spool) - 2.0 * self._damping * speed)

    def streams(self, state: list[float], a: Gas, b: Gas, supply_pressure: float) -> tuple[list[Stream], list[Stream]]:
        supply = Gas(supply_pressure, self._supply_temperature)
        forward = self._opening("A", state[0])
        backward = self._opening("B", -state[0])
        return (
            [
                self._edges["PA"].stream(forward, supply, a),
                self._edges["AR"].stream(backward, self._exhaust, a),
            ],
            [
                self._edges["PB"].stream(backward, supply, b),
                self._edges["BR"].stream(forward, self._exhaust, b),
            ],
        )

    def spool(self, state: list[float]) -> float:
        return state[0]

    def _opening(self, side: str, travel: float) -> float:
        if self._tables is None:
            opening = _clamp((travel - self._dead_zone) / (1.0 - self._dead_zone), 0.0, 1.0)
        else:
            curve = self._tables[side]
            opening = float(curve(_clamp(travel, curve.x[0], curve.x[-1])))
        return self._leakage + (1.0 - self._leakage) * opening


@dataclass(frozen=True)
class Edge:
    """A metering edge: conductance when fully open, and critical ratio."""

    conductance: float
    critical_ratio: float

    @staticmethod
    def of(parameters: Parameters, name: str) -> Edge:
        ratio = _number(parameters, f"valve.{name}.b")
        return Edge(
            _number(parameters, "valve.C") * _number(parameters, f"valve.{name}.factor"),
            _number(parameters, "valve.b") if ratio < 0.0 else ratio,
        )

    def stream(self, opening: float, outside: Gas, inside: Gas) -> Stream:
        return orifice(self.conductance * opening, self.critical_ratio, outside, inside)


def _table(parameters: Parameters, side: str) -> PchipInterpolator:
    """The openings over the spool travel that feeds a chamber."""
    places = range(1, int(_number(parameters, f"valve.table{side}.points")) + 1)
    columns = [[_number(parameters, f"valve.table{side}.{what}[{k}]") for k in places] for what in ("spool", "opening")]
    return PchipInterpolator(*columns)


class PressureRegulator(Actuator):
    """A reservoir at a regulated pressure feeds chamber A; chamber B is plugged.

    It gives no more than the pressure of its supply, which takes nothing back. The first state is the regulated
    pressure, the second is unused.
    """

    units = (1e5, 1.0)
    vents_to_surroundings = True

    def __init__(self, parameters: Parameters) -> None:
        self._low = _number(parameters, "regulator.pMin")
        self._high = _number(parameters, "regulator.pMax")
        self._tau = _number(parameters, "regulator.tau")
        self._conductance = _number(parameters, "regulator.C")
        self._critical_ratio = _number(parameters, "regulator.b")
        self._temperature = _number(parameters, "supplyTemperature")

    def command(self, voltage: float, time: float) -> float:
        return self._low + (self._high - self._low) * _clamp(voltage, 0.0, 10.0) / 10.0

    def start(self, command: float) -> tuple[float, float]:
        return command, 0.0

    def rates(self, state: list[float], command: float) -> tuple[float, float]:
        return (command - state[0]) / self._tau, 0.0

    def streams(self, state: list[float], a: Gas, b: Gas, supply_pressure: float) -> tuple[list[Stream], list[Stream]]:
        regulated = state[0]
        if regulated > supply_pressure:
            # Short of supply: from there, or nothing.
            regulated = min(regulated, max(supply_pressure, a.pressure))
        reservoir = Gas(regulated, self._temperature)
        return [orifice(self._conductance, self._critical_ratio, reservoir, a)], []

    def spool(self, state: list[float]) -> float:
        return 0.0


def _chamber(parameters: Parameters, name: str, area: float, tank_volume: float, lent_volume: float) -> Chamber:
    common = (
        area,
        _number(parameters, f"{name}.deadVolume") + tank_volume + lent_volume,
        tank_volume,
        _number(parameters, "cylinder.bore"),
        _number(parameters, f"{name}.pressure0"),
        _number(parameters, "ambientTemperature"),
    )
    match parameters["thermal.model"]:
        case "EnergyBalance":
            return EnergyBalanceChamber(*common, _number(parameters, "thermal.heatTransfer"))
        case "Isothermal":
            return PolytropicChamber(*common, 1.0)
        case "Polytropic":
            return PolytropicChamber(*common, _number(parameters, "thermal.exponent"))
        case "PolytropicServo":
            return PolytropicServoChamber(*common, _number(parameters, "thermal.exponent"))
        case other:
            raise ValueError(f"unknown thermal.model {other!r}")


def _actuator(parameters: Parameters) -> Actuator:
    match parameters["actuation"]:
        case "ProportionalValve":
            return ProportionalValve(parameters)
        case "PressureRegulator":
            return PressureRegulator(parameters)
        case "SwitchingValves":
            return SwitchingValves(parameters)
        case other:
            raise ValueError(f"unknown actuation {other!r}")


def _hardened(depth: float, clearance: float) -> float:
    """The depth at which a linear stop would push as hard; it has no bound where the chamber would have no volume."""
    half = clearance / 2.0
    return depth if depth <= half else depth + half * ((depth - half) / (clearance - depth)) ** 8


def _profile(parameters: Parameters) -> Callable[[float], float]:
    """The factor on friction over the position."""
    points = int(_number(parameters, "friction.position.points"))
    if points == 0:
        return lambda x: 1.0
    at, factors = (
        [_number(parameters, f"friction.position.{name}[{point}]") for point in range(1, points + 1)]
        for name in ("at", "factor")
    )
    curve = PchipInterpolator(at, factors)
    return lambda x: float(curve(min(max(x, at[0]), at[-1])))


def _number(parameters: Parameters, name: str) -> float:
    return float(parameters[name])


def _clamp(value: float, low: float, high: float) -> float:
    return min(max(value, low), high)
