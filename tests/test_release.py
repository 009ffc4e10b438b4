"""Released arms against a rod without links, over seeds; what is estimated of their error; loads that change."""

from dataclasses import replace

import numpy as np
import pytest
from swinging_rod import SwingingRod, released, straight

from contarm_sim.errors import InputError
from contarm_sim.model.arm import Arm
from contarm_sim.model.load import Load, Muscles, Wrench
from contarm_sim.motion.course import forces_over_time, ramp_down
from contarm_sim.motion.modes import bare, beam_frequencies, natural_frequencies, small_swing
from contarm_sim.motion.release import SwingSettings, release
from contarm_sim.motion.swing_error import judged_release
from contarm_sim.statics.equilibrium import equilibrium
from contarm_sim.statics.places import Places

THIN = Arm(bending_stiffness=0.05, mass=0.1, section_radius=0.004, damping_time=0.01)
TIME = np.arange(101) / 100


def _rod_and_wrenches(seed):
    """A thin rod, hanging where the seed is odd, and wrenches at its middle and tip, out of any one plane."""
    rng = np.random.default_rng(seed)
    hangs = seed % 2
    arm = Arm(
        bending_stiffness=10 ** rng.uniform(-2, -1), mass=rng.uniform(0.03, 0.3), gravity=(0, 0, 9.81 * hangs),
        section_radius=rng.uniform(0.002, 0.005), damping_time=10 ** rng.uniform(-2.7, -1.5),
        payload=0.05 * rng.integers(0, 2) * rng.uniform(),
    )  # fmt: skip
    force = arm.bending_stiffness / arm.length**2 + hangs * arm.mass * 9.81 / 2
    wrenches = tuple((xi, tuple(force * rng.uniform(-0.8, 0.8, 3) * [1, 1, 0.3]), (0, 0, 0)) for xi in (0.5, 1.0))
    return arm, wrenches


def _load(wrenches):
    return Load(wrenches=tuple(Wrench(xi=xi, force=force, moment=moment) for xi, force, moment in wrenches))


def _off(points, rod):
    """Mean distance [mm]."""
    return 1e3 * np.linalg.norm(points - rod, axis=-1).mean()


def _judge(seed, time):
    arm, wrenches = _rod_and_wrenches(seed)
    rod = released(arm, wrenches, time, xi=(0.3, 1.0), order=6)
    found = judged_release(arm, _load(wrenches), SwingSettings(duration=time[-1], xi=(0.3, 1.0)))
    return rod, found


def _agrees(rod, found):
    true = _off(found.swing.tip, rod.points[:, 1])
    reach = 1e3 * np.ptp(rod.points[:, 1], axis=0).max()
    assert true < (0.6 if reach > 150 else 0.25)
    assert _off(found.swing.positions[:, 0], rod.points[:, 0]) < 0.12
    turned = found.swing.frames[:, 1, :3, :3].swapaxes(-1, -2) @ rod.R[:, 1]
    assert np.degrees(np.arccos(np.clip((np.trace(turned, axis1=1, axis2=2) - 1) / 2, -1, 1))).mean() < 0.15
    assert 1e3 * found.total.mean() == pytest.approx(true, rel=0.05, abs=0.005)
    assert _off(found.tip, rod.points[:, 1]) < 0.02
    assert _off(found.positions[:, 0], rod.points[:, 0]) < 0.02
    lost = rod.energy[0] - rod.energy[-1]
    assert np.diff(found.swing.energy).max() < 1e-3 * lost
    fallen, fell = found.swing.energy - found.swing.energy[0], rod.energy - rod.energy[0]
    assert np.abs(fallen - fell).max() < 0.03 * lost
    return true


@pytest.mark.parametrize("seed", [2, 3])
def test_a_released_rod_swings_as_one_without_links_and_knows_its_error(seed):
    _agrees(*_judge(seed, TIME[:41]))


@pytest.mark.slow
def test_released_rods_of_many_seeds_swing_as_ones_without_links():
    errors = [_agrees(*_judge(seed, TIME)) for seed in range(12)]
    print("mean tip errors [mm]:", ", ".join(f"{error:.3f}" for error in errors))
    assert np.median(errors) < 0.25


@pytest.mark.slow
@pytest.mark.parametrize("torsional_stiffness", [0.03, 0.01])
def test_a_released_rod_that_twists_swings_as_one_without_links(torsional_stiffness):
    arm = replace(THIN, torsional_stiffness=torsional_stiffness, gravity=(0.0, 0.0, 9.81))
    wrenches = ((0.5, (0.0, 0.3, 0.0), (0, 0, 0)), (1.0, (0.25, -0.1, 0.0), (0, 0, 0)))
    rod = released(arm, wrenches, TIME[:51], xi=(0.3, 1.0), order=6)
    _agrees(rod, judged_release(arm, _load(wrenches), SwingSettings(duration=0.5, xi=(0.3, 1.0))))


def test_the_first_kick_lasts_half_a_step_and_links_err_to_second_order():
    """The step's error is of second order but for damping; the links' falls fourfold from 12 to 24."""
    arm, wrenches = replace(THIN, damping_time=0.001), ((1.0, (0.15, 0.1, 0.0), (0, 0, 0)),)
    load, time = _load(wrenches), TIME[:41]
    tips = {
        (links, step): release(made, equilibrium(made, load).qpos, load, SwingSettings(step, time[-1])).tip
        for links, step in ((24, 1e-3), (24, 1.25e-4), (12, 1.25e-4))
        for made in [replace(arm, links=links)]
    }
    assert _off(tips[24, 1e-3], tips[24, 1.25e-4]) < 0.03
    rod = released(arm, wrenches, time, panels=1, order=9).points[:, 0]
    coarse, fine = _off(tips[12, 1.25e-4], rod), _off(tips[24, 1.25e-4], rod)
    assert coarse / fine == pytest.approx(4, rel=0.1)


@pytest.mark.parametrize("payload", [0.0, 0.05])
@pytest.mark.parametrize("radius", [0.002, 0.03])
def test_the_closed_form_of_the_beam_and_the_rod_agree_on_frequencies(payload, radius):
    arm = replace(THIN, payload=payload, section_radius=radius)
    rod = straight(arm)
    beam = beam_frequencies(arm)
    assert rod.frequencies(np.zeros(rod.size), 6)[::2] == pytest.approx(beam, rel=1e-7)
    chain = natural_frequencies(bare(arm), Load(), 6)[::2]
    assert np.all(np.abs(chain / beam - 1) < [5e-4, 1.5e-3, 2.5e-3])


def test_beam_frequencies_of_a_thin_one_are_the_classical_ones():
    roots = np.array([1.8751040687, 4.6940911330, 7.8547574382, 10.9955407349, 14.1371683910])
    classical = roots**2 * np.sqrt(0.05 / (0.1 * 0.37**3)) / (2 * np.pi)
    assert beam_frequencies(replace(THIN, section_radius=1e-6), 5) == pytest.approx(classical, rel=1e-8)


@pytest.mark.parametrize("damping_time", [0.002, 0.02])
def test_the_first_mode_swings_and_decays_in_motion_as_kelvin_and_voigt_say(damping_time):
    arm = replace(THIN, damping_time=damping_time)
    omega = 2 * np.pi * beam_frequencies(arm)[0]
    frequency, decay = small_swing(arm)
    assert decay == pytest.approx(damping_time * omega**2 / 2, rel=2e-3)
    assert 2 * np.pi * frequency == pytest.approx(omega * np.sqrt(1 - (damping_time * omega / 2) ** 2), rel=1e-3)
    assert small_swing(replace(arm, damping_time=1.0)) is None


def test_a_load_that_fades_is_followed():
    wrenches, time = ((0.5, (0.0, 0.2, 0.0), (0, 0, 0)), (1.0, (0.15, 0.0, 0.0), (0.0, 0.0, 0.0))), TIME[:41]
    load = _load(wrenches)
    held = equilibrium(THIN, load).qpos
    course = ramp_down(0.2)
    rod = released(THIN, wrenches, time, order=6, course=course).points[:, 0]
    swing = release(THIN, held, load, SwingSettings(duration=time[-1], course=course))
    assert _off(swing.tip, rod) < 0.1
    assert _off(release(THIN, held, load, SwingSettings(duration=time[-1])).tip, rod) > 10
    kept = release(THIN, held, load, SwingSettings(duration=0.1, course=lambda t: 1.0))
    assert np.abs(kept.tip - kept.tip[0]).max() < 1e-8


def test_a_table_of_forces_is_followed():
    times, forces = [0.0, 0.1, 0.3], np.array([[0.15, 0.0, 0.0], [0.0, 0.15, 0.0], [0.0, 0.0, 0.0]])
    course, time = forces_over_time(times, forces, xi=0.5), TIME[:31]
    first = ((0.5, tuple(forces[0]), (0, 0, 0)),)
    held = equilibrium(THIN, _load(first)).qpos
    swing = release(THIN, held, _load(first), SwingSettings(duration=time[-1], course=course))
    axes = tuple((0.5, tuple(row), (0, 0, 0)) for row in np.eye(3))
    from rod import parallel_rod

    start = parallel_rod(THIN, wrenches=first, panels=2, order=6)
    rod = SwingingRod(THIN, start.grid, axes, lambda t: np.array([np.interp(t, times, row) for row in forces.T]))
    assert _off(swing.tip, rod.swing(start.curvature, time).points[:, 0]) < 0.1


def test_places_between_stations_and_sample_periods():
    load = Load(wrenches=(Wrench(xi=1.0, force=(0.3, 0.1, 0.0)),))
    held = equilibrium(THIN, load)
    xi = (0.0, 0.31, 0.5, 1.0)
    swing = release(THIN, held.qpos, load, SwingSettings(1e-3, 0.1, sample_period=2e-3, xi=xi))
    assert swing.frames.shape == (51, 4, 4, 4)
    assert swing.time[-1] == pytest.approx(0.1)
    assert swing.frames[0] == pytest.approx(Places(THIN, xi).of(held.frames), abs=1e-12)
    assert swing.frames[:, 3, :3, 3] == pytest.approx(swing.tip, abs=1e-12)
    sparse = release(THIN, held.qpos, load, SwingSettings(1e-3, 0.1, xi=xi))
    assert sparse.frames == pytest.approx(swing.frames[::5], abs=1e-12)
    w, x, y, z = np.moveaxis(swing.quaternions, -1, 0)
    assert 1 - 2 * (x**2 + y**2) == pytest.approx(swing.frames[..., 2, 2])
    assert 2 * (x * z + w * y) == pytest.approx(swing.frames[..., 0, 2], abs=1e-12)


def test_what_cannot_be_is_refused():
    held, load = np.zeros(48), Load()
    for wrong in (
        {"sample_period": 1.5e-3}, {"sample_period": 1e-4}, {"xi": ()}, {"xi": (1.1,)}, {"course": lambda t: np.nan},
        {"course": lambda t: Load(muscles=Muscles(kind="tensions", values=(1, 1, 1)))},
    ):  # fmt: skip
        with pytest.raises(InputError):
            release(THIN, held, load, SwingSettings(**{"duration": 0.05, **wrong}))
    with pytest.raises(InputError):
        ramp_down(0.0)
    for times, forces in (([0, 0], np.zeros((2, 3))), ([1.0], np.zeros((1, 3))), ([0.0], np.zeros((1, 2)))):
        with pytest.raises(InputError):
            forces_over_time(times, forces)
    with pytest.raises(InputError):
        judged_release(replace(THIN, links=3), load)
