"""Poses of two sections that the tests and benchmarks of their inverse kinematics aim at."""

import numpy as np

from contarm_sim.kinematics.backbone import Backbone

BACKBONES = {
    "arcs": Backbone(lengths=(0.2, 0.17)),
    "8:1": Backbone(lengths=(0.32, 0.04)),
    "1:8": Backbone(lengths=(0.04, 0.32)),
    "chains of 24": Backbone(lengths=(0.2, 0.17), links=(24, 24)),
    "chains, connectors": Backbone(lengths=(0.15, 0.2), links=(6, 6), connectors=(0.03, 0.05)),
    "connectors": Backbone(lengths=(0.15, 0.2), connectors=(0.05, 0.1)),
    "low limits": Backbone(lengths=(0.2, 0.2), limits=(2.0, 1.2)),
}
KINDS = ("random", "straight", "one straight", "planar", "limit of 1", "limit of 2", "both limits")


def poses(backbone, kind, count, seed=0):
    """Return bends [rad], shape (count, 2, 2)."""
    rng = np.random.default_rng(seed)
    angle = rng.uniform(size=(count, 2)) * backbone.limits
    plane = rng.uniform(-np.pi, np.pi, (count, 2))
    if kind == "straight":
        angle = 10 ** rng.uniform(-9, -1, (count, 2))
    elif kind == "one straight":
        angle[np.arange(count), rng.integers(2, size=count)] = 10 ** rng.uniform(-9, -1, count)
    elif kind == "planar":
        plane[:, 1] = plane[:, 0] + rng.choice([0, np.pi], count)
    elif kind == "limit of 1":
        angle[:, 0] = backbone.limits[0]
    elif kind == "limit of 2":
        angle[:, 1] = backbone.limits[1]
    elif kind == "both limits":
        angle[:] = backbone.limits
    return np.stack([angle * np.cos(plane), angle * np.sin(plane)], axis=-1)
