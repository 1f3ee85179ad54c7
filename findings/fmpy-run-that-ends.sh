#!/usr/bin/env bash
# FMPy 0.3.32, simulate_fmu: an FMU that discards a step and reports that it has terminated ends the run without an exception and without
# a message, even with `debug_logging`: the result is the rows until then. The last time tells, compared with the stop time that was asked.
. "$(dirname "$0")/common.sh"
pinned fmpy==0.3.32 numpy==2.3.5
probe 2 stop.fmu 's|</ModelVariables>|<ScalarVariable name="stop" valueReference="9" causality="parameter" variability="fixed" initial="exact"><Real start="1"/></ScalarVariable></ModelVariables>|'
python -W error - <<'PROGRAM' 2>&1 | tee out
import numpy as np
from fmpy import simulate_fmu

messages = []
rows = simulate_fmu(
    "stop.fmu", stop_time=1.0, output_interval=0.1, start_values={"stop": 1.0, "u": 5.0}, output=["x"], debug_logging=True,
    logger=lambda environment, instance, status, category, message: messages.append(message),
)
print("asked until 1 s, rows until", rows["time"][-1], "messages", messages)
# der(x) = 5: the stop at 1 is reached at 0.2 s.
assert np.isclose(rows["time"][-1], 0.2) and messages == []
PROGRAM
[[ $(wc -l <out) == 1 ]]
