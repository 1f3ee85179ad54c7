"""Model exchange: FMPy integrates the FMU with CVODE, with the results of co-simulation."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from bounds import assert_close
from fmpy import simulate_fmu
from numpy.typing import NDArray

from model_exchange import LAWS as HARD_LAWS
from model_exchange import RUNS, WRONG, Fmu, Start, allowed, unexpected

OUTPUTS = ["position", "velocity", "chamberA.pressure", "chamberB.pressure", "frictionForce", "sticking"]
LAWS = {"None": 1, "Coulomb": 2, "Stribeck": 7, "Karnopp": 8, "Dahl": 10, "LuGre": 14, "GMS": 16, "ElastoPlastic": 20}
STOP = 0.6


def run(fmu: Path, kind: str, law: int, voltage: float) -> NDArray:
    """The carriage starts at rest, under a constant voltage."""
    return simulate_fmu(
        str(fmu),
        fmi_type=kind,
        solver="CVode",
        stop_time=STOP,
        output_interval=1e-3,
        step_size=1e-3,
        relative_tolerance=1e-9,
        start_values={"friction.law": law, "valveVoltage": voltage},
        output=OUTPUTS,
    )


@pytest.mark.parametrize(("law", "number"), LAWS.items())
@pytest.mark.parametrize("voltage", [5.2, 7.0])
def test_cvode_outside_agrees_with_the_solver_inside(fmu: Path, law: str, number: int, voltage: float) -> None:
    inside, outside = (run(fmu, kind, number, voltage) for kind in ("CoSimulation", "ModelExchange"))
    times = inside["time"]
    for name, bound in [("position", 1e-7), ("chamberA.pressure", 1.0), ("chamberB.pressure", 1.0)]:
        # FMPy also records both sides of events; of values at one instant the last counts.
        instants, last = np.unique(outside["time"][::-1], return_index=True)
        found = np.interp(times, instants, outside[name][::-1][last])
        assert_close(found, inside[name], within=bound, what=name.rpartition(".")[2])


def test_stuck_carriage_does_not_move_by_a_bit(fmu: Path) -> None:
    result = run(fmu, "ModelExchange", LAWS["Stribeck"], 5.0)
    assert set(result["sticking"]) == {1}
    assert len(set(result["position"])) == 1
    assert set(result["velocity"]) == {0.0}


HARD = {model: starts for model, starts in RUNS.items() if model != "PneumaticServoCylinder"} | {
    "PneumaticServoCylinder": [
        {"valveVoltage": voltage, "friction.law": law} for voltage in (0.0, 6.5, 10.0) for law in HARD_LAWS.values()
    ]
}
"""A part of the runs of `docs/studies/model_exchange.py`; as a program it makes them all."""


@pytest.fixture(scope="module", params=[".", "fmi3"], ids=["FMI 2.0", "FMI 3.0"])
def folder(request: pytest.FixtureRequest, fmus: Path) -> Path:
    """FMUs of either version."""
    return fmus / request.param


@pytest.mark.parametrize("model", HARD)
def test_cvode_outside_gets_into_the_stops_and_back(folder: Path, model: str) -> None:
    """No exception, not even one that FMPy prints and forgets, and the same motion."""
    with Fmu(folder / f"{model}.fmu") as fmu:
        for start in HARD[model]:
            expected = fmu.inside(start)
            for tolerance in (1e-4, 1e-6):
                outcome = fmu.outside(start, tolerance, expected)
                assert outcome.problems == [], (start, tolerance)
                bound = allowed(fmu.law(start), outcome.counts.events) * tolerance
                assert outcome.deviation <= bound, (start, tolerance, outcome.deviation)
                assert outcome.counts.rates > 0


@pytest.mark.parametrize("model", HARD)
def test_solvers_that_do_not_suit_are_survived(folder: Path, model: str) -> None:
    with Fmu(folder / f"{model}.fmu") as fmu:
        for start in HARD[model][: len(HARD_LAWS)]:
            expected = fmu.inside(start)
            for name, (solver, tolerance) in WRONG.items():
                outcome = fmu.outside(start, tolerance, expected, solver)
                assert unexpected(outcome, fmu.law(start), solver) == [], (start, name)


@pytest.mark.parametrize(
    "law", [1, 9, 11, 13, 15, 18], ids=["None", "Polito", "Bristle", "Armstrong", "Leuven", "DNLRX"]
)
def test_laws_that_stop_a_solver_often_end_where_the_solver_inside_does(fmu: Path, law: int) -> None:
    """Laws that missed ten times the tolerance at one of seven voltages, at the tightest tolerance."""
    start: Start = {"valveVoltage": 6.5, "friction.law": law}
    with Fmu(fmu) as cylinder:
        outcome = cylinder.outside(start, 1e-8, cylinder.inside(start))
        assert outcome.problems == []
        assert outcome.deviation <= allowed(cylinder.law(start), outcome.counts.events) * 1e-8


def test_explicit_steps_that_explode_are_refused_at_a_cover(fmu: Path) -> None:
    """The message names the meaningless state; a run that stays finite is not refused."""
    solver, tolerance = WRONG["explicit Euler, 1 ms"]
    with Fmu(fmu) as cylinder:
        for law, is_refused in {"Stribeck": False, "LuGre": True}.items():
            start: Start = {"valveVoltage": 10.0, "friction.law": HARD_LAWS[law]}
            outcome = cylinder.outside(start, tolerance, cylinder.inside(start), solver)
            assert bool(outcome.problems) == is_refused, outcome.problems
            assert unexpected(outcome, law, solver) == []
