"""A positioning policy found by a simple search, under randomised friction laws and parameters, against a baseline.

The policy has six numbers: gains on error, velocity, difference of pressures and integral of the error, and height and
width of a jump over the valve's dead zone. The cross-entropy method looks for them: of many candidates, each tried on
several random plants, the best shape the distribution of the next ones. It is compared with the library's
PositionController on plants that neither has seen.

Usage: python examples/policy_search.py [--generations 8] [--plot policy_search.png]
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import Any

import gymnasium
import matplotlib as mpl
import numpy as np
import pneumatic_servo.envs as envs
from matplotlib.figure import Figure
from numpy.typing import NDArray
from pneumatic_servo import figures
from tqdm import tqdm

Array = NDArray[np.float64]

CANDIDATES, PLANTS, ELITE = 48, 16, 8
TASK: dict[str, Any] = {
    "laws": ["Stribeck", "CoulombStiction", "LuGre", "GMS"],
    "ranges": dict(envs.RANDOM),
    "period": 2e-3,
    "substeps": 2,
    "duration": 1.5,
}
STEPS = round(TASK["duration"] / TASK["period"])
STROKE = 0.5
MEAN = np.array([6.0, 0.5, 0.0, 1.0, 0.05, 0.02])
SPREAD = np.array([4.0, 0.4, 0.3, 1.0, 0.04, 0.02])


class Policy:
    """Candidates of shape (policies, 6), each for the same number of plants."""

    def __init__(self, numbers: Array, plants: int) -> None:
        self.numbers = np.repeat(np.atleast_2d(numbers), plants, axis=0)
        self.integral = np.zeros(len(self.numbers))

    def __call__(self, observations: NDArray[np.float32]) -> NDArray[np.float32]:
        error, _, velocity, pressure_a, pressure_b = observations.astype(float).T
        gain, damping, load, reset, jump, width = self.numbers.T
        # Far from the target the integral would only wind up.
        self.integral += np.where(np.abs(error) < 0.02, TASK["period"] * error, 0.0)
        command = gain * error - damping * velocity - load * (pressure_a - pressure_b) + 10.0 * reset * self.integral
        return (command + jump * np.tanh(command / np.maximum(np.abs(width), 1e-3))).astype(np.float32)[:, None]


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--generations", type=int, default=8)
    parser.add_argument("--plot", type=Path, help="figure to write")
    options = parser.parse_args()
    numbers, returns = search(options.generations)
    print("numbers:", np.array2string(numbers, precision=3))
    fleet = make(64)
    errors = {
        "policy found": episode(fleet, Policy(numbers, 64), seed=10_000)[0],
        "PositionController": episode(fleet, envs.PositionControllers(64, TASK["period"]), seed=10_000)[0],
    }
    for name, error in errors.items():
        late = 1e3 * error[2 * STEPS // 3 :]
        print(f"{name:20} mean error {1e3 * error.mean():6.2f} mm; in the last third {late.mean():6.3f} mm")
    if options.plot:
        draw(returns, errors, options.plot)
    found, baseline = (error.mean() for error in errors.values())
    return 0 if found < baseline else 1


def make(number: int) -> envs.VectorPositioning:
    fleet = gymnasium.make_vec("pneumatic_servo/Positioning-v0", num_envs=number, **TASK)
    assert isinstance(fleet, envs.VectorPositioning)
    return fleet


def search(generations: int) -> tuple[Array, list[float]]:
    """The numbers found, and the mean return of each generation's mean on plants that are kept for this."""
    random = np.random.default_rng(0)
    mean, spread, returns = MEAN, SPREAD, []
    fleet, kept = make(CANDIDATES * PLANTS), make(64)
    for generation in tqdm(range(generations), "search", disable=None):
        candidates = mean + spread * random.standard_normal((CANDIDATES, len(mean)))
        # All candidates of a generation are tried on the same plants.
        seeds = [1000 * generation + plant for _ in range(CANDIDATES) for plant in range(PLANTS)]
        total = episode(fleet, Policy(candidates, PLANTS), seeds)[1].reshape(CANDIDATES, PLANTS).mean(axis=1)
        best = np.argsort(total)[-ELITE:]
        mean, spread = candidates[best].mean(axis=0), candidates[best].std(axis=0) + 0.02 * SPREAD
        returns.append(float(episode(kept, Policy(mean, 64), seed=5_000)[1].mean()))
    return mean, returns


def episode(fleet: envs.VectorPositioning, policy: Any, seed: int | list[int]) -> tuple[Array, Array]:
    """The distance to the target in m, of shape (steps, plants), and the return of each plant."""
    observations, _ = fleet.reset(seed=seed)
    errors, total = [], np.zeros(fleet.num_envs)
    for _ in range(STEPS):
        observations, reward, *_ = fleet.step(policy(observations))
        errors.append(STROKE * np.abs(observations[:, 0].astype(float)))
        total += reward
    return np.array(errors), total


def draw(returns: list[float], errors: dict[str, Array], file: Path) -> None:
    with mpl.rc_context(figures.STYLE):
        figure = Figure(figsize=(9, 3.4), layout="constrained")
        left, right = figure.subplots(1, 2)
        left.plot(range(1, len(returns) + 1), returns, "o-")
        left.set(xlabel="generation", ylabel="return of the mean policy")
        time = np.arange(1, STEPS + 1) * TASK["period"]
        for (name, error), colour in zip(errors.items(), figures.COLOURS, strict=False):
            low, middle, high = np.quantile(1e3 * error, [0.1, 0.5, 0.9], axis=1)
            right.semilogy(time, middle, color=colour, label=name)
            right.fill_between(time, low, high, color=colour, alpha=0.15, linewidth=0)
        right.set(xlabel="time (s)", ylabel="distance to target (mm)", title="median, and 10 to 90 % of the plants")
        right.set_ylim(1e-2, None)
        right.legend()
        figure.savefig(file)


if __name__ == "__main__":
    sys.exit(main())
