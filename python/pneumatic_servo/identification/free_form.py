"""Free curves of friction over velocity, load and position on top of the fitted law: the gain that any law could bring.

Penalized cubic splines (P. H. C. Eilers and B. D. Marx, "Flexible smoothing with B-splines and penalties", Statistical
Science, 1996) are fitted to what the law leaves of friction, each direction of motion by itself. What they leave of
stretches of time that they have not seen is what a law of the same variables could come to; how strongly they are held
to zero is chosen by that, too. A law with memory may do better yet at reversals, which no such curve sees.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import BSpline

from pneumatic_servo.friction_tables import friction_table
from pneumatic_servo.identification.fitted import Fitted
from pneumatic_servo.identification.kinds import REST
from pneumatic_servo.identification.residuals import Residuals
from pneumatic_servo.identification.smoothing import fastest
from pneumatic_servo.identification.steady import steady

Array = NDArray[np.float64]

PIECES = 8
"""Pieces of a spline."""
STRETCHES = 10
"""Stretches of time that are left out in turn."""
PENALTIES = np.geomspace(1e-6, 1e2, 9)
"""Weight of the prior of a curve at zero, in units of the mean information of its samples."""
VARIES = 0.05
"""A load factor that varies by less than this share says nothing of load."""
FEWEST = 200
"""Samples in motion without which nothing is said."""


@dataclass(frozen=True)
class FreeForm:
    """RMS residual of friction in motion: under the law, and with a free curve on top of it.

    Attributes
    ----------
    law : float
        By the law.
    curves : dict
        By a curve over ``velocity``, ``velocity and load``, ``velocity, load and position``, predicted for stretches of
        time that the curve was not fitted to.
    unit : str
        Unit of friction.
    velocity, friction : ndarray of shape (samples,)
        The samples in motion: velocity, and friction divided by the load factor.
    """

    law: float
    curves: dict[str, float]
    unit: str = "N"
    velocity: Array = field(default_factory=lambda: np.empty(0), repr=False, compare=False)
    friction: Array = field(default_factory=lambda: np.empty(0), repr=False, compare=False)

    def table(self) -> dict[str, Any]:
        """Return the curve over velocity as settings of the law ``Table``, by `friction_table`."""
        return friction_table(self.velocity, self.friction)

    @property
    def family(self) -> str:
        """The variables of the laws that there are: velocity, and load where that varies."""
        return "velocity and load" if "velocity and load" in self.curves else "velocity"

    def gain(self, variables: str) -> float:
        """Return by which share a curve over some variables would leave less than the law; 0 if by none."""
        return max(0.0, 1.0 - self.curves[variables] / self.law) if self.law > 0.0 else 0.0

    def __str__(self) -> str:
        curves = ", ".join(f"{rms:.3g} {self.unit} over {name}" for name, rms in self.curves.items())
        return (
            f"Of friction in motion the law leaves {self.law:.3g} {self.unit} rms, a free curve {curves}: a law "
            f"of {self.family} could leave {100.0 * self.gain(self.family):.0f} % less."
        )


def free_form(fit: Fitted, residuals: Residuals) -> FreeForm | None:
    """Return the residual of free curves; nothing where the data alone do not give friction, or only its noise."""
    # Points are no stretches of time, which a curve could be tested on.
    samples = None if fit.problem.experiment.is_steady else _samples(fit, residuals)
    if samples is None:
        return None
    speed, place, level, friction, rest = samples
    moving = (np.abs(speed) > REST * fastest(speed)) & (level > 1e-3)
    speed, place, level, friction, rest = (values[moving] for values in (speed, place, level, friction, rest))
    if len(rest) < FEWEST:
        return None
    law = float(np.sqrt(np.mean(rest**2)))
    # Without a force sensor friction is the balance of a force and an acceleration, which may be noise.
    if fit.problem.experiment.name != "motion" and law > float(np.sqrt(np.mean((friction - rest) ** 2))):
        return None
    over_speed = _of_speed(speed)
    columns = {"velocity": over_speed}
    varies = float(np.std(level)) > VARIES * float(np.mean(level))
    if varies:
        columns["velocity and load"] = np.hstack([over_speed, over_speed * (level / np.mean(level) - 1.0)[:, None]])
    last = list(columns.values())[-1]
    along, way = _splines(place), np.sign(speed)[:, None]
    columns["velocity, load and position" if varies else "velocity and position"] = np.hstack(
        [last, along, along * way]
    )
    return FreeForm(
        law,
        {name: _predicted(table, rest) for name, table in columns.items()},
        fit.units.of("N"),
        speed,
        friction / level,
    )


def _samples(fit: Fitted, residuals: Residuals) -> tuple[Array, Array, Array, Array, Array] | None:
    """Return velocity, position, load factor, friction and its residual under the law, of the fitted samples."""
    experiment, problem, values = fit.problem.experiment, fit.problem, fit.values
    is_motion = experiment.name == "motion"
    differences = residuals.differences if is_motion else [{}] * len(problem.windows)
    parts = []
    for window, difference in zip(problem.windows, differences, strict=True):
        if not window.fitted:
            continue
        found = experiment.forces(window, values)
        if found is None:
            return None
        speed, friction, level = found
        record = window.record
        if is_motion:
            inside = window.used & ~window.held
            place = np.interp(record.time[inside], record.grid, window.driven["position"])
            rest = difference[experiment.compared[0]][inside]
        else:
            place = record.on_grid("position") if "position" in record.signals else np.zeros(len(record.grid))
            rest = friction
        parts.append((speed, place, level, friction, rest))
    speed, place, level, friction, rest = (np.concatenate(columns) for columns in zip(*parts, strict=True))
    if is_motion:
        return speed, place, level, friction, rest
    curve = steady(fit, float(np.max(np.abs(speed), initial=1e-6)))
    return None if curve is None else (speed, place, level, friction, friction - level * np.interp(speed, *curve))


def _of_speed(speed: Array) -> Array:
    """Return splines of each direction, closer where it is slow, as friction changes most there."""
    size = np.sqrt(np.abs(speed) / np.max(np.abs(speed)))
    table = _splines(size)
    return np.hstack([table * (speed > 0.0)[:, None], table * (speed < 0.0)[:, None]])


def _splines(values: Array) -> Array:
    low, high = float(np.min(values)), float(np.max(values))
    if high <= low:
        return np.ones((len(values), 1))
    inner = np.linspace(low, high, PIECES + 1)
    knots = np.concatenate([[low] * 3, inner, [high] * 3])
    return np.asarray(BSpline.design_matrix(values, knots, 3).toarray())


def _predicted(table: Array, rest: Array) -> float:
    """Return the rms that a curve leaves of stretches it was not fitted to, under the penalty that suits it best."""
    blocks = np.arange(len(rest)) * STRETCHES // len(rest)
    squares = [table[blocks == block].T @ table[blocks == block] for block in range(STRETCHES)]
    rights = [table[blocks == block].T @ rest[blocks == block] for block in range(STRETCHES)]
    whole, right = np.sum(squares, axis=0), np.sum(rights, axis=0)
    unit = np.eye(len(right)) * float(np.trace(whole)) / len(right)
    errors = []
    for penalty in PENALTIES:
        total = 0.0
        for block in range(STRETCHES):
            curve = np.linalg.solve(whole - squares[block] + penalty * unit, right - rights[block])
            total += float(np.sum((rest[blocks == block] - table[blocks == block] @ curve) ** 2))
        errors.append(total)
    return float(np.sqrt(min(errors) / len(rest)))
