"""Motions predicted: against swings by `release`, one by one, and against closed forms of friction."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import least_squares

from contarm_sim import Arm
from contarm_sim.engine.friction import BackboneFriction
from contarm_sim.engine.models import built
from contarm_sim.engine.plants import Plants
from contarm_sim.errors import InputError
from contarm_sim.identify.freedom import freedom
from contarm_sim.identify.prediction.base import AtRest
from contarm_sim.identify.prediction.choice import predictor_of
from contarm_sim.identify.prediction.moving import InMotion
from contarm_sim.identify.prediction.ringdown import ringdown
from contarm_sim.identify.recordings.recording import Recording
from contarm_sim.identify.recordings.rig import Actuation, Marker, Rig
from contarm_sim.model.load import Load, Wrench
from contarm_sim.model.tendon import Tendon
from contarm_sim.motion.release import SwingSettings, release
from contarm_sim.motion.rollout_step import step_for
from contarm_sim.motion.rollouts import Rollouts
from contarm_sim.statics.equilibrium import equilibrium
from contarm_sim.statics.places import Places

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
    with pytest.raises(InputError, match=r"payload is 0\.05 to 0\.3 kg in block 'swing 0'"):
        InMotion(replace(swings, payload=np.append(0.3, swings.payload[1:])))


def test_friction_along_driven_tendons_is_refused():
    arm = replace(ARM, muscle=Tendon(friction_coefficient=0.1))
    rig = replace(RIG, actuation=Actuation(drive="tensions", channels=(0, 1, 2)))
    recording = Recording("motion", np.arange(2.0), np.zeros((2, 2, 3)), np.ones((2, 3)), rig, np.full(2, "one"))
    for made in (lambda: predictor_of(recording, arm), lambda: InMotion(recording)([arm], [rig])):
        with pytest.raises(InputError, match=r"friction_coefficient is 0\.1"):
            made()


def test_each_arm_has_the_step_that_it_has_alone_and_neighbours_have_one(swings):
    """A stiff arm takes smaller steps than the others; one that no step is stable for has no motion."""
    part = swings.part(swings.blocks == "swing 0")
    stiff, absurd = replace(ARM, bending_stiffness=20.0), replace(ARM, bending_stiffness=1e9)
    assert step_for(stiff, "none") < step_for(ARM, "none")
    predictor = InMotion(part)
    together = predictor([ARM, stiff, absurd], [RIG] * 3)
    for arm, found in zip((ARM, stiff), together, strict=False):
        for alone in (predictor([arm], [RIG]), InMotion(part)([arm], [RIG])):
            np.testing.assert_allclose(found, alone[0], rtol=0, atol=1e-9)
    assert np.isnan(together[2]).all()
    assert np.isnan(predictor([absurd], [RIG])).all()
    with pytest.raises(InputError, match="no time step"):
        InMotion(part)([absurd], [RIG])
    low, high = 0.05, 20.0  # two neighbours of which one alone takes a smaller step
    while high / low > 1 + 1e-6:
        middle = np.sqrt(low * high)
        longer = step_for(replace(ARM, bending_stiffness=middle), "none") == step_for(ARM, "none")
        low, high = (middle, high) if longer else (low, middle)
    soft, hard = (replace(ARM, bending_stiffness=x) for x in (low, high))
    assert step_for(hard, "none") < step_for(soft, "none") == step_for(hard, "none", step_for(soft, "none"))
    assert step_for(soft, "none", step_for(hard, "none")) == step_for(hard, "none")
    assert step_for(stiff, "none", step_for(ARM, "none")) == step_for(stiff, "none")


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


def test_swings_tell_stiffness_damping_and_friction():
    """Six swings of an arm with friction, with a little noise and a tenth of the markers lost, give it back.

    Noise at the start of a swing is in all of it, so that intervals of independent samples are too narrow.
    """
    true = replace(ARM, friction_moment=0.01, friction_stiffness=0.06, damping_time=0.02)
    free = ["bending_stiffness", "damping_time", "friction_moment", "friction_stiffness"]
    recording = _swung(true)
    predictor = InMotion(recording, timestep=1e-3)
    seen = predictor.recording.seen
    start = freedom(replace(true, bending_stiffness=0.045, damping_time=0.03, friction_moment=0.015), RIG, free)

    def left(vectors):
        arms, rigs = zip(*(start.applied(start.of_vector(x)) for x in vectors), strict=True)
        return ((predictor(arms, rigs) - recording.positions) / 1e-4)[:, seen].reshape(len(vectors), -1)

    def jacobian(x):
        at = left([x, *(x + 1e-3 * np.eye(len(x)))])
        return (at[1:] - at[0]).T / 1e-3

    begin = start.vector(start.values())
    found = least_squares(lambda x: left([x])[0], begin, jacobian, max_nfev=6)
    off = np.abs(found.x - start.vector(start.values(true)))
    assert (off < [0.05, 0.12, 0.12, 0.12]).all(), off
    assert found.cost < 0.01 * np.sum(left([begin])[0] ** 2)


def _swung(arm):
    """Return swings of an arm, let go from rest under forces, its friction stretched by the way there."""
    rng, time = np.random.default_rng(5), 0.01 * np.arange(70.0)
    forces = [
        (0.35, 0.1, 0.0),
        (-0.1, 0.3, 0.0),
        (0.1, -0.2, 0.1),
        (-0.3, -0.3, 0.0),
        (0.5, 0.0, 0.0),
        (0.0, -0.4, 0.1),
    ]
    elastic, step = arm.without_memory, 1e-3
    plants = Plants([elastic] * len(forces), "none", threads=1)
    rollouts = Rollouts(plants, [arm] * len(forces), step)
    rest = equilibrium(elastic).qpos
    held = np.stack([equilibrium(elastic, Load(wrenches=(Wrench(xi=1.0, force=force),))).qpos for force in forces])
    plants.restart(None, held, np.zeros((len(forces), 3)))
    rollouts.friction.start(np.tile(rest, (len(forces), 1)))
    rollouts.friction.follow(held)
    seen = np.round(time / step).astype(int)
    places = Places(arm, [marker.xi for marker in RIG.markers])
    stations, columns = np.unique(places.stations, return_inverse=True)
    points, turns = rollouts.run(held, 0 * held, np.full(len(forces), seen[-1]), seen, stations, None)
    columns = columns.reshape(-1, 2)
    positions = RIG.measured(places.between(points[:, :, columns], turns[:, :, columns])).swapaxes(0, 1)
    positions = positions.reshape(-1, 2, 3) + rng.normal(scale=1e-4, size=(len(forces) * len(time), 2, 3))
    positions[rng.random(positions.shape[:2]) < 0.1] = np.nan
    count = len(positions)
    return Recording(
        "motion", np.tile(time, len(forces)), positions, np.zeros((count, 0)), RIG,
        np.repeat([f"swing {k}" for k in range(len(forces))], len(time)), release=0.5,
    )  # fmt: skip


def test_swings_start_where_they_do_in_spite_of_outliers_and_gaps():
    true = replace(ARM, friction_moment=0.01, friction_stiffness=0.06)
    recording, rng = _swung(true), np.random.default_rng(0)
    positions = recording.positions.copy()
    jumps = rng.random(positions.shape[:2]) < 0.05
    positions[jumps] += 0.03 * rng.normal(size=(jumps.sum(), 3))
    found = InMotion(replace(recording, positions=positions))([true], [RIG])[0] - recording.positions
    assert np.nanmedian(np.abs(found)) < 1e-3
    assert np.nanmax(np.abs(found)) < 0.1 * ARM.length
    positions[:70] = np.nan
    predictor = InMotion(replace(recording, positions=positions))
    assert np.isnan(predictor([true], [RIG])[0, :70]).all()
    assert not predictor.recording.seen[:70].any()
    with pytest.raises(InputError, match="none of them with a start"):
        InMotion(recording.part(slice(0, 3)))


def test_an_arm_that_diverges_has_no_motion_and_leaves_the_others_alone(swings):
    arms = [ARM, replace(ARM, damping_time=1e-6)]
    found, lost = InMotion(swings, timestep=0.02)(arms, [RIG, RIG])
    assert np.isfinite(found).mean() > 0.7
    assert np.isnan(lost).all()


def test_slow_commands_are_followed_from_rest_to_rest():
    """Tendons pulled over seconds, sampled unevenly: the arm is where it would rest at each time."""
    arm = replace(ARM, muscle=Tendon(), damping_time=0.1)
    time = np.array([0.0, 0.4, 1.3, 2.5, 4.0])
    commands = np.array([[2.0, 2.0, 2.0]]) + (time / 4)[:, None] * [[6.0, 0.0, 0.0]]
    rig = replace(RIG, actuation=Actuation(drive="tensions", channels=(0, 1, 2)))
    recording = Recording("motion", time, np.zeros((5, 2, 3)), commands, rig, np.full(5, "one"))
    moving = InMotion(recording)([arm], [rig])[0]
    resting = AtRest(replace(recording, kind="static"))([arm], [rig])[0]
    assert np.linalg.norm(resting[-1] - resting[0], axis=-1).max() > 0.1 * ARM.length
    np.testing.assert_allclose(moving, resting, rtol=0, atol=0.01 * ARM.length)
    assert np.abs(moving[0] - resting[0]).max() < 1e-9


@pytest.mark.parametrize(("frequency", "damping"), [(1.2, 2.2), (3.7, 0.3), (0.8, 4.0)])
def test_a_ringdown_is_measured_under_noise_and_outliers(frequency, damping):
    rng = np.random.default_rng(1)
    time = np.sort(rng.uniform(0, 2.0, 180))
    swing = 0.08 * np.exp(-damping * time) * np.cos(2 * np.pi * frequency * time + 0.6)
    positions = [0.1, 0.2, -0.3] + swing[:, None] * [0.6, 0.0, 0.8] + rng.normal(scale=5e-4, size=(180, 3))
    positions[::25] += 0.05
    positions[7] = np.nan
    found = ringdown(time, positions)
    assert found.frequency == pytest.approx(frequency, rel=0.04)
    assert found.damping == pytest.approx(damping, rel=0.15, abs=0.05)
    assert abs(found.direction @ [0.6, 0.0, 0.8]) == pytest.approx(1.0, abs=0.02)


@pytest.mark.parametrize(("frequency", "damping", "count"), [(30.0, 2.0, 200), (45.0, 2.0, 600)])
def test_a_ringdown_is_measured_up_to_half_the_sampling_rate(frequency, damping, count):
    time = 0.01 * np.arange(count)
    swing = 0.05 * np.exp(-damping * time) * np.cos(2 * np.pi * frequency * time)
    found = ringdown(time, swing[:, None] * [0.6, 0.0, 0.8])
    assert [found.frequency, found.damping] == pytest.approx([frequency, damping], rel=1e-3)
