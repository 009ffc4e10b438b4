"""Poses at rest of many samples at once, with the controls that hold them; what needs more care is left out."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from contarm_sim.engine.plant import Plant, bent
from contarm_sim.kinematics.arrays import Array
from contarm_sim.statics.downhill import Settling
from contarm_sim.statics.holding_together import Holding
from contarm_sim.statics.poses import Poses, Starts
from contarm_sim.statics.stiffness import definite


@dataclass(frozen=True)
class Rested:
    """Samples that were found at rest.

    Attributes:
        samples: which of those asked for, shape (P,).
        qpos: joint angles [rad], shape (P, dofs).
        setpoint: controls that hold them, shape (P, M).
    """

    samples: NDArray[np.intp]
    qpos: Array
    setpoint: Array


def settled(plant: Plant, bend: Array, setpoint: Array) -> Rested:
    """Settle under set-points, shape (C, M), from bends [rad], shape (C, 2 S), as a call of `Solver` does."""
    problem = Settling(Poses(plant, _starts(plant, bend, setpoint)))
    found: dict[int, Array] = {}

    def arrived(rows: NDArray[np.intp]) -> None:
        found.update(zip(problem.places[rows].tolist(), problem.poses.qpos[rows], strict=True))

    problem(arrived)
    samples = np.array(sorted(found), dtype=int)
    return Rested(samples, np.array([found[i] for i in samples.tolist()]), setpoint[samples])


def held(
    plant: Plant, bend: Array, lengths: Array, tensions: Array, meant: Array | None = None,
    least_pressures: Array | None = None,
) -> Rested:  # fmt: skip
    """Meet muscle lengths [m], shape (C, n), from bends [rad], shape (C, 2 S), as `Holder` does, and `check` it.

    Args:
        tensions, meant, least_pressures: as of `Holding`; with the last, muscles are driven by pressures.
    """
    problem = Holding(Poses(plant, _starts(plant, bend)), lengths, tensions, meant, least_pressures)
    qpos, setpoint, holds = np.empty_like(problem.poses.qpos), np.empty_like(lengths), np.zeros(len(bend), dtype=bool)

    def arrived(rows: NDArray[np.intp]) -> None:
        cases = problem.places[rows]
        controls, possible = problem.setpoints() if least_pressures is None else problem.pressures()
        qpos[cases], setpoint[cases], holds[cases] = problem.poses.qpos[rows], controls[rows], possible[rows]

    problem(arrived)
    samples = np.flatnonzero(holds)
    if len(samples):
        stay = Settling(Poses(plant, Starts(qpos[samples], setpoint[samples])))
        small = stay.evaluate() <= 100 * stay.tolerance
        K = stay.linearise()
        samples = samples[small & definite(0.5 * (K + K.swapaxes(-1, -2)))]
    return Rested(samples, qpos[samples], setpoint[samples])


def _starts(plant: Plant, bend: Array, setpoint: Array | None = None) -> Starts:
    plant.reset()
    qpos = np.tile(plant.data.qpos, (len(bend), 1))
    bent(qpos, plant.arm, plant.index, bend.reshape(len(bend), -1, 2))
    return Starts(qpos, np.zeros((len(bend), plant.control.shape[1])) if setpoint is None else setpoint)
