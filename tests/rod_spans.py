"""The rod of several sections whose muscles run straight from disk to disk, by the collocation of `rod`.

Disks are where the stations of the arm are; a muscle runs through the holes of those from its first section to its own.
"""

from types import SimpleNamespace

import numpy as np
from collocation import grid_of
from rod import System, raised, tension
from threadpoolctl import threadpool_limits


@threadpool_limits.wrap(limits=1, user_api="blas")
def spans_of_sections(arm, *, tensions=None, pressures=None, wrenches=()):
    """Return the equilibrium of an arm of sections that all twist or none; arguments as of `rod_sections.rod`."""
    return raised(_Sections(arm, tensions, pressures, wrenches))


class _Sections(System):
    """Residual and tangent with stiffness and weight of each section, and holes of its own muscles and those beyond."""

    def __init__(self, arm, tensions, pressures, wrenches):
        ends = np.cumsum([0.0, *(section.length for section in arm.sections)])
        disks = [
            low + np.arange(section.links) * section.link_pitch
            for low, section in zip(ends, arm.sections, strict=False)
        ]
        disks = np.append(np.concatenate(disks), ends[-1])
        dead = ((1.0, arm.payload * np.array(arm.gravity), (0, 0, 0)), *wrenches)
        breaks = np.unique(np.round(np.concatenate([disks / arm.length, [xi for xi, *_ in dead]]), 12))
        grid = grid_of(tuple(breaks), arm.length, 4)
        self.arm, self.grid, self.disks, self.W = arm, grid, True, len(dead)
        own = [arm.sections[np.searchsorted(ends, s) - 1] for s in grid.nodes]
        self.n = 2 if own[0].torsional_stiffness is None else 3
        self.K = np.array([[s.bending_stiffness, s.bending_stiffness, s.torsional_stiffness or 0.0] for s in own])
        self.actuation = self.follower = np.zeros(3)
        self._add_muscles(arm, ends, disks, tensions, pressures)
        G, M = len(grid.nodes), len(self.r)
        points = np.concatenate([[xi * arm.length for xi, *_ in dead], np.repeat(disks, M)])
        self.S = np.vstack([grid.S, grid.integrals(points)])
        self.E = np.hstack([grid.weights - grid.S, points > grid.nodes[:, None]])
        self.offset = np.concatenate([np.zeros((G + self.W, 3)), np.tile(self.r, (len(disks), 1))])
        self.force, self.couple = np.zeros((2, len(self.S), 3))
        self.force[:G] = np.array([s.mass / s.length for s in own])[:, None] * np.array(arm.gravity)
        self.force[G : G + self.W] = [force for _, force, _ in dead]
        self.couple[G : G + self.W] = [moment for *_, moment in dead]

    def _add_muscles(self, arm, ends, disks, tensions, pressures):
        r, crossed, muscles = [], [], []
        for number, (line, law) in enumerate(zip(arm.routings, arm.laws, strict=True)):
            start, end = ends[0 if line.start == "base" else number], ends[number + 1]
            middles = 0.5 * (disks[1:] + disks[:-1])
            for index in range(line.count):
                angle = line.offset + 2 * np.pi * index / line.count
                r.append([line.radius * np.cos(angle), line.radius * np.sin(angle), 0.0])
                crossed.append((start < middles) & (middles < end))
                muscles.append(SimpleNamespace(muscle=law, length=end - start))
        self.r, self.crossed = np.array(r), np.array(crossed).T[..., None]

        def drive(lengths, share):
            if pressures is None:
                return share * np.asarray(tensions, dtype=float), np.zeros(len(r))
            forces = [tension(share * P, L, one) for P, L, one in zip(pressures, lengths, muscles, strict=True)]
            return np.array(forces).T

        self.drive = drive

    def _spans(self, a, da, scale, f, df):
        """Write the forces on the holes into f, their change into df; return lengths and tensions."""
        shape = (-1, len(self.r), 3)
        a, da = a.reshape(shape), da.reshape(*shape, da.shape[-1])
        d, dd = np.diff(a, axis=0), np.diff(da, axis=0)
        span = np.linalg.norm(d, axis=-1, keepdims=True)
        d = self.crossed * d / span
        stretch = np.einsum("kia,kian->kin", d, dd)
        lengths = (self.crossed * span).sum(axis=(0, 2))
        T, slope = self.drive(lengths, scale)
        pull = T[:, None] * d
        dpull = T[:, None, None] * (self.crossed[..., None] * dd - d[..., None] * stretch[:, :, None]) / span[..., None]
        dpull += d[..., None] * (slope[:, None] * stretch.sum(axis=0))[:, None]
        for forces, pulls in ((f.reshape(a.shape), pull), (df.reshape(da.shape), dpull)):
            forces[:-1] += pulls
            forces[1:] -= pulls
        return lengths, T
