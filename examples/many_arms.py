"""Many arms at once: how far are hanging arms off a circle that differ in stiffness and mass?"""

from dataclasses import replace

import numpy as np

from contarm_sim import Arm, ContarmError, Reference, paths, simulate_many

hanging = Arm(links=12, gravity=(0, 0, 9.81))
circle = Reference.from_path(paths.named("circle", hanging.length, duration=3.0, max_bend=0.8), hanging)

rng = np.random.default_rng(1)
arms = [
    replace(hanging, bending_stiffness=hanging.bending_stiffness * stiffer, mass=hanging.mass * heavier)
    for stiffer, heavier in rng.uniform(0.7, 1.3, (16, 2))
]
found = simulate_many(arms, circle, "servo")

errors = [100 * one.tip_error.max() / hanging.length for one in found if not isinstance(one, ContarmError)]
print(f"{len(errors)} of {len(arms)} arms followed the circle")
print(f"largest tip error {min(errors):.2f} to {max(errors):.2f} % of length, median {np.median(errors):.2f} %")
