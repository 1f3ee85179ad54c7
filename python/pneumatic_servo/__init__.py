"""A friction-loaded pneumatic servo cylinder: simulate, compare friction laws, linearise, identify, roll out, learn.

>>> import pneumatic_servo as ps
>>> plant = ps.Model("PneumaticServoCylinder")
>>> run = plant.simulate({"friction.law": "LuGre"}, inputs={"valveVoltage": 6.0}, stop=0.5, outputs=["position"])
>>> bool(run["position"][-1] > 0.25)
True

All quantities are in SI units, unless a unit is given, as in ``{"supplyPressure": "6 bar"}``. The same inputs give the
same bits on every machine and in the FMU.
"""

from importlib import import_module as _import_module
from importlib.metadata import PackageNotFoundError as _NotInstalled
from importlib.metadata import version as _version
from importlib.util import find_spec as _find_spec
from typing import TYPE_CHECKING as _TYPE_CHECKING

from pneumatic_servo import _own as _own
from pneumatic_servo.bundled import fmus, parameter_sets
from pneumatic_servo.comparison import Comparison
from pneumatic_servo.data_sheet import DataSheet
from pneumatic_servo.errors import MissingPackage, NoDerivative, NotConverged, PlantWarning, Refused
from pneumatic_servo.export import export_drive, export_fmu
from pneumatic_servo.friction_tables import friction_table
from pneumatic_servo.gases import gas
from pneumatic_servo.linear import Linearisation
from pneumatic_servo.model import Model, models
from pneumatic_servo.observer import Consistency, Observer
from pneumatic_servo.playground import play
from pneumatic_servo.run import Run, Runs
from pneumatic_servo.run_errors import Interrupted, SimulationError
from pneumatic_servo.sensitivities import Crossing, Gradient, Sensitivities, Transition
from pneumatic_servo.simulation import SavedState, Simulation, transitions
from pneumatic_servo.solver_log import SolverEvent, SolverLog
from pneumatic_servo.ssv import read_ssv
from pneumatic_servo.trim import TrimError
from pneumatic_servo.variables import Unit, Value, Variable, Variables

if _TYPE_CHECKING:
    from pneumatic_servo.identification import (
        Band,
        Fit,
        Options,
        Plan,
        Posterior,
        Ranking,
        Series,
        compare_fits,
        fit,
        fit_series,
        plan,
    )  # fmt: skip

__all__ = [
    "Band",
    "Comparison",
    "Consistency",
    "Crossing",
    "DataSheet",
    "Fit",
    "Gradient",
    "Interrupted",
    "Linearisation",
    "MissingPackage",
    "Model",
    "NoDerivative",
    "NotConverged",
    "Observer",
    "Options",
    "Plan",
    "PlantWarning",
    "Posterior",
    "Ranking",
    "Refused",
    "Run",
    "Runs",
    "SavedState",
    "Sensitivities",
    "Series",
    "Simulation",
    "SimulationError",
    "SolverEvent",
    "SolverLog",
    "Transition",
    "TrimError",
    "Unit",
    "Value",
    "Variable",
    "Variables",
    "compare_fits",
    "export_drive",
    "export_fmu",
    "fit",
    "fit_series",
    "fmus",
    "friction_table",
    "gas",
    "linearise",
    "models",
    "parameter_sets",
    "plan",
    "play",
    "read_ssv",
    "transitions",
]

_FITTING = ("Band", "Fit", "Options", "Plan", "Posterior", "Ranking", "Series", "compare_fits", "fit",
            "fit_series", "plan")  # fmt: skip

try:
    __version__ = _version("pneumatic-servo")
except _NotInstalled:
    __version__ = "not installed"


def linearise(at: object = None, *, model: str = "PneumaticServoCylinder", **options: object) -> Linearisation:
    """Linearise a model at an operating point: `Model.linearise` of the model of a name.

    Examples
    --------
    >>> import pneumatic_servo as ps
    >>> ps.linearise({"velocity": 0.05, "valve.hysteresis": 0}).states[:2]
    ('position', 'velocity')
    """
    return Model(model).linearise(at, **options)  # type: ignore[arg-type]


def __getattr__(name: str) -> object:
    """Load names that need SciPy at their first use."""
    if name not in _FITTING:
        meant = f"; it is a method: {Model.__name__}().{name}" if _is_method(name) else ""
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}{meant}")
    try:
        identification = _import_module("pneumatic_servo.identification")
    except ImportError as error:
        raise MissingPackage("SciPy", "identification") from error
    return getattr(identification, name)


def _is_method(name: str) -> bool:
    return not name.startswith("_") and callable(getattr(Model, name, None))


def __dir__() -> list[str]:
    """List all names, also of modules that are loaded at their first use."""
    return sorted([*__all__, "__doc__", "__version__", "bundled", "envs", "errors"])


if _find_spec("gymnasium") is not None:
    from pneumatic_servo import envs as envs

    envs.register()
