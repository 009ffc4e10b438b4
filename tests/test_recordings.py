"""Recordings: what files say comes out in SI units, in order, in the frame that is named; what is saved comes back."""

import gzip
import tomllib
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from contarm_sim import Actuation, Marker, Rig, load_recording, presets, save_recording
from contarm_sim.identify.recordings.checks import check_against, findings, frozen, outliers
from contarm_sim.identify.recordings.file import KEYS, recording_from_frame
from contarm_sim.identify.recordings.recording import Recording
from contarm_sim.identify.recordings.rig_file import load_rig, save_rig
from contarm_sim.identify.recordings.synthetic import random_windings, recorded

EXAMPLES = sorted((Path(__file__).parents[1] / "examples" / "recordings").glob("*.toml"))
ARM = presets.tendon()
RIG = Rig(
    markers=(Marker(name="middle", xi=0.5), Marker(offset=(0.002, 0.0, 0.008))),
    actuation=Actuation(channels=tuple(range(9)), signs=(1, -1, 1) * 3, gains=(0.5,) * 9, slack=(3e-4,) * 9),
    position=(0.1, 0.2, 1.0),
    orientation=(0.0, 1.0, 0.1, 0.0),
    turn=(0.01, 0.0, 0.02),
    gravity=(0.0, 0.0, -9.81),
)
SMALL = """
kind = "static"
data = "{data}"
[time]
column = "t"
unit = "ms"
[commands]
drive = "windings"
columns = ["a", "b"]
unit = "mm"
pull = "negative"
[[markers]]
columns = ["x", "y", "z"]
unit = "cm"
offset = ["2 mm", 0, 0.01]
"""
ROWS = "t,a,b,x,y,z\n1000,1,-2,10,20,30\n2000,3,-4,11,,31\n3500,5,-6,12,22,32\n4000,5,-7,12,22,33\n"


@pytest.fixture(scope="module")
def made():
    commands, blocks = random_windings(ARM, 90, seed=1)
    rig = replace(RIG, actuation=Actuation(channels=tuple(range(9))))
    return recorded(ARM, rig, commands, seed=2, blocks=blocks, gaps=0.1, payload=0.02, force=(0, 0, 0.1))


def written(folder, toml=SMALL, rows=ROWS, data="poses.csv", pack=None):
    content = rows.encode() if isinstance(rows, str) else rows
    (folder / data).write_bytes(gzip.compress(content) if data.endswith(".gz") else content)
    (folder / "r.toml").write_text(toml.replace("{data}", data))
    return folder / "r.toml"


def test_columns_units_and_gaps_of_a_csv_file(tmp_path):
    found = load_recording(written(tmp_path))
    assert found.time.tolist() == [0.0, 1.0, 2.5, 3.0]  # ms, from the first sample
    assert found.commands.tolist() == [[-0.001, 0.002], [-0.003, 0.004], [-0.005, 0.006], [-0.005, 0.007]]
    assert found.positions[0, 0].tolist() == [0.1, 0.2, 0.3]
    assert found.seen[:, 0].tolist() == [True, False, True, True]
    assert found.rig.markers[0].offset == (0.002, 0.0, 0.01)
    assert found.rig.actuation.channels == (0, 1)
    assert found.name == "r"


def test_a_slow_log_is_drawn_through_its_updates_but_not_through_rest(tmp_path):
    held = [0, 0, 2, 2, 4, 4, 6, 6, 6, 6, 6, 6, 8, 8, 10, 10]
    rows = "t,a,b,x,y,z\n" + "".join(f"{k},{a},{-a},1,2,{k}\n" for k, a in enumerate(held))
    toml = SMALL.replace("[[markers]]", 'between_updates = "linear"\n[[markers]]')
    found = load_recording(written(tmp_path, toml, rows))
    wanted = np.array([0, 1, 2, 3, 4, 5, 6, 6, 6, 6, 6, 7, 8, 9, 10, 10])
    np.testing.assert_allclose(found.commands, 1e-3 * np.stack([-wanted, wanted], axis=1), atol=1e-12)
    apart = toml.replace("[commands]", "[block]\nseconds = 0.004\n[commands]")  # four rows each: lines end with them
    of_block = load_recording(written(tmp_path, apart, rows)).commands[:, 1]
    np.testing.assert_allclose(of_block[:8], 1e-3 * np.array([0, 1, 2, 2, 4, 5, 6, 6]), atol=1e-12)


@pytest.mark.parametrize(
    "change", ["gz", "bom", "semicolons", "decimal commas", "blank lines", "skipped lines", "names"]
)
def test_the_same_table_written_in_other_ways_is_the_same_recording(tmp_path, change):
    toml, rows, data = SMALL, ROWS, "poses.csv"
    if change == "gz":
        data = "poses.csv.gz"
    elif change == "bom":
        rows = ROWS.encode("utf-8-sig")
    elif change == "semicolons":
        rows = ROWS.replace(",", ";")
    elif change == "decimal commas":
        rows = ROWS.replace(",", "\t").replace("10\t20", "10,0\t2,0e1")
    elif change == "blank lines":
        rows = "\n" + ROWS.replace("\n", "\n\n").replace("\n", "\r\n")
    elif change == "skipped lines":
        rows, toml = "exported by a tracker\nat, noon\n" + ROWS, "skip = 2\n" + SMALL
    elif change == "names":
        rows, toml = ROWS.partition("\n")[2], 'names = ["t", "a", "b", "x", "y", "z"]\n' + SMALL
    (tmp_path / "other").mkdir()
    plain, other = load_recording(written(tmp_path)), load_recording(written(tmp_path / "other", toml, rows, data))
    for name in ("time", "commands", "positions", "blocks"):
        np.testing.assert_array_equal(getattr(plain, name), getattr(other, name))


def test_arrays_and_frames_are_read_as_csv_files_are(tmp_path):
    pandas = pytest.importorskip("pandas")
    plain = load_recording(written(tmp_path))
    values = plain.positions[:, 0] * 100
    np.savez(tmp_path / "d.npz", t=plain.time * 1000, u=-plain.commands * 1000, p=values[:, None], rate=100.0)
    toml = SMALL.replace('["a", "b"]', '"u"').replace('["x", "y", "z"]', '"p"').replace("{data}", "d.npz")
    (tmp_path / "n.toml").write_text(toml)
    spec = {key: value for key, value in tomllib.loads(SMALL).items() if key != "data"}
    frame = pandas.DataFrame(dict(zip("tab", [plain.time * 1000, *-plain.commands.T * 1000], strict=True)))
    frame[["x", "y", "z"]] = values
    for other in (load_recording(tmp_path / "n.toml"), recording_from_frame(frame, spec)):
        np.testing.assert_allclose(other.positions, plain.positions, rtol=1e-15)
        np.testing.assert_allclose(other.commands, plain.commands, rtol=1e-15)
        np.testing.assert_allclose(other.time, plain.time, rtol=1e-15)


def test_numbers_and_columns_that_say_that_nothing_was_seen(tmp_path):
    rows = "t,a,b,x,y,z,ok\n0,1,2,1,2,3,1\n1,1,3,-9999,2,3,1\n2,1,4,1,2,3,0\n3,1,4,1,lost,3,1\n"
    rows += "4,1,5,1,2,3,1\n5,1,5,1,2,4,1\n"
    gaps = '[gaps]\nvalues = [-9999, "lost"]\nvalid = "ok"\n'
    found = load_recording(written(tmp_path, SMALL + gaps, rows))
    assert found.seen[:, 0].tolist() == [True, False, False, False, True, True]
    rows = "t,a,b,x,y,z\n" + "".join(f"{k},{k},0,{k if k < 3 else 3},0,1\n" for k in range(9))
    found = load_recording(written(tmp_path, SMALL + "[gaps]\nfrozen = 4\n", rows))
    assert found.seen[:, 0].tolist() == [True] * 4 + [False] * 5  # the first at that place was seen


def test_samples_without_commands_are_left_out(tmp_path):
    found = load_recording(written(tmp_path, rows=ROWS.replace("2000,3,-4", "2000,,-4")))
    assert found.time.tolist() == [0.0, 2.5, 3.0]


def test_blocks_of_columns_restarts_files_and_lengths(tmp_path):
    rows = "n,label,x,y,z,u\n" + "".join(
        f"{k},{name},0,0,{1 + k},{k}\n" for name in ("a", "a_hold", "b") for k in range(4)
    )
    head = 'kind = "static"\ndata = "{data}"\n'
    tail = '[commands]\ndrive = "tensions"\ncolumns = ["u"]\n[[markers]]\ncolumns = ["x", "y", "z"]\n'

    def blocks(said):
        return load_recording(written(tmp_path, head + said + tail, rows)).blocks.tolist()

    assert blocks('block = "label"\n') == ["a"] * 4 + ["a_hold"] * 4 + ["b"] * 4
    assert blocks("block = {column = 'label', match = '(.*?)(_hold)?$'}\n") == ["a"] * 8 + ["b"] * 4
    assert blocks("block = {restart = 'n'}\n[time]\ncolumn = 'n'\nrate = 10\n") == ["1"] * 4 + ["2"] * 4 + ["3"] * 4
    assert blocks("block = {seconds = 0.5}\n[time]\nrate = 10\n") == ["1"] * 5 + ["2"] * 7
    (tmp_path / "two.csv").write_text(rows)
    files = '[[data]]\nfile = "poses.csv"\npayload = "200 g"\n[[data]]\nfile = "two.csv"\nblock = "c"\npayload = 0.3\n'
    found = load_recording(
        written(tmp_path, 'kind = "motion"\ntime = {rate = 100}\nblock = "label"\n' + files + tail, rows)
    )
    assert list(dict.fromkeys(found.blocks.tolist())) == [
        "poses/a",
        "poses/a_hold",
        "poses/b",
        "c/a",
        "c/a_hold",
        "c/b",
    ]
    assert found.payload.tolist() == [0.2] * 12 + [0.3] * 12
    assert found.time.tolist() == [0.0, 0.01, 0.02, 0.03] * 6


def test_a_block_of_a_motion_that_begins_again_is_another(tmp_path):
    rows = "t,label,x,y,z\n" + "".join(f"{k},{'ab'[k // 2 % 2]},0,{k},1\n" for k in range(8))
    toml = 'kind = "motion"\ndata = "{data}"\nblock = "label"\ntime = {column = "t"}\n'
    toml += '[[markers]]\ncolumns = ["x", "y", "z"]\n'
    found = load_recording(written(tmp_path, toml, rows))
    assert list(dict.fromkeys(found.blocks.tolist())) == ["a", "b", "a (2)", "b (2)"]


def test_ranges_blocks_and_every_other_sample_are_chosen(tmp_path):
    rows = "t,label,x,y,z,u\n" + "".join(f"{k},rep{k // 10}_x,0,0,1,{k}\n" for k in range(40))
    toml = ('kind = "static"\ndata = "{data}"\nblock = "label"\ntime = {column = "t"}\n[commands]\ndrive = "tensions"\n'
            'columns = ["u"]\n[[markers]]\ncolumns = ["x", "y", "z"]\n')  # fmt: skip

    def times(said):
        return load_recording(written(tmp_path, said + toml, rows)).time.tolist()

    assert times("keep = {time = [[0, 3], [35, 99]]}\n") == [0, 1, 2, 3, 35, 36, 37, 38, 39]
    assert times('keep = {blocks = ["rep1_*"]}\ndrop = {time = [11, 18]}\n') == [10, 19]
    assert times('drop = {blocks = "rep[0-2]*"}\nevery = 4\n') == [30, 34, 38]


def test_angles_wind_on_pulleys_and_one_channel_drives_two_muscles(tmp_path):
    commands = 'drive = "windings"\ncolumns = ["a", "b"]\nunit = "deg"\npulley_radius = ["10 mm", 0.02]\n'
    commands += 'channels = ["b", "b", 1]\nsigns = [1, -1, 1]\nslack = "1 mm"\n'
    toml = SMALL.partition("drive")[0] + commands + "[[markers]]" + SMALL.partition("[[markers]]")[2]
    found = load_recording(written(tmp_path, toml, ROWS.replace("1,-2", "180,-90")))
    wound = -found.rig.actuation.values(found.commands[0])
    np.testing.assert_allclose(wound, [-0.01 * np.pi - 0.001, 0.01 * np.pi - 0.001, 0.01 * np.pi - 0.001])


def test_places_of_markers_in_the_ways_people_say_them(tmp_path):
    for said, xi in (
        ("xi = 0.25", 0.25), ('at = "base"', 0.0), ("section_end = 2", 0.37 / 0.51), ("place = '100 mm'", 0.1 / 0.51),
        ("station = 18", 0.285 / 0.51), ("station = 36", 1.0),
    ):  # fmt: skip
        toml = SMALL.replace("offset", f"{said}\noffset").replace('columns = ["a", "b"]', f"columns = {['a', 'b']}")
        toml = toml.replace("pull =", f"channels = {[1, 2, 1] * 3}\npull =")
        found = load_recording(written(tmp_path, toml), ARM)
        assert found.rig.markers[0].xi == pytest.approx(xi, rel=1e-12), said


@pytest.mark.parametrize(
    ("said", "z", "x"),
    [
        ('z = "-y"\nx = "x"', (0, -1, 0), (1, 0, 0)), ('z = "-y"', (0, -1, 0), (1, 0, 0)),
        ('x = "y"', (0, 0, 1), (0, 1, 0)),
        ('z = "-z"', (0, 0, -1), (1, 0, 0)), ("z = [0, 3, 4]\nx = [-1, 0, 0]", (0, 0.6, 0.8), (-1, 0, 0)),
        ('z = "x"\nx = [5, 0, -1]', (1, 0, 0), (0, 0, -1)), ("orientation = [2, 0, 0, 0]", (0, 0, 1), (1, 0, 0)),
    ],
)  # fmt: skip
def test_frames_by_the_axes_of_the_arm(tmp_path, said, z, x):
    rig = load_recording(written(tmp_path, SMALL + f"[frame]\n{said}\ngravity = '-y'\nposition = ['1 cm', 0, 0]\n")).rig
    np.testing.assert_allclose(rig.rotation[:, 2], z, atol=1e-15)
    np.testing.assert_allclose(rig.rotation[:, 0], x, atol=1e-15)
    assert np.linalg.det(rig.rotation) == pytest.approx(1)
    assert rig.gravity == (0.0, -9.81, 0.0)
    assert rig.position == (0.01, 0.0, 0.0)


def test_what_is_saved_comes_back_to_the_bit(made, tmp_path):
    found = load_recording(save_recording(made, tmp_path / "r"))
    for name in ("time", "positions", "commands", "blocks", "payload", "force"):
        np.testing.assert_array_equal(getattr(found, name), getattr(made, name))
    assert found.rig == made.rig
    assert (found.kind, found.name, found.force_xi) == (made.kind, made.name, made.force_xi)
    late = made.part(slice(30, None))
    assert load_recording(save_recording(late, tmp_path / "late")).time[0] == late.time[0] == 30


def test_rigs_come_back_and_stand_in_another_recording(made, tmp_path):
    assert load_rig(save_rig(RIG, tmp_path / "rig.toml")) == RIG
    assert made.in_rig(RIG).rig.position == RIG.position
    assert sorted(path.name for path in tmp_path.iterdir()) == ["rig.toml"]


def test_a_synthetic_recording_has_the_noise_gaps_and_outliers_that_were_asked_for(made):
    commands, rig = made.commands, made.rig
    bare = recorded(ARM, rig, commands, seed=2, noise=0, payload=0.02, force=(0, 0, 0.1), blocks=made.blocks)
    error = (made.positions - bare.positions)[made.seen]
    assert error.std() == pytest.approx(5e-4, rel=0.1)
    assert abs(error.mean()) < 1e-4
    assert (~made.seen).mean() == pytest.approx(0.1, abs=0.01)
    again = recorded(ARM, rig, commands, seed=2, blocks=made.blocks, gaps=0.1, payload=0.02, force=(0, 0, 0.1))
    np.testing.assert_array_equal(again.positions, made.positions)
    far = recorded(ARM, rig, commands, seed=3, outliers=0.1, drift=0.004, noise=0, payload=0.02, force=(0, 0, 0.1))
    off = np.linalg.norm(far.positions - bare.positions, axis=-1)
    assert (off > 0.005).mean() == pytest.approx(0.1, abs=0.04)
    assert np.median(off[-9:]) == pytest.approx(0.004, rel=0.1)


def test_random_windings_are_closed_patterns_within_their_bends(made):
    for block in set(made.blocks.tolist()):
        first = made.commands[made.blocks == block][0]
        np.testing.assert_allclose(first, 5e-4, atol=1e-15)  # straight, and taut
    straight = np.array([group.routing.radius for group in ARM.groups])
    most = np.abs(made.commands - 5e-4).max()
    assert 0.3 * straight.max() < most <= 2.0 * straight.max()
    only = made.commands[made.blocks == "1_section_1"]
    assert np.ptp(only, axis=0).min() > 0.003  # tendons of sections 2 and 3 run through section 1


def test_outliers_are_found_and_clean_poses_are_not(made):
    assert outliers(made).sum() <= 2
    positions = np.array(made.positions)
    rows = [20, 36, 60]
    positions[rows, 1] += 0.06
    found = outliers(replace(made, positions=positions))
    assert found[[row for row in rows if made.seen[row, 1]], 1].all()


def test_drop_outs_and_what_is_odd_are_said_not_refused(made):
    positions, commands = np.array(made.positions), np.array(made.commands)
    positions[10:20, 0] = (0.3, 0.3, 0.3)
    commands[:, 4] = 0.0
    time = np.array(made.time)
    time[40:] += 20.0
    odd = replace(made, positions=positions, commands=commands, time=time)
    assert frozen(odd)[11:20, 0].all()
    assert not frozen(odd)[:10].any()
    said = "\n".join(findings(odd))
    assert "marker middle: 9 of 90 samples at the very same place" in said
    assert "time: 1 gap, the longest of 21 s, where samples are usually 1 s apart" in said
    assert "channel 5: the same in all samples" in said
    assert "marker tip: 9 of 90 samples not seen" in said


def test_a_part_may_lack_a_marker_that_the_whole_has(made):
    alone = made.part(~made.seen[:, 0])
    assert len(alone) == 9
    assert not alone.seen[:, 0].any()
    assert isinstance(alone, Recording)


@pytest.mark.parametrize("path", EXAMPLES, ids=[path.stem for path in EXAMPLES])
def test_the_described_data_sets_have_keys_that_are_read(path, tmp_path):
    spec = tomllib.loads(path.read_text())
    assert set(spec) <= set(KEYS)
    columns = [name for marker in spec["markers"] for name in marker["columns"]] + spec["commands"].get("columns", [])
    columns += [spec[key]["column"] for key in ("time", "block") if "column" in spec.get(key, {})]
    unit = 100.0 if spec["markers"][0]["unit"] == "mm" else 0.1
    rows = [",".join(columns)]
    for k in range(8):
        rows.append(
            ",".join(
                str(k) if name in ("timestamp", "ID", "pattern_label") else f"{unit * (1 + k) / 9:.3f}"
                for name in columns
            )
        )
    files = [one["file"] for one in spec["data"]] if isinstance(spec["data"], list) else [spec["data"]]
    for file in files:
        (tmp_path / file).write_text("\n".join(rows) + "\n")
    (tmp_path / path.name).write_text(path.read_text())
    found = load_recording(tmp_path / path.name)
    assert len(found) == 8 * len(files)
    assert len(found.rig.actuation.channels) in (0, 9, 12)
    assert all(0 < marker.xi <= 1 for marker in found.rig.markers)


def test_there_are_examples():
    assert len(EXAMPLES) == 4


def test_the_right_recording_of_an_arm_is_accepted(made):
    check_against(made, ARM)
