"""Predictive control by sampling: 1,000 roll-outs of the plant at each decision, against the PositionController.

Every 20 ms the controller rolls out 1,000 sequences of voltages over the next 120 ms from what it measures (position,
velocity, pressures), weighs them by their cost (path-integral control) and applies the first voltage of the mean. Its
model is the plant with another friction law than the controlled one. The PositionController has an
integrator: where the carriage sticks it hunts around the target.

Usage: python examples/predictive_control.py [--rollouts 1000] [--duration 3] [--plot predictive_control.png]
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

import matplotlib as mpl
import numpy as np
import pneumatic_servo as ps
from matplotlib.figure import Figure
from numpy.typing import NDArray
from pneumatic_servo import figures

Array = NDArray[np.float64]

STEP, PERIOD, KNOTS = 1e-3, 0.02, 6
START, TARGET = 0.20, 0.25
SPREAD = 0.6
"""Standard deviation of the voltages in V."""
TEMPERATURE = 0.05
"""Costs that are this part of their spread above the smallest weigh 1/e."""
MEASURED = ["position", "velocity", "chamberA.pressure", "chamberB.pressure"]
# Dry seals: twice the break-away force that the controllers are made for.
PLANT: dict[str, ps.Value] = {
    "friction.law": "Stribeck",
    "friction.stribeck.Fs": 20.0,
    "supplyPressure": 6e5,
    "position0": START,
}
BELIEF: dict[str, ps.Value] = {"friction.law": "CoulombStiction", "supplyPressure": 6e5}


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--rollouts", type=int, default=1000)
    parser.add_argument("--duration", type=float, default=3.0, help="in s")
    parser.add_argument("--plot", type=Path, help="figure to write")
    options = parser.parse_args()
    model = ps.Model("PneumaticServoCylinder")
    places = {
        "predictive": predictive(model, options.rollouts, options.duration),
        "PositionController": position_controller(model, options.duration),
    }
    for name, place in places.items():
        print(f"{name:20} {describe(place)}")
    if options.plot:
        draw(places, options.plot)
    late = {name: 1e3 * np.abs(place[len(place) // 2 :] - TARGET) for name, place in places.items()}
    return 0 if late["predictive"].max() < 5.0 else 1


def predictive(model: ps.Model, rollouts: int, duration: float) -> Array:
    """Positions in m at each millisecond under the predictive controller."""
    random = np.random.default_rng(1)
    plant = model.start(PLANT)
    plan = np.full(KNOTS, 5.0)
    places = [plant["position"]]
    for _ in range(round(duration / PERIOD)):
        tried = np.clip(plan + SPREAD * random.standard_normal((rollouts, KNOTS)), 0.0, 10.0)
        # Neither the plan as it is nor a closed valve may be missed.
        tried[0], tried[1] = plan, 5.0
        costs = cost(model, dict(zip(MEASURED, plant.get(MEASURED).tolist(), strict=True)), tried)
        weights = np.exp(-(costs - costs.min()) / (TEMPERATURE * costs.std() + 1e-12))
        plan = weights @ tried / weights.sum()
        plant["valveVoltage"] = float(plan[0])
        plan = np.append(plan[1:], 5.0)
        for _ in range(round(PERIOD / STEP)):
            plant.step(STEP)
            places.append(plant["position"])
    return np.array(places)


def cost(model: ps.Model, measured: dict[str, float], tried: Array) -> Array:
    """The cost of sequences of voltages, of shape (rollouts, KNOTS), from a measured state."""
    # A pair of points at each knot makes steps.
    knots = np.arange(KNOTS + 1) * PERIOD
    times = np.repeat(knots, 2)[1:-1]
    # The walls of the stroke yield a little, and a position beyond them is no place to start from.
    start = {f"{name}0": value for name, value in measured.items()} | {
        "position0": np.clip(measured["position"], 0.0, 0.5)
    }
    runs = model.simulate_many(
        common=BELIEF | start,
        inputs={"valveVoltage": (times, np.repeat(tried, 2, axis=1))},
        stop=KNOTS * PERIOD,
        step=STEP,
        every=10,
        outputs=["position", "velocity"],
        progress=False,
    )
    error, velocity = 1e3 * (runs["position"] - TARGET), runs["velocity"]
    effort = np.sum((tried - 5.0) ** 2, axis=1)
    return np.asarray(np.mean(error**2, axis=1) + 2e3 * np.mean(velocity[:, -4:] ** 2, axis=1) + 0.02 * effort)


def position_controller(model: ps.Model, duration: float) -> Array:
    """Positions in m at each millisecond under the library's controller."""
    plant = model.start(PLANT)
    controller = ps.Model("PositionController").start({"referencePosition": TARGET, "position": START})
    places = [plant["position"]]
    for _ in range(round(duration / STEP)):
        controller.set({"position": plant["position"], "velocity": plant["velocity"]})
        controller.step(STEP)
        plant["valveVoltage"] = controller["valveVoltage"]
        plant.step(STEP)
        places.append(plant["position"])
    return np.array(places)


def describe(place: Array) -> str:
    """The error in the second half, and how often the carriage sets out again there: hunting."""
    late = place[len(place) // 2 :]
    moves = np.abs(np.diff(late)) > 1e-6
    starts = int(np.count_nonzero(moves[1:] & ~moves[:-1]))
    error = 1e3 * np.abs(late - TARGET)
    return f"rms error {np.sqrt(np.mean(error**2)):6.3f} mm, largest {error.max():6.3f} mm, sets out {starts} times"


def draw(places: dict[str, Array], file: Path) -> None:
    with mpl.rc_context(figures.STYLE):
        figure = Figure(figsize=(8, 3.2), layout="constrained")
        axis = figure.subplots()
        for name, place in places.items():
            axis.plot(np.arange(len(place)) * STEP, 1e3 * (place - TARGET), label=name)
        axis.axhline(0.0, color=figures.GREY, linewidth=0.8)
        axis.set(xlabel="time (s)", ylabel="position less target (mm)")
        axis.legend()
        figure.savefig(file)


if __name__ == "__main__":
    sys.exit(main())
