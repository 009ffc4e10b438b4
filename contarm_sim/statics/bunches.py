"""A bunch of cases, solved together; what does not come to rest so is solved alone."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from contarm_sim.engine.plant import Plant, bent
from contarm_sim.errors import ContarmError, InputError
from contarm_sim.kinematics.arrays import Array
from contarm_sim.model.arm import Arm
from contarm_sim.model.load import Load
from contarm_sim.statics.cases import Bunch
from contarm_sim.statics.continuation import Method
from contarm_sim.statics.driving import DRIVEN, checked_values, commands
from contarm_sim.statics.equilibrium import checked_guess, equilibrium, reused
from contarm_sim.statics.failures import possible
from contarm_sim.statics.poses import Poses, Starts, written
from contarm_sim.statics.solver import tolerance
from contarm_sim.statics.stiffness import solved
from contarm_sim.statics.together import Together


@dataclass
class Solutions:
    """What was found of the C cases of a bunch: rows of `Equilibria`, by name, and why cases have none."""

    arrays: dict[str, Array]
    failed: dict[int, ContarmError] = field(default_factory=dict)

    @property
    def size(self) -> tuple[int, int, int]:
        """How many stations, muscles and joint angles there are."""
        stations, lengths, qpos = (self.arrays[name].shape[1] for name in ("frames", "muscle_lengths", "qpos"))
        return stations, lengths, qpos


def empty(count: int, size: Sequence[int], details: bool) -> dict[str, Array]:
    """Return arrays for so many cases of a `size` (stations, muscles, joint angles), NaN where there are numbers."""
    stations, muscles, dofs = size
    shapes = {
        "frames": (stations, 4, 4), "muscle_lengths": (muscles,), "muscle_tensions": (muscles,), "qpos": (dofs,),
        "residual": (),
    }  # fmt: skip
    if details:
        shapes |= {"smallest_eigenvalue": (), "growth": (), "tip_compliance": (6, 6)}
    out: dict[str, Array] = {name: np.full((count, *shape), np.nan) for name, shape in shapes.items()}
    out |= {name: np.zeros(count, dtype=bool) for name in ("stable", "held")}
    return out | {"iterations": np.zeros(count, dtype=int)}


def solve_bunch(bunch: Bunch, method: Method, details: bool) -> Solutions:
    """Solve the cases of a bunch; inside an `engine_room`."""
    kind = bunch.loads[0].muscles.kind
    pull_only, actuation = DRIVEN[kind]
    plant = reused(bunch.arms[0], pull_only, actuation)
    count = len(bunch.places)
    found = Solutions(empty(count, (len(plant.centres), len(plant.index.zero), plant.model.nv), details))
    starts, ready = _starts(plant, bunch, found.failed)
    left = np.ones(count, dtype=bool)
    left[list(found.failed)] = False
    if method != "pseudo-transient" and len(ready):
        _together(plant, bunch, starts, ready, found, left)
    for case in np.flatnonzero(left).tolist():
        guess = None if bunch.guesses is None else bunch.guesses[case]
        try:
            one = equilibrium(bunch.arms[case], bunch.loads[case], method, guess)
        except ContarmError as error:
            found.failed[case] = error
            for array in found.arrays.values():
                array[case] = np.nan if array.dtype == float else 0
            continue
        for name, array in found.arrays.items():
            array[case] = bool(one.held) if name == "held" else getattr(one, name)
    return found


def _starts(plant: Plant, bunch: Bunch, failed: dict[int, ContarmError]) -> tuple[Starts, NDArray[np.intp]]:
    """Return the cases to be solved, and which of the bunch they are; those with wrong inputs are noted as failed."""
    plant.reset()
    count, M = len(bunch.places), len(plant.index.zero) if plant.model.nu else 0
    qpos, control = np.tile(plant.data.qpos, (count, 1)), np.zeros((count, M))
    own: dict[int, int] = {}
    which = np.array([own.setdefault(id(arm), len(own)) for arm in bunch.arms])
    alike: dict[tuple[int, str], list[int]] = {}
    for case, load in enumerate(bunch.loads):
        alike.setdefault((int(which[case]), load.muscles.kind), []).append(case)
    firsts = np.unique(which, return_index=True)[1]
    arms = [bunch.arms[first] for first in firsts.tolist()]
    for (number, kind), cases in alike.items():
        if kind != "off":
            _command(plant, arms[number], bunch.loads, cases, (qpos, control), failed)
    if bunch.guesses is not None:
        for case, guess in enumerate(bunch.guesses):
            qpos[case] = checked_guess(guess, plant.data.qpos.shape)
    told = []
    for arm in arms:
        if len(arms) > 1:
            plant.become(arm)
        told.append(written(plant))
    ready = np.setdiff1d(np.arange(count), list(failed))
    allowed = np.array([tolerance(arm) for arm in arms])
    return Starts(qpos[ready], control[ready], which[ready], tuple(told), allowed[which][ready]), ready


def _command(
    plant: Plant, arm: Arm, loads: Sequence[Load], cases: list[int], into: tuple[Array, Array],
    failed: dict[int, ContarmError],
) -> None:  # fmt: skip
    """Write the starts of cases of one arm, driven alike, into joint angles [rad] and controls."""
    qpos, control = into
    kind = loads[cases[0]].muscles.kind
    try:
        values = [checked_values(arm, loads[case]) for case in cases]
        bend, control[cases] = commands(arm, kind, np.array(values) if len(cases) > 1 else values[0])
    except InputError as error:
        if len(cases) == 1:
            failed[cases[0]] = error
            return
        for case in cases:
            _command(plant, arm, loads, [case], into, failed)
        return
    if bend is not None:
        angles = qpos[cases]
        bent(angles, arm, plant.index, bend.reshape(len(cases), -1, 2))
        qpos[cases] = angles


def _together(
    plant: Plant, bunch: Bunch, starts: Starts, ready: NDArray[np.intp], found: Solutions, left: NDArray[np.bool_]
) -> None:
    """Solve cases together, as far as that goes; those that are found are no longer `left`."""
    poses = Poses(plant, starts)
    newton = Together(poses, [bunch.loads[case] for case in ready.tolist()], starts.tolerance)
    out, index, details = found.arrays, plant.index, "growth" in found.arrays
    servos = plant.actuation == "lengths"

    def arrived(rows: NDArray[np.intp], K: Array) -> None:
        cases, data = ready[newton.places[rows]], poses.data
        frames = np.zeros((len(rows), len(plant.centres), 4, 4))
        frames[:, :, :3, 3] = data.xpos[rows, index.stations]
        frames[:, :, :3, :3] = data.xmat[rows, index.stations].reshape(len(rows), -1, 3, 3)
        frames[:, :, 3, 3] = 1.0
        out["frames"][cases], out["qpos"][cases] = frames, poses.qpos[rows]
        out["muscle_lengths"][cases], out["muscle_tensions"][cases] = poses.muscle_lengths[rows], newton.tensions[rows]
        out["residual"][cases], out["iterations"][cases] = newton.residual[rows], newton.iterations[rows]
        out["stable"][cases] = True
        if servos:
            out["held"][cases] = ~poses.at_limit[rows].any(axis=-1)
        if details:
            _detail(poses, rows, K, newton.symmetric[rows], cases, out)
            out["growth"][cases] = newton.growth[rows]
        left[cases] = ~possible(index, poses.qpos[rows], out["muscle_lengths"][cases])

    newton(arrived)


def _detail(
    poses: Poses, rows: NDArray[np.intp], K: Array, symmetric: NDArray[np.bool_], cases: NDArray[np.intp],
    out: dict[str, Array],
) -> None:  # fmt: skip
    """Write eigenvalues and compliance of stable poses whose stiffness matrices are K [N m/rad]."""
    out["smallest_eigenvalue"][cases] = np.linalg.eigvalsh(K)[:, 0]
    for i in np.flatnonzero(~symmetric).tolist():
        out["smallest_eigenvalue"][cases[i]] = np.linalg.eigvals(K[i]).real.min()
    J = np.array([poses.tip_jacobian(row) for row in rows.tolist()])
    out["tip_compliance"][cases] = J @ solved(K, J.swapaxes(-1, -2))
