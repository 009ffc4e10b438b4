"""Rollouts of many arms at once: from angles and rates, under controls that change, seen at some steps."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from contarm_sim.engine.friction import BackboneFriction, has_friction
from contarm_sim.engine.plants import Plants
from contarm_sim.kinematics.arrays import Array
from contarm_sim.model.arm import Arm


class Rollouts:
    """P arms on their way, all with one step.

    Args:
        plants: the arms, without memory.
        arms: the same with it.
        timestep: [s].
    """

    def __init__(self, plants: Plants, arms: list[Arm], timestep: float) -> None:
        self._plants, self._step = plants, timestep
        self.friction = BackboneFriction(arms, plants.index) if any(map(has_friction, arms)) else None

    def run(
        self,
        qpos: Array,
        qvel: Array,
        ends: NDArray[np.intp],
        seen: NDArray[np.intp],
        stations: NDArray[np.intp],
        controls: Callable[[int], Array] | None,
    ) -> tuple[Array, Array]:
        """Return positions [m], shape (N, P, S, 3), and orientations, shape (N, P, S, 3, 3), of stations at steps.

        The first kick lasts half a step, as in `motion.release`: the rates are those of the start.

        Args:
            qpos, qvel: to start from [rad, rad/s], shape (P, D).
            ends: the last step that each arm is wanted at, shape (P,).
            seen: steps at which it is looked at, rising, shape (N,).
            stations: whose frames are wanted, shape (S,).
            controls: of a step, shape (P, M); None: nothing drives the muscles.
        """
        plants, friction = self._plants, self.friction
        points, turns = np.empty((len(seen), len(ends), len(stations), 3)), None
        turns = np.empty((*points.shape, 3))
        forces, orientations = plants.batch.bind("qfrc_applied"), plants.batch.bind("xmat")[:, plants.index.stations]
        plants.qpos[:], plants.qvel[:] = qpos, qvel
        done, row = 0, 0
        while row < len(seen):
            alone = friction is not None or controls is not None or plants.turning or done == 0
            count = 1 if alone else int(seen[row]) + 1 - done
            places = None if (ends >= done).all() else np.flatnonzero(ends >= done)
            if controls is not None:
                plants.send(controls(done))
            if friction is not None:
                friction.follow(plants.qpos)
                friction.push(forces)
            if plants.turning:
                plants.stiffen_twist()
            if done == 0:
                plants.timestep = 0.5 * self._step
                plants.step(1, places)
                plants.timestep = self._step
                plants.qpos[:] += 0.5 * self._step * plants.qvel
            else:
                plants.step(count, places)
            done += count
            if done - 1 == seen[row]:
                points[row] = plants.centres[:, stations]
                turns[row] = orientations[:, stations].reshape(turns.shape[1:])
                row += 1
        return points, turns
