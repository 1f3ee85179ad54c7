#!/usr/bin/env bash
# asammdf 8.8.28 and a position whose sensor was out from 30 to 70 ms, those samples 9 and marked as invalid in the MDF file. `get` leaves
# them out. `to_dataframe` fills the gap with a straight line, unless `use_interpolation=False`, which has NaN. `resample` leaves
# the gap but for one sample: at 25 ms it has 5.5, the mean of the last valid 2 and the first invalid 9, as a valid one, and a table of
# that falls from there. An export to MATLAB has the 9s and no mark.
. "$(dirname "$0")/common.sh"
pinned asammdf==8.8.28 numpy==2.3.5 pandas==2.3.3 scipy==1.17.1
python -W ignore - <<'PROGRAM'
import numpy as np
from asammdf import MDF, Signal
from scipy.io import loadmat

times = 0.01 * np.arange(11)
position = np.array([0.0, 1, 2, 9, 9, 9, 9, 9, 3, 4, 5])
with MDF() as file:
    file.append([Signal(position, times, name="position", invalidation_bits=position == 9)])
    file.save("rig.mf4")

with MDF("rig.mf4") as file:
    valid = file.get("position")
    table = file.to_dataframe()["position"].to_numpy()
    holes = file.to_dataframe(use_interpolation=False)["position"].to_numpy()
    file.export("mat", "rig.mat")
    finer = file.resample(0.005)
    sampled = finer.get("position")
    of_finer = finer.to_dataframe()["position"]

print("get", valid.samples)
print("to_dataframe", table)
print("without interpolation", holes)
assert np.array_equal(valid.samples, [0, 1, 2, 3, 4, 5])
assert np.allclose(table, [0, 1, 2, 2 + 1 / 6, 2 + 2 / 6, 2.5, 2 + 4 / 6, 2 + 5 / 6, 3, 4, 5])
assert np.array_equal(holes, np.where(position == 9, np.nan, position), equal_nan=True)

print("resample", dict(zip((1e3 * sampled.timestamps).round().astype(int).tolist(), sampled.samples.tolist(), strict=True)))
assert np.allclose(1e3 * sampled.timestamps, [0, 5, 10, 15, 20, 25, 80, 85, 90, 95, 100])
assert np.allclose(sampled.samples, [0, 0.5, 1, 1.5, 2, 5.5, 3, 3.5, 4, 4.5, 5])
print("table of it, 25 to 80 ms", of_finer.iloc[5:17].round(2).to_list())
assert np.allclose(of_finer.iloc[5:17], np.linspace(5.5, 3, 12))

exported = {name: value.ravel() for name, value in loadmat("rig.mat").items() if "position" in name}
print("MATLAB", exported)
assert len(exported) == 1 and all(np.array_equal(value, position) for value in exported.values())
PROGRAM
