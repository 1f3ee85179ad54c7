"""A friction-loaded pneumatic servo cylinder: simulate, compare friction laws, linearise, roll out, learn.

>>> import pneumatic_servo as ps
>>> plant = ps.Model("PneumaticServoCylinder")
>>> run = plant.simulate({"friction.law": "LuGre"}, inputs={"valveVoltage": 6.0}, stop=0.5, outputs=["position"])
>>> bool(run["position"][-1] > 0.25)
True

All quantities are in SI units. The same inputs give the same bits on every machine, and those of the FMU.
"""

from importlib.util import find_spec
from typing import TYPE_CHECKING, Any

from pneumatic_servo.bundled import fmus
from pneumatic_servo.comparison import Comparison
from pneumatic_servo.errors import Interrupted, MissingPackage, NotConverged, SimulationError
from pneumatic_servo.linear import Linearisation
from pneumatic_servo.model import Model, models
from pneumatic_servo.playground import play
from pneumatic_servo.run import Run, Runs
from pneumatic_servo.simulation import SavedState, Simulation
from pneumatic_servo.trim import TrimError
from pneumatic_servo.variables import Unit, Value, Variable, Variables

if TYPE_CHECKING:
    from pneumatic_servo.identification import Fit, compare_fits, fit, plan

__all__ = [
    "Comparison",
    "Fit",
    "Interrupted",
    "Linearisation",
    "MissingPackage",
    "Model",
    "NotConverged",
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
    "compare_fits",
    "fit",
    "fmus",
    "models",
    "plan",
    "play",
]

_FITTING = ("Fit", "compare_fits", "fit", "plan")


def __getattr__(name: str) -> Any:
    """Load what needs SciPy when it is asked for."""
    if name not in _FITTING:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    try:
        from pneumatic_servo import identification
    except ImportError as error:
        raise MissingPackage("SciPy", "identification") from error
    return getattr(identification, name)


if find_spec("gymnasium") is not None:
    from pneumatic_servo import envs

    envs.register()
