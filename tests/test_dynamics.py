"""Motion against analytic truths: beam frequencies, energy, and convergence with the time step."""

import numpy as np
import pytest

from contarm_sim.model.arm import Arm
from contarm_sim.model.load import Load, Muscles
from contarm_sim.motion.modes import natural_frequencies
from contarm_sim.motion.release import SwingSettings, release
from contarm_sim.statics.equilibrium import equilibrium

CLAMPED_FREE = np.array([1.8751041, 4.6940911, 7.8547574])  # roots of cosh x cos x = -1


def test_natural_frequencies_are_those_of_the_clamped_beam():
    """A slender arm, so that the disks' rotary inertia, which the beam formula leaves out, does not matter."""
    errors = []
    for links in (24, 48):
        arm = Arm(length=4.0, mass=1.0, bending_stiffness=2.0, links=links)
        expected = CLAMPED_FREE**2 * np.sqrt(arm.bending_stiffness / (arm.mass * arm.length**3))
        errors.append(np.abs(2 * np.pi * natural_frequencies(arm, Load(), 2 * len(CLAMPED_FREE))[::2] / expected - 1))
    assert errors[0].max() < 0.01
    assert errors[1].max() < 0.003


def _release(arm, timestep, duration):
    """Hold the arm by constant tensions in a bent pose, let go of the muscles, and return the swing."""
    held = equilibrium(arm, Load(muscles=Muscles(kind="tensions", values=(25.0, 5.0, 10.0))))
    return release(arm, held.qpos, Load(), SwingSettings(timestep, duration))


@pytest.mark.parametrize("gravity", [(0.0, 0.0, 0.0), (0.0, 0.0, 9.81)])
def test_a_released_arm_swings_as_a_finer_run_says_and_the_step_error_is_of_first_order(gravity):
    arm = Arm(gravity=gravity)
    fine = _release(arm, 5e-5, 0.6).tip
    errors = [
        np.linalg.norm(_release(arm, step, 0.6).tip - fine, axis=1).mean() / arm.length for step in (2e-3, 1e-3, 5e-4)
    ]
    assert errors[1] < 1e-3
    orders = np.log2(np.divide(errors[:-1], errors[1:]))
    assert np.all((orders > 0.8) & (orders < 1.3))


def test_energy_never_grows_without_input():
    energies = _release(Arm(gravity=(0.0, 0.0, 9.81), payload=0.05), 1e-3, 1.5).energy
    assert np.all(np.diff(energies) <= 1e-12)
    assert energies[0] - energies[-1] > 0.01


def test_without_damping_energy_is_kept_to_the_order_of_the_step():
    drifts = []
    for step in (2e-4, 1e-4):
        energies = _release(Arm(damping_time=0.0, links=8), step, 0.3).energy
        drifts.append(np.ptp(energies) / energies[0])
    assert drifts[0] < 0.05
    assert drifts[1] < 0.7 * drifts[0]
