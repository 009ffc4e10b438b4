"""The names of the tasks in Gymnasium's registry.

Gymnasium 1.x reads no entry points any more: `import contarm_sim.envs.gym` registers, and so does the name that imports
it, `gymnasium.make("contarm_sim.envs.gym:contarm/Reach-v0")`. The entry point `gymnasium.envs` names `register` for
whatever still reads it.
"""

from __future__ import annotations

NAMES = {
    "reach": "contarm/Reach-v0",
    "track": "contarm/Track-v0",
    "hold": "contarm/Hold-v0",
    "grasp": "contarm/Grasp-v0",
}
"""Gymnasium's names of the tasks."""


def register() -> None:
    """Register every task, alone and as a native vector; once."""
    import gymnasium

    for task, name in NAMES.items():
        if name not in gymnasium.registry:
            gymnasium.register(
                id=name,
                entry_point="contarm_sim.envs.gym:ArmEnv",
                vector_entry_point="contarm_sim.envs.vector:ArmVectorEnv",
                kwargs={"task": task},
                order_enforce=False,  # the environments say so themselves
            )
