#!/usr/bin/env bash
# asammdf 8.8.28 brings channels of an MDF file to a common raster by the type of their samples: floating-point numbers run on straight
# lines, integers and Booleans are held. A held command that was recorded as a floating-point number, 5 V and 10 ms later 6 V, becomes a
# ramp that begins a whole sample before the step; the same numbers as integers stay a step. The index begins at 0, wherever the record
# does.
. "$(dirname "$0")/common.sh"
pinned asammdf==8.8.28 numpy==2.3.5 pandas==2.3.3
python -W ignore - <<'PROGRAM'
import numpy as np
from asammdf import MDF, Signal

fast, slow = 100 + 0.001 * np.arange(41), 100 + 0.01 * np.arange(5)
command = np.array([5, 5, 6, 6, 6])
with MDF() as file:
    file.append([Signal(np.sin(fast), fast, name="position")])
    file.append([Signal(command.astype(kind), slow, name=kind) for kind in ("float64", "int16")])
    file.save("rig.mf4")
with MDF("rig.mf4") as file:
    tables = {"raster": file.to_dataframe(raster=0.001), "union": file.to_dataframe()}
    late = file.to_dataframe(time_from_zero=False).index[0]
for name, table in tables.items():
    print(name, table[["float64", "int16"]].iloc[[10, 12, 15, 18, 20]], sep="\n")
    assert np.allclose(table["float64"].iloc[[10, 15, 20]], [5.0, 5.5, 6.0]) and list(table["int16"].iloc[[10, 15, 19, 20]]) == [5, 5, 5, 6]
    assert table.index[0] == 0.0
print("begins at", late)
assert late == 100.0
PROGRAM
