#!/usr/bin/env bash
# ecospy 0.7.2 skips enumerations, of FMI 2.0 and 3.0: a set of parameters that names one is accepted with a warning on the console, and
# the run goes on with the FMU's default. It needs the Debian package libtbb12.
. "$(dirname "$0")/common.sh"
pinned ecospy==0.7.2
probe 2 two.fmu
probe 3 three.fmu
cat >run.py <<'PROGRAM'
import sys
from ecospy import EcosSimulation, EcosSimulationStructure

fmu, name = sys.argv[1:]
with EcosSimulationStructure() as structure:
    structure.add_model("plant", fmu)
    structure.add_parameter_set("set", {f"plant::{name}": 3})
    with EcosSimulation(structure=structure, step_size=0.1) as simulation:
        simulation.init(parameter_set="set")
        simulation.step(10)
        print(f"x = {simulation.get_real('plant::x'):.6g}")
PROGRAM
for fmu in two.fmu three.fmu; do
    for try in 'mode:x = 5' 'modeNumber:x = 10'; do
        python run.py $fmu "${try%%:*}" >out 2>&1
        echo "$fmu ${try%%:*} $(grep 'x = ' out)"
        grep -qx "${try#*:}" out || { cat out; exit 1; }
    done
done
