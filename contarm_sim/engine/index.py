"""Where the parts of the arm are in a compiled model, found once by what they mean.

Names are those of `mjcf.names`. Whoever reads the engine's arrays asks here; nobody else compares or builds names.
"""

from __future__ import annotations

from dataclasses import dataclass

import mujoco
import numpy as np
from numpy.typing import NDArray

from contarm_sim.kinematics.arrays import Array
from contarm_sim.mechanics.muscles import slices
from contarm_sim.mjcf import names
from contarm_sim.mjcf.routing import coefficient, counted_from
from contarm_sim.model.arm import Arm

Indices = NDArray[np.intp]


@dataclass(frozen=True)
class ArmIndex:
    """Indices of the parts of an arm of S sections, K stations, D joints and M muscles.

    Attributes:
        base, tip, payload: bodies.
        stations: rows of the bodies of base, links and tip in the engine's arrays.
        bodies: the same, and the payload.
        station_of_dof: station of the body that a hinge turns, shape (D,).
        section_of_joint: section of each hinge, from 0, shape (D,).
        bending: hinges about x and about y, by axis, base first.
        twisting: hinges about z, shape (J,).
        twisted: all hinges of the joints that have one about z, shape (J, 3).
        tendons: the muscles' tendons, shape (M,); empty for a bare backbone.
        actuators: of each muscle, one column a muscle, shape (R, M); R is 0 for a bare backbone.
        groups: which of the muscles those of each group of `Arm.groups` are.
        sites: where muscles in straight spans cross stations, shape (K, M); -1 where a muscle has no guide.
        lengths, velocities, forces: columns of the muscles' sensors, shape (M,).
        angles: columns of the joints' sensors, shape (D,).
        tip_position, tip_orientation: columns of the sensors of the tip's pose, shape (3,) and (4,).
        base_pose: columns of the sensors of the base's position and orientation in a host, shape (7,); else (0,).
        host: columns of the sensors of a host's own joint positions, in its order.
        joints, qpos, dofs: the arm's joints in the engine's arrays of joints, positions and velocities.
        states: the states of the arm's actuators in the engine's.
        touch, depth: columns of the sensors of what stations feel of P partners (see `mjcf.names.partners`): how many
            contacts, their force [N] on the partner and where it acts [m], shape (P, K, 7); the deepest one's distance
            [m] and normal, (P, K, 4). P is 0 where the arm cannot touch anything.
        poses: columns of the sensors of the F free objects' positions [m] and orientations, shape (F, 7).
        zero: muscle length at which the engine's is zero [m], shape (M,).
        by_angle: what parallel muscles gain in length by joint angles [m/rad], shape (M, D).
        straight: whether a muscle runs in straight spans, shape (M,).
    """

    base: int
    tip: int
    payload: int
    stations: slice
    bodies: slice
    station_of_dof: Indices
    section_of_joint: Indices
    bending: dict[str, Indices]
    twisting: Indices
    twisted: Indices
    tendons: Indices
    actuators: Indices
    groups: tuple[slice, ...]
    sites: Indices
    lengths: Indices
    velocities: Indices
    forces: Indices
    angles: Indices
    tip_position: Indices
    tip_orientation: Indices
    base_pose: Indices
    host: Indices
    joints: slice
    qpos: slice
    dofs: slice
    states: slice
    touch: Indices
    depth: Indices
    poses: Indices
    zero: Array
    by_angle: Array
    straight: NDArray[np.bool_]

    @classmethod
    def of(cls, model: mujoco.MjModel, arm: Arm, in_world: bool = False) -> ArmIndex:
        """Find the parts of an arm in a model that has it under its plain names.

        Args:
            in_world: whether what it can touch is in the model too.

        Raises:
            KeyError: the model has no such arm.
        """
        hinges, muscles = names.joints(arm), names.muscles(arm)
        bodies = np.array([model.body(name).id for name in [*names.stations(arm), names.PAYLOAD]])
        order = np.array([model.joint(hinge.name).dofadr[0] for hinge in hinges], dtype=int)
        by_dof = [hinges[i] for i in np.argsort(order)]
        of_axis = {axis: np.flatnonzero([hinge.axis == axis for hinge in by_dof]) for axis in "xyz"}
        stations = np.array([hinge.station for hinge in by_dof])
        columns = _Columns(model)
        driven = muscles if muscles and mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_TENDON, muscles[0]) >= 0 else []
        return cls(
            base=int(bodies[0]),
            tip=int(bodies[-2]),
            payload=int(bodies[-1]),
            stations=rows(bodies[:-1]),
            bodies=rows(bodies),
            station_of_dof=stations,
            section_of_joint=np.array([hinge.section for hinge in by_dof]),
            bending={axis: of_axis[axis] for axis in "xy"},
            twisting=of_axis["z"],
            twisted=np.array([np.flatnonzero(stations == stations[z]) for z in of_axis["z"]], dtype=int).reshape(-1, 3),
            tendons=np.array([model.tendon(name).id for name in driven], dtype=int),
            actuators=_actuators(model, muscles),
            groups=tuple(slices(arm)),
            sites=_sites(model, arm, len(driven)),
            lengths=columns([names.sensor(name, names.LENGTH) for name in driven]),
            velocities=columns([names.sensor(name, names.VELOCITY) for name in driven]),
            forces=columns([names.sensor(name, names.FORCE) for name in driven]),
            angles=columns([names.angle_sensor(hinge.name) for hinge in by_dof]),
            tip_position=columns([names.TIP_POSITION]),
            tip_orientation=columns([names.TIP_ORIENTATION]),
            base_pose=columns(_base_sensors(arm, in_world)),
            host=columns(_host_sensors(model, arm, in_world)),
            joints=rows(np.array([model.joint(hinges[i].name).id for i in np.argsort(order)])),
            qpos=rows(np.array([model.joint(hinges[i].name).qposadr[0] for i in np.argsort(order)])),
            dofs=rows(np.sort(order)),
            states=_states(model, _actuators(model, muscles)),
            touch=_felt(columns, arm, names.TOUCH, 7, in_world),
            depth=_felt(columns, arm, names.DEPTH, 7, in_world),
            poses=columns([
                names.sensor(name, quantity) for name in (arm.world.movable if in_world else [])
                for quantity in (names.POSITION, names.ORIENTATION)
            ]).reshape(-1, 7),
            zero=_frozen([counted_from(group) for group in arm.groups for _ in range(group.routing.count)]),
            by_angle=_frozen([
                [coefficient(group, muscle, hinge) for hinge in by_dof]
                for group in arm.groups for muscle in range(group.routing.count)
            ]).reshape(len(muscles), len(hinges)),
            straight=np.array(
                [group.routing.path == "spans" for group in arm.groups for _ in range(group.routing.count)], dtype=bool
            ),
        )  # fmt: skip


class _Columns:
    """Finds the columns of sensors in the engine's sensor data."""

    def __init__(self, model: mujoco.MjModel) -> None:
        self._model = model

    def __call__(self, sensors: list[str]) -> Indices:
        found = [self._model.sensor(name) for name in sensors]
        every = [np.arange(one.adr[0], one.adr[0] + one.dim[0]) for one in found]
        return np.concatenate([np.zeros(0, dtype=int), *every])


def _felt(columns: _Columns, arm: Arm, felt: str, width: int, in_world: bool) -> Indices:
    """Return the columns of the sensors of what stations feel of what the arm can touch, shape (P, K, width)."""
    stations, partners = names.stations(arm), names.partners(arm) if in_world else []
    found = columns([names.touch_sensor(station, partner, felt) for partner in partners for station in stations])
    return found.reshape(len(partners), len(stations), width)


def _base_sensors(arm: Arm, in_world: bool) -> list[str]:
    """Return the sensors of where the base is in a host."""
    hosted = in_world and arm.world.host is not None
    return [names.sensor(names.BASE, what) for what in (names.POSITION, names.ORIENTATION)] if hosted else []


def _host_sensors(model: mujoco.MjModel, arm: Arm, in_world: bool) -> list[str]:
    """Return the sensors of the positions of a host's own joints, as they come in the engine's."""
    if not in_world or arm.world.host is None:
        return []
    free = model.jnt_type == mujoco.mjtJoint.mjJNT_FREE
    return [name for i in range(model.njnt) for name in names.host_sensors(arm, model.joint(i).name, bool(free[i]))]


def _states(model: mujoco.MjModel, actuators: Indices) -> slice:
    """Return which of the engine's actuator states are those of these actuators."""
    adr = model.actuator_actadr[actuators.ravel()]
    return rows(adr[adr >= 0])


def rows(indices: Indices) -> slice:
    """Return indices that follow one another as a slice, whose selections are views that stay current.

    Raises:
        ValueError: they do not.
    """
    first = int(indices[0]) if len(indices) else 0
    if not np.array_equal(indices, np.arange(first, first + len(indices))):
        raise ValueError(f"parts of the arm do not follow one another in the model: {indices.tolist()}")
    return slice(first, first + len(indices))


def _actuators(model: mujoco.MjModel, muscles: list[str]) -> Indices:
    """Return the actuators of the muscles, shape (R, M), the first of each muscle in the first row."""
    if not model.nu:
        return np.zeros((0, len(muscles)), dtype=int)
    by_tendon = model.actuator_trntype == mujoco.mjtTrn.mjTRN_TENDON
    pulled = [
        model.tendon(int(number)).name if tendon else ""
        for number, tendon in zip(model.actuator_trnid[:, 0], by_tendon, strict=True)
    ]
    return np.stack([np.flatnonzero([name == muscle for name in pulled]) for muscle in muscles], axis=1)


def _sites(model: mujoco.MjModel, arm: Arm, muscles: int) -> Indices:
    stations, starts = names.stations(arm), names.section_stations(arm)
    sites = np.full((len(stations), muscles), -1)
    for group, columns in zip(arm.groups if muscles else (), tuple(slices(arm)), strict=False):
        if group.routing.path == "spans":
            for station in range(starts[group.first], starts[group.section + 1] + 1):
                guides = [names.guide(stations[station], name) for name in names.group_muscles(arm, group)]
                sites[station, columns] = [model.site(guide).id for guide in guides]
    return sites


def _frozen(values: list[float] | list[list[float]]) -> Array:
    array = np.array(values, dtype=float)
    array.setflags(write=False)
    return array
