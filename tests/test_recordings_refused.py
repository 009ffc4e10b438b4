"""Recordings that cannot be: each is refused in one line that says what, where, and what would do."""

import re
import tomllib
from dataclasses import replace

import numpy as np
import pytest
from bad_inputs import WRONG, refused, short

from contarm_sim import Actuation, InputError, Marker, Rig, load_recording, presets
from contarm_sim.identify.recordings.checks import check_against
from contarm_sim.identify.recordings.file import recording_from_frame
from contarm_sim.identify.recordings.recording import Recording
from contarm_sim.identify.recordings.rig_file import load_rig, save_rig
from contarm_sim.identify.recordings.synthetic import random_windings, recorded

ARM = presets.tendon()
TOML = """
kind = "static"
data = "poses.csv"
[time]
column = "t"
[commands]
drive = "windings"
columns = ["a", "b"]
[[markers]]
columns = ["x", "y", "z"]
"""
HEAD = "t,a,b,x,y,z\n"
ROWS = HEAD + "".join(f"{k},0.00{k % 5},0.001,0.1,0.0{k},0.3\n" for k in range(6))
MOTION = TOML.replace("static", "motion")
NAMED = ", ".join(HEAD.strip().split(","))

FILES = [
    # what is wrong, the TOML, the data, what the line says
    ("empty", TOML, "", "file is empty"),
    ("no rows", TOML, HEAD, "data is empty; allowed: one row or more"),
    ("no names", TOML, ROWS.partition("\n")[2], "header is numbers.*names = "),
    ("ragged", TOML, ROWS + "6,0,0,0,0\n", "row 8 is one of 5 cells; allowed: 6, as there are names"),
    ("decimal commas", TOML, ROWS + "6,0,0,1,0,2,0,0,3\n", "one of 9 cells.*decimal commas"),
    ("spaces", TOML, ROWS.replace(",", " "), "'t', which is no column.*put commas"),
    ("twice", TOML, ROWS.replace("t,a,b", "t,a,a"), "two columns named 'a'|did you mean"),
    ("Latin-1", TOML, ROWS.encode() + b"\xe9", "no text in UTF-8 .byte 0xe9 in row 8"),
    ("UTF-16", TOML, ROWS.encode("utf-16"), "UTF-16"),
    ("null", TOML, ROWS + "\0", "null characters"),
    ("text", TOML, ROWS.replace("0.04,0.3", "far,0.3"), "row 6, column y is 'far'; allowed: a number"),
    ("infinite", TOML, ROWS.replace("0.04,0.3", "inf,0.3"), "row 6, column y is inf; allowed: a finite number"),
    ("column", TOML.replace('"y"', '"yy"'), ROWS, f"'yy', which is no column.*mean 'y'. the columns are {NAMED}"),
    ("one for two", TOML.replace('"y"', '"x"'), ROWS, "marker tip.columns is .*; allowed: each column once"),
    ("two of three", TOML.replace('"x", ', ""), ROWS, "marker tip.columns is 2 columns; allowed: 3"),
    ("unseen", TOML, re.sub(r"0\.1,0\.0\d", ",", ROWS), "marker tip is seen in 0 of 6|marker tip is never seen"),
    ("nearly unseen", TOML, re.sub(r"(\n[2-5].*)0\.1,0\.0\d", r"\1,", ROWS), "seen in 2 of 6 samples; allowed: 3"),
    ("constant", TOML, re.sub(r"0\.00\d,0\.001", "0,0", ROWS), "commands is the same in all samples"),
    ("commands missing", TOML, re.sub(r"0\.00\d,0\.001", "0,", ROWS), "commands is missing in all rows"),
    ("time backwards", TOML, ROWS + "4.5,0,0,0,0,0\n", "row 8, time is 4.5 s; allowed: at least 5 s"),
    ("time twice", MOTION, ROWS + "5,0,0,0,0,0\n", "row 8, time is 5 s; allowed: above 5 s"),
    ("time missing", TOML, ROWS + ",0,0,0,0,0\n", "row 8, column t is missing; allowed: a time"),
    ("no time", MOTION.replace('[time]\ncolumn = "t"', ""), ROWS, "time is missing"),
    ("key", TOML + 'unti = "mm"\n', ROWS, "key 'marker 1.unti' is unknown.*mean 'marker 1.unit'"),
    ("key above", "evry = 2\n" + TOML, ROWS, "key 'evry' is unknown; allowed: did you mean 'every'"),
    ("unit", TOML + 'unit = "kg"\n', ROWS, "marker tip.unit is 'kg'; allowed: a unit such as m, mm, cm"),
    ("kind", TOML.replace("static", "statik"), ROWS, "kind is 'statik'; allowed: static, motion"),
    ("no data", TOML.replace('data = "poses.csv"', ""), ROWS, "data is missing; allowed: a file"),
    ("data elsewhere", TOML.replace("poses", "other"), ROWS, "other.csv: file is unreadable .No such file"),
    ("drive", TOML.replace("windings", "winding"), ROWS, "commands.drive is 'winding'; allowed: windings, tensions"),
    ("angles", TOML.replace("windings", 'windings"\nunit = "deg'), ROWS, "commands.pulley_radius is missing"),
    ("channel", TOML.replace("windings", 'windings"\nchannels = ["c"]#'), ROWS, "channels is 'c'.*one of a, b"),
    ("channels", TOML.replace("windings", 'windings"\nchannels = [0]#'), ROWS, "channels is 0; allowed: numbers from"),
    ("orientations", TOML + 'quaternion = ["w", "x", "y", "z"]\n', ROWS, "marker 1.quaternion is not read yet"),
    ("station", TOML + "station = 3\n", ROWS, "marker.*station is 3; allowed: .*load_recording.path, arm"),
    ("two places", TOML + 'xi = 1\nat = "tip"\n', ROWS, "said by xi and at"),
    ("frame", TOML + '[frame]\nz = "y"\nx = "-y"\n', ROWS, "frame.x is -y; allowed: a direction that is not"),
    ("axis", TOML + '[frame]\nz = "down"\n', ROWS, 'frame.z is down; allowed: an axis of the measuring frame'),
    ("kept", "keep = {time = [100, 200]}\n" + TOML, ROWS, "keep is nothing"),
    ("payload", 'payload = "2 mm"\n' + TOML, ROWS, "payload is '2 mm'"),
    ("not TOML", "kind = static", ROWS, "file is not TOML"),
    ("gzip", TOML.replace(".csv", ".csv.gz"), ROWS, "no whole gzip file"),
    ("npz", TOML.replace(".csv", ".npz"), ROWS, "no .npz file of plain arrays"),
]  # fmt: skip


@pytest.mark.parametrize(("toml", "rows", "said"), [case[1:] for case in FILES], ids=[case[0] for case in FILES])
def test_files_are_refused_in_one_line(tmp_path, toml, rows, said):
    for name in ("poses.csv", "poses.csv.gz", "poses.npz"):
        (tmp_path / name).write_bytes(rows if isinstance(rows, bytes) else rows.encode())
    (tmp_path / "r.toml").write_text(toml)
    with pytest.raises(InputError) as caught:
        load_recording(tmp_path / "r.toml")
    line = str(caught.value)
    assert re.search(said, line), line
    assert line.isprintable()
    assert re.match(rf"{tmp_path}/\w+\.(toml|csv|npz)|.*r\.toml", line) or ".." in line, line


def test_the_files_that_are_refused_are_right_but_for_that(tmp_path):
    (tmp_path / "poses.csv").write_text(ROWS)
    for toml in (TOML, MOTION):
        (tmp_path / "r.toml").write_text(toml)
        assert len(load_recording(tmp_path / "r.toml")) == 6


@pytest.fixture(scope="module")
def made():
    commands, blocks = random_windings(ARM, 48, seed=1)
    return recorded(ARM, Rig(actuation=Actuation(channels=tuple(range(9)))), commands, seed=2, blocks=blocks)


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"positions": 1e3}, '500 m from the base of an arm of 0.51 m; .*they seem to be millimetres: unit = "mm"'),
        ({"positions": 1e2}, 'seem to be centimetres: unit = "cm"'),
        ({"positions": 1e-3}, 'they seem to be metres, not mm: unit = "m"'),
        ({"positions": 7.0}, "are units and frame right"),
        ({"commands": 1e3}, 'windings up to .* seem to be millimetres: unit = "mm"'),
        ({"commands": 1e-3}, 'metres, not mm: unit = "m"'),
        ({"drive": "pressures", "commands": 1e4}, 'they seem to be kPa or bar: unit = "kPa"'),
        ({"drive": "pressures", "commands": 1e12}, "pressures up to"),
        ({"drive": "tensions", "commands": 1e8}, 'mN. unit = "mN"'),
        ({"drive": "tensions", "commands": 1.0}, "pulls above 0, not windings in m"),
        ({"channels": (0, 1, 2)}, "of 3 muscles; allowed: channels of 9, as the arm has muscles"),
        ({"gains": (57.3,) * 9}, 'degrees. unit = "deg"'),
    ],
)  # fmt: skip
def test_recordings_of_another_size_than_the_arm_are_refused_with_the_unit_that_explains_it(made, change, said):
    rig, numbers = made.rig, {name: getattr(made, name) * x for name, x in change.items() if isinstance(x, float)}
    said_of = {name: x for name, x in change.items() if not isinstance(x, float)}
    actuation = Actuation(**{"channels": rig.actuation.channels, **said_of})
    with pytest.raises(InputError, match=said):
        check_against(replace(made, rig=replace(rig, actuation=actuation), **numbers), ARM)


@pytest.mark.parametrize("factor", [0.3, 1.0, 2.0])
def test_arms_that_are_somewhat_larger_or_elsewhere_are_not_refused(made, factor):
    check_against(replace(made, positions=factor * made.positions, commands=factor * made.commands), ARM)
    check_against(replace(made, positions=made.positions + 4.0), ARM)  # the frame is yet to be fitted


CHANGES = {
    "time": (
        lambda r: r.time[::-1],
        "sample 2, time is 46 s; allowed: at least 47 s, as of the sample before in block",
    ),
    "time twice": (lambda r: np.zeros(len(r)), None),
    "commands": (lambda r: np.where(np.arange(9) == 3, np.nan, r.commands), "sample 1, commands"),
    "positions": (lambda r: np.full_like(r.positions, np.nan), "marker tip is never seen"),
    "positions far": (lambda r: r.positions + np.inf, "sample 1, positions is inf"),
    "payload": (lambda r: np.where(np.arange(len(r)) == 7, -1.0, 0.1), "sample 8, payload is -1"),
    "commands few": (lambda r: r.commands[:, :8], "commands is 8 channels; allowed: 9, as actuation.channels has them"),
    "blocks": (lambda r: r.blocks[:5], "blocks is of shape .5,."),
}


@pytest.mark.parametrize("name", CHANGES)
def test_recordings_made_in_python_are_refused_too(made, name):
    change, said = CHANGES[name]
    values = {name.split()[0]: change(made)}
    if said is None:  # at rest time may stand still, in a motion it may not
        assert len(replace(made, **values)) == len(made)
        values["kind"], said = "motion", "sample 2, time is 0 s; allowed: above 0 s"
    with pytest.raises(InputError, match=said):
        replace(made, **values)


def test_a_recording_has_samples_and_blocks_of_motions_stand_together(made):
    with pytest.raises(InputError, match="time is no samples"):
        Recording(
            kind="static", time=[], positions=np.zeros((0, 1, 3)), commands=np.zeros((0, 9)), rig=made.rig, blocks=[]
        )
    mixed = np.array(["a", "b"] * 24)
    with pytest.raises(InputError, match="samples of one block together; block 'a' begins again"):
        replace(made, kind="motion", blocks=mixed)
    assert len(replace(made, blocks=mixed)) == 48


def test_numbers_that_say_missing_are_not_positions(made):
    positions = made.positions.copy()
    positions[3:5] = -9.999
    with pytest.raises(InputError, match=r"2 times at -9\.999 m in x, y and z; .*gaps\.values = \[-9999\]"):
        check_against(replace(made, positions=positions), ARM)


def test_synthetic_recordings_refuse_what_makes_no_sense(made):
    with pytest.raises(InputError, match=r"gaps is 2; allowed: a part from 0 to 0\.9"):
        recorded(ARM, made.rig, made.commands, seed=1, gaps=2)
    free = replace(made.rig, actuation=Actuation(drive="none"))
    with pytest.raises(InputError, match="predictor is missing; allowed: one of free swings"):
        recorded(ARM, free, made.commands[:, :0], seed=1, kind="motion")
    with pytest.raises(InputError, match="count is 0"):
        random_windings(ARM, 0, seed=1)


RIG = 'frame = {position = [0, 0, 0]}\nactuation = {channels = [1, 2], slack = "1 mm"}\nmarkers = [{name = "tip"}]\n'


@pytest.mark.parametrize(
    ("toml", "said"),
    [
        (RIG.replace("slack", "slak"), "key 'actuation.slak' is unknown; allowed: did you mean 'actuation.slack'"),
        (RIG.replace("[1, 2]", "[0, 2]"), "actuation.channels is .0, 2.; allowed: whole numbers from 1"),
        (RIG.replace("1 mm", "1 kg"), "actuation.slack is '1 kg'"),
        (RIG.replace("[0, 0, 0]", "[0, 0]"), "frame.position is 2 numbers; allowed: 3"),
        (RIG.replace("name", "nam"), "key 'marker 1.nam' is unknown"),
        (RIG + "rig = 1\n", "key 'rig' is unknown"),
    ],
)
def test_rigs_are_refused_in_one_line(tmp_path, toml, said):
    (tmp_path / "rig.toml").write_text(RIG)
    assert load_rig(tmp_path / "rig.toml").actuation.slack == (0.001, 0.001)
    (tmp_path / "rig.toml").write_text(toml)
    with pytest.raises(InputError, match=said) as caught:
        load_rig(tmp_path / "rig.toml")
    assert str(caught.value).startswith(str(tmp_path / "rig.toml"))
    with pytest.raises(InputError, match="not written "):
        save_rig(Rig(markers=(Marker(),)), tmp_path / "none" / "rig.toml")


def _leaves(spec, path=()):
    for key, value in spec.items() if isinstance(spec, dict) else enumerate(spec):
        yield (*path, key)
        if isinstance(value, (dict, list)):
            yield from _leaves(value, (*path, key))


def _changed(spec, path, value):
    key, *rest = path
    found = dict(spec) if isinstance(spec, dict) else list(spec)
    found[key] = _changed(spec[key], rest, value) if rest else value
    return found


def test_no_value_of_any_key_ends_in_anything_but_one_line():
    pandas = pytest.importorskip("pandas")
    spec = tomllib.loads(TOML) | {
        "every": 1, "payload": {"column": "b", "unit": "kg"}, "force": {"columns": ["x", "y", "z"], "unit": "N"},
        "gaps": {"values": [-1], "valid": "t", "frozen": 4}, "keep": {"time": [[0, 9]], "blocks": ["*"]}, "name": "n",
        "block": {"column": "t", "match": "(.*)", "restart": "t", "seconds": 2}, "drop": {"time": [[50, 60]]},
        "frame": {"z": "z", "x": "x", "position": [0, 0, 0], "turn": [0, 0, 0], "gravity": "-z"},
    }  # fmt: skip
    del spec["data"]
    spec["time"] |= {"unit": "s", "origin": 0}
    spec["commands"] |= {
        "unit": "m",
        "pull": "positive",
        "channels": [1, 2],
        "signs": [1, 1],
        "gains": [1, 1],
        "slack": 0,
    }
    spec["markers"][0] |= {"name": "tip", "unit": "m", "offset": [0, 0, 0], "valid": "t", "at": "tip"}
    frame = pandas.DataFrame([list(map(float, line.split(","))) for line in ROWS.split()[1:]], columns=list("tabxyz"))
    frame["t"] += 1
    assert len(recording_from_frame(frame, spec)) == 6
    cases = [
        (
            f"{path} = {short(value)}",
            lambda path=path, value=value: recording_from_frame(frame, _changed(spec, path, value)),
        )
        for number, path in enumerate(_leaves(spec))
        for value in WRONG[number % 3 :: 3]  # every third of each
    ]
    count, failed = refused(cases, made_by_chance=True)
    assert count > 700
    assert not failed, "\n".join(failed[:20])
