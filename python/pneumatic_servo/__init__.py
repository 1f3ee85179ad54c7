"""A friction-loaded pneumatic servo cylinder: simulate, compare friction laws, linearise, roll out, learn.

>>> import pneumatic_servo as ps
>>> plant = ps.Model("PneumaticServoCylinder")
>>> run = plant.simulate({"friction.law": "LuGre"}, inputs={"valveVoltage": 6.0}, stop=0.5, outputs=["position"])
>>> bool(run["position"][-1] > 0.25)
True

All quantities are in SI units. The same inputs give the same bits on every machine, and those of the FMU.
"""

from importlib.util import find_spec

from pneumatic_servo.bundled import fmus
from pneumatic_servo.comparison import Comparison
from pneumatic_servo.errors import Interrupted, MissingPackage, SimulationError
from pneumatic_servo.linear import Linearisation, TrimError
from pneumatic_servo.model import Model, models
from pneumatic_servo.run import Run, Runs
from pneumatic_servo.simulation import SavedState, Simulation
from pneumatic_servo.variables import Unit, Value, Variable, Variables

__all__ = [
    "Comparison",
    "Interrupted",
    "Linearisation",
    "MissingPackage",
    "Model",
    "Run",
    "Runs",
    "SavedState",
    "Simulation",
    "SimulationError",
    "TrimError",
    "Unit",
    "Value",
    "Variable",
    "Variables",
    "fmus",
    "models",
]

if find_spec("gymnasium") is not None:
    from pneumatic_servo import envs

    envs.register()
