#!/usr/bin/env bash
# sofirpy 1.0.2 sets an enumeration by number (the name of an item is a ValueError), but cannot log one (KeyError). It takes every FMU for one of FMI 2.0: of FMI 3.0
# it looks for a library in linux64. It gives the FMU neither a tolerance nor a stop time.
. "$(dirname "$0")/common.sh"
pinned sofirpy==1.0.2 fmpy==0.3.32
probe 2 two.fmu
probe 3 three.fmu
python -W ignore - <<'PROGRAM' 2>log || { cat log; exit 1; }
from sofirpy import simulate


def answer(fmu, start, log):
    try:
        frame = simulate(stop_time=1.0, step_size=0.1, fmu_paths={"plant": fmu}, start_values={"plant": start},
                         logging_step_size=0.1, parameters_to_log={"plant": log})
    except Exception as error:
        return f"{type(error).__name__}: {error}"
    return f"{frame.iloc[-1]['plant.x']:.6g}"


for fmu, start, log, expected in (
    ("two.fmu", {"mode": 3}, ["x"], "10"),
    ("two.fmu", {"mode": "Doubled"}, ["x"], "ValueError: invalid literal for int"),
    ("two.fmu", {}, ["x", "mode"], "KeyError: 'Enumeration'"),
    ("three.fmu", {}, ["x"], "Exception: Cannot find shared library"),
):
    found = answer(fmu, start, log)
    print(fmu, start, log, found.split(" /")[0])
    assert found.startswith(expected), found
assert "tolerance 1e-06" not in open("calls").read() and "no tolerance" in open("calls").read()
PROGRAM
