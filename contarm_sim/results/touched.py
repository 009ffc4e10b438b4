"""What the arm touched in numbers, as a whole and object by object."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from contarm_sim.kinematics.arrays import Array
from contarm_sim.mechanics.contacts import Contacts
from contarm_sim.model.objects import ITSELF
from contarm_sim.results.document import shown_if
from contarm_sim.results.trajectory import Trajectory

_FAINT = 0.02
"""Normal force, over the largest one, below which nothing is said of friction: it is of no weight there."""


@dataclass(frozen=True)
class TouchedObject:
    """What the arm had to do with one object.

    Attributes:
        name: of the object, or `itself`.
        samples: in how many samples they touched.
        first_touch_s: when they first did [s]; None: never.
        longest_touch_s: the longest time that they touched without a break [s].
        largest_force_n: size of the largest force of the object on the arm in a sample, links added up [N]. Of
            the arm and itself, whose forces cancel: the largest sum of their sizes, each once.
        largest_depth_m: how far link and object overlapped at most [m].
        links: how many links touched it in all.
        friction_used: largest friction force over what friction could give at that normal force [-]; 1 slides. Where
            a link touches in several places, their sum is held against the normal of the deepest. None where it never
            bore any load, and of the arm and itself.
        moved_m: how far a free object was at most from where it began [m]; of free objects only.
    """

    name: str
    samples: int
    first_touch_s: float | None
    longest_touch_s: float
    largest_force_n: float
    largest_depth_m: float
    links: int
    friction_used: float | None
    moved_m: float | None = field(default=None, metadata=shown_if(lambda one: one.moved_m is not None))


@dataclass(frozen=True)
class ContactSummary:
    """What the arm touched.

    Attributes:
        contacts: how many there are in all samples; all of a link with an object in a sample are one, and of two links
            that touch each other both count.
        samples: in how many samples there is contact.
        most_links: the most links that touched something at once.
        largest_force_n: largest sum of the sizes of all contact forces of a sample [N], and its time [s].
        largest_depth_m: how far link and object overlapped at most [m].
        objects: one by one, touched or not.
    """

    contacts: int
    samples: int
    most_links: int
    largest_force_n: float
    largest_force_at_s: float | None
    largest_depth_m: float
    objects: tuple[TouchedObject, ...]


def touched(trajectory: Trajectory) -> ContactSummary | None:
    """Return what an arm touched; None where it can touch nothing, and for poses at rest."""
    found = trajectory.contacts
    if found is None:
        return None
    total = found.total(len(trajectory))
    pairs = np.unique(np.stack([found.sample, found.station], axis=1), axis=0)
    return ContactSummary(
        contacts=len(found),
        samples=len(np.unique(found.sample)),
        most_links=int(np.bincount(pairs[:, 0]).max(initial=0)),
        largest_force_n=float(total.max(initial=0.0)),
        largest_force_at_s=float(trajectory.time[total.argmax()]) if len(found) else None,
        largest_depth_m=max(float(found.depth.max(initial=0.0)), 0.0),
        objects=tuple(_of(trajectory, found, place) for place in range(len(found.names))),
    )


def object_forces(contacts: Contacts, samples: int) -> Array:
    """Return the forces of P objects on the arm [N], links added up, shape (samples, P, 3)."""
    forces = np.zeros((samples, len(contacts.names), 3))
    np.add.at(forces, (contacts.sample, contacts.partner), contacts.force)
    return forces


def object_force_sizes(contacts: Contacts, samples: int) -> Array:
    """Return the sizes of the forces of P objects on the arm [N], as `TouchedObject` has them, shape (samples, P)."""
    sizes = np.linalg.norm(object_forces(contacts, samples), axis=2)
    if ITSELF in contacts.names:
        place = contacts.names.index(ITSELF)
        sizes[:, place] = contacts.where(contacts.partner == place).total(samples)
    return sizes


def link_forces(contacts: Contacts, samples: int, stations: int) -> Array:
    """Return the sums of the sizes of the contact forces on each link [N], shape (samples, stations)."""
    forces = np.zeros((samples, stations))
    np.add.at(forces, (contacts.sample, contacts.station), np.linalg.norm(contacts.force, axis=1))
    return forces


def object_depths(contacts: Contacts, samples: int) -> Array:
    """Return how far links and each of P objects overlap [m], 0 where they do not touch, shape (samples, P)."""
    depths = np.zeros((samples, len(contacts.names)))
    np.maximum.at(depths, (contacts.sample, contacts.partner), contacts.depth)
    return depths


def _of(trajectory: Trajectory, every: Contacts, place: int) -> TouchedObject:
    """Return what the arm had to do with the object of a place among the names."""
    own, time, count = every.where(every.partner == place), trajectory.time, len(trajectory)
    touching = np.zeros(count, dtype=bool)
    touching[own.sample] = True
    forces = object_force_sizes(own, count)[:, place]
    return TouchedObject(
        name=every.names[place],
        samples=int(touching.sum()),
        first_touch_s=float(time[touching.argmax()]) if len(own) else None,
        longest_touch_s=_longest(touching, time),
        largest_force_n=float(forces.max(initial=0.0)),
        largest_depth_m=max(float(own.depth.max(initial=0.0)), 0.0),
        links=len(np.unique(own.station)),
        friction_used=_friction(trajectory, own),
        moved_m=_moved(trajectory, every.names[place]),
    )


def _longest(touching: NDArray[np.bool_], time: Array) -> float:
    """Return the longest time [s] between the first and the last of samples in a row."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], touching, [False]]).astype(int)))
    return max((float(time[end - 1] - time[start]) for start, end in edges.reshape(-1, 2)), default=0.0)


def _friction(trajectory: Trajectory, own: Contacts) -> float | None:
    known = {each.name: each.friction for each in trajectory.arm.world.objects}
    if not len(own) or own.names[own.partner[0]] not in known:  # itself, or a body of a host
        return None
    limit = known[own.names[own.partner[0]]] * own.normal_force
    loaded = own.normal_force > _FAINT * own.normal_force.max()
    if not limit[loaded].any() or (limit[loaded] <= 0).any():
        return None
    return min(float((own.friction_force[loaded] / limit[loaded]).max()), 1.0)


def _moved(trajectory: Trajectory, name: str) -> float | None:
    free = trajectory.arm.world.movable
    if trajectory.objects is None or name not in free:
        return None
    places = trajectory.objects[:, free.index(name), :3]
    return float(np.linalg.norm(places - places[0], axis=1).max(initial=0.0))
