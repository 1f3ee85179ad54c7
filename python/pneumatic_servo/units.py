"""Units that values may be given in, by name; and numbers written with one."""

from __future__ import annotations

import math
import re
from reprlib import repr as shortened
from typing import Any

AMBIENT = 101_325.0
"""Pressure of the standard atmosphere in Pa, above which bar g, kPa g and psi g count; all others are absolute."""
REFERENCE_DENSITY = 1.185
"""Density in kg/m3 of air in the standard reference atmosphere (ANR, ISO 8778: 1 bar, 20 degC, 65 % humidity)."""
POUND = 0.45359237

TO_SI: dict[str, tuple[str, float, float]] = {
    "%": ("1", 1e-2, 0.0),
    "s": ("s", 1.0, 0.0),
    "ms": ("s", 1e-3, 0.0),
    "us": ("s", 1e-6, 0.0),
    "min": ("s", 60.0, 0.0),
    "m": ("m", 1.0, 0.0),
    "cm": ("m", 1e-2, 0.0),
    "mm": ("m", 1e-3, 0.0),
    "um": ("m", 1e-6, 0.0),
    "in": ("m", 0.0254, 0.0),
    "ft": ("m", 0.3048, 0.0),
    "m2": ("m2", 1.0, 0.0),
    "cm2": ("m2", 1e-4, 0.0),
    "mm2": ("m2", 1e-6, 0.0),
    "in2": ("m2", 0.0254**2, 0.0),
    "m3": ("m3", 1.0, 0.0),
    "l": ("m3", 1e-3, 0.0),
    "cm3": ("m3", 1e-6, 0.0),
    "ml": ("m3", 1e-6, 0.0),
    "in3": ("m3", 0.0254**3, 0.0),
    "m/s": ("m/s", 1.0, 0.0),
    "mm/s": ("m/s", 1e-3, 0.0),
    "in/s": ("m/s", 0.0254, 0.0),
    "ft/s": ("m/s", 0.3048, 0.0),
    "N": ("N", 1.0, 0.0),
    "kN": ("N", 1e3, 0.0),
    "mN": ("N", 1e-3, 0.0),
    "lbf": ("N", POUND * 9.80665, 0.0),
    "N/m": ("N/m", 1.0, 0.0),
    "N/mm": ("N/m", 1e3, 0.0),
    "N/um": ("N/m", 1e6, 0.0),
    "lbf/in": ("N/m", POUND * 9.80665 / 0.0254, 0.0),
    "m/N": ("m/N", 1.0, 0.0),
    "mm/N": ("m/N", 1e-3, 0.0),
    "um/N": ("m/N", 1e-6, 0.0),
    "N.s/m": ("N.s/m", 1.0, 0.0),
    "N.s/mm": ("N.s/m", 1e3, 0.0),
    "kg": ("kg", 1.0, 0.0),
    "g": ("kg", 1e-3, 0.0),
    "t": ("kg", 1e3, 0.0),
    "lb": ("kg", POUND, 0.0),
    "Pa": ("Pa", 1.0, 0.0),
    "hPa": ("Pa", 1e2, 0.0),
    "mbar": ("Pa", 1e2, 0.0),
    "kPa": ("Pa", 1e3, 0.0),
    "MPa": ("Pa", 1e6, 0.0),
    "bar": ("Pa", 1e5, 0.0),
    "psi": ("Pa", 6894.757293168361, 0.0),
    "atm": ("Pa", 101_325.0, 0.0),
    "barg": ("Pa", 1e5, AMBIENT),
    "kPag": ("Pa", 1e3, AMBIENT),
    "psig": ("Pa", 6894.757293168361, AMBIENT),
    "Pa.s": ("Pa.s", 1.0, 0.0),
    "mPa.s": ("Pa.s", 1e-3, 0.0),
    "uPa.s": ("Pa.s", 1e-6, 0.0),
    "J/(kg.K)": ("J/(kg.K)", 1.0, 0.0),
    "Pa/s": ("Pa/s", 1.0, 0.0),
    "bar/s": ("Pa/s", 1e5, 0.0),
    "1/Pa": ("1/Pa", 1.0, 0.0),
    "1/bar": ("1/Pa", 1e-5, 0.0),
    "K": ("K", 1.0, 0.0),
    "degC": ("K", 1.0, 273.15),
    "V": ("V", 1.0, 0.0),
    "mV": ("V", 1e-3, 0.0),
    "rad": ("rad", 1.0, 0.0),
    "mrad": ("rad", 1e-3, 0.0),
    "deg": ("rad", math.pi / 180.0, 0.0),
    "rad/s": ("rad/s", 1.0, 0.0),
    "deg/s": ("rad/s", math.pi / 180.0, 0.0),
    "rpm": ("rad/s", math.pi / 30.0, 0.0),
    "N.m": ("N.m", 1.0, 0.0),
    "Nm": ("N.m", 1.0, 0.0),
    "mN.m": ("N.m", 1e-3, 0.0),
    "mNm": ("N.m", 1e-3, 0.0),
    "kg.m2": ("kg.m2", 1.0, 0.0),
    "kg.cm2": ("kg.m2", 1e-4, 0.0),
    "g.cm2": ("kg.m2", 1e-7, 0.0),
    "N.m/rad": ("N.m/rad", 1.0, 0.0),
    "N.m.s/rad": ("N.m.s/rad", 1.0, 0.0),
    "A": ("A", 1.0, 0.0),
    "mA": ("A", 1e-3, 0.0),
    "Hz": ("Hz", 1.0, 0.0),
    "kHz": ("Hz", 1e3, 0.0),
    "m3/(s.Pa)": ("m3/(s.Pa)", 1.0, 0.0),
    "dm3/(s.bar)": ("m3/(s.Pa)", 1e-8, 0.0),
    "l/(s.bar)": ("m3/(s.Pa)", 1e-8, 0.0),
    "l/(min.bar)": ("m3/(s.Pa)", 1e-8 / 60.0, 0.0),
    "kg/s": ("kg/s", 1.0, 0.0),
    "g/s": ("kg/s", 1e-3, 0.0),
    "l/min(ANR)": ("kg/s", REFERENCE_DENSITY * 1e-3 / 60.0, 0.0),
    # Cubic feet of air of 0.075 lb/ft3 (68 degF, 14.7 psi, 36 % humidity).
    "SCFM": ("kg/s", 0.075 * POUND / 60.0, 0.0),
}
"""The SI unit of each, and factor and offset to it: ``factor * value + offset``. Another name is refused."""

SPELLINGS = {
    " ": "",
    "(g)": "g",
    "\u00b5": "u",
    "\u03bc": "u",
    "\u00b2": "2",
    "\u00b3": "3",
    "\u00b0": "deg",
    "\u00b7": ".",
    "*": ".",
}
"""Other spellings of units in names."""

NUMBER = re.compile(r"\s*([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)\s*(.*?)\s*", re.DOTALL)


def scale(unit: str, si: str, where: str) -> tuple[float, float]:
    """Return factor and offset from a unit to an SI unit; `where` begins the message of an error."""
    name = unit.strip()
    for other, own in SPELLINGS.items():
        name = name.replace(other, own)
    if name == si:
        return 1.0, 0.0
    known, factor_, offset = TO_SI.get(name, ("", 0.0, 0.0))
    if known != si:
        of = units_of(si)
        near = next((f"did you mean {own}? " for own in of if own.lower() == name.lower()), "")
        raise ValueError(f"{where}: the unit {unit} is refused; {near}it must be one of {', '.join(of)}")
    return factor_, offset


def factor(unit: str, si: str, where: str) -> float:
    """Return the factor from a unit to an SI unit; `where` begins the message of an error."""
    return scale(unit, si, where)[0]


def to_si(value: float, unit: str, si: str, where: str) -> float:
    """Return a value in an SI unit."""
    times, offset = scale(unit, si, where)
    # 250 mm are 250/1000 m, which is 0.25; 250 times 1e-3 is not.
    inverse = round(1.0 / times)
    is_exact = times < 1.0 and math.isclose(inverse * times, 1.0, rel_tol=1e-14)
    return (value / inverse if is_exact else value * times) + offset


def units_of(si: str) -> list[str]:
    """Return the units that values of an SI unit may have, it first."""
    return [si, *(name for name, (of, _, _) in TO_SI.items() if of == si and name != si)]


def in_unit(si: str) -> str:
    """Return the end of a sentence about a number: the unit that it has to be in, if there is one."""
    return "" if si == "1" else f" in {si}"


def written(text: str, si: str, where: str, *, is_bare_allowed: bool = False) -> float:
    """Return the value in an SI unit of a text as ``6 bar``."""
    match = NUMBER.fullmatch(text)
    comma = re.fullmatch(r"\s*([-+]?\d+),(\d+)(.*)", text)
    if match is None or comma is not None:
        hint = f"; did you mean {comma[1]}.{comma[2]}{comma[3]}?" if comma else ""
        raise ValueError(f"{where}: {text!r} is no number{in_unit(si)}{hint}")
    if not match[2]:
        if is_bare_allowed:
            return float(match[1])
        with_unit = "" if si == "1" else f" or '{text.strip()} {si}'"
        raise ValueError(f"{where}: the text {text!r} has no unit; write {text.strip()}{with_unit}")
    return to_si(float(match[1]), match[2], si, where)


def has_unit(given: object) -> bool:
    """Tell whether something is a number with a unit: ``"6 bar"``, ``(6, "bar")``, or a quantity of pint."""
    if isinstance(given, str):
        match = NUMBER.fullmatch(given)
        return match is not None and bool(match[2])
    return (isinstance(given, tuple) and len(given) == 2 and isinstance(given[1], str)) or is_quantity(given)


def is_quantity(given: object) -> bool:
    """Tell whether something is a quantity of pint."""
    return hasattr(given, "magnitude") and hasattr(given, "to") and hasattr(given, "units")


def magnitude(given: Any, si: str, where: str) -> Any:
    """Return the number, or array of numbers, of a quantity of pint in an SI unit."""
    # For N.s/m and kg/(s.Pa2) of the table, pint reads N*s/m and kg/(s*Pa**2).
    name = "" if si == "1" else re.sub(r"(?<=[A-Za-z])(\d)", r"**\1", si.replace(".", "*"))
    try:
        return given.to(name).magnitude
    except Exception as error:
        raise ValueError(f"{where} = {shortened(given)} is refused: it must be in {si} ({error})") from None
