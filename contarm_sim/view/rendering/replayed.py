"""A replay as a film: the simulated arm, the real markers where they were measured, and the error between them."""

from __future__ import annotations

from collections.abc import Callable, Generator
from contextlib import closing
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from contarm_sim.identify.replays.replay import Replay
from contarm_sim.kinematics.arrays import Array
from contarm_sim.mjcf.names import joint_axes
from contarm_sim.model.arm import Arm
from contarm_sim.view.colours import ERROR, MEASURED, SIMULATED, rgb
from contarm_sim.view.rendering.caption import Caption, Legend
from contarm_sim.view.rendering.draw import ArmRenderer, Pixels
from contarm_sim.view.rendering.film import Progress
from contarm_sim.view.rendering.formats import FPS, check_size
from contarm_sim.view.rendering.insets import card_size
from contarm_sim.view.rendering.look import Look
from contarm_sim.view.rendering.overlays import Colour, add_ball, add_line
from contarm_sim.view.rendering.panel import Curve, Panel, Plot, fits
from contarm_sim.view.report.outliers import enlarged, outliers
from contarm_sim.view.report.replays.course import course_of
from contarm_sim.view.report.replays.words import named, status_words
from contarm_sim.view.sections import tube_radii

MOST_POSES, POSES_FPS = 300, 10.0
"""Most samples of a static recording that a film shows, evenly picked, and how many a second."""

MOST_FRAMES = 1200
"""Most frames of a film of a motion; a longer one is shown faster, twice, four times, ..."""

_REAL: Colour = (*rgb(MEASURED), 1.0)
_OWN: Colour = (*rgb(SIMULATED), 1.0)
_OFF: Colour = (*rgb(ERROR), 1.0)

_BALL, _SMALL = 0.017, 0.010
"""Radius of a measured marker, and of where the arm has it [of the arm's length]."""

_CLOSER = 2.5
"""How far before the arm, in its radii, markers are drawn, on the line to the eye: over it, at the same pixels."""

_STILL = 60
"""Samples that the camera is placed by."""


def joint_angles(arm: Arm, frames: Array) -> Array:
    """Return the joint angles [rad], shape (T, dofs), of an arm whose stations have frames, shape (T, N + 1, 4, 4)."""
    from scipy.spatial.transform import Rotation

    turns = frames[:, :-1, :3, :3].swapaxes(-1, -2) @ frames[:, 1:, :3, :3]
    out, station = [], 0
    for number, section in enumerate(arm.sections):
        for index in range(section.links):
            axes = joint_axes(arm, number, index)
            order = axes if len(axes) == 3 else f"{axes}z"  # intrinsic turns, in capitals
            out.append(Rotation.from_matrix(turns[:, station]).as_euler(order.upper())[:, : len(axes)])
            station += 1
    return np.concatenate(out, axis=1)


@dataclass(frozen=True)
class ReplayShot:
    """What a film of a replay shows, see `video.Filmed`.

    Attributes:
        replay: the recording and its prediction.
        look: size [pixels], camera, plots, captions, note.
        some_samples: number of frames at most; default as many as the recording is worth.
    """

    replay: Replay
    look: Look
    some_samples: int | None = None

    @property
    def fps(self) -> float:
        """Frames per second."""
        if self.replay.recording.kind == "motion":
            return FPS
        return POSES_FPS if len(self.rows) > 4 * POSES_FPS else 2.0

    @property
    def speed(self) -> int:
        """Recorded over shown time, a power of two; 1 of static recordings."""
        if self.replay.recording.kind != "motion":
            return 1
        span, speed = float(np.ptp(course_of(self.replay).places)), 1
        while span * FPS / speed > MOST_FRAMES:
            speed *= 2
        return speed

    @property
    def rows(self) -> NDArray[np.intp]:
        """Samples that frames show, all of which the arm has a pose in."""
        known = np.flatnonzero(np.isfinite(self.replay.frames).all(axis=(1, 2, 3)))
        if not len(known):
            return known
        if self.replay.recording.kind == "motion":
            places = course_of(self.replay).places
            frames = np.arange(places[0], places[-1] + 1e-9, self.speed / FPS)
            own = known[np.minimum(np.searchsorted(places[known], frames), len(known) - 1)]
        else:
            own = _thinned(known, MOST_POSES)
        return own if self.some_samples is None else _thinned(own, self.some_samples)

    @property
    def count(self) -> int:
        """Number of frames."""
        return len(self.rows)

    def checked(self) -> ReplayShot:
        """Return itself.

        Raises:
            InputError: a size that cannot be used.
        """
        check_size(self.look.width, self.look.height)
        return self

    def frames(self, on_frame: Progress | None = None, some: int | None = None) -> Generator[Pixels, None, None]:
        """Draw all frames one after the other, or `some` of them, evenly picked."""
        rows = self.rows if some is None else _thinned(self.rows, some)
        with closing(_framed(self.replay, rows, self.look, self.speed)) as pictures:
            for done, picture in enumerate(pictures, 1):
                yield picture
                if on_frame is not None:
                    on_frame(done, len(rows))


def _thinned(rows: NDArray[np.intp], most: int) -> NDArray[np.intp]:
    if len(rows) <= most:
        return rows
    return rows[np.linspace(0, len(rows) - 1, most).round().astype(int)]


def _framed(replay: Replay, rows: NDArray[np.intp], look: Look, speed: int) -> Generator[Pixels, None, None]:
    """Draw samples with a caption along the top and the error's plot in a lower corner."""
    from contarm_sim.mjcf.framing import Frame

    rig = replay.recording.rig
    arm, real, own = (
        rig.holds(replay.arm),
        _in_base(replay, replay.recording.positions),
        _in_base(replay, replay.predicted),
    )
    said = [_texts(replay, row, speed) for row in rows.tolist()]
    widest = [max(column, key=len) for column in zip(*said, strict=True)]
    around = Caption(look.width, look.height, [widest], _legend(replay), [look.note]) if look.captions else None
    card = _card(replay, look) if look.plots else None
    shares = (0.0, 0.0) if card is None else (card.width / look.width, card.height / look.height)
    frame = Frame(top=0.0 if around is None else around.height / look.height, cards=shares)
    qpos, often = joint_angles(arm, replay.frames[rows]), _enlarged(replay)
    seen = np.concatenate([replay.frames[_thinned(rows, _STILL)][..., :3, 3].reshape(-1, 3), _near(real, arm)])
    places = course_of(replay).places
    with ArmRenderer(arm, look.width, look.height, look.camera, seen, frame) as renderer:
        for k, row in enumerate(rows.tolist()):
            marks = _Marks(real[row], own[row], often[row], arm, renderer.to_world)
            image = renderer.with_marks(qpos[k], marks.add, k / max(len(rows) - 1, 1)).copy()
            if card is not None:
                card.write(image, float(places[row]), "left")
            if around is not None:
                around.write(image, [said[k]])
            yield image


def _in_base(replay: Replay, points: Array) -> Array:
    """Return points of the measurements' frame [m] in the base's."""
    rig = replay.recording.rig
    return np.asarray((points - np.array(rig.position)) @ rig.rotation)


def _near(points: Array, arm: Arm) -> Array:
    """Return the points that a camera is to show: those near the arm, outliers not."""
    flat = points.reshape(-1, 3)
    flat = flat[np.isfinite(flat).all(axis=1)]
    return np.asarray(flat[np.linalg.norm(flat, axis=1) < 1.2 * arm.length])


@dataclass(frozen=True)
class _Marks:
    """The markers of a sample in the base's frame [m], shape (K, 3) each: measured, and as the arm has them.

    Errors are drawn `often` times as long, shape (K,), from where the arm has a marker.
    """

    real: Array
    own: Array
    often: Array
    arm: Arm
    to_world: Callable[[Array], Array]

    def add(self, scene: Any, pixels: Callable[[float], float]) -> None:
        """Draw them, and a line of error between the two of each."""
        eye = np.mean([camera.pos for camera in scene.camera], axis=0)
        closer = _CLOSER * max(tube_radii(self.arm))
        tips = self.own + self.often[:, None] * (self.real - self.own)
        for real, own, tip in zip(*map(self.to_world, (self.real, self.own, tips)), strict=True):
            if not np.isfinite(own).all():
                continue
            if np.isfinite(real).all():
                add_ball(scene, _towards(real, eye, closer), _BALL * self.arm.length, _REAL)
                ends = np.stack([_towards(tip, eye, 1.5 * closer), _towards(own, eye, 1.5 * closer)])
                add_line(scene, ends, pixels(3.0), _OFF, rank=2)
            add_ball(scene, _towards(own, eye, 2 * closer), _SMALL * self.arm.length, _OWN)


def _towards(point: Array, eye: Array, far: float) -> Array:
    """Return a point so much nearer to the eye [m], on the line to it."""
    line = eye - point
    return np.asarray(point + far * line / np.linalg.norm(line))


def _enlarged(replay: Replay) -> NDArray[np.intp]:
    """Return how often each error is drawn as long as it is, shape (T, K): outliers once."""
    far = outliers(replay.distance)
    usual = float(np.nanmax(np.where(far, np.nan, replay.distance), initial=0.0))
    return np.where(far, 1, enlarged(usual / replay.arm.length))


def _legend(replay: Replay) -> Legend:
    often = int(_enlarged(replay).max(initial=1))
    words = "error" if often == 1 else f"error × {often}"
    return {"measured marker": [rgb(MEASURED)], "simulated": [rgb(SIMULATED)], words: [rgb(ERROR)]}


def _texts(replay: Replay, row: int, speed: int) -> list[str]:
    recording, error, length = replay.recording, float(replay.shape_error[row]), replay.arm.length
    if recording.kind == "motion":
        pace = f", {speed} × speed" if speed > 1 else ""
        when = f"t = {recording.time[row]:.2f} s{pace}"
    else:
        when = f"sample {row + 1} of {len(recording)}"
    size = (
        "no marker seen" if np.isnan(error) else f"error {1e3 * error:.1f} mm = {100 * error / length:.1f} % of length"
    )
    return [
        when,
        named(str(recording.blocks[row])),
        size,
        *([status_words(replay, row)] if replay.held_out is not None else []),
    ]


def _card(replay: Replay, look: Look) -> Panel | None:
    """Return the plot of the error in the lower left corner, or None where there is no room for it."""
    course, error = course_of(replay), 1e3 * replay.shape_error
    if len(error) < 2 or not np.isfinite(error).any():
        return None
    size, letters = card_size(look.width, look.height)
    several = len(replay.recording.rig.markers) > 1
    titles = ["error [mm], rms of the markers", "error [mm]"] if several else ["error [mm]"]
    plot = Plot(titles, course.places, [Curve(error, ERROR)], float(np.nanmax(error)), course.name)
    return Panel(size, letters, plot) if fits(size, letters, plot) else None
