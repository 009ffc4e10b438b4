"""What overlaps where an arm begins: links and objects inside of one another, which contact would throw apart."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import mujoco
import numpy as np

from contarm_sim.errors import InputError
from contarm_sim.mjcf import names
from contarm_sim.model.arm import Arm
from contarm_sim.model.objects import Object, said_of_object

STRAIGHT = "where the arm is straight"
"""When what begins without a bend begins."""

MOST = 1e-4
"""How deep bodies may overlap at first [m]: about as deep as what rests, far from what throws a link."""


@dataclass(frozen=True)
class Overlap:
    """Two bodies that overlap, by name, and how deep [m]."""

    body: str
    other: str
    depth: float


def overlaps(model: mujoco.MjModel, data: mujoco.MjData, own: set[str] | None = None) -> list[Overlap]:
    """Return the bodies that overlap by more than `MOST` in a state whose contacts are found, the deepest first.

    Bodies that do not move, objects or the base, may overlap one another.

    Args:
        own: bodies of which one must be one; default any.
    """
    contact, deepest = data.contact, dict[tuple[int, int], float]()
    for pair, distance in zip(np.asarray(contact.geom).tolist(), np.asarray(contact.dist).tolist(), strict=True):
        one, other = sorted(int(model.geom_bodyid[geom]) for geom in pair)
        deepest[one, other] = max(deepest.get((one, other), 0.0), -distance)
    found = [Overlap(model.body(b).name, model.body(a).name, depth) for (a, b), depth in deepest.items()]
    found = [each for each in found if each.depth > MOST and (own is None or own & {each.body, each.other})]
    return sorted(found, key=lambda each: -each.depth)


def refuse_overlaps(arm: Arm, model: mujoco.MjModel, data: mujoco.MjData, when: str) -> None:
    """Refuse links and objects that overlap in a state whose contacts are found.

    Args:
        when: what begins there, for the message: "where the motion starts", or `STRAIGHT`, which has no other bends.

    Raises:
        InputError: the deepest overlap: of what, how deep, and what would help.
    """
    stations = names.stations(arm)  # bodies of a host may overlap one another as they like
    found = overlaps(model, data, {*stations, *(each.name for each in arm.world.objects)})
    if not found:
        return
    objects = {each.name: each for each in arm.world.objects}
    one, other = found[0].body, found[0].other
    if one not in objects or (other in objects and objects[other].free and not objects[one].free):
        one, other = other, one
    deep = f"{float(f'{1e3 * found[0].depth:.3g}'):g} mm deep in {_said(other, objects)}"
    most = f"at most {1e3 * MOST:g} mm {when}"
    every = f" (the deepest of {len(found)} overlaps)" if len(found) > 1 else ""
    bends = [] if when == STRAIGHT or other in objects else ["begin with other bends"]
    if one not in objects and not {one, other} <= set(stations):
        ways = ["mount the arm elsewhere", *bends, "move that body"]
        raise InputError("world", f"one that puts {_said(one, objects)} {deep}", f"{most}: {_either(ways)}{every}")
    if one not in objects:
        ways = [*bends, "leave self-contact out"]
        raise InputError("self_contact", f"on, with {_said(one, objects)} {deep}", f"{most}: {_either(ways)}{every}")
    place = ", ".join(f"{x:.6g}" for x in objects[one].position)
    allowed = f"{most}: {_either([*_help(objects[one]), *bends])}{every}"
    raise InputError("position", f"({place}) m, which puts it {deep}", allowed, said_of_object(one))


def _either(ways: list[str]) -> str:
    """Return what may be done, of which any is enough."""
    return ", or ".join([", ".join(ways[:-1]), ways[-1]] if len(ways) > 1 else ways)


def _help(each: Object) -> list[str]:
    """Return what would help an object that overlaps something."""
    if each.shape == "plane":
        return ["move it", "turn its axis around (what is behind a plane is inside)"]
    return ["move it", "make it smaller" + (" (meshes touch as their convex hulls)" if each.shape == "mesh" else "")]


def _said(name: str, objects: Mapping[str, Object]) -> str:
    return said_of_object(name) if name in objects else "the base" if name == names.BASE else name
