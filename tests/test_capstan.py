"""Tension along tendons that rub: against integration of the law itself, finite differences, and arms at rest."""

from dataclasses import replace

import numpy as np
import pytest

from contarm_sim import Load, Muscles, Tendon, presets
from contarm_sim.mechanics.capstan import at_disks, spread
from contarm_sim.statics.memory import settle

TURNS = np.array([0.3, 0.0, 0.7, 1e-7, 1.1])


@pytest.mark.parametrize("friction", [0.0, 1e-6, 0.2, -0.2, 1.5])
def test_means_and_end_are_those_of_the_integrated_law(friction):
    """dT/ds = -m k T by steps of a thousandth of a piece, whose mean is what the piece pulls with."""
    steps, T = 1000, 1.0
    profile = spread(np.array(friction), TURNS)
    for share, turning in zip(profile.share, TURNS, strict=True):
        along = T
        mean = 0.0
        for _ in range(steps):  # of the midpoint rule
            half = along * (1 - 0.5 * friction * turning / steps)
            mean += half / steps
            along -= friction * turning / steps * half
        assert share == pytest.approx(mean, rel=1e-6)
        T = along
    assert profile.end == pytest.approx(T, rel=1e-6)
    assert profile.end == pytest.approx(np.exp(-friction * TURNS.sum()))


@pytest.mark.parametrize("law", [spread, at_disks])
def test_slopes_are_those_of_differences(law):
    m, h = np.array([0.4, -0.3, 0.0]), 1e-6
    turning = np.abs(np.random.default_rng(1).normal(size=(3, 6)))
    profile = law(m, turning)
    assert profile.by_friction == pytest.approx(
        (law(m + h, turning).share - law(m - h, turning).share) / (2 * h), abs=1e-8
    )
    for k in range(6):
        there = h * (np.arange(6) == k)
        slope = (law(m, turning + there).share - law(m, turning - there).share) / (2 * h)
        assert slope[:, :k] == pytest.approx(0, abs=1e-9)
        assert slope[:, k] == pytest.approx(profile.own[:, k], abs=1e-8)
        assert slope[:, k + 1 :] == pytest.approx(profile.before[:, k + 1 :], abs=1e-8)


def test_disks_and_even_bends_are_alike_in_many_pieces():
    turning = np.full(2000, 1.4 / 2000)
    even, disks = spread(np.array(0.3), turning), at_disks(np.array(0.3), turning)
    assert disks.share.mean() == pytest.approx(even.share.mean(), rel=3e-4)
    assert even.share.mean() == pytest.approx((1 - np.exp(-0.42)) / 0.42)
    assert disks.end == pytest.approx(even.end, rel=1e-12)


def _bending(path):
    arm = presets.tendon()
    return replace(
        arm, gravity=(0.0, 0.0, 0.0), sections=[replace(section, links=6) for section in arm.sections],
        routings=[replace(routing, path=path) for routing in arm.routings],
        laws=[Tendon(diameter=0.002, friction_coefficient=0.15)] * 3,
    )  # fmt: skip


@pytest.mark.parametrize(("path", "allowed"), [("parallel", 1e-9), ("spans", 0.03)])
def test_an_arm_at_rest_has_the_tensions_of_the_capstan(path, allowed):
    """Wound in, the tension falls towards the end by the angle that the tendon turned by; let out, it rises."""
    arm = _bending(path)
    ways = [*np.linspace(0, 0.012, 7), 0.008, 0.004]
    told = [(0.05,) * 6 + (-wound, 0.05, 0.05) for wound in ways]  # all others let out
    found = settle(arm, [Load(muscles=Muscles(kind="setpoints", values=values)) for values in told])
    assert not found.failed
    pairs = found.qpos[0].reshape(len(ways), -1, 2)
    turned = np.hypot(*pairs.transpose(2, 0, 1)).sum(axis=-1)
    start, end = found.start_tensions[0, :, 6], found.end_tensions[0, :, 6]
    for place, sign in ((6, 1.0), (8, -1.0)):
        assert found.grip[0, place, 6] == sign
        assert turned[place] > 0.1
        assert np.log(start[place] / end[place]) == pytest.approx(sign * 0.15 * turned[place], rel=allowed)


def test_stretch_is_that_of_the_mean_tension():
    """A tendon that is wound in by u and shortened by the bend by d keeps u - d of strain, whatever rubs."""
    arm = _bending("parallel")
    load = Load(muscles=Muscles(kind="setpoints", values=(0.0,) * 6 + (-0.01, 0.0, 0.0)))
    found = settle(arm, [Load(muscles=Muscles(kind="setpoints", values=(0.0,) * 9)), load])
    group = arm.groups[2]
    stretch = found.muscle_lengths[0, -1, 6] - group.length + 0.01
    mean = group.law.pretension + group.law.stiffness / group.length * stretch
    pairs = found.qpos[0, -1].reshape(-1, 2)
    profile = spread(np.array(0.15), np.hypot(*pairs.T))
    pitches = np.repeat([section.link_pitch for section in arm.sections], 6)
    assert found.start_tensions[0, -1, 6] * np.average(profile.share, weights=pitches) == pytest.approx(mean, rel=1e-9)
