"""Operating points: the states and inputs at which a plant stays as it is, or moves on steadily."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

from pneumatic_servo.model_description import ModelDescription
from pneumatic_servo.simulation import Simulation
from pneumatic_servo.variables import Value

Start = Callable[[Mapping[str, Value]], Simulation]
"""Starts a run with settings, as `Model.start` does."""


class TrimError(ValueError):
    """An operating point that cannot be found; the message names the states that do not come to rest.

    Examples
    --------
    >>> import pneumatic_servo as ps
    >>> try:
    ...     ps.Model().linearise({"velocity": 9.0, "valve.hysteresis": 0})
    ... except ps.TrimError:
    ...     print("no valve lets it move so fast")
    no valve lets it move so fast
    """


class OperatingPoint:
    """An operating point: a plant that has just been started, whose states and inputs are moved."""

    def __init__(self, model: ModelDescription, start: Start, at: Mapping[str, Value], inputs: Sequence[str]) -> None:
        self.variables = model.variables
        self.rates = {v.derivative_of: v.name for v in self.variables.values() if v.derivative_of is not None}
        self.simulation = _start(model, start, at, self.rates)
        self._given = [
            (name, float(at[key])) for name in self.simulation.states for key in (name, f"{name}0") if key in at
        ]
        self._fixed = [name for name in inputs if name in at]
        self._free = [name for name in inputs if name not in at]

    def trim(self) -> None:
        """Find free states and inputs for which all rates vanish.

        Raises
        ------
        TrimError
            When there is no such point.
        """
        reason = self.simulation._native.trim(self._given, self._fixed, self._free)
        if reason is not None:
            raise TrimError(reason)


def _start(model: ModelDescription, start: Start, at: Mapping[str, Value], rates: Mapping[str, str]) -> Simulation:
    """Start a plant at given parameters, inputs and states."""
    settings: dict[str, Value] = {}
    moved: dict[str, float] = {}
    for name, value in at.items():
        if name not in rates:
            settings[name] = value
            continue
        initial = f"{name}0"
        # Through the parameter the law starts in the mode that belongs to the state, sliding or sticking.
        if initial in model.parameters:
            settings[initial] = value
        else:
            moved[name] = float(value)
    for name in at:
        if name in rates and f"{name}0" in at:
            raise ValueError(f"{name} is given twice, as itself and as {name}0")
    simulation = start(settings)
    simulation.move_states(moved)
    return simulation
