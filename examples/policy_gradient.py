"""A positioning policy learned by proximal policy optimisation, in one file and without a framework of deep learning.

Actor and critic are linear in a few features of an observation: enough for a position loop, and quick enough to see
the reward rise within a minute on one processor. The rest is as in implementations of one file: a vector of plants,
generalised advantages, several epochs of clipped updates by Adam. It fails unless the mean reward rises by half of
what is missing.

Usage: python examples/policy_gradient.py [--updates 40] [--seed 1]
"""

from __future__ import annotations

import argparse
import sys

import gymnasium
import numpy as np
import pneumatic_servo  # noqa: F401 - makes the environments known
from numpy.typing import NDArray

Array = NDArray[np.float64]

PLANTS, STEPS = 64, 100
TASK = {"laws": ["Stribeck", "LuGre"], "period": 1e-2, "substeps": 10, "duration": 1.0}
DISCOUNT, SMOOTH, CLIP, EPOCHS, BATCHES, RATE = 0.97, 0.95, 0.2, 8, 4, 0.03


def features(observations: NDArray[np.float32]) -> Array:
    """Error, its square root, velocity, difference of pressures, and a one; each of the size of 1."""
    error, _, velocity, a, b = observations.astype(float).T
    root = np.sign(error) * np.sqrt(np.abs(error))
    return np.column_stack([5.0 * error, 2.0 * root, velocity, 2.0 * (a - b), np.ones(len(error))])


def worth(observations: NDArray[np.float32]) -> Array:
    """Input of the critic: magnitudes, since a return does not know the side."""
    seen = features(observations)
    return np.column_stack([np.abs(seen[:, :4]), seen[:, 0] * seen[:, 2], np.ones(len(seen))])


class Adam:
    """Steps along smoothed slopes."""

    def __init__(self, size: int) -> None:
        self.mean, self.square, self.count = np.zeros(size), np.zeros(size), 0

    def step(self, slope: Array) -> Array:
        self.count += 1
        self.mean += 0.1 * (slope - self.mean)
        self.square += 0.001 * (slope**2 - self.square)
        mean, square = self.mean / (1 - 0.9**self.count), self.square / (1 - 0.999**self.count)
        return RATE * mean / (np.sqrt(square) + 1e-8)


def learn(updates: int, seed: int) -> list[float]:
    """The mean reward of a step in each update."""
    random = np.random.default_rng(seed)
    fleet = gymnasium.make_vec("pneumatic_servo/Positioning-v0", num_envs=PLANTS, **TASK)
    observations, _ = fleet.reset(seed=seed)
    policy, critic = np.zeros(6), np.zeros(6)  # five weights and the logarithm of the spread; six weights
    policy[5] = np.log(0.5)
    adam, rewards = Adam(6), []
    for _ in range(updates):
        seen, values, actions, gains = [], [], [], []
        for _ in range(STEPS):
            now = features(observations)
            action = now @ policy[:5] + np.exp(policy[5]) * random.standard_normal(PLANTS)
            seen.append(now)
            values.append(worth(observations))
            actions.append(action)
            observations, reward, *_ = fleet.step(np.clip(action, -1, 1)[:, None].astype(np.float32))
            gains.append(reward)
        # An episode lasts as long as an update, and begins anew at the step after it, which is left out.
        rewards.append(float(np.mean(gains)))
        observations, _ = fleet.reset()
        x, w, a, r = (np.array(part) for part in (seen, values, actions, gains))
        advantages, returns = estimated(r, w @ critic)
        policy = improved(policy, adam, x.reshape(-1, 5), a.ravel(), advantages.ravel(), random)
        critic = np.linalg.lstsq(w.reshape(-1, 6), returns.ravel(), rcond=None)[0]
    return rewards


def estimated(rewards: Array, values: Array) -> tuple[Array, Array]:
    """Generalised advantages, and the returns that the critic learns from; the last value goes on for ever."""
    advantages, carried = np.zeros_like(rewards), np.zeros(rewards.shape[1])
    following = np.vstack([values[1:], values[-1:]])
    for step in reversed(range(len(rewards))):
        carried = rewards[step] + DISCOUNT * following[step] - values[step] + DISCOUNT * SMOOTH * carried
        advantages[step] = carried
    return advantages, advantages + values


def improved(policy: Array, adam: Adam, seen: Array, actions: Array, advantages: Array, random: np.random.Generator
             ) -> Array:  # fmt: skip
    """The policy after some epochs of clipped updates."""
    advantages = (advantages - advantages.mean()) / (advantages.std() + 1e-9)
    old = likelihood(policy, seen, actions)[0]
    for _ in range(EPOCHS):
        for batch in np.array_split(random.permutation(len(seen)), BATCHES):
            log, slope = likelihood(policy, seen[batch], actions[batch])
            ratio, gain = np.exp(log - old[batch]), advantages[batch]
            is_free = np.where(gain > 0, ratio < 1 + CLIP, ratio > 1 - CLIP)
            policy = policy + adam.step(((ratio * gain * is_free) @ slope) / len(batch))
            policy[5] = max(policy[5], np.log(0.05))
    return policy


def likelihood(policy: Array, seen: Array, actions: Array) -> tuple[Array, Array]:
    """The logarithm of the density of actions, and its slopes."""
    spread = np.exp(policy[5])
    off = (actions - seen @ policy[:5]) / spread
    return -0.5 * off**2 - policy[5], np.column_stack([off[:, None] * seen / spread, off**2 - 1.0])


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--updates", type=int, default=40)
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args()
    rewards = learn(options.updates, options.seed)
    for update in range(0, len(rewards), max(1, len(rewards) // 10)):
        print(f"update {update:3}: mean reward of a step {rewards[update]:7.4f}")
    print(f"at last    : mean reward of a step {rewards[-1]:7.4f}")
    return 0 if rewards[-1] > 0.5 * rewards[0] else 1


if __name__ == "__main__":
    sys.exit(main())
