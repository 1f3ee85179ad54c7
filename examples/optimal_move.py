"""Plans a move from rest to rest with CasADi and IPOPT, and replays it against stiction.

CasADi takes the FMU for model exchange as a function dx/dt = f(x, u) with exact derivatives. Optimisers want smooth
equations, so the move is planned under the friction law SmoothCoulomb; the same FMU replays it, for co-simulation,
under that law and under the law Stribeck, which sticks. The valve has no dead zone and no play, the air is isothermal.

Needs casadi, fmpy and matplotlib, and the FMU of `cargo xtask package`.
"""

from __future__ import annotations

import argparse
import os
import sys
import tempfile
from pathlib import Path
from typing import NamedTuple

import casadi as ca
import matplotlib.pyplot as plt
import numpy as np
from fmpy import extract, simulate_fmu
from numpy.typing import NDArray

START, END, DURATION = 0.2, 0.3, 0.6
INTERVALS, DEGREE = 40, 3
LAWS = {"SmoothCoulomb": 4, "Stribeck": 7}
PRESSURE, SUPPLY, AMBIENT = 3e5, 6e5, 101325.0
ROD_SHARE = (0.006 / 0.016) ** 2
"""Area of the rod relative to the bore's."""

PARAMETERS = {
    "position0": START,
    "chamberA.pressure0": PRESSURE,
    "chamberB.pressure0": (PRESSURE - ROD_SHARE * AMBIENT) / (1 - ROD_SHARE),  # in balance, at rest
    "thermal.modelNumber": 2,  # isothermal
    "valve.deadZone": 0.0,
    "valve.hysteresis": 0.0,
    "friction.smoothCoulomb.vd": 0.01,
}
STATES = {
    "position": 0.1,
    "velocity": 0.5,
    "chamberA.pressure": 1e5,
    "chamberB.pressure": 1e5,
    "valve.spool": 1.0,
    "valve.spoolVelocity": 100.0,
}
"""The states that move, with their magnitudes."""


class Plan(NamedTuple):
    """A voltage for each interval, and the states at the ends of the intervals."""

    times: NDArray
    voltage: NDArray
    states: dict[str, NDArray]


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    folder = Path(os.environ.get("FMU_FOLDER", Path(__file__).parents[1] / "target/fmu"))
    parser.add_argument("--fmu", type=Path, default=folder / "PneumaticServoCylinder.fmu", help="of FMI 2.0 or 3.0")
    parser.add_argument("--figure", type=Path, help="where to draw plan and replays")
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as unpacked:
        extract(str(arguments.fmu), unzipdir=unpacked)
        plan = planned(dynamics(unpacked), guess(arguments.fmu))
    runs = {law: replayed(arguments.fmu, plan.times, plan.voltage, law) for law in LAWS}
    errors = {law: run["position"][-1] - END for law, run in runs.items()}
    print(f"planned: {START} m to {END} m in {DURATION} s, at most {plan.states['velocity'].max():.3f} m/s")
    for law, error in errors.items():
        print(f"replayed under {law}: ends {1e3 * error:+.3f} mm from the target, {run_text(runs[law])}")
    if arguments.figure:
        draw(plan, runs, arguments.figure)
    # Collocation and co-simulation agree to a tenth of a millimetre; the plan did not know stiction.
    return 0 if abs(errors["SmoothCoulomb"]) < 1e-4 < abs(errors["Stribeck"]) else 1


def dynamics(unpacked: str) -> ca.Function:
    """Rates of the states that move, for states and voltage, all divided by their magnitudes."""
    plant = ca.DaeBuilder("plant", unpacked)
    for name, value in {**PARAMETERS, "friction.lawNumber": LAWS["SmoothCoulomb"], "supplyPressure": SUPPLY}.items():
        plant.set(name, value)
    rates = plant.create("rates", ["x", "u"], ["ode"])
    places = [plant.x().index(name) for name in STATES]
    scales = ca.DM(list(STATES.values()))
    x, voltage = ca.MX.sym("x", len(STATES)), ca.MX.sym("voltage")
    whole = ca.MX(ca.DM(plant.get(plant.x())))
    whole[places] = scales * x
    inputs = ca.vertcat(*[voltage if name == "valveVoltage" else plant.get(name) for name in plant.u()])
    return ca.Function("dynamics", [x, voltage], [rates(whole, inputs)[places] / scales])


def guess(fmu: Path) -> NDArray:
    """A run from which the optimiser starts: the valve opens one way and then the other."""
    times = np.linspace(0, DURATION, INTERVALS + 1)
    middles = 0.5 * (times[1:] + times[:-1])
    return replayed(fmu, times, 5.0 + np.sin(2 * np.pi * middles / DURATION), "SmoothCoulomb")


def planned(rates: ca.Function, first: NDArray) -> Plan:
    """Direct collocation (Radau) with a constant voltage in each interval, as smooth as possible."""
    h, n = DURATION / INTERVALS, len(STATES)
    points = ca.collocation_points(DEGREE, "radau")
    slopes, last, _ = ca.collocation_coeff(points)
    scales = np.array(list(STATES.values()))
    rest = np.array([START, 0.0, PRESSURE, PARAMETERS["chamberB.pressure0"], 0.0, 0.0]) / scales
    ends = ca.MX.sym("ends", n, INTERVALS + 1)
    inner = ca.MX.sym("inner", n, INTERVALS * DEGREE)
    voltage = ca.MX.sym("voltage", 1, INTERVALS)
    # One call for each point: CasADi 3.8 gives `map` of an FMU a wrong Jacobian within larger expressions.
    at = ca.horzcat(*[rates(inner[:, i], voltage[i // DEGREE]) for i in range(INTERVALS * DEGREE)])
    equations = [ends[:, 0] - rest]
    for k in range(INTERVALS):
        own = slice(DEGREE * k, DEGREE * (k + 1))
        path = ca.horzcat(ends[:, k], inner[:, own])
        equations.append(ca.vec(path @ slopes - h * at[:, own]))
        equations.append(path @ last - ends[:, k + 1])
    arrived = ends[:2, -1] - np.array([END, 0.0]) / scales[:2]
    effort = ca.sumsqr(ca.diff(voltage, 1, 1)) + 1e-2 * ca.sumsqr(voltage - 5.0)
    unknowns = ca.veccat(ends, inner, voltage)
    solver = ca.nlpsol(
        "move",
        "ipopt",
        {"x": unknowns, "f": effort, "g": ca.vertcat(*equations, arrived)},
        {
            "print_time": False,
            "ipopt": {"hessian_approximation": "limited-memory", "print_level": 0, "sb": "yes", "max_iter": 1000},
        },
    )
    count = INTERVALS * (DEGREE + 1) + 1
    edges = h * np.arange(INTERVALS + 1)
    within = (edges[:-1, None] + h * np.array(points)).ravel()

    def sampled(times: NDArray) -> NDArray:
        return np.array(
            [np.interp(times, first["time"], first[name]) / scale for name, scale in STATES.items()]
        ).T.ravel()

    low = np.tile([0.0, -4.0, AMBIENT / 1e5, AMBIENT / 1e5, -1.0, -20.0], count)
    high = np.tile([5.0, 4.0, SUPPLY / 1e5, SUPPLY / 1e5, 1.0, 20.0], count)
    found = solver(
        x0=np.concatenate(
            [sampled(edges), sampled(within), 5.0 + np.sin(2 * np.pi * (edges[:-1] + 0.5 * h) / DURATION)]
        ),
        lbx=np.concatenate([low, np.full(INTERVALS, 0.0)]),
        ubx=np.concatenate([high, np.full(INTERVALS, 10.0)]),
        lbg=0,
        ubg=0,
    )
    if not solver.stats()["success"]:
        sys.exit(f"IPOPT: {solver.stats()['return_status']}")
    solution = np.array(found["x"]).ravel()
    states = scales[:, None] * solution[: n * (INTERVALS + 1)].reshape(n, -1, order="F")
    return Plan(edges, solution[-INTERVALS:], dict(zip(STATES, states, strict=True)))


def replayed(fmu: Path, times: NDArray, voltage: NDArray, law: str) -> NDArray:
    """A run with a voltage that is constant in each interval."""
    edges, levels = np.repeat(times, 2)[1:-1], np.repeat(voltage, 2)
    signal = np.array(list(zip(edges, levels, strict=True)), dtype=[("time", float), ("valveVoltage", float)])
    return simulate_fmu(
        str(fmu),
        fmi_type="CoSimulation",
        stop_time=DURATION,
        output_interval=DURATION / (10 * INTERVALS),
        start_values={**PARAMETERS, "friction.lawNumber": LAWS[law], "supplyPressure": SUPPLY},
        input=signal,
        output=[*STATES, "sticking"],
    )


def run_text(run: NDArray) -> str:
    return f"sticks {100 * np.mean(run['sticking']):.0f} % of the time"


def draw(plan: Plan, runs: dict[str, NDArray], file: Path) -> None:
    figure, (top, middle, bottom) = plt.subplots(3, 1, sharex=True, figsize=(7, 7), layout="constrained")
    top.plot(plan.times, 1e3 * plan.states["position"], "k--", label="planned")
    middle.plot(plan.times, plan.states["velocity"], "k--", label="planned")
    for law, run in runs.items():
        top.plot(run["time"], 1e3 * run["position"], label=f"replayed under {law}")
        middle.plot(run["time"], run["velocity"])
    top.axhline(1e3 * END, color="0.7", linewidth=0.8)
    top.set_ylabel("position (mm)"), top.legend()
    middle.set_ylabel("velocity (m/s)")
    bottom.stairs(plan.voltage, plan.times, baseline=None, color="k")
    bottom.set_ylabel("valve voltage (V)"), bottom.set_xlabel("time (s)")
    figure.savefig(file, dpi=110)


if __name__ == "__main__":
    sys.exit(main())
