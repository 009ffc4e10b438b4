"""Inverse kinematics of several sections: closed form as far as it goes, least squares on the Jacobian beyond.

`solve` chooses one solution of each target, `solve_all` returns all of one target, `track` follows a path of targets.
`two` and `three` are the closed forms of so many sections, `general` the least squares for any number.
"""

from contarm_sim.kinematics.inverse.result import Inverse
from contarm_sim.kinematics.inverse.rotations import rotation_from_quaternion
from contarm_sim.kinematics.inverse.targets import solve, solve_all
from contarm_sim.kinematics.inverse.three.solutions import all_poses
from contarm_sim.kinematics.inverse.tracking.following import Track, track
from contarm_sim.kinematics.inverse.two.solutions import Family, family

__all__ = [
    "Family", "Inverse", "Track", "all_poses", "family", "rotation_from_quaternion", "solve", "solve_all", "track",
]  # fmt: skip
