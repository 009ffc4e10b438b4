"""Pictures of the arm: what a sample of a simulation looks like, beside what it was meant to look like."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from contarm_sim.kinematics.arrays import Array
from contarm_sim.mechanics import shape
from contarm_sim.model.arm import Arm
from contarm_sim.view import colours
from contarm_sim.view.colours import error_colours, rgb
from contarm_sim.view.rendering.alpha import clear_away, cut_out
from contarm_sim.view.rendering.cameras import Camera, check_camera
from contarm_sim.view.rendering.cloud import Cloud
from contarm_sim.view.rendering.context import open_renderer
from contarm_sim.view.rendering.formats import check_size
from contarm_sim.view.rendering.gl import choose_backend
from contarm_sim.view.rendering.overlays import (
    MAX_SEGMENTS,
    Colour,
    add_ball,
    add_line,
    add_triad,
    placed,
    thin,
)
from contarm_sim.view.rendering.touch import LIT, add_contacts, metres_per_newton
from contarm_sim.view.rendering.tubes import hidden

if TYPE_CHECKING:
    from contarm_sim.mjcf.framing import Frame
    from contarm_sim.results.trajectory import Trajectory

Pixels = NDArray[np.uint8]

ASKED: Colour = (*rgb(colours.TARGET), 1.0)
"""The planned path of the tip, and the target of a moment."""


_NEAREST = 0.05
"""Distance before which nothing is drawn, in extents of the model: what lies on the floor needs exact depths."""

_SAMPLES, _SLICES, _STACKS = 4, 28, 12
"""Samples a pixel, and roundness of what the engine draws."""


@dataclass(frozen=True)
class Overlays:
    """What to draw besides the simulated arm.

    Attributes:
        path: the planned path of the tip.
        trace: where the simulated tip has been so far, coloured by its distance from the analytic one.
        target: the target of this moment.
        ghost: the analytic arcs at the commanded bend, a ring where one section ends and the next begins.
        frames: axes at base and simulated tip, x red, y green, z blue.
        cloud: other arms of the same moment, or None.
        contacts: links that touch something, lit, and arrows of the forces on them.
    """

    path: bool = True
    trace: bool = True
    target: bool = True
    ghost: bool = True
    frames: bool = True
    cloud: Cloud | None = None
    contacts: bool = True


ALL = Overlays()


class ArmRenderer:
    """Draws one arm. A context manager: it holds GL memory until it is left.

    Args:
        arm: its parameters.
        width, height: size of the picture [pixels].
        camera: front, side, top, orbit (one turn a film) or tip (follows it).
        seen: points of the base frame that the camera shows [m], shape (T, 3), such as `cameras.extent` of what is
            filmed; default all that the arm can touch.
        frame: what covers the picture, whose aspect does not count.
        transparent: neither floor nor sky nor shadow; pictures have red, green, blue and opacity, shape (h, w, 4).

    Raises:
        InputError: an unknown camera, or a size that is no positive whole number.
        RenderingError: no GL library draws here, or none so large a picture.
    """

    def __init__(
        self, arm: Arm, width: int = 1280, height: int = 720, camera: str = "front", seen: Array | None = None,
        frame: Frame | None = None, transparent: bool = False,
    ) -> None:  # fmt: skip
        check_size(width, height)
        check_camera(camera)
        choose_backend()
        import mujoco

        from contarm_sim.engine.index import ArmIndex
        from contarm_sim.mjcf import scene_spec
        from contarm_sim.mjcf.framing import FOVY, Frame
        from contarm_sim.mjcf.scene import CLEAR, base_position, base_rotation, part_name
        from contarm_sim.view.rendering.backbone import Backbone, tell_sections_apart
        from contarm_sim.view.rendering.floor import Floor
        from contarm_sim.view.rendering.ghost import Ghost
        from contarm_sim.view.rendering.muscles import Muscles

        self.arm = arm
        spec = scene_spec(arm.without_memory)
        tell_sections_apart(spec, arm)
        host = arm.world.host
        self._floor, self._ghost = None if host is not None else Floor(spec, arm), Ghost(spec, arm)
        self._backbone, self._muscles = Backbone(spec, arm), Muscles(spec, arm)
        world = None if seen is None else base_position(arm) + seen @ base_rotation(arm).T
        self._camera = Camera(camera, arm, world, replace(frame or Frame(), aspect=width / height))
        if self._camera.cut_away and host is None:
            for part in ("flange", "mount", "elbow", "column"):
                geom = spec.geom(part_name(spec, part))
                if geom is not None:
                    hidden(geom)
        _set_quality(spec)
        spec.visual.global_.offwidth, spec.visual.global_.offheight, spec.visual.global_.fovy = width, height, FOVY
        self._model = spec.compile()
        sight, near = self._model.vis.map, _NEAREST if host is None else _NEAREST * self._near_by(arm)
        far = self._camera.reach / (CLEAR * self._model.stat.extent)
        sight.znear, sight.zfar = near, max(sight.zfar, math.ceil(far))
        self._transparent = transparent
        self._free = np.array([(*each.position, *each.quaternion) for each in arm.world.objects if each.free])
        if transparent:
            clear_away(self._model)
        self._index, self._data = ArmIndex.of(self._model, arm), mujoco.MjData(self._model)
        if host is not None:
            mujoco.mj_resetDataKeyframe(self._model, self._data, 0)
        if self._floor is not None:
            self._floor.compiled(self._model)
        self._ghost.compiled(self._model)
        self._backbone.compiled(self._model, self._index)
        self._muscles.compiled(self._model, self._index)
        self._renderer = open_renderer(self._model, width, height)

    def __enter__(self) -> ArmRenderer:
        return self

    def __exit__(self, *_: object) -> None:
        self._renderer.close()

    def frame(
        self, samples: Trajectory, index: int, overlays: Overlays = ALL, largest: float | None = None,
        newton: float | None = None,
    ) -> Pixels:  # fmt: skip
        """Draw sample `index`, muscles coloured by tension; return the picture, shape (height, width, 3).

        Args:
            largest: tip error [m] that the trace shows as the worst; default the largest of the samples.
            newton: length of the arrow of a contact force [m/N]; default one that suits the samples.
        """
        tension = samples.muscle_tensions[index] / max(samples.muscle_tensions.max(), 1e-9)
        things = None if samples.objects is None else samples.objects[index]
        hosted = None if samples.host is None else samples.host[index]
        self._show(samples.qpos[index], tension, index / max(len(samples) - 1, 1), things, hosted)
        scene = self._renderer.scene
        if overlays.path:
            add_line(scene, thin(self.to_world(samples.target)), self._pixels(1.6), ASKED)
        if overlays.trace:
            stride = -(-len(samples) // MAX_SEGMENTS)  # the same for all of a film, so that the line does not crawl
            tips = np.vstack([samples.stations[:index:stride, -1], samples.stations[index, -1]])
            error = samples.tip_error
            tints = error_colours(error[:index:stride], float(error.max()) if largest is None else largest)
            add_line(scene, self.to_world(tips), self._pixels(3.2), ASKED, tints, rank=1)
        if overlays.target:
            add_ball(scene, self.to_world(samples.target[index]), 0.02 * self.arm.length, ASKED)
        if overlays.ghost:
            base = self._data.body("base")
            self._ghost.show(self._renderer, base, samples.bend[index], samples.stations[index], self._pixels(1.0))
        else:
            self._ghost.hide(scene)
        if overlays.cloud is not None:
            overlays.cloud.show(scene, self._data.body("base"), index, self.arm)
        if overlays.contacts and samples.contacts is not None:
            touched = samples.contacts.at(index)
            self._backbone.light(scene, self._data, touched.station, LIT)
            scale = metres_per_newton(samples) if newton is None else newton
            add_contacts(scene, self._data.body("base"), touched, self.arm, scale)
        if overlays.frames:
            self._add_frames(self._pixels(1.6))
        return self._shot()

    def pose(
        self, qpos: Array, target: Array | None = None, share: float = 0.0, things: Array | None = None
    ) -> Pixels:  # fmt: skip
        """Draw the arm with joint angles [rad], shape (dofs,), and a ball at a target [m], if there is one.

        Args:
            share: of its turn that the camera `orbit` has made.
            things: where the free objects are in the base frame, see `Trajectory.objects`, shape (F, 7); default where
                they begin.
        """
        self._show(qpos, np.ones(self._index.zero.size), share, things)
        self._ghost.hide(self._renderer.scene)
        if target is not None:
            add_ball(self._renderer.scene, self.to_world(target), 0.02 * self.arm.length, ASKED)
        return self._shot()

    def with_marks(
        self, qpos: Array, add: Callable[[Any, Callable[[float], float]], object], share: float = 0.0
    ) -> Pixels:
        """Draw the arm with joint angles [rad], shape (dofs,), and what is added to the scene.

        Args:
            add: given the scene, and what turns the width of a line in a picture of 720 rows into its width here.
            share: of its turn that the camera `orbit` has made.
        """
        self._show(qpos, np.ones(self._index.zero.size), share)
        self._ghost.hide(self._renderer.scene)
        add(self._renderer.scene, self._pixels)
        return self._shot()

    def stations(self, qpos: Array) -> Array:
        """Return the stations of the arm with joint angles [rad], shape (dofs,), in the base frame [m], (T, 3)."""
        self._pose(qpos)
        base = self._data.body("base")
        return np.asarray((self._data.xpos[self._index.stations] - base.xpos) @ base.xmat.reshape(3, 3))

    def bent(self, bend: Array) -> Array:
        """Return the joint angles [rad], shape (dofs,), of the arm with every joint of a section bent alike.

        Args:
            bend: of the sections [rad], shape (2 S,).
        """
        qpos, bends = np.zeros(self._model.nq)[self._index.qpos], shape.bends_of(bend, self.arm)
        for axis, sign, part in (("x", -1.0, 1), ("y", 1.0, 0)):
            hinges = self._index.bending[axis]
            number = self._index.section_of_joint[hinges]
            links = np.array([section.links for section in self.arm.sections])
            qpos[hinges] = sign * (bends[:, part] / links)[number]
        return qpos

    def among(self, arm: Arm) -> None:
        """Draw the objects of another arm's world from now on, which has the same, of other sizes, elsewhere."""
        from contarm_sim.mjcf.object_looks import restage

        restage(self._model, self.arm, arm)

    def to_world(self, points: Array) -> Array:
        """Turn points of the base frame [m], shape (..., 3), into points of the world that is drawn."""
        return placed(self._data.body("base"), points)

    def _pixels(self, width: float) -> float:
        """Return the width of a line [pixels] that is so wide in a picture of 720 rows."""
        return width * self._renderer.height / 720

    def _shot(self) -> Pixels:
        """Draw what is gathered."""
        return cut_out(self._renderer) if self._transparent else self._renderer.render()

    def _pose(self, qpos: Array, things: Array | None = None, hosted: Array | None = None) -> None:
        """Place every body, light and muscle; no step is simulated.

        Args:
            things: where the free objects are in the base frame, see `Trajectory.objects`; default where they begin.
            hosted: positions of the host's joints, see `Trajectory.host`; default as before.
        """
        import mujoco

        from contarm_sim.mjcf.object_looks import to_scene

        own, all_free = self._index.qpos, self._model.nq - 7 * len(self._free)
        if hosted is not None:
            self._data.qpos[: own.start], self._data.qpos[own.stop : all_free] = np.split(hosted, [own.start])
            mujoco.mj_kinematics(self._model, self._data)
        self._data.qpos[own] = qpos
        if len(self._free):
            base = None if things is None or hosted is None else self._data.body("base")
            self._data.qpos[all_free:] = to_scene(self.arm, self._free if things is None else things, base)
        for update in (mujoco.mj_kinematics, mujoco.mj_comPos, mujoco.mj_camlight, mujoco.mj_tendon):
            update(self._model, self._data)

    def _near_by(self, arm: Arm) -> float:
        """Return the extent of the model of an arm by itself over that of this one, which a host may have made."""
        return 1.2 * arm.length / float(self._model.stat.extent)

    def _show(
        self, qpos: Array, tension: Array, share: float, things: Array | None = None, hosted: Array | None = None
    ) -> None:
        """Pose the arm, and gather what the camera sees of it and of the floor.

        Args:
            tension: of each muscle, over the largest.
            share: of the film that has passed.
            things, hosted: where the free objects and the host's joints are, see `_pose`.
        """
        from contarm_sim.mjcf.backbone import payload_radius

        self._pose(qpos, things, hosted)
        self._muscles.look(tension, self._data)
        self._renderer.update_scene(self._data, self._camera.at(self._data.body("tip").xpos, share))
        self._backbone.place(self._renderer.scene, self._data)
        self._muscles.place(self._renderer.scene, self._data)
        if not self._transparent and self._floor is not None:
            self._floor.shade(
                self._renderer, self._data.xpos[self._index.stations], payload_radius(self.arm), self._data
            )
            self._floor.add_lines(self._renderer.scene, self._pixels(1.0))

    def _add_frames(self, width: float) -> None:
        """Draw the axes of base and tip."""
        for name in ("base", "tip"):
            body = self._data.body(name)
            add_triad(self._renderer.scene, body.xpos, body.xmat.reshape(3, 3), 0.14 * self.arm.length, width)


def _set_quality(spec: Any) -> None:
    """Set samples a pixel and roundness: together with the floor they decide the time of a frame in software GL."""
    sight = spec.visual.quality
    sight.offsamples, sight.numslices, sight.numstacks = _SAMPLES, _SLICES, _STACKS
