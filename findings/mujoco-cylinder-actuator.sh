#!/usr/bin/env bash
# MuJoCo 4.0.0 has an actuator `cylinder`, meant for fluid power: a control signal, one lag, a force. There is no air in it: closed
# at 5 bar it pushes with the same 500 N wherever the rod is, so nothing makes a spring of it, and -6 bar, five below vacuum, pull with
# 600 N. Of `area` and `diameter` the latter wins without a word. With Euler and implicitfast the lag is an Euler step of `timeconst`:
# steps of one time constant reach 100 % in it instead of 63 %. A `timeconst` below half a step oscillates and grows, and 0, which
# reads like a valve without lag, gives 6e17 Pa in the first step; then the simulation starts anew, the command 0, with a line in a log.
. "$(dirname "$0")/common.sh"
pinned mujoco==4.0.0 numpy==2.3.5
python - <<'PROGRAM' 2>/dev/null
import math

import mujoco

MODEL = """<mujoco><option timestep="{step}" integrator="{integrator}" gravity="0 0 0"/><worldbody><body>
<joint name="rod" type="slide" axis="1 0 0"/><geom size="0.05" mass="2"/></body></worldbody>
<actuator><cylinder joint="rod" {cylinder}/></actuator></mujoco>"""


def loaded(cylinder, step=1e-3, integrator="Euler"):
    model = mujoco.MjModel.from_xml_string(MODEL.format(cylinder=cylinder, step=step, integrator=integrator))
    return model, mujoco.MjData(model)


model, data = loaded('area="0.001" timeconst="0.02"')
data.act[0] = data.ctrl[0] = 5e5
forces = []
for position in (0, 0.1, 0.5):
    data.qpos[0] = position
    mujoco.mj_forward(model, data)
    forces.append(data.actuator_force[0])
data.ctrl[0] = -6e5
mujoco.mj_step(model, data, 500)
print("closed at 5 bar, at 0, 0.1, 0.5 m:", *forces, "N; at -6 bar:", round(data.actuator_force[0], 3), "N")
assert forces == [500.0] * 3 and abs(data.actuator_force[0] + 600) < 1e-3

area = loaded('area="0.001" diameter="0.02"')[0].actuator_gainprm[0, 0]
print(f"area 0.001 m2 and diameter 0.02 m: {area:.6f} m2")
assert abs(area - math.pi * 0.01**2) < 1e-9


def lag(timeconst, step, integrator="Euler", seconds=0.02):
    """The share of the pressure after the time, and warnings that made the simulation start anew."""
    model, data = loaded(f'area="0.001" timeconst="{timeconst}"', step, integrator)
    data.ctrl[0] = 6e5
    first = None
    for _ in range(round(seconds / step)):
        mujoco.mj_step(model, data)
        first = data.act[0] if first is None else first
    return data.act[0] / 6e5, first, sum(warning.number for warning in data.warning), data.ctrl[0]


for integrator in ("Euler", "implicitfast", "RK4"):
    reached = [lag(0.02, step, integrator)[0] for step in (1e-3, 1e-2, 2e-2)]
    print(f"{integrator:12} after one time constant in steps of 1, 10, 20 ms:", *(f"{share:.4f}" for share in reached))
    expected = [1 - (1 - step / 0.02) ** round(0.02 / step) for step in (1e-3, 1e-2, 2e-2)] if integrator != "RK4" else [0.6321, 0.6321, 0.625]
    assert all(abs(a - b) < 5e-4 for a, b in zip(reached, expected, strict=True)), integrator
for timeconst, seconds in ((6e-4, 1), (4e-4, 0.01), (4e-4, 1), (0, 0.001), (0, 1)):
    share, first, warnings, command = lag(timeconst, 1e-3, seconds=seconds)
    print(f"timeconst {timeconst}, after {seconds} s: {share:.4g} of the pressure, starts anew {warnings}, command {command:g}")
    if timeconst == 6e-4:
        assert abs(share - 1) < 1e-9 and not warnings
    elif seconds == 1:
        assert warnings == 1 and share == 0 and command == 0
    else:
        assert abs(share) > 10 and not warnings
PROGRAM
