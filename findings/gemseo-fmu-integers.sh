#!/usr/bin/env bash
# gemseo-fmu 3.1.1 sets every input of an FMI 2.0 FMU with fmi2SetReal, Integers and Enumerations too, which the FMU must refuse; the same
# discipline sets both by number in FMI 3.0.
. "$(dirname "$0")/common.sh"
pinned gemseo-fmu==3.1.1 fmpy==0.3.19
probe 2 two.fmu
probe 3 three.fmu
python -W ignore - <<'PROGRAM'
import numpy as np
from gemseo_fmu.disciplines.fmu_discipline import FMUDiscipline

for fmu, refused in (("two.fmu", True), ("three.fmu", False)):
    for name in ("mode", "modeNumber"):
        try:
            result = FMUDiscipline(fmu, [name], ["x"], final_time=1.0, time_step=0.1).execute({name: np.array([3])})
            answer = f"x = {result['x'][-1]:.6g}"
        except Exception as error:
            answer = str(error)
        print(fmu, name, answer)
        assert answer == ("fmi2SetReal failed with status 3 (error)." if refused else "x = 10"), answer
PROGRAM
