"""A tendon wound in and let out again: the tip comes back another way, for three kinds of friction."""

from dataclasses import replace

import numpy as np

from contarm_sim import Arm, Load, Muscles, Routing, Section, Tendon
from contarm_sim.statics.memory import settle

arm = Arm(
    sections=(Section(length=0.2, links=12, mass=0.05, bending_stiffness=0.05),),
    routings=(Routing(radius=0.015),),
    laws=(Tendon(stiffness=2000, pretension=0.1),),
)
rubbing = {
    "none": arm,
    "backbone": replace(arm, friction_moment=0.03, friction_stiffness=0.1),
    "entry": replace(arm, muscle=replace(arm.muscle, friction=2.0)),
    "along the bend": replace(arm, muscle=replace(arm.muscle, friction_coefficient=0.3)),
}
phase = np.linspace(0, 4 * np.pi, 121)  # twice: the first turn comes from an arm that has held nothing yet
wound = 0.01 * (1 - np.cos(phase))
loads = [Load(muscles=Muscles(kind="setpoints", values=(-x, 0.05, 0.05))) for x in wound]  # the others are slack
found = settle(list(rubbing.values()), loads)
last = slice(60, 121)
for name, tip, tension in zip(rubbing, found.tip, found.start_tensions[:, last, 0], strict=True):
    apart = 1e3 * np.linalg.norm(tip[75] - tip[105])  # half wound in, and half let out
    lost = 1e3 * np.sum(0.5 * (tension[1:] + tension[:-1]) * np.diff(wound[last]))
    print(f"{name:15s} ways {apart:5.2f} mm apart, work lost in a turn {lost:6.2f} mJ")
