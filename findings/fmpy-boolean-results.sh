#!/usr/bin/env bash
# FMPy 0.3.32 cannot read a result file that it wrote itself if a recorded output is Boolean: write_csv writes `True`, read_csv
# takes every column as a number.
. "$(dirname "$0")/common.sh"
pinned fmpy==0.3.32 numpy==2.3.5
probe 2 probe.fmu
python - <<'PROGRAM'
from fmpy import simulate_fmu
from fmpy.util import read_csv, write_csv

result = simulate_fmu("probe.fmu", output=["x", "moving"])
write_csv("result.csv", result)
print(open("result.csv").read().splitlines()[:2])
try:
    read_csv("result.csv")
except ValueError as error:
    print("ValueError:", error)
    assert "True" in str(error)
else:
    raise SystemExit("it was read")
write_csv("numbers.csv", result[["time", "x"]])
assert read_csv("numbers.csv").shape == result.shape
PROGRAM
