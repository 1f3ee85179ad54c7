#!/usr/bin/env bash
# FMU Manipulation Toolbox 2.0: a container takes the importer's relative tolerance, which it hands to its FMUs, also as seconds by which
# its own clock may be late. With steps of 0.1 s inside and 0.098 s outside, the FMU is stepped at 0.1 s without a tolerance and at 1e-4,
# and already at 0.098 s at 1e-2: outputs come 2 ms early, and change by a whole step with a setting that is meant for accuracy.
. "$(dirname "$0")/common.sh"
pinned fmu_manipulation_toolbox==2.0 fmpy==0.3.32 numpy==2.3.5
probe 2 plant.fmu
cat >one.json <<'JSON'
{"name": "one.fmu", "step_size": 0.1, "fmu": ["plant.fmu"], "input": [["u", "plant.fmu", "u"]], "output": [["plant.fmu", "x", "x"]]}
JSON
fmucontainer -container one.json -fmu-directory . >log 2>&1 || { cat log; exit 1; }
python - <<'PROGRAM' 2>/dev/null
import numpy as np
from fmpy import simulate_fmu

for tolerance, expected in ((None, [0, 0, 0.5, 1]), (1e-4, [0, 0, 0.5, 1]), (1e-2, [0, 0.5, 1, 1.5])):
    open("calls", "w").close()
    x = simulate_fmu("one.fmu", stop_time=0.294, output_interval=0.098, relative_tolerance=tolerance, output=["x"])["x"]
    told = [line.split(": ")[1] for line in open("calls").read().splitlines() if "tolerance" in line]
    print("tolerance", tolerance, "x", x, "the FMU was told:", told)
    assert np.allclose(x, expected), x
    assert told == ["no tolerance" if tolerance is None else f"tolerance {tolerance:.9g}"]
PROGRAM
