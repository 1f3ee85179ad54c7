"""The plant as a nonlinear system of python-control."""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from pneumatic_servo.errors import MissingPackage
from pneumatic_servo.names import did_you_mean
from pneumatic_servo.simulation import SavedState, Simulation

if TYPE_CHECKING:
    import control

Array = NDArray[np.float64]
KEPT = 64
"""States of which the modes and discrete states are kept: those of the last steps."""


class Sampled:
    """A simulation as functions of states and inputs.

    Modes, such as sticking, and discrete states belong to the states that a step has led to. Other states, which nobody
    has come to, have those of the start.
    """

    def __init__(self, simulation: Simulation, inputs: Sequence[str], outputs: Sequence[str], period: float) -> None:
        self._simulation, self._inputs, self._outputs, self._period = simulation, inputs, outputs, period
        self.states = simulation.states
        self._begin = simulation.save()
        self._known: OrderedDict[bytes, SavedState] = OrderedDict()
        self.start = simulation.get(self.states)
        self._keep(self.start)

    def _keep(self, state: Array) -> None:
        self._known[state.tobytes()] = self._simulation.save()
        while len(self._known) > KEPT:
            self._known.popitem(last=False)

    def _go(self, state: Any, inputs: Any) -> None:
        x = np.ascontiguousarray(state, dtype=np.float64)
        known = self._known.get(x.tobytes())
        if known is None and not x.any() and self.start.any():
            raise ValueError("the plant has no state of zeros: give X0=system.x0, its state at the start")
        self._simulation.restore(self._begin if known is None else known)
        if known is None:
            self._simulation.move_states(dict(zip(self.states, x.tolist(), strict=True)))
        for name, value in zip(self._inputs, np.asarray(inputs, dtype=np.float64).tolist(), strict=True):
            self._simulation.set_one(name, value)

    def update(self, _time: float, state: Any, inputs: Any, _params: object) -> Array:
        """Return the states a period later."""
        self._go(state, inputs)
        self._simulation.step(self._period)
        there = self._simulation.get(self.states)
        self._keep(there)
        return there

    def output(self, _time: float, state: Any, inputs: Any, _params: object) -> Array:
        """Return the outputs."""
        self._go(state, inputs)
        return self._simulation.get(self._outputs)


def to_iosys(
    simulation: Simulation, inputs: Sequence[str], outputs: Sequence[str], period: float
) -> control.NonlinearIOSystem:
    """Return a system of a simulation that has been started; see `Model.to_iosys`."""
    try:
        import control
    except ImportError as error:
        raise MissingPackage("python-control", "control") from error
    model = simulation._model
    for argument, chosen, there in (("inputs", inputs, model.inputs), ("outputs", outputs, model.variables)):
        unknown = next((name for name in chosen if name not in there), None)
        if unknown is not None or not chosen:
            hint = "name at least one" if unknown is None else f"there is no {unknown}{did_you_mean(unknown, there)}"
            raise ValueError(f"{argument}: {hint}")
    sampled = Sampled(simulation, inputs, outputs, period)
    # Its names of signals may have no dots.
    plain = {
        key: [name.replace(".", "_") for name in names]
        for key, names in (("states", sampled.states), ("inputs", inputs), ("outputs", outputs))
    }
    system = control.NonlinearIOSystem(sampled.update, sampled.output, dt=period, name=model.name, **plain)
    system.x0 = sampled.start
    return system
