"""Random sane arms in motion, under every controller: they run, and a quarter of the step hardly moves the tip."""

from dataclasses import replace

import numpy as np
import pytest
from random_arms import can_stand, random_arm
from references import moving

from contarm_sim.control.registry import NAMES
from contarm_sim.errors import ContarmError
from contarm_sim.kinematics import arc
from contarm_sim.motion.simulate import STEP_LIMIT, Stepping, simulate

RATE = 100.0


def _standing(rng, links=60, weight=np.inf):
    """Return an arm with random damping, and bends of a smooth motion there and back through which it can stand.

    Args:
        links: most links.
        weight: most m g L^2/EI: heavier arms swing for long, in short steps; given, nothing rubs either.
    """
    while True:
        arm = random_arm(rng, twist=0.3, spans=0.2)
        arm = replace(arm, damping_time=float(rng.choice([0.003, 0.02, 0.05, 0.2])), links=min(arm.links, links))
        if np.isfinite(weight):  # dry friction makes motions that no step settles
            arm = replace(arm, joint_friction=None, muscle=replace(arm.pneumatics, braid_friction=None))
        farthest = arc.from_polar(rng.uniform(0.2, 1.8), rng.uniform(-np.pi, np.pi))
        heavy = (arm.mass + arm.payload) * np.linalg.norm(arm.gravity) * arm.length**2 > weight * arm.bending_stiffness
        if arm.links >= 6 and not heavy and can_stand(arm, farthest) and can_stand(arm, 0.5 * farthest):
            time = np.arange(0, rng.uniform(1.0, 2.0), 1 / RATE)
            return arm, np.sin(np.pi * time / time[-1])[:, None] ** 2 * farthest


def _moves(rng, controller, links=60, weight=np.inf):
    """Move an arm; return whether its step is said to be short enough, which a quarter of it then confirms."""
    arm, bend = _standing(rng, links, weight)
    reference = moving(arm, bend, rate=RATE)
    run = simulate(arm, reference, controller)
    if np.nanmax(run.step_error) >= STEP_LIMIT * arm.length:
        return False
    finer = simulate(arm, reference, controller, stepping=Stepping(0.25 * run.timestep))
    off = np.linalg.norm(run.tip - finer.tip, axis=1).max()
    assert off < STEP_LIMIT * arm.length, (arm, controller, run.timestep)
    assert run.muscle_tensions.max() < 1.5 * arm.muscle.blocked_force or controller in ("paper", "chain")
    return True


@pytest.mark.parametrize("controller", ["chain", "feedforward", "servo", "tip"])
def test_random_arms_that_can_stand_move(controller):
    assert _moves(np.random.default_rng(NAMES.index(controller)), controller, links=10, weight=10.0)


@pytest.mark.slow
@pytest.mark.parametrize("controller", NAMES)
def test_nearly_all_random_arms_that_can_stand_move(controller):
    """At least 85 % do, but for those whose pressures are not enough, which is said; the step of some is not found."""
    rng, failed, count = np.random.default_rng(100 + NAMES.index(controller)), [], 25
    for _ in range(count):
        try:
            if not _moves(rng, controller):
                failed.append("time step")
        except ContarmError as error:
            failed.append(str(error))
    said = [message for message in failed if "kPa" in message or "length it cannot take" in message]
    assert len(failed) - len(said) <= 0.15 * count, failed
