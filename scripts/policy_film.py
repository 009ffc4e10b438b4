"""A film of a policy beside the baseline: the same episodes, left and right."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from contarm_sim.envs.baseline import Policy
from contarm_sim.envs.definition import Definition
from contarm_sim.envs.gym import ArmEnv
from contarm_sim.envs.task import CONTROL_PERIOD
from contarm_sim.files import appearing
from contarm_sim.view.rendering.caption import Caption
from contarm_sim.view.rendering.encode import encoder, encoding

SIDE = 480
"""Width and height of each picture [pixels]."""


def write_film(path: Path, definition: Definition, policies: dict[str, Policy], seeds: int) -> None:
    """Write a film (.mp4) of the episodes of the seeds 0 .. seeds - 1 under each policy, side by side.

    Raises:
        RenderingError: nothing can be drawn here, or there is no encoder.
    """
    shape = (SIDE, SIDE * len(policies))
    widest = [[name, f"episode {seeds}", "error 9999.9 mm"] for name in policies]
    caption = Caption(shape[1], shape[0], widest, {})
    with appearing(path) as scratch, encoding(encoder(), scratch, shape, round(1 / CONTROL_PERIOD)) as add:
        for seed in range(seeds):
            films = [_episode(definition, policy, seed) for policy in policies.values()]
            for frames in zip(*films, strict=True):
                whole = np.concatenate([picture for picture, _ in frames], axis=1)
                errors = [f"error {1e3 * error:.1f} mm" for _, error in frames]
                told = zip(policies, errors, strict=True)
                caption.write(whole, [[name, f"episode {seed + 1}", error] for name, error in told])
                add(whole)


def _episode(definition: Definition, policy: Policy, seed: int) -> Iterator[tuple[Any, float]]:
    """Yield a picture of every moment, and the error [m]."""
    env = ArmEnv(
        definition.task.name, definition.arm, definition.actions.mode, definition.reward, definition.variations,
        definition.ticks * CONTROL_PERIOD, "rgb_array", width=SIDE, height=SIDE,
    )  # fmt: skip
    try:
        observation, info = env.reset(seed=seed)
        ended = False
        while True:
            yield env.render(), info["error"]
            if ended:
                return
            observation, _, _, ended, info = env.step(policy(observation[None])[0])
    finally:
        env.close()
