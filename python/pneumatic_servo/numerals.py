"""Numbers that people write in tables and on the command line."""

from __future__ import annotations

import math


def finite(text: str, where: str) -> float:
    """Return the number that a text stands for.

    Raises
    ------
    ValueError
        If it is none, or not finite; the message begins with where the text stands.
    """
    try:
        value = float(text)
    except ValueError:
        raise ValueError(f"{where}: {text!r} is no number") from None
    if not math.isfinite(value):
        raise ValueError(f"{where}: {text.strip()} is not finite")
    return value
