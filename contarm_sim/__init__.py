"""A single-section inextensible continuum arm: closed-form kinematics, its MuJoCo twin, and the measured difference.

The public names are few and load late, so that `import contarm_sim` costs nothing:

    Arm                   the parameters (SI units): sections, muscles and the world they stand in
    Section, Routing, McKibben, World   what an arm consists of
    load_arm              an Arm from TOML
    kinematics            closed forms: arc, dome (inverse), muscles, chain
    spec                  the arm as a mujoco.MjSpec to attach to other models
    arm_spec, scene_spec  the arm alone, and in its scene, as a mujoco.MjSpec to compile
    simulate              follow bends in MuJoCo
    poses_at_rest         rest poses of commanded bends in MuJoCo
    equilibrium           the static pose under a Load (of Wrench, Muscles)
    compare               samples beside the closed forms
"""

from __future__ import annotations

from importlib import import_module
from typing import Any

_HOMES = {
    "Arm": "model.arm",
    "McKibben": "model.mckibben",
    "Routing": "model.routing",
    "Section": "model.section",
    "World": "model.world",
    "load_arm": "model.arm_file",
    "ContarmError": "errors",
    "arm_spec": "mjcf",
    "scene_spec": "mjcf",
    "spec": "mjcf",
    "simulate": "motion.simulate",
    "poses_at_rest": "motion.rest",
    "equilibrium": "statics.equilibrium",
    "Load": "model.load",
    "Muscles": "model.load",
    "Wrench": "model.load",
    "compare": "results.compare",
}
_MODULES = ("envs", "kinematics", "mechanics", "mjcf", "paths", "studies")

__all__ = [*_HOMES, "kinematics", "paths"]


def __getattr__(name: str) -> Any:
    if name in _HOMES:
        return getattr(import_module(f"{__name__}.{_HOMES[name]}"), name)
    if name in _MODULES:
        return import_module(f"{__name__}.{name}")
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
