"""What arms go through one load after the other: commands checked, and where each leads to."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from contarm_sim.engine.plant import bent
from contarm_sim.errors import InputError, expect
from contarm_sim.kinematics.arrays import Array
from contarm_sim.mechanics import muscles
from contarm_sim.model.arm import Arm
from contarm_sim.model.load import Load
from contarm_sim.statics.driving import DRIVEN, checked_values, commands
from contarm_sim.statics.equilibrium import reused
from contarm_sim.statics.rubbing import without_friction
from contarm_sim.statics.several import alike


@dataclass(frozen=True)
class Way:
    """What one arm goes through.

    Attributes:
        arms, bare: at each load, with and without friction.
        loads: T of them.
        control: of its muscles, shape (T, M).
        about: joint angles that its winches about make of the straight arm [rad], shape (T, dofs).
        key: alike of arms that go together.
        changes: whether it carries now this, now that.
        error: why it cannot be driven so; then `control` and `about` are empty.
    """

    arms: Sequence[Arm]
    bare: Sequence[Arm]
    loads: Sequence[Load]
    control: Array
    about: Array
    key: Any
    changes: bool
    error: InputError | None = None


def ways_of(arms: Any, loads: Any) -> list[Way]:
    """Return what each arm goes through; arguments as of `settle`.

    Raises:
        InputError: arguments of another kind, or that do not fit together.
    """
    each_arm = [arms] if isinstance(arms, Arm) else list(arms)
    every = list(loads)
    if not each_arm or not every:
        raise InputError("arms" if not each_arm else "loads", "none", "one or more")
    shared = isinstance(every[0], Load)
    if not shared and len(every) != len(each_arm):
        raise InputError("loads", f"for {len(every)} arms", f"for each of {len(each_arm)} arms, or the same for all")
    ways, bare = [], dict[int, Arm]()
    times = len(every) if shared else len(list(every[0]))
    for number, given in enumerate(each_arm):
        own = every if shared else list(every[number])
        several = [given] * times if isinstance(given, Arm) else list(given)
        if len(own) != times or len(several) != times:
            raise InputError("loads", f"{len(own)} for {len(several)} arms in time", f"{times}, as for the first arm")
        for load in own:
            expect("load", load, Load)
        for arm in several:
            if id(arm) not in bare:
                expect("arm", arm, Arm)
                arm.refuse_objects("poses that remember are found")
                bare[id(arm)] = without_friction(arm)
        ways.append(way_of(several, [bare[id(arm)] for arm in several], own))
    return ways


def way_of(arms: Sequence[Arm], bare: Sequence[Arm], loads: Sequence[Load]) -> Way:
    """Return what an arm goes through.

    Args:
        arms, bare, loads: of each time, with and without friction.

    Raises:
        InputError: another arm at another time, or loads that drive muscles now so, now otherwise.
    """
    first, kind = arms[0], loads[0].muscles.kind
    changes = any(arm is not first for arm in arms)
    if changes and any(replace(arm, world=first.world) != first for arm in {id(arm): arm for arm in arms}.values()):
        raise InputError("arms", "another arm at another time", "one arm that differs in payload and gravity alone")
    if any(load.muscles.kind != kind for load in loads):
        raise InputError("loads", "muscles driven now so, now otherwise", f"muscles driven alike, here: {kind}")
    placed = any(load.wrenches for load in loads)
    laws = [group.law for group in first.groups]
    dry = any(law.dry_friction is not None for law in laws)
    along = any(getattr(law, "friction_coefficient", None) is not None for law in laws)
    key = (dry, along, alike(bare[0], kind, placed))
    try:
        return Way(arms, bare, loads, *_controls(bare[0], loads), key, changes)
    except InputError as error:
        nothing = np.zeros((len(loads), 0))
        return Way(arms, bare, loads, nothing, nothing, key, changes, error)


def _controls(bare: Arm, loads: Sequence[Load]) -> tuple[Array, Array]:
    """Return controls, shape (T, M), and the joint angles that winches about make [rad], shape (T, dofs).

    Raises:
        InputError: not as many numbers as muscles, or numbers that drive no such arm.
    """
    kind = loads[0].muscles.kind
    values = np.array([checked_values(bare, load) for load in loads])
    bend, control = None, np.zeros((len(loads), muscles.count(bare)))
    if kind != "off":
        bend, control = commands(bare, kind, values)
    plant = reused(bare, *DRIVEN[kind])
    about = np.zeros((len(loads), plant.model.nv))
    if bend is not None:
        bent(about, bare, plant.index, bend.reshape(len(loads), -1, 2))
    return control, about
