"""How far results are from what they should be, and how much room their bounds leave.

A bound is at most ten times what is observed, or `why` says why it is wider. What was observed is kept by test, over
all its parameters, and pytest prints the slackest bounds at its end.
"""

from __future__ import annotations

import os
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

SHOWN = 10
"""Number of bounds that the report shows."""
ROUNDING = 8.0 * np.finfo(float).eps
"""Relative. Less than this is not counted as observed: it may be more on another machine."""


class Bound(NamedTuple):
    """The largest share of a bound that was used."""

    share: float
    observed: float
    bound: float
    why: str


used: dict[str, Bound] = {}
"""By test and by what it compares."""


def largest(values: ArrayLike) -> float:
    """The largest magnitude. NaN if any value is; nothing at all is refused, since it would pass every bound."""
    magnitudes = np.abs(np.asarray(values))
    assert magnitudes.size > 0, "nothing is compared"
    return float(np.max(magnitudes))


def assert_close(
    found: ArrayLike,
    expected: ArrayLike,
    *,
    within: ArrayLike = 0.0,
    rel: float = 0.0,
    what: str = "",
    why: str = "",
) -> None:
    """Hold values against those expected, each within `within` or `rel` times the expected, whichever is more.

    `what` names the quantity, `why` says why a bound is more than ten times what is observed. NaN is never close.
    """
    values, wanted = np.asarray(found), np.asarray(expected)
    assert wanted.ndim == 0 or values.shape == wanted.shape, f"{what}: {values.shape} values for {wanted.shape}"
    wanted = np.broadcast_to(wanted, values.shape)
    bounds = np.maximum(within, rel * np.abs(wanted))
    assert np.all((bounds > 0.0) | np.isnan(wanted)), f"{what}: what has no room is compared by equality"
    differences = np.abs(values - wanted)
    largest(differences)
    observed = np.maximum(differences, ROUNDING * np.abs(wanted))
    worst = np.unravel_index(np.argmax(observed / bounds), values.shape)
    share = float(observed[worst] / bounds[worst])
    _keep(what, Bound(share, float(observed[worst]), float(bounds[worst]), why))
    assert share <= 1.0, f"{what or 'value'} is {values[worst]}, not within {bounds[worst]:.3g} of {wanted[worst]}"


def _keep(what: str, bound: Bound) -> None:
    test = os.environ.get("PYTEST_CURRENT_TEST", "").rpartition(" ")[0].rpartition("/")[2].partition("[")[0]
    key = f"{test} {what}".rstrip()
    if key not in used or not used[key].share >= bound.share:
        used[key] = bound


def report() -> Iterator[str]:
    """Yield the slackest bounds, those with a reason apart."""
    reasoned = sum(bool(bound.why) for bound in used.values())
    plain = {key: bound for key, bound in used.items() if not bound.why}
    yield f"{len(used)} bounds, {reasoned} of them wide for a stated reason; the slackest of the others:"
    for key, bound in sorted(plain.items(), key=lambda item: item[1].share)[:SHOWN]:
        slack = 1.0 / bound.share if bound.share > 0.0 else np.inf
        yield f"  {slack:8.3g} times: {key}: observed {bound.observed:.2g}, bound {bound.bound:.2g}"
