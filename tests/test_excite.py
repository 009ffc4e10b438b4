"""What to command next: closed forms on a predictor that is linear, and fits of a real arm repeated."""

from dataclasses import replace
from itertools import combinations

import numpy as np
import pytest

from contarm_sim import Arm
from contarm_sim.errors import InputError
from contarm_sim.identify.excite import excite
from contarm_sim.identify.fit import fit
from contarm_sim.identify.freedom import Free
from contarm_sim.identify.recordings.recording import Recording
from contarm_sim.identify.recordings.rig import Actuation, Marker, Rig
from contarm_sim.identify.recordings.synthetic import recorded
from contarm_sim.model.section import Section
from contarm_sim.model.tendon import Tendon
from contarm_sim.model.world import World

NOISE = 1e-4
ARM = Arm(
    sections=(Section(length=0.1, links=6, mass=0.01, bending_stiffness=0.005),),
    laws=(Tendon(stiffness=50.0, pretension=1e-3, max_tension=500.0),),
    world=World(gravity=(0.0, 0.0, 0.0)),
)
RIG = Rig(markers=(Marker(offset=(0.0, 0.0, 0.01)),), actuation=Actuation(channels=(0, 1, 2)))


class Linear:
    """x of the marker is its own offset, and y the first command times the logarithm of the bending stiffness."""

    def __init__(self, recording):
        self.recording = recording

    def __call__(self, arms, rigs):
        out = np.zeros((len(arms), len(self.recording), 1, 3))
        for place, (arm, rig) in enumerate(zip(arms, rigs, strict=True)):
            out[place, :, 0, 0] = rig.markers[0].offset[0]
            out[place, :, 0, 1] = self.recording.commands[:, 0] * np.log(arm.sections[0].bending_stiffness)
        out[:, self.recording.commands[:, 0] > 1] = np.nan
        return out


def test_expected_sds_are_those_of_linear_least_squares():
    free, table = ["bending_stiffness", "marker.offset.x", "mass"], np.array([[0.1, 0, 0], [0.2, 0, 0], [0.3, 0, 0]])
    known = Recording(
        kind="static", time=[0.0, 1.0], positions=[[[0, 0, 0]], [[np.nan] * 3]], commands=[[0.05, 0, 0], [0.9, 0, 0]],
        rig=RIG, blocks=["a", "a"],
    )  # fmt: skip
    found = excite(ARM, RIG, free, candidates=table, count=2, recording=known, noise=NOISE, predictor=Linear)
    assert found.chosen == (2, 1)
    np.testing.assert_array_equal(found.commands, table[[2, 1]])
    np.testing.assert_allclose(found.sd_before[:2], [0.005 * NOISE / 0.05, NOISE], rtol=1e-6)
    after = NOISE / np.sqrt([0.05**2 + 0.2**2 + 0.3**2, 3.0])
    np.testing.assert_allclose(found.sd_after[:2], [0.005 * after[0], after[1]], rtol=1e-6)
    assert np.isinf([found.sd_before[2], found.sd_after[2]]).all()
    assert np.argsort(found.gains).tolist() == [0, 1, 2]


def test_a_prior_counts_as_information():
    free = [Free(name="bending_stiffness", sd=0.001), "marker.offset.x"]
    found = excite(ARM, RIG, free, candidates=np.zeros((3, 3)), count=1, predictor=Linear)
    np.testing.assert_allclose(found.sd_after[0], 0.001, rtol=1e-2)


def test_candidates_without_a_pose_or_beyond_limits_are_refused():
    table = np.array([[0.1, 0, 0], [2.0, 0, 0], [0.3, 0, 0], [0.5, 0, -9.0]])
    found = excite(ARM, RIG, ["bending_stiffness"], candidates=table, count=2, limits=(-5, 5), predictor=Linear)
    assert found.refused == ("row_2", "row_4")
    assert found.chosen == (2, 0)
    with pytest.raises(InputError, match="2 of 4"):
        excite(ARM, RIG, ["bending_stiffness"], candidates=table, count=3, limits=(-5, 5), predictor=Linear)


@pytest.fixture(scope="module")
def choice():
    free = ["bending_stiffness", "actuation.slack_1", "actuation.slack_2", "frame.turn_z", "marker.offset.z"]
    table = np.random.default_rng(1).uniform(-0.004, 0.004, (14, 3))
    table += 0.0005 - table.mean(axis=1, keepdims=True)  # all are taut
    return free, table, excite(ARM, RIG, free, candidates=table, count=6, noise=NOISE)


def test_exchanges_find_the_best_of_all_choices(choice):
    free, table, _ = choice
    best = max(
        excite(ARM, RIG, free, candidates=table[list(own)], count=3, noise=NOISE).gain
        for own in combinations(range(6), 3)
    )  # fmt: skip
    assert excite(ARM, RIG, free, candidates=table[:6], count=3, noise=NOISE).gain == pytest.approx(best, rel=1e-9)


def test_the_choice_beats_random_ones_of_its_size(choice):
    free, table, found = choice
    random = np.random.default_rng(2)
    for _ in range(3):
        own = table[random.permutation(len(table))[:6]]
        assert excite(ARM, RIG, free, candidates=own, count=6, noise=NOISE).gain < found.gain


def test_repeated_fits_scatter_as_expected(choice):
    free, _, found = choice
    truth, size = found.values, []
    for seed in range(12):
        made = recorded(ARM, RIG, found.commands, seed=seed, noise=NOISE)
        done = fit(ARM, made, free, loss="linear", noise=NOISE)
        size.append(([one.value for one in done.parameters] - truth) / found.sd_after)
    assert np.isfinite(size).all()
    assert 0.7 < np.mean(np.square(size)) < 1.35  # of 60 numbers


def test_random_patterns_are_windings_of_taut_muscles():
    winches = Actuation(channels=(2, 0, 1), signs=(1, -1, 1), gains=(0.01, 1, 1), slack=(0.001,) * 3)
    slack = replace(RIG, actuation=winches)
    found = excite(ARM, slack, ["bending_stiffness"], candidates=5, count=2)
    assert len(found.patterns) == 5
    assert len(found.commands) == len(found.blocks) == 24
    assert set(found.blocks.tolist()) == {found.patterns[place] for place in found.chosen}
    straight = -slack.actuation.values(found.commands[:1])[0]
    np.testing.assert_allclose(straight, 0.0005, atol=1e-9)
    pressed = replace(RIG, actuation=Actuation(drive="pressures", channels=(0, 1, 2)))
    with pytest.raises(InputError, match="a table of commands"):
        excite(ARM, pressed, ["bending_stiffness"])


BAD = [({"criterion": "E"}, "D, A"), ({"noise": 0}, "above 0"), ({"count": 0}, "count"),
       ({"candidates": np.zeros((4, 2))}, "3 channels")]  # fmt: skip


@pytest.mark.parametrize(("bad", "word"), BAD)
def test_bad_arguments_are_refused(bad, word):
    with pytest.raises(InputError, match=word):
        excite(ARM, RIG, ["bending_stiffness"], **{"predictor": Linear, **bad})
