"""An observer: states, friction and disturbance from inputs and measurements, while a plant runs."""

from __future__ import annotations

from collections import deque
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Literal, get_args

import numpy as np
from numpy.typing import NDArray

from pneumatic_servo import _native, values
from pneumatic_servo.checks import mapping
from pneumatic_servo.errors import warn
from pneumatic_servo.linear import held_between_samples
from pneumatic_servo.model import Model, Parameters
from pneumatic_servo.names import did_you_mean
from pneumatic_servo.simulation import Simulation

Array = NDArray[np.float64]
Method = Literal["extended", "unscented"]

FORCE = "frictionForce"
LAW = "friction law"
"""The meaning of the parameters that choose one."""
WINDOW = 1000
"""Measurements that a verdict looks back on."""
FEWEST = 100
LAGS = 20
"""Correlations of successive innovations that are looked at."""
QUANTILE = 3.0902
"""Of the normal distribution, for one false alarm in a thousand."""


@dataclass(frozen=True)
class Consistency:
    """Comparison of an observer's errors with those that it expects.

    Attributes
    ----------
    count : int
        Innovations that were looked at, of all measured variables.
    mean_square : float
        Mean square of the normalised innovations; 1 is expected.
    mean_square_band : tuple of float
        Bounds within which it lies in 998 of 1000 cases.
    correlation : float
        Ljung-Box statistic of 20 lags, in units of the bound that it exceeds in one of 1000 cases: above 1 successive
        innovations are correlated, though independent ones are expected.

    Notes
    -----
    G. M. Ljung and G. E. P. Box, On a measure of lack of fit in time series models, Biometrika 65 (1978), 297-303.

    Examples
    --------
    >>> import pneumatic_servo as ps
    >>> plant = ps.Model().start()
    >>> observer = ps.Observer(measured={"position": 1e-6}, period=1e-3)
    >>> for _ in range(100):
    ...     plant.step(1e-3)
    ...     _ = observer.update({}, {"position": plant["position"]})
    >>> observer.consistency().count
    100
    """

    count: int
    mean_square: float
    mean_square_band: tuple[float, float]
    correlation: float

    @property
    def is_consistent(self) -> bool:
        """Whether the innovations are as large, and as independent, as those of a plant like the observer's."""
        low, high = self.mean_square_band
        return low <= self.mean_square <= high and self.correlation <= 1.0

    def __str__(self) -> str:
        low, high = self.mean_square_band
        word = "consistent" if self.is_consistent else "not consistent"
        return (
            f"{word}: mean square of {self.count} normalised "
            f"innovations {self.mean_square:.3g} (expected {low:.3g} to {high:.3g}), "
            f"correlation {self.correlation:.3g} (expected below 1)"
        )


def _chi_square(degrees: int, quantile: float) -> float:
    """Return a quantile of the chi-square distribution from one of the normal, as Wilson and Hilferty do."""
    share = 2.0 / (9.0 * degrees)
    return float(degrees * (1.0 - share + quantile * share**0.5) ** 3)


class Observer:
    """Estimates of all states of a plant, and of the friction force, from its inputs and a few measurements.

    It is a Kalman filter on the plant's own steps: an extended one, with the derivative of a step, through stick and
    slip, or an unscented one. It computes the deviations of its estimates; its innovations show whether its plant is
    the measured one.

    Parameters
    ----------
    settings : mapping, optional
        Parameters and start of the plant: see `Model.simulate`.
    measured : mapping
        Measured variables, and the standard deviations of their noise in SI units: ``{"position": 20e-6}``.
    period : float
        Period of the measurements in s.
    process : mapping, optional
        Random walks that disturb states: standard deviations in SI units after 1 s, in place of the defaults. With
        an input the observer estimates it, too, as a random walk: ``{"externalForce": 5.0}``.
    initial : mapping, optional
        Standard deviations of states at the start, in SI units, in place of the defaults.
    model : str or Model
        The model.
    method : str
        ``"extended"``, or ``"unscented"``: steps from points around the estimate take the place of the derivative, for
        laws whose step has no useful one, as ``Bristle``.

    Examples
    --------
    >>> import pneumatic_servo as ps
    >>> plant = ps.Model().start({"friction.law": "LuGre"})
    >>> observer = ps.Observer({"friction.law": "LuGre"}, measured={"position": 20e-6}, period=1e-3)
    >>> for _ in range(200):
    ...     plant["valveVoltage"] = 6.0
    ...     plant.step(1e-3)
    ...     found = observer.update({"valveVoltage": 6.0}, {"position": plant["position"]})
    >>> abs(found["velocity"] - plant["velocity"]) < 2 * observer.deviation["velocity"]
    True
    """

    def __init__(
        self,
        settings: Parameters | None = None,
        *,
        measured: Mapping[str, Any],
        period: float,
        process: Mapping[str, Any] | None = None,
        initial: Mapping[str, Any] | None = None,
        model: str | Model = "PneumaticServoCylinder",
        method: Method = "extended",
    ) -> None:
        if method not in get_args(Method):
            raise ValueError(f"method = {method!r} is refused: it must be one of {', '.join(get_args(Method))}")
        own = Model(model) if isinstance(model, str) else model
        self._inputs = list(own.inputs)
        simulation = own.start(settings)
        sampled = list(held_between_samples(own, simulation))
        for held in sampled:
            warn(f"{held}, which a single step does not show: the estimates diverge; choose another law")
        deviations = [
            [(name, float(value)) for name, value in values.settings(argument, own.variables, given or {}).items()]
            for argument, given in (("measured", measured), ("process", process), ("initial", initial))
        ]
        if not deviations[0]:
            raise ValueError("measured is empty: name at least one variable, with the deviation of its noise")
        others = [FORCE] if FORCE in own.variables else []
        self._period = values.seconds("period", period)
        self._native = _native.Observer(
            own._native, list(simulation._settings.items()), deviations[0], self._period,
            (deviations[1], deviations[2]), others, method == "unscented",
        )  # fmt: skip
        if not sampled and method == "extended" and (hanging := _hanging_on_memory(own, simulation, self._period)):
            warn(hanging)
        self._measured = [name for name, _ in deviations[0]]
        self._names = [*self._native.names(), *others]
        self._given = [simulation[name] for name in self._inputs]
        self._whitened: deque[list[float]] = deque(maxlen=WINDOW)

    @property
    def period(self) -> float:
        """Period of the measurements in s."""
        return self._period

    def update(self, inputs: Mapping[str, float], measurements: Mapping[str, float | None]) -> dict[str, float]:
        """Go a period on under inputs that are held over it, and take in what was measured at its end.

        Parameters
        ----------
        inputs : mapping
            Inputs in SI units; others keep their values.
        measurements : mapping
            Measured values in SI units. One that is missing, or None, is left out: the estimate goes on without it.

        Returns
        -------
        dict
            The estimates: see `estimates`.

        Raises
        ------
        ValueError
            For another name, or a value that is not finite.
        SimulationError
            When the plant cannot be followed; restart the observer from a start that is possible.
        """
        for name, value in mapping("inputs", inputs).items():
            if name not in self._inputs:
                raise ValueError(f"inputs: {name!r} is no input{did_you_mean(name, self._inputs)}")
            self._given[self._inputs.index(name)] = _finite("inputs", name, value)
        for name in mapping("measurements", measurements):
            if name not in self._measured:
                raise ValueError(f"measurements: {name!r} is not measured; {', '.join(self._measured)} are")
        read = [measurements.get(name) for name in self._measured]
        self._native.update(
            self._given,
            [None if value is None else _finite("measurements", name, value)
             for name, value in zip(self._measured, read, strict=True)],
        )  # fmt: skip
        self._whitened.append(self._native.innovation()[1])
        return self.estimates

    @property
    def estimates(self) -> dict[str, float]:
        """Estimates in SI units by name: all states, the inputs that are estimated, and the friction force."""
        return dict(zip(self._names, self._native.estimates(), strict=True))

    @property
    def deviation(self) -> dict[str, float]:
        """Standard deviations of the estimates in SI units by name."""
        return dict(zip(self._names, self._native.deviations(), strict=True))

    @property
    def innovation(self) -> dict[str, float]:
        """The last measurements minus their predictions, in SI units; not a number where one was missing."""
        return dict(zip(self._measured, self._native.innovation()[0], strict=True))

    @property
    def normalised_square(self) -> float:
        """Square of the last innovations in units of their deviations; its mean is the number of measurements."""
        return float(np.nansum(np.square(self._native.innovation()[1])))

    @property
    def states(self) -> tuple[str, ...]:
        """Names of the estimated states and inputs: the rows of `covariance`."""
        return tuple(self._native.names())

    @property
    def covariance(self) -> Array:
        """Covariance of the estimated states and inputs in SI units, of shape (states, states)."""
        return self._native.covariance()

    def consistency(self) -> Consistency:
        """Compare the last 1000 innovations with those of a plant like the observer's.

        The innovations of a wrong law may be as large as expected, but follow each other: both are looked at.

        Raises
        ------
        ValueError
            With fewer than 100 measurements.
        """
        every = np.array(self._whitened)
        found = [column[np.isfinite(column)] for column in every.T] if len(every) else []
        found = [column for column in found if len(column) >= FEWEST]
        if not found:
            raise ValueError(f"a verdict needs at least {FEWEST} measurements of a variable")
        count = sum(len(column) for column in found)
        square = float(sum(np.sum(column**2) for column in found) / count)
        low, high = (_chi_square(count, quantile) / count for quantile in (-QUANTILE, QUANTILE))
        correlation = max(_ljung_box(column) for column in found) / _chi_square(LAGS, QUANTILE)
        return Consistency(count, square, (low, high), correlation)


def _hanging_on_memory(model: Model, simulation: Simulation, period: float) -> str | None:
    """Return a warning if more numbers of the memory act on the states of a plant than it has states."""
    step = simulation.transition(period, at_rest="zero")
    kept = [name.startswith("memory.") for name in step.states]
    moved = [not name.startswith("memory.") for name in step.next_states]
    acting = np.count_nonzero(step.A[np.ix_(moved, kept)].any(axis=0))
    if acting <= sum(moved):
        return None
    law = ", ".join(f"{one.name} = {simulation[one.name]}" for one in model.variables.values() if one.meaning == LAW)
    return (
        f"{law}: its force hangs on {acting} numbers of its memory, which are not estimated; the bands are too narrow: "
        "with method='unscented' they are wider"
    )


def _ljung_box(column: Array) -> float:
    total = float(np.sum(column**2))
    if total == 0.0:
        return 0.0
    lags = [float(np.sum(column[lag:] * column[:-lag])) / total for lag in range(1, LAGS + 1)]
    count = len(column)
    return count * (count + 2) * sum(own**2 / (count - lag) for lag, own in enumerate(lags, 1))


def _finite(argument: str, name: str, value: float) -> float:
    number = float(value)
    if not np.isfinite(number):
        raise ValueError(
            f"{argument}: {name} = {number} is refused: it must be a finite number; leave out what is missing"
        )
    return number
