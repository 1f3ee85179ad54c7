"""The log of the solver: its steps row by row, and its events by kind and time."""

from __future__ import annotations

from typing import Any

import numpy as np
import pneumatic_servo as ps
import pytest

SINE: dict[str, Any] = {"inputs": {"valveVoltage": lambda t: 5.0 + 2.0 * np.sin(12.0 * t)}, "stop": 1.0, "step": 1e-3}
COUNTS = ["solver.steps", "solver.rejectedSteps", "solver.jacobians", "solver.events"]


@pytest.mark.parametrize("law", ["Stribeck", "LuGre", "MaxwellSlip"])
def test_log_counts_what_the_solver_counts_and_changes_no_bit(law: str) -> None:
    plant, settings = ps.Model(), {"friction.law": law}
    given: dict[str, Any] = {**SINE, "outputs": ["position", "velocity", *COUNTS]}
    plain = plant.simulate(settings, **given)
    run = plant.simulate(settings, solver_log=True, **given)
    log = run.solver_log
    assert plain.solver_log is None and log is not None
    assert run["position"].tobytes() == plain["position"].tobytes()
    for counted, name in zip((log.steps, log.rejected, log.jacobians), COUNTS, strict=False):
        assert np.array_equal(np.cumsum(counted), run[name] - run[name][0]), name
    assert len(log.events) == run["solver.events"][-1] - run["solver.events"][0] == sum(log.kinds.values())
    times = [event.time for event in log.events]
    assert times == sorted(times) and all(0.0 <= time <= 1.0 for time in times)
    assert bool(times) == (law != "LuGre")
    few = plant.simulate(settings, solver_log=True, every=50, sensitivities=["mass.moving"], **SINE).solver_log
    assert few is not None and few.events == log.events and few.steps.shape == (21,)
    assert few.steps.sum() == log.steps.sum()


def test_events_are_at_the_stops_and_starts_of_the_motion() -> None:
    """A mass under Coulomb friction stops after m*v0/Fc."""
    free = {"bench.drive": "Free", "friction.law": "Coulomb", "friction.coulomb.Fc": 2.0,
            "friction.coulomb.sigma2": 0.0, "velocity0": 3.0}  # fmt: skip
    log = ps.Model("FrictionBench").simulate(free, stop=2.0, step=0.1, solver_log=True).solver_log
    assert log is not None
    [kind] = log.kinds
    assert log.times_of(kind) == pytest.approx([1.5], abs=1e-6) and kind in repr(log)


@pytest.mark.parametrize("controller", ["PositionController", lambda t, seen: 5.0 + 20.0 * (0.3 - seen["position"])])
def test_closed_loop_has_a_log_of_the_plant(controller: Any) -> None:
    given: dict[str, Any] = {
        "stop": 0.4,
        "step": 1e-3,
        "outputs": ["valveVoltage", "position", *COUNTS],
        "controller": controller,
    }
    if controller == "PositionController":
        given["inputs"] = {"referencePosition": 0.3}
    run = ps.Model().simulate(solver_log=True, **given)
    log = run.solver_log
    assert log is not None and len(log.events) == run["solver.events"][-1] - run["solver.events"][0] > 0
    assert log.steps.sum() == run["solver.steps"][-1] - run["solver.steps"][0]
    again = ps.Model().simulate(inputs=run, stop=0.4, step=1e-3, solver_log=True).solver_log
    assert again is not None and again.events == log.events


def test_model_without_a_solver_has_no_log() -> None:
    with pytest.raises(ValueError, match="solver_log: PositionController has no solver"):
        ps.Model("PositionController").simulate(stop=0.1, step=1e-3, solver_log=True)
