"""Friction compensation in a position loop: with an observer, and with a filtered derivative.

A cascade of position and velocity with an integral part, as the library's controller is, in which only the position is
measured, with noise. At a reversal the pressures must change until the carriage breaks away, in the other direction:
the compensation adds ``k * (needed - found)`` to the command. The friction force that is needed is the one of the
friction curve at the wanted velocity. The one that is found comes

- with an observer from its estimate: while the carriage sticks, the force of the pressures;
- with a derivative, filtered by a first-order low-pass, from nowhere: it is 0, as in a feed-forward by the sign.

Each compensation has the gain that tracks best. Leaves a table (CSV) with the RMS errors of tracking, and the hunting
while the reference rests: extent, mean error and reversals of the motion; and a figure.

On friction from an observer: B. Friedland, Y.-J. Park, On adaptive friction compensation, IEEE Transactions on
Automatic Control 37 (1992); on extended Kalman filters: A. Ramasubramanian, L. R. Ray, Comparison of EKBF-based and
classical friction compensation, https://doi.org/10.1115/1.2431817; on noise at reversals: M. Ruderman, Reduced-order
asymptotic observer of nonlinear friction for precise motion control, https://arxiv.org/abs/2504.21316.

Usage: python docs/studies/friction_compensation.py [--small]
"""

from __future__ import annotations

import csv
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pneumatic_servo as ps
from common import arguments, parallel, plt, save

PERIOD = 1e-3
NOISE = 20e-6
"""Of the position in m."""
CUTOFF = 30.0
"""Of the derivative's filter in Hz."""
STANDSTILL = 5e-3
"""Wanted velocity in m/s from which on friction is compensated in full."""
PLANT: dict[str, ps.Value] = {"supplyPressure": 6e5, "friction.law": "Stribeck", "position0": 0.25}
MOVES, STOP = 4.0, 9.0
"""Times in s until which the reference moves, and of the end."""
GAINS = {"position": 12.0, "velocity": 8.0, "integral": 10.0, "feedForward": 1.6}
"""As of `PositionController`."""
DEAD_ZONE, RANGE, TRANSITION = 0.08, 5.0, 0.1


def reference(time: float) -> tuple[float, float]:
    """Position in m and velocity in m/s: a slow sine with reversals, then rest."""
    if time >= MOVES:
        return 0.25, 0.0
    phase = 2.0 * np.pi * 0.25 * time
    return 0.25 + 0.03 * float(np.sin(phase)), 0.03 * 2.0 * np.pi * 0.25 * float(np.cos(phase))


@dataclass(frozen=True)
class Choice:
    """A loop: whether an observer is in it, and the gain of the compensation in V/N."""

    observes: bool
    compensation: float = 0.0


class Loop:
    """The controller; each run has one of its own."""

    def __init__(self, choice: Choice) -> None:
        self.choice, self.noise = choice, np.random.default_rng(1)
        self.observer = ps.Observer(PLANT, measured={"position": NOISE}, period=PERIOD) if choice.observes else None
        self.share = 1.0 - float(np.exp(-2.0 * np.pi * CUTOFF * PERIOD))
        self.last, self.velocity, self.integral, self.voltage = 0.25, 0.0, 0.0, 5.0
        parameters = ps.Model().parameters
        self.levels = [float(parameters[f"friction.stribeck.{name}"].default or 0.0) for name in ("Fs", "Fc", "sigma2")]

    def estimate(self, position: float) -> tuple[float, float]:
        """Return velocity in m/s and friction force in N."""
        if self.observer is not None:
            found = self.observer.update({"valveVoltage": self.voltage}, {"position": position})
            return found["velocity"], found["frictionForce"]
        self.velocity += self.share * ((position - self.last) / PERIOD - self.velocity)
        self.last = position
        return self.velocity, 0.0

    def needed(self, velocity: float) -> float:
        """Return the friction force in N of sliding with a velocity in m/s, and at least that of break-away."""
        held, sliding, viscous = self.levels
        return max(held, sliding + viscous * abs(velocity)) * float(np.tanh(velocity / STANDSTILL))

    def __call__(self, time: float, seen: Mapping[str, float]) -> dict[str, float]:
        position = seen["position"] + NOISE * self.noise.standard_normal()
        velocity, friction = self.estimate(position)
        wanted, speed = reference(time)
        speed = min(max(speed + GAINS["position"] * (wanted - position), -1.0), 1.0)
        lack = speed - velocity
        command = GAINS["feedForward"] * speed + GAINS["velocity"] * lack + self.integral
        command += self.choice.compensation * (self.needed(speed) - friction)
        side = command / TRANSITION if abs(command) < TRANSITION else float(np.sign(command))
        inverted = command * (1.0 - DEAD_ZONE) + side * DEAD_ZONE * RANGE
        effort = min(max(inverted, -RANGE), RANGE)
        if effort == inverted:
            self.integral = min(max(self.integral + PERIOD * GAINS["integral"] * lack, -2.0), 2.0)
        self.voltage = 5.0 + effort
        return {"valveVoltage": self.voltage, "estimate": velocity}


@dataclass(frozen=True)
class Outcome:
    """A run and what it is measured by; lengths in m."""

    choice: Choice
    run: ps.Run
    rms: float
    hunting: float
    offset: float
    reversals: int


def outcome(choice: Choice) -> Outcome:
    """Run a loop."""
    run = ps.Model().simulate(
        PLANT, controller=lambda: Loop(choice), stop=STOP, step=PERIOD,
        outputs=["position", "velocity", "valveVoltage"], record={"estimate": "m/s"},
    )  # fmt: skip
    moves, rests = run.time <= MOVES, run.time >= MOVES + 1.5
    wanted = np.array([reference(time)[0] for time in run.time])
    # A reversal of the motion, rests between left out.
    signs = np.sign(run["velocity"][rests])
    signs = signs[signs != 0.0]
    return Outcome(
        choice, run, rms=float(np.sqrt(np.mean((run["position"] - wanted)[moves] ** 2))),
        hunting=float(np.ptp(run["position"][rests])),
        offset=float(np.mean((run["position"] - wanted)[rests])), reversals=int(np.sum(signs[1:] != signs[:-1])),
    )  # fmt: skip


NAMES = {
    (False, False): "filtered derivative", (False, True): "filtered derivative, compensated",
    (True, False): "observer", (True, True): "observer, compensated",
}  # fmt: skip


def name_of(choice: Choice) -> str:
    return NAMES[choice.observes, choice.compensation > 0.0]


def draw(best: list[Outcome], file: Path) -> None:
    """Draw the tracking error and the velocity estimate beside the plant's."""
    figure, axes = plt.subplots(len(best), 2, figsize=(9, 1.7 * len(best) + 0.6), sharex="col", layout="constrained")
    for (error, velocity), one in zip(axes, best, strict=True):
        wanted = np.array([reference(time)[0] for time in one.run.time])
        error.plot(one.run.time, 1e3 * (one.run["position"] - wanted), linewidth=0.9)
        error.axvspan(MOVES, STOP, color="0.93")
        error.set_title(
            f"{name_of(one.choice)}: RMS {1e3 * one.rms:.2f} mm, hunting {1e3 * one.hunting:.2f} mm", fontsize=9
        )
        error.set_ylabel("error (mm)")
        part = (one.run.time >= 0.6) & (one.run.time <= 1.6)
        velocity.plot(one.run.time[part], 1e3 * one.run["estimate"][part], color="0.7", label="estimate")
        velocity.plot(one.run.time[part], 1e3 * one.run["velocity"][part], "k", linewidth=0.9, label="plant")
        velocity.set_ylabel("velocity (mm/s)")
    axes[0, 1].legend(loc="upper right", fontsize="small")
    axes[0, 0].sharey(axes[-1, 0])
    for axis in axes[-1]:
        axis.set_xlabel("time (s)")
    save(figure, file)


def main() -> None:
    options = arguments(__doc__ or "")
    gains = [0.0, 0.01] if options.small else [0.0, 0.005, 0.01, 0.02, 0.04]
    choices = [Choice(observes, gain) for observes in (False, True) for gain in gains]
    found = parallel(options, "loops", outcome, choices)
    best = [
        min((one for one in found if name_of(one.choice) == name), key=lambda one: one.rms) for name in NAMES.values()
    ]
    with (options.output / "FrictionCompensation.csv").open("w", newline="", encoding="utf-8") as stream:
        table = csv.writer(stream, lineterminator="\n")
        table.writerow(
            [
                "loop",
                "compensation (V/N)",
                "RMS error (mm)",
                "hunting (mm)",
                "mean error at rest (mm)",
                "reversals at rest",
            ]
        )
        for one in best:
            row = [name_of(one.choice), f"{one.choice.compensation:g}", f"{1e3 * one.rms:.3f}",
                   f"{1e3 * one.hunting:.3f}",
                   f"{1e3 * one.offset:.3f}", one.reversals]  # fmt: skip
            table.writerow(row)
            print(*row)
    draw(best, options.output / "FrictionCompensation.png")


if __name__ == "__main__":
    main()
