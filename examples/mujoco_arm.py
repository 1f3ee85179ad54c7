"""Lifts an arm of MuJoCo with the cylinder, which sticks and slips on its way, and says how exact the coupling is.

The arm turns about a hinge; a pin on it slides in a slot of the carriage, so that the carriage is at `x` where the arm
is at the angle `asin((x - 0.25 m)/r)`. Three ways to couple both, each with one exchange per communication step:

- spring: MuJoCo moves the arm, and a stiff spring between pin and carriage pulls both. It needs nothing but forces.
- held: the cylinder moves carriage and arm as one. MuJoCo's inverse dynamics says what force the arm asks for at this
  position, velocity and acceleration. A reflected mass of the arm is part of `mass.moving`, the rest `externalForce`.
- mean: the same, with the force extrapolated to the middle of the step.

Usage: python examples/mujoco_arm.py        needs the package mujoco
"""

from __future__ import annotations

import argparse
import math
import sys
from dataclasses import dataclass

import numpy as np
import pneumatic_servo as ps

RADIUS = 0.3
"""Distance of the pin from the hinge in m."""
MIDDLE = 0.25
"""Position of the carriage in m at which the arm is level."""
TIP = (0.35, 0.2, 1.5)
"""Position of the load on the level arm, outwards and upwards in m, and its mass in kg."""
CARRIAGE = 0.88
"""Moving mass of the cylinder alone in kg."""
REFLECTED = TIP[2] * (TIP[0] ** 2 + TIP[1] ** 2) / RADIUS**2
"""Mass of the level arm as the carriage sees it in kg: the inertia about the hinge over the radius squared."""
DURATION = 2.4
"""Length of the run in s."""
SPRING, DAMPING = 1e6, 500.0

ARM = f"""
<mujoco>
  <option gravity="0 0 -9.80665" timestep="1e-3"><flag energy="enable"/></option>
  <worldbody>
    <body>
      <joint name="hinge" type="hinge" axis="0 -1 0"/>
      <inertial pos="{TIP[0]} 0 {TIP[1]}" mass="{TIP[2]}" diaginertia="1e-9 1e-9 1e-9"/>
    </body>
  </worldbody>
</mujoco>
"""
SETTINGS = {
    "chamberA.pressure0": 4e5,
    "chamberB.pressure0": 3e5,
    "position0": 0.2,
    "supplyPressure": 6e5,
}


def voltage(time: float) -> float:
    """Return the valve voltage: a slow lift at the edge of the dead zone, a fast one, and back down."""
    return 5.46 if time < 1.6 else 6.5 if time < 1.9 else 4.2


class Arm:
    """The arm as the carriage sees it."""

    def __init__(self) -> None:
        try:
            import mujoco
        except ImportError:
            sys.exit("this needs the package mujoco: pip install mujoco")
        self.mujoco = mujoco
        self.model = mujoco.MjModel.from_xml_string(ARM)
        self.data = mujoco.MjData(self.model)

    def angle(self, x: float) -> tuple[float, float, float]:
        """The angle at a position, and its first two derivatives by it."""
        angle = math.asin((x - MIDDLE) / RADIUS)
        cosine = math.cos(angle)
        return angle, 1.0 / (RADIUS * cosine), math.sin(angle) / (RADIUS**2 * cosine**3)

    def force(self, x: float, v: float, a: float) -> float:
        """Force on the carriage that the arm asks for, in N towards +x."""
        angle, slope, bend = self.angle(x)
        self.data.qpos[0], self.data.qvel[0], self.data.qacc[0] = angle, slope * v, slope * a + bend * v * v
        self.mujoco.mj_inverse(self.model, self.data)
        return slope * float(self.data.qfrc_inverse[0])

    def energy(self, x: float, v: float) -> float:
        """Potential and kinetic energy in J."""
        angle, slope, _ = self.angle(x)
        self.data.qpos[0], self.data.qvel[0] = angle, slope * v
        self.mujoco.mj_forward(self.model, self.data)
        return float(np.sum(self.data.energy))


@dataclass
class Lift:
    """A run: positions of the carriage in m each millisecond, and energies in J."""

    position: np.ndarray
    sticking: np.ndarray
    given: float = 0.0
    """Energy from the cylinder to the arm: the work of the exchanged force, and of the reflected mass."""
    taken: float = 0.0
    """By how much the energy of the arm has grown."""


def driven(way: str, step: float) -> Lift:
    """Let the cylinder move the arm, the ways `held` and `mean`."""
    arm = Arm()
    plant = ps.Model().start({**SETTINGS, "mass.moving": CARRIAGE + REFLECTED})
    count, kept = round(DURATION / step), round(1e-3 / step)
    position, sticking, last, given = [], [], None, 0.0
    before = arm.energy(plant["position"], 0.0)
    for index in range(count):
        plant["valveVoltage"] = voltage(index * step)
        x, v = plant["position"], plant["velocity"]
        # The acceleration answers the force at once; little of it is left after each round.
        for _ in range(4):
            a = plant["acceleration"]
            force = REFLECTED * a - arm.force(x, v, a)
            plant["externalForce"] = force
        trend = 0.0 if last is None or way == "held" else 0.5 * (force - last)
        last = force
        plant["externalForce"] = force + trend
        plant.step(step)
        given -= (force + trend) * (plant["position"] - x)
        if (index + 1) % kept == 0:
            position.append(plant["position"])
            sticking.append(plant["sticking"])
    x, v = plant["position"], plant["velocity"]
    given += 0.5 * REFLECTED * v * v
    return Lift(np.array(position), np.array(sticking), given, arm.energy(x, v) - before)


def sprung(step: float) -> Lift:
    """Let MuJoCo move the arm, the way `spring`."""
    arm = Arm()
    plant = ps.Model().start({**SETTINGS, "mass.moving": CARRIAGE})
    arm.model.opt.timestep = step
    # Stretched as far as it holds the arm.
    stretch = arm.force(plant["position"], 0.0, 0.0) / SPRING
    arm.data.qpos[0], _, _ = arm.angle(plant["position"] - stretch)
    arm.data.qvel[0] = 0.0
    position, sticking = [], []
    for index in range(round(DURATION / step)):
        plant["valveVoltage"] = voltage(index * step)
        angle, rate = float(arm.data.qpos[0]), float(arm.data.qvel[0])
        pin, pin_rate = MIDDLE + RADIUS * math.sin(angle), RADIUS * math.cos(angle) * rate
        force = SPRING * (pin - plant["position"]) + DAMPING * (pin_rate - plant["velocity"])
        plant["externalForce"] = force
        arm.data.qfrc_applied[0] = -force * RADIUS * math.cos(angle)
        arm.mujoco.mj_step(arm.model, arm.data)
        plant.step(step)
        if (index + 1) % round(1e-3 / step) == 0:
            position.append(plant["position"])
            sticking.append(plant["sticking"])
    return Lift(np.array(position), np.array(sticking))


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.parse_args()
    fine = driven("mean", 5e-5)
    rests = int(np.sum(np.diff(fine.sticking.astype(int)) > 0))
    begin, end = (1e3 * place for place in (fine.position[0], fine.position.max()))
    print(f"the arm rests {rests} times on its way from {begin:.0f} mm to {end:.0f} mm")
    worst = {}
    for step in (1e-3, 2.5e-4):
        for way in ("spring", "held", "mean"):
            lift = sprung(step) if way == "spring" else driven(way, step)
            worst[way, step] = float(np.abs(lift.position - fine.position).max())
            lost = (
                ""
                if way == "spring"
                else f", {1e3 * abs(lift.given - lift.taken):.2f} mJ of {lift.given:.2f} J unaccounted for"
            )
            print(f"{way:6} at {1e3 * step:.2f} ms: {1e3 * worst[way, step]:.4f} mm{lost}")
    return 0 if worst["mean", 1e-3] < 1e-4 else 1


if __name__ == "__main__":
    sys.exit(main())
