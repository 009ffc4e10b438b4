"""The simulated arm in motion: along a path, and let go."""

from contarm_sim import libmujoco

libmujoco.load()
