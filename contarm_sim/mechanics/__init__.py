"""Closed-form mechanics of the arm, NumPy only."""
