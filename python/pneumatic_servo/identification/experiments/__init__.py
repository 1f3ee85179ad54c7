"""The experiments that a fit can be made of."""

from __future__ import annotations

from pneumatic_servo.identification.experiments.base import Beginning, Experiment, Options, Values, Window
from pneumatic_servo.identification.experiments.force import Force
from pneumatic_servo.identification.experiments.mechanical import Mechanical
from pneumatic_servo.identification.experiments.motion import Motion
from pneumatic_servo.identification.experiments.pneumatic import Pneumatic
from pneumatic_servo.identification.experiments.pushed import Pushed
from pneumatic_servo.identification.experiments.rig import Rig

__all__ = ["EXPERIMENTS", "Beginning", "Experiment", "Options", "Pushed", "Values", "Window"]

EXPERIMENTS: dict[str, type[Experiment]] = {kind.name: kind for kind in (Motion, Force, Mechanical, Pneumatic, Rig)}
"""By the name that users choose them with."""
