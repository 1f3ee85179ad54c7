"""Estimated parameters of a fit: names, bounds, scales."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pneumatic_servo import _native, checks
from pneumatic_servo.argument_names import quoted
from pneumatic_servo.identification.experiments import Experiment
from pneumatic_servo.model import Model
from pneumatic_servo.names import did_you_mean
from pneumatic_servo.numerals import finite
from pneumatic_servo.units import has_unit, is_quantity, magnitude, written
from pneumatic_servo.values import is_number
from pneumatic_servo.variables import Value

Array = NDArray[np.float64]

DAMPING_SPEED = "friction.lugre.vd"
"""Speed above which the damping of LuGre's bristles decays; with 0 it is constant, as in the first publication."""


@dataclass(frozen=True)
class Free:
    """A free parameter.

    Attributes
    ----------
    name : str
        A parameter of the model, `gain.SIGNAL`, `offset.SIGNAL`, `delay.SIGNAL`, `lag.SIGNAL`, or what a bench has.
    unit : str
        SI unit.
    start, low, high : float
        Start value and bounds; a start that only the data tell is NaN.
    scale : float
        Magnitude of its changes; 0 for a parameter whose logarithm is free.
    is_given : bool
        Whether the user gave the start.
    is_bounded : bool
        Whether the user gave bounds.
    legal : tuple of float
        Smallest and largest value that the model accepts.
    """

    name: str
    unit: str
    start: float
    low: float
    high: float
    scale: float
    is_given: bool = False
    is_bounded: bool = False
    legal: tuple[float, float] = (-math.inf, math.inf)

    @staticmethod
    def of(defined: _native.Free, unit: str) -> Free:
        """Return a parameter that the crate defines, with its unit on the machine."""
        name, _, start, low, high, scale, is_given, is_bounded, *legal = defined
        return Free(name, unit, start, low, high, scale, is_given, is_bounded, (legal[0], legal[1]))

    @property
    def is_logarithmic(self) -> bool:
        """Whether the solver sees its logarithm."""
        return self.scale == 0.0

    @property
    def numbers(self) -> _native.Free:
        """The parameter as the crate takes it."""
        return (self.name, self.unit, self.start, self.low, self.high, self.scale, self.is_given, self.is_bounded,
                *self.legal)  # fmt: skip

    def inner(self, value: float) -> float:
        """Return a value as the solver sees it."""
        return math.log(value) if self.is_logarithmic else value / self.scale

    def outer(self, inner: float) -> float:
        """Return the value that the solver sees as this."""
        return math.exp(inner) if self.is_logarithmic else inner * self.scale


def split(text: str) -> list[str]:
    """Split a list at its commas."""
    return [word.strip() for word in text.split(",") if word.strip()]


def words_of(
    given: str | Sequence[str] | Mapping[str, Any], unit_of: Callable[[str], str | None], argument: str = "fit"
) -> list[str]:
    """Return words NAME[=start][:low:high] of a text, a list of them, or a mapping of names to starts.

    A start is a number, a text, a number with a unit, an expression of other parameters, or None for the usual one;
    ``(start, low, high)`` has bounds, too.
    """
    if isinstance(given, str):
        return split(given)
    if not isinstance(given, Mapping):
        return checks.names(argument, given)
    words = []
    for name, value in given.items():
        where = quoted(argument, {name: value})
        if isinstance(value, tuple) and len(value) == 3:
            words.append(f"{name}={':'.join(_text(one, name, unit_of, where) for one in value)}")
        else:
            words.append(name if value is None else f"{name}={_text(value, name, unit_of, where)}")
    return words


def _text(value: Any, name: str, unit_of: Callable[[str], str | None], where: str) -> str:
    """Return a start or a bound as it is written in a word."""
    if isinstance(value, str):
        return value
    if isinstance(value, tuple) and len(value) == 2 and isinstance(value[1], str):
        return f"{value[0]} {value[1]}"
    if is_quantity(value):
        unit = unit_of(name)
        if unit is None:
            raise ValueError(f"{where}: there is no unit of {name} to convert to; write a number or a text")
        value = magnitude(value, unit, where)
    if not is_number(value):
        raise ValueError(f"{where}: it must be a number, a text, None, or (start, low, high)")
    return repr(float(value))


def unit_of(model: Model, name: str) -> str | None:
    """Return the SI unit of a variable of a model, if there is such a one."""
    return model.variables[name].unit if name in model.variables else None


def named_by(word: str) -> str:
    """Return the name in `NAME[=start][:low:high]`."""
    return word.partition(":")[0].partition("=")[0].strip()


def parse(word: str, experiment: Experiment) -> Free:
    """Read `NAME[=start][:low:high]`."""
    head, *bounds = word.split(":")
    name, equals, start = head.partition("=")
    where = quoted("fit", word)
    if len(bounds) not in (0, 2) or not name.strip():
        raise ValueError(f"{where}: it must be NAME[=start][:low:high]")
    free = free_of(name.strip(), experiment, where)
    return _given(free, start if equals else None, bounds, where)


def _given(free: Free, start: str | None, bounds: Sequence[str], where: str) -> Free:
    """Return a parameter with a start and bounds as they are written."""
    number = None if start is None else _number(start, free.unit, where)
    ends = tuple(_number(bound, free.unit, where) for bound in bounds)
    try:
        return Free.of(_native.given_parameter(free.numbers, number, ends or None), free.unit)
    except ValueError as error:
        raise ValueError(f"{where}: {error}") from None


def _number(text: str, unit: str, where: str) -> float:
    """Return a number in an SI unit, of a text with another unit or without."""
    return written(text, unit, where) if has_unit(text) else finite(text, where)


def auxiliary(word: str) -> Free:
    """Read `NAME=start[:low:high]` of a number that only expressions of other parameters use, as a ratio."""
    where = quoted("fit", word)
    head, *bounds = word.split(":")
    name, _, start = head.partition("=")
    if not start or len(bounds) not in (0, 2):
        raise ValueError(f"{where}: {name} is none of the model, so that it needs a start: NAME=start[:low:high]")
    free = Free.of(_native.number(name.strip(), _number(start, "1", where)), "1")
    return _given(free, start, bounds, where)


def free_of(name: str, experiment: Experiment, where: str) -> Free:
    """Return a parameter with the start and the bounds that the experiment has for it."""
    variables, beside = experiment.table.variables, experiment.beside
    if name in variables:
        name = variables[name].name
    elif name.partition(".")[0] not in ("gain", "offset", "delay", "lag") and name not in (*beside, "area", *OF_LOAD):
        hint = did_you_mean(name, [*variables, *beside])
        raise ValueError(f"{where}: there is no {name} here{hint}")
    try:
        found = experiment.native.parameter(name)
    except ValueError as error:
        raise ValueError(f"{where}: {error}") from None
    return Free.of(found, beside.get(name, experiment.units.of(found[1])))


OF_LOAD = ("friction.kappaA", "friction.direction.factor")
"""Parameters of the cylinder that make the load factor of a test bench."""


def group_of(law: str, model: Model) -> str:
    """Return the group of the parameters of a law, for example `friction.lugre`; nothing for a law without any."""
    laws = model.parameters["friction.law"].items
    if law not in laws:
        raise ValueError(
            f"{quoted('law', law)}: there is no such law{did_you_mean(str(law), laws)}; there are {', '.join(laws)}"
        )
    own = (name for name, variable in model.parameters.items() if variable.counts_for == ("friction.law", law))
    return next(own, "").rpartition(".")[0]


def usual(experiment: str, law: str, model: Model, settings: Mapping[str, Value]) -> list[str]:
    """Return the parameters of a law that a fit usually frees: forces, stiffnesses, dampings, velocities and lengths.

    Of the elements those that there are; of Table the forces; of GMS their shares too, which make its levels; of Dahl
    and Leuven the exponent that says how sharply presliding ends. The rate of GMS, the speed below which a film
    of lubricant is at rest, and forces and coefficients that are 0 by default, without effect, stay as they are.
    Of points only those that friction of a steady motion depends on.
    """
    group_of(law, model)
    known = {name: float(value) for name, value in settings.items() if isinstance(value, float | int)}
    return _native.usual_parameters(experiment, model._native, model.parameters["friction.law"].ids[law], known)
