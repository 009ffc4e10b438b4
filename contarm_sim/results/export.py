"""Trajectories for pandas and xarray, where these are installed."""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

import numpy as np

from contarm_sim.errors import MissingError
from contarm_sim.mechanics.shape import stations
from contarm_sim.results.touched import link_forces, object_depths, object_forces

if TYPE_CHECKING:
    from contarm_sim.results.trajectory import Trajectory

_SETPOINT_UNITS = {"lengths": "m", "pressures": "Pa", "tensions": "N"}


def units(trajectory: Trajectory) -> dict[str, str]:
    """Return the unit of each array by its name."""
    return {
        "target": "m", "bend": "rad", "bends": "rad",
        "setpoint": _SETPOINT_UNITS[trajectory.actuation], "muscle_lengths": "m",
        "muscle_tensions": "N", "pressure": "Pa", "stations": "m", "tip_rotation": "1", "qpos": "rad",
    }  # fmt: skip


def _library(name: str) -> Any:
    try:
        return import_module(name)
    except ImportError:
        raise MissingError(name, "tables") from None


def dataframe(trajectory: Trajectory) -> Any:
    """Return a pandas DataFrame with one row a sample: tip, target, bend, and per muscle what drove and what it did."""
    pandas, unit = _library("pandas"), units(trajectory)
    columns: dict[str, Any] = {"time [s]": trajectory.time}
    for name, array in (("target", trajectory.target), ("tip", trajectory.tip)):
        columns |= {f"{name}_{axis} [m]": array[:, i] for i, axis in enumerate("xyz")}
    bends = trajectory.bends
    for number in range(bends.shape[1]):
        of_section = f"{number + 1}_" if bends.shape[1] > 1 else ""
        columns |= {f"bend_{of_section}{axis} [rad]": bends[:, number, i] for i, axis in enumerate("xy")}
    columns["tip_error [m]"] = trajectory.tip_error
    for name in ("setpoint", "muscle_lengths", "muscle_tensions", "pressure"):
        array = getattr(trajectory, name)
        columns |= {f"{name}_{i + 1} [{unit[name]}]": array[:, i] for i in range(array.shape[1])}
    columns |= _touch_columns(trajectory)
    frame = pandas.DataFrame({name: np.array(values) for name, values in columns.items()})
    frame.attrs = {"controller": trajectory.controller, "status": trajectory.status, "length_m": trajectory.arm.length}
    return frame


def _touch_columns(trajectory: Trajectory) -> dict[str, Any]:
    """Return columns of what is touched and of where free objects are; none where there are none."""
    columns: dict[str, Any] = {}
    found, count = trajectory.contacts, len(trajectory)
    if found is not None:
        columns["contact_force [N]"] = found.total(count)
        columns["contacts"] = np.bincount(found.sample, minlength=count)
        columns["contact_depth [m]"] = found.deepest(count)
    for number, name in enumerate(trajectory.arm.world.movable if trajectory.objects is not None else []):
        pose = trajectory.objects[:, number]  # type: ignore[index]
        columns |= {f"{name}_{axis} [m]": pose[:, i] for i, axis in enumerate("xyz")}
        columns |= {f"{name}_q{part}": pose[:, 3 + i] for i, part in enumerate("wxyz")}
    return columns


_DIMENSIONS = {
    "target": ("axis",), "bend": ("bending_axis",), "setpoint": ("muscle",), "muscle_lengths": ("muscle",),
    "muscle_tensions": ("muscle",), "pressure": ("muscle",), "stations": ("station", "axis"),
    "tip_rotation": ("row", "column"), "qpos": ("joint",),
}  # fmt: skip


def dataset(trajectory: Trajectory) -> Any:
    """Return an xarray Dataset over time (the sample's number for poses at rest), with units as attributes."""
    xarray, unit = _library("xarray"), units(trajectory)
    over = "time" if trajectory.moving else "pose"
    coordinates = {
        over: trajectory.time if trajectory.moving else np.arange(len(trajectory)),
        "axis": list("xyz"), "bending_axis": list("xy"),
        "station": stations(trajectory.arm),
        "muscle": np.arange(1, trajectory.setpoint.shape[1] + 1),
    }  # fmt: skip
    dimensions: dict[str, tuple[str, ...]] = dict(_DIMENSIONS)
    if len(trajectory.arm.sections) > 1:
        del dimensions["bend"]
        coordinates["section"] = np.arange(1, len(trajectory.arm.sections) + 1)
        dimensions["bends"] = ("section", "bending_axis")
    variables = {
        name: ((over, *own), np.array(getattr(trajectory, name)), {"units": unit[name]})
        for name, own in dimensions.items()
    }
    more, names = _touch_variables(trajectory, over)
    about = {"controller": trajectory.controller, "status": trajectory.status, "length_m": trajectory.arm.length}
    coordinates |= names
    variables |= more
    return xarray.Dataset(variables, coordinates, about)


def _touch_variables(trajectory: Trajectory, over: str) -> tuple[dict[str, Any], dict[str, Any]]:
    """Return variables of what is touched and of where free objects are, and their coordinates."""
    found, count = trajectory.contacts, len(trajectory)
    variables: dict[str, Any] = {}
    names: dict[str, Any] = {}
    if found is not None:
        names["touched"] = list(found.names)
        links = link_forces(found, count, trajectory.arm.links + 1)
        variables["contact_force"] = ((over, "touched", "axis"), object_forces(found, count), {"units": "N"})
        variables["contact_depth"] = ((over, "touched"), object_depths(found, count), {"units": "m"})
        variables["link_contact_force"] = ((over, "station"), links, {"units": "N"})
    if trajectory.objects is not None:
        names |= {"object": trajectory.arm.world.movable, "part": list("wxyz")}
        place, turn = np.split(np.array(trajectory.objects), [3], axis=2)
        variables["object_position"] = ((over, "object", "axis"), place, {"units": "m"})
        variables["object_orientation"] = ((over, "object", "part"), turn, {"units": "1"})
    return variables, names
