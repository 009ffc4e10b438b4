"""How `contarm ik` solves targets: by the dome, by inverse kinematics, or by poses that keep clear of objects."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from contarm_sim.cli.options import bends_from_words
from contarm_sim.errors import InputError, UnreachableError
from contarm_sim.model.arm import Arm

if TYPE_CHECKING:
    from contarm_sim.kinematics.backbone import Backbone
    from contarm_sim.paths.targets import Targets
    from contarm_sim.planning import Avoiding


@dataclass(frozen=True)
class Asked:
    """How targets are to be solved, as the flags say it."""

    choose: str | None
    near: tuple[tuple[float, float], ...]
    limit: tuple[float, ...]
    project: Any
    tolerance: float | None
    avoid: bool
    margin: float | None


def solved(arm: Arm, targets: Targets, asked: Asked) -> tuple[list[dict[str, Any]], list[Avoiding]]:
    """Return what is said of each solution, and those that avoid as they are.

    Raises:
        UnreachableError: a target out of reach, unless projected.
        BlockedError: a target without a clear pose, where that is asked for.
        InputError: flags that do not suit this arm.
    """
    from contarm_sim.kinematics import inverse
    from contarm_sim.mechanics import shape

    plain = not (targets.turned or asked.choose or asked.near or asked.limit or asked.avoid)
    if len(arm.sections) == 1 and plain:
        return _on_dome(arm, targets, asked), []
    if asked.project not in ("refuse", "nearest"):
        allowed = "refuse or nearest; ray and paper are for positions of one section alone"
        raise InputError("--project", asked.project, allowed)
    _check_limits(asked.limit, arm)
    form = shape.backbone(arm, limits=asked.limit or None)
    if asked.near and asked.choose not in (None, "nearest"):
        raise InputError("--from", f"given with --choose {asked.choose}", "--choose nearest, or no --choose")
    if asked.choose == "all":
        return _all(arm, targets, form, asked), []
    near = bends_from_words(asked.near, arm, "from").reshape(-1, 2) if asked.near else None
    choose: Any = asked.choose or ("nearest" if asked.near else "least-bend")
    if choose == "nearest" and near is None:
        raise InputError("--choose nearest", "given without --from", "--from BEND_ANGLE PLANE_ANGLE for each section")
    if asked.avoid:
        return _avoided(arm, targets, asked, choose, near)
    found = inverse.solve(targets.position, form, targets.direction, targets.rotation, choose, near)
    return _said(arm, targets, found.bends, found.solutions, asked, form.limits), []


def _avoided(
    arm: Arm, targets: Targets, asked: Asked, choose: Any, near: Any
) -> tuple[list[dict[str, Any]], list[Avoiding]]:
    """Return the same of poses that keep clear of objects."""
    import numpy as np

    from contarm_sim.cli.avoiding import avoided, said_of

    limits = asked.limit or None
    found = avoided(arm, targets, asked.margin, choose, near, limits)
    bends = np.stack([each.bends for each in found])
    count = np.array([each.solutions for each in found])
    rows = _said(arm, targets, bends, count, asked, limits or ())
    return [row | said_of(each) for row, each in zip(rows, found, strict=True)], found


def _check_limits(limits: tuple[float, ...], arm: Arm) -> None:
    """Refuse limits that are none, or not one for all sections or for each.

    Raises:
        InputError: says which.
    """
    import math

    count = len(arm.sections)
    if len(limits) not in (0, 1, count):
        raise InputError("--limit", f"given {len(limits)} times", f"once, or {count} times, once for each section")
    for limit in limits:
        if not 0 < limit < math.pi:
            given = f"{limit:.6g} rad ({math.degrees(limit):.6g} deg)"
            raise InputError("--limit", given, "above 0, below pi rad (180 deg)")


def _all(arm: Arm, targets: Targets, form: Backbone, asked: Asked) -> list[dict[str, Any]]:
    import numpy as np

    from contarm_sim.kinematics import inverse

    if len(targets.position) != 1:
        raise InputError("--choose all", f"given for {len(targets.position)} targets", "one target: --tip")
    one = targets.repeated(1)
    direction, rotation = (None if each is None else each[0] for each in (one.direction, one.rotation))
    pieces = inverse.solve_all(one.position[0], form, direction, rotation)
    if not pieces:
        found = inverse.solve(one.position, form, one.direction, one.rotation)
        return _said(arm, targets, found.bends, found.solutions, asked, form.limits)
    bends = np.concatenate(pieces)
    isolated = all(len(piece) == 1 for piece in pieces)
    count = np.full(len(bends), len(bends) if isolated else -1)
    rows = _said(arm, targets.repeated(len(bends)), bends, count, asked, form.limits)
    for row, piece in zip(rows, np.repeat(np.arange(1, len(pieces) + 1), [len(p) for p in pieces]), strict=True):
        row["piece"] = int(piece)
    return rows


def _said(
    arm: Arm, targets: Targets, bends: Any, count: Any, asked: Asked, limits: tuple[float, ...]
) -> list[dict[str, Any]]:
    """Return what is said of solutions, shape (T, S, 2), if they reach their targets or may miss them.

    Raises:
        UnreachableError: the first that does not, unless projected.
    """
    import numpy as np

    from contarm_sim.cli.solutions import of_bends
    from contarm_sim.kinematics.dome import TOLERANCE
    from contarm_sim.kinematics.inverse.result import ANGLE_LENGTH
    from contarm_sim.mechanics import shape

    bend = bends.reshape(len(bends), -1)
    tips = shape.transform(bend, arm)
    miss, angle = targets.misses(tips)
    tolerance = TOLERANCE * arm.length if asked.tolerance is None else asked.tolerance
    reached = np.maximum(miss, ANGLE_LENGTH * arm.length * angle) <= tolerance
    if asked.project == "refuse" and not reached.all():
        index = int(np.argmin(reached))
        raise UnreachableError(
            targets.position[index], float(miss[index]), tips[index, :3, 3], tolerance, index,
            angle=float(angle[index]), dome=False, limits=limits,
        )  # fmt: skip
    rows = of_bends(arm, bend)
    return [
        {
            "target": targets.position[i].tolist(), "miss": float(miss[i]), "angle_miss": float(angle[i]),
            "reachable": bool(reached[i]), "solutions": int(count[i]), "bends": bends[i].tolist(), **rows[i],
            "transform": tips[i].tolist(), "asks_turn": targets.turned,
        }
        for i in range(len(bends))
    ]  # fmt: skip


def _on_dome(arm: Arm, targets: Targets, asked: Asked) -> list[dict[str, Any]]:
    """Return the same of one section and positions alone, by the dome and its projections."""
    from contarm_sim.cli.solutions import of_bends
    from contarm_sim.kinematics import arc, dome

    reach = dome.bend_from_tip(targets.position, arm.length, asked.project, asked.tolerance)
    reached, rows = arc.transform(reach.bend, arm.length), of_bends(arm, reach.bend)
    return [
        {
            "target": targets.position[i].tolist(), "miss": float(reach.miss[i]), "angle_miss": 0.0,
            "reachable": bool(reach.reachable[i]), "solutions": int(reach.reachable[i]),
            "bends": [reach.bend[i].tolist()], **rows[i], "transform": reached[i].tolist(),
        }
        for i in range(len(rows))
    ]  # fmt: skip
