"""CasADi takes the FMUs for model exchange: Jacobians by its own check, and a simulation between events.

The optimal move, planned and replayed, is `examples/optimal_move.py`, which `test_examples.py` runs.
"""

from __future__ import annotations

from pathlib import Path

import casadi as ca
import numpy as np
import pytest
from bounds import assert_close
from fmpy import extract, simulate_fmu

LAWS = {"SmoothCoulomb": 4, "Stribeck": 7, "LuGre": 14}
START = {
    "velocity0": 0.05,
    "chamberA.pressure0": 4e5,
    "chamberB.pressure0": 3e5,
    "supplyPressure": 6e5,
    "valveVoltage": 7.0,
    "valve.hysteresis": 0.0,
}
"""The carriage slides, and goes on to do so."""


@pytest.fixture(params=[".", "fmi3"], ids=["FMI 2.0", "FMI 3.0"])
def file(request: pytest.FixtureRequest, fmus: Path) -> Path:
    """The FMU of either version."""
    return fmus / request.param / "PneumaticServoCylinder.fmu"


def imported(file: Path, law: str, folder: Path) -> ca.DaeBuilder:
    """The plant as CasADi imports it, with its start values."""
    extract(str(file), unzipdir=str(folder))
    plant = ca.DaeBuilder("plant", str(folder))
    for name, value in {**START, "friction.lawNumber": LAWS[law]}.items():
        plant.set(name, value)
    return plant


def test_start_values_of_the_description_are_those_of_a_run(file: Path, tmp_path: Path) -> None:
    """CasADi takes the attribute `start` of a state for its value."""
    extract(str(file), unzipdir=str(tmp_path / "fmu"))
    plant = ca.DaeBuilder("plant", str(tmp_path / "fmu"))
    starts = {name: plant.start(name)[0] for name in plant.x()}
    assert starts["position"] == 0.25
    assert starts["chamberA.pressure"] == 101_325.0
    assert starts == dict(zip(plant.x(), plant.get(plant.x()), strict=True))


def test_step_response_gets_into_the_stop(file: Path, tmp_path: Path) -> None:
    """CVODES of CasADi, which knows no events, under a law that has none; it tries states beyond the cover, too."""
    plant = imported(file, "LuGre", tmp_path / "fmu")
    plant.set("valveVoltage", 10.0)
    rates = plant.create("rates", ["x", "u"], ["ode"])
    scales = ca.DM([plant.nominal(name) for name in plant.x()])
    x = ca.MX.sym("x", plant.nx())
    ode = rates(scales * x, ca.DM(plant.get(plant.u()))) / scales
    times = np.linspace(0.0, 1.0, 101)
    options = {"abstol": 1e-8, "reltol": 1e-8, "max_num_steps": 100_000}
    run = ca.integrator("run", "cvodes", {"x": x, "ode": ode}, 0, times, options)
    start = ca.DM(plant.get(plant.x())) / scales
    start[plant.x().index("velocity")] = START["velocity0"] / scales[plant.x().index("velocity")]
    place = plant.x().index("position")
    found = np.array(run(x0=start)["xf"])[place] * float(scales[place])
    given = {**START, "friction.lawNumber": LAWS["LuGre"], "valveVoltage": 10.0, "solver.relativeTolerance": 1e-9}
    inside = simulate_fmu(
        str(file),
        fmi_type="CoSimulation",
        stop_time=1.0,
        step_size=0.01,
        output_interval=0.01,
        start_values=given,
        output=["position"],
    )
    assert inside["position"][-1] > 0.5, "it leans on the stop"
    assert_close(found, inside["position"], within=2e-7, what="position")


@pytest.mark.parametrize("law", LAWS)
def test_jacobians_pass_the_check_of_casadi(file: Path, law: str, tmp_path: Path) -> None:
    """CasADi compares derivatives with differences, and writes down those that do not agree."""
    plant = imported(file, law, tmp_path / "fmu")
    failures = tmp_path / "failures.txt"
    check = {"validate_forward": True, "validate_ad_file": str(failures)}
    rates = plant.create("rates", ["x", "u"], ["ode"], check)
    x, u = (ca.DM(plant.get(names)) for names in (plant.x(), plant.u()))
    x[plant.x().index("velocity")] = START["velocity0"]
    by_states, by_inputs = rates.jacobian()(x, u, 0)
    place = plant.x().index("velocity")
    assert_close(float(by_inputs[place, plant.u().index("externalForce")]), 1 / 0.88, rel=1e-14, what="acceleration")
    assert float(by_states[plant.x().index("position"), place]) == 1.0
    assert len(failures.read_text(encoding="utf-8").splitlines()) == 1, "more than the head of the table"


@pytest.mark.parametrize("law", LAWS)
def test_simulation_between_events_is_that_of_co_simulation(file: Path, law: str, tmp_path: Path) -> None:
    plant = imported(file, law, tmp_path / "fmu")
    rates = plant.create("rates", ["x", "u"], ["ode"])
    scales = ca.DM([plant.nominal(name) for name in plant.x()])
    x = ca.MX.sym("x", plant.nx())
    ode = rates(scales * x, ca.DM(plant.get(plant.u()))) / scales
    options = {"abstol": 1e-10, "reltol": 1e-10}
    run = ca.integrator("run", "cvodes", {"x": x, "ode": ode}, 0, 0.1, options)
    start = ca.DM(plant.get(plant.x())) / scales
    start[plant.x().index("velocity")] = START["velocity0"] / scales[plant.x().index("velocity")]
    found = dict(zip(plant.x(), np.array(run(x0=start)["xf"] * scales).ravel(), strict=True))
    bounds = {"position": 1e-7, "velocity": 1e-6, "chamberA.pressure": 1.0, "chamberB.pressure": 1.0}
    inside = simulate_fmu(
        str(file),
        fmi_type="CoSimulation",
        stop_time=0.1,
        start_values={**START, "friction.lawNumber": LAWS[law], "solver.relativeTolerance": 1e-9},
        output=[*bounds, "solver.events"],
    )
    assert inside["solver.events"][-1] == 0, "it slides all the time"
    for name, bound in bounds.items():
        assert abs(found[name] - inside[name][-1]) < bound, (name, found[name], inside[name][-1])
