"""What the page shows in three dimensions: the simulated arm, its analytic ghost, the dome, the target, the trace.

Everything lies in the base frame, under one node that is turned so that gravity points down.
"""

from __future__ import annotations

from collections import deque
from typing import TYPE_CHECKING, Any

import numpy as np

from contarm_sim.kinematics import dome
from contarm_sim.kinematics.arc import LARGEST_BEND
from contarm_sim.kinematics.arrays import Array
from contarm_sim.mechanics import shape
from contarm_sim.mechanics.muscles import each
from contarm_sim.mjcf import names
from contarm_sim.mjcf.backbone import SPINE_RADIUS, payload_radius
from contarm_sim.mjcf.scene import base_quaternion, base_rotation
from contarm_sim.view.colours import error_colours
from contarm_sim.view.live.session import Session
from contarm_sim.view.rendering.draw import TARGET
from contarm_sim.view.rendering.ghost import GHOST
from contarm_sim.view.rendering.muscles import thickness, tint
from contarm_sim.view.sections import muscle_colours, reachable_tips, section_colour, section_places, tube_radii

if TYPE_CHECKING:
    import viser

_SIDES = 20
_DARK, _PALE, _DOME = (62, 66, 74), (206, 209, 214), (118, 126, 140)
_TRACE = 150
"""Points of the trace."""

_WORST = 0.02
"""Tip error that the trace shows as the worst [lengths]."""


class Scene:
    """The nodes of a page. `show` brings them up to date."""

    def __init__(self, server: viser.ViserServer, session: Session) -> None:
        self._server, self._session = server, session
        self._tips: deque[tuple[Array, float]] = deque(maxlen=_TRACE)
        self._add = server.scene
        server.scene.set_up_direction("+z")
        server.scene.world_axes.visible = False
        self.base = self._add.add_frame("/arm", show_axes=False, wxyz=base_quaternion(session.arm))
        length = session.arm.length
        grid: dict[str, Any] = {"width": 4 * length, "height": 4 * length, "cell_size": 0.1, "section_size": 0.5}
        self._floor = self._add.add_grid("/floor", **grid)
        self._add_dome()
        self._add_arm()
        ball = {"color": _bytes(np.array(TARGET[:3])), "opacity": 0.55, "cast_shadow": False}
        self.target = self._add.add_icosphere("/arm/target", radius=1.1 * session.arm.disk_radius, **ball)
        self._payload = self._add.add_icosphere("/arm/payload", radius=1.0, color=_DARK)
        vertices, faces = self._ghost()
        # Only far sides of what is clear are drawn, here and of the dome: they never cover the arm.
        self._glass = self._add.add_mesh_simple(
            "/arm/analytic", vertices, faces, color=_bytes(np.array(GHOST[:3])), opacity=0.45, side="back",
            cast_shadow=False, receive_shadow=False,
        )  # fmt: skip
        self.turn()
        self.show()

    def turn(self) -> None:
        """Turn the arm so that its gravity points down, put the floor below, look there; forget the trace."""
        self.base.wxyz, length = base_quaternion(self._session.arm), self._session.arm.length
        reach = self._dome @ base_rotation(self._session.arm).T
        self._floor.position = (0.0, 0.0, float(reach[:, 2].min()) - 0.15 * length)
        centre = 0.5 * (reach.min(axis=0) + reach.max(axis=0))
        self._server.initial_camera.look_at = tuple(centre)
        self._server.initial_camera.position = tuple(centre + length * np.array([1.1, -1.65, 0.65]))
        self._tips.clear()

    def _add_dome(self) -> None:
        """Draw the reachable tips, or the hull of those of several sections, faint, with meridians and parallels."""
        points = reachable_tips(self._session.arm, 35, 49, LARGEST_BEND)
        self._dome = points.reshape(-1, 3)
        faces = _faces(np.arange(len(self._dome)).reshape(points.shape[:2]))
        self._add.add_mesh_simple(
            "/arm/dome", self._dome, faces, color=_DOME, opacity=0.12, side="back", cast_shadow=False,
            receive_shadow=False,
        )  # fmt: skip
        parallels = np.stack([points[6::6, :-1], points[6::6, 1:]], axis=2).reshape(-1, 2, 3)
        meridians = np.stack([points[:-1, ::4], points[1:, ::4]], axis=2).reshape(-1, 2, 3)
        lines = np.concatenate([parallels, meridians])
        self._add.add_line_segments("/arm/dome/lines", lines, _DOME, thickness=1.0, thickness_units="screen")

    def _add_arm(self) -> None:
        """Draw disks, spine and muscles as cylinders, each kind in one node."""
        arm = self._session.arm
        vertices, faces = _cylinder()
        n, starts = arm.links, names.section_stations(arm)
        upright, places = np.tile([1.0, 0.0, 0.0, 0.0], (n + 1, 1)), np.zeros((n + 1, 3))
        own = np.repeat(np.arange(len(arm.sections)), [section.links for section in arm.sections])  # section of a link
        pitch = np.array([arm.sections[number].link_pitch for number in own])
        disks = np.array(arm.disk_radii)[np.concatenate([own[:1], own])]
        disks[starts[1:-1]] = np.maximum(disks[starts[1:-1]], np.array(arm.disk_radii)[1:])
        thick = np.minimum(0.0025, 0.2 * np.concatenate([pitch[:1], pitch]))
        thick[starts] *= 1.6
        tints = [_DARK if number == 0 else _bytes(np.array(section_colour(number))) for number in [0, *own]]
        self._disks = self._add.add_batched_meshes_simple(
            "/arm/disks", vertices, faces, upright, places, batched_scales=np.stack([disks, disks, thick], axis=1),
            batched_colors=_DARK if len(arm.sections) == 1 else np.array(tints, np.uint8), lod="off",
        )  # fmt: skip
        radii = SPINE_RADIUS * np.array([arm.routings[number].radius for number in own])
        self._spine = self._add.add_batched_meshes_simple(
            "/arm/spine", vertices, faces, upright[1:], places[1:],
            batched_scales=np.stack([radii, radii, 1.03 * pitch], axis=1), batched_colors=_PALE, lod="off",
        )  # fmt: skip
        paths = self._session.plant.muscle_paths
        self._spans = np.isfinite(paths[:, 1:, 0]) & np.isfinite(paths[:, :-1, 0])
        count = int(self._spans.sum())
        self._muscles = self._add.add_batched_meshes_simple(
            "/arm/muscles", vertices, faces, np.tile(upright[:1], (count, 1)), np.zeros((count, 3)),
            batched_scales=np.ones((count, 3)), batched_colors=np.zeros((count, 3), np.uint8), lod="off",
        )  # fmt: skip

    def show(self) -> None:
        """Send the session's current state."""
        session, plant = self._session, self._session.plant
        stations, rotations = plant.stations, plant.rotations
        paths = plant.muscle_paths
        with self._server.atomic():
            self._disks.batched_positions = stations
            self._disks.batched_wxyzs = _from_upright(rotations[:, :, 2])
            self._place(self._spine, stations[:-1], stations[1:])
            self._place(self._muscles, paths[:, :-1][self._spans], paths[:, 1:][self._spans])
            self._muscles.batched_scales, self._muscles.batched_colors = self._strength(paths)
            self._glass.vertices = self._ghost()[0].astype(np.float32)
            self._payload.position = stations[-1]
            self._payload.radius = max(payload_radius(session.arm), 1e-6)
            self.target.position = shape.position(session.goal, session.arm)
            self._show_trace()

    def _place(self, node: Any, starts: Array, ends: Array) -> None:
        node.batched_positions = 0.5 * (starts + ends)
        node.batched_wxyzs = _from_upright(ends - starts)

    def _strength(self, paths: Array) -> tuple[Array, Array]:
        """Return sizes and colours of all spans: the thicker and the brighter the more a muscle pulls."""
        arm = self._session.arm
        share = self._session.reading.tensions / (0.5 * each(arm, lambda group: group.law.blocked_force))
        radius = 0.5 * each(arm, lambda group: group.law.diameter) * thickness(share)
        spans = np.linalg.norm(np.diff(paths, axis=1), axis=2)
        sizes = np.stack([*[np.repeat(radius[:, None], spans.shape[1], 1)] * 2, 1.02 * spans], axis=2)
        tints = np.array([_bytes(row) for row in tint(share, muscle_colours(arm))])
        colours = np.repeat(tints[:, None], spans.shape[1], 1)
        return sizes[self._spans].astype(np.float32), colours[self._spans].astype(np.uint8)

    def _ghost(self) -> tuple[Array, Array]:
        """Return vertices and faces of the tubes of the analytic arcs."""
        session, pieces = self._session, max(24 // len(self._session.arm.sections), 12)
        vertices: list[Array] = []
        faces: list[Array] = []
        for xi, inside in zip(section_places(session.arm, pieces), tube_radii(session.arm), strict=True):
            points = shape.position(session.reading.bend, session.arm, xi)
            own = _tube(points, shape.rotation(session.reading.bend, session.arm, xi), 1.25 * inside)
            faces.append(own[1] + sum(map(len, vertices)))
            vertices.append(own[0])
        return np.concatenate(vertices), np.concatenate(faces)

    def _show_trace(self) -> None:
        """Draw where the tip has been, coloured by its error then."""
        reading = self._session.reading
        self._tips.append((reading.tip, reading.error))
        if len(self._tips) < 2:
            return
        tips = np.array([tip for tip, _ in self._tips])
        error = np.array([error for _, error in self._tips])[:-1]
        tints = 255 * error_colours(error, _WORST * self._session.arm.length)
        colours = np.repeat(tints[:, None], 2, 1).astype(np.uint8)
        lines = np.stack([tips[:-1], tips[1:]], axis=1)
        self._add.add_line_segments("/arm/trace", lines, colours, thickness=3.0, thickness_units="screen")

    def in_base(self, point: Array) -> Array:
        """Return a point of the world [m], shape (3,), in the base frame."""
        return np.asarray(point) @ base_rotation(self._session.arm)

    def bend_seen(self, eye: Array, through: Array) -> Array:
        """Return the bend [rad], shape (2,), whose tip lies where a ray meets the dome, or passes nearest to it.

        Args:
            eye, through: two points of the ray, in the world [m]; of several meetings, that near `through` counts.
        """
        length = self._session.arm.length
        ray = through - eye
        along = ray / max(float(np.linalg.norm(ray)), 1e-12) * length
        offsets = np.linspace(-1.0, 1.0, 65)
        for _ in range(2):  # coarse, then between the neighbours of the best
            points = (through + offsets[:, None] * along) @ base_rotation(self._session.arm)
            found = dome.bend_from_tip(points, length, project="nearest")
            best = int(np.argmin(found.miss / length + 0.02 * np.abs(offsets)))
            offsets = offsets[best] + np.linspace(-1.0, 1.0, 65) / 32
        return found.bend[best]


def _bytes(colour: Array) -> tuple[int, int, int]:
    red, green, blue = (int(255 * x) for x in colour)
    return red, green, blue


def _cylinder() -> tuple[Array, Array]:
    """Return vertices and faces of an upright cylinder of radius and height 1."""
    import trimesh

    made = trimesh.creation.cylinder(radius=1.0, height=1.0, sections=_SIDES)
    return np.asarray(made.vertices), np.asarray(made.faces)


def _tube(points: Array, frames: Array, radius: float) -> tuple[Array, Array]:
    """Return vertices and faces of an open tube along points [m], shape (T, 3), with frames, shape (T, 3, 3)."""
    turn = np.linspace(0.0, 2 * np.pi, _SIDES, endpoint=False)
    ring = radius * np.stack([np.cos(turn), np.sin(turn), np.zeros(_SIDES)], axis=1)
    rims = points[:, None] + ring @ frames.swapaxes(1, 2)
    index = np.arange(rims[..., 0].size).reshape(rims.shape[:2])
    return rims.reshape(-1, 3), _faces(np.hstack([index, index[:, :1]]).T)


def _faces(index: Any) -> Array:
    """Return the triangles, shape (F, 3), between vertices whose numbers lie in a grid, shape (T, K)."""
    a, b, c, d = index[:-1, :-1], index[1:, :-1], index[1:, 1:], index[:-1, 1:]
    return np.concatenate([np.stack(side, -1).reshape(-1, 3) for side in ((a, b, c), (a, c, d))])


def _from_upright(directions: Array) -> Array:
    """Return the quaternions w x y z, shape (T, 4), of the smallest turns from +Z to directions, shape (T, 3)."""
    x, y, z = (directions / np.linalg.norm(directions, axis=1, keepdims=True)).T
    quaternions = np.stack([1 + z, -y, x, np.zeros_like(z)], axis=1)
    quaternions[1 + z < 1e-9] = [0.0, 1.0, 0.0, 0.0]
    return quaternions / np.linalg.norm(quaternions, axis=1, keepdims=True)
