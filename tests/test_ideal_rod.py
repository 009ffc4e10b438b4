"""The rod that explains sag and motion: against collocation, and against momentum that is made up."""

import numpy as np
import pytest
from rod import parallel_rod

from contarm_sim.kinematics import arc
from contarm_sim.kinematics.muscles import deltas_from_bend
from contarm_sim.mechanics.rod import SEGMENTS, rod_tips
from contarm_sim.model.arm import Arm

BENDS = arc.from_polar(np.radians([0.0, 30.0, 90.0, 150.0, 170.0]), np.radians([0.0, 20.0, 200.0, 300.0, 77.0]))


def _hanging(arm, bend, **more):
    weight = np.broadcast_to(np.array(arm.gravity), (len(bend), 3))
    density = np.repeat(arm.mass / arm.length * weight[:, None], SEGMENTS, axis=1)
    return rod_tips(arm, bend, density, arm.payload * weight, **more)


def test_without_loads_it_is_the_arc():
    np.testing.assert_allclose(_hanging(Arm(), BENDS), arc.position(BENDS, 0.37), atol=1e-12)


@pytest.mark.parametrize("arm", [
    Arm(gravity=(0, 0, 9.81)), Arm(gravity=(0, 0, 9.81), payload=0.1), Arm(gravity=(9.81, 0, 0)),
    Arm(gravity=(0, 0, -9.81)), Arm(gravity=(0, 5, 5), bending_stiffness=0.03),
], ids=["hanging", "payload", "level", "upright", "soft"])  # fmt: skip
def test_under_gravity_it_is_the_collocated_rod(arm):
    """Two solvers that share nothing: Ritz on the energy's gradient, and collocation of the boundary value problem."""
    tips = _hanging(arm, BENDS)
    for bend, tip in zip(BENDS, tips, strict=True):
        lengths = arm.length + deltas_from_bend(bend, arm.muscle_radius)
        np.testing.assert_allclose(tip, parallel_rod(arm, lengths=lengths).tip, atol=5e-4 * arm.length)


def test_a_twisting_rod_sags_further_sideways():
    stiff, soft = (Arm(gravity=(9.81, 0, 0), torsional_stiffness=k) for k in (10.0, 0.05))
    bend = arc.from_polar(np.array([1.5]), np.pi / 2)
    rigid = _hanging(Arm(gravity=(9.81, 0, 0)), bend)
    np.testing.assert_allclose(_hanging(stiff, bend), rigid, atol=1e-3)
    assert np.linalg.norm(_hanging(soft, bend) - rigid) > 5e-3
    true = parallel_rod(soft, lengths=soft.length + deltas_from_bend(bend[0], soft.muscle_radius))
    twisted = _hanging(soft, bend, tension=true.tensions.sum(keepdims=True))[0]
    np.testing.assert_allclose(twisted, true.tip, atol=1e-4)


def test_pulled_tight_muscles_stiffen_it_against_twist():
    arm = Arm(gravity=(9.81, 0, 0), torsional_stiffness=0.02)
    bend = arc.from_polar(np.array([1.5]), np.pi / 2)
    loose, tight = (_hanging(arm, bend, tension=np.array([sum_])) for sum_ in (0.0, 300.0))
    rigid = _hanging(Arm(gravity=(9.81, 0, 0)), bend)
    assert np.linalg.norm(tight - rigid) < np.linalg.norm(loose - rigid)


def test_a_rod_that_finds_no_rest_is_not_a_number():
    arm = Arm(gravity=(0, 0, -9.81), bending_stiffness=1e-4)
    assert np.isnan(_hanging(arm, BENDS[3:4])).all()
