"""Experiments: the model that is run, its inputs, and the outputs that are compared."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Container, Iterable, Mapping, Sequence
from copy import copy
from dataclasses import dataclass, field, replace
from itertools import pairwise
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from pneumatic_servo.argument_names import quoted
from pneumatic_servo.identification.records import Record
from pneumatic_servo.identification.signals import SLIDING, Units
from pneumatic_servo.identification.smoothing import low_pass
from pneumatic_servo.model import Model
from pneumatic_servo.variables import Value

Array = NDArray[np.float64]
Values = Mapping[str, float]
"""Values of the free parameters, in SI units."""
SHORTEST = 10
"""Fewest samples of a part that is simulated in one go."""


@dataclass(frozen=True)
class Beginning:
    """Measured start values of the simulation of a window.

    Attributes
    ----------
    values : dict
        Settings of the model.
    loose : tuple of str
        The estimated ones of them, since their sensors err.
    """

    values: Mapping[str, float] = field(default_factory=dict)
    loose: tuple[str, ...] = ()

    def without(self, names: Container[str]) -> Beginning:
        """Return the start values without those fixed or estimated elsewhere."""
        values = {name: value for name, value in self.values.items() if name not in names}
        return Beginning(values, tuple(name for name in self.loose if name not in names))

    def with_more(self, values: Mapping[str, float]) -> Beginning:
        """Return the beginning with more values, which are all loose."""
        return Beginning({**self.values, **values}, (*self.loose, *values))


@dataclass(frozen=True)
class Around:
    """Values computed from the whole record of a window.

    A sensor that lags reads after the end of a window what was true within it.

    Attributes
    ----------
    begin : float
        Time in s of the record at which the window begins.
    grid : ndarray
        Communication points of the record, in s.
    driven : dict
        Values computed from its signals, at these.
    """

    begin: float
    grid: Array
    driven: Mapping[str, Array]


@dataclass(frozen=True)
class Window:
    """A stretch of a record that is simulated in one go.

    Attributes
    ----------
    record : Record
        The measured signals of the window.
    driven : dict
        Values computed from them once, at the communication points.
    held : ndarray of bool, shape (samples,)
        Samples of validation data.
    used : ndarray of bool, shape (samples,)
        Samples that are compared at all.
    begin : Beginning
        Start values of its simulation.
    around : Around
        Values computed from its whole record.
    """

    record: Record
    driven: Mapping[str, Array]
    held: NDArray[np.bool_]
    used: NDArray[np.bool_]
    begin: Beginning
    around: Around

    @property
    def fitted(self) -> int:
        """Number of the samples that are fitted."""
        return int(np.sum(self.used & ~self.held))

    def later(self, name: str, delay: float) -> Array:
        """Return what is read a delay in s after each communication point, of what was made of the record.

        Between points it is on straight lines. Of an input that is held from point to point this is its mean over the
        step.
        """
        whole = self.around
        return np.interp(whole.begin + self.record.grid + delay, whole.grid, whole.driven[name])


@dataclass(frozen=True)
class Options:
    """Options of the use of the data.

    Attributes
    ----------
    rated : float
        Normal force in N at which the load level is 1.
    width : float
        Width in s of the parabolas that give velocities.
    play : float or None
        Play in m that hides the jitter of a position at rest; by default three times its noise.
    window : float or None
        Length in s after which a simulation starts anew from what is measured; by default never.
    inputs : str
        Course of measured inputs between samples: ``held``, or on straight ``lines``.
    """

    rated: float = 1.0
    width: float = 0.04
    play: float | None = None
    window: float | None = None
    inputs: str = "held"
    smooths: bool = True
    """Whether measured forces and pressures are smoothed over the width."""
    is_cut: bool | None = None
    """Whether the user gave the length of the windows; by default where there is one."""

    @property
    def window_is_chosen(self) -> bool:
        """Whether somebody chose the length of the windows."""
        return self.window is not None if self.is_cut is None else self.is_cut


class Experiment(ABC):
    """An experiment under given settings.

    Parameters
    ----------
    law : str
        Friction law.
    settings : mapping
        Parameters that are known.
    options : Options
        Options of the use of the data.
    units : Units
        The units of the data and of the machine.
    """

    name: ClassVar[str]
    required: ClassVar[Sequence[str]]
    """Signals that have to be measured."""

    def __init__(self, law: str, settings: Mapping[str, Value], options: Options, units: Units = SLIDING) -> None:
        self.law = law
        self.units = units
        self.settings = dict(settings)
        self.options = options
        self.table = self.make_table()
        self.simulated = self.make_model()
        self.notes: list[str] = []
        self.signals: frozenset[str] = frozenset()
        self.held: dict[str, float] = {}

    def make_table(self) -> Model:
        """Return the model whose parameters are known or fitted."""
        return self.make_model()

    @abstractmethod
    def make_model(self) -> Model:
        """Return the model that is simulated."""

    def use(self, signals: Iterable[str]) -> None:
        """Take the measured signals; refuse too few."""
        self.signals = frozenset(signals)
        missing = [signal for signal in self.required if signal not in self.signals]
        if missing:
            raise ValueError(f"{quoted('experiment', self.name)} needs columns for {', '.join(self.required)}; "
                             f"{', '.join(missing)} is missing")  # fmt: skip

    @property
    @abstractmethod
    def compared(self) -> tuple[str, ...]:
        """The signals that are compared."""

    @property
    def driving(self) -> tuple[str, ...]:
        """The measured signals that drive the model."""
        return ()

    @property
    def beside(self) -> Mapping[str, str]:
        """Parameters of sensors besides the model's, fixed or estimated, with their SI units.

        What is true is ``gain.SIGNAL * (reading - offset.SIGNAL)``, and a reading comes ``delay.SIGNAL`` late; one that
        is compared may have gone through a filter of first order with the time constant ``lag.SIGNAL``.
        """
        found: dict[str, str] = {}
        for signal in (*self.compared, *self.driving):
            gain, unit = self.units.of_gain(signal), self.units.of_signal(signal)
            found |= {f"gain.{signal}": gain, f"offset.{signal}": unit, f"delay.{signal}": "s"}
        return {**found, **{f"lag.{signal}": "s" for signal in self.compared}}

    @property
    def unknown(self) -> tuple[str, ...]:
        """Parameters that have to be fixed or estimated, since the model has no default of them."""
        return ()

    @property
    def outputs(self) -> list[str]:
        """The variables of the model that are recorded: those that are compared, unless those follow from others."""
        return list(self.compared)

    @abstractmethod
    def prepare(self, record: Record) -> tuple[Mapping[str, Array], NDArray[np.bool_]]:
        """Return the prepared signals of a record, and the compared samples."""

    def begin(self, record: Record, driven: Mapping[str, Array]) -> Beginning:
        """Return the start values of the simulation of a part."""
        return Beginning()

    @abstractmethod
    def inputs(self, window: Window, values: Values) -> dict[str, Array]:
        """Return the inputs at the communication points."""

    @abstractmethod
    def start(self, window: Window, values: Values) -> dict[str, Value]:
        """Return the settings of a run, without the start values of its segment."""

    def predict(self, window: Window, outputs: Mapping[str, Array], values: Values) -> dict[str, Array]:
        """Return the compared signals at the communication points."""
        return {signal: outputs[signal] for signal in self.compared}

    def forces(self, window: Window, values: Values) -> tuple[Array, Array, Array] | None:
        """Return velocity, friction and load level as far as the data alone tell them, for a start of the fit."""
        return None

    def with_value(self, name: str, value: float) -> Experiment:
        """Return the same experiment with something that was free held at a value."""
        other = copy(self)
        other.held = {**self.held, name: value}
        return other

    def value(self, name: str, values: Values) -> float:
        """Return a parameter: fitted, known, or by default."""
        if name in values:
            return values[name]
        given = self.settings.get(name, self.table.variables[name].default)
        assert isinstance(given, float | int)
        return float(given)

    def beside_value(self, name: str, values: Values, usual: float) -> float:
        """Return something that is no parameter of the model: fitted, known, or as usual."""
        if name in values:
            return values[name]
        known = self.settings.get(name, usual)
        assert isinstance(known, float | int)
        return float(known)

    def true(self, signal: str, reading: Array, values: Values) -> Array:
        """Return the readings of a sensor, corrected by its gain and its offset."""
        gain = self.beside_value(f"gain.{signal}", values, 1.0)
        offset = self.beside_value(f"offset.{signal}", values, 0.0)
        return reading if gain == 1.0 and offset == 0.0 else gain * (reading - offset)

    def given(self, window: Window, signal: str, values: Values) -> Array:
        """Return the true values of a measured signal at the communication points."""
        return self.true(signal, self.reading(window, signal, signal, values), values)

    def reading(self, window: Window, name: str, signal: str, values: Values) -> Array:
        """Return a prepared signal, by its name, as read after the delay of its sensor."""
        delay = f"delay.{signal}"
        if delay not in values and delay not in self.settings:
            return window.driven[name]
        return window.later(name, self.beside_value(delay, values, 0.0))

    def filtered(self, signal: str, truth: Array, step: float, values: Values) -> Array:
        """Return a course at the communication points as the filter of its sensor passes it on."""
        lag = self.beside_value(f"lag.{signal}", values, 0.0)
        return truth if lag == 0.0 else low_pass(truth, step, lag)

    def read(self, signal: str, truth: Array, values: Values) -> Array:
        """Return the readings of true values."""
        gain = self.beside_value(f"gain.{signal}", values, 1.0)
        seen = truth if gain == 1.0 else truth / gain
        return seen + self.beside_value(f"offset.{signal}", values, 0.0)

    def corrected(self, begin: Beginning) -> Beginning:
        """Return true start values from readings, as far as gains and offsets of sensors are known."""
        values = dict(begin.values)
        for name in values:
            if name == "velocity0" and "velocity" not in self.signals:
                values[name] *= self.pace
            else:
                values[name] = float(self.true(name.removesuffix("0"), np.array(values[name]), {}))
        return replace(begin, values=values)

    @property
    def pace(self) -> float:
        """Factor of a slope of the measured motion, as far as a gain is known."""
        return self.beside_value("gain.velocity" if "velocity" in self.signals else "gain.position", {}, 1.0)

    def guess(self, windows: Sequence[Window], values: Values) -> dict[str, float]:
        """Return starts that the data tell of parameters of the machine."""
        return {}

    def of_model(self, values: Values) -> dict[str, Value]:
        """Return the settings and estimated parameters that the simulated model has."""
        both: dict[str, Value] = {**self.settings, **values}
        inputs = set(self.simulated.inputs) - self.signals
        return {name: value for name, value in both.items() if name in self.simulated.parameters or name in inputs}

    def windows(self, record: Record) -> list[Record]:
        """Cut a record into the parts that are simulated in one go.

        Every part begins where the carriage rests, if it does within half a part: there its velocity is known to be 0.
        """
        length = self.options.window
        if length is None:
            return [record]
        end = float(record.time[-1])
        number = max(1, round(end / length))
        inner = [self._cut(record, end * part / number, 0.5 * length) for part in range(1, number)]
        cuts = [0, *inner, len(record.time)]
        parts = [record.part(first, last) for first, last in pairwise(cuts) if last - first >= SHORTEST]
        if not parts:
            raise ValueError(
                f"{quoted('segment', length)} s: no part has {SHORTEST} samples, which are {record.step:g} s apart"
            )
        return parts

    def _cut(self, record: Record, time: float, within: float) -> int:
        resting = self.resting(record)
        near = np.flatnonzero(resting & (np.abs(record.time - time) <= within))
        if len(near):
            return int(near[np.argmin(np.abs(record.time[near] - time))])
        return int(np.searchsorted(record.time, time))

    def resting(self, record: Record) -> NDArray[np.bool_]:
        """Tell where a position does not change by more than its noise."""
        return np.zeros(len(record.time), dtype=bool)
