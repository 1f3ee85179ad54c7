"""Runs as functions that JAX transforms: `jit`, `grad`, `jvp`, `vmap`.

>>> import jax, jax.numpy as jnp                                     # doctest: +SKIP
>>> import pneumatic_servo as ps                                     # doctest: +SKIP
>>> import pneumatic_servo.jax                                       # doctest: +SKIP
>>> run = ps.jax.trajectory(ps.Model(), inputs=["valveVoltage"], outputs=["position"], stop=0.2)    # doctest: +SKIP
>>> voltage = jnp.full((1, run.steps), 6.5)                          # doctest: +SKIP
>>> jax.grad(lambda u: run(jnp.zeros(0), u)[0, -1])(voltage).shape   # doctest: +SKIP
(1, 200)
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from pneumatic_servo.constant_voltage import AtRest
from pneumatic_servo.differentiable import Function, Trajectory
from pneumatic_servo.errors import MissingPackage
from pneumatic_servo.model import Model, Parameters

try:
    import jax
    from jax import numpy as jnp
    from jax.extend.core import Primitive
    from jax.interpreters import ad, batching, mlir
except ImportError as error:
    raise MissingPackage("JAX", "jax") from error

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

    def __init__(self, made: Trajectory) -> None:
        super().__init__(made)
        self._call = _differentiable(made)

    def __call__(self, parameters: Any, inputs: Any) -> jax.Array:
        """Return the outputs, of shape (outputs, rows).

        Parameters
        ----------
        parameters : array of shape (parameters,)
            Their values in SI units.
        inputs : array of shape (inputs, steps)
            Values of the inputs over each step in SI units.

        Raises
        ------
        TypeError
            Unless JAX computes with 64 bits.
        ValueError
            For arrays of other shapes.
        """
        if jnp.zeros(()).dtype != jnp.float64:
            raise TypeError('runs need 64 bits: jax.config.update("jax_enable_x64", True)')
        given = [jnp.asarray(parameters, dtype=jnp.float64), jnp.asarray(inputs, dtype=jnp.float64)]
        self._check(*given)
        found: jax.Array = self._call(*given)
        return found


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
    """Return a run of a model as a function that JAX differentiates, exactly through stick and slip.

    Runs are made on the host, one after the other: `jit` calls back, and `vmap` makes one run after another. A
    derivative takes the run again, and the transitions of its steps (`Run.vjp`).

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
        To be called with arrays for parameters and inputs.

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


def _differentiable(made: Trajectory) -> Callable[..., jax.Array]:
    of_run = jax.ShapeDtypeStruct((len(made.outputs), len(made.times)), jnp.float64)
    of_inputs = jax.ShapeDtypeStruct((len(made.parameters) + len(made.inputs) * made.steps,), jnp.float64)

    def back(function: Callable[..., Any], shapes: Any, *arrays: Any) -> Any:
        """Call a function of NumPy arrays."""

        def call(*arrays: Any) -> Any:
            return function(*(np.asarray(array, dtype=np.float64) for array in arrays))

        return jax.pure_callback(call, shapes, *arrays, vmap_method="sequential")

    def apart(flat: Any) -> tuple[Any, Any]:
        return flat[: len(made.parameters)], flat[len(made.parameters) :].reshape(len(made.inputs), made.steps)

    def pull(flat: Any, cotangents: Any) -> Any:
        return np.concatenate([part.ravel() for part in made.pull(*apart(flat), cotangents)])

    def pushed(at: Any, moved: Any) -> Any:
        return back(lambda at, moved: made.push(*apart(at), *apart(moved)), of_run, at, moved)

    def pulled(cotangents: Any, at: Any, moved: Any) -> tuple[None, Any]:
        return None, ad.Zero(moved.aval) if type(cotangents) is ad.Zero else back(pull, of_inputs, at, cotangents)

    def one_by_one(arrays: Any, axes: Any) -> tuple[Any, int]:
        size = next(array.shape[axis] for array, axis in zip(arrays, axes, strict=True) if axis is not None)
        stacked = [batching.bdim_at_front(array, axis, size) for array, axis in zip(arrays, axes, strict=True)]
        return jax.lax.map(lambda pair: push.bind(*pair), tuple(stacked)), 0

    # Linear in the tangent, with a transpose of its own: so both modes have one rule.
    push = Primitive("run_tangent")
    push.def_impl(pushed)
    push.def_abstract_eval(lambda at, moved: jax.core.ShapedArray(of_run.shape, of_run.dtype))
    mlir.register_lowering(push, mlir.lower_fun(pushed, multiple_results=False))
    ad.primitive_transposes[push] = pulled
    batching.primitive_batchers[push] = one_by_one

    # One array, so that a derivative by some of it alone is one by all.
    @jax.custom_jvp
    def of_flat(flat: Any) -> Any:
        return back(lambda flat: made.values(*apart(flat)), of_run, flat)

    @of_flat.defjvp
    def _(primals: tuple[Any], tangents: tuple[Any]) -> tuple[Any, Any]:
        return of_flat(*primals), push.bind(primals[0], tangents[0])

    def run(parameters: Any, inputs: Any) -> Any:
        return of_flat(jnp.concatenate([parameters, inputs.ravel()]))

    function: Callable[..., jax.Array] = run
    return function
