"""A quick look at a trajectory."""

from __future__ import annotations

from typing import TYPE_CHECKING

from contarm_sim.mechanics.muscles import each
from contarm_sim.model.colours import muscle_hex

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from contarm_sim.results.trajectory import Trajectory


def plot(trajectory: Trajectory) -> Figure:
    """Return a matplotlib figure: tip error, muscle length changes and tensions, over time or over poses."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(6.7, 5.2), layout="constrained")
    top, middle, bottom = figure.subplots(3, 1, sharex=True)
    over = trajectory.time if trajectory.moving else range(1, len(trajectory) + 1)
    top.plot(over, 1e3 * trajectory.tip_error, color="black")
    top.set_ylabel("tip error [mm]")
    top.set_title(f"controller {trajectory.controller}, {trajectory.status}", fontsize="medium")
    straight = each(trajectory.arm, lambda group: group.length)
    for i in range(trajectory.muscle_lengths.shape[1]):
        colour = muscle_hex(i)
        change = 1e3 * (trajectory.muscle_lengths[:, i] - straight[i])
        middle.plot(over, change, color=colour, label=f"muscle {i + 1}")
        bottom.plot(over, trajectory.muscle_tensions[:, i], color=colour)
    middle.set_ylabel("length change [mm]")
    middle.legend(loc="upper right", fontsize="small")
    bottom.set_ylabel("tension [N]")
    bottom.set_xlabel("time [s]" if trajectory.moving else "pose")
    for axes in (top, middle, bottom):
        axes.grid(alpha=0.3)
    return figure
