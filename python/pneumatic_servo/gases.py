"""Gases that a cylinder may be filled with."""

from __future__ import annotations

from typing import NamedTuple

from pneumatic_servo.names import did_you_mean


class _Gas(NamedTuple):
    """Specific gas constant in J/(kg K), ratio of specific heats, and viscosity in Pa s."""

    constant: float
    heat_ratio: float
    viscosity: float


AIR = _Gas(287.05, 1.4, 1.813e-5)
"""Dry air, the default of all runs."""
GASES = {
    "air": AIR,
    "nitrogen": _Gas(296.80, 1.40, 1.76e-5),
    "oxygen": _Gas(259.84, 1.40, 2.03e-5),
    "argon": _Gas(208.13, 1.67, 2.23e-5),
    "helium": _Gas(2077.3, 1.67, 1.96e-5),
    "hydrogen": _Gas(4124.2, 1.41, 8.8e-6),
    "carbon dioxide": _Gas(188.92, 1.29, 1.47e-5),
}
"""Gas constants from molar masses; the others at 20 degC and 1 bar. Viscosities of all but air: M. L. Huber and
A. H. Harvey, Viscosity of gases, CRC Handbook of Chemistry and Physics."""
CONSTANT = "gas.R"


def gas(name: str) -> dict[str, float]:
    """Return the parameters of a gas in the cylinder, its valve and its lines, for any run.

    Sonic conductances and critical pressure ratios stay as measured with air. An ideal nozzle has a ratio of 0.53 for
    gases of two atoms, and 0.49 for noble gases. Heat transfer (``thermal.heatTransfer``) is to be given for the gas.

    Parameters
    ----------
    name : str
        ``air``, ``nitrogen``, ``oxygen``, ``argon``, ``helium``, ``hydrogen`` or ``carbon dioxide``.

    Returns
    -------
    dict
        ``gas.R`` in J/(kg.K), ``gas.gamma`` and ``gas.viscosity`` in Pa.s.

    Raises
    ------
    ValueError
        For another name.

    Examples
    --------
    >>> import pneumatic_servo as ps
    >>> run = ps.Model().simulate(ps.gas("nitrogen") | {"friction.law": "LuGre"}, stop=0.1)
    >>> ps.gas("helium")
    {'gas.R': 2077.3, 'gas.gamma': 1.67, 'gas.viscosity': 1.96e-05}
    """
    known = GASES.get(name)
    if known is None:
        raise ValueError(f"there is no gas {name!r}{did_you_mean(name, GASES)}; there are {', '.join(GASES)}")
    return {CONSTANT: known.constant, "gas.gamma": known.heat_ratio, "gas.viscosity": known.viscosity}


def relative_density(constant: float) -> float:
    """Return the density of a gas, by its specific gas constant in J/(kg K), relative to air."""
    return AIR.constant / constant
