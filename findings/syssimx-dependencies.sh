#!/usr/bin/env bash
# syssimx 0.4.3 ends with a TypeError while it initializes an FMI 2.0 FMU whose outputs have no attribute `dependencies`; the standard
# makes it optional. FMI 3.0 is refused in words. Inputs without a connection are set to 0 in place of their start values.
. "$(dirname "$0")/common.sh"
pinned syssimx==0.4.3 fmpy==0.3.32
probe 2 told.fmu
probe 2 plain.fmu 's/ dependencies="[^"]*"//g'
probe 3 three.fmu
python - <<'PROGRAM'
from syssimx.components.fmu import FMUComponent


def answer(fmu):
    try:
        component = FMUComponent("plant", fmu)
        component.initialize(0.0)
    except Exception as error:
        return f"{type(error).__name__}: {error}"
    return "initialized"


for fmu, expected in (("told.fmu", "initialized"), ("plain.fmu", "TypeError: 'NoneType' object is not iterable"), ("three.fmu", "NotImplementedError")):
    print(fmu, answer(fmu))
    assert answer(fmu).startswith(expected)
calls = open("calls").read()
assert "plant: exit initialization with u 0 mode 2" in calls and "u 5" not in calls, calls
PROGRAM
