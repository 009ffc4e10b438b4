"""What moves on the page in three dimensions: the simulated arm, its analytic ghost, the target, the trace.

Everything lies in the base frame, under one node that is turned so that gravity points down.
"""

from __future__ import annotations

from collections import deque
from typing import TYPE_CHECKING, Any

import numpy as np

from contarm_sim.kinematics import dome
from contarm_sim.kinematics.arrays import Array
from contarm_sim.mechanics import shape
from contarm_sim.mechanics.muscles import each
from contarm_sim.mjcf import names
from contarm_sim.mjcf.backbone import SPINE_RADIUS, links, payload_radius
from contarm_sim.mjcf.nose import SILICONE, disk_in_nose, drawn_length, nose_radius
from contarm_sim.mjcf.scene import base_quaternion, base_rotation
from contarm_sim.mjcf.surfaces import cap
from contarm_sim.view.colours import ANALYTIC, CONTACT, TARGET, error_colours, rgb
from contarm_sim.view.live.hosted import HostThings
from contarm_sim.view.live.session import Reading, Session
from contarm_sim.view.live.shapes import as_bytes, cylinder, from_upright, hoop, linear, tube
from contarm_sim.view.live.surroundings import Surroundings, add_lights
from contarm_sim.view.live.things import Things
from contarm_sim.view.rendering.muscles import radii, tint
from contarm_sim.view.rendering.tubes import ended
from contarm_sim.view.sections import muscle_colours, section_colour, section_places, tube_radii

if TYPE_CHECKING:
    import viser

_DARK, _PALE = (0.36, 0.38, 0.42), (0.78, 0.79, 0.81)
_TRACE, _EVERY = 150, 0.025
"""Points of the trace, and the simulated time between them [s]."""

_WORST = 0.02
"""Tip error that the trace shows as the worst [lengths]."""

_HOOP = 1.8
"""Radius of the target's ring [radii of the tip plate]: the analytic and the simulated tip are seen inside it."""


class Scene:
    """The nodes of a page. `show` brings them up to date.

    Attributes:
        trace: readings where the tip was of late.
    """

    def __init__(self, server: viser.ViserServer, session: Session) -> None:
        self._server, self._session, self._add = server, session, server.scene
        self._shades: Array | None = None
        server.scene.set_up_direction("+z")
        server.scene.world_axes.visible = False
        add_lights(server.scene)
        self.build()

    def build(self) -> None:
        """Draw the session's arm in place of whatever was drawn before."""
        arm = self._session.arm
        self.trace: deque[Reading] = deque(maxlen=_TRACE)
        self.base = self._add.add_frame("/arm", show_axes=False, wxyz=base_quaternion(arm))
        self._around = Surroundings(self._server, arm)
        self._add_arm()
        self._add_target()
        self._things, self._lit = Things(self._server, arm, "/arm"), np.zeros(0, dtype=int)
        plant = self._session.plant
        self._host = HostThings(self._server, plant, "/arm") if plant.hosted else None
        self._payload = self._add.add_icosphere("/arm/payload", radius=1.0, color=as_bytes(_DARK))
        vertices, faces = self._ghost()
        # Only far sides of what is clear are drawn: they never cover the arm.
        self._glass = self._add.add_mesh_simple(
            "/arm/analytic", vertices, faces, color=as_bytes(rgb(ANALYTIC)), opacity=0.5, side="back",
            cast_shadow=False, receive_shadow=False,
        )  # fmt: skip
        self._line: Any = None
        self.show()

    def clear(self) -> None:
        """Take all nodes away; those of the target first, which people may hold."""
        for node in (self.target, self.base, *self._around.nodes):
            node.remove()

    def turn(self) -> None:
        """Turn the arm so that its gravity points down, with floor and mount, look there; forget the trace."""
        self.base.wxyz = base_quaternion(self._session.arm)
        self._around.turn(self._session.arm)
        self._things = Things(self._server, self._session.arm, "/arm")  # in place of those before, with another floor
        self.trace.clear()

    def _add_target(self) -> None:
        """Draw a ring around where the tip is to be, in a bubble to take hold of."""
        radius, colour = _HOOP * self._session.arm.disk_radius, as_bytes(rgb(TARGET))
        bubble: dict[str, Any] = {"opacity": 0.22, "side": "back", "cast_shadow": False, "receive_shadow": False}
        self.target = self._add.add_icosphere("/arm/target", radius=radius, color=colour, **bubble)
        # White inside, so that it is seen on a dark page too.
        for name, share, shade in (("ring", 1.0, colour), ("edge", 0.91, (255, 255, 255))):
            self._add.add_mesh_simple(
                f"/arm/target/{name}", *hoop(share * radius, 0.14 * share**6 * radius), color=shade, cast_shadow=False
            )

    def _add_arm(self) -> None:
        """Draw disks, spine and muscles as cylinders, each kind in one node."""
        arm = self._session.arm
        vertices, faces = cylinder()
        n, starts = arm.links, names.section_stations(arm)
        upright, places = np.tile([1.0, 0.0, 0.0, 0.0], (n + 1, 1)), np.zeros((n + 1, 3))
        own = np.repeat(np.arange(len(arm.sections)), [section.links for section in arm.sections])  # section of a link
        pitch = np.array([arm.sections[number].link_pitch for number in own])
        disks = np.array(arm.disk_radii)[np.concatenate([own[:1], own])]
        disks[starts[1:-1]] = np.maximum(disks[starts[1:-1]], np.array(arm.disk_radii)[1:])
        thick = np.minimum(0.0025, 0.2 * np.concatenate([pitch[:1], pitch]))
        thick[starts] *= 1.6
        self._nose, self._end = nose_radius(arm), drawn_length(arm)
        self._heights = np.array([link.height for link in links(arm)])
        fits = [disk_in_nose(link, self._nose, 0.0, 0.5 * half) if self._nose else np.inf for link, half in
                zip(links(arm)[:-1], thick, strict=False)]  # fmt: skip
        disks = np.append(np.minimum(disks[:-1], fits), self._nose or disks[-1])
        tints = [_DARK if number == 0 else section_colour(number) for number in [0, *own]]
        self._tints = (255 * linear(tints)).astype(np.uint8)
        self._disks = self._add.add_batched_meshes_simple(
            "/arm/disks", vertices, faces, upright, places, batched_scales=np.stack([disks, disks, thick], axis=1),
            batched_colors=self._tints, lod="off",
        )  # fmt: skip
        radii = SPINE_RADIUS * np.array([arm.routings[number].radius for number in own])
        self._pieces = int((self._heights[:-1] < self._end).sum())  # of the spine
        sizes = np.stack([radii, radii, pitch], axis=1)[: self._pieces]
        self._spine = self._add.add_batched_meshes_simple(
            "/arm/spine", vertices, faces, upright[: self._pieces], places[: self._pieces],
            batched_scales=sizes, batched_colors=as_bytes(linear(_PALE)), lod="off",
        )  # fmt: skip
        paths = self._session.plant.muscle_paths
        self._spans = np.isfinite(paths[:, 1:, 0]) & np.isfinite(paths[:, :-1, 0]) & (self._heights[:-1] < self._end)
        count = int(self._spans.sum())
        self._muscles = self._add.add_batched_meshes_simple(
            "/arm/muscles", vertices, faces, np.tile(upright[:1], (count, 1)), np.zeros((count, 3)),
            batched_scales=np.ones((count, 3)), batched_colors=np.zeros((count, 3), np.uint8), lod="off",
        )  # fmt: skip

        self._cap = None
        if self._nose:
            self._cap = self._add.add_mesh_simple("/arm/nose", *cap(self._nose), color=as_bytes(SILICONE))

    def note(self) -> None:
        """Take a point of the trace, if it is time for one: it is smooth however seldom the page is drawn."""
        reading = self._session.reading
        if self.trace and reading.time < self.trace[-1].time:  # the motion began again
            self.trace.clear()
        if not self.trace or reading.time - self.trace[-1].time >= _EVERY:
            self.trace.append(reading)

    def show(self) -> None:
        """Send the session's current state."""
        session, plant = self._session, self._session.plant
        stations, rotations = plant.stations, plant.rotations
        paths = ended(plant.muscle_paths, self._heights, self._end)
        spine, disks, turns = (
            ended(stations, self._heights, self._end),
            stations.copy(),
            from_upright(rotations[:, :, 2]),
        )
        disks[-1] -= self._nose * rotations[-1, :, 2]
        with self._server.atomic():
            self._disks.batched_positions, self._disks.batched_wxyzs = disks, turns
            self._place(self._spine, spine[: self._pieces], spine[1 : self._pieces + 1])
            if self._cap is not None:
                self._cap.position, self._cap.wxyz = disks[-1], turns[-1]
            self._place(self._muscles, paths[:, :-1][self._spans], paths[:, 1:][self._spans])
            self._muscles.batched_scales, self._muscles.batched_colors = self._strength(paths)
            self._glass.vertices = self._ghost()[0].astype(np.float32)
            self._payload.position = stations[-1]
            self._payload.radius = max(payload_radius(session.arm), 1e-6)
            self.target.position = shape.position(session.goal, session.arm)
            self.target.wxyz = from_upright(shape.rotation(session.goal, session.arm)[None, :, 2])[0]
            self._around.show_shadow(stations)
            self._show_trace()
            self._show_contacts()

    def _show_contacts(self) -> None:
        """Draw what is touched now, and where free objects are."""
        contacts = self._session.contacts
        self._things.show(self._session.poses, contacts)
        if self._host is not None:
            self._host.show(self._session.plant)
        if contacts is None:
            return
        lit = np.unique(contacts.station)
        if not np.array_equal(lit, self._lit):
            self._lit, colours = lit, self._tints.copy()
            colours[lit] = (255 * linear(rgb(CONTACT))).astype(np.uint8)
            self._disks.batched_colors = colours

    @property
    def arrows(self) -> float:
        """How long the arrows of contact forces are [m/N]; 0 before anything was touched."""
        return self._things.scale

    def _place(self, node: Any, starts: Array, ends: Array) -> None:
        node.batched_positions = 0.5 * (starts + ends)
        node.batched_wxyzs = from_upright(ends - starts)

    def _strength(self, paths: Array) -> tuple[Array, Array]:
        """Return sizes and colours of all spans: as thick as a muscle's law says, the brighter the more it pulls."""
        arm = self._session.arm
        share = self._session.reading.tensions / (0.5 * each(arm, lambda group: group.law.blocked_force))
        radius = radii(arm, self._session.plant.muscle_lengths)
        spans = np.linalg.norm(np.diff(paths, axis=1), axis=2)
        sizes = np.stack([*[np.repeat(radius[:, None], spans.shape[1], 1)] * 2, 1.02 * spans], axis=2)
        tints = np.array([as_bytes(linear(row)) for row in tint(share, muscle_colours(arm))])
        colours = np.repeat(tints[:, None], spans.shape[1], 1)
        return sizes[self._spans].astype(np.float32), colours[self._spans].astype(np.uint8)

    def _ghost(self) -> tuple[Array, Array]:
        """Return vertices and faces of the tubes of the analytic arcs."""
        session, pieces = self._session, max(24 // len(self._session.arm.sections), 12)
        vertices: list[Array] = []
        faces: list[Array] = []
        for xi, inside in zip(section_places(session.arm, pieces), tube_radii(session.arm), strict=True):
            points = shape.position(session.reading.bend, session.arm, xi)
            own = tube(points, shape.rotation(session.reading.bend, session.arm, xi), 1.25 * inside)
            faces.append(own[1] + sum(map(len, vertices)))
            vertices.append(own[0])
        return np.concatenate(vertices), np.concatenate(faces)

    def _show_trace(self) -> None:
        """Draw where the tip has been, coloured by its error then."""
        self.note()
        if len(self.trace) < 2 or self._shades is None:
            if self._line is not None:
                self._line.remove()
                self._line = None
            return
        tips = np.array([reading.tip for reading in self.trace])
        share = np.array([reading.error for reading in self.trace])[:-1] / (_WORST * self._session.arm.length)
        tints = self._shades[(np.clip(share, 0, 1) * (len(self._shades) - 1)).astype(int)]
        lines, colours = np.stack([tips[:-1], tips[1:]], axis=1), np.repeat(tints[:, None], 2, 1)
        if self._line is None:
            self._line = self._add.add_line_segments(
                "/arm/trace", lines, colours, thickness=3.0, thickness_units="screen"
            )
        else:
            self._line.points, self._line.colors = lines.astype(np.float32), colours

    def learn_shades(self) -> None:
        """Learn the colours of errors, from a library that takes long to load: until then no trace is drawn."""
        self._shades = (255 * linear(error_colours(np.linspace(0, 1, 64), 1.0))).astype(np.uint8)

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
