"""Times of the clock that are written as texts, with a date or without, as seconds since the first."""

from __future__ import annotations

import re
from collections.abc import Sequence
from datetime import date

CLOCK = re.compile(
    r"(?:(?P<date>\d{1,4}[-./]\d{1,2}[-./]\d{1,4})(?:T|,?\s+))?(?P<hour>\d{1,2}):(?P<minute>\d{2}):(?P<second>\d{2})"
    r"(?:[.,](?P<fraction>\d{1,9}))?\s*(?P<half>[AaPp]\.?[Mm]\.?)?\s*(?P<zone>Z|[-+]\d{2}:?\d{2})?"
)
NANO = 1_000_000_000
DAY = 86_400 * NANO


def is_clock(text: str) -> bool:
    """Tell whether a text is a time of the clock: ``12:30:01.25``, ``2026-11-27T12:30:01``, ``27.11.2026 0:30:01``."""
    return CLOCK.fullmatch(text.strip()) is not None


def seconds_since_first(texts: Sequence[str]) -> list[float] | None:
    """Return the seconds of times of the clock since the first of them; nothing if some text is none.

    Without dates, a clock that goes back by more than half a day has passed midnight.

    Raises
    ------
    ValueError
        For a date that is none, or dates that may be of day and month or of month and day.
    """
    matches = [CLOCK.fullmatch(text.strip()) for text in texts]
    found = [match for match in matches if match is not None]
    if not found or len(found) < len(matches):
        return None
    dates = [match["date"] for match in found]
    moments = [_of_day(match) for match in found]
    if any(dates):
        days = _days([one or "" for one in dates])
        moments = [days[one or ""] * DAY + moment for one, moment in zip(dates, moments, strict=True)]
    else:
        midnights = 0
        for place in range(1, len(moments)):
            moments[place] += midnights * DAY
            if moments[place - 1] - moments[place] > DAY // 2:
                midnights += 1
                moments[place] += DAY
    return [(moment - moments[0]) / NANO for moment in moments]


def _of_day(match: re.Match[str]) -> int:
    """Return the nanoseconds since midnight, of world time where a zone is given."""
    hour = int(match["hour"])
    if match["half"]:
        hour = hour % 12 + (12 if match["half"][0] in "pP" else 0)
    minutes = 60 * hour + int(match["minute"])
    zone = match["zone"]
    if zone and zone != "Z":
        ahead = 60 * int(zone[1:3]) + int(zone[-2:])
        minutes -= ahead if zone[0] == "+" else -ahead
    return (60 * minutes + int(match["second"])) * NANO + int((match["fraction"] or "").ljust(9, "0"))


def _days(texts: Sequence[str]) -> dict[str, int]:
    """Return the number of the day of each date that is written."""
    numbers = {text: [int(part) for part in re.split(r"[-./]", text)] for text in dict.fromkeys(texts) if text}
    is_month_first = _is_month_first(numbers)
    days = {"": 0}
    for text, (one, two, three) in numbers.items():
        if len(text) - len(text.lstrip("0123456789")) == 4:
            year, month, day = one, two, three
        else:
            day, month, year = (two, one, three) if is_month_first and "/" in text else (one, two, three)
        try:
            days[text] = date(year, month, day).toordinal()
        except ValueError as error:
            raise ValueError(f"the date {text!r} is refused: {error}") from None
    return days


def _is_month_first(numbers: dict[str, list[int]]) -> bool:
    """Tell whether dates with slashes are of month, day and year."""
    slashed = {text: parts for text, parts in numbers.items() if "/" in text and parts[0] < 1000}
    if any(parts[0] > 12 for parts in slashed.values()):
        return False
    is_told = any(parts[1] > 12 for parts in slashed.values())
    if len(slashed) > 1 and not is_told:
        text = next(iter(slashed))
        raise ValueError(f"the date {text!r} may be of day and month or of month and day; write year-month-day")
    return is_told
