"""The static pose of an arm that may lean on objects."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from contarm_sim.engine.plant import Plant
from contarm_sim.errors import ContarmError, EquilibriumError, InputError, NotConvergedError
from contarm_sim.kinematics.arrays import Array
from contarm_sim.mechanics.shape import stations
from contarm_sim.model.arm import Arm
from contarm_sim.statics.continuation import SIDE, Method, solve
from contarm_sim.statics.descent import descend
from contarm_sim.statics.failures import unsettled, unstable
from contarm_sim.statics.leaning.leaning import GAP, STRIDE, Leaning
from contarm_sim.statics.leaning.pressed import free
from contarm_sim.statics.leaning.surroundings import Surroundings
from contarm_sim.statics.leaning.touch import HeldObject, Touch
from contarm_sim.statics.solver import Solution, Solver
from contarm_sim.statics.stability import growth

OFF_SADDLES = 5
"""Most saddles that a search leaves."""

SIDES = (1.0, -1.0)
"""Where else a search starts that has not come to rest: bent towards +X, and towards -X."""

TRUSTED = 0.25
"""Largest range of friction that the first order tells [lengths]."""

AGAIN = 3
"""Most searches again, where what lay flat on an object does so no more."""

RING = 24
"""Places looked at about the base plate's edge."""

SAME = 1e-3
"""Contacts on one object are one that are nearer to each other than this [lengths]."""


@dataclass(frozen=True)
class Leant:
    """How an arm leans.

    Attributes:
        solution: as of an arm alone; the stiffness is that among changes that keep contacts closed.
        contacts: where it leans.
        compliance: of the tip, contacts closed, shape (6, 6), see `Equilibrium`.
        friction_range: see `Equilibrium`.
        held_objects: the free objects.
    """

    solution: Solution
    contacts: tuple[Touch, ...]
    compliance: Array
    friction_range: float | None
    held_objects: tuple[HeldObject, ...]

    @property
    def more(self) -> dict[str, Any]:
        """What `Equilibrium` has of an arm among objects alone."""
        return {name: getattr(self, name) for name in ("contacts", "friction_range", "held_objects")}


def lean(solver: Solver, arm: Arm, surroundings: Surroundings, method: Method, guessed: bool) -> Leant:
    """Bring a solver's plant, which is the arm alone, to rest among the arm's objects.

    Where the way from the start to the pose of the arm alone is clear of objects, it is that pose, to the bit.

    Args:
        guessed: whether to start at the plant's present pose; else from the straight arm, or from that pose where the
            straight arm overlaps an object.

    Raises:
        EquilibriumError: no equilibrium was reached, or the arm cannot be brought clear of an object; says which.
        InputError: the arm is too thick to have a round tip.
    """
    plant = solver.plant
    planned = plant.data.qpos.copy()
    if surroundings.radii[-1] >= 0.5 * arm.length:
        raise InputError(
            "contact_radius", float(surroundings.radii[-1]), f"below half the arm's length, {0.5 * arm.length:g} m"
        )
    _clear_of_base(arm, surroundings, plant)
    leaning = Leaning(solver, surroundings, arm.length * stations(arm))
    start = planned
    if not guessed:
        plant.data.qpos[:] = 0
        plant.pose()
        leaning.look()
        start = planned if leaning.overlaps else 0 * planned
    plant.data.qpos[:] = planned
    found, alone = _alone(solver, method)
    if found is not None and _clear(leaning, start, alone):
        plant.data.qpos[:] = alone
        solver.evaluate()
        return Leant(found, (), solver.tip_compliance(), None, _held(arm, ()))
    plant.data.qpos[:] = start
    return _among(leaning, arm)


def _clear_of_base(arm: Arm, surroundings: Surroundings, plant: Plant) -> None:
    """Check that no object overlaps the base plate, which does not give way."""
    ring = 2 * np.pi * np.arange(RING) / RING
    disc = np.stack([np.cos(ring), np.sin(ring), 0 * ring], axis=1) * surroundings.radii[0]
    for number, each in enumerate(surroundings.objects):
        depth = -float(surroundings.distances(number, np.concatenate([np.zeros((1, 3)), 0.5 * disc, disc]))[0].min())
        if depth > GAP * arm.length:
            raise NotConvergedError(
                f"object {each.name!r} overlaps the arm's base by {1e3 * depth:.3g} mm; another place would help",
                depth, GAP * arm.length, pose=plant.data.qpos.copy(), residual=float("nan"),
            )  # fmt: skip


def _alone(solver: Solver, method: Method) -> tuple[Solution | None, Array]:
    """Return the solution of the arm alone and its joint angles [rad]; None where it has none."""
    try:
        found = solve(solver, method)
    except InputError:
        raise
    except ContarmError:
        return None, solver.plant.data.qpos
    return found, solver.plant.data.qpos.copy()


def _clear(leaning: Leaning, start: Array, end: Array) -> bool:
    """Whether the arm overlaps no object on the way between two poses."""
    plant = leaning.solver.plant
    places = []
    for pose in (start, end):
        plant.data.qpos[:] = pose
        plant.pose()
        places.append(plant.stations)
    way = float(np.linalg.norm(places[1] - places[0], axis=1).max())
    count = 1 + int(np.ceil(way / (0.5 * STRIDE * leaning.tube.length)))
    for share in np.linspace(1.0, 0.0, count + 1):
        plant.data.qpos[:] = start + share * (end - start)
        plant.pose()
        leaning.look(0.0)
        if leaning.overlaps:
            return False
    return True


def _among(leaning: Leaning, arm: Arm) -> Leant:
    """Go down from the present pose, contacts and all."""
    solver = leaning.solver
    data = solver.plant.data
    solver.iterations = 0
    start = data.qpos.copy()
    residual, stable = _down(leaning)
    for side in SIDES:  # a straight arm has no way to give way
        if residual <= leaning.tolerance:
            break
        data.qpos[:] = start + side * SIDE / arm.links * (solver.plant.model.jnt_axis[:, 1] > 0.5)
        residual, stable = _down(leaning)
    for _ in range(OFF_SADDLES):
        if stable or residual > leaning.tolerance:
            break
        mode = leaning.softest_mode()
        data.qpos += SIDE * mode / np.abs(mode).sum()
        residual, stable = _down(leaning)
    residual = leaning.evaluate()
    if residual > leaning.tolerance:
        raise _unsettled(leaning, residual)
    leaning.linearise()
    softest = leaning.softest()
    if not stable or softest <= 0:
        raise unstable(solver.plant, softest)
    residual = float(np.abs(solver.forces + leaning.press @ leaning.slopes).max())
    grows = growth(solver, leaning.stiffness, free(leaning.pressing))
    contacts = _touches(leaning)
    J = solver.plant.tip_jacobian()
    return Leant(
        solution=Solution(residual, softest, grows, solver.iterations),
        contacts=contacts,
        compliance=J @ leaning.compliance() @ J.T,
        friction_range=_friction_range(leaning, arm, J[:3]) if contacts else None,
        held_objects=_held(arm, contacts),
    )


def _down(leaning: Leaning) -> tuple[float, bool]:
    """Go down to rest; return what is left [N m] and whether that is a minimum."""
    residual, stable = descend(leaning, leaning.solver.steps)
    for _ in range(AGAIN):
        if residual > leaning.tolerance or not leaning.forget():
            break
        residual, stable = descend(leaning, leaning.solver.steps)
    return residual, stable


def _unsettled(leaning: Leaning, residual: float) -> EquilibriumError:
    """Return why no rest was found: an object that the arm cannot be clear of, or as of an arm alone."""
    deepest, length = leaning.deepest, leaning.tube.length
    plant = leaning.solver.plant
    if deepest <= 1e3 * GAP * length:
        return unsettled(plant, residual, leaning.tolerance, leaning.solver.iterations)
    near = min(leaning.nears, key=lambda each: each.gap)
    name = leaning.surroundings.objects[near.number].name
    allowed = GAP * length
    return NotConvergedError(
        f"the arm overlaps object {name!r} by {1e3 * deepest:.3g} mm at {near.place.along / length:.2g} of its length, "
        "and the search did not bring it clear; another place of the object, or a guess beside it, would help",
        deepest,
        allowed,
        pose=plant.data.qpos.copy(),
        load_fraction=1.0,
        residual=residual,
    )


def _touches(leaning: Leaning) -> tuple[Touch, ...]:
    """Return the contacts that press; those at one place are one."""
    found: list[Touch] = []
    length = leaning.tube.length
    for near, force in zip(leaning.nears, leaning.press, strict=True):
        if force <= 0:
            continue
        name, friction = (getattr(leaning.surroundings.objects[near.number], what) for what in ("name", "friction"))
        touch = Touch(
            name, near.place.station, near.place.along / length, near.point, near.normal, float(force), near.gap,
            friction,
        )  # fmt: skip
        for place, other in enumerate(found):
            if other.object == name and np.linalg.norm(other.point - touch.point) < SAME * length:
                total = other.force + touch.force
                point = (other.force * other.point + touch.force * touch.point) / total
                found[place] = replace(other, point=point, force=total)
                break
        else:
            found.append(touch)
    return tuple(found)


def _friction_range(leaning: Leaning, arm: Arm, J: Array) -> float:
    """Return how far friction can hold the tip from here at most, to the first order [m].

    At each contact any force across the normal up to friction times the contact force may act; the tip gives way to it
    by the compliance with contacts closed. The worst directions are added up. Infinite where that comes to more than
    `TRUSTED`.
    """
    chain, C, total = leaning.chain, leaning.compliance(), 0.0
    for near, force in zip(leaning.nears, leaning.press, strict=True):
        if force > 0:
            across = np.eye(3) - np.outer(near.normal, near.normal)
            moved = J @ C @ (across @ chain.surface_motion(near)).T
            total += leaning.surroundings.objects[near.number].friction * force * float(np.linalg.svd(moved)[1][0])
    return total if total < TRUSTED * arm.length else float("inf")


def _held(arm: Arm, contacts: tuple[Touch, ...]) -> tuple[HeldObject, ...]:
    """Return what it takes to hold the free objects."""
    found = []
    for each in arm.world.objects:
        if each.mass is not None:
            force = -each.mass * np.array(arm.gravity)
            for touch in contacts:
                force = force + touch.force * touch.normal * (touch.object == each.name)
            found.append(HeldObject(each.name, force))
    return tuple(found)
