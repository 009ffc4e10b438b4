"""What a user's own MJCF says: its sites and bodies where they are at the start, its gravity and step, what touches."""

from __future__ import annotations

import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from functools import lru_cache
from itertools import count
from pathlib import Path
from threading import Lock
from typing import TYPE_CHECKING, Any

from contarm_sim import libmujoco
from contarm_sim.errors import InputError, one_line
from contarm_sim.model.host_stamps import Stamp, stamps
from contarm_sim.model.parameters import Quaternion, Vector

if TYPE_CHECKING:
    import mujoco

TOUCHES = 1
"""Bit of conaffinity of the geoms that the arm's links touch."""

_NEEDED = ("ACTUATION", "CONTACT", "SENSOR", "SPRING", "DAMPER", "CLAMPCTRL")
"""What the arm does not work, or does not touch, without."""

_LEAST_IMPRATIO = 100.0
"""Least `impratio` at which an arm of 2 N on a wall keeps 80 % of its friction for a second; at 30 it is half, at 1,
and under pyramidal cones, nothing. Under `implicitfast` its contact buzzes."""

HOLDING = '<option integrator="Euler" cone="elliptic" impratio="300"><flag eulerdamp="disable"/></option>'
"""Options under which friction holds."""

_lock = Lock()


@dataclass(frozen=True)
class Place:
    """Where a site or a body is in the world at the start.

    Attributes:
        body: of a site, its body; of a body, itself.
        position: [m].
        quaternion: w x y z.
        moves: whether joints move it.
    """

    body: str
    position: Vector
    quaternion: Quaternion
    moves: bool


@dataclass(frozen=True)
class Key:
    """A keyframe: what the engine starts from."""

    name: str
    qpos: tuple[float, ...]
    qvel: tuple[float, ...]
    act: tuple[float, ...]
    ctrl: tuple[float, ...]
    mpos: tuple[float, ...]
    mquat: tuple[float, ...]


@dataclass(frozen=True)
class HostFile:
    """What a file says, compiled by itself.

    Attributes:
        gravity: in the world [m/s^2].
        timestep: [s].
        sites, bodies: those with names.
        touched: the bodies with geoms that the arm's links touch; those without a name by their number.
        keys: its keyframes; where it has none, one that is what the engine starts from.
        holds: whether friction holds under its options what rests; else it creeps away within a second, or buzzes.
        ends: positions and velocities in the engine's arrays before what is attached to a body, by its name.
    """

    gravity: Vector
    timestep: float
    sites: dict[str, Place]
    bodies: dict[str, Place]
    touched: tuple[str, ...]
    keys: tuple[Key, ...]
    holds: bool
    ends: dict[str, tuple[int, int]]


def host_file(file: str) -> HostFile:
    """Return what a file says; read anew where it, or a file that it includes, has changed.

    Raises:
        InputError: MuJoCo does not take it, or has options under which the arm cannot be simulated.
    """
    return _read(file, stamps(file))


def opened(file: str) -> mujoco.MjSpec:
    """Return a file as a spec whose bodies and joints all have names.

    Raises:
        InputError: MuJoCo does not take it.
    """
    libmujoco.load()
    import mujoco

    try:
        with quiet():
            spec = mujoco.MjSpec.from_file(file)
    except (ValueError, UnicodeDecodeError) as error:
        raise _refused(file, error) from None
    for kind, every in (("body", spec.bodies), ("joint", spec.joints)):
        taken = {part.name for part in every}
        for number, part in enumerate(every):
            if not part.name:
                free = (f"{kind}_{more}" for more in count(number))
                part.name = next(name for name in free if name not in taken)
                taken.add(part.name)
    return spec


@contextmanager
def quiet() -> Iterator[None]:
    """Keep the engine from warning of a file in Python's warnings and in MUJOCO_LOG.TXT: it is as its user wrote it."""
    import mujoco

    with _lock, warnings.catch_warnings():
        warnings.simplefilter("ignore")
        before = mujoco.get_mju_user_warning()
        mujoco.set_mju_user_warning(_ignore)
        try:
            yield
        finally:
            mujoco.set_mju_user_warning(before)


def _ignore(message: str) -> None:
    pass


def rotated(vector: Vector, by: Quaternion) -> Vector:
    """Return a vector turned by a quaternion."""
    x, y, z = vector
    w, a, b, c = by
    u, v, t = 2 * (b * z - c * y), 2 * (c * x - a * z), 2 * (a * y - b * x)
    return x + w * u + b * t - c * v, y + w * v + c * u - a * t, z + w * t + a * v - b * u


def turned_back(vector: Vector, by: Quaternion) -> Vector:
    """Return a vector in the frame that a quaternion turns to."""
    w, a, b, c = by
    return rotated(vector, (w, -a, -b, -c))


def _refused(file: str, error: Exception) -> InputError:
    said = one_line(" ".join(str(error).split()), 150)
    return InputError("world", f"{Path(file).name!r}, which MuJoCo does not take", f"MJCF that compiles ({said})")


@lru_cache(maxsize=16)
def _read(file: str, written: tuple[Stamp, ...]) -> HostFile:
    spec = opened(file)
    import mujoco

    try:
        with quiet():
            model = spec.compile()
    except ValueError as error:
        raise _refused(file, error) from None
    _check_options(spec, model)
    data = mujoco.MjData(model)
    if model.nkey:
        mujoco.mj_resetDataKeyframe(model, data, 0)
    mujoco.mj_kinematics(model, data)

    def place(body: int, position: Any, rotation: Any) -> Place:
        import numpy as np

        quaternion = np.zeros(4)
        mujoco.mju_mat2Quat(quaternion, rotation)
        x, y, z = position.tolist()
        w, a, b, c = quaternion.tolist()
        return Place(model.body(body).name, (x, y, z), (w, a, b, c), bool(model.body_weldid[body]))

    names = [model.body(body).name for body in range(model.nbody)]
    off = mujoco.mjtDisableBit
    gravity = (0.0, 0.0, 0.0) if model.opt.disableflags & off.mjDSBL_GRAVITY else tuple(model.opt.gravity.tolist())
    touching = {int(model.geom_bodyid[geom]) for geom in range(model.ngeom) if model.geom_conaffinity[geom] & TOUCHES}
    return HostFile(
        gravity=gravity,
        timestep=float(model.opt.timestep),
        sites={
            model.site(i).name: place(int(model.site_bodyid[i]), data.site_xpos[i], data.site_xmat[i])
            for i in range(model.nsite)
            if model.site(i).name
        },
        bodies={name: place(i, data.xpos[i], data.xmat[i]) for i, name in enumerate(names)},
        touched=tuple(names[body] for body in sorted(touching)),
        keys=tuple(_keys(model, data)),
        holds=bool(
            model.opt.cone == mujoco.mjtCone.mjCONE_ELLIPTIC
            and model.opt.impratio >= _LEAST_IMPRATIO
            and model.opt.integrator == mujoco.mjtIntegrator.mjINT_EULER
        ),
        ends={name: _end(model, body) for body, name in enumerate(names)},
    )


def _check_options(spec: mujoco.MjSpec, model: mujoco.MjModel) -> None:
    """Refuse what the arm cannot be simulated under, as the options of a host stay as they are.

    Raises:
        InputError: says what to change.
    """
    import mujoco

    if model.opt.integrator == mujoco.mjtIntegrator.mjINT_RK4:
        allowed = "Euler, implicit or implicitfast, in <option integrator=...>: under RK4 the arm's muscles diverge"
        raise InputError("world's integrator", "RK4", allowed)
    if spec.compiler.fusestatic:
        raise InputError("world's fusestatic", "true", "false, in <compiler>: the arm's base is a body of its own")
    for name in _NEEDED:
        if model.opt.disableflags & getattr(mujoco.mjtDisableBit, f"mjDSBL_{name}"):
            raise InputError(f"world's flag {name.lower()}", "disabled", "enabled, in <option><flag>: the arm needs it")


def _keys(model: mujoco.MjModel, data: mujoco.MjData) -> list[Key]:
    fields = ("qpos", "qvel", "act", "ctrl", "mpos", "mquat")
    if not model.nkey:
        now = (data.qpos, data.qvel, data.act, data.ctrl, data.mocap_pos, data.mocap_quat)
        return [Key("start", *(tuple(each.ravel().tolist()) for each in now))]
    return [
        Key(model.key(i).name, *(tuple(getattr(model, f"key_{name}")[i].ravel().tolist()) for name in fields))
        for i in range(model.nkey)
    ]


def _end(model: mujoco.MjModel, body: int) -> tuple[int, int]:
    """Return how many positions and velocities come before what is attached to a body, after all that it carries."""
    last = body
    for other in range(body + 1, model.nbody):
        if not last >= int(model.body_parentid[other]) >= body:
            break
        last = other
    joint = int((model.jnt_bodyid <= last).sum())  # the first after
    if joint == model.njnt:
        return int(model.nq), int(model.nv)
    return int(model.jnt_qposadr[joint]), int(model.jnt_dofadr[joint])
