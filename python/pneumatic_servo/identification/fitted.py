"""A fitted model: the result of a search, before its verdict."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from pneumatic_servo.identification.problem import Problem
from pneumatic_servo.identification.signals import Units
from pneumatic_servo.variables import Value

if TYPE_CHECKING:
    from pneumatic_servo.identification.cross_validation import CrossValidation
    from pneumatic_servo.identification.intervals import Certainty
    from pneumatic_servo.identification.posterior import Posterior

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Estimate:
    """A fitted parameter in SI units: its value and the ends of its 95 % interval.

    Examples
    --------
    >>> from pneumatic_servo.identification import Estimate
    >>> force = Estimate(value=7.02, low=6.9, high=7.1, unit="N")
    >>> print(force, float(force) < 7.1)
    7.02 [6.9, 7.1] N True
    """

    value: float
    low: float
    high: float
    unit: str

    def __float__(self) -> float:
        return self.value

    def __str__(self) -> str:
        return f"{self.value:.6g} [{self.low:.6g}, {self.high:.6g}] {self.unit}"


@dataclass(frozen=True)
class Fitted:
    """A fitted model as data. `Fit`, the public class, documents its attributes."""

    converged: bool
    law: str
    parameters: dict[str, Estimate]
    rms: dict[str, float]
    validation_rms: dict[str, float]
    not_identifiable: dict[str, str]
    aic: float
    notes: tuple[str, ...]
    problem: Problem = field(repr=False)
    x: Array = field(repr=False)
    certainty: Certainty = field(repr=False)
    message: str = ""
    posterior: Posterior | None = field(default=None, repr=False)
    cross_validation: CrossValidation | None = field(default=None, repr=False)

    @property
    def values(self) -> dict[str, float]:
        """The fitted values by name, in SI units."""
        return {name: estimate.value for name, estimate in self.parameters.items()}

    @property
    def settings(self) -> dict[str, Value]:
        """Settings of a model under the fit: fixed and estimated parameters and inputs, the law, and the start.

        The start is the fitted start of the first segment: position, velocity and pressures.
        """
        experiment = self.problem.experiment
        start: dict[str, Value] = dict(self.problem.begins(self.x)[0]) if self.problem.windows else {}
        if experiment.name == "force":
            # By default a spring pulls the bench.
            start["bench.drive"] = "Free"
        known = {**start, "friction.law": self.law, **experiment.settings, **self.values}
        table = self.problem.experiment.table
        return {name: value for name, value in known.items() if name in table.variables}

    @property
    def units(self) -> Units:
        """The units of signals and parameters; a rotating machine has other units than its model."""
        return self.problem.experiment.units
