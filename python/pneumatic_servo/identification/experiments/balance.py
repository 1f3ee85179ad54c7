"""The balance of forces along a measured motion: a start for laws that remember where they have been."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import uniform_filter1d

from pneumatic_servo.identification.experiments.base import Around, Beginning, Experiment, Values, Window
from pneumatic_servo.identification.experiments.cylinder import middle
from pneumatic_servo.identification.experiments.pushed import Pushed
from pneumatic_servo.identification.records import Record
from pneumatic_servo.identification.smoothing import fastest, follow, noise, smooth
from pneumatic_servo.model import Model
from pneumatic_servo.variables import Value

Array = NDArray[np.float64]

BALANCE = "balance"
"""The signal that is compared, whose measured value is 0."""
LOUD = 0.01
"""Share of the fastest velocity above which the noise of a velocity between two samples is smoothed away."""


class Balance(Experiment):
    """A mass that goes as its position was measured; the force, its friction and its inertia are in balance.

    ```text
    0 = W[applied - friction] - mass*W''[position]
    ```

    `W` is a weighted mean over four widths, a cubic B-spline, and `W''` the same mean of the acceleration, after two
    integrations by parts: nothing is differentiated (M. Shinbrot's modulating functions). Friction follows the law
    along the measured motion, with its history, so that no record is cut, errors of the force do not add up,
    and the search has few local minima. The noise of the position passes into the friction: what is found is a start.
    """

    name = "balance"
    required = ("time", "position")

    def __init__(self, inner: Pushed) -> None:
        self.inner = inner
        super().__init__(inner.law, inner.settings, inner.options, inner.units)
        self.signals, self.held = inner.signals, inner.held

    def make_table(self) -> Model:
        """Return the model whose parameters are known or fitted."""
        return self.inner.table

    def make_model(self) -> Model:
        """Return the bench."""
        return Model("FrictionBench")

    @property
    def compared(self) -> tuple[str, ...]:
        """The balance."""
        return (BALANCE,)

    @property
    def outputs(self) -> list[str]:
        """The friction force."""
        return ["frictionForce"]

    def window_of(self, record: Record, held: NDArray[np.bool_]) -> Window:
        """Return a whole record as a window, with two communication points a step."""
        points = len(record.grid)
        time = 0.5 * record.step * np.arange(2 * points - 1, dtype=np.float64)
        halves = {signal: np.interp(time, record.grid, record.on_grid(signal)) for signal in record.signals}
        fine = Record(record.name, time, record.begin, {**halves, BALANCE: np.zeros(len(time))})
        driven, used = self.prepare(record)
        used = np.repeat(used & ~held[np.minimum(np.arange(points), len(held) - 1)], 2)[:-1]
        used[1::2] = False
        whole = Around(0.0, record.grid, driven)
        return Window(fine, driven, np.zeros(len(time), dtype=bool), used, Beginning(), whole)

    def prepare(self, record: Record) -> tuple[Mapping[str, Array], NDArray[np.bool_]]:
        """Smooth a position whose noise would be a motion of its own; leave out the ends, which have no mean."""
        driven = {signal: record.on_grid(signal) for signal in record.signals}
        driven["direction"] = self.inner.direction(record)
        position = driven["position"]
        error = noise(record.signals["position"])
        if np.sqrt(2.0) * error / record.step > LOUD * fastest(np.gradient(position, record.step)):
            position = smooth(position, record.step, self.options.width)
        driven["path"] = follow(position - position[0], 3.0 * error)
        edge = 2 * _samples(record.step, self.options.width) + 1
        used = np.zeros(len(position), dtype=bool)
        used[edge : len(used) - edge] = True
        return driven, used

    def inputs(self, window: Window, values: Values) -> dict[str, Array]:
        """Return the position at the end of each half step, and the load level."""
        path = self.inner.beside_value("gain.position", values, 1.0) * window.driven["path"]
        level = self.inner.level(_steps(window), values)
        return {
            "prescribedPosition": _halved(np.append(path[1:], path[-1]), path),
            "friction.level": np.repeat(level, 2)[:-1],
        }

    def start(self, window: Window, values: Values) -> dict[str, Value]:
        """Start at rest at the first sample."""
        return {
            **self.of_model(values), "friction.law": self.law, "bench.drive": "PrescribedPosition",
            "driveVelocity": 0.0, "position0": 0.0,
        }  # fmt: skip

    def predict(self, window: Window, outputs: Mapping[str, Array], values: Values) -> dict[str, Array]:
        """Return minus the residual of the balance, which takes the place of a simulation.

        Friction is taken in the middle of each step: at its ends the velocity leaps, and damping with it.
        """
        applied = self.inner.applied(_steps(window), values)
        step, position = 2.0 * window.record.step, self.inner.true("position", window.driven["position"], values)
        size = _samples(step, self.options.width)
        middles = (applied[:-1] if self.options.inputs == "held" else middle(applied)[:-1]) - outputs["frictionForce"][
            1::2
        ]
        rest = np.concatenate([middles[:1], 0.5 * (middles[1:] + middles[:-1]), middles[-1:]])
        lacking = self.inner.inertia(values) * _accelerated(position, size, step) - _mean(_mean(rest, size), size)
        return {BALANCE: np.repeat(lacking, 2)[:-1]}


def _steps(window: Window) -> Window:
    """Return a window with one communication point a step."""
    record = window.record
    signals = {signal: values[::2] for signal, values in record.signals.items()}
    return replace(window, record=Record(record.name, record.time[::2], record.begin, signals))


def _halved(ends: Array, path: Array) -> Array:
    """Return where half steps end, on straight lines from where the whole ones begin."""
    halves = np.empty(2 * len(path) - 1)
    halves[::2], halves[1::2] = 0.5 * (path + ends), ends[:-1]
    return halves


def _samples(step: float, width: float) -> int:
    """Return the samples of a mean: an odd number, a quarter of a width."""
    return 2 * max(1, round(0.125 * width / step)) + 1


def _mean(values: Array, size: int) -> Array:
    """Return a moving mean."""
    return np.asarray(uniform_filter1d(values, size, mode="nearest"))


def _accelerated(position: Array, size: int, step: float) -> Array:
    """Return the mean acceleration: second differences, over the size of a mean, of the mean position."""
    mean = _mean(_mean(position, size), size)
    padded = np.pad(mean, size, mode="edge")
    return np.asarray((padded[2 * size :] - 2.0 * mean + padded[: -2 * size]) / (size * step) ** 2)
