"""Arguments of a kind that cannot be meant, refused by their names before they are taken apart."""

from __future__ import annotations

import operator
from collections.abc import Iterable, KeysView, Mapping, Set
from reprlib import repr as shortened
from typing import TypeVar

Given = TypeVar("Given")


def names(argument: str, given: Iterable[str]) -> list[str]:
    """Return a list of names; a text, which Python takes for a list of its letters, is refused."""
    if isinstance(given, str):
        raise TypeError(f"{argument} must be a list of names, not the text {given!r}")
    if isinstance(given, Set) and not isinstance(given, KeysView):
        raise TypeError(f"{argument} must be a list of names, not a set, which has no order")
    if not isinstance(given, Iterable):
        raise TypeError(f"{argument} must be a list of names, not {shortened(given)}")
    listed = list(given)
    wrong = next((name for name in listed if not isinstance(name, str)), None)
    if wrong is not None:
        raise TypeError(f"{argument} must be a list of names, but has {shortened(wrong)}")
    return listed


def mapping(argument: str, given: Mapping[str, Given] | None) -> dict[str, Given]:
    """Return values by name; none where nothing is given."""
    if given is None:
        return {}
    if not isinstance(given, Mapping):
        raise TypeError(f"{argument} must be a mapping of names to values, not {shortened(given)}")
    return dict(given)


def whole_number(argument: str, given: int, least: int) -> int:
    """Return a whole number, of NumPy's too, that is not too small."""
    try:
        if isinstance(given, bool):
            raise TypeError
        number = operator.index(given)
    except TypeError:
        raise ValueError(f"{argument} = {shortened(given)} is refused: it must be a whole number") from None
    if number < least:
        raise ValueError(f"{argument} = {number} is refused: it must be at least {least}")
    return number


def submits(argument: str, given: object) -> None:
    """Refuse an object that is no executor."""
    if given is not None and not hasattr(given, "submit"):
        raise TypeError(
            f"{argument} = {shortened(given)} is refused: it must have `submit`, as a ProcessPoolExecutor has"
        )
