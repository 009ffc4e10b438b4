"""Recordings predicted: errors whose sizes are known beforehand, bands, whole backbones, pictures, the command."""

import csv
import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from made_fit import made_fit
from text_boxes import faults

from contarm_sim.errors import InputError
from contarm_sim.identify.freedom import freedom
from contarm_sim.identify.prediction.base import AtRest, under
from contarm_sim.identify.recordings.recording import Recording
from contarm_sim.identify.recordings.rig import Actuation, Marker, Rig
from contarm_sim.identify.recordings.saved import save_recording
from contarm_sim.identify.recordings.synthetic import random_windings, recorded
from contarm_sim.identify.replays.by_fit import held_out_in
from contarm_sim.identify.replays.covariance import Covariance
from contarm_sim.identify.replays.replay import replay
from contarm_sim.model.arm_file import arm_to_toml
from contarm_sim.model.named import with_parameters
from contarm_sim.model.presets import preset
from contarm_sim.statics.equilibria import equilibria
from contarm_sim.view.report.replays import words
from contarm_sim.view.report.replays.course import course_of

NOISE, SHIFT = 0.001, 0.006
BLUE, ORANGE = (130, 150), (10, 32)
"""Hues of balls, of 255."""


@pytest.fixture(scope="module")
def arm():
    return with_parameters(preset("tendon"), {f"section_{k}.links": 3 for k in (1, 2, 3)})


@pytest.fixture(scope="module")
def recording(arm):
    """Return 120 samples of three markers, with noise and gaps."""
    markers = (Marker(name="disk 1", xi=0.4), Marker(name="disk 2", xi=0.72), Marker(offset=(0.0, 0.0, 0.01)))
    rig = Rig(markers=markers, actuation=Actuation(channels=tuple(range(9))), position=(0.1, 0.0, 0.2),
              orientation=(0.0, 0.8, 0.6, 0.0))  # fmt: skip
    windings, blocks = random_windings(arm, 120, 1)
    return recorded(arm, rig, windings, seed=2, noise=NOISE, gaps=0.05, blocks=blocks, name="day 2")


def shifted(recording):
    return recording.in_rig(replace(recording.rig, position=(0.1 + SHIFT, 0.0, 0.2)))


def known(arm, recording, sd, noise=NOISE):
    return Covariance(freedom(arm, recording.rig, ["frame.x"]), np.array([[sd**2]]), noise)


@pytest.fixture(scope="module")
def true(arm, recording):
    return replay(arm, recording, known(arm, recording, 1e-6))


@pytest.fixture(scope="module")
def wrong(arm, recording):
    held = np.arange(len(recording)) >= 96
    return replay(arm, shifted(recording), known(arm, shifted(recording), 1e-6), held_out=held)


def test_the_arm_that_made_a_recording_leaves_its_noise_and_nothing_else(true, recording):
    found = true.differences()
    assert found.count == recording.seen.sum() < 360
    assert found.rms == pytest.approx(np.sqrt(3) * NOISE, rel=4 / np.sqrt(6 * found.count))
    assert np.abs(found.bias).max() < 4 * NOISE / np.sqrt(found.count)
    assert abs(true.bands.share - 0.95) < 4 * np.sqrt(0.95 * 0.05 / found.count)
    low, high = true.bands.foreseen
    assert low < found.rms < high < 1.1 * low
    assert list(true.by_block()) == list(dict.fromkeys(recording.blocks))
    whole = sum(each.count * each.rms**2 for each in true.by_block().values())
    assert whole == pytest.approx(found.count * found.rms**2)


def test_a_base_that_is_off_is_an_offset_of_all_markers_and_no_distance_between_them(true, wrong):
    found = wrong.differences()
    assert found.bias == pytest.approx((-SHIFT + true.differences().bias[0], *true.differences().bias[1:]))
    assert found.centred_rms == pytest.approx(true.differences().centred_rms)
    assert found.rms == pytest.approx(np.hypot(SHIFT, np.sqrt(3) * NOISE), rel=0.02)
    assert [row[1:] for row in wrong.stretch()] == [pytest.approx(row[1:]) for row in true.stretch()]
    assert wrong.bands.share < 0.05
    told = words.standings(wrong)
    assert [one.state for one in told] == ["note", "bad"]
    assert "24 of 120" in told[0].text
    assert "one offset" in told[1].text
    assert "one offset" not in words.standings(true)[1].text


def test_bands_are_those_of_a_parameter_that_moves_all_markers_alike(arm, recording):
    """The base's place is off by 6 mm, and known to 6 mm: then most markers are inside, and the rms is foreseen."""
    moved = shifted(recording)
    found = replay(arm, moved, known(arm, moved, SHIFT))
    half = found.bands.half_width
    assert half[..., 0] == pytest.approx(1.959964 * np.hypot(SHIFT, NOISE), rel=1e-6)
    assert half[..., 1:] == pytest.approx(1.959964 * NOISE, rel=1e-6)
    assert found.bands.share > 0.9
    size = found.differences().rms
    assert found.bands.foreseen[0] < size < found.bands.foreseen[1]
    assert found.bands.rms[0] < np.sqrt(3) * NOISE * 1.05 < size < found.bands.rms[1]


def test_whole_backbones_are_those_of_the_poses_and_give_their_joint_angles(arm, true, recording):
    from contarm_sim.view.rendering.replayed import joint_angles

    poses = equilibria(*under(arm, recording.rig, recording.part(slice(0, 120, 7))))
    np.testing.assert_allclose(true.frames[::7], poses.frames, atol=1e-8)
    np.testing.assert_allclose(joint_angles(arm, poses.frames), poses.qpos, atol=1e-9)
    twisting = with_parameters(arm, {f"section_{k}.torsional_stiffness": 0.02 for k in (1, 2, 3)})
    poses = equilibria(*under(twisting, recording.rig, recording.part(slice(0, 120, 30))))
    np.testing.assert_allclose(joint_angles(twisting, poses.frames), poses.qpos, atol=1e-9)


def test_the_worst_samples_come_first_and_are_apart(arm, recording):
    positions = recording.positions.copy()
    positions[[20, 21, 70]] += [[[0, 0.03, 0]], [[0, 0.028, 0]], [[0, 0.02, 0]]]
    found = replay(arm, replace(recording, positions=positions))
    assert found.worst(2) == [20, 70]
    assert len(found.worst()) == 6
    assert found.bands is None
    (alone,) = words.standings(found)
    assert "--fit" in alone.text


def test_outliers_are_told_of_and_bands_are_judged_without_them(arm, recording):
    positions = recording.positions.copy()
    positions[::30] += 0.05
    found = replay(arm, replace(recording, positions=positions), known(arm, recording, 1e-6),
                   held_out=np.ones(len(recording), dtype=bool))  # fmt: skip
    far = int(np.isfinite(positions[::30]).all(axis=-1).sum())
    bands = words.standings(found)[1]
    assert f"; {far} outliers of {found.differences().count}." in bands.title
    assert bands.state == "good"
    assert f"{far} outliers" in words.headline(found)
    assert words.status_words(found, 0) == "predicted"
    assert found.figure("errors").axes[0].get_ylim()[1] < 10
    assert found.figure("histogram").axes[0].get_xlim()[1] < 10


class Swings:
    """Says that markers are where they were measured, once a hand has let go."""

    def __init__(self, recording):
        self.recording = recording

    def __call__(self, arms, rigs):
        out = np.tile(np.array([0.0, 0.0, 0.1]), (len(arms), len(self.recording), len(rigs[0].markers), 1))
        out[:, :3] = np.nan
        out[:, self.recording.blocks == "3"] = np.nan
        return out


@pytest.mark.parametrize("kind", ["static", "motion"])
def test_a_recording_that_a_fit_was_made_from_is_known_again(kind):
    """A fit knows no positions before a swing starts, and may have had every tenth sample alone."""
    done = made_fit(kind, recordings=2)
    first, second = done.left
    whole = second.recording
    unseen = whole.positions.copy()
    unseen[::30] = np.nan
    thin = slice(1, None, 10)
    some = replace(second, recording=replace(whole, positions=unseen).part(thin), predicted=second.predicted[thin],
                   held_out=second.held_out[thin])  # fmt: skip
    for left in (replace(second, recording=replace(whole, positions=unseen)), some):
        place, held = held_out_in(replace(done, left=(first, left)), replace(whole, name="a copy"))
        assert place == 1
        np.testing.assert_array_equal(held, second.held_out)
    early = replace(second, recording=whole.part(slice(0, 100)), predicted=second.predicted[:100],
                    held_out=np.zeros(100, dtype=bool))  # fmt: skip
    np.testing.assert_array_equal(held_out_in(replace(done, left=(early,)), whole)[1], np.arange(240) >= 100)
    place, held = held_out_in(done, replace(whole, positions=whole.positions + 1e-5))
    assert place is None
    assert held.all()


def test_a_replay_without_bands_predicts_once(arm, recording):
    calls = []

    class Counted(AtRest):
        def __call__(self, arms, rigs):
            calls.append(len(arms))
            return super().__call__(arms, rigs)

    few = recording.part(slice(0, 8))
    found = replay(arm, few, predictor=Counted)
    assert calls == [1]
    np.testing.assert_allclose(found.predicted, AtRest(few)([arm], [few.rig])[0], atol=1e-12)


def test_swings_are_drawn_one_after_the_other_and_count_from_where_the_hand_lets_go(arm):
    time, blocks = np.tile(np.arange(10) * 0.01, 3), np.repeat(["1", "2", "3"], 10)
    bare = Recording("motion", time, np.zeros((30, 1, 3)), np.zeros((30, 0)), Rig(actuation=Actuation(drive="none")),
                     blocks)  # fmt: skip
    found = replay(arm, bare, predictor=Swings)
    assert found.unpredicted == 10
    assert found.differences().count == 17
    course = course_of(found)
    assert (np.diff(course.places) > 0).all()
    assert [part.start for part in course.parts] == [0, 10, 20]


class Faster:
    """Says that arms swing at 1.25 Hz and 2 1/s, whatever they are."""

    def __init__(self, recording):
        self.recording = recording

    def __call__(self, arms, rigs):
        return np.broadcast_to(
            swing(self.recording.time, 1.25, 2.0)[:, None], (len(arms), 160, len(rigs[0].markers), 3)
        )


def swing(time, frequency, damping):
    return np.stack([0.1 * np.exp(-damping * time) * np.cos(2 * np.pi * frequency * time), 0 * time, 0 * time], axis=-1)


def test_swings_are_measured_alike_and_those_that_grow_are_left_out(arm):
    """One release swings at 1.2 Hz and fades with 1.6 1/s; the other grows: somebody pushes the arm."""
    time, blocks = np.tile(np.arange(80) * 0.02, 2), np.repeat(["1", "2"], 80)
    positions = np.concatenate([swing(time[:80], 1.2, 1.6), swing(time[80:], 1.2, -1.0)])[:, None]
    bare = Recording("motion", time, positions, np.zeros((160, 0)), Rig(actuation=Actuation(drive="none")), blocks)
    found = replay(arm, bare, predictor=Faster)
    (one,) = found.swings
    assert one.block == "1"
    assert one.frequency_percent == pytest.approx(100 / 24, abs=0.05)
    assert one.damping_percent == pytest.approx(25, abs=0.5)
    assert words.swing_rows(found)[0][3:] == ["+4.2", "1.60", "2.00", "+25.0"]
    for width in ("page", "column"):
        assert not faults(found.figure("swings", width))


@pytest.mark.parametrize(
    ("width", "names"),
    [("page", ("components", "errors", "histogram", "paths", "worst")), ("column", ("components", "errors", "worst"))],
)
def test_figures_are_clean(wrong, width, names):
    for name in names:
        sheet = wrong.figure(name, width)
        assert not faults(sheet), name
        assert all(axes.get_xlabel() or axes.get_shared_x_axes().get_siblings(axes) for axes in sheet.axes), name


def test_films_show_the_real_markers_where_they_were_measured(arm, wrong, gl):
    """Blue balls move as far as the recording's markers are moved, and the arm stays."""
    from PIL import Image

    from contarm_sim.view.rendering.look import Look
    from contarm_sim.view.rendering.replayed import ReplayShot

    look = Look(320, 240, captions=False, plots=False)
    higher = wrong.recording.positions + np.array([0, 0, 0.05])
    moved = replace(wrong, recording=replace(wrong.recording, positions=higher))
    films = [list(ReplayShot(each, look, 3).frames()) for each in (wrong, moved)]
    assert [len(pictures) for pictures in films] == [3, 3]

    def blobs(picture, low, high):
        """Return pixels of a range of hues that are as bright as balls are, and no muscle."""
        hue, saturation, value = np.moveaxis(np.asarray(Image.fromarray(picture).convert("HSV")), -1, 0)
        return np.argwhere((hue >= low) & (hue <= high) & (saturation > 200) & (value > 180))

    for one, other in zip(*films, strict=True):
        assert len(blobs(one, *ORANGE)) > 3
        before, after = (blobs(each, *BLUE) for each in (one, other))
        assert len(after) > 3
        assert abs(after.mean(axis=0) - before.mean(axis=0)).max() > 3


def test_notebooks_show_the_errors(wrong):
    shown = wrong._repr_html_()
    assert "6.27" in shown
    assert "This is a" in shown or "Part of it is a prediction" in shown
    assert repr(wrong).startswith("Replay('day 2', 120 samples, rms 6.27 mm")


def test_what_does_not_fit_is_refused(arm, recording, true):
    with pytest.raises(InputError, match="another arm or rig"):
        replay(arm, shifted(recording), known(arm, recording, 0.001))
    with pytest.raises(InputError, match="one for each sample"):
        replay(arm, recording, held_out=[True])
    with pytest.raises(InputError, match="components, errors"):
        true.figure("nothing")
    own = freedom(arm, recording.rig, ["frame.x"])
    for matrix in (np.eye(2), np.array([[np.nan]]), np.array([[-1.0]])):
        with pytest.raises(InputError, match="covariance"):
            Covariance(own, matrix, NOISE)


@pytest.fixture(scope="module")
def files(arm, recording, tmp_path_factory):
    folder = tmp_path_factory.mktemp("replay")
    (folder / "arm.toml").write_text(arm_to_toml(arm))
    return folder / "arm.toml", save_recording(shifted(recording), folder / "day 2")


def test_the_command_leaves_numbers_that_agree_and_a_page(contarm, files, wrong, blank_figures):
    code, out, err = contarm("replay", *files, "--within", "5mm", "--no-video", "--json", "--out", "it")
    assert code == 1
    assert "above the 5 mm" in err
    told, summary = json.loads(out), json.loads(Path("it/summary.json").read_text())
    assert told == summary
    assert told["verdict"] == "fail"
    assert told["error"]["rms_m"] == pytest.approx(wrong.differences().rms, rel=1e-6)
    rows = list(csv.DictReader(Path("it/replay.csv").read_text().splitlines()))
    tips = [float(row["error.tip_m"]) for row in rows if row["error.tip_m"]]
    assert np.sqrt(np.mean(np.square(tips))) == pytest.approx(told["by_marker"]["tip"]["rms_m"], rel=1e-6)
    with np.load("it/replay.npz") as kept:
        np.testing.assert_allclose(kept["predicted"], wrong.predicted, atol=1e-8)
        assert kept["stations"].shape == (120, 10, 3)
    page = Path("it/report.html").read_text()
    assert told["in_words"] in page.replace("\u00a0", " ")
    assert {path.name for path in Path("it").glob("*.png")} == {
        f"{stem}.png" for stem in ("components", "errors", "histogram", "paths", "worst")
    }


def test_some_samples_and_errors_in_one_line(contarm, files, tmp_path):
    code, out, _ = contarm("replay", *files, "--samples", 12, "--within", "1cm", "--no-video", "--figures", "none")
    assert code == 0
    assert "12 samples" in out
    assert "errors [mm]" in out
    for words_of, said in (
        ((files[1],), "an arm (or the folder of a fit) and a recording"),
        ((*files, files[1]), "3 arguments"),
        ((files[0], "missing.toml"), "missing.toml"),
        ((*files, "--within", "5"), "such as 5mm"),
        ((tmp_path, files[1]), str(tmp_path)),
    ):
        code, out, err = contarm("replay", *words_of)
        assert (code, out) == (2, "")
        assert said in err
        assert err.count("\n") == 1


def test_ctrl_c_leaves_nothing_half_written(contarm, files, monkeypatch):
    from contarm_sim.view.report.replays.report import ReplayReport

    def stopped(*_):
        raise KeyboardInterrupt

    monkeypatch.setattr(ReplayReport, "write", stopped)
    code, *_ = contarm("replay", *files, "--samples", 3, "--out", "it")
    assert code == 130
    assert not list(Path().glob("*it*")) + list(Path().glob(".*"))
