"""Planning that avoids: poses, and courses along targets, whose whole backbone is clear of the objects of the world.

`avoid` is inverse kinematics that keeps clear, `avoid_along` the same of a row of targets, `reference` of a path.
`Clearance` is how far an arm is from the objects of its world.
"""

from contarm_sim.planning.along import Course, avoid_along, reference
from contarm_sim.planning.avoid import Avoiding, avoid, default_margin, solutions
from contarm_sim.planning.clearance import Clearance, Nearest

__all__ = [
    "Avoiding",
    "Clearance",
    "Course",
    "Nearest",
    "avoid",
    "avoid_along",
    "default_margin",
    "reference",
    "solutions",
]
