#!/usr/bin/env bash
# asammdf 8.8.28 and a pressure that was recorded as counts of a converter, 16 bits and the linear conversion into bar, 0 to 40 ms -1 bar and
# from 50 ms on 9 bar. By `resample` and by `get(raster=...)` it is held, for the counts are integers; by `to_dataframe(raster=...)` it is 4 bar
# in between, for bar is not. `get(raster=0.005)` has no sample at 5 ms: 0.1 s become 20 samples from end to end, 5.263 ms apart, and ten
# seconds in steps of 1 ms 1.0001 ms, where the two others keep the raster.
. "$(dirname "$0")/common.sh"
pinned asammdf==8.8.28 numpy==2.3.5 pandas==2.3.3
python -W ignore - <<'PROGRAM'
import numpy as np
from asammdf import MDF, Signal


def record(samples, step, file):
    counts = np.where(np.arange(samples) < samples // 2, 0, 1000).astype(np.int16)
    with MDF() as mdf:
        mdf.append([Signal(counts, step * np.arange(samples), name="pressure", unit="bar", conversion={"a": 0.01, "b": -1.0})])
        mdf.save(file)


record(11, 0.01, "short.mf4")
with MDF("short.mf4") as file:
    table = file.to_dataframe(raster=0.005)["pressure"]
    sampled = file.resample(0.005).get("pressure")
    got = file.get("pressure", raster=0.005)
print("to_dataframe", table.iloc[8:12].to_dict())
print("resample", dict(zip(sampled.timestamps[8:12].round(6).tolist(), sampled.samples[8:12].tolist(), strict=True)))
print("get", dict(zip(got.timestamps[8:12].round(6).tolist(), got.samples[8:12].tolist(), strict=True)))
assert np.allclose(table.loc[0.04:0.05], [-1, 4, 9])
assert np.array_equal(sampled.samples, np.where(np.arange(21) < 10, -1, 9)) and np.allclose(sampled.timestamps, 0.005 * np.arange(21))
assert np.allclose(got.timestamps, np.linspace(0, 0.1, 20)) and set(got.samples) == {-1.0, 9.0}

record(10001, 0.001, "long.mf4")
with MDF("long.mf4") as file:
    clocks = [file.get("pressure", raster=0.001).timestamps, file.resample(0.001).get("pressure").timestamps, file.to_dataframe(raster=0.001).index]
print("samples of 10 s by get, resample, to_dataframe:", [len(clock) for clock in clocks], f"get: {1e3 * clocks[0][1]:.4f} ms apart")
assert [len(clock) for clock in clocks] == [10000, 10001, 10001] and abs(clocks[0][5000] - clocks[1][5000]) > 4e-4
PROGRAM
