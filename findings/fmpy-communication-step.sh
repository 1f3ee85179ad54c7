#!/usr/bin/env bash
# FMPy 0.3.32 doubles the FMU's own step until a run has at most 1000 of them, and does not look at `step_size` in co-simulation:
# 3 s of an FMU whose default experiment has stepSize 1 ms are communicated in steps of 4 ms, also with step_size=1e-3.
# Only `output_interval` sets the communication step.
. "$(dirname "$0")/common.sh"
pinned fmpy==0.3.32 numpy==2.3.5
probe 2 two.fmu
probe 3 three.fmu
python - <<'PROGRAM'
from fmpy import simulate_fmu

for fmu in ("two.fmu", "three.fmu"):
    for options, expected in (({}, 0.004), ({"step_size": 1e-3}, 0.004), ({"output_interval": 1e-3}, 0.001), ({"step_size": 1e-3, "output_interval": 1e-2}, 0.01)):
        open("calls", "w").close()
        simulate_fmu(fmu, stop_time=3, **options)
        steps = [float(line.split()[-1]) for line in open("calls") if "step from" in line]
        print(fmu, options, len(steps), "steps of", steps[0], "s")
        assert abs(steps[0] - expected) < 1e-9 and len(steps) == round(3 / expected), steps[:3]
PROGRAM
