"""A plant that is run step by step."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from pneumatic_servo import _native, checks
from pneumatic_servo.checks import mapping
from pneumatic_servo.variables import Value


class SavedState:
    """A saved state of a `Simulation`; it serves every simulation of the same model with the same parameters.

    It can be pickled, and so goes to other processes and into files.
    """

    __slots__ = ("_state",)

    def __init__(self, state: _native.SavedState) -> None:
        self._state = state

    def to_bytes(self) -> bytes:
        """Return the state as bytes, which the same version of the package reads on every platform."""
        return self._state.to_bytes()

    @classmethod
    def from_bytes(cls, data: bytes) -> SavedState:
        """Return the state of such bytes.

        Raises
        ------
        ValueError
            If the bytes are none of this version, or were changed.
        """
        return cls(_native.SavedState.from_bytes(data))

    def __reduce__(self) -> tuple[Callable[[bytes], SavedState], tuple[bytes]]:
        return SavedState.from_bytes, (self.to_bytes(),)


class Simulation:
    """A running plant: set inputs, make a step, read variables; save a state and go back to it.

    A run from a saved state repeats bit for bit. `Model.start` makes one.
    """

    __slots__ = ("_native", "get_one", "set_one", "step")

    def __init__(self, native: _native.Simulation) -> None:
        self._native = native
        # Bound once, because loops call them every step.
        self.step = native.step
        """Integrate over a step of a size in s."""
        self.set_one = native.set_one
        """Set one input or tunable parameter: name and value."""
        self.get_one = native.get
        """Return the value of one variable in its SI unit."""

    @property
    def time(self) -> float:
        """Present time in s."""
        return self._native.time

    def set(self, values: Mapping[str, Value] | None = None, /, **more: Value) -> None:
        """Set inputs and tunable parameters, by a mapping or, where the name allows, by keywords.

        They are set one after the other; each must be legal together with what is set by then. If one is refused, none
        of them is set.
        """
        self._native.set([*mapping("values", values).items(), *more.items()])

    def get(self, names: Sequence[str]) -> NDArray[np.float64]:
        """Return the values of variables, of shape (names,), in SI units."""
        return np.array([self._native.get(name) for name in checks.names("names", names)])

    def __getitem__(self, name: str) -> float:
        """Return the value of a variable in its SI unit."""
        return self._native.get(name)

    def __setitem__(self, name: str, value: Value) -> None:
        """Set an input or a tunable parameter."""
        self._native.set_one(name, value)

    def save(self) -> SavedState:
        """Return everything that affects the further run."""
        return SavedState(self._native.save())

    def restore(self, saved: SavedState) -> None:
        """Go back to a saved state."""
        self._native.restore(saved._state)

    @property
    def states(self) -> list[str]:
        """Names of the continuous states that are integrated under the present law and rig."""
        return self._native.states()

    def move_states(self, states: Mapping[str, float]) -> None:
        """Move continuous states to other values at the present time, with the present modes of valve and law.

        If one is refused, none of them is moved.
        """
        self._native.move_states(list(mapping("states", states).items()))

    def jacobian(self, of: Sequence[str], to: Sequence[str]) -> NDArray[np.float64]:
        """Return exact partial derivatives in SI units.

        Parameters
        ----------
        of : sequence of str
            Computed variables, the rows.
        to : sequence of str
            Continuous states and inputs, the columns.

        Returns
        -------
        ndarray of shape (of, to)
        """
        return self._native.jacobian(checks.names("of", of), checks.names("to", to))
