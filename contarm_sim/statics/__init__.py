"""Poses at rest: loads, stiffness, solvers."""

from contarm_sim import libmujoco

libmujoco.load()
