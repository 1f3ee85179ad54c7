"""Runs as functions of arrays, with their derivatives, for `jax` and `torch`."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from pneumatic_servo import _native, constant_voltage, defaults
from pneumatic_servo.checks import names
from pneumatic_servo.errors import NoDerivative
from pneumatic_servo.grid import Grid
from pneumatic_servo.names import did_you_mean
from pneumatic_servo.sensitivities import Followers, along_leaders

if TYPE_CHECKING:
    from pneumatic_servo.model import Model, Parameters

Array = NDArray[np.float64]


class Trajectory:
    """Recorded variables of a run as a function of parameters, of shape (parameters,), and inputs (inputs, steps).

    Each column of the inputs is held over a step. What is recorded has the shape (outputs, rows), with a row at the
    start and after every step.

    Attributes
    ----------
    parameters, inputs, outputs : list of str
        Their names.
    times : ndarray of shape (rows,)
        Times of the rows in s.
    """

    def __init__(
        self,
        model: Model,
        *,
        parameters: Sequence[str],
        inputs: Sequence[str],
        outputs: Sequence[str],
        given: Parameters | None,
        stop: float | None,
        step: float | None,
        at_rest: str = "mean",
    ) -> None:
        constant_voltage.check(at_rest)
        self._at_rest = at_rest
        self.parameters, self.inputs = names("parameters", parameters), names("inputs", inputs)
        for name in self.parameters:
            if name not in model.parameters:
                raise ValueError(f"parameters: {name} is no parameter{did_you_mean(name, model.parameters)}")
            if model.parameters[name].kind != "real":
                raise ValueError(f"parameters: {name} is no real number, and nothing can be differentiated by it")
        for name in self.inputs:
            if name not in model.inputs:
                raise ValueError(f"inputs: {name} is not an input{did_you_mean(name, model.inputs)}")
            if model.inputs[name].kind != "real":
                raise ValueError(f"inputs: {name} is true or false, and nothing can be differentiated by it")
        self.outputs = list(model._recorded(outputs, {}))
        wrong = next((name for name in self.outputs if model.variables[name].kind != "real"), None)
        if wrong is not None:
            raise ValueError(f"outputs: {wrong} is no real number, and has no derivative")
        self._model = model
        self._given = model._settings(given, "given")
        twice = next((name for name in self._given if name in {*self.parameters, *self.inputs}), None)
        if twice is not None:
            raise ValueError(f"{twice} is given twice, as what varies and among what is given")
        self._grid = Grid.of(0.0, model.stop if stop is None else stop, model.step if step is None else step, 1)
        for what, given_names in (("parameters", self.parameters), ("inputs", self.inputs)):
            twice = next((name for name in given_names if given_names.count(name) > 1), None)
            if twice is not None:
                raise ValueError(f"{what}: {twice} is given twice")
        self._places = [list(model.inputs).index(name) for name in self.inputs]
        self.times = self._grid.times()

    @property
    def steps(self) -> int:
        """Number of steps: a value of each input for each."""
        return self._grid.count

    def values(self, parameters: Array, inputs: Array) -> Array:
        """Return the recorded outputs, of shape (outputs, rows)."""
        run = self._model.simulate(
            self._settings(parameters),
            inputs=dict(self._driven(inputs)),
            stop=float(self.times[-1]),
            step=self._grid.step,
            outputs=self.outputs,
        )
        return np.stack([run[name] for name in self.outputs])

    def push(self, parameters: Array, inputs: Array, of_parameters: Array, of_inputs: Array) -> Array:
        """Return the derivatives of the outputs along a direction, of shape (outputs, rows)."""
        added = np.zeros((len(self._model.inputs), self.steps))
        added[self._places] = of_inputs
        model, settings, driven, grid, outputs = self._arguments(parameters, inputs)
        by = dict(zip(self.parameters, map(float, of_parameters), strict=True))
        followed = self._followers(parameters, settings).items()
        seeds = [*by.items(), *((name, slope * by[leader]) for name, (leader, slope) in followed)]
        found = _native.tangent(model, settings, driven, grid, outputs, added, seeds)
        if np.isnan(found).any() and self._at_rest != "refuse" and constant_voltage.VOLTAGE in self.inputs:
            found = self._pushed_at_rest(parameters, inputs, added, seeds)
        lacking = np.isnan(found).any(axis=0)
        if lacking.any():
            raise NoDerivative(float(self.times[np.argmax(lacking)]), "the recorded outputs", constant_voltage.REASON)
        return found

    def _pushed_at_rest(
        self, parameters: Array, inputs: Array, added: Array, seeds: Sequence[tuple[str, float]]
    ) -> Array:
        """Return the change along a direction that moves a voltage which rests."""
        model, settings, driven, grid, outputs = self._arguments(parameters, inputs)
        if self._at_rest == "zero":
            every_row = np.ones((len(outputs), len(self.times)))
            by_inputs, _, _ = _native.gradient(model, settings, driven, grid, outputs, every_row, [])
            moved = added.copy()
            every = list(self._model.inputs)
            moved[every.index(constant_voltage.VOLTAGE), constant_voltage.lacking(every, by_inputs)] = 0.0
            return _native.tangent(model, settings, driven, grid, outputs, moved, seeds)
        row = self.inputs.index(constant_voltage.VOLTAGE)
        sides = [
            _native.tangent(model, settings, self._driven(_with_row(inputs, row, side)), grid, outputs, added, seeds)
            for side in constant_voltage.nearby(np.asarray(inputs[row], dtype=np.float64))
        ]
        return np.asarray(np.mean(sides, axis=0))

    def pull(self, parameters: Array, inputs: Array, cotangents: Array) -> tuple[Array, Array]:
        """Return the derivatives, by parameters and inputs, of the sum of outputs times cotangents."""
        weights = np.ascontiguousarray(cotangents, dtype=np.float64)
        model, settings, driven, grid, outputs = self._arguments(parameters, inputs)
        followed = self._followers(parameters, settings)
        by = [*self.parameters, *followed]
        found, _, slopes = _native.gradient(model, settings, driven, grid, outputs, weights, by)
        of_parameters = along_leaders(self.parameters, np.asarray(slopes), followed)
        if constant_voltage.VOLTAGE in self.inputs:
            row = self.inputs.index(constant_voltage.VOLTAGE)

            def again(voltage: Array) -> Array:
                held = self._driven(_with_row(inputs, row, voltage))
                return _native.gradient(model, settings, held, grid, outputs, weights, by)[0]

            every = list(self._model.inputs)
            found = constant_voltage.settled(every, found, self._at_rest, lambda: np.asarray(inputs[row], float), again)
        of_inputs = found[self._places]
        constant_voltage.refuse(self.inputs, of_inputs, self.times)
        for name, slope in zip(self.parameters, of_parameters, strict=True):
            if np.isnan(slope):
                raise NoDerivative(0.0, name, "what follows depends on it in another way to either side")
        return np.array(of_parameters), of_inputs

    def _followers(self, parameters: Array, settings: Sequence[tuple[str, Any]]) -> Followers:
        """Return the defaults that follow one of the parameters."""
        found = defaults.followers(self._model.variables, self._settings(parameters), dict(settings))
        return {name: follows for name, follows in found.items() if follows[0] in self.parameters}

    def _settings(self, parameters: Array) -> dict[str, float]:
        return {**self._given, **dict(zip(self.parameters, map(float, parameters), strict=True))}  # type: ignore[dict-item]

    def _driven(self, inputs: Array) -> list[tuple[str, tuple[Array, Array]]]:
        held = np.ascontiguousarray(inputs, dtype=np.float64)
        return [(name, (self._grid.points()[:-1], row)) for name, row in zip(self.inputs, held, strict=True)]

    def _arguments(self, parameters: Array, inputs: Array) -> tuple[Any, ...]:
        settings = self._model._fitted(self._settings(parameters))
        return self._model._native, list(settings.items()), self._driven(inputs), self._grid.numbers, self.outputs


def _with_row(inputs: Array, row: int, course: Array) -> Array:
    moved = np.array(inputs, dtype=np.float64)
    moved[row] = course
    return moved


class Function:
    """A run as a function, ``run(parameters, inputs)``: the common part of `jax.Run` and `torch.Run`."""

    def __init__(self, made: Trajectory) -> None:
        self.parameters, self.inputs, self.outputs = made.parameters, made.inputs, made.outputs
        self.steps, self.times, self._made = made.steps, made.times, made

    def _check(self, parameters: Any, inputs: Any) -> None:
        """Refuse arrays of other shapes than (parameters,) and (inputs, steps)."""
        expected = [(len(self.parameters),), (len(self.inputs), self.steps)]
        for name, array, shape in zip(("parameters", "inputs"), (parameters, inputs), expected, strict=True):
            if tuple(array.shape) != shape:
                raise ValueError(f"{name} have the shape {tuple(array.shape)}; it must be {shape}")
