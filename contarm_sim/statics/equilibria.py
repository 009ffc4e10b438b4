"""Static poses in bulk: one arm under many loads, many arms under one, or a load for each arm."""

from __future__ import annotations

import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from contarm_sim.display import Shown
from contarm_sim.engine.plant import engine_room
from contarm_sim.engine.threads import allowed, shared_out
from contarm_sim.errors import ContarmError, InputError
from contarm_sim.kinematics.arrays import Array
from contarm_sim.mechanics import muscles
from contarm_sim.mechanics.pneumatics import pressure_for
from contarm_sim.model.arm import Arm
from contarm_sim.model.load import Load
from contarm_sim.model.parameters import check_count
from contarm_sim.statics.bunches import Solutions, empty, solve_bunch
from contarm_sim.statics.cases import Bunch, bunched, cases, guesses
from contarm_sim.statics.continuation import METHODS, Method
from contarm_sim.statics.equilibrium import Equilibrium, equilibrium


@dataclass(frozen=True, eq=False, repr=False)
class Equilibria(Shown):
    """Static poses of C cases; positions [m] and frames in the base frame.

    Rows of cases that have none are NaN (False, 0), and so is what an arm of fewer links or muscles does not have.

    Attributes:
        frames: 4x4 frames at the stations, from the base to the tip, shape (C, N + 1, 4, 4), N the most links.
        tip: tip positions [m], shape (C, 3).
        tip_rotation: orientations of the tip, shape (C, 3, 3).
        muscle_lengths: [m], shape (C, M), M the most muscles.
        muscle_tensions: [N], pulling > 0, shape (C, M).
        qpos: joint angles [rad], shape (C, dofs).
        residual: largest generalised force left [N m], shape (C,).
        iterations: evaluations of the stiffness matrix, shape (C,).
        stable: whether the arm would stay there, shape (C,).
        held: whether no length servo is at its limit, shape (C,); False too where muscles are driven otherwise.
        failed: why a case has no equilibrium, by its number: the error that `equilibrium` raises.
        smallest_eigenvalue: of the stiffness matrix [N m/rad], shape (C,); None unless asked for.
        growth: fastest growth of a small disturbance [1/s], shape (C,), see `Solution`; likewise.
        tip_compliance: displacement [m] and rotation [rad] of the tip by force [N] and couple [N m], shape (C, 6, 6);
            likewise.
        arms, loads: of the cases.
        method: how they were solved.
        seconds: time to solve, building models included, a case's share.
    """

    frames: Array
    tip: Array
    tip_rotation: Array
    muscle_lengths: Array
    muscle_tensions: Array
    qpos: Array
    residual: Array
    iterations: NDArray[np.intp]
    stable: NDArray[np.bool_]
    held: NDArray[np.bool_]
    failed: dict[int, ContarmError]
    smallest_eigenvalue: Array | None
    growth: Array | None
    tip_compliance: Array | None
    arms: Sequence[Arm]
    loads: Sequence[Load]
    method: Method
    seconds: float

    def __len__(self) -> int:
        return len(self.tip)

    def __repr__(self) -> str:
        return f"Equilibria({len(self)} cases, {len(self.failed)} without)"

    @property
    def found(self) -> NDArray[np.bool_]:
        """Whether a case has an equilibrium, shape (C,)."""
        return ~np.isin(np.arange(len(self)), list(self.failed))

    def case(self, index: int) -> Equilibrium:
        """Return all that `equilibrium` says of a case, details that were not asked for computed anew.

        Raises:
            EquilibriumError, InputError: the case has no equilibrium; says why.
        """
        index = range(len(self))[index]
        if index in self.failed:
            raise self.failed[index]
        arm, load, iterations = self.arms[index], self.loads[index], int(self.iterations[index])
        qpos = self.qpos[index][~np.isnan(self.qpos[index])]
        if self.smallest_eigenvalue is None or self.growth is None or self.tip_compliance is None:
            return replace(equilibrium(arm, load, self.method, qpos), iterations=iterations, seconds=self.seconds)
        own = slice(0, muscles.count(arm))
        return Equilibrium(
            float(self.residual[index]), float(self.smallest_eigenvalue[index]), float(self.growth[index]), iterations,
            frames=self.frames[index, : arm.links + 1], muscle_lengths=self.muscle_lengths[index, own],
            muscle_tensions=self.muscle_tensions[index, own], tip_compliance=self.tip_compliance[index],
            held=bool(self.held[index]) if load.muscles.servos else None, seconds=self.seconds, qpos=qpos,
        )  # fmt: skip

    def __iter__(self) -> Iterator[Equilibrium]:
        return (self.case(index) for index in range(len(self)))

    @property
    def pressures_needed(self) -> Array:
        """Gauge pressures [Pa] that pneumatic muscles need for these tensions, shape (C, M); inf where none does it."""
        out = np.full(self.muscle_tensions.shape, np.nan)
        of_arm: dict[int, list[int]] = {}
        for index, arm in enumerate(self.arms):
            of_arm.setdefault(id(arm), []).append(index)
        for places in of_arm.values():
            arm = self.arms[places[0]]
            own = slice(0, muscles.count(arm))
            out[places, own] = pressure_for(self.muscle_tensions[places, own], self.muscle_lengths[places, own], arm)
        return out


def equilibria(
    arms: Arm | Sequence[Arm],
    loads: Load | Sequence[Load] | None = None,
    *,
    method: Method = "auto",
    guess: Any = None,
    threads: int = 1,
    details: bool = False,
) -> Equilibria:
    """Return the static poses of many cases: `equilibrium` of each, to the bit, at a fraction of its time.

    Cases of arms that differ in gravity and in the stiffness and damping of sections alone are solved together; an arm
    of other lengths, masses or links takes a model of its own.

    Args:
        arms: one for all cases, or one for each.
        loads: likewise; default none.
        method: as of `equilibrium`.
        guess: joint angles to start from [rad], shape (dofs,), or (C, dofs) for cases of as many joints.
        threads: most that share the work; 0: one a processor. Results do not depend on it.
        details: also find smallest eigenvalues, growth and compliance of the tip, which take longer than the pose.

    Raises:
        InputError: arguments of another kind, or not as many arms as loads. What is wrong with one case alone is
            in `failed`. Arms that can touch something, which `equilibrium` finds one by one.
    """
    each_arm, each_load = cases(arms, loads)
    for arm in each_arm:
        arm.refuse_objects("many poses at once are found")
    if method not in METHODS:
        raise InputError("method", repr(method), ", ".join(METHODS))
    check_count("threads", threads, 0)
    bunches = bunched(each_arm, each_load, guesses(guess, len(each_arm)), allowed(threads))
    began = time.perf_counter()
    with engine_room():
        solved = shared_out(lambda bunch: solve_bunch(bunch, method, details), bunches, threads)
    found = _gathered(each_arm, each_load, method, bunches, solved, details)
    return replace(found, seconds=(time.perf_counter() - began) / max(len(found), 1))


def _gathered(
    arms: Sequence[Arm],
    loads: Sequence[Load],
    method: Method,
    bunches: list[Bunch],
    solved: list[Solutions],
    details: bool,
) -> Equilibria:
    """Return the rows of all bunches in the order of the cases."""
    sizes = [found.size for found in solved]
    out: dict[str, Any] = empty(len(arms), np.max(sizes, axis=0) if sizes else (0, 0, 0), details)
    tip, failed = np.full((len(arms), 4, 4), np.nan), dict[int, ContarmError]()
    for bunch, found in zip(bunches, solved, strict=True):
        for name, array in found.arrays.items():
            out[name][(bunch.places, *(slice(size) for size in array.shape[1:]))] = array
        tip[bunch.places] = found.arrays["frames"][:, -1]
        failed |= {int(bunch.places[case]): error for case, error in found.failed.items()}
    given: dict[str, Any] = {name: out.get(name) for name in ("smallest_eigenvalue", "growth", "tip_compliance")} | out
    return Equilibria(
        **given, tip=tip[:, :3, 3], tip_rotation=tip[:, :3, :3], failed=dict(sorted(failed.items())), arms=arms,
        loads=loads, method=method, seconds=0.0,
    )  # fmt: skip
