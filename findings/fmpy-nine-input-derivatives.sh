#!/usr/bin/env bash
# FMPy 0.3.32: simulate_fmu(..., set_input_derivatives=True) works for an FMU with exactly nine continuous inputs, and ends with a
# ValueError for any other number, before the first step. At the start time the slope that it sets is 0: of u = t the first step is held.
. "$(dirname "$0")/common.sh"
pinned fmpy==0.3.32 numpy==2.3.5
# inputs <number>: variables of further inputs
inputs() { for ((i = 1; i < $1; i++)); do printf '<ScalarVariable name="v%d" valueReference="%d" causality="input" variability="continuous"><Real start="0"/></ScalarVariable>' "$i" $((100 + i)); done; }
for number in 1 2 8 9 10; do
    more=$((number - 1))
    probe 2 "$number.fmu" "s|<ScalarVariable name=\"x\"|$(inputs "$number")&|; s/ dependencies=\"[^\"]*\"//g
        s/Unknown index=\"5\"/Unknown index=\"$((5 + more))\"/g; s/Unknown index=\"3\"/Unknown index=\"$((3 + more))\"/g; s/Unknown index=\"2\"/Unknown index=\"$((2 + more))\"/g"
done
python - <<'PROGRAM'
import numpy as np
from fmpy import read_model_description, simulate_fmu

for number in (1, 2, 8, 9, 10):
    fmu = f"{number}.fmu"
    names = [v.name for v in read_model_description(fmu).modelVariables if v.causality == "input"]
    assert len(names) == number
    table = np.zeros(11, dtype=[("time", float), *((name, float) for name in names)])
    table["time"] = table["u"] = np.linspace(0, 1, 11)
    open("calls", "w").close()
    try:
        end = simulate_fmu(fmu, input=table, output_interval=0.1, set_input_derivatives=True, output=["x"])["x"][-1]
    except ValueError as error:
        print(number, "inputs: ValueError:", error)
        assert number != 9 and "set slope" not in open("calls").read()
    else:
        print(number, "inputs: x =", end)
        assert number == 9 and abs(end - 0.495) < 1e-9  # 0.5 without that first step
PROGRAM
