#!/usr/bin/env bash
# MuJoCo 4.0.0: a joint with `frictionloss` 10 N never sticks. Under 5 N, half of what would break it away, it creeps at 2.64 mm/s, under
# 9 N at 4.75 mm/s, in proportion to the force. Shorter steps do not change this, nor do other integrators, nor a loss of 100 N: friction
# is a soft constraint. A tenth of the time constant of `solreffriction` leaves a tenth of the creep, and so does an impedance of 0.99.
. "$(dirname "$0")/common.sh"
pinned mujoco==4.0.0 numpy==2.3.5
python - <<'PROGRAM'
import mujoco

MODEL = """<mujoco><option timestep="{step}" integrator="{integrator}" gravity="0 0 0"/><worldbody><body>
<joint type="slide" axis="1 0 0" frictionloss="{loss}" {more}/><geom size="0.05" mass="2"/></body></worldbody></mujoco>"""


def creep(force, step=1e-3, integrator="Euler", loss=10, more=""):
    """mm in the second second under a constant force."""
    model = mujoco.MjModel.from_xml_string(MODEL.format(step=step, integrator=integrator, loss=loss, more=more))
    data = mujoco.MjData(model)
    data.qfrc_applied[0] = force
    reached = []
    for _ in range(2):
        for _ in range(round(1 / step)):
            mujoco.mj_step(model, data)
        reached.append(1e3 * data.qpos[0])
    return reached[1] - reached[0]


cases = {
    "2 N": (creep(2), 1.056),
    "5 N": (creep(5), 2.639),
    "9 N": (creep(9), 4.75),
    "5 N, steps of 0.1 ms": (creep(5, step=1e-4), 2.639),
    "5 N, implicitfast": (creep(5, integrator="implicitfast"), 2.639),
    "5 N, RK4": (creep(5, integrator="RK4"), 2.639),
    "5 N of 100 N": (creep(5, loss=100), 2.639),
    "5 N, solreffriction 0.002 1": (creep(5, more='solreffriction="0.002 1"'), 0.2639),
    "5 N, solimpfriction 0.99": (creep(5, more='solimpfriction="0.99 0.99 0.001"'), 0.25),
}
for name, (seen, expected) in cases.items():
    print(f"{name:28} {seen:.3f} mm/s")
    assert abs(seen - expected) < 2e-3 * expected, name
PROGRAM
