"""The simulated arm: plant, controllers, rest and motion."""

from contarm_sim import engine

engine.load()
