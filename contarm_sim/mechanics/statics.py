"""Muscle tensions, and pressures, that hold uniform bends of all sections.

With the chain's elastic energy, the sum of (EI/length) |bend|^2/2 over sections, its weight's potential V(bend) and the
work of tensions T on lengths L(bend), equilibrium is (EI/length) bend + dV/dbend + J^T T = 0, J = dL/dbend: two
equations a section, n tensions. What is free is the null space of J^T: co-contraction, one direction for the muscles of
each section. Of three muscles it is (1, 1, 1) if they are parallel, nearly so for spans; of more it is the direction
nearest to (1, ..., 1). Where muscles pass through sections nearer to the base, in straight spans, those sections'
muscles take up what they pull there.

Without gravity this is exact for a chain that bends evenly. Under gravity it is the best answer of uniform bends
(Ritz): it balances the weight's moment on each section as a whole, not the sag within.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from contarm_sim.errors import InputError
from contarm_sim.kinematics.arrays import Array
from contarm_sim.mechanics import muscles, pneumatics, routing, shape
from contarm_sim.mechanics.compliance import buckling_tension
from contarm_sim.mechanics.moments import weight_moment
from contarm_sim.mechanics.routing import length_jacobian
from contarm_sim.mechanics.servos import least_tensions
from contarm_sim.model.arm import Arm

BUCKLING_SHARE = 0.95
"""Of the tension that buckles an arm between the disks of straight spans, what is used at most."""


def cocontraction(bend: Any, arm: Arm) -> Array:
    """Return tensions that do nothing to the bend, one direction a section, shape (..., S, n).

    Each is 1 for the muscles of its section and 0 for others, less what that does to bends: J x, by least squares over
    the muscles up to that section. For parallel muscles that is nothing, to the bit. The mean over its own is 1.

    Raises:
        InputError: fewer than three muscles in a section, which cannot hold a bend in every plane.
    """
    muscles.require_drivable(arm)
    J = length_jacobian(bend, arm)
    out = np.zeros((*J.shape[:-2], len(arm.sections), J.shape[-2]))
    for number, own in enumerate(muscles.slices(arm)):
        part = J[..., : own.stop, : 2 * number + 2]
        x = np.linalg.solve(part.swapaxes(-1, -2) @ part, part[..., own, :].sum(axis=-2)[..., None])
        free = -(part @ x)[..., 0]
        free[..., own] += 1
        out[..., number, : own.stop] = free / free[..., own].mean(axis=-1, keepdims=True)
    return out


@dataclass(frozen=True)
class Balance:
    """All tensions that hold bends: `tensions` + the levels of the sections' muscles times their `cocontraction`.

    Attributes:
        tensions: one of them [N], shape (..., n), by actuators; what stretched silicone pulls is taken off.
        cocontraction: the free directions, shape (..., S, n), of mean 1 over their own muscles, positive there.
        per_pascal: force of each muscle by pressure [N/Pa], shape (..., n); 0 where the braid is closed.
        highest: levels [N], shape (..., S), at which the arm buckles between its disks, see `compliance`; inf for
            parallel muscles.
        own: the muscles of each section.
    """

    tensions: Array
    cocontraction: Array
    per_pascal: Array
    highest: Array
    own: list[slice]

    def level(self, least: Array | float) -> Array:
        """Return the lowest levels [N], shape (..., S), at which no tension is less than `least` [N]."""
        return self.from_tip(lambda short: short.max(axis=-1), least)

    def at(self, level: Any) -> Array:
        """Return the tensions [N], shape (..., n), at levels [N], shape (..., S)."""
        level, tensions = np.asarray(level), self.tensions
        for number in range(len(self.own)):
            tensions = tensions + level[..., number, None] * self.cocontraction[..., number, :]
        return tensions

    def from_tip(self, choose: Callable[[Array], Array], wanted: Array | float) -> Array:
        """Return levels at which muscles have what is wanted [N], `choose`n among those of each section.

        From the tip to the base, for the muscles of a section load those before theirs, and none beyond.
        """
        tensions, wanted = self.tensions, np.broadcast_to(wanted, self.tensions.shape)
        levels = np.empty((*tensions.shape[:-1], len(self.own)))
        for number in range(len(self.own) - 1, -1, -1):
            own, free = self.own[number], self.cocontraction[..., number, :]
            levels[..., number] = choose((wanted[..., own] - tensions[..., own]) / free[..., own])
            if number:
                tensions = tensions + levels[..., number, None] * free
        return levels


def balance(bend: Any, arm: Arm, rate: Any = None, load: Any = 0.0) -> Balance:
    """Return the tensions that hold bends [rad], shape (..., 2 S), under the arm's gravity and payload.

    Args:
        rate: velocity of the bends [rad/s], shape (..., 2 S), whose Kelvin-Voigt damping is carried too.
        load: further moment on the bends [N m], shape (..., 2 S), as `wrench_moment` gives it.

    Raises:
        InputError: no pulling tensions hold the bend. That needs few disks, where straight spans cut the corner so far
            that even the outer muscle pulls inwards; or muscles that all sit on one side.
    """
    bends = shape.bends_of(bend, arm)
    rates = None if rate is None else shape.bends_of(rate, arm)
    J, null, own = length_jacobian(bend, arm), cocontraction(bend, arm), muscles.slices(arm)
    for number, mine in enumerate(own):
        _refuse_pushing(null[..., number, mine], bends[..., number, :], arm, number)
    lengths = routing.lengths_from_bend(bend, arm)
    held = [
        _elastic_moment(bends[..., number, :], None if rates is None else rates[..., number, :], arm, number)
        for number in range(len(arm.sections))
    ]
    moment = np.concatenate(held, axis=-1) - weight_moment(bend, arm) - load
    moment = moment + np.einsum("...ij,...i->...j", J, pneumatics.passive_tension(lengths, arm))
    gram = J.swapaxes(-1, -2) @ J
    tensions = -(J @ np.linalg.solve(gram, moment[..., None]))[..., 0]
    longest = muscles.each(arm, lambda group: group.length_range[1])
    per_pascal = np.where(lengths <= longest, pneumatics.force_per_pascal(lengths, arm), 0.0)
    return Balance(tensions, null, per_pascal, _highest(tensions, arm), own)


def _elastic_moment(bend: Array, rate: Array | None, arm: Arm, number: int) -> Array:
    """Return what a section resists its bend, and the bend's rate, with [N m], shape (..., 2)."""
    section = arm.sections[number]
    elastic, turn = routing.section_angles(bend, section, arm.routings[number])
    if rate is not None:
        elastic = elastic + section.damping_time * (turn * rate[..., None, :]).sum(axis=-1)
    return np.asarray((section.bending_stiffness / section.length) * (turn * elastic[..., :, None]).sum(axis=-2))


def _refuse_pushing(null: Array, bend: Array, arm: Arm, number: int) -> None:
    """Refuse bends at which co-contraction is no pull of all the muscles of a section.

    Raises:
        InputError: names the least such bend.
    """
    if np.all(null > 0):
        return
    of_section = "" if len(arm.sections) == 1 else f" of section {number + 1}"
    if not np.all(cocontraction(np.zeros(2 * len(arm.sections)), arm)[number, muscles.slices(arm)[number]] > 0):
        angles = ", ".join(f"{np.degrees(angle):.4g}" for angle in arm.routings[number].angles)
        raise InputError(f"muscle angles{of_section}", f"{angles} deg", "muscles on all sides of the backbone")
    worst = np.hypot(bend[..., 0], bend[..., 1])[~np.all(null > 0, axis=-1)].min()
    links = arm.sections[number].links
    raise InputError(
        f"bend_angle{of_section}",
        f"{worst:.4g} rad",
        f"bends that pulling muscles can hold with {links} links: more links, or bend less",
    )


def _highest(tensions: Array, arm: Arm) -> Array:
    """Return the levels [N], shape (..., S), up to which no section buckles between its disks, all levels alike."""
    out = np.full((*tensions.shape[:-1], len(arm.sections)), np.inf)
    own = muscles.slices(arm)
    for number in range(len(arm.sections)):
        limit = BUCKLING_SHARE * buckling_tension(arm, number)
        through = [i for i, group in enumerate(arm.groups) if group.crosses(number) and group.routing.path == "spans"]
        if not through:
            continue
        total = sum(tensions[..., own[i]].sum(axis=-1) for i in through)
        room = (limit - total) / sum(arm.groups[i].routing.count for i in through)
        for i in through:
            section = arm.groups[i].section
            out[..., section] = np.minimum(out[..., section], room)
    return out


def holding_tensions(bend: Any, arm: Arm, min_tension: float | None = None, rate: Any = None) -> Array:
    """Return the least tensions T [N] that hold a bend, shape (..., n).

    Args:
        bend: bends [rad], shape (..., 2 S).
        min_tension: tension of the slackest muscle of each section [N]; default that of its law.
        rate: velocity of the bends [rad/s], see `balance`. Tensions then are also enough for length servos to pull
            where damping along a lengthening muscle already does, see `least_tensions`.

    Raises:
        InputError: no pulling tensions hold the bend, see `balance`.
    """
    held = balance(bend, arm, rate)
    least: Any = min_tensions(arm) if min_tension is None else min_tension
    if rate is not None:
        least = least_tensions((length_jacobian(bend, arm) * np.asarray(rate)[..., None, :]).sum(axis=-1), least, arm)
    return held.at(held.level(least))


def min_tensions(arm: Arm) -> Array:
    """Return the tensions [N], shape (n,), that the muscles' laws hold the slackest at."""
    return muscles.each(arm, lambda group: group.law.min_tension)
