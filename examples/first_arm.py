"""The paper's arm: forward and inverse kinematics, a motion in MuJoCo, and the difference between the two."""

import numpy as np

from contarm_sim import Arm, Reference, compare, paths, simulate
from contarm_sim.kinematics import arc, dome

arm = Arm()  # the paper's arm, SI units
bend = arc.from_polar(np.pi / 2, 0.0)  # 90 degrees towards muscle 1
tip = arc.position(bend, arm.length)  # forward kinematics
print("tip", tip.round(4), "m; bend from it", dome.bend_from_tip(tip, arm.length).bend.round(4), "rad")

path = paths.named("circle", arm.length, duration=20, max_bend=1.0)
trajectory = simulate(arm, Reference.from_path(path, arm))  # MuJoCo
print(trajectory)
print(f"largest tip error {1e3 * compare(trajectory).tip_error.max():.2f} mm")
