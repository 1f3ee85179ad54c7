"""Tracks a course with reversals: iLQR, which knows the friction, against the PositionController.

The iterative linear-quadratic regulator takes the transition of every step (`Simulation.transition`), exact through
stick and slip, and starts from the voltages of the controller. Beside it the controller with gains that the method of
Nelder and Mead finds without derivatives. Needs pneumatic_servo, scipy and matplotlib.
"""

import argparse
import sys
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
import pneumatic_servo as ps
from pneumatic_servo import figures
from scipy.optimize import minimize

STEP, COUNT, SEEN, ROUNDS, RUNS = 2e-3, 400, ["position", "velocity"], 6, 100
GAINS = {"gain.position": 12.0, "gain.velocity": 8.0, "gain.integral": 10.0}
PHASE = 4.0 * np.pi * STEP * np.arange(COUNT + 1)
COURSE = np.stack([0.25 - 0.02 * np.cos(PHASE), 0.08 * np.pi * np.sin(PHASE), np.full(COUNT + 1, 5.0)]).T
WEIGHTS, DAMPING = np.array([1e8, 2.5e3, 0.04]), 0.3  # scales of equal cost: 0.1 mm, 20 mm/s, 5 V from neutral
GIVEN = {"position0": COURSE[0, 0], "valve.hysteresis": 0.0, "supplyPressure": 6e5}  # a play has no derivative at rest


def rollout(policy):
    """The states before each step of a policy; the observations behind it, with its voltage; and the cost."""
    plant, states, seen = ps.Model().start(GIVEN), [], []
    names = plant.states
    for step in range(COUNT):
        states.append(plant.get(names))
        plant.set_one("valveVoltage", float(np.clip(policy(step, states[-1]), 0.1, 9.9)))
        plant.step(STEP)
        seen.append(plant.get([*SEEN, "valveVoltage"]))
    return states, np.array(seen), float(np.sum((np.array(seen) - COURSE[1:]) ** 2 @ WEIGHTS))


def controlled(logarithms):
    given = {**dict(zip(GAINS, np.exp(logarithms), strict=True)), "sampleTime": STEP, "position": COURSE[0, 0]}
    controller = ps.Model("PositionController").start({**given, "referencePosition": COURSE[0, 0]})

    def policy(step, states):
        controller.set({"referencePosition": COURSE[step + 1, 0], "position": states[0], "velocity": states[1]})
        controller.step(STEP)
        return controller["valveVoltage"]

    return rollout(policy)


def improved(states, seen, cost):
    """The rollout of the linear-quadratic policy around another one."""
    plant, steps, policy, value, slope, names = ps.Model().start(GIVEN), [], [], np.zeros((0, 0)), np.zeros(0), ()
    for voltage in seen[:, 2]:
        plant.set_one("valveVoltage", voltage)
        steps.append(plant.transition(STEP, outputs=SEEN))
    for step, off in zip(reversed(steps), (seen - COURSE[1:])[::-1], strict=True):
        # The numbers of the memory differ where the mode does, and are known by their names.
        same = np.array([[one == other for other in step.next_states] for one in names]).reshape(-1, len(step.A))
        moved, shown = same @ np.hstack([step.A, step.B[:, :1]]), np.zeros((3, step.A.shape[1] + 1))
        shown[:2], shown[2, -1] = np.hstack([step.C, step.D[:, :1]]), 1.0
        bend = moved.T @ value @ moved + shown.T * WEIGHTS @ shown
        fall = moved.T @ slope + shown.T @ (WEIGHTS * off)
        change, *gain = -np.array([fall[-1], *bend[-1, :-1]]) / (bend[-1, -1] + DAMPING)
        value, slope, names = (
            bend[:-1, :-1] + np.outer(bend[:-1, -1], gain),
            fall[:-1] + bend[:-1, -1] * change,
            step.states,
        )
        policy.insert(0, (change, gain[: len(states[0])]))
    for share in (1.0, 0.5, 0.25, 0.1):
        found = rollout(lambda k, x, part=share: seen[k, 2] + part * policy[k][0] + policy[k][1] @ (x - states[k]))
        if found[2] < cost:
            break
    return found


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--figure", type=Path, help="where to draw")
    options, first = parser.parse_args(), np.log([*GAINS.values()])
    tuned = minimize(lambda it: controlled(it)[2], first, method="Nelder-Mead", options={"maxfev": RUNS})
    runs = {"PositionController": controlled(first), f"tuned by {tuned.nfev} runs": controlled(tuned.x)}
    found = controlled(first)
    for _ in range(ROUNDS):
        found = improved(*found)
    runs[f"iLQR, {ROUNDS} rounds"] = found
    plt.rcParams.update(figures.STYLE | {"axes.prop_cycle": figures.CYCLE})
    figure, axes = plt.subplots(2, 1, sharex=True, figsize=(7, 5), layout="constrained")
    for name, (_, seen, _) in runs.items():
        off = 1e3 * (seen[:, 0] - COURSE[1:, 0])
        print(f"{name}: {np.sqrt(np.mean(off**2)):.3f} mm off (rms), {np.abs(off).max():.2f} mm at most")
        axes[0].plot(STEP * np.arange(1, COUNT + 1), off, label=name)
        axes[1].step(STEP * np.arange(COUNT), seen[:, 2], where="post")
    axes[0].set_ylabel("position error (mm)"), axes[0].legend()
    axes[1].set_ylabel("valve voltage (V)"), axes[1].set_xlabel("time (s)")
    if options.figure:
        figure.savefig(options.figure, dpi=110)
    return 0 if found[2] < 0.1 * tuned.fun else 1


if __name__ == "__main__":
    sys.exit(main())
