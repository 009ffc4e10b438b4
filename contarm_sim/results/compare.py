"""Sample by sample: where the tip should be, where it is, and where in the model each part of the difference arises.

    target --IK--> arc tip --discretisation--> chain tip --servo--> chain tip as measured --shape--> simulated tip

`discretisation` is known in closed form; `servo` is what commanded and measured lengths differ by, as tip motion;
`shape` is what differs at equal muscle lengths: gravity, inertia, torsion, joints that bend unequally. The vectors add
up to the tip error.

What an arm touches is a part of its own: `contact` is the way from where the tip would be without objects to where it
is. The other parts are then those of the motion without objects, which has to be given; otherwise contact is in the
shape.

Of several sections each part is also given section by section: what the tip moves where that section alone has it.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from contarm_sim.display import Shown
from contarm_sim.errors import InputError, expect
from contarm_sim.kinematics.arrays import Array
from contarm_sim.mechanics import routing, shape
from contarm_sim.results.trajectory import Trajectory

SLACK_TENSION = 0.01
"""A muscle that pulls no more than this is slack [N]."""

PUSH_TENSION = -1e-6
"""A muscle below this tension pushes [N]."""


@dataclass(frozen=True, eq=False, repr=False)
class Comparison(Shown):
    """T samples beside the closed forms; positions [m] in the base frame, distances [m].

    Attributes:
        analytic_tip, chain_tip, simulated_tip: of the commanded bends, and as simulated, shape (T, 3).
        target_error: target to simulated tip, shape (T,): what the arm leaves.
        miss: target to analytic tip, shape (T,): a target off the dome cannot be reached.
        tip_error: analytic to simulated tip, shape (T,).
        followed_tip: of the chain at the measured lengths, shape (T, 3).
        discretisation, servo, shape: sizes of the three parts of the tip error, shape (T,).
        orientation_error: angle between analytic and simulated tip frames [rad], shape (T,).
        backbone_error: largest distance from a station of the simulated backbone to its point on the arc, shape (T,).
        measured_bend: bends of the measured lengths [rad], shape (T, 2 S).
        alone_tip: the simulated tip without objects, shape (T, 3), and
        contact: how far they move it, shape (T,); None where that was not given. With it, `followed_tip`, `servo`,
            `shape` and `measured_bend` are of the motion without objects.
        section_discretisation, section_servo, section_shape: the three parts, of each section alone, shape (T, S).
            Joint angles tell the last; with an extrapolated trajectory it is that of the finer chain.
    """

    analytic_tip: Array
    chain_tip: Array
    simulated_tip: Array
    followed_tip: Array
    target_error: Array
    miss: Array
    tip_error: Array
    discretisation: Array
    servo: Array
    shape: Array
    orientation_error: Array
    backbone_error: Array
    measured_bend: Array
    section_discretisation: Array
    section_servo: Array
    section_shape: Array
    alone_tip: Array | None = None
    contact: Array | None = None

    def __repr__(self) -> str:
        parts = ["target_error", "tip_error", "discretisation", "servo", "shape"]
        parts += [] if self.contact is None else ["contact"]
        said = (f"{name} {1e3 * getattr(self, name).max():.3g} mm" for name in parts)
        return f"Comparison({len(self.tip_error)} samples; at most {', '.join(said)})"


def compare(trajectory: Trajectory, alone: Trajectory | None = None) -> Comparison:
    """Return the comparison of a trajectory with the closed forms of its own arm.

    Args:
        alone: the same motion without objects, as `studies.without_objects` returns it: contact is then a part of its
            own.

    Raises:
        InputError: no trajectory, or another motion.
    """
    expect("trajectory", trajectory, Trajectory)
    if alone is not None:
        _check_alone(trajectory, alone)
    samples, arm, extrapolated = trajectory, trajectory.arm, trajectory.extrapolated
    bend, free = samples.bend, trajectory if alone is None else alone
    analytic, chained = shape.position(bend, arm), shape.chain_tip(bend, arm, extrapolated)
    measured, _ = routing.bend_from_lengths(free.muscle_lengths, arm, extrapolated)
    followed, simulated = shape.chain_tip(measured, arm, extrapolated), samples.tip
    arcs = shape.position(bend[:, None, :], arm, shape.stations(arm))
    parts = [_norm(part) for part in (chained - analytic, followed - chained, free.tip - followed)]
    one = len(arm.sections) == 1
    by_section = [part[:, None] for part in parts] if one else _by_section(free, measured)
    return Comparison(
        analytic_tip=analytic,
        chain_tip=chained,
        simulated_tip=simulated,
        followed_tip=followed,
        target_error=_norm(simulated - samples.target),
        miss=_norm(analytic - samples.target),
        tip_error=_norm(simulated - analytic),
        discretisation=parts[0],
        servo=parts[1],
        shape=parts[2],
        orientation_error=rotation_angle(shape.rotation(bend, arm), samples.tip_rotation),
        backbone_error=_norm(samples.stations - arcs).max(axis=-1),
        measured_bend=measured,
        section_discretisation=by_section[0],
        section_servo=by_section[1],
        section_shape=by_section[2],
        alone_tip=None if alone is None else alone.tip,
        contact=None if alone is None else _norm(simulated - alone.tip),
    )


def _check_alone(trajectory: Trajectory, alone: Trajectory) -> None:
    """Refuse another motion than the same without objects.

    Raises:
        InputError: says what differs.
    """
    expect("alone", alone, Trajectory)
    if alone.arm != trajectory.arm.alone:
        raise InputError("alone", "of another arm", "of the same arm without objects, arm.alone")
    same = ("time", "bend")
    if not all(np.array_equal(getattr(alone, name), getattr(trajectory, name)) for name in same):
        raise InputError("alone", "of other times or bends", "the same motion without objects")


def _by_section(trajectory: Trajectory, measured: Array) -> list[Array]:
    """Return how far the tip moves where one section alone goes from arc to chain, to measured lengths, to its shape.

    Three arrays of shape (T, S) [m].
    """
    arm, bend = trajectory.arm, trajectory.bend
    steps = [
        shape.section_frames(bend, arm, chained=False),
        shape.section_frames(bend, arm),
        shape.section_frames(measured, arm),
        shape.posed_frames(trajectory.qpos, arm),
    ]
    parts = []
    for before, after in pairwise(steps):
        tip, moved = shape.end_to_end(before)[..., :3, 3], []
        for number in range(len(arm.sections)):
            one = before.copy()
            one[:, number] = after[:, number]
            moved.append(_norm(shape.end_to_end(one)[..., :3, 3] - tip))
        parts.append(np.stack(moved, axis=-1))
    return parts


def _norm(vectors: Array) -> Array:
    return np.linalg.norm(vectors, axis=-1)


def rotation_angle(a: Array, b: Array) -> Array:
    """Return the angle [rad] between orientations, shape (..., 3, 3) -> (...), accurate for small angles too."""
    return 2 * np.arcsin(np.clip(np.linalg.norm(a - b, axis=(-2, -1)) / np.sqrt(8), 0, 1))
