"""Pictures and videos of the arm. Nothing is imported here: mujoco is loaded by what draws, not by its name.

`gl` finds a GL library, `draw` makes pictures, `video` makes films of a simulation.
"""

BROADEST = 16_384
"""Longest side of a picture [pixels]: OpenGL draws no longer ones."""
