"""Smoothing of a measured force, and bounds that physics sets."""

from __future__ import annotations

from typing import Any

import numpy as np
import pneumatic_servo as ps
import pytest

MASS, STEP = 12.0, 1e-3


def axis(noise: float) -> dict[str, Any]:
    """An axis of 12 kg under a force that a controller holds."""
    time = np.arange(0.0, 1.5, STEP)
    force = 60.0 * np.sin(9.0 * time) + 40.0 * np.sign(np.sin(31.0 * time))
    law = {"mass": MASS, "friction.law": "Coulomb", "friction.coulomb.Fc": 9.0, "friction.coulomb.sigma2": 30.0}
    run = ps.Model("FrictionBench").simulate(
        {**law, "bench.drive": "Free"}, inputs={"appliedForce": {"hold": (time, force)}}, stop=float(time[-1]),
        step=STEP, outputs=["position"],
    )  # fmt: skip
    random = np.random.default_rng(3)
    position = run["position"] + 2e-6 * random.standard_normal(len(time))
    return {"time": time, "position": position, "force": force + noise * random.standard_normal(len(time))}


def mass_of(noise: float, **options: Any) -> Any:
    return ps.fit(
        axis(noise), experiment="force", law="Coulomb", fit=["mass", "friction.coulomb.Fc", "friction.coulomb.sigma2"],
        starts=0, segment=0.15, progress=False, **options,
    )  # fmt: skip


def test_exact_force_is_not_smoothed_unless_it_is_asked_for() -> None:
    """The course of an exact force is known: intervals are narrow, and the mass is in its own."""
    exact = mass_of(0.0)
    assert any("not smoothed" in note for note in exact.notes)
    assert mass_of(0.0, smoothing=False).parameters["mass"].value == pytest.approx(MASS, rel=2e-4)
    own, smooth = exact.parameters["mass"], mass_of(0.0, smoothing=True).parameters["mass"]
    assert own.low <= MASS <= own.high
    assert abs(own.value - MASS) < 0.2 * abs(smooth.value - MASS)
    assert own.high - own.low < 0.3 * (smooth.high - smooth.low)


def test_smoothing_is_true_false_or_neither() -> None:
    with pytest.raises(ValueError, match="smoothing"):
        mass_of(0.0, smoothing="no")


def test_noisy_force_stays_smoothed_where_nothing_tells_that_more_is_left() -> None:
    """A force with a noise of 10 N: both leave the same but for chance."""
    assert not any("not smoothed" in note for note in mass_of(10.0).notes)
