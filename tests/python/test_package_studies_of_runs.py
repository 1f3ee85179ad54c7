"""Many runs as figures, tables and datasets, and the plant as a system of python-control."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import control
import numpy as np
import pneumatic_servo as ps
import pytest

GIVEN: dict[str, Any] = {
    "inputs": {"valveVoltage": 7.0}, "common": {"supplyPressure": 6e5}, "stop": 0.1, "step": 1e-3, "progress": False,
    "outputs": ["position", "velocity"],
}  # fmt: skip
LAWS = ["Stribeck", "LuGre", "LuGre"]
MASSES = [0.8, 1.0, 1.2]


@pytest.fixture(scope="module")
def runs() -> ps.Runs:
    return ps.Model().simulate_many({"mass.moving": MASSES, "friction.law": LAWS}, **GIVEN)


def test_table_of_runs_has_their_parameters(runs: ps.Runs) -> None:
    assert runs.parameters == {"mass.moving": MASSES, "friction.law": LAWS}
    table = runs.to_pandas()
    assert list(table.columns) == ["position", "velocity", "mass.moving", "friction.law"]
    assert table.groupby("run")["mass.moving"].unique().map(list).tolist() == [[mass] for mass in MASSES]
    assert table.loc[2, "friction.law"].unique().tolist() == ["LuGre"]
    part = runs.of([2, 0]).to_pandas()
    assert part.loc[0, "mass.moving"].iloc[0] == 0.8 and part.loc[2, "mass.moving"].iloc[0] == 1.2
    own = ps.Model().simulate_many([{}, {"mass.moving": 1.0}], **GIVEN)
    assert own.parameters == {"mass.moving": [None, 1.0]}


def test_dataset_of_runs_has_units_and_parameters_as_coordinates(runs: ps.Runs) -> None:
    data = runs.to_xarray()
    assert data["position"].dims == ("run", "time") and data["velocity"].attrs["units"] == "m/s"
    assert np.array_equal(data["position"].values, runs["position"])
    assert data["mass.moving"].values.tolist() == MASSES and data.attrs["supplyPressure"] == 6e5
    means = data.groupby("friction.law").mean()["position"].sel({"friction.law": "LuGre"})
    assert np.allclose(means.values, runs["position"][1:].mean(axis=0), rtol=1e-15)


def test_runs_are_drawn_as_lines_or_bands(runs: ps.Runs, tmp_path: Path) -> None:
    few = runs.plot("position")
    [axis] = few.axes
    assert [line.get_ydata().tolist() for line in axis.lines] == [(1e3 * one).tolist() for one in runs["position"]]
    many = ps.Model().simulate_many({"mass.moving": np.linspace(0.8, 1.2, 21)}, **GIVEN)
    panels = many.plot().axes
    assert [axis.get_ylabel() for axis in panels] == ["position (mm)", "velocity (mm/s)"]
    assert np.allclose(panels[0].lines[0].get_ydata(), 1e3 * np.median(many["position"], axis=0), rtol=1e-12)
    assert len(panels[0].collections) == 2
    with pytest.raises(KeyError, match="positon was not recorded"):
        runs.plot("positon")


@pytest.mark.parametrize("law", ["Stribeck", "LuGre"])
def test_system_of_python_control_has_the_bits_of_the_plant(law: str) -> None:
    plant, settings = ps.Model(), {"friction.law": law, "supplyPressure": 6e5}
    t = np.arange(600) * 1e-3
    u = 5.0 + 2.0 * np.sin(12.0 * t)
    system = plant.to_iosys(settings, outputs=["position", "chamberA.pressure", "frictionForce"])
    found = control.input_output_response(system, t, u, system.x0)
    assert found.output_labels == ["position", "chamberA_pressure", "frictionForce"]
    stepped, rows = plant.start(settings), []
    for voltage in u:
        stepped["valveVoltage"] = voltage
        rows.append(stepped.get(["position", "chamberA.pressure", "frictionForce", "velocity"]))
        stepped.step(1e-3)
    expected = np.array(rows).T
    assert np.array_equal(found.outputs, expected[:3])
    assert (expected[3, 1:] == 0.0).any() == (law == "Stribeck")
    # A loop that python-control closes.
    gain = control.ss([], [], [], [[20.0]], 1e-3, inputs="error", outputs="command")
    bias = control.summing_junction(["command", "bias"], "valveVoltage")
    error = control.summing_junction(["reference", "-position"], "error")
    seen = plant.to_iosys(settings, outputs=["position"])
    loop = control.interconnect([seen, gain, bias, error], inputs=["reference", "bias"], outputs="position", dt=1e-3)
    courses = np.array([np.full(600, 0.3), np.full(600, 5.0)])
    closed = control.input_output_response(loop, t, courses, seen.x0)
    own = plant.simulate(settings, controller=lambda _t, seen: 20.0 * (0.3 - seen["position"]) + 5.0, stop=0.6,
                         step=1e-3, outputs=["position"])  # fmt: skip
    assert np.allclose(closed.outputs.ravel(), own["position"][:-1], rtol=0.0, atol=1e-9)


def test_system_begins_at_an_operating_point_and_refuses_what_there_is_not() -> None:
    plant = ps.Model()
    linear = plant.linearise({"velocity": 0.05, "valve.hysteresis": 0})
    system = plant.to_iosys(linear, period="2 ms")  # type: ignore[arg-type]
    assert dict(zip(linear.states, linear.x, strict=True))["chamberA.pressure"] in system.x0 and system.dt == 2e-3
    t = np.arange(50) * 2e-3
    steady = control.input_output_response(system, t, np.full(50, linear.u[0]), system.x0)
    assert np.allclose(steady.outputs[1], 0.05, rtol=1e-3)
    with pytest.raises(ValueError, match=r"give X0=system\.x0"):
        control.input_output_response(system, t, np.full(50, 5.0))
    with pytest.raises(ValueError, match="inputs: there is no valveVoltag; did you mean valveVoltage"):
        plant.to_iosys(inputs=["valveVoltag"])
    with pytest.raises(ValueError, match="period = 0 is refused"):
        plant.to_iosys(period=0.0)
