"""A film inside a notebook."""

from __future__ import annotations

from contarm_sim.errors import InputError
from contarm_sim.results.trajectory import Trajectory
from contarm_sim.view.rendering.encode import encoder
from contarm_sim.view.rendering.film import Look, Progress
from contarm_sim.view.rendering.video import Shot

_LONGEST = 2000
"""Frames that are kept in memory at most: 1.4 GB of 640 x 360 pixels."""


def show(
    trajectory: Trajectory, look: Look | None = None, fps: float = 20, speed: float = 1.0,
    on_frame: Progress | None = None,
) -> None:  # fmt: skip
    """Show a trajectory as a film in the notebook that runs this, in a player with controls.

    Args:
        look: size [pixels], camera; default 640 x 360, seen from the front.
        fps: frames per second.
        speed: simulated over shown time.
        on_frame: called with the number of frames drawn and their total, for progress.

    Raises:
        InputError: a value that cannot be used, or a film too long to be kept in memory.
        RenderingError: no GL library draws here, or there is no encoder.
    """
    import mediapy

    shot = Shot(trajectory, look or Look(width=640, height=360), fps, speed).checked()
    if shot.count > _LONGEST:
        raise InputError("speed", speed, f"a speed or fps that makes at most {_LONGEST} frames, not {shot.count}")
    mediapy.set_ffmpeg(encoder())
    mediapy.show_video(list(shot.frames(on_frame)), fps=fps, codec="h264", title=trajectory.controller)
