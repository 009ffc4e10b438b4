"""Courses along targets whose every pose is clear: around the objects, without a jump."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from contarm_sim.display import Shown
from contarm_sim.errors import BlockedError, ContarmError, InputError, UnreachableError, expect
from contarm_sim.kinematics import dome, inverse, sections
from contarm_sim.kinematics.arrays import Array, as_vectors
from contarm_sim.kinematics.backbone import as_bends
from contarm_sim.kinematics.inverse.goals import Goals
from contarm_sim.model.arm import Arm
from contarm_sim.paths.reference import RATE, Reference, section_lengths
from contarm_sim.paths.shapes import Path
from contarm_sim.planning.avoid import avoid, check_point, checked_margin
from contarm_sim.planning.clearance import Clearance, Nearest, clearance_of
from contarm_sim.planning.way import Way, said_of_target


@dataclass(frozen=True, repr=False)
class Course(Shown):
    """Poses along a row of targets that follow one another continuously and keep clear.

    Attributes:
        bends: of the sections [rad], shape (T, S, 2).
        target: tip positions [m], shape (T, 3).
        nearest: where the arm and an object are nearest at each target.
        margin: clearance that was asked for [m].
    """

    bends: Array
    target: Array
    nearest: tuple[Nearest, ...]
    margin: float

    @property
    def clearance(self) -> Array:
        """Distances from the arm's surface to the nearest object [m], shape (T,): lower bounds."""
        return np.array([each.clearance for each in self.nearest])

    def reference(self, arm: Arm, time: Any = None) -> Reference:
        """Return the motion along it, at even times from 0 [s], shape (T,); None: poses at rest.

        Raises:
            InputError: other times.
        """
        at = np.zeros(len(self.bends)) if time is None else time
        return Reference(at, self.target, self.bends.reshape(len(self.bends), -1), section_lengths(arm))


def reference(path: Path, arm: Arm, margin: float | None = None, rate: float = RATE, start: Any = None) -> Reference:
    """Return the motion along a path (`contarm_sim.paths.named`), sampled at a rate [Hz], that keeps clear.

    Args:
        margin, start: as of `avoid_along`.

    Raises:
        UnreachableError, BlockedError, InputError: as `avoid_along`; says how far along the path.
    """
    expect("path", path, Path)
    time, target = path.targets(rate)
    return avoid_along(arm, target, margin, start).reference(arm, time)


def avoid_along(arm: Arm, targets: Any, margin: float | None = None, start: Any = None) -> Course:
    """Return bends that follow targets in order, without a jump, and keep clear of the objects of the arm's world.

    Between targets tips go straight, and the poses on the way are clear, too, as far as they were looked at: at least
    ten to each 5 % of the arm's length.

    Args:
        arm: with objects in its world; free ones are where they start.
        targets: tip positions in the base frame [m], shape (T, 3).
        margin: clearance to keep [m]; default `planning.default_margin`.
        start: bends [rad], shape (S, 2), that the course starts from: at the solution that they lead to. Default: free.

    Raises:
        InputError: an arm without objects, a margin below 0, targets that are none, or one in an object.
        UnreachableError: a target that no pose reaches; `index` says which.
        BlockedError: a target without a clear pose, or no continuous way was found.
    """
    expect("arm", arm, Arm)
    clearance, margin = clearance_of(arm), checked_margin(arm, margin)
    target = as_vectors(targets, 3, "targets")
    if target.ndim != 2 or not len(target):
        raise InputError("targets", f"of shape {target.shape}", "targets in a row, shape (T, 3)")
    first = None if start is None else as_bends(start, clearance.backbone, "start").reshape(-1, 2)
    goals = Goals(target)
    _check_targets(arm, clearance, target)
    if len(clearance.backbone) == 1 or len(target) == 1:
        found = [_at(arm, target, k, margin, first) for k in range(len(target))]
        return Course(np.stack([each.bends for each in found]), target, tuple(each.nearest for each in found), margin)

    bends = Way(arm, clearance, goals, margin + clearance.tube.between(margin), margin, first).course()
    nearest = tuple(clearance.nearest(each) for each in bends)
    worst = min(range(len(nearest)), key=lambda k: nearest[k].clearance)
    if nearest[worst].clearance < margin:
        raise _no_way(target, worst, nearest[worst], margin)
    return Course(bends, target, nearest, margin)


def _at(arm: Arm, target: Array, number: int, margin: float, start: Array | None) -> Any:
    """Return the clear pose at one target.

    Raises:
        BlockedError: says at which.
    """
    try:
        return avoid(arm, target[number], margin, near=start)
    except BlockedError as error:
        said = said_of_target(number, len(target))
        raise BlockedError(f"{said}: {error}", error.clearance, margin, error.object) from None


def _check_targets(arm: Arm, clearance: Clearance, target: Array) -> None:
    """Refuse targets out of reach and in objects.

    Raises:
        UnreachableError, InputError: say which.
    """
    inside = np.flatnonzero(clearance.of_points(target)[0] < 0)
    if len(inside):
        check_point(clearance, target[inside[0]], said_of_target(int(inside[0]), len(target)))
    backbone = clearance.backbone
    found = inverse.solve(target, backbone)
    missed = np.flatnonzero(~found.reachable)
    if len(missed):
        k = int(missed[0])
        raise UnreachableError(
            target[k], float(found.miss[k]), sections.position(found.bends[k], backbone), dome.TOLERANCE * arm.length,
            k, said_of_target(k, len(target)), dome=len(backbone) == 1, limits=backbone.limits[1:] and backbone.limits,
        )  # fmt: skip


def _no_way(target: Array, number: int, nearest: Nearest, margin: float) -> ContarmError:
    """Return the error of a course that is not clear after all."""
    return BlockedError(
        f"{said_of_target(number, len(target))}: the course comes {1e3 * nearest.clearance:.4g} mm near to "
        f"{nearest.object!r}, and {1e3 * margin:.4g} mm were asked for",
        nearest.clearance, margin, nearest.object,
    )  # fmt: skip
