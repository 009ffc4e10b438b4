"""A host on the page: what is drawn of its bodies, in the base frame, which they move in when the base moves."""

from __future__ import annotations

from typing import Any

import mujoco
import numpy as np

from contarm_sim.engine.plant import Plant
from contarm_sim.kinematics.arrays import Array
from contarm_sim.mjcf import names
from contarm_sim.mjcf.surfaces import surface
from contarm_sim.model.objects import Object
from contarm_sim.view.live.shapes import as_bytes

_SEEN = 3
"""Groups of geoms that are drawn: those below, as in MuJoCo's own viewer."""

_WIDE = 2.0
"""Half side of planes without end [lengths]."""

_GEOM, _RGB = mujoco.mjtGeom, int(mujoco.mjtTextureRole.mjTEXROLE_RGB)


class HostThings:
    """Nodes of the geoms of a host, under a node of a name."""

    def __init__(self, server: Any, plant: Plant, under: str) -> None:
        self._add, self._plant, model = server.scene, plant, plant.model
        own = {*names.stations(plant.arm), names.PAYLOAD, *(each.name for each in plant.arm.world.objects)}
        self._nodes: dict[int, Any] = {}
        for geom in range(model.ngeom):
            if model.body(int(model.geom_bodyid[geom])).name in own or model.geom_group[geom] >= _SEEN:
                continue
            node = self._draw(geom, f"{under}/world/{geom}")
            if node is not None:
                self._nodes[geom] = node
        self.show(plant)

    def show(self, plant: Plant) -> None:
        """Put all where the engine has them; the plant is of the same host."""
        data, index = plant.data, plant.index
        turn = data.xmat[index.base].reshape(3, 3)
        for geom, node in self._nodes.items():
            quat = np.zeros(4)
            mujoco.mju_mat2Quat(quat, (turn.T @ data.geom_xmat[geom].reshape(3, 3)).ravel())
            node.position, node.wxyz = plant.to_base(data.geom_xpos[geom]), quat

    def _draw(self, geom: int, name: str) -> Any:
        """Draw one geom; None for what is clear, or of a kind that is not drawn here."""
        model = self._plant.model
        size, rgba = model.geom_size[geom], _colour(model, geom)
        if rgba[3] < 0.05:
            return None
        look: dict[str, Any] = {"color": as_bytes(rgba[:3]), "cast_shadow": False, "receive_shadow": False}
        if rgba[3] < 1:
            look["opacity"] = float(rgba[3])
        kind = model.geom_type[geom]
        if kind == _GEOM.mjGEOM_PLANE:
            sides = np.where(size[:2] > 0, size[:2], _WIDE * self._plant.arm.length)
            corners = np.array([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]]) * [*sides, 0]
            return self._add.add_mesh_simple(name, corners, np.array([[0, 1, 2], [0, 2, 3]]), side="front", **look)
        if kind == _GEOM.mjGEOM_MESH:
            mesh = int(model.geom_dataid[geom])
            first, face = model.mesh_vertadr[mesh], model.mesh_faceadr[mesh]
            vertices = model.mesh_vert[first : first + model.mesh_vertnum[mesh]]
            faces = model.mesh_face[face : face + model.mesh_facenum[mesh]]
            return self._add.add_mesh_simple(name, vertices, faces, flat_shading=True, **look)
        shape = _as_object(int(kind), size)
        if shape is None:
            return None
        vertices, faces = surface(shape)
        if kind == _GEOM.mjGEOM_ELLIPSOID:
            vertices = vertices * size
        return self._add.add_mesh_simple(name, vertices, faces, flat_shading=shape.shape == "box", **look)


def _colour(model: mujoco.MjModel, geom: int) -> Array:
    """Return red, green, blue and opacity of a geom: its own, or its material's, of a texture the mean."""
    material, rgba = int(model.geom_matid[geom]), np.array(model.geom_rgba[geom], dtype=float)
    if material < 0 or not np.allclose(rgba, [0.5, 0.5, 0.5, 1.0]):  # what the engine takes for none of its own
        return rgba
    rgba, picture = np.array(model.mat_rgba[material], dtype=float), int(model.mat_texid[material][_RGB])
    if picture >= 0:
        channels, first = int(model.tex_nchannel[picture]), int(model.tex_adr[picture])
        size = int(model.tex_width[picture] * model.tex_height[picture]) * channels
        pixels = model.tex_data[first : first + size].reshape(-1, channels)
        rgba[:3] *= pixels[:, :3].mean(axis=0) / 255
    return rgba


def _as_object(kind: int, size: np.ndarray) -> Object | None:
    """Return the object that has the form of a geom; of an ellipsoid a ball of radius 1; None where none has it."""
    radius, half = float(size[0]), float(size[1])
    if kind == _GEOM.mjGEOM_BOX:
        x, y, z = (2 * float(x) for x in size)
        return Object(name="box", shape="box", size=(x, y, z))
    if kind in (_GEOM.mjGEOM_SPHERE, _GEOM.mjGEOM_ELLIPSOID):
        return Object(name="ball", shape="sphere", radius=radius if kind == _GEOM.mjGEOM_SPHERE else 1.0)
    if kind in (_GEOM.mjGEOM_CAPSULE, _GEOM.mjGEOM_CYLINDER):
        shape: Any = "capsule" if kind == _GEOM.mjGEOM_CAPSULE else "cylinder"
        return Object(name="rod", shape=shape, radius=radius, length=2 * half)
    return None
