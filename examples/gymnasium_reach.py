"""Gymnasium: the closed-form baseline reaches points; chance does not. Needs the extra `gym`."""

import gymnasium

import contarm_sim.envs.gym  # noqa: F401 (registers contarm/Reach-v0 and the others)
from contarm_sim.envs.baseline import baseline, random_policy

env = gymnasium.make("contarm/Reach-v0")  # or arm="two", arm="my_arm.toml", arm=Arm(...)
definition = env.unwrapped.definition
for name, policy in (("baseline", baseline(definition)), ("random", random_policy(definition))):
    solved = 0
    for seed in range(5):
        observation, info = env.reset(seed=seed)
        ended = False
        while not ended:
            observation, _, _, ended, info = env.step(policy(observation[None])[0])
        solved += info["success"]
    print(f"{name:8} solved {solved} of 5, last error {1e3 * info['error']:.1f} mm")
