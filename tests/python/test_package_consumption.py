"""Air consumption of a run."""

from __future__ import annotations

import numpy as np
import pneumatic_servo as ps
import pytest

COUNTED = {"consumption.enabled": True}
FAST = {"inputs": {"valveVoltage": 8.0}, "stop": 0.4, "step": 1e-3}


@pytest.fixture(scope="module")
def run() -> ps.Run:
    return ps.Model().simulate(COUNTED, **FAST)  # type: ignore[arg-type]


def test_consumption_is_the_integral_of_the_flow(run: ps.Run) -> None:
    found = run.consumption()
    assert found.mass == pytest.approx(np.trapezoid(run["supply.massFlow"], run.time), rel=1e-4)
    assert found.volume == pytest.approx(run["supply.consumedVolume"][-1], rel=1e-12)
    assert found.mean_flow * run.time[-1] == pytest.approx(found.mass, rel=1e-12)


def test_run_that_has_not_counted_says_what_to_set() -> None:
    with pytest.raises(ValueError, match=r"give it consumption\.enabled = True"):
        ps.Model().simulate(**FAST).consumption()  # type: ignore[arg-type]
    with pytest.raises(KeyError, match=r"supply\.consumed was not recorded"):
        ps.Model().simulate(COUNTED, outputs=["position"], **FAST).consumption()  # type: ignore[arg-type]


def test_comparison_has_a_column_of_air_where_it_is_counted(run: ps.Run) -> None:
    model = ps.Model()
    found = model.compare(["Stribeck", "LuGre"], COUNTED, progress=False, **FAST)  # type: ignore[arg-type]
    assert found.columns[-1] == "air (kg)"
    assert found.rows()[0][-1] == pytest.approx(run.consumption().mass, rel=1e-9)
    without = model.compare(["Stribeck"], progress=False, **FAST)  # type: ignore[arg-type]
    assert "air (kg)" not in without.columns and len(without.rows()[0]) == len(without.columns)


def test_units_of_flow_are_those_of_the_standards() -> None:
    """A litre (ANR) has 1.185 g, a standard cubic foot 0.075 lb."""
    from pneumatic_servo.units import to_si

    assert to_si(60.0, "l/min(ANR)", "kg/s", "q") == pytest.approx(1.185e-3, rel=1e-12)
    assert to_si(60.0, "SCFM", "kg/s", "q") == pytest.approx(0.075 * 0.45359237, rel=1e-12)
    assert to_si(1.0, "lbf", "N", "F") == pytest.approx(4.4482216152605, rel=1e-12)
    assert to_si(10.0, "in/s", "m/s", "v") == pytest.approx(0.254, rel=1e-12)
