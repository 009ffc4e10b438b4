"""A sweep: how much does the bending stiffness decide about sag, with perfect muscle lengths?"""

from dataclasses import replace

from contarm_sim import Arm, Reference, compare, poses_at_rest

hanging = Arm(gravity=(0, 0, 9.81))
for stiffness in (0.05, 0.1, 0.2, 0.4):
    arm = replace(hanging, bending_stiffness=stiffness)
    error = compare(poses_at_rest(arm, Reference.from_bends([[1.2, 0.0]], arm))).tip_error[0]
    number = arm.mass * 9.81 * arm.length**2 / stiffness
    print(f"EI {stiffness:4.2f} N m^2, m g L^2/EI {number:5.2f}: tip {100 * error / arm.length:5.2f} % of length off")
