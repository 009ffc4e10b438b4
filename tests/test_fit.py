"""Fits to recordings that the simulator made: parameters come back, and what cannot be found is named."""

import csv
import json
import tomllib
from dataclasses import fields, replace

import numpy as np
import pytest

from contarm_sim.errors import InputError
from contarm_sim.identify.fit import fit
from contarm_sim.identify.fit_folder import load_fit, save_fit
from contarm_sim.identify.freedom import Free
from contarm_sim.identify.prediction.base import AtRest
from contarm_sim.identify.recordings.rig import Actuation, Marker, Rig
from contarm_sim.identify.recordings.synthetic import random_windings, recorded
from contarm_sim.model.arm import Arm
from contarm_sim.model.named import named_parameters, with_parameters
from contarm_sim.model.routing import Routing
from contarm_sim.model.section import Section
from contarm_sim.model.tendon import Tendon

START = Arm(
    sections=(Section(length=0.1, links=6, mass=0.03, bending_stiffness=0.02),) * 2,
    routings=tuple(Routing(radius=0.01, start="base", offset=0.4 * k) for k in range(2)),
    laws=(Tendon(stiffness=2000.0, pretension=1e-3, max_tension=1e6),) * 2,
)
TRUE = {"section_1.bending_stiffness": 0.034, "section_2.bending_stiffness": 0.013, "muscle_radius": 0.0106}
OFFSET, TURN = 0.009, 0.05
RIG = Rig(
    markers=(Marker(name="middle", xi=0.5), Marker(offset=(0, 0, 0.005))), actuation=Actuation(channels=tuple(range(6)))
)
FREE = ["section_*.bending_stiffness", "muscle_radius", "marker_2.offset.z", "frame.turn_x"]


def _true_rig(rig=RIG):
    middle, tip = rig.markers
    return replace(rig, markers=(middle, replace(tip, offset=(0, 0, OFFSET))), turn=(TURN, 0, 0))


def _recording(count=40, seed=3, noise=5e-4, **kwargs):
    commands, blocks = random_windings(START, count, seed, samples=5, bend=1.2)
    made = recorded(
        with_parameters(START, TRUE), _true_rig(), commands, seed=seed, noise=noise, blocks=blocks, **kwargs
    )
    return made.in_rig(RIG)


@pytest.fixture(scope="module")
def recording():
    return _recording(gaps=0.1, outliers=0.1)


@pytest.fixture(scope="module")
def fitted(recording):
    return fit(START, recording, FREE, held_out=[recording.blocks[-1][:-1] + "*"], threads=1)


def _values(found):
    return {one.name: one.value for one in found.parameters}


def test_known_parameters_come_back_from_a_recording_with_gaps_and_outliers(recording, fitted):
    true = {**TRUE, "marker_2.offset.z": OFFSET, "frame.turn_x": TURN}
    assert np.isnan(recording.positions).any()
    for one in fitted.parameters:
        assert one.status == "determined"
        assert one.low < one.value < one.high
        assert abs(one.value - true[one.name]) < 1.6 * max(one.high - one.value, one.value - one.low)
        assert one.sd < 0.2 * abs(one.value)
    assert fitted.converged
    assert 3.5e-4 < fitted.noise < 7e-4
    assert fitted.arm.sections[0].bending_stiffness == pytest.approx(_values(fitted)["section_1.bending_stiffness"])
    assert fitted.rig.markers[1].offset[2] == _values(fitted)["marker_2.offset.z"]
    assert fitted.correlation.shape == (5, 5)
    assert not fitted.undetermined


def test_what_is_left_over_is_of_the_fitted_arm(recording, fitted):
    predicted = AtRest(recording)([fitted.arm], [fitted.rig])[0]
    np.testing.assert_allclose(fitted.left[0].predicted, predicted, atol=1e-9)


def test_outliers_weigh_less_in_a_robust_loss(recording, fitted):
    truth = AtRest(recording)([with_parameters(START, TRUE)], [_true_rig()])[0]
    linear = fit(START, recording, FREE, loss="linear", threads=1)
    off = [np.abs(found.left[0].predicted - truth).max() for found in (fitted, linear)]
    assert off[0] < 0.4 * off[1]


def test_held_out_samples_are_predicted_and_change_nothing(recording, fitted):
    left = fitted.left[0]
    assert 0 < left.held_out.sum() < 0.5 * len(recording)
    assert len(set(recording.blocks[left.held_out]) & set(recording.blocks[~left.held_out])) == 0
    wrong = recording.positions + 0.05 * left.held_out[:, None, None]
    other = fit(START, replace(recording, positions=wrong), FREE, held_out=left.held_out, threads=1)
    assert _values(other) == _values(fitted)
    assert other.left[0].rms(left.held_out) > 0.05 > left.rms(left.held_out)


def test_what_no_force_tells_is_held_and_the_ratio_is_found():
    """Windings alone bend an arm as the ratio of its stiffness and its tendons' says: either may be any."""
    recording = _recording()
    true = with_parameters(START, {"bending_stiffness": 0.04})
    made = replace(recording, positions=AtRest(recording)([true], [RIG])[0] + 0)
    noisy = np.random.default_rng(0).normal(0, 5e-4, made.positions.shape)
    made = replace(made, positions=made.positions + noisy)
    found = fit(START, made, ["bending_stiffness", "muscle.stiffness"], threads=1)
    assert [one.status for one in found.parameters] == ["only with others"] * 2
    assert all(np.isnan(one.value) for one in found.parameters)
    assert [set(one.names) for one in found.undetermined] == [{"bending_stiffness", "muscle.stiffness"}]
    stiffness, tendon = found.arm.sections[0].bending_stiffness, found.arm.laws[0].stiffness  # type: ignore[attr-defined]
    assert stiffness / tendon == pytest.approx(0.04 / 2000, rel=0.05)
    assert stiffness == pytest.approx(0.02) or tendon == pytest.approx(2000)
    assert found.left[0].rms() == pytest.approx(np.sqrt(3) * 5e-4, rel=0.1)


def test_what_a_recording_cannot_see_is_left_alone_and_said(recording):
    found = fit(START, recording, ["section_1.damping_time", "frame.turn_x"], threads=1)
    unseen, seen = found.parameters
    assert (unseen.status, seen.status) == ("not seen", "determined")
    assert np.isnan(unseen.value)
    assert "damping" in unseen.said
    assert found.arm == START
    with pytest.raises(InputError, match=r"damping_time.*the recording sees \(an arm at rest does not show its damp"):
        fit(START, recording, ["damping_time"], threads=1)


def test_priors_pull_and_bounds_hold(recording):
    """An offset along the tip moves a marker by as much: n samples tell it to noise / sqrt(n), and so weigh a prior."""
    samples, noise = recording.seen[:, 1].sum(), 5e-4

    def found(**kwargs):
        own = Free(name="marker_2.offset.z", **kwargs)
        return fit(START, recording, [own], threads=1, noise=noise, loss="linear").parameters[0]

    alone = found().value
    told, mean = noise / np.sqrt(samples), alone + 1e-3
    for spread in (1e-6, 0.5 * told, 2 * told, 1.0):
        expected = (alone / told**2 + mean / spread**2) / (1 / told**2 + 1 / spread**2)
        assert found(mean=mean, sd=spread).value == pytest.approx(expected, abs=1e-3 * told)
    bound = found(high=alone - 1e-3)
    assert bound.status == "at bound"
    assert bound.value == pytest.approx(alone - 1e-3, abs=1e-6)


def test_recordings_share_the_arm_and_each_has_its_own_rig(recording):
    moved = replace(RIG, position=(0.1, 0.0, 0.0), markers=RIG.markers[1:])
    other = replace(recording, positions=recording.positions[:, 1:] + [0.1, 0, 0], rig=moved)
    found = fit(START, [recording, other], ["section_1.bending_stiffness", "frame.turn_x", "marker_2.offset.z"],
                threads=1)  # fmt: skip
    assert len(found.rigs) == len(found.left) == 2
    assert found.rigs[1].position == (0.1, 0.0, 0.0)
    assert found.rigs[0].turn == found.rigs[1].turn != (0, 0, 0)
    assert found.rigs[1].markers == moved.markers


def test_a_population_is_predicted_as_each_of_it_alone(recording):
    """Poses are found anew wherever anything that they depend on differs, gravity that turns with the frame too."""
    hanging = replace(RIG, gravity=(0.0, 0.0, -9.81))
    rigs = [hanging, replace(hanging, turn=(0.3, 0, 0)), replace(hanging, position=(1, 0, 0)), RIG,
            replace(hanging, actuation=replace(RIG.actuation, slack=(1e-3,) * 6))]  # fmt: skip
    arms = [START, START, START, START, START]
    together = AtRest(recording)(arms, rigs)
    for arm, rig, found in zip(arms, rigs, together, strict=True):
        np.testing.assert_allclose(found, AtRest(recording)([arm], [rig])[0], atol=1e-9)


def test_a_fit_is_kept_in_a_folder_and_read_back(recording, fitted, tmp_path):
    folder = save_fit(fitted, tmp_path / "new" / "fit")
    again = load_fit(folder)
    assert (again.arm, again.rigs, again.cost, again.message) == (
        fitted.arm, fitted.rigs, fitted.cost, fitted.message
    )  # fmt: skip
    assert again.parameters == fitted.parameters or repr(again.parameters) == repr(fitted.parameters)
    np.testing.assert_array_equal(again.correlation, fitted.correlation)
    for item in fields(recording):
        if isinstance(value := getattr(fitted.left[0].recording, item.name), np.ndarray):
            np.testing.assert_array_equal(getattr(again.left[0].recording, item.name), value)
    np.testing.assert_array_equal(again.left[0].error, fitted.left[0].error)
    rows = list(csv.DictReader((folder / "residuals.csv").read_text().splitlines()))
    assert len(rows) == 2 * len(recording)
    seen = [row for row in rows if row["distance_m"]]
    assert len(seen) == recording.seen.sum()
    one = seen[0]
    assert float(one["x_m"]) - float(one["predicted_x_m"]) == pytest.approx(float(one["error_x_m"]), abs=1e-12)
    assert {row["held_out"] for row in rows} == {"0", "1"}
    told = list(csv.DictReader((folder / "parameters.csv").read_text().splitlines()))
    assert [row["name"] for row in told] == list(_values(fitted))
    assert tomllib.loads((folder / "arm.toml").read_text())
    document = json.loads(json.dumps(fitted.to_dict(), allow_nan=False))
    assert document["recordings"][0]["rms_fitted_m"] == fitted.left[0].rms(~fitted.left[0].held_out)
    (folder / "fit.npz").write_bytes((folder / "fit.npz").read_bytes()[:500])
    with pytest.raises(InputError, match=r"fit\.npz.*damaged"):
        load_fit(folder)
    with pytest.raises(InputError, match=r"which has no arm\.toml"):
        load_fit(tmp_path)


def test_parameters_that_start_at_nothing_may_leave_it(recording):
    bare = START.in_world(replace(START.world, payload=0.0, gravity=(0.0, 0.0, 9.81)))
    loaded = with_parameters(bare, {"payload": 0.2})
    made = replace(recording, positions=AtRest(recording)([loaded], [RIG])[0] + 0)
    assert named_parameters(bare)["payload"].value(bare) == 0
    found = fit(bare, made, ["payload"], threads=1)
    assert found.parameters[0].value == pytest.approx(0.2, rel=1e-3)
