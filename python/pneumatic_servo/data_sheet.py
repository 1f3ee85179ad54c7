"""From the numbers of data sheets to the parameters of the cylinder.

Every parameter comes with the formula it follows from, the standard that defines the number, and what is assumed
where a data sheet says nothing.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import cache
from itertools import groupby
from pathlib import Path
from typing import Any

from pneumatic_servo.effects import LAW
from pneumatic_servo.gases import AIR
from pneumatic_servo.model_description import ModelDescription
from pneumatic_servo.units import REFERENCE_DENSITY, has_unit
from pneumatic_servo.values import is_number, number_in
from pneumatic_servo.variables import Variable, Variables

AMBIENT = 101_325.0
"""Ambient pressure in Pa, by which pressures above ambient become absolute."""
NOMINAL = (6e5 + AMBIENT, 5e5 + AMBIENT)
"""Absolute pressures in Pa before and behind a valve at which its nominal flow is stated."""
NOZZLE = math.pow(2.0 / (AIR.heat_ratio + 1.0), AIR.heat_ratio / (AIR.heat_ratio - 1.0))
"""Critical pressure ratio of an ideal nozzle, 0.528."""
TEMPERATURE = 293.15
WATER_DENSITY = 1000.0
KV_OF_CV = 3.785411784e-3 * 60.0 / math.sqrt(6894.757 / 1e5)
"""Kv in m3/h of a Cv of 1 US gallon per minute at 1 psi."""


@dataclass(frozen=True)
class Entry:
    """A parameter with its value in SI units, and where it comes from."""

    name: str
    value: float
    formula: str
    standard: str = ""
    assumption: str = ""


@dataclass(frozen=True, kw_only=True)
class DataSheet:
    """Data of a cylinder, its valve, its hoses and its load, in the units of data sheets or with their own.

    A number has the unit below, a text its own: ``bore="1.25 in"``, ``qn="25 SCFM"``, ``supply="87 psig"``. Pressures
    are above ambient: ``barg``, ``kPag`` or ``psig``.

    Every run takes it in place of parameters. Friction is stated for all laws that have static or Coulomb friction;
    `kept` is what no data sheet states, and stays as on the small rig.

    Attributes
    ----------
    bore, rod, rod_a, stroke : float
        Diameters and stroke in mm; ``rod_a`` is a second rod through chamber A.
    mass : float
        Moving mass in kg.
    qn : float, optional
        Nominal flow of the valve in l/min (ANR), from 6 to 5 bar above ambient.
    kv, cv : float, optional
        Flow of water in m3/h at 1 bar, or in US gallons per minute at 1 psi.
    conductance : float, optional
        Sonic conductance in dm3/(s bar).
    area : float, optional
        Effective area of the open valve in mm2, discharge coefficient included.
    critical_ratio : float, optional
        Critical pressure ratio of the valve; by default 0.3, or with an `area` 0.528, as of a nozzle.
    hysteresis : float, optional
        Hysteresis of the valve in % of its whole range of commands.
    hose : tuple of float or str, optional
        Inner diameter and length in mm of the hoses to both chambers: ``(4, 1500)`` or ``"4x1500"``.
    clearance : float
        Length in mm of bore that stands for the dead volume at each end.
    min_pressure : float, optional
        Pressure in bar above ambient at which the maker says that the unloaded piston starts to move.
    supply : float, optional
        Supply pressure in bar above ambient.
    spring : tuple of float, optional
        Force in N of a spring that retracts the piston, retracted and extended: ``(20, 60)``. Chamber B, where it is,
        is open to the surroundings, without hose and leak.
    leak : tuple of float, optional
        Leakage of each chamber in l/min (ANR) at a pressure in bar above ambient, at least 1: ``(0.2, 6)``.
    response : float, optional
        Time in ms in which the spool of the valve goes from 10 to 90 % of a step.
    cushion : tuple of float or str, optional
        Length in mm of adjustable end cushions, and sonic conductance in dm3/(s bar) of the needle as it is set:
        ``(20, 0.2)``.
    bumper : float, optional
        Stiffness in N/mm of elastic bumpers at both ends, or of the stops.
    rebound : tuple of float or str, optional
        Rebound resilience in % of the bumpers (ISO 4662), the share of the energy that comes back, and the speed in
        m/s of the blow that had it: ``(45, 0.5)``.
    rotates : bool
        Whether the numbers describe a rotary drive, as `rotary` sets them: bore, stroke and mass then stand for
        displacement, angle and inertia, 1 m for 1 rad.

    Examples
    --------
    >>> import pneumatic_servo as ps
    >>> sheet = ps.DataSheet(bore=32, rod=12, stroke=200, mass=5, qn=700, supply=6)
    >>> round(sheet.settings["supplyPressure"])
    701325
    >>> run = ps.Model().simulate(sheet, inputs={"valveVoltage": 6}, stop=0.1)
    """

    bore: float
    stroke: float
    mass: float
    rod: float = 0.0
    rod_a: float = 0.0
    qn: float | None = None
    kv: float | None = None
    cv: float | None = None
    conductance: float | None = None
    area: float | None = None
    critical_ratio: float | None = None
    hysteresis: float | None = None
    hose: tuple[float, float] | str | None = None
    clearance: float = 5.0
    min_pressure: float | None = None
    supply: float | None = None
    spring: tuple[float, float] | None = None
    leak: tuple[float, float] | None = None
    response: float | None = None
    cushion: tuple[float | str, float | str] | None = None
    bumper: float | None = None
    rebound: tuple[float | str, float | str] | None = None
    rotates: bool = False

    @classmethod
    def rotary(cls, displacement: float, angle: float, inertia: float, **others: Any) -> DataSheet:
        """Return the sheet of a rotary drive, a vane or a rack and pinion: 1 rad takes the place of 1 m.

        The equations are the same, with torques for forces: ``frictionForce``, ``rodForce`` and ``externalForce`` are
        in N.m, ``position`` is in rad, ``mass.moving`` in kg.m2, and friction parameters are torques.

        Parameters
        ----------
        displacement : float
            Volume in cm3 that a chamber takes per rad, or with a unit of volume.
        angle : float
            Angle of rotation in degrees, or with a unit.
        inertia : float
            Moment of inertia in kg.m2 of all that turns, or with a unit.
        **others
            The rest of the sheet. ``clearance`` is an angle in mrad that stands for the dead volume, by default 5 % of
            the whole.

        Examples
        --------
        >>> import pneumatic_servo as ps
        >>> drive = ps.DataSheet.rotary(20, 180, 0.02, qn=200, supply=6)
        >>> round(drive.settings["cylinder.stroke"], 4)
        3.1416
        """
        given = {"displacement": displacement, "angle": angle, "inertia": inertia}
        given = {name: _in_own_unit(name, value) for name, value in given.items()}
        displacement, angle, inertia = given.values()
        for name, value in given.items():
            if not (is_number(value) and math.isfinite(value) and value > 0.0):
                raise ValueError(f"{name} = {value!r} is refused: it must be a positive number in {ROTARY[name]}")
        sized = {"bore", "rod", "rod_a", "stroke", "mass", "rotates"} & set(others)
        if sized:
            raise TypeError(
                f"{sorted(sized)[0]} is refused: displacement, angle and inertia say what a rotary drive is"
            )
        bore = 2e3 * math.sqrt(displacement * 1e-6 / math.pi)
        stroke = math.radians(angle) * 1e3
        return cls(**{"clearance": 0.05 * stroke, **others}, bore=bore, stroke=stroke, mass=inertia, rotates=True)

    def __post_init__(self) -> None:
        for name in UNITS:
            object.__setattr__(self, name, _in_own_unit(name, getattr(self, name)))
        for name, parts in PAIRS.items():
            value = getattr(self, name)
            if isinstance(value, tuple | list) and len(value) == 2:
                pair = tuple(_in_own_unit(part, one, name) for part, one in zip(parts, value, strict=True))
                object.__setattr__(self, name, pair)
        self._check_numbers()
        given = [name for name in FLOWS if getattr(self, name) is not None]
        if len(given) != 1:
            raise ValueError(f"the flow of the valve is given by exactly one of {', '.join(FLOWS)}, not by {given}")
        numbers = [
            ("bore", self.bore),
            ("stroke", self.stroke),
            ("mass", self.mass),
            (given[0], getattr(self, given[0])),
        ]
        numbers += [
            (name, getattr(self, name))
            for name in ("min_pressure", "supply", "bumper")
            if getattr(self, name) is not None
        ]
        for name, value in numbers:
            if not (math.isfinite(value) and value > 0.0):
                raise ValueError(f"{name} = {value}: it must be positive")
        self._check_magnitudes()
        if self.min_pressure and self.supply and self.min_pressure >= self.supply:
            raise ValueError(
                f"min_pressure = {self.min_pressure} bar: the piston never moves at supply = {self.supply} bar"
            )
        if self.clearance > self.stroke:
            raise ValueError(f"clearance = {self.clearance} mm: it must be shorter than the stroke, {self.stroke} mm")
        for name in ("rod", "rod_a", "clearance"):
            value = getattr(self, name)
            if not (math.isfinite(value) and value >= 0.0):
                raise ValueError(f"{name} = {value}: it must not be negative")
        for name in ("rod", "rod_a"):
            if not getattr(self, name) < self.bore:
                raise ValueError(f"{name} = {getattr(self, name)}: it must be smaller than the bore, {self.bore}")
        if self.critical_ratio is not None and not 0.0 <= self.critical_ratio < 1.0:
            raise ValueError(f"critical_ratio = {self.critical_ratio}: it must be at least 0 and below 1")
        if self.hysteresis is not None and not 0.0 <= self.hysteresis < 50.0:
            raise ValueError(f"hysteresis = {self.hysteresis} %: it must be at least 0 and below 50")
        if self.response is not None and not 0.0342 <= self.response <= 3420.0:
            raise ValueError(f"response = {self.response} ms: it must be from 0.0342 to 3420 ms")
        self._check_pairs()

    def _check_pairs(self) -> None:
        """Refuse a spring that pulls, a leak that is not choked, a cushion beyond the stroke, a blow that gains."""
        if self.cushion is not None:
            length, conductance = _pair("cushion", self.cushion, "a length in mm and a conductance in dm3/(s.bar)")
            if not (0.0 < length <= self.stroke and conductance > 0.0):
                raise ValueError(
                    f"cushion = {self.cushion!r}: its length must be above 0 and at most the stroke, {self.stroke:g} "
                    "mm, the conductance of its needle above 0"
                )
        if self.rebound is not None:
            resilience, speed = _pair("rebound", self.rebound, "a rebound resilience in % and a speed in m/s")
            if not (0.0 < resilience <= 100.0 and speed > 0.0):
                raise ValueError(
                    f"rebound = {self.rebound!r}: its resilience must be above 0 and at most 100 %, its speed above 0"
                )
        if self.spring is not None:
            retracted, extended = _pair("spring", self.spring, "forces in N, retracted and extended")
            if not 0.0 <= retracted < extended:
                raise ValueError(
                    f"spring = {self.spring!r}: its force must be at least 0 and grow as the piston extends"
                )
        if self.leak is not None:
            flow, pressure = _pair("leak", self.leak, "a flow in l/min and a pressure in bar above ambient")
            if not (flow >= 0.0 and pressure >= 1.0):
                raise ValueError(
                    f"leak = {self.leak!r}: its flow must not be negative, its pressure at least 1 bar above ambient, "
                    "where it is choked"
                )

    def _check_numbers(self) -> None:
        """Refuse a value that is no number, by the name of its field."""
        for name, unit in UNITS.items():
            value = getattr(self, name)
            if value is not None and not is_number(value):
                where = f" in {unit}" if unit else ""
                raise ValueError(f"{name} = {value!r} is refused: it must be a number{where}")
        if self.hose is not None:
            diameter, length = _hose(self.hose)
            (least, most), (shortest, longest) = HOSES
            if not (least <= diameter <= most and shortest <= length <= longest):
                as_m = diameter if diameter >= least else 1e3 * diameter, 1e3 * length
                is_meant = least <= as_m[0] <= most and shortest <= as_m[1] <= longest and length < shortest
                hint = f"; did you mean {as_m[0]:g}x{as_m[1]:g}, which is {length:g} m long?" if is_meant else ""
                raise ValueError(
                    f"hose = {self.hose!r} is refused: it is an inner diameter of {least:g} to {most:g} mm and a "
                    f"length of {shortest:g} to {longest:g} mm{hint}"
                )

    def _check_magnitudes(self) -> None:
        """Refuse a value in another unit than data sheets use."""
        for name, (low, high, unit, meant) in MAGNITUDES.items():
            value = getattr(self, name)
            low = ROTARY_BORE if name == "bore" and self.rotates else low
            if value is not None and not low <= value <= high:
                si, factor = meant
                hint = f"; did you give it in {si}? that would be {value * factor:g} {unit}"
                is_meant = low <= value * factor <= high
                raise ValueError(
                    f"{name} = {value:g} {unit} is refused: it must be from {low:g} to {high:g} {unit}"
                    + (hint if is_meant else "")
                )

    @property
    def kept(self) -> dict[str, float]:
        """Parameters not in the data, which keep the values of the small rig, the defaults."""
        names = [
            *(name for name in KEPT if name not in self._stated()),
            *(() if self.min_pressure else (own.name for own in _of_meaning("static friction", "Coulomb friction"))),
            *(() if self.supply else ("supplyPressure",)),
            *(() if self.hose else ("hoseA.length", "hoseB.length")),
        ]
        variables = _variables()
        return {name: float(variables[name].default or 0.0) for name in names}

    def _stated(self) -> set[str]:
        """Return the stated ones of the quantities that sheets seldom state."""
        stated = {"valve.hysteresis": self.hysteresis, "valve.bandwidth": self.response}
        return {name for name, value in stated.items() if value is not None}

    @property
    def settings(self) -> dict[str, float]:
        """The parameters by name, in SI units, as every run takes them."""
        return {entry.name: entry.value for entry in self.entries()}

    def to_ssv(self, file: str | Path) -> None:
        """Write the parameters as a set of values that tools load into the FMU; `read_ssv` reads it."""
        from pneumatic_servo.files import check_ending, write
        from pneumatic_servo.model import Model
        from pneumatic_servo.ssv import ssv

        check_ending(Path(file), ".ssv", ".xml")
        text = ssv(Path(file).stem, "Parameters from data sheets", Model(), self.settings)
        write(Path(file), lambda part: part.write_text(text, encoding="utf-8"))

    def entries(self) -> Iterator[Entry]:
        """Yield the parameters, and the supply pressure if it is given."""
        formula = "2*sqrt(displacement per rad/pi)" if self.rotates else "bore"
        yield Entry("cylinder.bore", self.bore * 1e-3, formula)
        yield Entry("cylinder.rod", self.rod * 1e-3, "rod")
        if self.rod_a > 0.0:
            yield Entry("cylinder.rodA", self.rod_a * 1e-3, "second rod")
        formula = "angle in rad" if self.rotates else "stroke"
        yield Entry("cylinder.stroke", self.stroke * 1e-3, formula)
        yield Entry("position0", self.stroke * 0.5e-3, "stroke/2", assumption="the run starts in the middle")
        yield Entry("mass.moving", self.mass, "inertia in kg.m2" if self.rotates else "mass")
        yield Entry("mass.carriage", self.mass, "mass", assumption="the mass of piston and rod is small beside it")
        yield self._flow()
        stated = self.critical_ratio is not None or self.conductance is not None
        usual = "the value of a nozzle" if self.area is not None else "the usual value of valves"
        yield Entry("valve.b", self._ratio, "b", "ISO 6358", "" if stated else usual)
        if self.hysteresis is not None:
            formula = "hysteresis/100: half of its width, of commands from -1 to 1"
            yield Entry("valve.hysteresis", self.hysteresis * 1e-2, formula)
        if self.response is not None:
            formula = "0.342/(time from 10 to 90 %)"
            assumption = "a lag of second order with the damping ratio 0.71"
            yield Entry("valve.bandwidth", 342.0 / self.response, formula, assumption=assumption)
        yield from self._dead_volumes()
        if self.hose is not None:
            diameter, length = _hose(self.hose)
            for side in self._closed_chambers:
                yield Entry(f"hose{side}.diameter", diameter * 1e-3, "inner diameter of the hose")
                yield Entry(
                    f"hose{side}.length", length * 1e-3, "length of the hose", assumption="both hoses are alike"
                )
        if self.min_pressure is not None:
            yield from self._friction(self.min_pressure)
        if self.spring is not None:
            least, most = self.spring
            stiffness = (most - least) / (self.stroke * 1e-3)
            yield Entry("load.stiffness", stiffness, "(F extended - F retracted)/stroke")
            yield Entry("load.rest", -least / stiffness, "-F retracted/stiffness")
            yield Entry("chamberB.open", 1.0, "single-acting", assumption="the chamber of the spring is vented")
        if self.cushion is not None:
            length, conductance = _pair("cushion", self.cushion, "")
            yield Entry("cushion.length", length * 1e-3, "length of the cushion", assumption="both ends are alike")
            yield Entry("cushion.C", conductance * 1e-8, "C of the needle, 1 dm3/(s.bar) = 1e-8 m3/(s.Pa)", "ISO 6358")
        if self.bumper is not None:
            yield Entry("cylinder.stopStiffness", self.bumper * 1e3, "stiffness", assumption="both ends are alike")
        if self.rebound is not None:
            resilience, speed = _pair("rebound", self.rebound, "")
            formula = "c, by e = sqrt(resilience/100) and c*v*(1 + e) = ln((1 + c*v)/(1 - e*c*v))"
            damping = stop_damping(math.sqrt(resilience * 1e-2), speed)
            yield Entry("cylinder.stopDamping", damping, formula, "ISO 4662", "no other force acts during the blow")
        if self.leak is not None:
            flow, pressure = self.leak
            conductance = flow / 60_000.0 / (pressure * 1e5 + AMBIENT)
            for side in self._closed_chambers:
                yield Entry(
                    f"chamber{side}.leakage", conductance, "C = q/p", "ISO 6358", "choked; both chambers are alike"
                )
        if self.supply is not None:
            formula = "supply + p_atm"
            yield Entry("supplyPressure", self.supply * 1e5 + AMBIENT, formula, assumption="p_atm = 1.01325 bar")

    @property
    def _closed_chambers(self) -> str:
        """The chambers with a port: a single-acting cylinder has none where its spring is."""
        return "AB" if self.spring is None else "A"

    def _flow(self) -> Entry:
        given = next(name for name in FLOWS if getattr(self, name) is not None)
        formula, standard, assumption, conductance = FLOWS[given]
        return Entry("valve.C", conductance(getattr(self, given), self._ratio), formula, standard, assumption)

    @property
    def _ratio(self) -> float:
        """The critical pressure ratio of the valve."""
        if self.critical_ratio is not None:
            return self.critical_ratio
        return NOZZLE if self.area is not None else 0.3

    def _dead_volumes(self) -> Iterator[Entry]:
        of = "mrad" if self.rotates else "mm of the bore"
        for side, rod in (("A", self.rod_a), ("B", self.rod)):
            volume = math.pi / 4.0 * (self.bore**2 - rod**2) * self.clearance * 1e-9
            yield Entry(
                f"chamber{side}.deadVolume",
                volume,
                "piston area times clearance",
                assumption=f"{self.clearance:g} {of} stand for cover and port",
            )

    def _friction(self, pressure: float) -> Iterator[Entry]:
        force = pressure * 1e5 * math.pi / 4.0 * (self.bore**2 - self.rod_a**2) * 1e-6
        assumption = "chamber B is vented, the piston unloaded"
        for own in _of_meaning("static friction"):
            yield Entry(own.name, force, "minimum pressure times piston area", assumption=assumption)
        ratio = "the ratio of the default set, 8.3 N to 11 N"
        for own in _of_meaning("Coulomb friction"):
            yield Entry(own.name, 0.75 * force, "3/4 Fs", assumption=ratio)
        for own in _of_meaning("static excess"):
            yield Entry(own.name, 0.25 * force, "Fs - Fc", assumption=ratio)


@cache
def _variables() -> Variables:
    return ModelDescription("PneumaticServoCylinder").variables


def _of_meaning(*meanings: str) -> list[Variable]:
    """Return the friction parameters of meanings, in N, the default law first."""
    law = _variables()[LAW].default
    found = [
        own for own in _variables().values() if own.meaning in meanings and own.unit == "N" and "[" not in own.name
    ]
    return sorted(found, key=lambda own: own.counts_for != (LAW, law))


def laws_without_levels() -> list[str]:
    """Return the laws that have neither static nor Coulomb friction among their parameters."""
    having = {"None"} | {
        own.counts_for[1] for own in _of_meaning("static friction", "Coulomb friction") if own.counts_for
    }
    return [law for law in _variables()[LAW].items if law not in having]


def _hose(given: tuple[float, float] | str) -> tuple[float, float]:
    """Return inner diameter and length in mm."""
    try:
        diameter, length = given.lower().split("x") if isinstance(given, str) else given
        diameter, length = (_in_own_unit("bore", part, "hose") for part in (diameter, length))
        return float(diameter), float(length)
    except (TypeError, ValueError):
        raise ValueError(
            f"hose = {given!r} is refused: it must be inner diameter and length in mm, (4, 1500) or '4x1500'"
        ) from None


def _in_own_unit(name: str, given: Any, where: str = "") -> Any:
    """Return a number in the unit of data sheets, of one that has a unit; all else as it is."""
    if not has_unit(given) or name not in IN_SI:
        return given
    si, factor = IN_SI[name]
    if si == "Pa":
        _refuse_absolute(where or name, given)
        return factor * (number_in(si, where or name, given) - AMBIENT)
    if si == "kg/s" and isinstance(given, str) and given.replace(" ", "").endswith("l/min"):
        given = f"{given}(ANR)"
    return factor * number_in(si, where or name, given)


def _refuse_absolute(name: str, given: Any) -> None:
    """Refuse a pressure in a unit that counts from vacuum: sheets state pressures above ambient."""
    parts = (
        given.split() if isinstance(given, str) else [str(part) for part in given] if isinstance(given, tuple) else []
    )
    unit = "".join(parts[1:]) or (parts[0].lstrip("+-.0123456789") if parts else "")
    if unit in ("bar", "kPa", "psi"):
        raise ValueError(
            f"{name} = {given!r} is refused: a pressure of a sheet is above ambient, and {unit} is absolute; write "
            f"{unit}g, or give the model supplyPressure"
        )


def _pair(name: str, given: object, what: str) -> tuple[float, float]:
    """Return two finite numbers; `what` they are is told where they are none."""
    if isinstance(given, tuple | list) and len(given) == 2 and all(is_number(one) for one in given):
        first, second = (float(one) for one in given)
        if math.isfinite(first) and math.isfinite(second):
            return first, second
    raise ValueError(f"{name} = {given!r} is refused: it must be {what}")


UNITS = {
    "bore": "mm", "stroke": "mm", "mass": "kg", "rod": "mm", "rod_a": "mm", "qn": "l/min", "kv": "m3/h",
    "cv": "gal/min", "conductance": "dm3/(s.bar)", "area": "mm2", "critical_ratio": "", "hysteresis": "%",
    "clearance": "mm", "min_pressure": "bar above ambient", "supply": "bar above ambient", "response": "ms",
    "bumper": "N/mm",
}  # fmt: skip
"""Units of the numbers."""

IN_SI = {
    **dict.fromkeys(("bore", "stroke", "rod", "rod_a", "clearance"), ("m", 1e3)),
    "mass": ("kg", 1.0), "conductance": ("m3/(s.Pa)", 1e8), "area": ("m2", 1e6), "hysteresis": ("1", 1e2),
    "bumper": ("N/m", 1e-3), "speed": ("m/s", 1.0), "critical_ratio": ("1", 1.0),
    "response": ("s", 1e3), "force": ("N", 1.0), "qn": ("kg/s", 6e4 / REFERENCE_DENSITY),
    **dict.fromkeys(("min_pressure", "supply"), ("Pa", 1e-5)),
    "displacement": ("m3", 1e6), "angle": ("rad", 180.0 / math.pi), "inertia": ("kg.m2", 1.0),
}  # fmt: skip
"""The SI unit of numbers that may have a unit, and the factor from it to the unit of sheets."""

PAIRS = {
    "hose": ("bore", "stroke"), "spring": ("force", "force"), "leak": ("qn", "supply"),
    "cushion": ("stroke", "conductance"), "rebound": ("hysteresis", "speed"),
}  # fmt: skip
"""Meanings of the two numbers of a pair."""

ROTARY = {"displacement": "cm3 per rad", "angle": "degrees", "inertia": "kg.m2"}
"""Units of the data of a rotary drive."""
ROTARY_BORE = 0.1
"""Bore in mm that the least displacement of a rotary drive stands for, 0.008 cm3 per rad."""

HOSES = (0.5, 100.0), (20.0, 1e5)
"""Inner diameters and lengths of hoses in mm."""

KEPT = (
    "friction.stribeck.sigma2", "friction.stribeck.vs", "valve.deadZone", "valve.leakage", "valve.bandwidth",
    "valve.hysteresis", "chamberA.pressure0", "chamberB.pressure0", "thermal.heatTransfer",
)  # fmt: skip
"""Quantities that data sheets seldom state; viscous friction and Stribeck velocity apply to all laws."""

MAGNITUDES: dict[str, tuple[float, float, str, tuple[str, float]]] = {
    "bore": (1.0, 1000.0, "mm", ("m", 1e3)),
    "area": (1e-3, 1e4, "mm2", ("m2", 1e6)),
    "conductance": (1e-3, 1e3, "dm3/(s.bar)", ("m3/(s.Pa)", 1e8)),
    "stroke": (1.0, 20_000.0, "mm", ("m", 1e3)),
    "supply": (0.1, 100.0, "bar", ("Pa", 1e-5)),
    "min_pressure": (1e-4, 20.0, "bar", ("Pa", 1e-5)),
}
"""Data of machines, in the units of data sheets, and the unit and factor in SI units."""


def nominal_flow(conductance: float, critical_ratio: float) -> float:
    """Return the flow in m3/s (ANR) from 6 to 5 bar above ambient through a sonic conductance in m3/(s Pa)."""
    before, behind = NOMINAL
    beyond = max(behind / before - critical_ratio, 0.0) / (1.0 - critical_ratio)
    return conductance * before * math.sqrt(1.0 - beyond * beyond)


def stop_damping(restitution: float, speed: float) -> float:
    """Return the dissipation coefficient in s/m of a stop that throws a mass back with a share of its speed.

    A force ``k*p*(1 + c*dp/dt)`` takes the energy ``integral of v/(1 + c*v) dv`` on the way in and gives it back on the
    way out: ``c*v - ln(1 + c*v) = -c*e*v - ln(1 - c*e*v)`` for a speed v in m/s and the coefficient of restitution e,
    whatever mass and stiffness. The law is that of Hunt and Crossley (1975), ASME J. Applied Mechanics 42(2):440-445.
    """
    if restitution == 1.0:
        return 0.0
    low, high = 0.0, 1.0 / restitution
    while (middle := 0.5 * (low + high)) not in (low, high):
        gains = middle * (1.0 + restitution) > math.log1p(middle) - math.log1p(-restitution * middle)
        low, high = (middle, high) if gains else (low, middle)
    return middle / speed


def _of_nominal_flow(qn: float, critical_ratio: float) -> float:
    return qn / 60_000.0 / nominal_flow(1.0, critical_ratio)


def _of_kv(kv: float, critical_ratio: float) -> float:
    before, behind = NOMINAL
    density = behind / (AIR.constant * TEMPERATURE)
    # Water loses 1 bar at Kv; other fluids in proportion to their density.
    mass_flow = kv / 3600.0 * math.sqrt((before - behind) / 1e5 * WATER_DENSITY * density)
    return _of_nominal_flow(mass_flow / REFERENCE_DENSITY * 60_000.0, critical_ratio)


def _of_cv(cv: float, critical_ratio: float) -> float:
    return _of_kv(cv * KV_OF_CV, critical_ratio)


def _of_area(area: float, critical_ratio: float) -> float:
    """Return C: the choked flow of a nozzle is p*A*sqrt(gamma/(R*T0))*(2/(gamma + 1))^((gamma + 1)/(2*(gamma - 1)))."""
    gamma = AIR.heat_ratio
    choked = math.sqrt(gamma / (AIR.constant * TEMPERATURE))
    choked *= math.pow(2.0 / (gamma + 1.0), (gamma + 1.0) / (2.0 * (gamma - 1.0)))
    return area * 1e-6 * choked / REFERENCE_DENSITY


def _of_conductance(conductance: float, critical_ratio: float) -> float:
    return conductance * 1e-8


_WATER = "flow of air from 6 to 5 bar above ambient as of water, with the density of the air behind the valve"

FLOWS: dict[str, tuple[str, str, str, Callable[[float, float], float]]] = {
    "qn": (
        "C = qn/(p1*sqrt(1 - ((p2/p1 - b)/(1 - b))^2))",
        "ISO 6358, ISO 8778 (ANR)",
        "p1, p2 = 6 and 5 bar above 1.01325 bar, 20 degC",
        _of_nominal_flow,
    ),
    "kv": ("qn = Kv*sqrt(1000 kg/m3*rho2*dp/1 bar)/rho0, C from qn", "ISO 6358, ISO 8778 (ANR)", _WATER, _of_kv),
    "cv": ("Kv = 0.865*Cv, C from Kv", "ISO 6358, ISO 8778 (ANR)", _WATER, _of_cv),
    "conductance": ("C, 1 dm3/(s.bar) = 1e-8 m3/(s.Pa)", "ISO 6358", "", _of_conductance),
    "area": ("C = A*1.992e-3 m/(s.Pa)", "choked flow of a nozzle", "the area has its discharge coefficient", _of_area),
}
"""Ways in which data sheets state the flow of a valve: formula, standard, assumption, and the conductance."""


def table(entries: Sequence[Entry], unit: Callable[[str], str]) -> str:
    """Return the entries as a text, with the units of the variables; laws of one value share a line."""
    lines = []
    for _, group in groupby(entries, key=lambda entry: (entry.value, entry.formula, entry.assumption)):
        first, *others = list(group)
        shared = f" (and of {len(others)} parameters of other laws)" if others and "friction." in first.name else ""
        listed = [first] if shared else [first, *others]
        lines += [f"{entry.name} = {entry.value:.6g} {unit(entry.name)}".rstrip() + shared for entry in listed]
        lines.append(f"    {first.formula}" + (f"   [{first.standard}]" if first.standard else ""))
        if first.assumption:
            lines.append(f"    assumed: {first.assumption}")
    return "\n".join(lines)


def kept_table(sheet: DataSheet, unit: Callable[[str], str]) -> str:
    """Return the values that are kept from the small rig, as a text."""
    kept = {name: value for name, value in sheet.kept.items() if not name.startswith("friction.") or name in FIRST}
    lines = [f"{name} = {value:.6g} {unit(name)}".rstrip() for name, value in kept.items()]
    laws = ", ".join(laws_without_levels())
    return "\n".join([
        "not stated, and as on the small rig (cylinder.bore = 16 mm) unless you set it:",
        *(f"    {line}" for line in lines),
        "    chambers start vented: with the rod side filled a motion begins slower; set chamberB.pressure0",
        f"    the friction of {laws}, which have no static or Coulomb friction to state",
    ])  # fmt: skip


FIRST = ("friction.stribeck.Fs", "friction.stribeck.Fc", "friction.stribeck.sigma2", "friction.stribeck.vs")
"""Friction parameters of one law that represent all laws."""
