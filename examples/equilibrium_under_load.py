"""Static poses under a growing force at the tip, and the tip's stiffness there."""

import numpy as np

from contarm_sim import Arm, Load, Muscles, Wrench, equilibrium

arm = Arm(gravity=(0, 0, 9.81), payload=0.05)
held = Muscles(kind="bend", values=(1.0, 0.0))  # length servos hold 1 rad towards muscle 1
for newtons in (0.0, 0.25, 0.5):
    pose = equilibrium(arm, Load(wrenches=(Wrench(xi=1, force=(0, newtons, 0)),), muscles=held))
    softest = 1 / np.linalg.eigvalsh(pose.tip_compliance[:3, :3]).max()
    print(f"{newtons:4.2f} N sideways: tip {(1e3 * pose.tip).round(1)} mm, softest direction {softest:.1f} N/m")
