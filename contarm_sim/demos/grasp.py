"""Grasp: the arm curls round a log, lifts it, and puts it down."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import mujoco
import numpy as np

from contarm_sim.demos.curl import Curl, reference_of_curl
from contarm_sim.demos.demonstration import STEP, Demonstration, OnTick, Requirement
from contarm_sim.demos.grasp_script import END, LIFTED, LOWERING, bends_at, grasp_arm
from contarm_sim.engine.plant import Plant
from contarm_sim.kinematics.arrays import Array
from contarm_sim.kinematics.inverse.rotations import rotation_from_quaternion
from contarm_sim.model.arm import Arm
from contarm_sim.motion.simulate import CONTROL_RATE, Stepping, simulate
from contarm_sim.results.trajectory import Trajectory

OFF = 0.01
"""Height [m] from which on the log is off its forks."""


def demonstrate(on_tick: OnTick | None = None) -> Demonstration:
    """Simulate the grasp, and measure what the log does."""
    motion = run(grasp_arm(), None if on_tick is None else lambda done: on_tick(done, count()))
    found = checks(motion)
    assert motion.contacts is not None
    top = motion.contacts.at(round(0.5 * (LIFTED + LOWERING) * CONTROL_RATE))
    said = (
        f"{len(np.unique(top.station))} links hold the log, {1e3 * found[0].value:.0f} mm above its forks; "
        f"their normal forces add up to {top.normal_force.sum():.0f} N"
    )
    return Demonstration(motion, found, said, camera=(-85.0, 5.0), size=(720, 1000))


def run(arm: Arm, on_tick: Callable[[int], object] | None = None) -> Trajectory:
    """Return the motion of an arm such as `grasp_arm` returns."""
    time = np.arange(count()) / CONTROL_RATE
    bend = bends_at(time)
    reference = reference_of_curl(bend, arm, time)
    return simulate(arm, reference, Curl(bend), stepping=Stepping(STEP), on_tick=on_tick)


def count() -> int:
    """Return how many samples the motion has."""
    return round(END * CONTROL_RATE) + 1


def checks(run: Trajectory) -> list[Requirement]:
    """Return what the motion must show of log and arm: lifted, carried, not slipped, put down, by tendons that can."""
    assert run.objects is not None
    assert run.contacts is not None
    log, time = run.objects[:, 0], run.time
    height = log[0, 2] - log[:, 2]  # +Z points down
    top = (time >= LIFTED) & (time <= LOWERING)
    weight = run.arm.world.objects[0].mass * run.arm.gravity[2]  # type: ignore[operator]
    pressed = run.contacts.where(run.contacts.partner == 0)
    carried = np.bincount(pressed.sample, pressed.force[:, 2], minlength=len(run))[top].mean()
    slipped, turned = slip(run)
    axes = rotation_from_quaternion(log[[0, -1], 3:])[:, :, 2]
    winches = min(group.law.blocked_force for group in run.arm.groups)
    return [
        Requirement(
            "height of the log over its forks, while it is up", float(height[top].min()), 0.06, "m", least=True
        ),
        Requirement(
            "weight carried, difference from the log's weight", 100 * float(abs(carried / weight - 1)), 5.0, "%"
        ),
        Requirement("slip in the grip", slipped, 0.005, "m"),
        Requirement("turn in the grip", turned, np.radians(5), "rad"),
        Requirement("deepest contact of a link", float(run.contacts.depth.max(initial=0.0)), 0.0005, "m"),
        Requirement(
            "put down, distance from where it lay", float(np.linalg.norm(log[-1, :3] - log[0, :3])), 0.005, "m"
        ),
        Requirement("put down, angle to how it lay", _apart(*axes), np.radians(5), "rad"),
        Requirement("highest tension of a tendon", float(run.muscle_tensions.max()), winches, "N"),
    ]


def slip(run: Trajectory) -> tuple[float, float]:
    """Return how far the log moves [m] and how much it turns [rad] while it is held, as seen from the link under it."""
    assert run.objects is not None
    assert run.contacts is not None
    log = run.objects[:, 0]
    held = np.flatnonzero(log[0, 2] - log[:, 2] > OFF)
    if not len(held):
        return np.inf, np.inf
    pressed = run.contacts.where((run.contacts.partner == 0) & np.isin(run.contacts.sample, held))
    if not len(pressed):
        return np.inf, np.inf
    forces = np.bincount(pressed.station, pressed.force[:, 2])
    places, turns = _link_poses(run.arm, run.qpos[held], int(forces.argmax()))
    seen = np.einsum("tji,tj->ti", turns, log[held, :3] - places)
    axes = np.einsum("tji,tjk->tik", turns, rotation_from_quaternion(log[held, 3:]))
    moved = np.linalg.norm(seen - seen[0], axis=1).max()
    trace = np.einsum("tij,ij->t", axes, axes[0])
    return float(moved), float(np.arccos(np.clip((trace - 1) / 2, -1, 1)).max())


def varied(arm: Arm, seed: int, share: float = 0.2) -> Arm:
    """Return the arm with another log: mass, friction and start are off by up to a share of them, drawn evenly.

    The start is off by a share of the log's radius in X, Y and Z; the forks are where it lies.
    """
    draw = np.random.default_rng(seed)
    mass, friction = 1 + share * draw.uniform(-1, 1, 2)
    log = arm.world.objects[0]
    assert log.mass is not None
    assert log.radius is not None
    off = share * log.radius * draw.uniform(-1, 1, 3)
    other = replace(log, mass=log.mass * mass, friction=log.friction * friction, position=_moved(log.position, off))
    forks = [replace(fork, position=_moved(fork.position, off * [1, 0, 1])) for fork in arm.world.objects[1:]]
    return arm.in_world(replace(arm.world, objects=(other, *forks)))


def _moved(position: tuple[float, float, float], off: Array) -> tuple[float, float, float]:
    x, y, z = (np.array(position) + off).tolist()
    return x, y, z


def _link_poses(arm: Arm, qpos: Array, station: int) -> tuple[Array, Array]:
    """Return places [m], shape (T, 3), and orientations, shape (T, 3, 3), of the link at a station.

    Args:
        qpos: joint angles [rad], shape (T, dofs).
        station: counted from the base, 0 to the number of links.
    """
    plant = Plant(arm.alone)
    places, turns = np.empty((len(qpos), 3)), np.empty((len(qpos), 3, 3))
    for row, angles in enumerate(qpos):
        plant.data.qpos[:] = angles
        mujoco.mj_kinematics(plant.model, plant.data)
        places[row], turns[row] = plant.centres[station], plant.rotations[station]
    return places, turns


def _apart(one: Array, other: Array) -> float:
    """Return the angle [rad] between two unit vectors."""
    return float(np.arctan2(np.linalg.norm(np.cross(one, other)), one @ other))
