"""Errors and warnings of the package."""

from __future__ import annotations

import sys
import warnings
from pathlib import Path

PACKAGE = str(Path(__file__).parent)


class PlantWarning(UserWarning):
    """An accepted value that is hardly meant: the text names variable, value and unit.

    >>> import warnings
    >>> warnings.simplefilter("error", PlantWarning)     # for those who want it refused
    >>> warnings.simplefilter("default", PlantWarning)   # told once at each place
    """


def warn(text: str) -> None:
    """Tell something unusual, at the place outside the package that called it."""
    level, frame = 1, sys._getframe(1)
    while frame.f_back is not None and frame.f_code.co_filename.startswith(PACKAGE):
        level, frame = level + 1, frame.f_back
    warnings.warn(text, PlantWarning, stacklevel=level + 1)


class Refused(ValueError):
    """A value that a variable cannot have, by itself or beside the others.

    Attributes
    ----------
    variable : str
        Its name.
    value : float
        The value.
    reason : str
        The requirement that it does not meet.
    time : float or None
        Time in s at which it was to be applied.

    Examples
    --------
    >>> import pneumatic_servo as ps
    >>> try:
    ...     ps.Model().start({"mass.carriage": 5.0, "mass.moving": 1.0})
    ... except ps.Refused as refused:
    ...     print(refused.variable, refused.value)
    mass.carriage 5.0
    """

    def __init__(self, variable: str, value: float, reason: str, time: float | None = None, unit: str = "1") -> None:
        self.variable, self.value, self.reason, self.time, self.unit = variable, value, reason, time, unit
        when = "" if time is None else f"at t = {time} s "
        shown = f"{value:g}" if float(f"{value:g}") == value else repr(value)
        super().__init__(f"{when}{variable} = {shown}{'' if unit == '1' else ' ' + unit} is refused: {reason}")

    def __reduce__(self) -> tuple[type[Refused], tuple[object, ...]]:
        return Refused, (self.variable, self.value, self.reason, self.time, self.unit)

    def with_unit(self, unit: str) -> Refused:
        """Return the same with the unit of the value."""
        return Refused(self.variable, self.value, self.reason, self.time, unit)


class NoDerivative(ArithmeticError):
    """A point of a run beyond which it has no derivative.

    Attributes
    ----------
    time : float
        Time of the point in s.
    event : str
        The event at this point.
    reason : str
        The reason.

    Examples
    --------
    >>> import pneumatic_servo as ps
    >>> print(ps.NoDerivative(0.5, "break-away", "the motion rests at its limit"))
    the run has no derivative from t = 0.5 s on, at break-away: the motion rests at its limit
    """

    def __init__(self, time: float, event: str, reason: str) -> None:
        self.time, self.event, self.reason = time, event, reason
        super().__init__(f"the run has no derivative from t = {time:g} s on, at {event}: {reason}")

    def __reduce__(self) -> tuple[type[NoDerivative], tuple[object, ...]]:
        return NoDerivative, (self.time, self.event, self.reason)


class MissingPackage(ImportError):
    """An optional package that is not installed; the message says how to get it.

    Examples
    --------
    >>> import pneumatic_servo as ps
    >>> print(ps.MissingPackage("pandas", "pandas"))
    this needs pandas: pip install 'pneumatic-servo[pandas]'
    """

    def __init__(self, package: str, extra: str) -> None:
        super().__init__(f"this needs {package}: pip install 'pneumatic-servo[{extra}]'")


class NotConverged(RuntimeError):
    """A fit whose search did not converge."""
