"""Ctrl-C in a fit and in a comparison: what was found until then is kept, and told before."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pneumatic_servo as ps
import pytest
from test_identification import bench

GIVEN = {"experiment": "motion", "play": 0.0, "starts": 0}


def stopping(after: int) -> Callable[[str], None]:
    """A progress during which somebody presses Ctrl-C."""
    left = [after]

    def tell(text: str) -> None:
        left[0] -= text.startswith("cost")
        if left[0] < 0:
            raise KeyboardInterrupt

    return tell


def stopping_in_the_second() -> Callable[[str], None]:
    """A progress during whose second fit somebody presses Ctrl-C, at the last refinement."""
    begun: list[str] = []

    def tell(text: str) -> None:
        begun.extend([text] * (text == "last refinement"))
        if len(begun) == 2:
            raise KeyboardInterrupt

    return tell


def test_fit_that_is_interrupted_keeps_its_best() -> None:
    with pytest.raises(ps.Interrupted) as caught:
        ps.fit(bench(), law="Stribeck", progress=stopping(6), **GIVEN)  # type: ignore[arg-type]
    found = caught.value.finished
    assert isinstance(found, ps.Fit) and not found.converged and found.message == "it was interrupted"
    assert set(found.values) == {f"friction.stribeck.{name}" for name in ("Fs", "Fc", "vs", "sigma2")}
    assert all(np.isfinite(value) for value in found.values.values())
    # After six vectors it is better than at its start, and worse than at its end.
    with pytest.raises(ps.Interrupted) as begun:
        ps.fit(bench(), law="Stribeck", progress=stopping(1), **GIVEN)  # type: ignore[arg-type]
    end = ps.fit(bench(), law="Stribeck", progress=False, **GIVEN).rms["frictionForce"]  # type: ignore[arg-type]
    at_first = begun.value.finished.rms["frictionForce"]  # type: ignore[union-attr]
    assert end <= found.rms["frictionForce"] < at_first


def test_comparison_that_is_interrupted_keeps_the_laws_that_are_done() -> None:
    with pytest.raises(ps.Interrupted) as caught:
        ps.compare_fits(bench(), ["Coulomb", "Stribeck", "LuGre"], progress=stopping_in_the_second(), **GIVEN)  # type: ignore[arg-type]
    ranking = caught.value.finished
    assert isinstance(ranking, ps.Ranking)
    assert {fit.law: fit.converged for fit in ranking.fits} == {"Coulomb": True, "Stribeck": False}


def test_progress_tells_the_best_misfit_so_far() -> None:
    told: list[str] = []
    ps.fit(bench(), law="Stribeck", progress=told.append, **GIVEN)  # type: ignore[arg-type]
    best = [float(text.split("leaves ")[1].split()[0]) for text in told if "first search" in text and "leaves" in text]
    assert len(best) > 3 and best == sorted(best, reverse=True)
    assert told[-1] == "intervals"
