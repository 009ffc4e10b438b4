"""Pictures of the arm: what a sample of a simulation looks like, beside what it was meant to look like."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, get_args

import numpy as np
from numpy.typing import NDArray

from contarm_sim.errors import InputError
from contarm_sim.kinematics.arrays import Array
from contarm_sim.mechanics import shape
from contarm_sim.model.arm import Arm
from contarm_sim.view.rendering.cameras import check_camera, eye
from contarm_sim.view.rendering.context import open_renderer
from contarm_sim.view.rendering.gl import choose_backend
from contarm_sim.view.rendering.muscles import Muscles
from contarm_sim.view.rendering.overlays import (
    MAX_SEGMENTS,
    Colour,
    add_ball,
    add_line,
    add_ring,
    add_triad,
    add_tube,
    placed,
    thin,
)
from contarm_sim.view.sections import section_colour, section_places, tube_radii

if TYPE_CHECKING:
    from contarm_sim.results.trajectory import Trajectory

Pixels = NDArray[np.uint8]
Quality = Literal["draft", "final"]
QUALITIES: tuple[Quality, ...] = get_args(Quality)

PATH: Colour = (0.30, 0.33, 0.40, 1.0)
TRACE: Colour = (0.00, 0.78, 0.45, 1.0)
TARGET: Colour = (0.46, 0.16, 0.80, 1.0)
GHOST: Colour = (0.46, 0.16, 0.80, 0.40)
RING: Colour = (0.46, 0.16, 0.80, 0.85)

_NARROWEST = 1.4
_GHOST_SEGMENTS, _LEAST_SEGMENTS = 24, 12
"""Pieces that the ghost of an arm is made of, and of each section at least."""


@dataclass(frozen=True)
class Overlays:
    """What to draw besides the simulated arm.

    Attributes:
        path: the planned path of the tip.
        trace: where the simulated tip has been so far, coloured by its distance from the analytic one.
        target: the target of this moment.
        ghost: the analytic arcs at the commanded bend, a ring where one section ends and the next begins.
        frames: axes at base and simulated tip, x red, y green, z blue.
    """

    path: bool = True
    trace: bool = True
    target: bool = True
    ghost: bool = True
    frames: bool = True


ALL = Overlays()


class ArmRenderer:
    """Draws one arm. A context manager: it holds GL memory until it is left.

    Args:
        arm: its parameters.
        width, height: size of the picture [pixels].
        camera: front, side, top, orbit (one turn a film) or tip (follows it).
        quality: `draft` for speed, `final` for smooth edges and sharp shadows.

    Raises:
        InputError: an unknown camera or quality, or a size that is no positive whole number.
        RenderingError: no GL library draws here, or none so large a picture.
    """

    def __init__(
        self, arm: Arm, width: int = 1280, height: int = 720, camera: str = "front", quality: Quality = "draft"
    ) -> None:
        check_size(width, height)
        if quality not in QUALITIES:
            raise InputError("quality", repr(quality), ", ".join(QUALITIES))
        choose_backend()
        import mujoco

        from contarm_sim.engine.index import ArmIndex
        from contarm_sim.mjcf import scene_spec

        self.arm = arm
        self._model = _told_apart(scene_spec(arm), arm).compile()
        self._camera = check_camera(camera)
        _set_quality(self._model, quality)
        _fit(self._model, width, height)
        self._muscles, self._index = Muscles(self._model, arm), ArmIndex.of(self._model, arm)
        self._data = mujoco.MjData(self._model)
        self._renderer = open_renderer(self._model, width, height)

    def __enter__(self) -> ArmRenderer:
        return self

    def __exit__(self, *_: object) -> None:
        self._renderer.close()

    def frame(self, samples: Trajectory, index: int, overlays: Overlays = ALL, largest: float | None = None) -> Pixels:
        """Draw sample `index`, muscles coloured by tension; return the picture, shape (height, width, 3).

        Args:
            largest: tip error [m] that the trace shows as the worst; default the largest of the samples.
        """
        self._pose(samples.qpos[index])
        self._muscles.show(samples.muscle_tensions[index] / max(samples.muscle_tensions.max(), 1e-9))
        self._look(index / max(len(samples) - 1, 1))
        scene, pixel = self._renderer.scene, self._renderer.height / 720
        if overlays.path:
            add_line(scene, thin(self.to_world(samples.target)), 1.6 * pixel, PATH)
        if overlays.trace:
            stride = -(-len(samples) // MAX_SEGMENTS)  # the same for all of a film, so that the line does not crawl
            tips = np.vstack([samples.stations[:index:stride, -1], samples.stations[index, -1]])
            error = samples.tip_error
            tints = trace_colours(error[:index:stride], float(error.max()) if largest is None else largest)
            add_line(scene, self.to_world(tips), 3.2 * pixel, TRACE, tints)
        if overlays.target:
            add_ball(scene, self.to_world(samples.target[index]), 0.02 * self.arm.length, TARGET)
        if overlays.ghost:
            self._add_ghost(samples.bend[index])
        if overlays.frames:
            self._add_frames(1.6 * pixel)
        return self._renderer.render()

    def pose(self, qpos: Array, target: Array | None = None, share: float = 0.0) -> Pixels:
        """Draw the arm with joint angles [rad], shape (dofs,), and a ball at a target [m], if there is one.

        Args:
            share: of its turn that the camera `orbit` has made.
        """
        self._pose(qpos)
        self._muscles.show(np.ones(self._index.zero.size))
        self._look(share)
        if target is not None:
            add_ball(self._renderer.scene, self.to_world(target), 0.02 * self.arm.length, TARGET)
        return self._renderer.render()

    def bent(self, bend: Array) -> Array:
        """Return the joint angles [rad], shape (dofs,), of the arm with every joint of a section bent alike.

        Args:
            bend: of the sections [rad], shape (2 S,).
        """
        qpos, bends = np.zeros(self._model.nq), shape.bends_of(bend, self.arm)
        for axis, sign, part in (("x", -1.0, 1), ("y", 1.0, 0)):
            hinges = self._index.bending[axis]
            number = self._index.section_of_joint[hinges]
            links = np.array([section.links for section in self.arm.sections])
            qpos[hinges] = sign * (bends[:, part] / links)[number]
        return qpos

    def to_world(self, points: Array) -> Array:
        """Turn points of the base frame [m], shape (..., 3), into points of the world that is drawn."""
        return placed(self._data.body("base"), points)

    def _pixels(self, width: float) -> float:
        """Return the width of a line [pixels] that is so wide in a picture of 720 rows."""
        return width * self._renderer.height / 720

    @property
    def _base_rotation(self) -> Array:
        return self._data.body("base").xmat.reshape(3, 3)

    def _pose(self, qpos: Array) -> None:
        """Place every body, camera, light and muscle; no step is simulated."""
        import mujoco

        self._data.qpos[:] = qpos
        for update in (mujoco.mj_kinematics, mujoco.mj_comPos, mujoco.mj_camlight, mujoco.mj_tendon):
            update(self._model, self._data)

    def _look(self, share: float) -> None:
        """Gather what the camera sees, `share` of the film having passed."""
        tip = self._data.body("tip").xpos
        self._renderer.update_scene(self._data, eye(self._model, self._camera, tip, share, self.arm.length))

    def _add_frames(self, width: float) -> None:
        """Draw the axes of base and tip."""
        for name in ("base", "tip"):
            body = self._data.body(name)
            add_triad(self._renderer.scene, body.xpos, body.xmat.reshape(3, 3), 0.14 * self.arm.length, width)

    def _add_ghost(self, bend: Array) -> None:
        """Draw the analytic arcs as a glass tube about the arm."""
        arm, pieces = self.arm, max(_GHOST_SEGMENTS // len(self.arm.sections), _LEAST_SEGMENTS)
        for number, (xi, inside) in enumerate(zip(section_places(arm, pieces), tube_radii(arm), strict=True)):
            points = self.to_world(shape.position(bend, arm, xi))
            frames = self._base_rotation @ shape.rotation(bend, arm, xi)
            add_tube(self._renderer.scene, points, frames, 1.25 * inside, GHOST)
            if number < len(arm.sections) - 1:
                add_ring(self._renderer.scene, points[-1], frames[-1], 1.25 * inside, self._pixels(2.0), RING)


def trace_colours(error: Array, largest: float) -> Array:
    """Return colours, shape (K, 3), of errors, shape (K,): green for none, over amber to red for the largest."""
    share = np.clip(error / max(largest, 1e-12), 0, 1)[:, None]
    good, middling, bad = (np.array(c) for c in (TRACE[:3], (0.95, 0.66, 0.10), (0.86, 0.12, 0.12)))
    return np.where(share < 0.5, good + 2 * share * (middling - good), middling + (2 * share - 1) * (bad - middling))


def still(arm: Arm, bend: Array, path: Path, width: int = 1280, height: int = 720, camera: str = "front") -> None:
    """Write a picture (.png) of the arm, every joint of a section bent alike; `bend` [rad], shape (2 S,)."""
    from PIL import Image

    with ArmRenderer(arm, width, height, camera, "final") as renderer:
        Image.fromarray(renderer.pose(renderer.bent(bend))).save(path, optimize=True)


def check_size(width: int, height: int) -> None:
    """Refuse sizes that are no positive whole numbers.

    Raises:
        InputError: names the side.
    """
    for name, value in (("width", width), ("height", height)):
        if isinstance(value, bool) or not isinstance(value, int) or value < 1:
            raise InputError(name, value, "a positive whole number [pixels]")


def _told_apart(spec: Any, arm: Arm) -> Any:
    """Give the disks of each section but the first a colour of their own; return the spec."""
    from contarm_sim.mjcf import names

    stations, starts = names.stations(arm), names.section_stations(arm)
    for number in range(1, len(arm.sections)):
        look = f"{names.of_section(arm, number)}disk"
        spec.add_material(name=look, rgba=[*section_colour(number), 1.0], specular=0.3, shininess=0.4)
        for station in stations[starts[number] + 1 : starts[number + 1] + 1]:
            for part in ("disk", "guide"):
                geom = spec.geom(f"{station}_{part}")
                if geom is not None:
                    geom.material = look
    return spec


def _set_quality(model: Any, quality: Quality) -> None:
    """Set samples a pixel, shadow size and roundness: together they decide the time of a frame in software GL."""
    sight = model.vis.quality
    if quality == "draft":
        sight.offsamples, sight.shadowsize, sight.numslices, sight.numstacks = 0, 1024, 16, 6
    else:
        sight.offsamples, sight.shadowsize, sight.numslices, sight.numstacks = 4, 4096, 32, 14


def _fit(model: Any, width: int, height: int) -> None:
    """Make room for the picture, and show as much to the left and right in a narrow one as in a wide one."""
    model.vis.global_.offwidth, model.vis.global_.offheight = width, height
    narrow = max(1.0, _NARROWEST * height / width)
    model.cam_fovy[:] = np.degrees(2 * np.arctan(narrow * np.tan(np.radians(0.5 * model.cam_fovy))))
    model.vis.global_.fovy = model.cam_fovy[0]
