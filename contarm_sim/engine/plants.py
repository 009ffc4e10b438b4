"""Many arms in the engine at once, each to the bits of a `Plant` of its own, stepped on threads."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any, ClassVar, Self

import mujoco
import numpy as np
from mujoco.batch import Batch
from numpy.typing import ArrayLike

from contarm_sim.engine.layout import layout
from contarm_sim.engine.models import Built, built
from contarm_sim.engine.moved import STATE, MovedArms
from contarm_sim.engine.plant import Plant
from contarm_sim.engine.threads import thread_count
from contarm_sim.errors import DivergenceError, InputError
from contarm_sim.kinematics.arrays import Array
from contarm_sim.mjcf import TIMESTEP, Actuation
from contarm_sim.model.arm import Arm


class Plants(MovedArms):
    """B simulated arms of one layout, see `layout`: M muscles, D joint angles, K stations each.

    They may differ in all that leaves the layout as it is: lengths, stiffness, mass, damping, friction, gravity,
    payload, muscle law. Every array has a leading axis of arms; arms are frozen, and left out of later steps, once they
    diverge. Step them in an `engine_room`.

    Args:
        arms: their parameters.
        actuation, pull_only, integrator: as of `Plant`.
        timestep: engine step [s], one or one for each arm; default 5 ms.
        threads: that step them, fewer where there are few arms; 0: one a processor.
        compiled: what makes an arm's model, of the caller's own; default `models.built`.
        persistent: keep all of the engine's data of every arm, so that `step(stage=...)` costs nothing extra.

    Attributes:
        arms: their parameters; `become` changes them.
        actuation: what drives the muscles.
        batch: the engine's. Its derived fields are, as after `mj_step`, of the state before the last substep.
        models: of the arms, the caller's to change before the first step.
        index: where the parts of the first arm are in them; those of all but for `zero` and `by_angle`.
        control: controls as a view, shape (B, M): length changes [m], pressures [Pa] or tensions [N]. Where muscles
            have several actuators they take the same control: shape (B, R, M).
        centres: centres of base plate, disks and tip plate [m], shape (B, K, 3), as last derived; not to be written.
        sensors: what the engine's sensors read, shape (B, sensors), likewise.
        zero: muscle length at which the engine's is zero [m], shape (B, M).
        damping: of muscles along themselves [N s/m], shape (B, M).
        failed: the error of each arm that diverged, by its place.

    Raises:
        InputError: no arms, arms of several layouts, or not as many time steps as arms.
    """

    engine: ClassVar[Callable[..., Any]] = Batch
    at_once: ClassVar[int] = 256  # motions under way together, whose records are in memory

    def __init__(
        self,
        arms: Sequence[Arm],
        actuation: Actuation = "lengths",
        pull_only: bool = True,
        timestep: float | ArrayLike | None = None,
        integrator: mujoco.mjtIntegrator | None = None,
        threads: int = 0,
        *,
        compiled: Callable[[Arm, Actuation], Built] = built,
        persistent: bool = False,
    ) -> None:
        if not len(arms):
            raise InputError("arms", "none", "one arm or more")
        self._pull_only, self._integrator, self._compiled = pull_only, integrator, compiled
        self._begin(arms, [compiled(arm, actuation) for arm in arms], actuation, timestep, threads, persistent)
        for place in range(len(arms)):
            self._adopt(place)

    def _begin(
        self, arms: Sequence[Arm], own: Sequence[Built], actuation: Actuation, timestep: float | ArrayLike | None,
        threads: int, persistent: bool,
    ) -> None:  # fmt: skip
        self.arms, self.actuation, self.failed = list(arms), actuation, dict[int, DivergenceError]()
        if len({layout(one) for one in own}) > 1:
            raise InputError("arms", "of several layouts", "arms of one")
        self._own, self.models, self.index = list(own), [one.model for one in own], own[0].index
        self._steps = self._each(TIMESTEP if timestep is None else timestep)
        self.batch = self.engine(self.models[0], len(arms), thread_count(len(arms), threads), persistent)
        self._views()
        self._stack()

    @classmethod
    def of(cls, plants: Sequence[Plant], threads: int = 0) -> Self:
        """Return arms that go on from where single ones are, on the models of these.

        Raises:
            InputError: plants of several layouts.
        """
        many, first = cls.__new__(cls), plants[0]
        many._pull_only, many._integrator, many._compiled = first.pull_only, first.integrator, built
        steps = [plant.model.opt.timestep for plant in plants]
        many._begin(
            [plant.arm for plant in plants], [plant.own for plant in plants], first.actuation, steps, threads, False
        )
        states = np.empty(many.state.shape)
        for row, plant in zip(states, plants, strict=True):
            mujoco.mj_getState(plant.model, plant.data, row, STATE)
        many.go_back(states)
        return many

    @staticmethod
    def check_installed() -> None:
        """Refuse to begin where a library is missing, see `backends`."""

    @staticmethod
    def alike(plant: Plant) -> Any:
        """Return what arms must have in common beside their layout, see `backends`."""
        return None

    def _adopt(self, place: int) -> None:
        model = self.models[place]
        if not self._pull_only:
            self._own[place].unlimit()
        if self._integrator is not None:
            model.opt.integrator = self._integrator
        self._own[place].step_by(self._steps[place])

    def __len__(self) -> int:
        return len(self.arms)

    @property
    def timestep(self) -> Array:
        """Engine step of each arm [s], shape (B,); assign one or one for each."""
        return self._steps

    @timestep.setter
    def timestep(self, given: float | ArrayLike) -> None:
        self._steps = self._each(given)
        for own, step in zip(self._own, self._steps, strict=True):
            own.step_by(step)
        self.batch.set_models(self.models)

    def _each(self, timestep: float | ArrayLike) -> Array:
        try:
            return np.broadcast_to(np.asarray(timestep, dtype=float), len(self.arms)).copy()
        except ValueError:
            raise InputError("timestep", f"of shape {np.shape(timestep)}", f"one, or {len(self.arms)}") from None

    def become(self, arms: Mapping[int, Arm]) -> None:
        """Take the parameters of other arms, by place; these must be reset afterwards.

        Raises:
            InputError: an arm of another layout.
        """
        changed = {place: arm for place, arm in arms.items() if arm != self.arms[place]}
        own = {place: self._compiled(arm, self.actuation) for place, arm in changed.items()}
        if any(layout(one) != layout(self._own[0]) for one in own.values()):
            raise InputError("arms", "of another layout", "arms of the same")
        for place, arm in changed.items():
            self.arms[place], self._own[place] = arm, own[place]
            self.models[place] = own[place].model
            self._adopt(place)
        if changed:
            self._stack()
