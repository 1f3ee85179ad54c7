#!/usr/bin/env bash
# Units of data sheets that Pint 0.25.3 takes for something else, without a word: `cfm` is a centifermi (1e-17 m) and no cubic foot a
# minute, `Nm` the yarn count number_meter (1000 m/kg) and no newton metre, `bar(g)` bar times gram, `slm` the power of a standard litre a
# minute at one atmosphere (1.69 W) and no flow, `lbs` a mass. `barg`, `psig`, `Nl/min`, `scfm` and `kp` are refused.
. "$(dirname "$0")/common.sh"
pinned pint==0.25.3
python - <<'PROGRAM'
import pint

registry = pint.UnitRegistry()
FLOW, TORQUE, PRESSURE, FORCE = (registry.get_dimensionality(unit) for unit in ("m**3/s", "N*m", "Pa", "N"))
meant = {"cfm": FLOW, "Nm": TORQUE, "bar(g)": PRESSURE, "psi(g)": PRESSURE, "slm": FLOW, "lbs": FORCE}
for text, dimension in meant.items():
    read = registry.Quantity(1, text)
    print(f"{text:7} {read.units!s:32} {read.to_base_units()}")
    assert read.dimensionality != dimension, text
assert abs(registry.Quantity(1, "cfm").to("m").magnitude / 1e-17 - 1) < 1e-12
assert abs(registry.Quantity(1, "slm").to("W").magnitude - 1.68875) < 1e-9
for text in ("barg", "psig", "Nl/min", "scfm", "kp"):
    try:
        registry.Unit(text)
    except pint.UndefinedUnitError as error:
        print(error)
    else:
        raise AssertionError(text)
PROGRAM
