"""Suggestions for misspelt names."""

from __future__ import annotations

import difflib
from collections.abc import Iterable


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
