#!/usr/bin/env bash
# CasADi 3.8.2 has events in its integrators, with derivatives of their times, for equations that are written in CasADi. The event
# indicators of an imported FMU are no part of that: `DaeBuilder` has no zero-crossing functions for them, says nothing, never asks for
# them, and its integrator runs through the end stop at which FMPy 0.3.32 (CVODE) stops the same FMU.
. "$(dirname "$0")/common.sh"
pinned casadi==3.8.2 fmpy==0.3.32 numpy==2.3.5
probe 2 stop.fmu 's/numberOfEventIndicators="0"/numberOfEventIndicators="1"/
s|</ModelVariables>|<ScalarVariable name="stop" valueReference="9" causality="parameter" variability="fixed" initial="exact"><Real start="1"/></ScalarVariable></ModelVariables>|'
python - <<'PROGRAM'
import os
from pathlib import Path
from zipfile import ZipFile

import casadi as ca
import numpy as np
from fmpy import simulate_fmu

calls = Path(os.environ["PROBE_CALLS"])
stopped = simulate_fmu("stop.fmu", stop_time=1, fmi_type="ModelExchange", start_values={"stop": 1.0}, output=["x"])["x"][-1]
asked = "event indicators" in calls.read_text()
print("FMPy:", stopped, "- asks for indicators:", asked)
assert abs(stopped - 1) < 1e-3 and asked

calls.write_text("")
ZipFile("stop.fmu").extractall("stop")
plant = ca.DaeBuilder("plant", "stop")
plant.set("stop", 1.0)
rates = plant.create("rates", ["x", "u"], ["ode"])
x, u = ca.MX.sym("x"), ca.MX.sym("u")
run = ca.integrator("run", "cvodes", {"x": x, "u": u, "ode": rates(x, u)}, 0, 1)
through = float(run(x0=0, u=5)["xf"])
asked = "event indicators" in calls.read_text()
print("CasADi:", through, "- zero-crossing functions:", plant.nzero(), "- asks for indicators:", asked)
assert abs(through - 5) < 1e-6 and plant.nzero() == 0 and not asked

# The same stop, written in CasADi, is an event.
own = ca.DaeBuilder("own")
x = own.add("x", {"start": 0})
moves = own.add("moves", {"start": 1})
own.eq(own.der(x), 5 * moves)
own.eq(own.der(moves), 0)
own.when(1 - x < 0, [own.reinit("moves", 0)])
equations = own.create("equations", ca.dyn_in(), ca.dyn_out())
run = ca.integrator("run", "cvodes", equations, 0, 1, {"transition": own.transition()})
located = float(run(x0=[0, 1])["xf"][0])
print("written in CasADi:", located)
assert abs(located - 1) < 1e-6
PROGRAM
