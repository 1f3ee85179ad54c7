#!/usr/bin/env bash
# PathSim-FMI 0.1.1 sets start values of Integers in FMI 2.0, of Enumerations in neither version (ValueError), and in FMI 3.0 of none of
# 32 bits: it calls fmi3SetInt64 for an Int32. An FMU whose options should be chosen in it needs Reals or, in FMI 3.0, Int64.
. "$(dirname "$0")/common.sh"
pinned pathsim==0.27.1 pathsim-fmi==0.1.1 fmpy==0.3.32
probe 2 two.fmu
probe 3 three.fmu
python - <<'PROGRAM'
from pathsim_fmi.wrapper import FMUWrapper


def answer(fmu, values):
    open("calls", "w").close()
    try:
        FMUWrapper(fmu).initialize(values)
    except Exception as error:
        return f"{type(error).__name__}: {error}"
    return next(line.split(": ")[1] for line in open("calls").read().splitlines() if "exit initialization" in line)


for fmu, values, expected in (
    ("two.fmu", {"modeNumber": 3}, "exit initialization with u 5 mode 3"),
    ("two.fmu", {"mode": 3}, "ValueError: Unsupported variable type: Enumeration"),
    ("three.fmu", {"modeNumber": 3}, "FMICallException: fmi3SetInt64 failed with status 3 (error)."),
    ("three.fmu", {"mode": 3}, "ValueError: Unsupported variable type: Enumeration"),
):
    print(fmu, values, answer(fmu, values))
    assert answer(fmu, values) == expected
PROGRAM
