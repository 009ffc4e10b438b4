"""Richardson's extrapolation of a motion: chains of N and N/2 links say where one of infinitely many would be.

The chain's error is of second order in 1/N, so x_N + (x_N - x_n)/((N/n)^2 - 1) is of fourth order where both chains are
fine enough for the motion: the least are some eight and four links.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from contarm_sim.kinematics.arrays import Array
from contarm_sim.kinematics.chain import richardson
from contarm_sim.mechanics.shape import halved, stations
from contarm_sim.model.arm import Arm
from contarm_sim.results.trajectory import Trajectory

LEAST_LINKS = 8
"""Fewest links of the finer chain."""


def coarser(arm: Arm) -> Arm:
    """Return the arm of the coarser chain, of half the links.

    Raises:
        InputError: too few links to extrapolate from; of several sections, an odd number too.
    """
    return halved(arm, fewest=LEAST_LINKS)


def extrapolated(fine: Trajectory, coarse: Trajectory) -> Trajectory:
    """Return the motion of a chain improved by those of a coarser one at the same times.

    Stations, tip orientations, muscle lengths, tensions and pressures are; controls and joint angles stay those of the
    finer chain. Between stations of the coarser chain the difference is interpolated by cubic splines.
    """
    from scipy.interpolate import CubicSpline
    from scipy.spatial.transform import Rotation

    count = min(len(fine), len(coarse))
    fine, coarse = fine.first(count), coarse.first(count)
    links, fewer = fine.stations.shape[1] - 1, coarse.stations.shape[1] - 1
    gain = richardson(links, fewer)
    places, sparser = stations(fine.arm), stations(coarse.arm)
    shape = CubicSpline(places, fine.stations, axis=1)(sparser)
    difference = CubicSpline(sparser, shape - coarse.stations, axis=1)
    here, there = Rotation.from_matrix(fine.tip_rotation), Rotation.from_matrix(coarse.tip_rotation)

    def better(one: Array, other: Array) -> Array:
        with np.errstate(invalid="ignore"):  # pressures that no muscle has
            return np.where(np.isfinite(one) & np.isfinite(other), one + gain * (one - other), one)

    return replace(
        fine,
        extrapolated=True,
        stations=fine.stations + gain * difference(places),
        tip_rotation=(here * Rotation.from_rotvec(gain * (there.inv() * here).as_rotvec())).as_matrix(),
        muscle_lengths=better(fine.muscle_lengths, coarse.muscle_lengths),
        muscle_tensions=better(fine.muscle_tensions, coarse.muscle_tensions),
        pressure=better(fine.pressure, coarse.pressure),
    )
