"""Environments for Gymnasium, single and vector: `pneumatic_servo/Positioning-v0`, and `pneumatic_servo/LiftedArm-v0`.

>>> import gymnasium
>>> import pneumatic_servo
>>> environment = gymnasium.make("pneumatic_servo/Positioning-v0", law="LuGre")
>>> fleet = gymnasium.make_vec("pneumatic_servo/Positioning-v0", num_envs=1024)

Importing `pneumatic_servo` makes them known to Gymnasium, where that is installed.
"""

from __future__ import annotations

from importlib.util import find_spec

from pneumatic_servo.errors import MissingPackage

if find_spec("gymnasium") is None:
    raise MissingPackage("Gymnasium", "gymnasium")

from gymnasium.envs import registration

from pneumatic_servo.envs.arm import Arm
from pneumatic_servo.envs.controllers import PositionControllers
from pneumatic_servo.envs.positioning import Positioning, VectorPositioning
from pneumatic_servo.envs.task import RANDOM, Task

__all__ = ["RANDOM", "Arm", "PositionControllers", "Positioning", "Task", "VectorPositioning", "register"]

NAME = "pneumatic_servo/Positioning-v0"
WITH_ARM = "pneumatic_servo/LiftedArm-v0"


def register() -> None:
    """Make the environments known to Gymnasium; importing `pneumatic_servo` does."""
    for name, given in ((NAME, {}), (WITH_ARM, {"arm": Arm()})):
        if name not in registration.registry:
            registration.register(name, entry_point=Positioning, vector_entry_point=VectorPositioning, kwargs=given)
