"""The files of a demonstration, which lie beside this one: its arm as TOML, its path as CSV."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from contarm_sim.inputs import read_text
from contarm_sim.kinematics.arrays import Array
from contarm_sim.model.arm import Arm
from contarm_sim.model.arm_file import load_arm
from contarm_sim.paths.table import read_table

HERE = Path(__file__).parent


def arm_of(name: str) -> Arm:
    """Return the arm of a demonstration, with all that it can touch."""
    return load_arm(HERE / f"{name}.toml")


def knots_of(name: str) -> tuple[Array, Array]:
    """Return the path of a demonstration: times [s], shape (K,), and bends of its sections [rad], shape (K, S).

    All bends lie in one plane, that of X and Z: positive ones towards +X.
    """
    file = HERE / f"{name}.csv"
    units = {"t": "s", "bend_1": "rad", "bend_2": "rad"}
    columns = read_table(read_text(file, "a path"), units, {}, tuple(units), file.name).columns
    return columns["t"], np.stack([columns["bend_1"], columns["bend_2"]], axis=1)


def smooth(times: Array, values: Array, t: Array) -> Array:
    """Return what runs smoothly through values at times, at other times, without overshoot; the ends stay."""
    from scipy.interpolate import PchipInterpolator

    return np.asarray(PchipInterpolator(times, values)(np.clip(t, times[0], times[-1])), dtype=float)
