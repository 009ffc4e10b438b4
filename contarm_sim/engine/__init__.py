"""The compiled arm in MuJoCo: model, state, and what is read from it."""

from contarm_sim import libmujoco

libmujoco.load()
