#!/usr/bin/env bash
# CoFMUPy 1.0.0 sets and reads every variable of an FMI 2.0 FMU by fmi2SetReal and fmi2GetReal, and reads all outputs after each step,
# connected or not: one Boolean output ends the run, and enumerations cannot be initialized. In FMI 3.0 outputs are read as Float64, with
# the same end, and the type Enumeration is refused. It hands on no tolerance.
. "$(dirname "$0")/common.sh"
pinned cofmupy==1.0.0
without_boolean='/name="moving"/d;s/<Unknown index="5"[^>]*>//'
probe 2 boolean.fmu
probe 2 real.fmu "$without_boolean"
cat >run.py <<'PROGRAM'
import contextlib
import json
import os
import sys
from pathlib import Path

from cofmupy import Coordinator

fmu, initial = sys.argv[1], json.loads(sys.argv[2])
Path("rows.csv").write_text("t,u\n0,5\n1,5\n")
source = {"type": "csv", "path": "rows.csv", "variable": "u", "interpolation": "previous"}
config = {
    "fmus": [{"id": "plant", "path": fmu, "initialization": initial}],
    "connections": [{"source": source, "target": {"id": "plant", "variable": "u"}}],
    "root": ".",
}
Path("config.json").write_text(json.dumps(config))
Path(os.environ["PROBE_CALLS"]).write_text("")
with open(os.devnull, "w") as silent, contextlib.redirect_stdout(silent):
    coordinator = Coordinator()
    coordinator.start("config.json")
    for _ in range(4):
        coordinator.do_step(0.25)
print("x", coordinator.get_variable(("plant", "x"))[0])
PROGRAM
expect() { # expect <fmu> <initial values> <extended regular expression>
    python run.py "$1" "$2" >out 2>&1 || true
    echo "$1 $2: $(grep -m1 -oE "$3" out || tail -1 out)"
    grep -qE "$3" out || { cat out; exit 1; }
}
expect real.fmu '{}' "x 5\.0"
grep -q "no tolerance" calls
expect boolean.fmu '{}' "fmi2GetReal failed with status 3"
expect real.fmu '{"gain": 2.0}' "x 10\.0"
expect real.fmu '{"mode": 3}' "fmi2SetReal failed with status 3"
probe 3 boolean3.fmu
expect boolean3.fmu '{"mode": 3}' "Variable type Enumeration not supported"
expect boolean3.fmu '{}' "fmi3GetFloat64 failed with status 3"
