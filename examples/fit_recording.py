"""A recording of an arm that differs from its data sheet, fitted; it predicts commands that were held out."""

from dataclasses import replace

from contarm_sim import Actuation, Arm, Marker, Rig, Routing, Section, Tendon, World, fit
from contarm_sim.identify.synthetic import random_windings, recorded

section = Section(length=0.15, links=8, mass=0.05, bending_stiffness=0.03)
routings = (Routing(radius=0.015, start="base"), Routing(radius=0.015, offset=0.6, start="base"))
sheet = Arm(sections=(section,) * 2, routings=routings, laws=(Tendon(),) * 2, world=World(gravity=(0, 0, 9.81)))
rig = Rig(markers=(Marker(name="middle", xi=0.5), Marker(name="tip")), actuation=Actuation(channels=tuple(range(6))))

softer = tuple(replace(section, bending_stiffness=stiffness) for stiffness in (0.022, 0.037))
real = replace(sheet, sections=softer)
shifted = replace(rig, position=(0.003, -0.002, 0.0))
commands, patterns = random_windings(sheet, 120, seed=1, samples=12)
recording = recorded(real, shifted, commands, seed=2, noise=0.0005, gaps=0.05, blocks=patterns)

free = ["section_1.bending_stiffness", "section_2.bending_stiffness", "frame.x", "frame.y", "damping_time"]
found = fit(sheet, recording.in_rig(rig), free, held_out=0.3)
for one in found.parameters:
    print(f"{one.name:28} {one.value:8.4f}, 95 % interval {one.low:8.4f} to {one.high:8.4f} {one.unit}: {one.status}")
(left,) = found.left
print(f"fitted {1e3 * left.rms(~left.held_out):.2f} mm rms, held out {1e3 * left.rms(left.held_out):.2f} mm")
