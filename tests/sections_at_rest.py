"""Bends of several sections that tensions hold without gravity, in closed form: simulated, as chain, and as arc."""

from itertools import accumulate, pairwise

import numpy as np

from contarm_sim.kinematics import arc, hinges, sections
from contarm_sim.kinematics.backbone import Backbone
from contarm_sim.kinematics.muscles import directions
from contarm_sim.model.arm import Arm
from contarm_sim.model.load import Load, Muscles
from contarm_sim.model.routing import Routing
from contarm_sim.model.section import Section
from contarm_sim.statics.equilibrium import equilibrium

LARGEST = np.radians(120)
LEAST = 5.0
"""Tension of the slackest muscle of each section [N]."""

PARTS = ((0.20, 0.12, 0.018, 3, 0.0), (0.17, 0.08, 0.016, 4, 0.5), (0.14, 0.06, 0.015, 3, 1.2),
         (0.10, 0.05, 0.014, 3, -0.8))  # fmt: skip
"""Length [m], EI [N m^2], muscle radius [m], muscles, angle of the first [rad] of each section."""


def arm_of(size, links, start):
    """Return the arm of the first `size` parts, muscles from their section or from the base."""
    parts = PARTS[:size]
    return Arm(
        sections=tuple(Section(length=length, links=links, bending_stiffness=EI) for length, EI, *_ in parts),
        routings=tuple(Routing(radius=r, count=n, offset=turn, start=start) for *_, r, n, turn in parts),
    )


def random_bends(seed, count, size):
    """Return bends to `LARGEST` a section [rad], (count, size, 2)."""
    rng = np.random.default_rng(seed)
    return arc.from_polar(rng.uniform(0, LARGEST, (count, size)), rng.uniform(-np.pi, np.pi, (count, size)))


def holding(arm, bends):
    """Return the tensions of all muscles that hold bends (size, 2): each section's moment is r sum T u through it."""
    moments = [
        section.bending_stiffness / section.length * hinges.angles(bend, section.links)[0]
        for section, bend in zip(arm.sections, bends, strict=True)
    ]
    values = []
    for number, line in enumerate(arm.routings):
        passed = moments[number + 1] if line.start == "base" and number + 1 < len(moments) else 0.0
        pulls = 2 / (line.count * line.radius) * directions(line.angles) @ (moments[number] - passed)
        values.append(pulls - pulls.min() + LEAST)
    return np.concatenate(values)


def simulated(arm, bends):
    """Return the simulated arm that these tensions hold."""
    return equilibrium(arm, Load(muscles=Muscles(kind="tensions", values=tuple(holding(arm, bends)))))


def chain_frames(arm, bends):
    """Return the frames of the chain of hinges at all stations: closed forms of each section, multiplied."""
    frame, places = np.eye(4), [np.eye(4)[None]]
    for section, bend in zip(arm.sections, bends, strict=True):
        own = frame @ hinges.frames(bend, section.length, section.links)
        places.append(own[1:])
        frame = own[-1]
    return np.concatenate(places)


def smooth_points(arm, bends, links=None):
    """Return the points at all stations, of arcs, or of chains of so many ball joints a section."""
    lengths = tuple(section.length for section in arm.sections)
    ends = accumulate(lengths, initial=0.0)
    xi = [np.linspace(low, high, section.links, endpoint=False) for (low, high), section in
          zip(pairwise(ends), arm.sections, strict=True)]  # fmt: skip
    places = np.append(np.concatenate(xi) / sum(lengths), 1.0)
    backbone = Backbone(lengths=lengths, links=links and (links,) * len(lengths))
    return sections.position(np.broadcast_to(bends, (len(places), *bends.shape)), backbone, places)
