"""What a static pose says of the objects that the arm leans on."""

from __future__ import annotations

from dataclasses import dataclass

from contarm_sim.display import Shown
from contarm_sim.kinematics.arrays import Array


@dataclass(frozen=True, eq=False, repr=False)
class Touch(Shown):
    """Where an arm at rest leans on an object; base frame.

    Attributes:
        object: name of the object.
        station: the station next to it, 0 base to N tip.
        xi: where along the backbone, 0 base to 1 tip, which stands for all of the ball that the tip is.
        point: on the arm's surface [m], shape (3,).
        normal: out of the object, shape (3,).
        force: the object's on the arm, along the normal [N].
        gap: between arm and object [m]: 0 but for rounding, for both are rigid here. In motion contact is a little
            soft, and they overlap.
        friction: coefficient of the two, by which `Equilibrium.friction_range` is found [-].
    """

    object: str
    station: int
    xi: float
    point: Array
    normal: Array
    force: float
    gap: float
    friction: float


@dataclass(frozen=True, eq=False, repr=False)
class HeldObject(Shown):
    """A free object that a static pose takes as held where it stands.

    Attributes:
        name: of the object.
        force: that it takes to hold it against its weight and the arm [N], shape (3,).
    """

    name: str
    force: Array
