"""Inverse kinematics of several sections: closed form as far as it goes, least squares on the Jacobian beyond."""

from contarm_sim.kinematics.inverse.goals import rotation_from_quaternion
from contarm_sim.kinematics.inverse.result import Inverse
from contarm_sim.kinematics.inverse.targets import solve, solve_all
from contarm_sim.kinematics.inverse.tracking import Track, track

__all__ = ["Inverse", "Track", "rotation_from_quaternion", "solve", "solve_all", "track"]
