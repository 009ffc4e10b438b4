"""Train a small policy on one of the tasks with stable-baselines3 (PPO), and score it beside the baseline and chance.

    pip install 'contarm-sim[train]'
    python scripts/train.py --task reach --steps 200000 --out reach.zip

It is a start, not a result: a two-layer network on flat observations, eight arms side by side, default settings.
`PPO.load("reach.zip")` brings the policy back.
"""

from __future__ import annotations

import argparse

import gymnasium
import numpy as np
from stable_baselines3 import PPO
from stable_baselines3.common.vec_env import DummyVecEnv

import contarm_sim.envs.gym  # noqa: F401
from contarm_sim.envs.definition import TASKS, define
from contarm_sim.envs.registration import NAMES
from contarm_sim.envs.scores import POLICIES, score

ARMS = 8


def main() -> None:
    """Train, save, score."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--task", choices=TASKS, default="reach")
    parser.add_argument("--steps", type=int, default=200_000, help="actions to learn from, of all arms together")
    parser.add_argument("--seeds", type=int, default=20, help="episodes that the scores are taken over")
    parser.add_argument("--out", help="where to save the policy (.zip)")
    given = parser.parse_args()

    envs = DummyVecEnv([lambda: gymnasium.make(NAMES[given.task]) for _ in range(ARMS)])
    batch = min(256, max(16, given.steps // ARMS))
    model = PPO("MlpPolicy", envs, n_steps=batch, batch_size=batch, seed=0, device="cpu")
    model.learn(given.steps)
    if given.out:
        model.save(given.out)

    definition = define(given.task)
    policies = {"learned": lambda observation: np.asarray(model.predict(observation, deterministic=True)[0], float)}
    for name, policy in (policies | {name: make(definition) for name, make in POLICIES.items()}).items():
        found = score(definition, policy, given.seeds).summary
        print(f"{name:9} reward {found['reward_mean']:.3f}, solved {found['solved']} of {given.seeds}")


if __name__ == "__main__":
    main()
