"""Seeded load cases of arms of several unlike sections, with the ideal rod's answer, and a simulation's error."""

from dataclasses import dataclass, replace
from itertools import islice

import numpy as np
from rod_sections import NoEquilibriumError, Rod, rod
from rod_spans import spans_of_sections

from contarm_sim.model.arm import Arm
from contarm_sim.model.load import Load, Muscles, Wrench
from contarm_sim.model.routing import Routing
from contarm_sim.model.section import Section
from contarm_sim.statics.equilibrium import equilibrium

LARGEST_BEND = np.radians(150)
"""Largest integral of bending over a section of a kept case [rad]."""


@dataclass(frozen=True)
class Case:
    """An arm with its gravity and payload, and a load on it.

    Attributes:
        rod: its equilibrium.
    """

    arm: Arm
    load: Load
    rod: Rod

    def at(self, links, path="parallel"):
        """Return the arm with so many links in each section, or as many as a tuple says."""
        counts = links if isinstance(links, tuple) else (links,) * len(self.arm.sections)
        parts = [replace(section, links=count) for section, count in zip(self.arm.sections, counts, strict=True)]
        return replace(self.arm, sections=parts, routings=[replace(line, path=path) for line in self.arm.routings])

    def error(self, links, path="parallel"):
        """Return the largest distance of a simulated arm's stations from the rod [% of length]."""
        return self._from(self.rod, self.at(links, path))

    def span_error(self, links):
        """Return the same of an arm with straight spans, from the rod with disks at its stations."""
        arm = self.at(links, "spans")
        return self._from(spans_of_sections(arm, **_dead(self.load), **_driven(self.load)), arm, arm.length)

    def _from(self, true, arm, unit=1.0):
        found = equilibrium(arm, self.load)
        pitches = [section.link_pitch for section in arm.sections for _ in range(section.links)]
        points, _ = true.at(np.cumsum([0.0, *pitches]) / unit)
        return 100 * np.linalg.norm(found.frames[:, :3, 3] - points, axis=1).max() / arm.length

    def under(self, *wrenches):
        """Return the case with other wrenches, and its rod."""
        load = replace(self.load, wrenches=wrenches)
        return replace(self, load=load, rod=_rod(self.arm, load))


def random_cases(seed, count, drive, size=2, start="section", twist=False):
    """Return `count` cases of arms of `size` sections; more of them begin with these.

    Args:
        drive: moments (about the material axes, and a follower at the tip), tensions, or pressures.
        start: where muscles begin, section or base.
        twist: whether sections have a torsional stiffness.
    """
    return list(islice(_kept(np.random.default_rng(seed), drive, size, start, twist), count))


def _direction(rng):
    vector = rng.normal(size=3)
    return vector / np.linalg.norm(vector)


def _arm(rng, size, start, twist):
    sections, routings = [], []
    for _ in range(size):
        stiffness = float(np.exp(rng.uniform(np.log(0.05), np.log(0.2))))
        torsion = stiffness * rng.uniform(0.5, 1.0) if twist else None
        length, mass = rng.uniform(0.12, 0.25), rng.uniform(0.03, 0.15)
        sections.append(Section(length=length, mass=mass, bending_stiffness=stiffness, torsional_stiffness=torsion))
        radius, count = rng.uniform(0.012, 0.02), int(rng.choice([3, 4]))
        routings.append(Routing(radius=radius, count=count, offset=rng.uniform(0, 2 * np.pi), start=start))
    gravity = 9.81 * _direction(rng) * (rng.random() < 0.8)
    payload = rng.uniform(0, 0.1) * (rng.random() < 0.6)
    return Arm(sections=tuple(sections), routings=tuple(routings), gravity=tuple(gravity), payload=payload)


def _load(rng, drive, arm):
    places = (rng.uniform(0.2, 0.8), 1.0)
    wrenches = tuple(
        Wrench(xi=xi, force=tuple(rng.normal(0, 0.3) * _direction(rng)), moment=tuple(0.03 * rng.normal(size=3)))
        for xi in places
    )
    muscles = sum(line.count for line in arm.routings)
    if drive == "moments":
        return Load(
            wrenches=wrenches, actuation_moment=tuple(0.3 * rng.normal(size=2)),
            follower_moment=tuple(0.15 * rng.normal(size=3)),
        )  # fmt: skip
    values = rng.uniform(5, 80, muscles) if drive == "tensions" else rng.uniform(90e3, 700e3, muscles)
    return Load(wrenches=wrenches, muscles=Muscles(kind=drive, values=tuple(values)))


def _rod(arm, load):
    moments = {"actuation_moment": load.actuation_moment, "follower_moment": load.follower_moment}
    return rod(arm, **_dead(load), **moments, **_driven(load))


def _dead(load):
    return {"wrenches": [(wrench.xi, wrench.force, wrench.moment) for wrench in load.wrenches]}


def _driven(load):
    return {} if load.muscles.kind == "off" else {load.muscles.kind: load.muscles.values}


def _kept(rng, drive, size, start, twist):
    """Yield the random cases whose loads, raised in proportion from none, lead to a rod that is not bent too far."""
    while True:
        arm = _arm(rng, size, start, twist)
        load = _load(rng, drive, arm)
        try:
            found = _rod(arm, load)
        except NoEquilibriumError:
            continue
        if found.bends.max() < LARGEST_BEND and _usable(found, arm):
            yield Case(arm, load, found)


def _usable(found, arm):
    """Whether every muscle keeps within what its braid allows."""
    ranges = np.array([group.length_range for group in arm.groups for _ in range(group.routing.count)])
    return bool(np.all((found.lengths > ranges[:, 0]) & (found.lengths < ranges[:, 1])))
