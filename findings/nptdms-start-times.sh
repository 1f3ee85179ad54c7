#!/usr/bin/env bash
# npTDMS 1.13.0: channels of a TDMS file have a start each, `wf_start_time`. The relative time axis, `time_track()` and the index of
# `as_dataframe(time_index=True)`, counts `wf_start_offset` and leaves the start out: a channel that began 250 ms after another stands
# beside it as if both had begun together. `time_track(absolute_time=True)` has both.
. "$(dirname "$0")/common.sh"
pinned nptdms==1.13.0 numpy==2.3.5 pandas==2.3.3
python - <<'PROGRAM'
import numpy as np
from nptdms import ChannelObject, TdmsFile, TdmsWriter

begun = np.datetime64("2026-03-01T12:00:00", "us")
late = np.timedelta64(250, "ms")


def channel(name, start, offset):
    return ChannelObject("rig", name, np.arange(3.0), {"wf_start_time": start, "wf_increment": 0.01, "wf_start_offset": offset})


with TdmsWriter("rig.tdms") as writer:
    writer.write_segment([channel("position", begun, 0.0), channel("late", begun + late, 0.0), channel("offset", begun, 0.25)])
rig = TdmsFile.read("rig.tdms")["rig"]
for name in ("position", "late", "offset"):
    print(f"{name:9} relative {rig[name].time_track()[0]:.2f} s, absolute {rig[name].time_track(absolute_time=True)[0]}")
table = rig.as_dataframe(time_index=True)
print(table)
assert rig["late"].time_track()[0] == 0.0 and rig["offset"].time_track()[0] == 0.25
assert rig["late"].time_track(absolute_time=True)[0] - rig["position"].time_track(absolute_time=True)[0] == late
assert table.loc[0.0, "late"] == 0.0 and np.isnan(table.loc[0.25, "late"])
PROGRAM
