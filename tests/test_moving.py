"""Motions predicted: against swings by `release`, one by one, and against closed forms of friction."""

from dataclasses import replace

import numpy as np
import pytest

from contarm_sim import Arm
from contarm_sim.engine.friction import BackboneFriction
from contarm_sim.engine.models import built
from contarm_sim.errors import InputError
from contarm_sim.identify.moving import InMotion
from contarm_sim.identify.recording import Recording
from contarm_sim.identify.rig import Actuation, Marker, Rig
from contarm_sim.model.load import Load, Wrench
from contarm_sim.motion.release import SwingSettings, release
from contarm_sim.statics.equilibrium import equilibrium

ARM = Arm(links=6, mass=0.1, bending_stiffness=0.05, damping_time=0.03, gravity=(0.0, 0.0, 9.81), payload=0.05)
RIG = Rig(
    markers=(Marker(name="middle", xi=0.5), Marker(name="tip", offset=(0.01, 0.0, 0.005))),
    actuation=Actuation(drive="none"), position=(0.1, 0.2, 0.3), orientation=(0.8, 0.6, 0.0, 0.0),
)  # fmt: skip
FORCES = ((0.3, 0.1, 0.0), (-0.1, 0.25, 0.0), (0.1, -0.2, 0.1))


@pytest.fixture(scope="module")
def swings():
    """Three swings by `release`, of arms with payloads of their own."""
    time, positions, blocks, payload = [], [], [], []
    for number, force in enumerate(FORCES):
        arm = replace(ARM, payload=0.05 + 0.02 * number)
        load = Load(wrenches=(Wrench(xi=1.0, force=force),))
        settings = SwingSettings(duration=1.0, xi=(0.5, 1.0))
        swing = release(arm, equilibrium(arm, load).qpos, load, settings)
        time.append(swing.time)
        positions.append(RIG.measured(swing.frames))
        blocks += [f"swing {number}"] * len(swing.time)
        payload += [arm.payload] * len(swing.time)
    return Recording(
        "motion", np.concatenate(time), np.concatenate(positions), np.zeros((len(payload), 0)), RIG,
        np.array(blocks), np.array(payload),
    )  # fmt: skip


def test_swings_are_those_of_release(swings):
    """From 70 % of the peak speed on, from markers alone: what is left is what they do not tell of the shape."""
    predictor = InMotion(swings)
    (found,) = predictor([ARM], [RIG])
    seen = predictor.recording.seen
    assert 0.7 < seen.mean() < 0.97
    assert np.isnan(found[~seen]).all()
    off = np.linalg.norm(found - swings.positions, axis=-1)[seen]
    assert np.sqrt(np.mean(off**2)) < 0.01 * ARM.length


def test_many_arms_are_predicted_as_one(swings):
    arms = [ARM, replace(ARM, mass=0.12), replace(ARM, bending_stiffness=0.06)]
    rigs = [RIG, RIG, replace(RIG, position=(0.1, 0.2, 0.31))]
    predictor = InMotion(swings)
    together = predictor(arms, rigs)
    for place, (arm, rig) in enumerate(zip(arms, rigs, strict=True)):
        np.testing.assert_allclose(predictor([arm], [rig])[0], together[place], rtol=0, atol=1e-9)


def test_recordings_at_rest_are_refused(swings):
    with pytest.raises(InputError, match="kind is 'static'"):
        InMotion(replace(swings, kind="static"))


def test_friction_loses_the_area_of_its_loop():
    """An elastic and perfectly plastic joint, bent to and fro by u: a cycle takes 4 M (u - M/k), in any plane."""
    arm = Arm(links=2, friction_moment=0.02, friction_stiffness=0.05)
    index, k, moment, u = built(arm, "none").index, arm.section.sticking_stiffness, 0.02, 0.4
    friction = BackboneFriction([arm], index)
    for plane in (0.0, 0.7):
        way = np.concatenate([np.linspace(0, u, 101), np.linspace(u, -u, 201), np.linspace(-u, u, 201)])
        bends = way[:, None] * [np.cos(plane), np.sin(plane)]
        held = []
        for bend in bends:
            qpos = np.zeros((1, 4))
            qpos[0, [index.bending["x"][0], index.bending["y"][0]]] = bend
            friction.start(qpos) if not held else friction.follow(qpos)
            held.append(friction.moment[0, 0] @ [np.cos(plane), np.sin(plane)])
        assert held[1] == pytest.approx(k * way[1])
        assert np.trapezoid(held[100:], way[100:]) == pytest.approx(4 * moment * (u - moment / k), rel=1e-3)
        assert np.abs(friction.moment[0, 1]).max() == 0


def test_a_joint_that_sticks_swings_as_if_it_were_stiffer(swings):
    """Where nothing slides, friction is a spring beside the backbone's, stretched from where the arm rests."""
    sticking = replace(ARM, friction_moment=1e6, friction_stiffness=0.03)
    stiffer = replace(ARM, bending_stiffness=0.08, damping_time=0.03 * 5 / 8)
    part = swings.part(swings.blocks == "swing 0")
    found, expected = (InMotion(part, timestep=1e-3)([arm], [RIG])[0] for arm in (sticking, stiffer))
    seen = np.isfinite(found)
    np.testing.assert_allclose(found[seen], expected[seen], rtol=0, atol=1e-7)
