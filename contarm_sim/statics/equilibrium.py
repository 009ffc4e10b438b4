"""The static pose of the simulated arm under any load, without waiting for it to swing out."""

from __future__ import annotations

import threading
import time
from collections import OrderedDict
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from contarm_sim.brevity import brief
from contarm_sim.engine.models import structure
from contarm_sim.engine.plant import Plant, engine_room
from contarm_sim.errors import InputError, expect
from contarm_sim.kinematics.arrays import Array, as_vectors
from contarm_sim.mechanics.pneumatics import pressure_for
from contarm_sim.mjcf import Actuation
from contarm_sim.model.arm import Arm
from contarm_sim.model.load import Load
from contarm_sim.statics.continuation import Method, solve
from contarm_sim.statics.driving import driven_plant
from contarm_sim.statics.failures import impossible
from contarm_sim.statics.leaning.lean import lean
from contarm_sim.statics.leaning.surroundings import Surroundings
from contarm_sim.statics.leaning.touch import HeldObject, Touch
from contarm_sim.statics.solver import Solution, Solver

REUSED = 8
"""Most plants that a thread keeps for the next load."""

_own = threading.local()


@dataclass(frozen=True, eq=False, repr=False)
class Equilibrium(Solution):
    """A static pose and how it was found; positions [m] and frames in the base frame. Equal only to itself.

    Attributes:
        frames: 4x4 frames at the stations, from the base to the tip, shape (N + 1, 4, 4). Station i is at
            s = i length/N; in an arm of several sections, at every link pitch of each.
        muscle_lengths: [m], shape (M,) of M muscles.
        muscle_tensions: [N], pulling > 0, shape (M,).
        tip_compliance: displacement [m] and rotation [rad] of the tip, base frame, by a small force [N] and couple
            [N m] there, shape (6, 6), muscles driven as they are. Its inverse is the stiffness where that exists: an
            inextensible straight arm does not give way along its axis.
        held: whether no length servo is at its limit; None where muscles are not driven by servos.
        seconds: time to solve, building the model not counted.
        qpos: joint angles [rad], shape (dofs,): a guess for a neighbouring load.
        contacts: where it leans on objects, without friction; smallest_eigenvalue and tip_compliance are then those
            of changes that keep these contacts closed.
        friction_range: how far from here friction at the contacts could hold the tip at most, to the first order [m]:
            with friction the arm may rest in a whole range of poses, about this one. None without contact, infinite
            where it comes to more than a quarter of the length.
        held_objects: free objects, which are held where they stand, and the force that it takes. Bodies of a
            host are held too, of which nothing is said here.
    """

    frames: Array
    muscle_lengths: Array
    muscle_tensions: Array
    tip_compliance: Array
    held: bool | None
    seconds: float
    qpos: Array
    contacts: tuple[Touch, ...] = field(default=(), kw_only=True)
    friction_range: float | None = field(default=None, kw_only=True)
    held_objects: tuple[HeldObject, ...] = field(default=(), kw_only=True)

    def __repr__(self) -> str:
        tip = ", ".join(f"{x:.4g}" for x in self.tip)
        pulled = f", tensions {brief(self.muscle_tensions)} N" if len(self.muscle_tensions) else ""
        leans = "".join(f", leans on {each.object} with {each.force:.3g} N" for each in self.contacts)
        return f"Equilibrium({'stable' if self.stable else 'NOT stable'}, tip ({tip}) m{pulled}{leans})"

    @property
    def tip(self) -> Array:
        """Tip position [m], shape (3,)."""
        return self.frames[-1, :3, 3]

    def pressures_needed(self, arm: Arm) -> Array:
        """Return the gauge pressures [Pa] that pneumatic muscles need for these tensions, inf where none does it."""
        return pressure_for(self.muscle_tensions, self.muscle_lengths, arm)


def equilibrium(arm: Arm, load: Load | None = None, method: Method = "auto", guess: Any = None) -> Equilibrium:
    """Return the static pose of an arm under its gravity, its payload and a load.

    Dry friction, which would hold the arm in a whole range of poses, is left out: this is that range's centre.

    Among objects it is a pose that a slow, strongly damped arm comes to from where it starts, without a jump through an
    object: the straight arm by default. Contact is rigid and without friction. Free objects are held where they stand,
    see `Equilibrium.held_objects`. Links touch as a smooth tube about the backbone. An arm that touches itself is
    refused.

    Args:
        method: `auto`, `newton` or `pseudo-transient` (see `statics.continuation`).
        guess: joint angles to start from [rad], shape (dofs,); default straight, or the uniform bend that
            the muscles ask for. Among objects: straight, or that bend where the straight arm overlaps an object.

    Raises:
        EquilibriumError: no equilibrium was reached, or only one with a negative stiffness; says how far it got. A
            pose that flutters under loads without energy is returned, and says so: `stable` is False.
        NoEquilibriumError: of these, a pose that no arm can take: a joint folded by more than a right angle, or a
            muscle of no length.
        InputError: a bend that pulling muscles cannot hold, pressures out of range, or arguments of another kind.
    """
    found = pose_at_rest(arm, load, method, guess)
    impossible(arm, found.qpos, found.muscle_lengths)
    return found


def pose_at_rest(arm: Arm, load: Load | None = None, method: Method = "auto", guess: Any = None) -> Equilibrium:
    """Return what `equilibrium` does, also of a pose that no arm can take."""
    load = Load() if load is None else load
    expect("arm", arm, Arm)
    expect("load", load, Load)
    plant = driven_plant(arm.alone, load, reused)
    if guess is not None:
        plant.data.qpos[:] = checked_guess(guess, plant.data.qpos.shape)
    with engine_room():
        solver, around = Solver(plant, load), _around(arm)
        start = time.perf_counter()
        leant = None if around is None else lean(solver, arm, around, method, guess is not None)
        found = solve(solver, method) if leant is None else leant.solution
        seconds = time.perf_counter() - start
    frames = np.tile(np.eye(4), (arm.links + 1, 1, 1))
    frames[:, :3, 3] = plant.stations
    frames[:, :3, :3] = plant.rotations
    return Equilibrium(
        frames=frames,
        muscle_lengths=plant.muscle_lengths,
        muscle_tensions=plant.muscle_tensions,
        tip_compliance=solver.tip_compliance() if leant is None else leant.compliance,
        **vars(found),
        held=_held(plant) if load.muscles.servos else None,
        seconds=seconds,
        qpos=plant.data.qpos.copy(),
        **({} if leant is None else leant.more),
    )


def _around(arm: Arm) -> Surroundings | None:
    """Return what an arm can touch, with all loaded that the search among it needs: it is not a part of its time."""
    if not arm.world.touchable:
        return None
    import scipy.optimize  # noqa: F401

    return Surroundings(arm)


def checked_guess(guess: Any, shape: tuple[int, ...]) -> Array:
    """Return joint angles to start from [rad], of the shape asked for.

    Raises:
        InputError: they are none, or not as many.
    """
    angles = as_vectors(guess, shape[-1], "guess")
    if angles.shape != shape:
        raise InputError("guess", f"of shape {angles.shape}", f"shape {shape}")
    return angles


def reused(arm: Arm, pull_only: bool = True, actuation: Actuation = "lengths") -> Plant:
    """Return a plant of this thread's own, used before if there is one of this structure."""
    plants = _own.__dict__.setdefault("plants", OrderedDict())
    key = (pull_only, structure(arm, actuation))
    plant = plants.pop(key, None)
    if plant is None:
        plant = Plant(arm, pull_only, actuation=actuation)
    else:
        plant.become(arm)
    plants[key] = plant
    if len(plants) > REUSED:
        plants.popitem(last=False)
    return plant


def _held(plant: Plant) -> bool:
    low, high = plant.model.actuator_forcerange.T
    force = plant.data.actuator_force
    return bool(np.all((force > low) & (force < high)))
