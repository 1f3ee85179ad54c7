"""Models of a user's crate, whose module stands in the place of `pneumatic_servo._native`.

The module puts itself there when it is imported, and names itself in the environment for processes that are started.
"""

from importlib import import_module
from os import environ

if module := environ.get("PNEUMATIC_SERVO_MODULE"):
    import_module(module)
