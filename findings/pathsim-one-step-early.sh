#!/usr/bin/env bash
# PathSim 0.27.1 with PathSim-FMI 0.1.1: outputs of a co-simulation block are those of the end of the step that has just begun. Of
# der(x) = 2 with steps of 0.1 s the recorded x is 0.2 at time 0, where the FMU and the equation have 0.
. "$(dirname "$0")/common.sh"
pinned pathsim==0.27.1 pathsim-fmi==0.1.1 fmpy==0.3.32
probe 2 probe.fmu '/name="moving"/d; /Outputs/s/<Unknown index="5"[^>]*>//; /Initial/s/<Unknown index="5"[^>]*>//'
python - <<'PROGRAM'
import numpy as np
from pathsim import Connection, Simulation
from pathsim.blocks import Constant, Scope
from pathsim_fmi import CoSimulationFMU

source, plant, scope = Constant(2.0), CoSimulationFMU("probe.fmu", dt=0.1), Scope()
Simulation([source, plant, scope], [Connection(source, plant["u"]), Connection(plant["x"], scope)], dt=0.1, log=False).run(0.5)
time, (x,) = scope.read()
print("time", time, "x", x)
assert np.allclose(x, 2 * (time + 0.1)), x
PROGRAM
