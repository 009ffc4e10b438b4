"""Reach around: the tip comes to a point behind a post, by poses that keep clear of it.

The same targets by plain inverse kinematics lead the arm into the post.
"""

from __future__ import annotations

import numpy as np

from contarm_sim.demos.demonstration import STEP, Demonstration, OnTick, Requirement, ticks
from contarm_sim.demos.files import HERE, arm_of, smooth
from contarm_sim.kinematics.arrays import Array
from contarm_sim.model.arm import Arm
from contarm_sim.motion.simulate import CONTROL_RATE, Stepping, simulate
from contarm_sim.paths.reference import Reference, section_lengths
from contarm_sim.paths.waypoints import read_csv
from contarm_sim.planning.along import avoid_along
from contarm_sim.results.trajectory import Trajectory

MARGIN = 0.015
"""Clearance that is planned [m]: the simulated arm is some millimetres beside its arcs."""

EVERY = 10
"""Samples between targets that are planned; bends run smoothly in between."""


def demonstrate(on_tick: OnTick | None = None) -> Demonstration:
    """Simulate both ways to the point, and compare what they touch and where they end."""
    arm = arm_of("reach_around")
    time, target = targets()
    round_it, straight = (
        simulate(arm, reference, "servo", stepping=Stepping(STEP), on_tick=ticks(on_tick, number, len(time)))
        for number, reference in enumerate((planned(arm, time, target), plain(arm, time, target)))
    )
    found = checks(round_it, straight)
    said = (
        f"plain inverse kinematics leads the arm into the post, which it presses with {pressed(straight):.1f} N, and"
        f" ends {1e3 * missed(straight):.0f} mm from the target; the planned way touches nothing, and ends "
        f"{1e3 * missed(round_it):.0f} mm from it, because the arm sags"
    )
    names = ("planned round the post", "plain inverse kinematics")
    return Demonstration(round_it, found, said, straight, names, aims=True)


def targets() -> tuple[Array, Array]:
    """Return times [s], shape (T,), and tip positions [m], shape (T, 3), of the path."""
    way = read_csv(HERE / "reach_around.csv")
    assert way.times is not None
    time = np.arange(round(way.times[-1] * CONTROL_RATE) + 1) / CONTROL_RATE
    return time, smooth(way.times, way.positions, time)


def planned(arm: Arm, time: Array, target: Array) -> Reference:
    """Return the motion whose poses keep clear of the post."""
    rows = np.unique(np.r_[0 : len(time) : EVERY, len(time) - 1])
    bends = avoid_along(arm, target[rows], MARGIN).bends.reshape(len(rows), -1)
    return Reference(time, target, smooth(time[rows], bends, time), section_lengths(arm))


def plain(arm: Arm, time: Array, target: Array) -> Reference:
    """Return the motion that inverse kinematics gives: the pose of least bend behind the post, and back from there."""
    from contarm_sim.kinematics import inverse
    from contarm_sim.mechanics import shape

    form = shape.backbone(arm)
    end = inverse.solve(target[-1], form)
    back = inverse.track(target[::-1], form, start=end.bends)
    return Reference(time, target, back.bends[::-1].reshape(len(time), -1), section_lengths(arm))


def checks(round_it: Trajectory, straight: Trajectory) -> list[Requirement]:
    """Return what both motions must show."""
    return [
        Requirement("planned: distance of tip and target at the end", missed(round_it), 0.015, "m"),
        Requirement("planned: largest sum of contact forces", pressed(round_it), 0.0, "N"),
        Requirement("plain: distance of tip and target at the end", missed(straight), 0.03, "m", least=True),
        Requirement("plain: largest sum of contact forces", pressed(straight), 0.2, "N", least=True),
        Requirement("plain: deepest contact of a link", _deepest(straight), 0.0005, "m"),
    ]


def missed(run: Trajectory) -> float:
    """Return how far the tip is off its target at the end [m]."""
    return float(np.linalg.norm(run.tip[-1] - run.target[-1]))


def pressed(run: Trajectory) -> float:
    """Return the largest sum of contact forces [N]."""
    assert run.contacts is not None
    return float(run.contacts.total(len(run)).max())


def _deepest(run: Trajectory) -> float:
    assert run.contacts is not None
    return float(run.contacts.depth.max(initial=0.0))
