#!/usr/bin/env bash
# jaxonomy 3.4.1, blocks of imported FMUs. The FMU is made when the block is, and no run makes it anew: a second `simulate` of the same
# diagram with a new context begins at x = 0 and is at 2.5, where the first ended, a step later; by model exchange a mode that an event has
# changed stays changed, and the second run does not move at all. In co-simulation every output is one step late, for each update reads
# before it steps, and the first step starts at -1.4e-17 s, which is below the start time; `first_step_at_zero=True` has neither. Of
# `parameters` names with dots are passed over without a word, like those that do not exist: `valve.gain` is `valve_gain`.
. "$(dirname "$0")/common.sh"
pinned jaxonomy==3.4.1 fmpy==0.3.32 jax==0.9.2 numpy==2.3.5
probe 2 probe.fmu 's/name="gain"/name="valve.gain"/'
probe 2 stop.fmu 's/numberOfEventIndicators="0"/numberOfEventIndicators="1"/
s|</ModelVariables>|<ScalarVariable name="stop" valueReference="9" causality="parameter" variability="fixed" initial="exact"><Real start="1"/></ScalarVariable></ModelVariables>|'
python -W ignore - 2>&1 <<'PROGRAM' | grep -v INFO
import os
from pathlib import Path

import numpy as np
from jaxonomy import DiagramBuilder, library, simulate


def diagram(kind, file, **options):
    builder = DiagramBuilder()
    plant = builder.add(kind(file, name="plant", output_names=["x"], **options))
    command = builder.add(library.Constant(5.0))
    builder.connect(command.output_ports[0], plant.input_ports[0])
    return builder.build(), plant.output_ports[0]


def run(made, stop=0.5):
    whole, port = made
    results = simulate(whole, whole.create_context(), (0.0, stop), recorded_signals={"x": port})
    return np.array(results.time), np.array(results.outputs["x"])


calls = Path(os.environ["PROBE_CALLS"])


def first_step():
    line = next(line for line in calls.read_text().splitlines() if ": step from" in line)
    calls.write_text("")
    return float(line.split()[3])


late, early = diagram(library.ModelicaFMU, "probe.fmu", dt=0.1), diagram(library.ModelicaFMU, "probe.fmu", dt=0.1, first_step_at_zero=True)
calls.write_text("")
first, begun = run(late)[1], first_step()
second = run(late)[1]
calls.write_text("")
at_zero, begun_at_zero = run(early)[1], first_step()
print("first run", first, "from", begun)
print("second run", second)
print("first_step_at_zero", at_zero, "from", begun_at_zero)
assert np.allclose(first, [0, 0, 0.5, 1, 1.5, 2]) and np.allclose(second, [0, 2.5, 3, 3.5, 4, 4.5])
assert np.allclose(at_zero, [0, 0.5, 1, 1.5, 2, 2.5]) and -1e-16 < begun < 0 and begun_at_zero == 0

stopping = diagram(library.ModelicaFMUME, "stop.fmu", parameters={"stop": 1.0})
(times, first), (_, second) = run(stopping, 1.0), run(stopping, 1.0)
print("model exchange: stopped at", times[np.argmax(first > 0.999)], "s,", first[-1], "- second run:", second.max())
assert abs(times[np.argmax(first > 0.999)] - 0.2) < 1e-3 and abs(first[-1] - 1) < 1e-3 and second.max() < 1e-9

ends = {name: run(diagram(library.ModelicaFMU, "probe.fmu", dt=0.1, parameters={name: 2.0}))[1][-1] for name in ("valve.gain", "valve_gain", "no such")}
print("x with a gain of 2:", ends)
assert np.allclose(list(ends.values()), [2, 4, 2])
PROGRAM
