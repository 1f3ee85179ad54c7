"""Model exchange: FMPy integrates the FMU with CVODE and finds what the solver inside finds."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from bounds import assert_close
from fmpy import simulate_fmu
from numpy.typing import NDArray

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
