"""The library's `PositionController` as a policy for the positioning task."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from pneumatic_servo.model import Model
from pneumatic_servo.variables import Value


class PositionControllers:
    """One `PositionController` per plant, which has the observations alone: the baseline.

    Parameters
    ----------
    number : int
        Number of plants.
    period : float
        Time between actions in s; it should be the controllers' sample time.
    parameters : mapping, optional
        Parameters of the controllers.
    stroke : float, optional
        The ``cylinder.stroke`` among the task's parameters in m, the unit of observations; its default if not given.

    Examples
    --------
    >>> import pneumatic_servo.envs as envs
    >>> task = {"law": "Stribeck", "period": 1e-3, "duration": 1.0}
    >>> fleet, controllers = envs.VectorPositioning(4, **task), envs.PositionControllers(4, period=1e-3)
    >>> observations, _ = fleet.reset(seed=1)
    >>> for _ in range(100):
    ...     observations, *_ = fleet.step(controllers(observations))
    >>> controllers(observations).shape
    (4, 1)
    """

    def __init__(
        self,
        number: int,
        period: float = 1e-3,
        parameters: Mapping[str, Value] | None = None,
        *,
        stroke: float | None = None,
    ) -> None:
        model = Model("PositionController")
        default = Model("PneumaticServoCylinder").parameters["cylinder.stroke"].default
        self._stroke = float(default or 1.0) if stroke is None else stroke
        self._period = period
        self._controllers = [model.start(parameters) for _ in range(number)]

    def __call__(self, observations: NDArray[np.float32]) -> NDArray[np.float32]:
        """Return actions of shape (plants, 1) for observations of shape (plants, 5)."""
        actions = np.empty((len(self._controllers), 1), dtype=np.float32)
        rows = observations.astype(float).tolist()
        for index, (controller, (error, position, velocity, *_)) in enumerate(
            zip(self._controllers, rows, strict=True)
        ):
            place = position * self._stroke
            controller.set({"referencePosition": place + error * self._stroke, "position": place, "velocity": velocity})
            controller.step(self._period)
            actions[index] = controller["valveVoltage"] / 5.0 - 1.0
        return actions
