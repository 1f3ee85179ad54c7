"""Experiments that a fit can be made of: the model that is run, its inputs, and the compared signals.

The crate `fit` has the experiments, for the page as well; here are the units of a machine and the model's variables.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from copy import copy
from dataclasses import dataclass, field, replace
from functools import cached_property, partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pneumatic_servo import _native
from pneumatic_servo.argument_names import quoted
from pneumatic_servo.identification.records import Record, plain
from pneumatic_servo.identification.signals import SLIDING, Units
from pneumatic_servo.identification.table import Measured
from pneumatic_servo.identification.ties import Tie
from pneumatic_servo.model import Model
from pneumatic_servo.variables import Value

Array = NDArray[np.float64]
Values = Mapping[str, float]
"""Values of the free parameters, in SI units."""


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

    @cached_property
    def native(self) -> _native.Segment:
        """The window as the crate takes it."""
        whole = (self.around.begin, plain(self.around.grid), _plain(self.around.driven))
        return _native.Segment(self.record.numbers, _plain(self.driven), self.used, self.held, whole)

    def __getstate__(self) -> dict[str, Any]:
        """Return what is sent to other processes."""
        return {name: value for name, value in self.__dict__.items() if name != "native"}


INPUTS = ("held", "lines", "smooth")
"""Courses of measured inputs between samples."""


@dataclass(frozen=True)
class Options:
    """Options of the use of the data.

    Attributes
    ----------
    rated : float
        Normal force in N at which the load factor is 1.
    width : float
        Width in s of the parabolas that give velocities.
    play : float or None
        Play in m that hides the jitter of a position at rest; by default three times its noise.
    window : float or None
        Length in s after which a simulation starts anew from what is measured; by default the length of the experiment:
        about 0.15 s where measured forces move a mass, never otherwise.
    inputs : str or None
        Course of measured inputs between samples: ``hold``, on straight ``lines``, or ``smooth``, on a curve through
        them; by default held, but of ``force`` the one that leaves least. Pressures that move a mass are always smooth.

    Examples
    --------
    >>> import numpy as np
    >>> import pneumatic_servo as ps
    >>> t = np.arange(0.0, 1.0, 0.02)
    >>> noise = 0.1 * np.random.default_rng(0).standard_normal(len(t))
    >>> data = {"time": t, "position": 0.01 * np.sin(6.0 * t), "frictionForce": 7.0 * np.sign(np.cos(6.0 * t)) + noise}
    >>> found = ps.fit(data, experiment="motion", law="Coulomb", starts=0, rated=100.0, progress=False)
    >>> found.problem.experiment.options == ps.Options(rated=100.0)
    True
    """

    rated: float = 1.0
    width: float = 0.04
    play: float | None = None
    window: float | None = None
    inputs: str | None = None
    smoothing: bool | None = None
    """Whether measured forces and pressures are smoothed over the width; by default the data choose."""


class Experiment:
    """An experiment under given settings.

    Parameters
    ----------
    name : str
        Name of the experiment.
    law : str
        Friction law.
    settings : mapping
        Parameters that are known.
    options : Options
        Options of the use of the data.
    units : Units
        The units of the data and of the machine.
    """

    def __init__(
        self, name: str, law: str, settings: Mapping[str, Value], options: Options, units: Units = SLIDING
    ) -> None:
        table, simulated = MODELS[name]
        self.name = name
        self.law = law
        self.units = units
        self.settings = dict(settings)
        self.options = options
        self.table = Model(table)
        self.simulated = self.table if simulated == table else Model(simulated)
        self.notes: list[str] = []
        self.signals: frozenset[str] = frozenset()
        self.ties: tuple[Tie, ...] = ()

    def __getstate__(self) -> dict[str, Any]:
        """Return what is sent to other processes."""
        return {name: value for name, value in self.__dict__.items() if name not in MADE}

    def _with(self, **changes: Any) -> Experiment:
        other = copy(self)
        other.__dict__.update(changes)
        return other

    def tied(self, values: Values) -> dict[str, float]:
        """Return values with the parameters that follow from them."""
        return self.native.tied([(tie.name, tie.text) for tie in self.ties], dict(values))

    def with_options(self, **changes: Any) -> Experiment:
        """Return the same experiment with other options, and without notes."""
        return self._with(options=replace(self.options, **changes), notes=[])

    def use(self, signals: Iterable[str]) -> None:
        """Take the measured signals; refuse too few."""
        self.signals = frozenset(signals)
        for name in MADE:
            self.__dict__.pop(name, None)
        try:
            assert self.native
        except ValueError as error:
            told = str(error).replace(f"experiment {self.name}", quoted("experiment", self.name), 1)
            raise ValueError(told) from None
        if self.name != "force":
            return
        if self.units.is_rotating and "incline" in self.settings:
            raise ValueError(f"{quoted('settings', 'incline')}: a rotating machine has none; its mass is an inertia")
        for name in ("spring", "springRest"):
            if name in self.settings and "position" not in self.signals:
                raise ValueError(f"{quoted('settings', name)}: a spring needs a column for position")

    @cached_property
    def native(self) -> _native.Experiment:
        """The experiment of the crate."""
        variables, options = self.table.variables, self.options
        known = {name: float(variables[name].ids[value]) if isinstance(value, str) else float(value)
                 for name, value in self.settings.items()}  # fmt: skip
        chosen = (options.rated, options.width, options.play, options.window, options.inputs, options.smoothing)
        law = variables["friction.law"].ids[self.law]
        return _native.Experiment(self.name, law, known, sorted(self.signals), chosen)

    @cached_property
    def compared(self) -> tuple[str, ...]:
        """The signals that are compared."""
        return tuple(self.native.compared)

    @cached_property
    def driving(self) -> tuple[str, ...]:
        """The measured signals that drive the model."""
        return tuple(self.native.driving)

    @cached_property
    def is_steady(self) -> bool:
        """Whether each sample is a steady motion of its own, without time."""
        return self.native.is_steady

    @cached_property
    def outputs(self) -> list[str]:
        """The variables of the model that are recorded."""
        return self.native.outputs

    @cached_property
    def beside(self) -> Mapping[str, str]:
        """Parameters of sensors and benches besides the model's, fixed or estimated, with their SI units.

        What is true is ``gain.SIGNAL * (reading - offset.SIGNAL)``, and a reading comes ``delay.SIGNAL`` late; one that
        is compared may have gone through a filter of first order with the time constant ``lag.SIGNAL``.
        """
        found = {}
        for name in self.native.sensors:
            kind, _, signal = name.partition(".")
            of = {"gain": self.units.of_gain, "offset": self.units.of_signal}
            found[name] = of[kind](signal) if kind in of else "s"
        bench = {"incline": "rad", "spring": self.units.of("N/m"), "springRest": self.units.of("m")}
        if self.units.is_rotating:
            # Rotating masses are balanced.
            del bench["incline"]
        return {**found, **{name: unit for name, unit in bench.items() if name in self.native.of_bench}}

    @property
    def unknown(self) -> tuple[str, ...]:
        """Parameters that have to be fixed or estimated, since the model has no default of them.

        The gain from current to force is one of them.
        """
        reads_force = self.name != "force" or self.units.of_gain("force") == "1"
        return (*self.native.unknown, *(() if reads_force else ("gain.force",)))

    def records(self, sources: Iterable[Measured]) -> tuple[list[Record], list[str]]:
        """Split tables at gaps; return the records, and notes on omitted parts.

        Points without a time are one record, whose times number them.
        """
        records: list[Record] = []
        notes: list[str] = []
        for source in sources:
            for signal, values in source.signals.items():
                if values.ndim != 1:
                    raise ValueError(
                        f"{source.name}: {signal} has the shape {values.shape}; it must have one dimension"
                    )
            found, own = self.native.split(source.name, {name: plain(one) for name, one in source.signals.items()})
            records += [Record(source.name, *one) for one in found]
            notes += [f"{source.name}: {note}" for note in own]
        _native.check_motion([record.numbers for record in records])
        return records, notes

    def windows(self, record: Record, share: float = 0.0, named: Iterable[str] = ()) -> list[Window]:
        """Cut a record into the parts that are simulated in one go; its last share is validation data.

        Every part begins where the carriage rests, if it does within half a part: there its velocity is known to be 0.
        Start values that are fixed or estimated by their names are none of a window's own.
        """
        whole, parts, notes = self.native.segments(record.numbers, share, list(named))
        self.notes += [f"{record.name}: {note}" for note in notes]
        if not parts:
            length = self.native.length(record.step)
            raise ValueError(
                f"{quoted('segment', length)} s: no part has 10 samples, which are {record.step:g} s apart"
            )
        windows = []
        for first, driven, used, held, values, loose in parts:
            part = record if len(used) == len(record.time) else record.part(first, first + len(used))
            around = Around(part.begin - record.begin, record.grid, whole)
            windows.append(Window(part, driven, held, used, Beginning(values, tuple(loose)), around))
        return windows

    def resting(self, record: Record) -> NDArray[np.bool_]:
        """Tell where a position does not change by more than its noise."""
        return self.native.resting(record.numbers)

    def under_law(self, values: Values) -> dict[str, Value]:
        """Return the known and fitted values that the simulated model has, and the law."""
        return self.typed(self.native.under_law(dict(values)))

    def typed(self, numbers: Mapping[str, float]) -> dict[str, Value]:
        """Return values as the model shows them."""
        variables = self.simulated.variables
        items = {name: {number: item for item, number in variables[name].ids.items()} for name in numbers}
        return {
            name: items[name][int(number)]
            if items[name]
            else bool(number)
            if variables[name].kind == "boolean"
            else number
            for name, number in numbers.items()
        }

    def forces(self, window: Window, values: Values) -> tuple[Array, Array, Array] | None:
        """Return velocity, friction and load factor as far as the data alone tell them, for a start of the fit."""
        return self.native.forces(window.native, dict(values))

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


def _plain(courses: Mapping[str, Array]) -> dict[str, Array]:
    return {name: plain(course) for name, course in courses.items()}


MADE = ("native", "compared", "driving", "is_steady", "outputs", "beside")
"""Attributes that are computed from the others."""
REQUIRED = {name: tuple(required) for name, required, _, _ in _native.experiments()}
"""For each experiment the signals that have to be measured."""
MODELS = {name: (table, simulated) for name, _, table, simulated in _native.experiments()}
"""For each experiment the models with the known and fitted parameters and of the simulation."""
OF_CYLINDER = frozenset(name for name, (table, _) in MODELS.items() if table != "FrictionBench")
"""Experiments with the parameters of the cylinder."""
EXPERIMENTS = {name: partial(Experiment, name) for name in MODELS}
"""By the name that users choose them with."""
