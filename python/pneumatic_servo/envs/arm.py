"""A lever arm that the cylinder lifts, in closed form."""

from __future__ import annotations

from dataclasses import dataclass, fields

import numpy as np
from numpy.typing import NDArray

from pneumatic_servo.values import number_in

Array = NDArray[np.float64]

GRAVITY = 9.80665
"""Acceleration of gravity in m/s2, as in the plant."""
UNITS = {"radius": "m", "middle": "m", "outwards": "m", "upwards": "m", "mass": "kg"}
BEYOND = 0.01
"""Distance in m by which the carriage may leave the stroke, into its end stops."""


@dataclass(frozen=True)
class Arm:
    """An arm about a hinge, whose pin slides in a slot of the carriage; it has no friction of its own.

    The carriage is at ``middle + radius*sin(angle)``, and the arm is level at the angle 0.

    Attributes
    ----------
    radius : float
        Distance of the pin from the hinge in m, or with a unit, as all of these.
    middle : float
        Position of the carriage in m at which the arm is level.
    outwards, upwards : float
        Position of the load on the level arm in m from the hinge, away from it and above it.
    mass : float
        Mass of the load in kg, a point.

    Examples
    --------
    >>> import pneumatic_servo.envs as envs
    >>> environment = envs.Positioning(arm=envs.Arm(radius="0.3 m", mass=2.0))
    >>> observation, _ = environment.reset(seed=1)
    >>> environment.observation_space.contains(observation)
    True
    """

    radius: float = 0.3
    middle: float = 0.25
    outwards: float = 0.35
    upwards: float = 0.2
    mass: float = 1.5

    def in_si(self, stroke: float) -> Arm:
        """Return the same in SI units; an arm that cannot follow a stroke in m is refused."""
        given = {
            one.name: number_in(UNITS[one.name], f"arm: {one.name}", getattr(self, one.name)) for one in fields(self)
        }
        arm = Arm(**given)
        for name in ("radius", "mass"):
            if not given[name] > 0.0:
                raise ValueError(f"arm: {name} = {given[name]:g} {UNITS[name]} is refused: it must be positive")
        reach = max(arm.middle, stroke - arm.middle) + BEYOND
        if arm.radius <= reach:
            raise ValueError(
                f"arm: radius = {arm.radius:g} m is refused: the carriage moves up to {reach:g} m away from middle = "
                f"{arm.middle:g} m, and the radius must be larger"
            )
        if arm.inertia == 0.0:
            raise ValueError("arm: outwards and upwards are both 0: the load must be away from the hinge")
        return arm

    @property
    def inertia(self) -> float:
        """Moment of inertia about the hinge in kg.m2."""
        return self.mass * (self.outwards**2 + self.upwards**2)

    @property
    def reflected(self) -> float:
        """Mass of the level arm as the carriage sees it in kg, which is the least of all positions."""
        return self.inertia / self.radius**2

    def resistance(self, position: Array, velocity: Array) -> tuple[Array, Array]:
        """Return the mass in kg that the carriage sees, and the force in N against it at a constant velocity.

        Arithmetic and square roots alone: many plants have the bits of one.
        """
        sine = (position - self.middle) / self.radius
        square = 1.0 - sine * sine
        seen: Array = self.reflected / square
        slope = 1.0 / (self.radius * np.sqrt(square))
        weight = self.mass * GRAVITY * (self.outwards - self.upwards * sine * self.radius * slope) / self.radius
        force: Array = weight + seen * sine / (self.radius * square) * velocity * velocity
        return seen, force
