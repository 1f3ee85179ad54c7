#!/usr/bin/env bash
# Unit names as Modelica and FMI exporters write them, `m3/(s.Pa)`, meet unit parsers. Pint 0.25.3 and unyt 3.2.0 refuse exponents without
# an operator; astropy 8.0.2 reads them, and so does Pint behind syssimx 0.4.3, which inserts the operator. No spelling is read alike by
# all: `m3/s.Pa` is m3/(s.Pa) in astropy and (m3/s).Pa in syssimx, a factor of Pa2. With parentheses the two agree.
. "$(dirname "$0")/common.sh"
pinned pint==0.25.3 unyt==3.2.0 astropy==8.0.2 syssimx==0.4.3
python -W ignore - <<'PROGRAM'
import astropy.units as ap
import pint
import unyt
from syssimx.utilities.units import to_pint_unit

registry = pint.UnitRegistry()


def exponent_of_pascal(read, text):
    try:
        return read(text)
    except Exception:
        return None


def of_pint(unit):
    return unit._units.get("pascal", 0)


def of_astropy(unit):
    return dict(zip(unit.bases, unit.powers))[ap.Pa]


readers = {
    "astropy": lambda text: of_astropy(ap.Unit(text)),
    "syssimx": lambda text: of_pint(to_pint_unit(text)),
    "pint": lambda text: of_pint(registry.Unit(text)),
    "unyt": lambda text: unyt.unyt_quantity(1, text).units.expr.as_powers_dict()[unyt.Pa.expr],
}
for text, expected in (
    ("m3/(s.Pa)", {"astropy": -1, "syssimx": -1, "pint": None, "unyt": None}),
    ("m3/s.Pa", {"astropy": -1, "syssimx": 1, "pint": None, "unyt": None}),
    ("m3.s-1.Pa-1", {"astropy": -1, "syssimx": -1, "pint": None, "unyt": None}),
    ("m**3/(s*Pa)", {"astropy": -1, "syssimx": -1, "pint": -1, "unyt": -1}),
    ("Pa.s", {"astropy": 1, "syssimx": 1, "pint": 1, "unyt": None}),
):
    found = {name: exponent_of_pascal(read, text) for name, read in readers.items()}
    print(f"{text:12} exponent of Pa:", found)
    assert found == expected, text
PROGRAM
