"""What is around the arm on the page: floor, mount, the dome of reachable tips, and where one looks from."""

from __future__ import annotations

from typing import Any

import mujoco
import numpy as np

from contarm_sim.kinematics.arc import LARGEST_BEND
from contarm_sim.kinematics.arrays import Array
from contarm_sim.mjcf.scene import KEY, add_scene, base_rotation
from contarm_sim.model.arm import Arm
from contarm_sim.view.live.shapes import as_bytes, faces
from contarm_sim.view.sections import reachable_tips

_DOME = (118, 126, 140)
_GRID = (150, 156, 166)
_FLOOR, _LINE = 0.1, 0.5
"""Distances between the lines of the floor [m]."""

FOV = 0.62
"""Vertical field of view [rad]."""

_ASPECT = 0.78
"""Width over height of the narrowest picture that shows all: a phone's, and a laptop's between the panels."""

_TOWARDS = np.array([0.52, -0.80, 0.30])


_SLANT = np.array(KEY[:2]) / -KEY[2]
"""How far a shadow falls aside for every metre of height."""

_ROUND = np.stack([np.cos(turn := np.linspace(0, 2 * np.pi, 48, endpoint=False)), np.sin(turn)], axis=1)
"""Directions on the floor."""


def add_lights(scene: Any) -> None:
    """Light the scene without shadow maps and pictures of surroundings, which software renderers are slow at."""
    scene.configure_environment_map(None)
    scene.configure_default_lights(enabled=False)
    scene.add_light_hemisphere("/light/sky", sky_color=(255, 255, 255), ground_color=(190, 192, 200), intensity=1.5)
    for name, strength, place in (("key", 1.5, (1.0, -1.2, 2.0)), ("fill", 0.8, (-1.5, -0.6, 0.4))):
        scene.add_light_directional(f"/light/{name}", intensity=strength, position=place)


class Surroundings:
    """Nodes of the page that stand still while the arm moves.

    Attributes:
        tips: the dome, or the hull of what several sections reach [m], shape (K, 3), in the base frame.
    """

    def __init__(self, server: Any, arm: Arm) -> None:
        self._server = server
        self._floor = server.scene.add_grid(
            "/floor", width=4 * arm.length, height=4 * arm.length, cell_size=_FLOOR, section_size=_LINE,
            cell_color=_GRID, section_color=_GRID, cell_thickness=0.6, section_thickness=1.2, shadow_opacity=0.0,
        )  # fmt: skip
        self._mount: list[Any] = []
        self._shadow: Any = None
        self.tips = self._add_dome(arm)
        self.turn(arm)

    @property
    def nodes(self) -> list[Any]:
        """What is not fixed to the arm."""
        return [self._floor, *self._mount, *([] if self._shadow is None else [self._shadow])]

    def _add_dome(self, arm: Arm) -> Array:
        """Draw the reachable tips, faint, with meridians and parallels."""
        add = self._server.scene
        points = reachable_tips(arm, 35, 49, LARGEST_BEND)
        tips = points.reshape(-1, 3)
        # Only far sides of what is clear are drawn: they never cover the arm.
        add.add_mesh_simple(
            "/arm/dome", tips, faces(np.arange(len(tips)).reshape(points.shape[:2])), color=_DOME, opacity=0.12,
            side="back", cast_shadow=False, receive_shadow=False,
        )  # fmt: skip
        parallels = np.stack([points[6::6, :-1], points[6::6, 1:]], axis=2).reshape(-1, 2, 3)
        meridians = np.stack([points[:-1, ::4], points[1:, ::4]], axis=2).reshape(-1, 2, 3)
        lines = np.concatenate([parallels, meridians])
        add.add_line_segments("/arm/dome/lines", lines, _DOME, thickness=1.0, thickness_units="screen")
        return tips

    def turn(self, arm: Arm) -> None:
        """Put floor and mount where they are when gravity points down, and look there."""
        spec = mujoco.MjSpec()
        base = add_scene(spec, arm)
        self._ground, self._width, self._turn = -float(base[2]), arm.disk_radius, base_rotation(arm)
        self._floor.position = (0.0, 0.0, self._ground)
        self._hosted = arm.world.host is not None  # which has floors and mounts of its own
        self._floor.visible = not self._hosted
        for node in self._mount:
            node.remove()
        colours = {material.name: as_bytes(material.rgba) for material in spec.materials}
        self._mount = [
            node for geom in ([] if self._hosted else spec.worldbody.geoms)
            if (node := self._part(geom, base, colours.get(geom.material, _DOME))) is not None
        ]  # fmt: skip
        eye, centre = view_of(arm, self.tips)
        first: Any = self._server.initial_camera
        first.fov, first.look_at, first.position = FOV, tuple(centre), tuple(eye)
        for client in self._server.get_clients().values():
            with client.atomic():
                client.camera.position = tuple(eye)
                client.camera.look_at = tuple(centre)

    def show_shadow(self, stations: Array) -> None:
        """Draw the hull of the arm's shadow on the floor: shadow maps take a software renderer five times as long.

        Args:
            stations: of the arm [m], shape (N + 1, 3), in the base frame.
        """
        if self._hosted:
            return
        places = stations @ self._turn.T
        fallen = places[:, :2] + np.outer(places[:, 2] - self._ground, _SLANT)
        farthest = fallen[(fallen @ _ROUND.T).argmax(axis=0)]
        rim = np.column_stack([farthest + self._width * _ROUND, np.full(len(_ROUND), self._ground + 1e-3)])
        vertices = np.vstack([rim.mean(axis=0), rim])
        if self._shadow is None:
            self._shadow = self._server.scene.add_mesh_simple(
                "/shadow", vertices, _fan(len(_ROUND)), color=(0, 0, 0), opacity=0.14,
                side="double", cast_shadow=False, receive_shadow=False,
            )  # fmt: skip
        else:
            self._shadow.vertices = vertices.astype(np.float32)

    def _part(self, geom: Any, base: Array, colour: tuple[int, int, int]) -> Any:
        """Draw a part of the mount, as the scene of films has it; None for floor and sky."""
        add, name = self._server.scene, f"/mount/{geom.name}"
        place = {"position": tuple(geom.pos - base), "wxyz": tuple(geom.quat / np.linalg.norm(geom.quat))}
        size, kind = [float(part) for part in geom.size], mujoco.mjtGeom
        if geom.type == kind.mjGEOM_CYLINDER:
            return add.add_cylinder(name, radius=size[0], height=2 * size[1], color=colour, **place)
        if geom.type == kind.mjGEOM_SPHERE:
            return add.add_icosphere(name, radius=size[0], color=colour, **place)
        if geom.type == kind.mjGEOM_BOX:
            return add.add_box(name, dimensions=(2 * size[0], 2 * size[1], 2 * size[2]), color=colour, **place)
        return None


def _fan(count: int) -> Array:
    """Return the triangles, shape (count, 3), between vertex 0 and a closed rim of the others."""
    rim = np.arange(count)
    return np.stack([np.zeros(count, dtype=int), 1 + rim, 1 + (rim + 1) % count], axis=1)


def view_of(arm: Arm, tips: Array) -> tuple[Array, Array]:
    """Return eye and centre [m], in the world, of a view of all tips, shape (K, 3) in the base frame, and the base."""
    seen = np.vstack([tips, np.zeros(3), tips * (1 + 2 * arm.disk_radius / arm.length)]) @ base_rotation(arm).T
    back = _TOWARDS / np.linalg.norm(_TOWARDS)
    right = np.cross([0.0, 0.0, 1.0], back)
    frame = np.stack([right / np.linalg.norm(right), np.cross(back, right / np.linalg.norm(right)), back])
    place = seen @ frame.T
    middle = 0.5 * (place.min(axis=0) + place.max(axis=0))
    x, y, z = (place - middle).T
    distance = np.max(z + np.maximum(np.abs(y), np.abs(x) / _ASPECT) / np.tan(0.5 * FOV))
    centre = middle @ frame
    return centre + 1.06 * distance * back, centre
