"""Progress on a terminal says what is done, of how much, and what of."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from typing import Any

import pneumatic_servo as ps
import pytest
from test_identification import bench


@cache
def ranking() -> ps.Ranking:
    return ps.compare_fits(bench(), ["Coulomb", "Dahl"], experiment="motion", play=0.0, starts=0, progress=False)


SHOWN: dict[str, tuple[Callable[..., object], str, str]] = {
    "a run": (
        lambda **shown: ps.Model().simulate(stop=0.1, step=1e-3, outputs=["position"], **shown),
        "PneumaticServoCylinder",
        " steps",
    ),
    "runs": (
        lambda **shown: ps.Model("FrictionBench").simulate_many([{}, {}], stop=0.1, step=1e-3, **shown),
        "FrictionBench",
        " runs",
    ),
    "a plan": (
        lambda **shown: ps.plan(law="Coulomb", experiment="motion", duration=2.0, step=0.01, **shown),
        "plan",
        " candidates",
    ),
    "what tells laws apart": (
        lambda **shown: ranking().telling("Coulomb", "Dahl", duration=2.0, step=0.02, **shown),
        "tell apart",
        " candidates",
    ),
}


@pytest.mark.parametrize("name", SHOWN)
def test_bar_says_what_is_done(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """It shows what a function would be told, and nothing where there is no terminal."""
    made: list[dict[str, Any]] = []

    class Bar:
        def __init__(self, **options: Any) -> None:
            self.n = 0
            made.append(options | {"bar": self})

        def __enter__(self) -> Bar:
            return self

        def __exit__(self, *_: object) -> None:
            pass

        def update(self, more: int) -> None:
            assert more >= 0
            self.n += more

    monkeypatch.setattr("pneumatic_servo.progress.tqdm", Bar)
    work, label, unit = SHOWN[name]
    told: list[tuple[int, int]] = []
    work(progress=lambda done, total: told.append((done, total)))
    assert not made
    work(progress=True)
    (bar,) = made
    assert bar["desc"] == label and bar["unit"] == unit and bar["disable"] is None
    assert told[-1] == (bar["total"], bar["total"]) and bar["bar"].n == bar["total"]
    work(progress=False)
    assert len(made) == 1
