"""A positioning policy learned with Stable-Baselines3: proximal policy optimisation with its usual network.

It needs Stable-Baselines3, which brings PyTorch: pip install stable-baselines3. The policy is tried before and after.
The example fails unless what is missing of the mean reward falls by half.

Usage: python examples/stable_baselines.py [--steps 60000] [--seed 1]
"""

from __future__ import annotations

import argparse
import sys

import pneumatic_servo  # noqa: F401 - makes the environments known

NAME = "pneumatic_servo/Positioning-v0"
TASK = {"laws": ["Stribeck", "LuGre"], "period": 1e-2, "substeps": 10, "duration": 1.0}
PLANTS, EPISODES = 16, 40


def learn(steps: int, seed: int) -> tuple[float, float]:
    """The mean reward of a step before and after a number of steps of learning."""
    try:
        from stable_baselines3 import PPO
        from stable_baselines3.common.env_util import make_vec_env
        from stable_baselines3.common.evaluation import evaluate_policy
    except ImportError as error:
        sys.exit(f"this example needs Stable-Baselines3: pip install stable-baselines3 ({error})")
    plants = make_vec_env(NAME, n_envs=PLANTS, seed=seed, env_kwargs=TASK)
    model = PPO(
        "MlpPolicy", plants, seed=seed, device="cpu", n_steps=100, batch_size=400, gamma=0.97, learning_rate=1e-3
    )

    def tried() -> float:
        judge = make_vec_env(NAME, n_envs=PLANTS, seed=seed + 1000, env_kwargs=TASK)
        total, _ = evaluate_policy(model, judge, n_eval_episodes=EPISODES)
        return float(total) / (TASK["duration"] / TASK["period"])

    before = tried()
    model.learn(steps)
    return before, tried()


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--steps", type=int, default=60_000)
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args()
    before, after = learn(options.steps, options.seed)
    print(f"mean reward of a step: {before:.4f} before, {after:.4f} after {options.steps} steps")
    return 0 if after > 0.5 * before else 1


if __name__ == "__main__":
    sys.exit(main())
