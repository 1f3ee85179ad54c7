"""Tunes the drive in closed loop by gradient descent, with the exact gradient of its step response.

The gradient goes through every sample of the PositionController and every step of the cylinder, which sticks and slips:
slopes are carried along by `Simulation.transition` of both. Beside it the method of Nelder and Mead, which needs no
derivatives. Needs pneumatic_servo, scipy and matplotlib.
"""

import argparse
import sys
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
import pneumatic_servo as ps
from pneumatic_servo import figures
from scipy.optimize import minimize

STEP, COUNT, START, TARGET, SEEN = 2e-3, 300, 0.2, 0.25, ["position", "velocity"]
GAINS = {"gain.position": 12.0, "gain.velocity": 8.0, "gain.integral": 10.0, "feedForward.gain": 1.6}
TIMES = STEP * np.arange(1, COUNT + 1)
# In a valve with a play, a voltage that rests has no derivative.
PLANT = {"position0": START, "valve.hysteresis": 0.0, "supplyPressure": 6e5}
# At the ends of its range the valve has a derivative to one side alone: the controller stays 0.1 V within.
CONTROLLER = {"sampleTime": STEP, "position": START, "referencePosition": START, "valve.range": 4.9}


class Slopes:
    """Slopes of the states of a part by the gains, from step to step."""

    def __init__(self, part, parameters, outputs):
        self.part, self.parameters, self.outputs, self.states = part, parameters, outputs, {}

    def step(self, **of_inputs):
        """Go on over a step, and return the slopes of the outputs."""
        it = self.part.transition(STEP, parameters=self.parameters, outputs=self.outputs)
        none = np.zeros(len(GAINS))
        x = np.array([self.states.get(name, none) for name in it.states])
        u = np.array([of_inputs.get(name, none) for name in it.inputs])
        p = np.eye(len(it.parameters), len(GAINS))
        self.states = dict(zip(it.next_states, it.A @ x + it.B @ u + it.P @ p, strict=True))
        return it.C @ x + it.D @ u + it.Q @ p


def response(logarithms, slopes=True):
    """Positions of the step response, and their slopes by the logarithms of the gains."""
    gains = np.exp(logarithms)
    plant = ps.Model().start(PLANT)
    controller = ps.Model("PositionController").start({**CONTROLLER, **dict(zip(GAINS, gains, strict=True))})
    moved, set_point = Slopes(plant, [], SEEN), Slopes(controller, list(GAINS), ["valveVoltage"])
    motion, voltage, found = np.zeros((2, len(GAINS))), np.zeros((1, len(GAINS))), []
    controller["referencePosition"] = TARGET
    for _ in range(COUNT):
        for name in SEEN:
            controller.set_one(name, plant[name])
        plant.set_one("valveVoltage", controller["valveVoltage"])
        if slopes:
            before, motion = motion, moved.step(valveVoltage=voltage[0])
            voltage = set_point.step(position=before[0], velocity=before[1])
        else:
            plant.step(STEP), controller.step(STEP)
        found.append([plant["position"], *(motion[0] * gains)])
    return np.array(found)


def cost(found):
    """Error of a response, and its gradient: a millimetre counts the more, the later."""
    off, weights = 1e3 * (found[:, 0] - TARGET), STEP * TIMES
    return weights @ off**2, 2e3 * (weights * off) @ found[:, 1:]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--figure", type=Path, help="where to draw")
    options, first = parser.parse_args(), np.log([*GAINS.values()])
    bounds = [(it - 2.0, it + 2.0) for it in first]
    descent = minimize(
        lambda it: cost(response(it)), first, jac=True, method="L-BFGS-B", bounds=bounds, options={"maxfun": 15}
    )
    other = minimize(
        lambda it: cost(response(it, slopes=False))[0], first, method="Nelder-Mead", options={"maxfev": 100}
    )
    names = ["start", f"{descent.nfev} gradients", f"Nelder and Mead, {other.nfev} runs"]
    plt.rcParams.update(figures.STYLE | {"axes.prop_cycle": figures.CYCLE})
    for name, gains in zip(names, [first, descent.x, other.x], strict=True):
        found = response(gains, slopes=False)
        print(f"{name}: cost {cost(found)[0]:.3f}, gains {', '.join(f'{it:.2f}' for it in np.exp(gains))}")
        plt.plot(TIMES, 1e3 * found[:, 0], label=name)
    plt.xlabel("time (s)"), plt.ylabel("position (mm)"), plt.legend(), plt.axhline(1e3 * TARGET, color="0.7", zorder=0)
    if options.figure:
        plt.savefig(options.figure, dpi=110)
    return 0 if descent.fun < 0.8 * cost(response(first, slopes=False))[0] else 1


if __name__ == "__main__":
    sys.exit(main())
