"""McKibben muscles behind valves: a control is a gauge pressure [Pa].

The force P A (c s^2 - d), s = L/L_rest, vanishes at s0, where c s0^2 = d; there it is, exactly,

    P A (2 c s0 (s - s0) + c (s - s0)^2)        for s > s0, and nothing below: a muscle cannot push.

Native gains are affine in length, or made of parabolas (those of biological muscles); so two actuators make a muscle,
both fed with its pressure: the line, limited to pulling, and the parabola, which is zero below its vertex.
"""

from __future__ import annotations

from collections.abc import Sequence

import mujoco

from contarm_sim.mjcf.actuators import Actuators, add_round
from contarm_sim.mjcf.routing import CLASS, Strands, counted_from
from contarm_sim.model.mckibben import McKibben
from contarm_sim.model.muscle_group import MuscleGroup

_LINEAR, _QUADRATIC = "linear", "quadratic"

_REACH = 2.0
"""A length in rest lengths that no muscle gets to."""


class McKibbenMuscles(Actuators):
    """Two actuators a muscle: first the lines of all muscles, then the parabolas."""

    states = True

    def add(self, spec: mujoco.MjSpec, strands: Sequence[Strands]) -> None:
        """Add lines, then parabolas."""
        for one in strands:
            add_round(spec, one, _linear(spec, one), f"_{_LINEAR}")
        for one in strands:
            group = one.group
            reach = [length * group.rest_length for length in (1 - group.law.max_contraction, _REACH)]
            counted = [length - counted_from(group) for length in reach]
            add_round(spec, one, _quadratic(spec, one), f"_{_QUADRATIC}", lengthrange=counted)

    def straight_control(self, group: MuscleGroup, share: float) -> float:
        """Return a pressure [Pa], at least the lowest that there is: tensions may be larger than the least."""
        law = _law(group)
        s, s0 = 1 - law.mount_contraction, 1 - law.max_contraction
        return share * max(law.min_tension / (law.pull_per_pascal * (s**2 - s0**2)), law.min_pressure)

    def stiffest(self, group: MuscleGroup) -> float:
        """Return dF/dL of the longest muscle at the highest pressure [N/m]."""
        law = _law(group)
        return law.max_pressure * 2 * law.pull_per_pascal * (1 + law.max_stretch) / group.rest_length


def _law(group: MuscleGroup) -> McKibben:
    assert isinstance(group.law, McKibben)  # `pressures.LAWS` finds these actuators by it
    return group.law


def _linear(spec: mujoco.MjSpec, strands: Strands) -> mujoco.MjsDefault:
    """Make the line 2 c s0 (s - s0) of the law."""
    group, default = strands.group, _add_default(spec, strands, _LINEAR)
    rest, law = group.rest_length, _law(group)
    s0 = 1 - law.max_contraction
    slope = 2 * s0 * law.pull_per_pascal / rest
    default.actuator.gaintype = mujoco.mjtGain.mjGAIN_AFFINE
    default.actuator.gainprm[:2] = [slope * (s0 * rest - counted_from(group)), -slope]
    default.actuator.forcerange = [-10 * slope * rest * law.max_pressure, 0.0]  # never met from below
    default.actuator.forcelimited = True
    return default


def _quadratic(spec: mujoco.MjSpec, strands: Strands) -> mujoco.MjsDefault:
    """Make the parabola c (s - s0)^2 of the law.

    The engine's muscle gain is -F (x/x1)^2 / 2 from its shortest length, x = 0, to x1, half its range; a speed limit
    that is never met turns its dependence on velocity off.
    """
    law, default = _law(strands.group), _add_default(spec, strands, _QUADRATIC)
    force = 2 * law.pull_per_pascal * (_REACH - (1 - law.max_contraction)) ** 2
    shortest, longest, most_speed = 0.0, 2.0, 1e9
    default.actuator.gaintype = mujoco.mjtGain.mjGAIN_MUSCLE
    default.actuator.gainprm[:9] = [0.0, 0.5, force, 1.0, shortest, longest, most_speed, 1.0, 1.0]
    return default


def _add_default(spec: mujoco.MjSpec, strands: Strands, part: str) -> mujoco.MjsDefault:
    """Add a default class of actuators whose pressure [Pa] follows its control with a first-order lag."""
    name = strands.default.name.removesuffix(CLASS) + f"pressure_{part}"
    default, law = spec.add_default(name, spec.default), _law(strands.group)
    default.actuator.dyntype = mujoco.mjtDyn.mjDYN_FILTEREXACT
    default.actuator.dynprm[0] = law.valve_time
    default.actuator.ctrlrange = [0.0, law.max_pressure]
    default.actuator.ctrllimited = True
    return default
