#!/usr/bin/env bash
# One prismatic joint with `<dynamics damping="7" friction="5"/>`, `<limit effort="6" velocity="1"/>` and 10 N on 2 kg, in four simulators
# that read URDF. MuJoCo 4.0.0 applies damping, friction and effort. Drake 1.51.1 warns of the friction and goes without; the same joint
# in SDF has no warning. PyBullet 3.2.7 answers with the friction of 5 when asked and goes without. Pinocchio 4.1.0 has both numbers in its
# model, and `aba` uses neither: its acceleration is 10/2. The velocity is limited by none.
. "$(dirname "$0")/common.sh"
pinned mujoco==4.0.0 drake==1.51.1 pybullet==3.2.7 pin==4.1.0 numpy==2.3.5
python - <<'PROGRAM' 2>&1 | grep -v "^pybullet build time"
import logging

import mujoco
import numpy as np
import pinocchio
import pybullet
from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import AddMultibodyPlantSceneGraph
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder

BODY = '<link name="{}"><inertial><mass value="2"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link>'
FORCE, SECONDS, STEP = 10.0, 0.5, 1e-3


def urdf(base, damping=0, friction=0, effort=1e6, velocity=1e3):
    return f"""<robot name="cylinder">{BODY.format(base) if base != "world" else ""}{BODY.format("carriage")}
<joint name="slide" type="prismatic"><parent link="{base}"/><child link="carriage"/><axis xyz="1 0 0"/>
<limit lower="-50" upper="50" effort="{effort}" velocity="{velocity}"/><dynamics damping="{damping}" friction="{friction}"/></joint>
<transmission><type>transmission_interface/SimpleTransmission</type><joint name="slide"/><actuator name="motor"/></transmission></robot>"""


SDF = """<sdf version="1.9"><model name="cylinder"><link name="carriage"><inertial><mass>2</mass></inertial></link>
<joint name="slide" type="prismatic"><parent>world</parent><child>carriage</child><axis><xyz>1 0 0</xyz>
<limit><effort>1e6</effort></limit><dynamics><friction>5</friction></dynamics></axis></joint></model></sdf>"""


def mujoco_velocity(**joint):
    spec = mujoco.MjSpec.from_string(urdf("barrel", **joint))
    spec.option.gravity, spec.option.timestep = [0, 0, 0], STEP
    motor = spec.add_actuator(name="motor", target="slide", trntype=mujoco.mjtTrn.mjTRN_JOINT)
    motor.set_to_motor()
    model = spec.compile()
    data = mujoco.MjData(model)
    data.ctrl[0] = FORCE
    mujoco.mj_step(model, data, round(SECONDS / STEP))
    return data.qvel[0]


warnings = []
handler = logging.Handler()
handler.emit = lambda record: warnings.append(record.getMessage())
logging.getLogger("drake").addHandler(handler)


def drake_velocity(text=None, **joint):
    builder = DiagramBuilder()
    plant, _ = AddMultibodyPlantSceneGraph(builder, STEP)
    plant.mutable_gravity_field().set_gravity_vector([0, 0, 0])
    Parser(plant).AddModelsFromString(*((text, "sdf") if text else (urdf("world", **joint), "urdf")))
    plant.Finalize()
    simulator = Simulator(builder.Build())
    context = plant.GetMyMutableContextFromRoot(simulator.get_mutable_context())
    plant.get_actuation_input_port().FixValue(context, [FORCE])
    simulator.AdvanceTo(SECONDS)
    return plant.GetVelocities(context)[0]


def pybullet_velocity(**joint):
    with open("cylinder.urdf", "w") as file:
        file.write(urdf("barrel", **joint))
    pybullet.connect(pybullet.DIRECT)
    pybullet.setTimeStep(STEP)
    body = pybullet.loadURDF("cylinder.urdf", useFixedBase=True)
    pybullet.setJointMotorControl2(body, 0, pybullet.VELOCITY_CONTROL, force=0)
    for link in (-1, 0):
        pybullet.changeDynamics(body, link, linearDamping=0)
    told = pybullet.getJointInfo(body, 0)[6:8]
    for _ in range(round(SECONDS / STEP)):
        pybullet.setJointMotorControl2(body, 0, pybullet.TORQUE_CONTROL, force=FORCE)
        pybullet.stepSimulation()
    velocity = pybullet.getJointState(body, 0)[1]
    pybullet.disconnect()
    assert told == (joint.get("damping", 0), joint.get("friction", 0))
    return velocity


def pinocchio_velocity(**joint):
    model = pinocchio.buildModelFromXML(urdf("barrel", **joint))
    assert model.damping[0] == joint.get("damping", 0) and model.upperDryFrictionLimit[0] == joint.get("friction", 0)
    data, position, velocity = model.createData(), np.zeros(1), np.zeros(1)
    for _ in range(round(SECONDS / STEP)):
        velocity = velocity + STEP * pinocchio.aba(model, data, position, velocity, np.array([FORCE]))
        position = position + STEP * velocity
    return velocity[0]


free = FORCE / 2 * SECONDS
damped = FORCE / 7 * (1 - np.exp(-7 / 2 * SECONDS))
cases = {
    "free": ({}, [free, free, free, free]),
    "friction 5": ({"friction": 5}, [free / 2, free, free, free]),
    "damping 7": ({"damping": 7}, [damped, damped, damped, free]),
    "effort 6": ({"effort": 6}, [0.6 * free, 0.6 * free, free, free]),
    "velocity 1": ({"velocity": 1}, [free, free, free, free]),
}
hosts = (mujoco_velocity, drake_velocity, pybullet_velocity, pinocchio_velocity)
print(f"{'m/s after 0.5 s':16}" + "".join(f"{host.__name__.split('_')[0]:>10}" for host in hosts))
for name, (joint, expected) in cases.items():
    seen = [host(**joint) for host in hosts]
    print(f"{name:16}" + "".join(f"{velocity:10.3f}" for velocity in seen))
    assert np.allclose(seen, expected, rtol=0.01), name
    assert len(warnings) == (name == "friction 5"), warnings
    warnings.clear()
through_sdf = drake_velocity(SDF)
print(f"Drake, SDF with friction 5: {through_sdf:.3f} m/s, warnings: {warnings}")
assert abs(through_sdf - free) < 0.01 and not warnings
PROGRAM
