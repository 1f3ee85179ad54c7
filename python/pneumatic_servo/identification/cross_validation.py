"""Cross-validation of a law over operating conditions: each is left out in turn, and predicted from the others.

That a law describes all conditions together says little of the next one. So the law is fitted without one of them, and
its prediction is compared with the measurement there: by the RMS residual of each signal, and by friction, predicted
with an interval, and measured. The crate `fit` does both, and states the model of the error of a law.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray

from pneumatic_servo.figures import BLUE, STYLE, VERMILION, WIDTH, Drawing
from pneumatic_servo.files import write_csv
from pneumatic_servo.identification.conditions import Condition
from pneumatic_servo.identification.problem import Problem
from pneumatic_servo.identification.ranges import Ranges, asked_of
from pneumatic_servo.identification.signals import SLIDING, Units
from pneumatic_servo.identification.watch import Watch
from pneumatic_servo.run import table

Array = NDArray[np.float64]

MISSED = 3.0
"""Ratio of predicted to fitted residuals of a condition, from which, without a friction, it is not predicted."""
USUAL = 0.2
"""Prior standard deviation of the error of any law in a condition, relative to friction."""
WIDE = 3.0
"""An interval whose ends have this ratio tells hardly anything."""


@dataclass(frozen=True)
class FrictionPrediction:
    """Mean friction of a condition in N: as the other conditions predict it, and as measured, with 95 % intervals."""

    predicted: float
    low: float
    high: float
    measured: float
    measured_low: float
    measured_high: float
    spread: float
    """Median of tau, as far as the other conditions tell it; NaN if the law has as many parameters as there are."""

    @property
    def is_within(self) -> bool:
        """Whether the interval of the prediction contains the measurement."""
        return self.low <= self.measured <= self.high

    @property
    def is_wide(self) -> bool:
        """Whether the interval is so wide that it tells hardly anything."""
        return self.high > WIDE * self.low

    def said(self, unit: str) -> str:
        """Return it for people, in a unit."""
        return (
            f"predicted {self.predicted:.4g} {unit} [{self.low:.4g}, {self.high:.4g}], "
            f"measured {self.measured:.4g} {unit} [{self.measured_low:.4g}, {self.measured_high:.4g}]"
        )


@dataclass(frozen=True)
class Case:
    """A condition that was left out.

    Attributes
    ----------
    condition : Condition
        Name of the condition.
    samples : int
        Number of its samples.
    rms, fitted : dict
        RMS residual of each signal in it, predicted and fitted, in SI units.
    friction : FrictionPrediction or None
        Friction; None for experiments that do not tell it alone (``rig``, ``pneumatic``).
    beyond : tuple of str
        In which respects it lies beyond all others.
    """

    condition: Condition
    samples: int
    rms: dict[str, float]
    fitted: dict[str, float]
    friction: FrictionPrediction | None
    beyond: tuple[str, ...]

    @property
    def holds(self) -> bool:
        """Whether the law holds in it as far as the others tell."""
        if self.friction is not None:
            return self.friction.is_within
        return all(rms <= MISSED * self.fitted[signal] for signal, rms in self.rms.items())

    def said(self, units: Units) -> str:
        """Return the prediction by the others, for people: friction, or the residual of each signal."""
        if self.friction is not None:
            return self.friction.said(units.of("N"))
        return ", ".join(
            f"{signal} is predicted to {rms:.3g} {units.of_signal(signal)} rms, and fitted to {self.fitted[signal]:.3g}"
            for signal, rms in self.rms.items()
        )


@dataclass(frozen=True)
class CrossValidation:
    """All conditions, each left out in turn.

    Attributes
    ----------
    cases : tuple of Case
        One for each condition.
    units : Units
        The units of the fit.

    Examples
    --------
    >>> import numpy as np
    >>> import pneumatic_servo as ps
    >>> t, rng = np.arange(0.0, 1.0, 0.01), np.random.default_rng(0)
    >>> def record(amplitude):
    ...     force = 7.0 * np.sign(np.cos(6.0 * t)) + 0.1 * rng.standard_normal(len(t))
    ...     return {"time": t, "position": amplitude * np.sin(6.0 * t), "frictionForce": force}
    >>> found = ps.fit([record(0.005), record(0.01), record(0.02)], experiment="motion", law="Coulomb", starts=0,
    ...                cross_validate="record", progress=False)
    >>> found.cross_validation.holds, len(found.cross_validation.cases)
    (3, 3)
    """

    cases: tuple[Case, ...]
    units: Units = SLIDING

    @property
    def holds(self) -> int:
        """In how many of the conditions the law holds."""
        return sum(case.holds for case in self.cases)

    @property
    def columns(self) -> list[str]:
        """The names of the columns of the table."""
        force = self.units.of("N")
        return ["left out", "samples", "signal", "rms predicted", "rms fitted along", "unit",
                f"friction predicted ({force})", "low", "high", f"measured ({force})", "measured low",
                "measured high", "holds"]  # fmt: skip

    def rows(self) -> list[list[Any]]:
        """Return the table, under its `columns`."""
        found: list[list[Any]] = []
        for case in self.cases:
            told = case.friction
            friction: list[Any] = [None] * 6
            if told is not None:
                friction = [
                    told.predicted, told.low, told.high, told.measured, told.measured_low, told.measured_high
                ]  # fmt: skip
            for signal, rms in case.rms.items():
                found.append([
                    case.condition.name, case.samples, signal, rms, case.fitted[signal],
                    self.units.of_signal(signal), *friction,
                    "yes" if case.holds else "no",
                ])  # fmt: skip
        return found

    def as_list(self) -> list[dict[str, Any]]:
        """Return the table for JSON, with null for infinite ends and other values that are not finite."""
        return [
            {name: None if isinstance(cell, float) and not np.isfinite(cell) else cell
             for name, cell in zip(self.columns, row, strict=True)}
            for row in self.rows()
        ]  # fmt: skip

    def texts(self) -> list[list[str]]:
        """Return the table as texts."""
        return [
            ["" if c is None else f"{c:.4g}" if isinstance(c, float) else str(c) for c in row] for row in self.rows()
        ]

    def to_csv(self, file: str | Path) -> None:
        """Write the table."""
        write_csv(Path(file), self.columns, self.rows())

    def plot(self) -> Figure:
        """Draw friction in each condition, predicted by the others and measured; without friction, residuals."""
        names = [case.condition.name for case in self.cases]
        with mpl.rc_context(STYLE):
            figure = Drawing(figsize=(WIDTH, 0.9 + 0.32 * len(names)), layout="constrained")
            axis = figure.subplots()
            for place, case in enumerate(self.cases):
                told = case.friction
                if told is None:
                    ratios = [rms / max(case.fitted[signal], 1e-300) for signal, rms in case.rms.items()]
                    axis.plot(ratios, [place] * len(ratios), "o", ms=4, color=BLUE)
                    continue
                axis.plot([told.low, told.high], [place, place], color=BLUE, lw=4, alpha=0.3)
                axis.plot(told.predicted, place, "|", ms=9, color=BLUE)
                axis.plot(told.measured, place, "o", ms=4, color=VERMILION)
            axis.set_yticks(range(len(names)), names)
            axis.invert_yaxis()
            if all(case.friction is None for case in self.cases):
                axis.set_xlabel("rms if left out, over that if fitted along")
            else:
                axis.plot([], [], color=BLUE, lw=4, alpha=0.3, label="predicted by the others, 95 %")
                axis.plot([], [], "o", ms=4, color=VERMILION, label="measured")
                axis.set_xlabel(f"friction ({self.units.of('N')})")
                axis.legend(loc="best", fontsize=7)
        return figure

    def __repr__(self) -> str:
        lines = [f"each condition left out in turn: the law holds in {self.holds} of {len(self.cases)}"]
        for case in self.cases:
            failed = "" if case.holds else ": the law does not hold there"
            lines.append(f"  {case.condition.name}: {case.said(self.units)}{failed}")
        return "\n".join(lines)

    def _repr_html_(self) -> str:
        return table(self.columns, self.texts())


def cross_validate(
    problem: Problem, x: Array, groups: Sequence[Condition], loss: str, law_error: float, watch: Watch
) -> CrossValidation:
    """Leave out one condition after the other.

    Parameters
    ----------
    problem, x : Problem, ndarray
        A fitted problem and its solution, from which the search without a condition begins.
    groups : sequence of Condition
        The conditions.
    loss : str
        Loss function.
    law_error : float
        Expected deviation of friction from the law, as a share.
    watch : Watch
        Is told how far it is.
    """
    told = problem.native.cross_validate(
        x, [(group.quantity, group.name, list(group.windows)) for group in groups], loss, law_error, watch
    )
    cases = []
    for group, (of_others, asked, rms, friction) in zip(groups, told, strict=True):
        others = [place for place in range(len(problem.windows)) if place not in group.windows]
        out = _of_windows(problem, group.windows)
        beyond = Ranges.of(_of_windows(problem, others), of_others).beyond(asked_of(out, asked))
        predicted, fitted = (dict(zip(problem.experiment.compared, own, strict=True)) for own in zip(*rms, strict=True))
        samples = sum(window.fitted for window in out.windows)
        prediction = None if friction is None else FrictionPrediction(*friction[0], *friction[1], friction[2])
        cases.append(Case(group, samples, predicted, fitted, prediction, tuple(beyond.values())))
    return CrossValidation(tuple(cases), problem.experiment.units)


def _of_windows(problem: Problem, places: Sequence[int]) -> Problem:
    return replace(problem, windows=tuple(problem.windows[place] for place in places))
