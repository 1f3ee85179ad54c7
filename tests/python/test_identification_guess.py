"""The start of a search: at levels of friction that the record shows, under every law."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pneumatic_servo as ps
import pytest
from test_identification import bench

BREAK_AWAY = {"Stribeck": "Fs", "LuGre": "Fs", "ElastoPlastic": "Fs", "Armstrong": "FsInf"}
"""Parameters of the extra force of break-away; of Armstrong only the excess."""


@pytest.mark.parametrize("law", BREAK_AWAY)
def test_search_starts_at_the_levels_of_the_record(law: str) -> None:
    """The record slides at 7 N and 25 N.s/m, and has 4 N more at rest, of which slow samples show a part."""
    problem = ps.fit(bench(), experiment="motion", law=law, play=0.0, starts=0, progress=False).problem
    starts = {free.name.rpartition(".")[2]: free.start for free in problem.started().free}
    assert starts["Fc"] == pytest.approx(7.0, rel=0.05)
    assert starts["sigma2"] == pytest.approx(25.0, rel=0.2)
    excess = starts[BREAK_AWAY[law]] - (0.0 if law == "Armstrong" else starts["Fc"])
    assert 2.0 < excess < 4.0
    # The slow samples are those below a tenth of the fastest; the peak is 12 mm/s wide.
    assert 0.004 < starts["vs"] < 0.03
    if "sigma0" in starts:
        # Bristles bend by a fiftieth of the stroke of 47 mm; at full speed, 65 mm/s, their damping is a tenth of Fc.
        assert starts["Fc"] / starts["sigma0"] == pytest.approx(0.047 / 50.0, rel=0.05)
        assert starts["sigma1"] * 0.065 == pytest.approx(0.1 * starts["Fc"], rel=0.1)


def test_viscous_friction_is_none_of_what_breaks_away() -> None:
    """Ten times as much of it as in `bench`, 16 N at full speed, leaves the 4 N more at rest."""
    data = bench()
    data["frictionForce"] += 225.0 * np.gradient(data["position"], data["time"])
    problem = ps.fit(data, experiment="motion", law="Stribeck", play=0.0, starts=0, progress=False).problem
    starts = {free.name.rpartition(".")[2]: free.start for free in problem.started().free}
    assert starts["sigma2"] == pytest.approx(250.0, rel=0.1)
    assert 2.0 < starts["Fs"] - starts["Fc"] < 5.0


def test_friction_of_a_cylinder_is_what_the_pressures_leave() -> None:
    """A start is searched in the friction of the run itself, as smoothed."""
    time = np.arange(0.0, 3.0, 1e-3)
    voltage = 5.0 + 1.5 * np.sin(2.0 * np.pi * time)
    names = ["position", "chamberA.pressure", "chamberB.pressure"]
    run = ps.Model().simulate(inputs={"valveVoltage": (time, voltage)}, stop=3.0, step=1e-3,
                              outputs=[*names, "velocity", "frictionForce"])  # fmt: skip
    problem = ps.fit({"time": run.time, **{name: run[name] for name in names}}, experiment="mechanical",
                     law="Stribeck", fit="friction.stribeck.Fc", starts=0, progress=False).problem  # fmt: skip
    parts = []
    for window in problem.windows:
        found = problem.experiment.forces(window, {})
        assert found is not None
        at = window.record.begin + window.record.grid
        parts.append([*found, *(np.interp(at, run.time, run[name]) for name in ("velocity", "frictionForce"))])
    speed, friction, level, true_speed, true_friction = np.concatenate(parts, axis=1)
    fast = np.abs(true_speed) > 0.5 * np.max(np.abs(true_speed))
    assert np.sum(fast) > 100 and np.all(level == 1.0)
    # Smoothing over 80 ms leaves about a hundredth of both.
    assert np.median(np.abs(speed - true_speed)[fast]) < 0.05 * np.max(np.abs(true_speed))
    assert np.median(np.abs(friction - true_friction)[fast]) < 0.05 * np.median(np.abs(true_friction[fast]))
    for lacking in names:
        signals = {name: values for name, values in window.record.signals.items() if name != lacking}
        assert problem.experiment.forces(replace(window, record=replace(window.record, signals=signals)), {}) is None
