from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

from pneumatic_servo.variables import Description

_Array = NDArray[np.float64]
_Value = float | bool | str
_Setting = tuple[str, _Value]
_Grid = tuple[float, float, int, int]
_Course = float | tuple[_Array, _Array] | Callable[[float], float]
_Courses = float | _Array | tuple[_Array, _Array]
_Progress = Callable[[int], None] | None
_Noticed = tuple[str, float, str]
_Transition = tuple[list[str], list[str], list[_Array], list[tuple[int, float, str, str]]]
_Sensitivities = tuple[_Array, list[tuple[float, str, str] | None], list[tuple[float, str, float, list[float]]]]

class Model:
    def __init__(self, name: str) -> None: ...
    @property
    def name(self) -> str: ...
    @property
    def description(self) -> str: ...
    @property
    def experiment(self) -> tuple[float, float]: ...
    def variables(self) -> list[Description]: ...
    def start(self, settings: Sequence[_Setting], time: float) -> Simulation: ...

class SavedState:
    def to_bytes(self) -> bytes: ...
    @staticmethod
    def from_bytes(data: bytes) -> SavedState: ...

class Simulation:
    @property
    def time(self) -> float: ...
    def set(self, settings: Sequence[_Setting]) -> None: ...
    def set_one(self, name: str, value: _Value) -> None: ...
    def get(self, name: str) -> float: ...
    def step(self, size: float) -> None: ...
    def transition(self, size: float, parameters: Sequence[str], outputs: Sequence[str]) -> _Transition: ...
    def notices(self) -> list[_Noticed]: ...
    def save(self) -> SavedState: ...
    def restore(self, saved: SavedState) -> None: ...
    def states(self) -> list[str]: ...
    def move_states(self, states: Sequence[tuple[str, float]]) -> None: ...
    def jacobian(self, of: Sequence[str], to: Sequence[str]) -> _Array: ...

class Fleet:
    def __init__(
        self,
        model: Model,
        number: int,
        settings: Sequence[_Setting],
        input: str,  # noqa: A002
        observed: Sequence[str],
        workers: int,
    ) -> None: ...
    def restart(self, fresh: Sequence[tuple[int, Sequence[_Setting]]]) -> None: ...
    def save(self) -> list[SavedState]: ...
    def restore(self, states: Sequence[SavedState]) -> None: ...
    def observe(self) -> _Array: ...
    def step(self, inputs: _Array, size: float, steps: int) -> _Array: ...
    def transitions(
        self, inputs: _Array, size: float, steps: int, parameters: Sequence[str], outputs: Sequence[str]
    ) -> list[list[_Transition]]: ...

def models() -> list[str]: ...
def transitions(
    simulations: Sequence[Simulation], size: float, parameters: Sequence[str], outputs: Sequence[str], workers: int
) -> list[_Transition]: ...
def ssv(model: Model, name: str, description: str, settings: Sequence[_Setting]) -> str: ...
def simulate(
    model: Model,
    settings: Sequence[_Setting],
    inputs: Sequence[tuple[str, _Course]],
    grid: _Grid,
    outputs: Sequence[str],
    sensitivities: Sequence[str],
    progress: _Progress,
) -> tuple[
    _Array,
    int,
    str | None,
    BaseException | None,
    list[_Noticed],
    list[tuple[float, float]],
    _Sensitivities | None,
]: ...
def simulate_many(
    model: Model,
    settings: Sequence[_Setting],
    runs: Sequence[Sequence[_Setting]],
    inputs: Sequence[tuple[str, _Courses]],
    grid: _Grid,
    outputs: Sequence[str],
    workers: int,
    progress: _Progress,
    most: int | None = None,
) -> tuple[_Array, list[tuple[int, str | None]], BaseException | None, list[tuple[int, _Noticed]]]: ...
def gradient(
    model: Model,
    settings: Sequence[_Setting],
    inputs: Sequence[tuple[str, _Course]],
    grid: _Grid,
    outputs: Sequence[str],
    cotangents: _Array,
    parameters: Sequence[str],
) -> tuple[_Array, list[tuple[str, float]], list[float]]: ...
def tangent(
    model: Model,
    settings: Sequence[_Setting],
    inputs: Sequence[tuple[str, _Course]],
    grid: _Grid,
    outputs: Sequence[str],
    of_inputs: _Array,
    of_parameters: Sequence[tuple[str, float]],
) -> _Array: ...
