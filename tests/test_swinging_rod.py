"""The reference for motion against what is known of it: frequencies, statics, energy, decay, its own refinement."""

from dataclasses import replace

import numpy as np
import pytest
from rod import parallel_rod
from swinging_rod import released, straight

from contarm_sim.model.arm import Arm

THIN = Arm(bending_stiffness=0.05, mass=0.1, section_radius=0.004, damping_time=0.02)
SIDEWAYS = ((0.5, (0, 0.2, 0.1), (0, 0, 0)), (1.0, (0.2, 0, 0), (0, 0, 0)))


def test_a_very_thin_one_has_the_frequencies_of_the_clamped_beam():
    rod = straight(replace(THIN, section_radius=1e-6))
    roots = np.array([1.8751040687119611, 4.694091132974175, 7.854757438237613])  # of cosh x cos x = -1
    beam = roots**2 * np.sqrt(0.05 / (0.1 * 0.37**3)) / (2 * np.pi)
    assert rod.frequencies(np.zeros(rod.size), 6)[::2] == pytest.approx(beam, rel=1e-8)
    assert rod.frequencies(np.zeros(rod.size), 6)[1::2] == pytest.approx(beam, rel=1e-8)


def test_a_heavily_damped_one_comes_to_rest_where_the_static_rod_does():
    arm = replace(THIN, gravity=(3.0, 0.0, 9.0), payload=0.03, damping_time=0.1)
    moved = released(arm, SIDEWAYS, [0.0, 0.5, 5.0], xi=(0.5, 1.0), panels=1, order=10)
    started, rests = parallel_rod(arm, wrenches=SIDEWAYS), parallel_rod(arm)
    assert moved.points[0] == pytest.approx(started.at([0.5, 1.0])[0], abs=2e-6)
    assert moved.points[-1] == pytest.approx(rests.at([0.5, 1.0])[0], abs=1e-7)
    assert moved.R[-1] == pytest.approx(rests.at([0.5, 1.0])[1], abs=1e-6)


@pytest.mark.parametrize("twists", [False, True])
def test_it_loses_the_energy_that_damping_takes_and_undamped_none(twists):
    """Whatever the pose and its speed, strongly bent ones among them: the derivative of energy along the motion."""
    rng = np.random.default_rng(0)
    arm = replace(THIN, gravity=(3.0, 2.0, 9.0), payload=0.03, torsional_stiffness=0.03 if twists else None)
    for damping_time in (0.0, 0.01):
        rod = straight(replace(arm, damping_time=damping_time), order=10)
        x = 2 * rod.grid.nodes[:, None] / arm.length - 1
        powers = np.hstack([x**0, x, x**2])
        u, rate = (scale * (powers @ rng.normal(size=(3, rod.n))).ravel() for scale in (4, 60))
        gained = rod.acceleration(0.0, u, rate)
        step = 1e-8
        power = rod.energy(u + step * rate, rate + step * gained) - rod.energy(u - step * rate, rate - step * gained)
        taken = damping_time * rate @ (rod.K * rate)
        flow = np.abs(rate * rod.K * u).sum()
        assert power / (2 * step) == pytest.approx(-taken, abs=1e-6 * flow)


def test_a_small_swing_decays_as_kelvin_and_voigt_say():
    arm = replace(THIN, damping_time=0.01)
    moved = released(arm, ((1.0, (1e-4, 0, 0), (0, 0, 0)),), np.linspace(0.5, 1.5, 41) - 0.5, panels=1, order=8)
    x = moved.points[12:, 0, 0]
    (twice, square), *_ = np.linalg.lstsq(np.stack([x[1:-1], -x[:-2]], axis=-1), x[2:], rcond=None)
    rod = straight(arm)
    omega = 2 * np.pi * rod.frequencies(np.zeros(rod.size), 1)[0]
    period = moved.time[1] - moved.time[0]
    assert -0.5 * np.log(square) / period == pytest.approx(0.01 * omega**2 / 2, rel=1e-3)
    angle = np.arccos(0.5 * twice / np.sqrt(square)) / period
    assert angle == pytest.approx(omega * np.sqrt(1 - (0.01 * omega / 2) ** 2), rel=1e-4)


def test_more_nodes_and_finer_steps_change_nothing():
    time = np.linspace(0, 0.2, 5)
    coarse, fine = released(THIN, SIDEWAYS, time, order=6), released(THIN, SIDEWAYS, time, order=7, rtol=3e-7)
    assert np.abs(coarse.points - fine.points).max() < 1e-7
