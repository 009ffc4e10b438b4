"""The simulated arm: plant, controllers, rest and motion."""
