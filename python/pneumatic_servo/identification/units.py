"""Units that columns and options may be in, by name."""

from __future__ import annotations

SI = {
    "s": ("s", 1.0),
    "ms": ("s", 1e-3),
    "m": ("m", 1.0),
    "mm": ("m", 1e-3),
    "um": ("m", 1e-6),
    "m/s": ("m/s", 1.0),
    "mm/s": ("m/s", 1e-3),
    "N": ("N", 1.0),
    "kN": ("N", 1e3),
    "Pa": ("Pa", 1.0),
    "kPa": ("Pa", 1e3),
    "MPa": ("Pa", 1e6),
    "bar": ("Pa", 1e5),
    "V": ("V", 1.0),
    "mV": ("V", 1e-3),
}
"""The SI unit of each, and the factor to it. Nothing is guessed: another name is refused."""


def factor(unit: str, si: str, where: str) -> float:
    """Return what values in a unit are multiplied with to be in an SI unit; `where` begins the message of an error."""
    known, scale = SI.get(unit, ("", 0.0))
    if known != si:
        legal = ", ".join(name for name, (of, _) in SI.items() if of == si)
        raise ValueError(f"{where}: the unit {unit} is refused; it must be one of {legal}")
    return scale
