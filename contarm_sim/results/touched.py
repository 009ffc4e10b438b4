"""What an arm touched in a motion, object by object."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from contarm_sim.mechanics.contacts import ITSELF
from contarm_sim.results.trajectory import Trajectory


@dataclass(frozen=True)
class Touched:
    """Contacts of an arm with one object, or with itself.

    Attributes:
        object: its name; `itself` of self-contact.
        first_s: when they first touch [s].
        share: of the samples in which they do.
        first_link, last_link: links that touch, counted from the base, 0, to the tip, the number of links.
        force_n: largest sum of the sizes of contact forces in a sample [N].
        depth_m: deepest that link and object overlap [m].
    """

    object: str
    first_s: float
    share: float
    first_link: int
    last_link: int
    force_n: float
    depth_m: float


def touched(trajectory: Trajectory) -> tuple[Touched, ...]:
    """Return what the arm touched, in the order of its world; nothing where it touched nothing."""
    contacts, found = trajectory.contacts, list[Touched]()
    if contacts is None:
        return ()
    for place, name in enumerate(contacts.names):
        own = contacts.where(contacts.partner == place)
        if not len(own):
            continue
        twice = 2 if name == ITSELF else 1  # both links feel it
        found.append(
            Touched(
                object=name,
                first_s=float(trajectory.time[own.sample[0]]),
                share=len(np.unique(own.sample)) / len(trajectory),
                first_link=int(own.station.min()),
                last_link=int(own.station.max()),
                force_n=float(own.total(len(trajectory)).max()) / twice,
                depth_m=max(0.0, float(own.depth.max())),
            )
        )
    return tuple(found)
