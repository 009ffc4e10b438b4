"""Muscle tensions, and pressures, that hold a uniform bend.

With the chain's elastic energy (EI/length) |bend|^2/2, its weight's potential V(bend) and the work of tensions T
on lengths L(bend), equilibrium is (EI/length) bend + dV/dbend + J^T T = 0, J = dL/dbend: two equations, n tensions.
What is free is the null space of J^T. Of three muscles it is one direction, co-contraction: (1, 1, 1) for parallel
muscles, nearly so for spans. Of more it has n - 2 dimensions; co-contraction is the direction nearest to (1, ..., 1).

Without gravity this is exact for a chain that bends evenly. Under gravity it is the best answer of one uniform bend
(Ritz): it balances the weight's moment as a whole, not the sag between.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from contarm_sim.errors import InputError
from contarm_sim.kinematics import arc
from contarm_sim.kinematics.arrays import Array, as_vectors, sinc
from contarm_sim.mechanics import pneumatics, routing
from contarm_sim.mechanics.compliance import buckling_tension
from contarm_sim.mechanics.routing import length_jacobian
from contarm_sim.model.arm import Arm

BUCKLING_SHARE = 0.95
"""Of the tension that buckles an arm between the disks of straight spans, what is used at most."""

SERVO_SHARE = 0.2
"""Of the least tension, what a length servo keeps pulling with beside the damping along its muscle."""

_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(12)


def cocontraction(bend: Any, arm: Arm) -> Array:
    """Return tensions of mean 1 that do nothing to the bend, shape (..., n): what of (1, ..., 1) J^T sends to 0.

    The rest of (1, ..., 1) is J x, by least squares; for parallel muscles there is none, to the bit.

    Raises:
        InputError: fewer than three muscles, which cannot hold a bend in every plane.
    """
    if arm.routing.count < 3:
        raise InputError("muscle.count", arm.routing.count, "three muscles or more, which can hold a bend in any plane")
    J = length_jacobian(bend, arm)
    x = np.linalg.solve(J.swapaxes(-1, -2) @ J, J.sum(axis=-2)[..., None])
    free = 1 - (J @ x)[..., 0]
    return free / free.mean(axis=-1, keepdims=True)


def weight_moment(bend: Any, arm: Arm) -> Array:
    """Return -dV/dbend [N m], shape (..., 2): the moment of mass and payload, under the arm's gravity, on the bend."""
    bend, gravity = as_vectors(bend, 2, "bend"), np.array(arm.gravity)
    xi, weight = 0.5 * (1 + _NODES), 0.5 * _WEIGHTS
    spread = np.einsum("q,...qij->...ij", weight, arc.jacobian(bend[..., None, :], arm.length, xi))
    moved = arm.mass * spread + arm.payload * arc.jacobian(bend, arm.length)
    return np.einsum("i,...ij->...j", gravity, moved)


def wrench_moment(bend: Any, force: Any, moment: Any, arm: Arm) -> Array:
    """Return the moment on the bend [N m], shape (..., 2), of a dead force [N] and couple [N m] at the tip."""
    bend = as_vectors(bend, 2, "bend")
    force, moment = as_vectors(force, 3, "force"), as_vectors(moment, 3, "moment")
    moved = (arc.jacobian(bend, arm.length) * force[..., :, None]).sum(axis=-2)
    # The tip turns by exp([-bend_y, bend_x, 0]^), left Jacobian is sin a/a + (1 - sin a/a) n n^T + (1 - cos a)/a n^.
    angle = np.hypot(bend[..., 0], bend[..., 1])
    by_sine, by_cosine = sinc(angle), 0.5 * sinc(0.5 * angle) ** 2
    vector = np.stack([-bend[..., 1], bend[..., 0], np.zeros_like(angle)], axis=-1)
    rest = np.divide(1 - by_sine, angle**2, out=np.full_like(angle, 1 / 6), where=angle > 1e-4)
    turned = by_sine[..., None] * moment + (rest * (vector * moment).sum(axis=-1))[..., None] * vector
    turned = turned - by_cosine[..., None] * np.cross(vector, moment)
    return moved + np.stack([turned[..., 1], -turned[..., 0]], axis=-1)


@dataclass(frozen=True)
class Balance:
    """All tensions that hold bends: `tensions` + level * `cocontraction`, level any number [N].

    Attributes:
        tensions: one of them [N], shape (..., n), by actuators; what stretched silicone pulls is taken off.
        cocontraction: the free direction, shape (..., n), positive, of mean 1.
        per_pascal: force of each muscle by pressure [N/Pa], shape (..., n); 0 where the braid is closed.
        highest: level [N], shape (...), at which the arm buckles between its disks, see `compliance`; inf for parallel
            muscles.
    """

    tensions: Array
    cocontraction: Array
    per_pascal: Array
    highest: Array

    def level(self, least: Array | float) -> Array:
        """Return the lowest level [N] at which no tension is less than `least` [N], shape (...)."""
        return ((least - self.tensions) / self.cocontraction).max(axis=-1)

    def at(self, level: Any) -> Array:
        """Return the tensions [N] at a level [N], shape (..., n)."""
        return self.tensions + np.asarray(level)[..., None] * self.cocontraction


def balance(bend: Any, arm: Arm, rate: Any = None, load: Any = 0.0) -> Balance:
    """Return the tensions that hold bends [rad], shape (..., 2), under the arm's gravity and payload.

    Args:
        rate: velocity of the bend [rad/s], shape (..., 2), whose Kelvin-Voigt damping is carried too.
        load: further moment on the bend [N m], shape (..., 2), as `wrench_moment` gives it.

    Raises:
        InputError: no pulling tensions hold the bend. That needs few disks: straight spans then cut the corner so far
            that even the outer muscle pulls inwards.
    """
    bend = as_vectors(bend, 2, "bend")
    elastic, turn = routing.joint_angles(bend, arm)
    if rate is not None:
        elastic = elastic + arm.damping_time * (turn * as_vectors(rate, 2, "rate")[..., None, :]).sum(axis=-1)
    J, null = length_jacobian(bend, arm), cocontraction(bend, arm)
    if not np.all(null > 0):
        worst = np.hypot(bend[..., 0], bend[..., 1])[~np.all(null > 0, axis=-1)].min()
        raise InputError(
            "bend_angle",
            f"{worst:.4g} rad",
            f"bends that pulling muscles can hold with {arm.links} links: more links, or bend less",
        )
    lengths = routing.lengths_from_bend(bend, arm)
    moment = (arm.bending_stiffness / arm.length) * (turn * elastic[..., :, None]).sum(axis=-2)
    moment = moment - weight_moment(bend, arm) - load
    moment = moment + np.einsum("...ij,...i->...j", J, pneumatics.passive_tension(lengths, arm))
    gram = J.swapaxes(-1, -2) @ J
    tensions = -(J @ np.linalg.solve(gram, moment[..., None]))[..., 0]
    per_pascal = np.where(lengths <= arm.muscle_length_range[1], pneumatics.force_per_pascal(lengths, arm), 0.0)
    buckling = BUCKLING_SHARE * buckling_tension(arm)
    return Balance(tensions, null, per_pascal, (buckling - tensions.sum(axis=-1)) / arm.routing.count)


def holding_tensions(bend: Any, arm: Arm, min_tension: float | None = None, rate: Any = None) -> Array:
    """Return the least tensions T [N] that hold a bend, shape (..., n).

    Args:
        bend: bend vectors [rad], shape (..., 2).
        min_tension: tension of the slackest muscle [N]; default `arm.muscle.min_tension`.
        rate: velocity of the bend [rad/s], see `balance`. Tensions then are also enough for length servos to pull where
            damping along a lengthening muscle already does, see `least_tensions`.

    Raises:
        InputError: no pulling tensions hold the bend, see `balance`.
    """
    held = balance(bend, arm, rate)
    least: Any = arm.muscle.min_tension if min_tension is None else min_tension
    if rate is not None:
        least = least_tensions((length_jacobian(bend, arm) * np.asarray(rate)[..., None, :]).sum(axis=-1), least, arm)
    return held.at(held.level(least))


def least_tensions(speeds: Array, min_tension: float, arm: Arm) -> Array:
    """Return the least tensions [N], shape (..., n), of servo-driven muscles that lengthen at given speeds [m/s].

    Damping along a muscle pulls while it lengthens; the servo, which cannot push, keeps a share of the least tension.
    """
    return np.maximum(min_tension, arm.servo_stiffness * arm.servo_time * speeds + SERVO_SHARE * min_tension)


def servo_control(lengths: Array, tensions: Array, arm: Arm) -> Array:
    """Return controls of length servos, length changes [m], at which muscles of these lengths [m] have tensions [N]."""
    return np.asarray(arm.group.setpoint(lengths, tensions))


def servo_tensions(control: Array, lengths: Array, arm: Arm) -> Array:
    """Return the tensions [N] of muscles of these lengths [m] under controls of length servos, see `servo_control`."""
    return np.asarray(arm.group.servo_tension(control, lengths))


def level_range(held: Balance, arm: Arm) -> tuple[Array, Array]:
    """Return the lowest and highest level [N], each of shape (...), that pressures within the limits give.

    The lowest also keeps `min_tension`; the highest stays below what buckles the arm between its disks. Where the
    lowest is higher, no pressures hold the bend.
    """
    low = held.level(np.maximum(arm.muscle.min_tension, arm.pneumatics.min_pressure * held.per_pascal))
    room = (arm.pneumatics.max_pressure * held.per_pascal - held.tensions) / held.cocontraction
    high = np.where(held.per_pascal.min(axis=-1) > 0, room.min(axis=-1), -np.inf)
    return low, np.minimum(high, held.highest)


def pressure_needed(bend: Any, arm: Arm) -> tuple[Array, Array]:
    """Return the highest of the least pressures [Pa] that hold bends, (all muscles inflated, one may be vented).

    Each of shape (...); inf where no pressure does. Inflated muscles have at least the lowest pressure there is, so
    an antagonist that is vented, without any tension, leaves the others less to carry.
    """
    return balance_pressure(balance(bend, arm), arm)


def balance_pressure(held: Balance, arm: Arm) -> tuple[Array, Array]:
    """Return the highest of the least pressures [Pa] that give a balance's tensions, see `pressure_needed`."""
    with np.errstate(divide="ignore", invalid="ignore"):
        low = level_range(held, arm)[0]
        inflated = (held.at(low) / held.per_pascal).max(axis=-1)
        possible = (held.per_pascal > 0).all(axis=-1) & (low <= held.highest)
        least = inflated = np.where(possible, inflated, np.inf)
        for i in range(held.tensions.shape[-1]):
            level = -held.tensions[..., i] / held.cocontraction[..., i]
            others = np.delete(held.at(level) / held.per_pascal, i, axis=-1)
            allowed = (others >= arm.pneumatics.min_pressure).all(axis=-1) & np.isfinite(others).all(axis=-1)
            allowed &= (held.per_pascal > 0).all(axis=-1) & (level <= held.highest)
            least = np.minimum(least, np.where(allowed, others.max(axis=-1), np.inf))
    return inflated, least


def holding_pressures(bend: Any, arm: Arm, share: float = 0.0, rate: Any = None) -> Array:
    """Return pressures [Pa] that hold a bend, shape (..., n), all between the lowest and the highest there are.

    Args:
        share: co-contraction, from 0 (the least that the limits allow) to 1 (the most).
        rate: velocity of the bend [rad/s], see `balance`.

    Raises:
        InputError: the bend needs more than the highest pressure; says how much.
    """
    held = balance(bend, arm, rate)
    low, high = level_range(held, arm)
    if not np.all(low <= high):
        raise InputError("bend", *_refusal(held, low, arm))
    return held.at(low + share * (high - low)) / held.per_pascal


def _refusal(held: Balance, low: Array, arm: Arm) -> tuple[str, str]:
    """Say what the first bend that no pressures hold needs, and what is allowed."""
    pressures = f"{arm.pneumatics.min_pressure / 1e3:.4g} to {arm.pneumatics.max_pressure / 1e3:.4g} kPa"
    if not np.all(held.per_pascal > 0):
        shortest, longest = (1e3 * length for length in arm.muscle_length_range)
        return (
            "one that asks a muscle for a length it cannot take",
            f"muscle lengths of {shortest:.1f} to {longest:.1f} mm",
        )
    if np.any(low > held.highest):
        return f"one that {pressures} buckle the arm at", "a stiffer arm, more links, or less of a bend"
    return (
        f"one that needs {float((held.at(low) / held.per_pascal).max()) / 1e3:.0f} kPa",
        f"bends that need no more than there is; available {pressures}",
    )
