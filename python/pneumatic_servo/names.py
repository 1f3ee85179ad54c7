"""Suggestions for misspelt names, and earlier names of arguments."""

from __future__ import annotations

import difflib
from collections.abc import Callable, Iterable
from functools import wraps
from typing import ParamSpec, TypeVar

from pneumatic_servo.errors import warn

P = ParamSpec("P")
R = TypeVar("R")


def similar(name: str, known: Iterable[str], number: int = 3) -> list[str]:
    """Return the known names that resemble one the most, ignoring case, also by a part of it."""
    by_lower: dict[str, str] = {}
    for one in known:
        by_lower.setdefault(one.lower(), one)
    wanted = name.lower().strip()
    if not wanted:
        return []
    if wanted in by_lower:
        return [by_lower[wanted]]
    begins = sorted((one for one in by_lower if one.startswith(wanted)), key=lambda one: (len(one), one))
    parts = [one for one in by_lower if wanted in one.split(".")]
    close = difflib.get_close_matches(wanted, by_lower, n=number)
    lasts = [one for one in by_lower if difflib.SequenceMatcher(None, wanted, one.rpartition(".")[2]).ratio() > 0.85]
    inside = [one for one in by_lower if len(wanted) > 2 and wanted in one]
    ranked = close + begins + parts + lasts + inside if len(wanted) > 4 else begins + parts + close + lasts + inside
    found = dict.fromkeys(ranked)
    return [by_lower[one] for one in list(found)[:number]]


def did_you_mean(name: str, known: Iterable[str]) -> str:
    """Return ``; did you mean ...?`` with the names that resemble one, or nothing if none does."""
    near = similar(name, known)
    return f"; did you mean {' or '.join(near)}?" if near else ""


def tell_renamed(old: str, new: str) -> None:
    """Warn of an earlier name."""
    warn(f"{old} is now called {new}; the earlier name works until the next release")


def renamed(**names: str) -> Callable[[Callable[P, R]], Callable[P, R]]:
    """Return a decorator by which arguments have an earlier name, too: ``old="new"``."""

    def with_earlier(function: Callable[P, R]) -> Callable[P, R]:
        @wraps(function)
        def call(*args: P.args, **given: P.kwargs) -> R:
            for old, new in names.items():
                if old in given:
                    if new in given:
                        raise TypeError(f"{old} is the earlier name of {new}: give one of both")
                    tell_renamed(old, new)
                    given[new] = given.pop(old)
            return function(*args, **given)

        return call

    return with_earlier
