"""Lean: the arm leans on a wall, and its tip is stiffer for it."""

from __future__ import annotations

import numpy as np

from contarm_sim.demos.checks import Check
from contarm_sim.demos.demonstration import Demonstration, OnTick
from contarm_sim.demos.files import arm_of, knots_of, smooth
from contarm_sim.demos.probe import tip_stiffness
from contarm_sim.motion.simulate import CONTROL_RATE, Stepping, simulate
from contarm_sim.paths.reference import Reference
from contarm_sim.results.touched import object_forces

STEP = 0.0025
"""Engine step [s]."""


def demonstrate(on_tick: OnTick | None = None) -> Demonstration:
    """Simulate the same controls with the wall and without, and compare how stiff the tip is at the end."""
    arm = arm_of("lean")
    times, angles = knots_of("lean")
    time = np.arange(round(times[-1] * CONTROL_RATE) + 1) / CONTROL_RATE
    bend = np.zeros((len(time), 4))
    bend[:, 0::2] = smooth(times, angles, time)
    reference = Reference.from_bends(bend, arm, time)
    motions = []
    for number, one in enumerate((arm, arm.alone)):

        def tick(count: int, before: int = number * len(time)) -> object:
            return None if on_tick is None else on_tick(before + count, 2 * len(time))

        motions.append(simulate(one, reference, "feedforward", stepping=Stepping(STEP), on_tick=tick))
    leaning, free = motions
    assert leaning.contacts is not None
    stiff, slack = (tip_stiffness(each.arm, each.qpos[-1], each.setpoint[-1]) for each in motions)
    ratio = stiff / slack
    pressed = float(np.linalg.norm(object_forces(leaning.contacts, len(leaning))[-1], axis=-1).sum())
    deepest = float(leaning.contacts.depth.max(initial=0.0))
    checks = [
        Check("net force of the wall at the end", pressed, 0.2, "N", least=True),
        Check("deepest contact of a link", 1e3 * deepest, 0.5, "mm"),
        *(Check(f"tip stiffness along {axis}, leaning over free", float(ratio[i]), least, "x", least=True)
          for i, (axis, least) in enumerate((("X", 3.0), ("Y", 3.0), ("Z", 1.2)))),
    ]  # fmt: skip
    said = (
        f"the tip yields {1e3 / slack[0]:.0f} mm/N across the wall and {1e3 / slack[1]:.0f} mm/N along it when free, "
        f"{1e3 / stiff[0]:.1f} and {1e3 / stiff[1]:.1f} mm/N when the arm leans: what is between base and wall hardly "
        "moves, and only the rest bends"
    )
    return Demonstration(leaning, checks, said, free, ("leaning on the wall", "the same controls, no wall"),
                         camera=(-84.0, 5.0))  # fmt: skip
