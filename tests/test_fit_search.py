"""The search of a fit on problems with a known answer that cost nothing: valleys, starts, stops, bad input."""

import re
from dataclasses import replace

import numpy as np
import pytest

from contarm_sim.errors import InputError
from contarm_sim.identify.fit import fit
from contarm_sim.identify.freedom import Free
from contarm_sim.identify.prediction.base import AtRest
from contarm_sim.identify.prediction.choice import predictor_of
from contarm_sim.identify.prediction.moving import InMotion
from contarm_sim.identify.prediction.remembering import WithMemory
from contarm_sim.identify.recordings.recording import Recording
from contarm_sim.identify.recordings.rig import Actuation, Rig
from contarm_sim.identify.search import descent
from contarm_sim.identify.search.losses import LOSSES, rho
from contarm_sim.identify.search.residuals import Problem
from contarm_sim.identify.search.seeing import cannot_see, explains_little
from contarm_sim.identify.search.shared import shared
from contarm_sim.model.arm import Arm
from contarm_sim.statics.places import Places

ARM = Arm()
BLOCKS = np.array([f"block {k // 10}" for k in range(60)])


class Waves:
    """Predicts a marker that swings at a rate: its offset x over 0.1 m; many valleys. No pose beyond `most`."""

    def __init__(self, recording, most=np.inf):
        self.recording, self.most, self.calls = recording, most, 0

    def __call__(self, arms, rigs):
        self.calls += 1
        offsets = np.array([rig.markers[0].offset for rig in rigs])
        out = np.zeros((len(rigs), len(self.recording), 1, 3))
        out[:, :, 0, 0] = 0.1 * np.sin(offsets[:, :1] / 0.1 * self.recording.time)
        out[:, :, 0, 1] = offsets[:, 1:2]
        out[offsets[:, 0] > self.most] = np.nan
        return out


def _recording(rate=0.5, shift=0.02, count=60, **kwargs):
    blank = np.zeros((count, 1, 3))
    made = Recording("static", np.arange(count) * 1.0, blank, np.zeros((count, 0)),
                     Rig(actuation=Actuation(drive="none")), BLOCKS[:count],
                     **kwargs)  # fmt: skip
    true = replace(made.rig, markers=(replace(made.rig.markers[0], offset=(0.1 * rate, shift, 0)),))
    noise = np.random.default_rng(0).normal(0, 1e-4, blank.shape)
    return replace(made, positions=Waves(made)([ARM], [true])[0] + noise)


FREE = [Free(name="marker.offset.x", low=-0.01, high=0.2), "marker.offset.y"]


def _fit(recording, free=FREE, **kwargs):
    return fit(ARM, recording, free, predictors=[Waves(recording)], **kwargs)


def test_least_squares_from_one_start_stay_in_their_valley():
    assert _fit(_recording(rate=0.7, count=20)).left[0].rms() > 0.05


@pytest.mark.parametrize("options", [{"method": "cma"}, {"starts": 12}])
def test_populations_and_many_starts_find_the_deepest_valley(options):
    if options.get("method") == "cma":
        pytest.importorskip("cma")
    recording = _recording(rate=0.7, count=20)
    found = [_fit(recording, seed=seed, **options) for seed in (1, 1)]
    assert found[0].parameters[0].value == pytest.approx(0.07, abs=1e-4)
    assert found[0].cost == found[1].cost
    assert found[0].parameters[0].value == found[1].parameters[0].value
    assert list(found[0].cost) == sorted(found[0].cost)
    assert len(found[0].cost) == options.get("starts", 1)


class Pulled:
    """Predicts a marker that moves as far as three tendons are wound in beyond their slack, and hides what all share.

    While all are taut a common slack changes nothing; only what is pulled differently moves the marker.
    """

    def __init__(self, recording):
        self.recording = recording

    def __call__(self, arms, rigs):
        told = np.array([rig.actuation.values(self.recording.commands) for rig in rigs])
        pulled = np.maximum(-told, 0) * 5.0
        pulled = np.where((told < 0).all(axis=-1, keepdims=True), -told * 5.0, pulled)
        out = np.stack([pulled[..., 0] - pulled[..., 1], pulled[..., 1] - pulled[..., 2], 0 * told[..., 0]], axis=-1)
        return out[:, :, None] + np.array([rig.position for rig in rigs])[:, None, None]


def test_tendons_that_were_slack_are_found_from_where_all_are_taut():
    """From slack 0 the common slack has no slope: a search from there alone says that it changes nothing."""
    phase = np.linspace(0, 6 * np.pi, 60)[:, None] - 2 * np.pi / 3 * np.arange(3)
    rig = Rig(actuation=Actuation(channels=(0, 1, 2)))
    made = Recording("static", np.arange(60.0), np.zeros((60, 1, 3)), 0.011 + 0.01 * np.cos(phase), rig, BLOCKS)
    true = replace(rig, actuation=replace(rig.actuation, slack=(0.006, 0.005, 0.007)))
    seen = Pulled(made)([ARM], [true])[0] + np.random.default_rng(0).normal(0, 1e-4, (60, 1, 3))
    made = replace(made, positions=seen)
    for free in (["actuation.slack_1", "actuation.slack_2", "actuation.slack_3"], ["actuation.slack", "frame.z"]):
        found = fit(ARM, made, free, predictors=[Pulled(made)])
        assert found.rig.actuation.slack == pytest.approx((0.006, 0.005, 0.007), abs=2e-4 if len(free) > 2 else 2e-3)
    assert explains_little(found) == ""
    held = fit(ARM, made, ["frame.x"], predictors=[Pulled(made)])
    assert re.search("leaves over [0-9]+ % of the markers' motion", explains_little(held))


def test_starts_without_a_pose_fail_and_are_told():
    recording = _recording(rate=0.02)
    found = fit(ARM, recording, FREE, predictors=[Waves(recording, most=0.1)], starts=6)
    lost = sum(np.isinf(found.cost))
    assert 0 < lost < 6
    assert f"{lost} of 6 starts failed" in found.message
    assert found.parameters[0].value == pytest.approx(0.002, abs=1e-4)
    with pytest.raises(InputError, match="without a pose at any sample"):
        fit(ARM, recording, FREE, predictors=[Waves(recording, most=-1)])


def test_a_search_comes_back_from_where_there_is_no_pose():
    recording = _recording(rate=0.02)
    found = fit(ARM, recording, FREE, predictors=[Waves(recording, most=0.0021)])
    assert found.parameters[0].value == pytest.approx(0.002, abs=1e-4)
    assert np.isfinite(found.left[0].predicted).all()


@pytest.mark.parametrize("after", [1, 6, 11])
def test_ctrl_c_returns_what_was_found_so_far(after):
    recording, rms = _recording(rate=0.02), []

    def stop(progress):
        rms.append(progress.rms)
        if len(rms) == after:
            raise KeyboardInterrupt

    if after == 1:  # before there is anything
        with pytest.raises(KeyboardInterrupt):
            _fit(recording, on_progress=stop)
        return
    found = _fit(recording, on_progress=stop)
    assert not found.converged
    assert found.message.startswith(descent.STOPPED)
    assert found.left[0].rms() == pytest.approx(rms[-1], rel=1e-6)
    assert all(np.isfinite(one.value) and np.isnan(one.low) for one in found.parameters)
    assert {one.status for one in found.parameters} == {"stopped early"}
    assert found.rig.markers[0].offset[0] == found.parameters[0].value


@pytest.mark.parametrize("central", [False, True])
def test_derivatives_beside_where_there_is_no_pose_are_those_of_the_other_side(central):
    recording = _recording()
    problem = Problem(shared(ARM, [recording], FREE), [recording], [np.zeros(60, dtype=bool)],
                      [Waves(recording, most=0.0)], "linear")  # fmt: skip
    found = problem.slopes(np.zeros(2), central).reshape(-1, 3, 2)[:, 0, 0]
    np.testing.assert_allclose(found, -recording.time if central else 0 * found, rtol=1e-3, atol=1e-12)


def test_the_noise_is_that_of_the_end_though_the_first_search_goes_nowhere(monkeypatch):
    recording, searched = _recording(rate=0.02), descent._least_squares
    monkeypatch.setattr(descent, "_least_squares", lambda problem, moved, settled:
                        searched(problem, moved, settled) if settled else (moved, True, ""))  # fmt: skip
    assert _fit(recording).noise == pytest.approx(1e-4, rel=0.2)


@pytest.mark.parametrize("curved", [0.0, 10.0])
def test_a_combination_that_is_open_nearby_alone_is_said_to_be(curved):
    class Sum(Waves):
        def __call__(self, arms, rigs):
            x, y, _ = np.array([rig.markers[0].offset for rig in rigs]).T
            return super().__call__(arms, rigs) * 0 + (x + y + curved * y**2)[:, None, None, None]

    recording = _recording()
    made = replace(recording, positions=np.random.default_rng(0).normal(0, 1e-4, recording.positions.shape))
    [one] = fit(ARM, made, ["marker.offset.x", "marker.offset.y"], predictors=[Sum(made)]).undetermined
    assert "only their sum is determined" in one.said
    assert ("near these values" in one.said) == bool(curved)


def test_frames_without_a_pose_give_none_between_stations():
    frames = np.tile(np.eye(4), (2, ARM.links + 1, 1, 1))
    frames[1] = np.nan
    places = Places(ARM, [0.51])
    about = frames[:, places.stations]
    found = places.between(about[..., :3, 3], about[..., :3, :3])
    assert np.isfinite(found[0]).all()
    assert np.isnan(found[1, 0, :3]).all()


def test_a_fraction_is_held_out_as_whole_blocks():
    recording = _recording(rate=0.02)
    found = [_fit(recording, held_out=0.3, seed=seed).left[0].held_out for seed in (0, 0, 1)]
    assert np.array_equal(found[0], found[1])
    assert not np.array_equal(found[0], found[2])
    assert 0.3 <= found[0].mean() < 0.5
    assert not set(recording.blocks[found[0]]) & set(recording.blocks[~found[0]])


def test_progress_is_told():
    told = []
    done = _fit(_recording(rate=0.02), starts=2, on_progress=told.append)
    counts = [one.evaluation for one in told]
    assert counts == sorted(counts)
    assert counts[-1] <= done.evaluations
    assert {"start 1 of 2", "start 2 of 2", "intervals"} <= {one.phase for one in told}
    assert told[-1].of == told[-1].evaluation


def test_each_recording_has_the_predictor_of_its_kind():
    rubbing = replace(ARM, friction_moment=0.01, friction_stiffness=1.0)
    rest = _recording()
    moving = replace(rest, kind="motion", blocks=np.full(len(rest), "all"), positions=rest.positions + 0)
    assert type(predictor_of(rest, ARM)) is type(predictor_of(rest, rubbing, memory=False)) is AtRest
    assert type(predictor_of(rest, rubbing)) is type(predictor_of(rest, ARM, memory=True)) is WithMemory
    assert type(predictor_of(moving, ARM)) is InMotion
    with pytest.raises(InputError, match="memory is 'yes'"):
        predictor_of(rest, ARM, memory="yes")
    with pytest.raises(InputError, match="friction_moment"):
        predictor_of(rest, ARM, names=["friction_moment"])


@pytest.mark.parametrize("loss", LOSSES)
def test_losses_have_the_derivatives_that_they_say(loss):
    z = np.array([0.01, 0.5, 1.5, 40.0])
    h = 1e-5 * z
    value, slope, curvature = rho(z, loss)
    up, down = rho(z + h, loss), rho(z - h, loss)
    np.testing.assert_allclose(slope, (up[0] - down[0]) / (2 * h), rtol=1e-6)
    np.testing.assert_allclose(curvature, (up[1] - down[1]) / (2 * h), rtol=1e-5, atol=1e-9)
    assert rho(np.array([1e-9]), loss)[0] == pytest.approx(1e-9)
    assert (value <= z).all()


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"free": []}, "free is 'nothing'|free is nothing"),
        ({"free": ["marker.offset.w"]}, "did you mean 'marker.offset"),
        ({"free": ["frame.x", "frame.x"]}, "each parameter once"),
        ({"free": ["marker.offset.z", "marker_1.offset.z"]}, "marker_1.offset.z; allowed: one of them"),
        ({"free": ["muscle.angle"]}, "'muscle.offset'. It turns all. contarm fit"),
        ({"free": ["friction_moment"]}, "friction_moment is omitted; allowed: a value in the arm's file"),
        ({"free": ["*"]}, "A star stands for a number"),
        ({"free": [Free(name="bending_stiffness", low=-1.0, high=1.0)]}, "-1 to 1; allowed: numbers above 0"),
        ({"free": [Free(name="bending_stiffness", mean=-1.0, sd=0.1)]}, "prior of bending_stiffness is -1"),
        ({"held_out": "block 9"}, "did you mean 'block"),
        ({"held_out": ["b*"]}, "samples left to fit to"),
        ({"held_out": 1.5}, "a fraction from 0 to less than 1"),
        ({"held_out": [True, False]}, "a mask of 60 samples"),
        ({"loss": "l2"}, "linear, soft_l1"),
        ({"method": "newton"}, "least-squares, cma"),
        ({"noise": 0.0}, "a length above 0"),
        ({"starts": 0}, "starts is 0"),
        ({"recordings": []}, "one or more"),
        ({"predictors": []}, "predictors is 0; allowed: 1, one for each recording"),
        ({"recordings": "short"}, "free is 4 parameters; allowed: at most 3"),
    ],
)
def test_bad_input_is_one_clear_line(change, said):
    recording = _recording()
    given = {"recordings": recording, "free": FREE} | change
    if given["recordings"] == "short":
        given = {"recordings": recording.part(slice(0, 1)), "free": ["frame.x", "frame.y", "frame.z", "marker.xi"]}
    recordings, free = given.pop("recordings"), given.pop("free")
    own = recordings if isinstance(recordings, Recording) else recording
    with pytest.raises(InputError, match=said) as caught:
        fit(ARM, recordings, free, **{"predictors": [Waves(own)], **given})
    assert "\n" not in str(caught.value)


def test_one_value_for_several_starts_from_one():
    """A fit that frees a value for several would move those that start elsewhere, even where it sees nothing."""
    recording = _recording()
    slack = Actuation(channels=(0, 1), slack=(2e-4, -1e-3))
    wound = replace(recording, rig=Rig(actuation=slack), commands=np.zeros((60, 2)))
    tapered = replace(ARM, sections=(ARM.sections[0], replace(ARM.sections[0], mass=0.5 * ARM.sections[0].mass)),
                      routings=ARM.routings * 2, laws=ARM.laws * 2)  # fmt: skip
    aside = recording.in_rig(replace(recording.rig, position=(0.2, 0, 0)))
    for arm, several, name, said in (
        (ARM, [wound], "actuation.slack", r"0.0002 in one place, -0.001 in another; allowed: .*actuation.slack_\*"),
        (tapered, [recording], "mass", r"another; allowed: one start for all, or section_\*.mass"),
        (ARM, [recording, aside], "frame.x", "frame.x is 0 m in one recording, 0.2 m in another"),
    ):
        with pytest.raises(InputError, match=said):
            shared(arm, several, [name])
    assert shared(tapered, [recording], ["section_*.mass"]).names == ("section_1.mass", "section_2.mass")


def test_a_gain_and_a_radius_make_a_ratio():
    drive = Actuation(channels=(0, 1))
    recording = replace(_recording(), rig=Rig(actuation=drive), commands=np.zeros((60, 2)))
    assert shared(ARM, [recording], ["actuation.gain", "muscle_radius"]).logarithmic == (True, True)
    open_sign = Free(name="actuation.gain", low=-2.0, high=2.0)
    assert shared(ARM, [recording], [open_sign]).logarithmic == (False,)


@pytest.mark.parametrize(
    ("name", "said"),
    [("payload", "the recording says what the tip carries"), ("gravity.z", "the rig says what gravity is"),
     ("section_1.mass", "its weight alone"), ("muscle.damping", "its damping"), ("length", "")],
)  # fmt: skip
def test_why_a_recording_does_not_see_a_parameter(name, said):
    made = _recording()
    rig = replace(made.rig, gravity=(0.0, 0.0, -9.81))
    told = cannot_see(name, [replace(made, rig=rig, payload=np.zeros(60))])
    assert said in told
    assert bool(said) == bool(told)
