"""Two sections: all bends that reach one point, and the arm at rest in those that take the least pressure."""

import numpy as np

from contarm_sim import Reference, compare, poses_at_rest, presets
from contarm_sim.kinematics import inverse
from contarm_sim.mechanics import shape
from contarm_sim.mechanics.pressures import pressure_needed

arm, target = presets.two(), np.array([0.15, 0.1, 0.25])
(family,) = inverse.solve_all(target, shape.backbone(arm))  # a closed curve of poses
pressure, _ = pressure_needed(family.reshape(len(family), -1), arm)
best = family[pressure.argmin()]
print(f"{len(family)} poses reach the point; they take {pressure.min() / 1e3:.0f} kPa or more")
print("least pressure at bends of", np.degrees(np.linalg.norm(best, axis=-1)).round(1), "deg")
found = compare(poses_at_rest(arm, Reference.from_bends([best], arm), "tip"))
print(f"simulated, hanging, controller tip: {1e3 * found.target_error[0]:.4f} mm from the point")
