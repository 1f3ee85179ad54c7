"""Positioning environments for Gymnasium: `pneumatic_servo/Positioning-v0`, single and vector.

>>> import gymnasium
>>> import pneumatic_servo
>>> environment = gymnasium.make("pneumatic_servo/Positioning-v0", law="LuGre")
>>> fleet = gymnasium.make_vec("pneumatic_servo/Positioning-v0", num_envs=1024)

Importing `pneumatic_servo` makes them known to Gymnasium, where that is installed.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from pneumatic_servo.envs.task import RANDOM, Task
from pneumatic_servo.errors import MissingPackage

if TYPE_CHECKING:
    from pneumatic_servo.envs.controllers import PositionControllers as PositionControllers
    from pneumatic_servo.envs.positioning import Positioning as Positioning
    from pneumatic_servo.envs.positioning import VectorPositioning as VectorPositioning

__all__ = ["RANDOM", "PositionControllers", "Positioning", "Task", "VectorPositioning", "register"]

NAME = "pneumatic_servo/Positioning-v0"


def register() -> None:
    """Make the environments known to Gymnasium."""
    from gymnasium.envs.registration import register, registry

    if NAME not in registry:
        register(
            NAME,
            entry_point="pneumatic_servo.envs.positioning:Positioning",
            vector_entry_point="pneumatic_servo.envs.positioning:VectorPositioning",
        )


def __getattr__(name: str) -> Any:
    if name == "PositionControllers":
        from pneumatic_servo.envs import controllers

        return controllers.PositionControllers
    if name in ("Positioning", "VectorPositioning"):
        try:
            from pneumatic_servo.envs import positioning
        except ModuleNotFoundError as error:
            if error.name != "gymnasium":
                raise
            raise MissingPackage("gymnasium", "gymnasium") from error
        return getattr(positioning, name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
