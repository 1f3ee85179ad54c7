#!/usr/bin/env bash
# PyBullet 3.2.7: every joint of a loaded URDF has a motor that holds it still until one asks for other control. Its strength is an impulse
# of 1 N s a step: 1000 N at steps of 1 ms, 240 N at the default of 1/240 s, 100 N at 10 ms. With the motor off a carriage still drags:
# mass times 0.04 v + 0.04 v^2, by which 10 N on 2 kg end at 10.7 m/s, with no air named anywhere. The motor as a Coulomb friction of 5 N
# is exact: the carriage sticks below and slides above. (`<dynamics friction>` is another matter: urdf-joint-friction.)
. "$(dirname "$0")/common.sh"
pinned pybullet==3.2.7 numpy==2.3.5
cat >carriage.urdf <<'XML'
<robot name="cylinder">
  <link name="barrel"><inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <link name="carriage"><inertial><mass value="2"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <joint name="slide" type="prismatic">
    <parent link="barrel"/><child link="carriage"/><axis xyz="1 0 0"/>
    <limit lower="-1000" upper="1000" effort="1e6" velocity="1000"/>
  </joint>
</robot>
XML
python - <<'PROGRAM' 2>&1 | grep -v "^pybullet build time"
import math

import pybullet as p


def run(force, seconds, step=1e-3, motor=None, drag=True):
    """Position and velocity of the carriage under a constant force; motor in N, None for what loading leaves."""
    p.connect(p.DIRECT)
    p.setTimeStep(step)
    body = p.loadURDF("carriage.urdf", useFixedBase=True)
    if motor is not None:
        p.setJointMotorControl2(body, 0, p.VELOCITY_CONTROL, targetVelocity=0, force=motor)
    if not drag:
        for link in (-1, 0):
            p.changeDynamics(body, link, linearDamping=0)
    for _ in range(round(seconds / step)):
        p.setJointMotorControl2(body, 0, p.TORQUE_CONTROL, force=force)
        p.stepSimulation()
    position, velocity = p.getJointState(body, 0)[:2]
    p.disconnect()
    return position, velocity


for step in (1e-3, 1 / 240, 1e-2):
    below, above = run(0.98 / step, 0.1, step), run(1.02 / step, 0.1, step)
    print(f"steps of {step:.5f} s: {0.98 / step:6.1f} N leave it at {below[0]} m, {1.02 / step:6.1f} N move it to {above[0]:.3f} m")
    assert below == (0, 0) and above[0] > 1e-3

last = run(10, 12, motor=0)[1]
free = run(10, 12, motor=0, drag=False)[1]
terminal = -0.5 + math.sqrt(0.25 + 10 / 2 / 0.04)
print(f"10 N for 12 s: {last:.2f} m/s, without linearDamping {free:.2f} m/s; 0.04 v + 0.04 v^2 = 5 m/s^2 at {terminal:.2f} m/s")
assert abs(last - terminal) < 0.02 and abs(free - 60) < 0.1

for force, expected in ((4.9, 0), (5.1, 0.05), (10, 2.5)):
    seen = run(force, 1, motor=5, drag=False)[1]
    print(f"{force} N against a motor of 5 N: {seen:.4f} m/s")
    assert abs(seen - expected) < 1e-6
PROGRAM
