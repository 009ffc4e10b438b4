"""The generated MJCF of the arm. Never imports the kinematics: the comparison is between two derivations."""

from contarm_sim import libmujoco

libmujoco.load()

from contarm_sim.mjcf.build import TIMESTEP, arm_spec, scene_spec, spec  # noqa: E402
from contarm_sim.mjcf.muscles import ACTUATIONS, Actuation, straight_controls  # noqa: E402
from contarm_sim.mjcf.xml import exact_xml, write_models  # noqa: E402

__all__ = [
    "ACTUATIONS", "TIMESTEP", "Actuation", "arm_spec", "exact_xml", "scene_spec", "spec", "straight_controls",
    "write_models",
]  # fmt: skip
