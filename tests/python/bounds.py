"""Bounds on deviations: each is at most ten times the observed deviation, or `why` says why."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike


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
    worst = np.unravel_index(np.argmax(differences / bounds), values.shape)
    assert differences[worst] <= bounds[worst], (
        f"{what or 'value'} is {values[worst]}, not within {bounds[worst]:.3g} of {wanted[worst]}{why and f' ({why})'}"
    )
