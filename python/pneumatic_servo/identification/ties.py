"""Parameters that follow from others, as ``friction.stribeck.Fs = 1.2*friction.stribeck.Fc``."""

from __future__ import annotations

from dataclasses import dataclass

from pneumatic_servo import _native


@dataclass(frozen=True)
class Tie:
    """A parameter that an expression of others gives, in SI units.

    Attributes
    ----------
    name, unit : str
        The parameter and its SI unit.
    text : str
        The expression: numbers, names, ``+ - * / **``, brackets, and sqrt, exp, log and abs.
    """

    name: str
    unit: str
    text: str

    @property
    def names(self) -> list[str]:
        """The names in the expression."""
        return _native.expression_names(self.text) or []


def is_expression(text: str, where: str) -> bool:
    """Tell whether a text is an expression of parameters, and no number with a unit; refuse an unknown function."""
    try:
        return _native.expression_names(text) is not None
    except ValueError as refused:
        raise ValueError(f"{where}: {refused}") from None
