"""An arm of one's own from TOML: how far does the constant-curvature model hold for it, at rest?"""

from pathlib import Path

import numpy as np

from contarm_sim import Reference, compare, load_arm, poses_at_rest
from contarm_sim.kinematics import arc

arm = load_arm(Path(__file__).with_name("own_arm.toml"))
degrees = np.array([30.0, 60.0, 90.0, 120.0])
reference = Reference.from_bends(arc.from_polar(np.radians(degrees), 0.3), arm)
trajectory = poses_at_rest(arm, reference)
error = compare(trajectory).tip_error
for bend, off, tensions in zip(degrees, error, trajectory.muscle_tensions, strict=True):
    print(f"{bend:5.0f} deg: tip {100 * off / arm.length:5.2f} % of length off the arc, tensions {tensions.round(1)} N")
