"""What the arm can touch on the page: objects, and where and how hard it touches them now."""

from __future__ import annotations

from typing import Any

import numpy as np

from contarm_sim.kinematics.arrays import Array
from contarm_sim.mechanics.contacts import Contacts
from contarm_sim.mjcf.ground import floor_plane, patch
from contarm_sim.mjcf.scene import base_position, base_rotation, floor_colour
from contarm_sim.mjcf.surfaces import surface
from contarm_sim.model.arm import Arm
from contarm_sim.model.objects import Object
from contarm_sim.view.colours import CONTACT, rgb
from contarm_sim.view.live.shapes import arrow, as_bytes, from_upright, linear
from contarm_sim.view.rendering.touch import arrow_scale

_MOST = 48
"""Contacts that are drawn at once, at most: the hardest."""

_THICK, _BALL = 0.014, 0.012
"""Radii of an arrow's head and of the ball at its foot [lengths]."""


class Things:
    """Nodes of the objects of an arm's world, all in the base frame, under a node of a name.

    Attributes:
        scale: how long arrows are [m/N]; 0 before anything was touched.
    """

    def __init__(self, server: Any, arm: Arm, under: str) -> None:
        self._add, self._arm, self.scale, self._largest = server.scene, arm, 0.0, 0.0
        turn, ground = base_rotation(arm), -float(base_position(arm)[2])
        floor = floor_plane(arm, turn)
        self._free: list[Any] = []
        for each in arm.world.objects:
            node = self._draw(each, f"{under}/objects/{each.name}", floor, turn, ground)
            if each.free:
                self._free.append(node)
        self._marks: tuple[Any, Any] | None = self._add_marks(under) if arm.world.touchable else None

    def _draw(self, each: Object, name: str, floor: Object | None, turn: Array, ground: float) -> Any:
        """Draw one object where it begins."""
        look: dict[str, Any] = {"color": as_bytes(each.colour), "position": each.position, "wxyz": each.quaternion}
        radius, length = each.radius or 0.0, each.length or 0.0
        if each.shape == "box":
            return self._add.add_box(name, dimensions=each.size, **look)
        if each.shape == "sphere":
            return self._add.add_icosphere(name, radius=radius, **look)
        if each.shape == "cylinder":
            return self._add.add_cylinder(name, radius=radius, height=length, radial_segments=40, **look)
        if each.shape == "plane":
            return self._draw_plane(each, name, floor, turn, ground)
        return self._add.add_mesh_simple(name, *surface(each), flat_shading=each.shape == "mesh", **look)

    def _draw_plane(self, each: Object, name: str, floor: Object | None, turn: Array, ground: float) -> Any:
        """Draw a part of a plane, seen from its outside only; of the floor a wide one, just below its lines."""
        middle, axes, sides = patch(each, self._arm, turn, ground)
        tint = each.colour
        if each is floor:
            tint, sides = floor_colour(self._arm), np.full(2, 2 * self._arm.length)  # type: ignore[assignment]
            middle = middle - 1e-3 * axes[:, 2]
        corners = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]]) * sides
        return self._add.add_mesh_simple(
            name, middle + corners @ axes[:, :2].T, np.array([[0, 1, 2], [0, 2, 3]]), color=as_bytes(tint),
            side="front", cast_shadow=False, receive_shadow=False,
        )  # fmt: skip

    def _add_marks(self, under: str) -> tuple[Any, Any]:
        """Add arrows and balls, all of no size yet."""
        upright, places = np.tile([1.0, 0.0, 0.0, 0.0], (_MOST, 1)), np.zeros((_MOST, 3))
        ball = surface(Object(name="ball", shape="sphere", radius=1.0))
        arrows, points = (
            self._add.add_batched_meshes_simple(
                f"{under}/contact/{name}", *mesh, upright, places, batched_scales=np.full((_MOST, 3), 1e-9),
                batched_colors=as_bytes(linear(rgb(CONTACT))), lod="off", cast_shadow=False, receive_shadow=False,
            )
            for name, mesh in (("arrows", arrow()), ("points", ball))
        )  # fmt: skip
        return arrows, points

    def show(self, poses: Array, contacts: Contacts | None) -> None:
        """Bring all up to date.

        Args:
            poses: of the free objects, see `Trajectory.objects`, shape (F, 7).
            contacts: of this moment.
        """
        for node, pose in zip(self._free, poses, strict=True):
            node.position, node.wxyz = pose[:3], pose[3:]
        if self._marks is None or contacts is None:
            return
        sizes = np.linalg.norm(contacts.force, axis=1)
        chosen = np.argsort(-sizes)[:_MOST]
        self._rescale(float(sizes.max(initial=0.0)))
        length, count = self._arm.length, len(chosen)
        places, turns = np.zeros((_MOST, 3)), np.tile([1.0, 0.0, 0.0, 0.0], (_MOST, 1))
        wide, round_ = np.full((_MOST, 3), 1e-9), np.full((_MOST, 3), 1e-9)
        places[:count] = contacts.point[chosen]
        if count:
            turns[:count] = from_upright(contacts.force[chosen] + [0.0, 0.0, 1e-12])
            wide[:count] = _THICK * length
            wide[:count, 2] = np.maximum(self.scale * sizes[chosen], 1e-6)
            round_[:count] = _BALL * length
        for node, scales in zip(self._marks, (wide, round_), strict=True):
            node.batched_positions, node.batched_wxyzs = places, turns
            node.batched_scales = scales.astype(np.float32)

    def _rescale(self, force: float) -> None:
        """Shorten arrows where a force is larger than any before."""
        if force > self._largest:
            self._largest = force
            self.scale = arrow_scale(force, self._arm.length)
