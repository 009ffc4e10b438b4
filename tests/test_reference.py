"""A motion as one value: what it refuses, and what it keeps apart."""

import numpy as np
import pytest

from contarm_sim import paths
from contarm_sim.errors import InputError, UnreachableError
from contarm_sim.kinematics import arc
from contarm_sim.model.arm import Arm
from contarm_sim.model.section import Section
from contarm_sim.motion.rest import poses_at_rest
from contarm_sim.motion.simulate import Stepping, simulate
from contarm_sim.paths.reference import Reference

ARM = Arm(links=6)
BENDS = np.array([[0.0, 0.0], [0.1, 0.05], [0.2, 0.1]])


def test_a_motion_takes_the_time_that_its_targets_were_made_for():
    """Targets made at 50 Hz for 4 s take 4 s, at any rate of their own."""
    path = paths.named("circle", ARM.length, 0.6, max_bend=0.3)
    for rate in (50.0, 100.0, 200.0):
        reference = Reference.from_path(path, ARM, rate)
        run = simulate(ARM, reference)
        assert run.time[-1] == pytest.approx(0.6, abs=1e-12)
        assert len(run) == len(reference) == round(0.6 * rate) + 1
        assert reference.rate == rate


def test_a_motion_is_the_same_whatever_happens_to_the_arrays_that_it_was_made_from():
    bend, target = BENDS.copy(), arc.position(BENDS, ARM.length)
    reference = Reference(np.arange(3) / 100, target, bend, ARM.length)
    before = simulate(ARM, reference)
    bend[:], target[:] = 1.0, 0.0
    assert simulate(ARM, reference) == before
    for array in (reference.time, reference.target, reference.bend, before.bend, before.stations):
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 1.0


def test_another_arms_motion_is_refused():
    longer = Arm(length=0.5, links=6)
    reference = Reference.from_bends(BENDS, longer, np.arange(3) / 100)
    for call in (simulate, poses_at_rest):
        with pytest.raises(InputError, match=r"for an arm of 0\.5 m"):
            call(ARM, reference)


def test_poses_are_no_motion():
    with pytest.raises(InputError, match="poses at rest, all at time 0"):
        simulate(ARM, Reference.from_bends(BENDS, ARM))


@pytest.mark.parametrize(
    ("time", "bend", "said"),
    [
        ([0, 0.01, 0.03], BENDS, "3 even times that rise from 0"),
        ([0.01, 0.02, 0.03], BENDS, "3 even times"),
        ([0, -0.01, -0.02], BENDS, "3 even times"),
        ([0, 0.01], BENDS, "3 even times"),
        ([0, 0.01, np.nan], BENDS, "3 even times"),
        ("abc", BENDS, "3 even times"),
        ([0, 0.01, 0.02], 4.0 * BENDS / 0.2, "bend_angle is"),
        ([0, 0.01, 0.02], [[1, 2], [3]], "bend"),
        ([0, 0.01, 0.02], BENDS[:, :1], "bend"),
        ([], np.empty((0, 2)), "target is of shape"),
    ],
)
def test_what_is_no_motion_is_refused_when_it_is_made(time, bend, said):
    with pytest.raises(InputError, match=said):
        Reference(time, np.zeros((len(bend), 3)), bend, ARM.length)


def test_targets_off_the_dome_are_refused_or_projected():
    target = np.array([[0.0, 0.0, 0.37], [0.1, 0.0, 0.37]])
    with pytest.raises(UnreachableError):
        Reference.from_targets(target, ARM)
    found = Reference.from_targets(target, ARM, project="nearest")
    np.testing.assert_array_equal(found.target, target)
    assert np.linalg.norm(arc.position(found.bend, ARM.length) - target, axis=1)[1] > 0.01
    with pytest.raises(UnreachableError, match="path sphere-spiral"):
        Reference.from_path(paths.named("sphere-spiral", ARM.length, 2.0), ARM)


def test_references_are_compared_by_value():
    one, same = (Reference.from_bends(BENDS, ARM, np.arange(3) / 100) for _ in range(2))
    assert one == same
    assert one != Reference.from_bends(2 * BENDS, ARM, np.arange(3) / 100)
    assert one != "reference"
    assert repr(one) == "Reference(3 samples, 0.02 s at 100 Hz, length 0.37 m)"
    assert one.at_rest() == Reference.from_bends(BENDS, ARM)


@pytest.mark.parametrize("length", [np.nan, -1, 0, "x", True, np.inf])
def test_a_length_that_is_none_is_refused(length):
    with pytest.raises(InputError, match="length"):
        Reference(np.zeros(3), np.zeros((3, 3)), BENDS, length)


def test_values_of_other_types_are_named():
    reference = Reference.from_bends(BENDS, ARM, np.arange(3) / 100)
    calls = [
        lambda: simulate(reference, ARM), lambda: simulate(ARM, None), lambda: simulate(ARM, BENDS),
        lambda: simulate(ARM, reference, stepping=0.001), lambda: poses_at_rest(ARM, BENDS),
        lambda: Reference.from_path("circle", ARM), lambda: Reference.from_bends(BENDS, 0.37),
        lambda: Reference.from_path(paths.named("circle", 0.37), ARM, "fast"),
        lambda: Reference.from_path(paths.named("circle", 0.37), ARM, 1e12),
        lambda: poses_at_rest(ARM, reference, ticks=range(2)), lambda: poses_at_rest(ARM, reference, ticks=[0, 0, 0]),
        lambda: reference.first(-1), lambda: reference.first(1.5), lambda: Stepping(0), lambda: Stepping("a"),
        lambda: Reference.from_bends(BENDS, ARM, np.arange(3) * 1e-12),
        lambda: Reference.from_bends(BENDS, ARM, np.arange(3) * 1e7),
        lambda: simulate(Arm(sections=(Section(), Section())), reference),
    ]  # fmt: skip
    for call in calls:
        with pytest.raises(InputError):
            call()
