"""Runs as functions that PyTorch differentiates.

>>> import torch                                                     # doctest: +SKIP
>>> import pneumatic_servo as ps                                     # doctest: +SKIP
>>> import pneumatic_servo.torch                                     # doctest: +SKIP
>>> run = ps.torch.trajectory(ps.Model(), inputs=["valveVoltage"], outputs=["position"], stop=0.2)    # doctest: +SKIP
>>> voltage = torch.full((1, run.steps), 6.5, dtype=torch.float64, requires_grad=True)    # doctest: +SKIP
>>> run(torch.zeros(0), voltage)[0, -1].backward()                   # doctest: +SKIP
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from pneumatic_servo.constant_voltage import AtRest
from pneumatic_servo.differentiable import Function, Trajectory
from pneumatic_servo.errors import MissingPackage
from pneumatic_servo.model import Model, Parameters

try:
    import torch
except ImportError as error:
    raise MissingPackage("PyTorch", "torch") from error

__all__ = ["Run", "trajectory"]


class Run(Function):
    """A run as a function: ``run(parameters, inputs)`` returns the outputs, of shape (outputs, rows).

    Attributes
    ----------
    parameters, inputs, outputs : list of str
        Names of the rows of what goes in and comes out.
    steps : int
        Values of each input, which are held over a step.
    times : ndarray of shape (rows,)
        Times of the rows in s.
    """

    def __call__(self, parameters: torch.Tensor, inputs: torch.Tensor) -> torch.Tensor:
        """Return the outputs, of shape (outputs, rows), with 64 bits.

        Parameters
        ----------
        parameters : tensor of shape (parameters,)
            Their values in SI units.
        inputs : tensor of shape (inputs, steps)
            Values of the inputs over each step in SI units.

        Raises
        ------
        ValueError
            For tensors of other shapes.
        """
        self._check(parameters, inputs)
        found: torch.Tensor = _Run.apply(self._made, parameters, inputs)
        return found


class _Run(torch.autograd.Function):
    """The run with the adjoint of its transitions."""

    @staticmethod
    def forward(ctx: Any, made: Trajectory, parameters: torch.Tensor, inputs: torch.Tensor) -> torch.Tensor:
        ctx.made = made
        ctx.save_for_backward(parameters, inputs)
        ctx.save_for_forward(parameters, inputs)
        return torch.from_numpy(made.values(_numbers(parameters), _numbers(inputs)))

    @staticmethod
    def backward(ctx: Any, *cotangents: torch.Tensor) -> tuple[None, torch.Tensor, torch.Tensor]:
        parameters, inputs = ctx.saved_tensors
        found = ctx.made.pull(_numbers(parameters), _numbers(inputs), _numbers(cotangents[0]))
        by_parameters, by_inputs = (torch.from_numpy(np.ascontiguousarray(array)) for array in found)
        return None, by_parameters.to(parameters.dtype), by_inputs.to(inputs.dtype)

    @staticmethod
    def jvp(ctx: Any, *tangents: Any) -> torch.Tensor:
        parameters, inputs = ctx.saved_tensors
        moved = [
            np.zeros(tuple(tensor.shape)) if tangent is None else _numbers(tangent)
            for tensor, tangent in zip((parameters, inputs), tangents[1:], strict=True)
        ]
        return torch.from_numpy(ctx.made.push(_numbers(parameters), _numbers(inputs), *moved))


def _numbers(tensor: torch.Tensor) -> Any:
    return tensor.detach().to(dtype=torch.float64, device="cpu").numpy()


def trajectory(
    model: Model,
    *,
    parameters: Sequence[str] = (),
    inputs: Sequence[str] = (),
    outputs: Sequence[str],
    given: Parameters | None = None,
    stop: float | None = None,
    step: float | None = None,
    at_rest: AtRest = "mean",
) -> Run:
    """Return a run of a model as a function that PyTorch differentiates, exactly through stick and slip.

    Parameters
    ----------
    model : Model
        The model.
    parameters, inputs, outputs : sequence of str
        Real parameters and inputs that vary, and what is recorded.
    given : mapping or path, optional
        Other parameters and start values, as for `Model.simulate`.
    stop, step : float, optional
        End and size of the steps in s.
    at_rest : str
        Choice of the derivative by a constant voltage: as for `Run.vjp`.

    Returns
    -------
    Run
        To be called with tensors for parameters and inputs.

    Raises
    ------
    ValueError
        For names that are unknown or given twice, and outputs that are no real numbers.
    """
    made = Trajectory(
        model, parameters=parameters, inputs=inputs, outputs=outputs, given=given, stop=stop, step=step,
        at_rest=at_rest,
    )  # fmt: skip
    return Run(made)
