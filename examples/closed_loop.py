"""Closes a position loop around the plant step by step: the commonest use of the plant.

A PI-P controller (velocity inside, position outside) with compensation of the valve's dead zone moves the carriage
along a smooth trajectory, at 1 ms.
"""

from __future__ import annotations

import argparse
import sys
from dataclasses import dataclass

import numpy as np
import pneumatic_servo as ps

PERIOD = 1e-3


@dataclass
class Controller:
    """Position controller with feed-forward of the velocity; `dead_zone` is the valve's overlap in V."""

    position_gain: float = 12.0
    velocity_gain: float = 8.0
    integral_gain: float = 10.0
    feed_forward: float = 1.6
    dead_zone: float = 0.4
    integral: float = 0.0

    def voltage(self, reference: float, slope: float, position: float, velocity: float) -> float:
        wanted = slope + self.position_gain * (reference - position)
        error = wanted - velocity
        self.integral = float(np.clip(self.integral + self.integral_gain * error * PERIOD, -1.0, 1.0))
        command = self.feed_forward * wanted + self.velocity_gain * error + self.integral
        return float(np.clip(5.0 + command + self.dead_zone * np.tanh(command / 0.1), 0.0, 10.0))


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.parse_args()
    controller = Controller()
    errors = []
    plant = ps.Model("PneumaticServoCylinder").start({"supplyPressure": 6e5, "position0": 0.15})
    for step in range(4000):
        reference, slope = trajectory(step * PERIOD)
        position, velocity = plant.get(["position", "velocity"])
        errors.append(reference - position)
        plant["valveVoltage"] = controller.voltage(reference, slope, position, velocity)
        plant.step(PERIOD)
    settled = np.abs(errors[1000:])
    rms, largest = 1e3 * np.sqrt(np.mean(settled**2)), 1e3 * settled.max()
    print(f"tracking error after 1 s: rms {rms:.2f} mm, largest {largest:.2f} mm")
    return 0 if settled.max() < 8e-3 else 1


def trajectory(t: float) -> tuple[float, float]:
    """Position in m and velocity in m/s: 200 mm peak to peak at 0.5 Hz."""
    phase = np.pi * t
    return 0.25 - 0.1 * np.cos(phase), 0.1 * np.pi * np.sin(phase)


if __name__ == "__main__":
    sys.exit(main())
