#!/usr/bin/env bash
# PathSim 0.27.1 with PathSim-FMI 0.1.1: an input without a connection is set to 0 at every step. Its start value, also one given as
# start_values, holds while the FMU initializes and is gone with the first step: x stays 0.
. "$(dirname "$0")/common.sh"
pinned pathsim==0.27.1 pathsim-fmi==0.1.1 fmpy==0.3.32
probe 2 probe.fmu '/name="moving"/d; /Outputs/s/<Unknown index="5"[^>]*>//; /Initial/s/<Unknown index="5"[^>]*>//'
python - <<'PROGRAM'
from pathsim import Connection, Simulation
from pathsim.blocks import Scope
from pathsim_fmi import CoSimulationFMU

plant, scope = CoSimulationFMU("probe.fmu", dt=0.1, start_values={"u": 7.0}), Scope()
Simulation([plant, scope], [Connection(plant["x"], scope)], dt=0.1, log=False).run(0.5)
calls = open("calls").read().splitlines()
print(*calls[:8], sep="\n")
assert "fmu_instance: exit initialization with u 7 mode 2" in calls
assert calls[calls.index("fmu_instance: step from 0 by 0.1") - 1] == "fmu_instance: set real 1 0"
assert not scope.read()[1].any()
PROGRAM
