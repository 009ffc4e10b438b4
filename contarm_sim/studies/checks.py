"""What is checked of a simulation: at rest, hanging, in motion. Limits and their reasons stand in `verdict`."""

from __future__ import annotations

import math

from contarm_sim.model.arm import Arm
from contarm_sim.model.section import Section
from contarm_sim.results.summary import ErrorSummary, MuscleUse, Spread
from contarm_sim.studies import verdict as limits
from contarm_sim.studies.explained import RodParts
from contarm_sim.studies.timestep import TimeStep
from contarm_sim.studies.verdict import Check, at_most

_LENGTH = "% of length"


def ideal_checks(arm: Arm, errors: ErrorSummary, rod: RodParts, chain_error: Spread) -> list[Check]:
    """Return the checks of poses at rest without gravity: those of the closed forms, and the muscles'."""
    coarse, count = 24 / _fewest_links(arm), len(arm.sections)
    odd = sum(_twist_of_odd_links(section) for section in arm.sections)
    of_chain, of_arc = (limits.CHAIN_LIMIT, limits.ARC_LIMIT) if count == 1 else limits.SECTIONS_LIMITS
    chain, turned = of_chain * coarse**3, count * limits.ORIENTATION_LIMIT * coarse**3 + odd
    error, arc = errors.tip_error.max_percent, of_arc * coarse**2
    return [
        at_most("simulated against chain form", chain_error.max_percent, chain, _LENGTH,
                "without load the simulated tip is known in closed form"),
        at_most("simulated against arc", error, arc, _LENGTH, "a chain of that many links is nearer to the arc"),
        at_most("tip orientation", errors.orientation_error_deg, turned, "deg", "the hinges' twists cancel"),
        *muscle_checks(errors),
    ]  # fmt: skip


def _fewest_links(arm: Arm) -> int:
    """Return the number of links of the section that has the fewest: errors fall with it."""
    return min(section.links for section in arm.sections)


def _twist_of_odd_links(section: Section) -> float:
    """Return how far a section's end may be twisted [deg] where one hinge pair has no mirror image."""
    return math.degrees((math.pi / section.links) ** 2 / 4) if section.links % 2 else 0.0


def loaded_checks(arm: Arm, errors: ErrorSummary, rod: RodParts, chain_error: Spread) -> list[Check]:
    """Return the checks of poses at rest under gravity: lengths are held, and an ideal rod sags as much."""
    return [
        at_most("servo holds lengths", errors.servo.max_percent, limits.CHAIN_LIMIT, _LENGTH,
                "at rest lengths are held to rounding"),
        *shape_checks(arm, errors, rod),
        *muscle_checks(errors),
    ]  # fmt: skip


def run_checks(arm: Arm, errors: ErrorSummary, rod: RodParts, motion: Spread | None, step: TimeStep) -> list[Check]:
    """Return the checks of a motion; where the controller shifts lengths on purpose, how it holds them is not."""
    found = shape_checks(arm, errors, rod)
    if errors.holds_lengths:
        found.append(
            at_most("servo holds lengths", errors.servo.max_percent, limits.SERVO_LIMIT, _LENGTH,
                    "muscle lengths were not reached, so this says little about the model")
        )  # fmt: skip
    if motion is not None:
        found.append(
            at_most("motion share", motion.max_percent, limits.MOTION_LIMIT, _LENGTH,
                    "what moves the base, or the path, is too fast for this arm" if _rides(arm)
                    else "the path is too fast for this arm; a longer --duration helps")
        )  # fmt: skip
    found += muscle_checks(errors)
    if step.compared:
        found.append(
            at_most("time step", step.max_percent, limits.STEP_LIMIT, _LENGTH,
                    "the step itself puts the tip elsewhere; a smaller --timestep mends it", "converged")
        )  # fmt: skip
    where = "off the dome" if len(arm.sections) == 1 else "out of reach"
    reason = f"targets {where} cannot be reached: another path was followed"
    if errors.targets_in_millimetres:
        reason += "; divided by 1000 they can: are they in metres?"
    return [*found, at_most("miss", errors.miss.max_percent, limits.MISS_LIMIT, _LENGTH, reason, "targets")]


def shape_checks(arm: Arm, errors: ErrorSummary, rod: RodParts) -> list[Check]:
    """Return the checks that an ideal rod explains the shape, and that the pose is near enough to the model."""
    links = _fewest_links(arm)
    open_limit = min(limits.UNEXPLAINED_LIMIT * max(1.0, 24 / links) ** 2, limits.MODEL_LIMIT)
    left, reason = rod.unexplained, "the rod model predicts another tip for these lengths, weight and motion"
    if links < 24:
        reason += "; more --links may mend it"
    if arm.world.touchable and errors.contact_error is None:
        why = "the base may move" if _rides(arm) else "the motion was not repeated without objects"
        reason = f"what contact does is not known here: {why}"
    elif _rides(arm):
        reason = "the base may move here, and the rod's stands still"
    alone = ", without objects" * (errors.contact_error is not None and errors.contact_error.max_m > 0)
    return [
        at_most("not explained by an ideal rod", None if left is None else left.max_percent, open_limit, _LENGTH,
                reason),
        at_most(f"distance from the model{alone}", errors.tip_error.max_percent, limits.FAR_LIMIT, _LENGTH,
                "too far from the model to compare with it"),
    ]  # fmt: skip


def _rides(arm: Arm) -> bool:
    """Whether joints of a host may move the base."""
    return arm.world.host is not None and arm.world.host.moves


def muscle_checks(errors: ErrorSummary) -> list[Check]:
    """Return the checks of the muscles: contractions are what a braid allows; those that can only pull, do."""
    muscle, found = errors.muscle, []
    uses = [("", muscle)] if not errors.sections else [(f" in section {s.section}", s.muscle) for s in errors.sections]
    for of_section, use in uses:
        if use is not None:
            found += _contraction_checks(use, of_section)
    if not errors.pulls_only:
        return found
    depth = 100 * muscle.largest_push_n / max(muscle.max_force_n, 1e-12)
    share = "% of muscle samples"
    return [
        *found,
        at_most("slack", 100 * muscle.slack_fraction, limits.SLACK_LIMIT, share, "a slack muscle steers nothing"),
        at_most("pushes", 100 * muscle.push_fraction, limits.PUSH_LIMIT, share, "muscles cannot push"),
        at_most("largest push", depth, limits.PUSH_DEPTH_LIMIT, "% of the largest tension",
                "more than damping along a slack muscle does"),
    ]  # fmt: skip


def _contraction_checks(muscle: MuscleUse, of_section: str) -> list[Check]:
    low, high = muscle.allowed_contraction
    braid = "beyond what the braid allows"
    return [
        at_most(f"contraction{of_section}", 100 * muscle.max_contraction, 100 * high, "%", braid),
        at_most(f"stretch{of_section}", -100 * muscle.min_contraction, -100 * low, "%", braid),
    ]
