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
    with (
        appearing(path) as scratch,
        encoding(encoder(), scratch, shape, round(1 / CONTROL_PERIOD)) as add,
    ):
        for seed in range(seeds):
            films = [_episode(definition, policy, name, seed) for name, policy in policies.items()]
            for pictures in zip(*films, strict=True):
                add(np.concatenate(pictures, axis=1))


def _episode(definition: Definition, policy: Policy, name: str, seed: int) -> Iterator[Any]:
    env = ArmEnv(
        definition.task.name, definition.arm, definition.actions.mode, definition.reward, definition.variations,
        definition.ticks * CONTROL_PERIOD, "rgb_array", width=SIDE, height=SIDE,
    )  # fmt: skip
    try:
        caption = Caption(SIDE, SIDE, f"{name}, episode {seed + 1}, error 9999.9 mm", {})
        observation, info = env.reset(seed=seed)
        ended = False
        while True:
            picture = env.render()
            caption.write(picture, f"{name}, episode {seed + 1}, error {1e3 * info['error']:.1f} mm")
            yield picture
            if ended:
                return
            observation, _, _, ended, info = env.step(policy(observation[None])[0])
    finally:
        env.close()
