#!/usr/bin/env bash
# CasADi 3.8.2: DaeBuilder.set takes an enumeration by number, of FMI 2.0 and 3.0. The name of an item, which the description has, is
# ignored without a word, and so is any other text: the FMU keeps its default.
. "$(dirname "$0")/common.sh"
pinned casadi==3.8.2 numpy==2.3.5
probe 2 two.fmu
probe 3 three.fmu
python - <<'PROGRAM'
from zipfile import ZipFile

import casadi as ca

for name in ("two", "three"):
    ZipFile(f"{name}.fmu").extractall(name)
    for value, expected in ((3, 4.0), ("Doubled", 2.0), ("3", 2.0), ("NoSuchItem", 2.0)):
        plant = ca.DaeBuilder("plant", name)
        plant.set("mode", value)
        rate = float(plant.create("rate", ["x", "u"], ["ode"])(0, 2)[0])
        print(name, repr(value), "der(x) =", rate)
        assert rate == expected  # gain*u*(mode - 1)
PROGRAM
