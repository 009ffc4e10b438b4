"""The tangent stiffness of the simulated arm: minus the derivative of its generalised forces, in closed form.

For a chain of hinges with axes a_j through anchors o_j, a dead force f at p on a body distal to j has the
generalised force a_j . ((p - o_j) x f); its derivative by q_i, i proximal or equal to j, is a_i . c_j with
c_j = D_j a_j - tr(D_j) a_j, D_j the sum of (p - o_j) (x) f over the bodies distal to j (design 5). Gravity is such a
load. Muscle spans add what their turning and stretching does.
"""

from __future__ import annotations

import mujoco
import numpy as np

from contarm_sim.kinematics.arrays import Array
from contarm_sim.simulation.plant import Plant


class TangentStiffness:
    """Evaluates K = -dQ/dq [N m/rad], shape (dofs, dofs), at the plant's current positions and forces."""

    def __init__(self, plant: Plant) -> None:
        self._model, self._data = plant.model, plant.data
        model = self._model
        self._base = model.body("base").id
        self._station_of_dof = model.dof_bodyid - self._base
        self._sites = np.array(
            [[model.site(f"{model.body(self._base + s).name}_muscle_{m}").id for m in (1, 2, 3)]
             for s in range(plant.arm.links + 1)]
        )  # fmt: skip
        stations = np.arange(1, plant.arm.links + 1)
        self._own = self._station_of_dof == stations[:, None]  # span s crosses the joint of station s
        self._proximal = self._station_of_dof < stations[:, None]
        self._limited = bool(model.actuator_forcelimited.any())
        self._gain = model.actuator_gainprm[:, 0]

    def __call__(self) -> Array:
        """Return K; `mj_forward` must be up to date."""
        data, model = self._data, self._model
        axes, anchors = data.xaxis, data.xanchor
        ends = data.site_xpos[self._sites]  # (stations, muscles, 3)
        spans = np.diff(ends, axis=0)
        reach = np.linalg.norm(spans, axis=-1, keepdims=True)
        u = spans / reach
        tension = -data.actuator_force[None, :, None]

        force = np.zeros_like(ends)
        force[:-1] += tension * u
        force[1:] -= tension * u
        dyad = np.einsum("smi,smj->sij", ends, force)
        force = force.sum(axis=1)
        links = slice(self._base, self._base + len(ends))
        weight = model.body_mass[links, None] * model.opt.gravity
        force += weight
        dyad += data.xipos[links, :, None] * weight[:, None, :]
        force = np.cumsum(force[::-1], axis=0)[::-1][self._station_of_dof]
        dyad = np.cumsum(dyad[::-1], axis=0)[::-1][self._station_of_dof]
        D = dyad - anchors[:, :, None] * force[:, None, :]
        c = np.einsum("jab,jb->ja", D, axes) - np.trace(D, axis1=1, axis2=2)[:, None] * axes
        dead = np.triu(axes @ c.T)
        K = -(dead + np.triu(dead, 1).T)

        # Velocities of each span's end relative to its start under each dof: (spans, muscles, dofs, 3).
        arm_of = np.where(
            self._own[:, None, :, None],
            ends[1:, :, None, :] - anchors,
            self._proximal[:, None, :, None] * spans[:, :, None, :],
        )
        relative = np.cross(axes, arm_of)
        relative -= (relative @ u[..., None]) * u[:, :, None, :]
        weighted = relative * np.sqrt(np.maximum(tension, 0) / reach)[..., None]
        flat = weighted.transpose(2, 0, 1, 3).reshape(len(axes), -1)
        K += flat @ flat.T
        if np.any(tension < 0):  # plain servos push
            pushed = relative * np.sqrt(np.maximum(-tension, 0) / reach)[..., None]
            flat = pushed.transpose(2, 0, 1, 3).reshape(len(axes), -1)
            K -= flat @ flat.T

        free = np.ones(3, bool)
        if self._limited:
            low, high = model.actuator_forcerange.T
            free = (data.actuator_force > low) & (data.actuator_force < high)
        J = _dense_tendon_jacobian(model, data)
        K += (J.T * (self._gain * free)) @ J
        K[np.diag_indices_from(K)] += model.jnt_stiffness
        return K


def _dense_tendon_jacobian(model: mujoco.MjModel, data: mujoco.MjData) -> Array:
    """Return dL/dq [m/rad], shape (3, dofs)."""
    J = np.zeros((model.ntendon, model.nv))
    mujoco.mju_sparse2dense(J, data.ten_J, model.ten_J_rownnz, model.ten_J_rowadr, model.ten_J_colind)
    return J
