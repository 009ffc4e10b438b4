"""What rubs in slow arms, with memory: the backbone, tendons where they enter the arm, and along their bends.

Rate-independent; what is held depends on the way to a pose, not on time. One step takes C arms from a pose at rest to
the next (implicit, radial return):

backbone    each joint holds the moment m = k (q - z) across it, k = friction_stiffness over the pitch, at most
            friction_moment in size; beyond that z, what it has slid by, follows q.
at entry    the arm feels T_0 - s F, T_0 the tension at the winch, F = dry friction, s in [-1, 1] the grip: it follows
            the slip of the muscle towards its winch, s = 1 after `PRESLIDING` from 0. It never pushes.
along       from there tension falls by exp(-s mu W), see `mechanics.capstan`; stretch is that of the mean tension, so
            T_0 is the law's tension over the profile's mean, at most that at which the winch slips.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from contarm_sim.kinematics.arrays import Array
from contarm_sim.mechanics.capstan import Profile, at_disks, spread
from contarm_sim.mechanics.muscles import each
from contarm_sim.model.arm import Arm
from contarm_sim.statics.poses import Poses
from contarm_sim.statics.stiffness import TangentStiffness

PRESLIDING = 1e-4
"""Slip of a muscle over which its grip goes from 0 to 1 [m]: less than a degree of bend, and no creep."""


class Rubbing:
    """Forces and stiffness of C arms that rub, from the state that each had at its last rest.

    Attributes:
        slid: what the joints' friction has slid by, about x and y [rad], shape (C, J, 2).
        grip: of each muscle, shape (C, M).
        lengths: of the muscles at the last rest [m], shape (C, M).
        lengths_now: at the present pose [m], shape (C, M).
        start, end: tensions of each muscle at its winch and at its end [N] at the present pose, shape (C, M).
    """

    def __init__(self, poses: Poses, arms: Sequence[Arm]) -> None:
        self._poses, index = poses, poses.index
        self._pairs = np.stack([index.bending["x"], index.bending["y"]], axis=-1)
        self._joint_of_dof = index.station_of_dof - 1
        own = {id(arm): _Numbers.of(arm) for arm in arms}
        each_own = [own[id(arm)] for arm in arms]
        self._stick, self._limit = (np.stack([getattr(one, name) for one in each_own]) for name in ("stick", "limit"))
        self._dry, self._mu, self._most = (
            np.stack([getattr(one, name) for one in each_own]) for name in ("dry", "mu", "most")
        )
        self._pitch = np.stack([one.pitch for one in each_own])
        self._weight = self._pitch / np.maximum(self._pitch.sum(axis=-1, keepdims=True), 1e-300)
        self._crossed = self._pitch > 0
        driven = bool(poses.model.ntendon)
        self._backbone = bool(self._stick.any())
        self._along = driven and bool(self._mu.any())
        self._muscles = driven and (self._along or bool(self._dry.any()))
        self._given = poses.actuation == "tensions"
        self.restart()

    def restart(self) -> None:
        """Let nothing hold the present joint angles; lengths are those of the pose last derived."""
        count, muscles = len(self._poses), self._dry.shape[1]
        self.slid, self.grip = self._poses.qpos[:, self._pairs], np.zeros((count, muscles))
        self.lengths = self._poses.muscle_lengths

    def remember(self, slid: Array, grip: Array, lengths: Array) -> None:
        """Go on from states of arms, which may have room for more joints and muscles than there are.

        Args:
            slid: about x and y [rad], shape (C, J or more, 2).
            grip: shape (C, M or more).
            lengths: of the muscles at the last rest [m], shape (C, M or more).
        """
        joints, muscles = self.slid.shape[1], self.grip.shape[1]
        self.slid, self.grip = slid[:, :joints].copy(), grip[:, :muscles].copy()
        self.lengths = lengths[:, :muscles].copy()

    def forces(self, stiffness: TangentStiffness) -> Array:
        """Return the generalised forces at the present pose [N m], shape (C, dofs)."""
        poses = self._poses
        self._law, self.lengths_now = poses.muscle_tensions, poses.muscle_lengths
        if self._muscles:
            self._pull()
        else:
            self.start = self.end = self._mean = self._law
        poses.tighten(self._mean)
        Q = stiffness.forces(self._mean)
        if self._along:
            off = self._tension.take(self._joint_of_dof, axis=-1) - self._mean[..., None]
            Q -= (off * poses.muscle_jacobian).sum(axis=-2)
        if self._backbone:
            self._hold()
            Q[:, self._pairs] -= self._moment
        return Q

    def matrix(self, stiffness: TangentStiffness, gripping: bool = True) -> Array:
        """Return the stiffness matrices at the pose of the last `forces` [N m/rad], shape (C, dofs, dofs).

        Of straight spans what turning does to the tensions of others is left out: Newton takes more steps there.

        Args:
            stiffness: of the arms without friction.
            gripping: with what friction at muscles adds.
        """
        slopes = self._poses.muscle_slopes
        if not (self._muscles and gripping):
            K = stiffness.matrix(self._mean, slopes)
        elif not self._along:
            K = stiffness.matrix(self._mean, self._pulling * (slopes * self._slipping + self._dry * self._sticking))
        else:
            K = stiffness.matrix(self._mean, np.zeros_like(slopes))
            K += self._of_profiles(slopes)
        if self._backbone:
            x, y = self._pairs.T
            K[:, x, x] += self._yield[:, :, 0, 0]
            K[:, x, y] += self._yield[:, :, 0, 1]
            K[:, y, x] += self._yield[:, :, 1, 0]
            K[:, y, y] += self._yield[:, :, 1, 1]
        return np.asarray(K)

    def carry(self, rows: NDArray[np.integer]) -> None:
        """Go on from the pose of the last `forces`.

        Args:
            rows: numbers of the arms that do, at most C.
        """
        if self._backbone:
            held = self._moment[rows] / np.where(self._stick[rows] > 0, self._stick[rows], 1.0)[..., None]
            self.slid[rows] = self._poses.qpos[rows][:, self._pairs] - held
        if self._muscles:
            self.grip[rows] = self._gripped[rows]
        self.lengths[rows] = self.lengths_now[rows]

    def _hold(self) -> None:
        """Find the moments of the backbone's friction [N m], shape (C, J, 2), and what they gain by angles."""
        trial = self._stick[..., None] * (self._poses.qpos[:, self._pairs] - self.slid)
        size = np.hypot(trial[..., 0], trial[..., 1])
        sliding = size > self._limit
        safe = np.where(sliding, size, 1.0)
        share = np.where(sliding, self._limit / safe, 1.0)
        self._moment = share[..., None] * trial
        along = np.where(sliding, 1.0, 0.0)[..., None] * trial / safe[..., None]
        self._yield = (self._stick * share)[..., None, None] * (np.eye(2) - along[..., None] * along[..., None, :])

    def _pull(self) -> None:
        """Find tensions [N]: at winches, where the arm begins, and of each piece."""
        reach = self.grip - (self.lengths_now - self.lengths) / PRESLIDING
        self._gripped = np.clip(reach, -1.0, 1.0)
        self._sticking = np.where(np.abs(reach) < 1.0, 1.0 / PRESLIDING, 0.0)  # of -grip, by length
        self.start, self._slipping = self._law, np.ones_like(self._law)
        if self._along:
            self._profile = self._profiles()
            self._share = (self._weight * self._profile.share).sum(axis=-1)
            if not self._given:
                self.start = np.minimum(self._law / self._share, self._most)
                self._slipping = np.where(self._law < self._most * self._share, 1.0 / self._share, 0.0)
        entering = self.start - self._dry * self._gripped
        self._pulling = np.where((entering > 0) | (self._dry == 0), 1.0, 0.0)
        self._entering = self._pulling * entering
        if self._along:
            self._tension = self._entering[..., None] * self._profile.share
            self._mean, self.end = self._entering * self._share, self._entering * self._profile.end
        else:
            self._mean = self.end = self._entering

    def _profiles(self) -> Profile:
        angles, index = self._poses.qpos[:, self._pairs], self._poses.index
        self._bend = np.hypot(angles[..., 0], angles[..., 1])
        m, straight = self._mu * self._gripped, index.straight
        if straight.all():
            return at_disks(m, self._turning())
        even = spread(m, np.where(self._crossed, self._bend[:, None, :], 0.0))
        if not straight.any():
            return even
        disks = at_disks(m, self._turning())
        pick = straight[:, None]
        share, by_friction, before, own = (
            np.where(pick, getattr(disks, name), getattr(even, name))
            for name in ("share", "by_friction", "before", "own")
        )
        return Profile(share, by_friction, before, own, np.where(straight, disks.end, even.end))

    def _turning(self) -> Array:
        """Return by what straight tendons turn at the disk before each span [rad], shape (C, M, J)."""
        poses = self._poses
        ends = poses.data.site_xpos[:, np.maximum(poses.index.sites, 0)]  # (C, K, M, 3)
        span = np.diff(ends, axis=1)
        span /= np.maximum(np.linalg.norm(span, axis=-1, keepdims=True), 1e-12)
        before = np.empty_like(span)
        before[:, 1:] = span[:, :-1]
        z = poses.data.xmat[:, poses.index.stations].reshape(*ends.shape[:2], 3, 3)[:, :-1, None, :, 2]
        first = np.argmax(self._crossed, axis=-1)
        at = np.arange(span.shape[1])[None, :, None] == first[:, None, :]
        before = np.where(at[..., None], z, before)
        angle = 2 * np.arcsin(np.clip(0.5 * np.linalg.norm(span - before, axis=-1), 0.0, 1.0))
        return np.where(self._crossed & poses.index.straight[:, None], angle.swapaxes(1, 2), 0.0)

    def _of_profiles(self, slopes: Array) -> Array:
        """Return what tensions along tendons add to the stiffness matrix, shape (C, dofs, dofs).

        Q_d = -sum_m T_m,j(d) J_md, and T_mj depends on the length of its tendon and on the turning before it.
        """
        p, J = self._profile, np.broadcast_to(self._poses.muscle_jacobian, (len(self._law), *self._joints_shape()))
        by_length = -self._mu * self._sticking  # of m
        slip, start = self._pulling * self._slipping, self.start / self._share
        open_ = self._pulling * np.where(self._slipping * (not self._given) > 0, 1.0, 0.0)  # the winch holds
        mean = (self._weight * p.by_friction).sum(axis=-1)
        entering = slip * slopes - open_ * start * mean * by_length + self._pulling * self._dry * self._sticking
        rate = entering[..., None] * p.share + (self._entering * by_length)[..., None] * p.by_friction
        K = (J * rate.take(self._joint_of_dof, axis=-1)).swapaxes(-1, -2) @ J
        if self._poses.index.straight.all():
            return np.asarray(K)
        count = p.share.shape[-1]
        earlier = np.tril(np.ones((count, count)), -1)
        later = (self._weight * p.before)[..., ::-1].cumsum(axis=-1)[..., ::-1] - self._weight * p.before
        lost = -(open_ * start)[..., None] * (later + self._weight * p.own)  # of T_entering, by turning
        crossed, (x, y) = self._crossed.astype(float), self._pairs.T
        unit = self._poses.qpos[:, self._pairs] / np.maximum(self._bend, 1e-12)[..., None]
        own = self._entering[..., None] * p.own
        before = self._entering[..., None] * p.before
        lost = np.where(self._poses.index.straight[:, None], 0.0, lost * self._crossed)
        parallel = ~self._poses.index.straight[:, None] * self._crossed
        for side in (x, y):
            Js = J[..., side]
            M = (Js * p.share).swapaxes(-1, -2) @ lost
            M += earlier * ((Js * before * parallel).swapaxes(-1, -2) @ crossed)
            M.reshape(*M.shape[:-2], -1)[..., :: count + 1] += (Js * own * parallel).sum(axis=-2)
            K[:, side[:, None], x] += M * unit[:, None, :, 0]
            K[:, side[:, None], y] += M * unit[:, None, :, 1]
        return np.asarray(K)

    def _joints_shape(self) -> tuple[int, int]:
        return self._dry.shape[1], self._poses.qpos.shape[1]


@dataclass(frozen=True)
class _Numbers:
    """Of one arm: of joints [N m/rad, N m], shape (J,); of muscles [N, -, N], shape (M,); pitches [m], shape (M, J)."""

    stick: Array
    limit: Array
    dry: Array
    mu: Array
    most: Array
    pitch: Array

    @classmethod
    def of(cls, arm: Arm) -> _Numbers:
        sections = [section for section in arm.sections for _ in range(section.links)]
        owners = [number for number, section in enumerate(arm.sections) for _ in range(section.links)]
        pitch = [
            [section.link_pitch * group.crosses(number) for section, number in zip(sections, owners, strict=True)]
            for group in arm.groups for _ in range(group.routing.count)
        ]  # fmt: skip
        return cls(
            np.array([section.sticking_stiffness for section in sections]),
            np.array([section.friction_moment or 0.0 for section in sections]),
            each(arm, lambda group: group.law.dry_friction or 0.0),
            each(arm, lambda group: getattr(group.law, "friction_coefficient", None) or 0.0),
            each(arm, lambda group: group.law.blocked_force),
            np.array(pitch, dtype=float).reshape(-1, len(sections)),
        )


def without_friction(arm: Arm) -> Arm:
    """Return the same arm without any friction, dry friction of its muscles included: what single poses are of."""
    bare, laws = arm.without_memory, []
    for law in bare.laws:
        dry = {item.name for item in fields(law)} & {"friction", "braid_friction"}
        given: Any = {name: None for name in dry if getattr(law, name) is not None}
        laws.append(replace(law, **given) if given else law)
    return bare if all(a is b for a, b in zip(laws, bare.laws, strict=True)) else replace(bare, laws=tuple(laws))
