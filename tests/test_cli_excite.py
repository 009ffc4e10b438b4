"""`contarm excite`: commands in the words of the recording, what they would tell, and a figure of it."""

import csv
import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from text_boxes import faults

from contarm_sim.identify.excite import excite
from contarm_sim.identify.recordings.file import load_recording
from contarm_sim.identify.recordings.rig import Actuation, Marker, Rig
from contarm_sim.identify.recordings.rig_file import save_rig
from contarm_sim.identify.recordings.synthetic import random_windings, recorded
from contarm_sim.identify.replays.written import written_of
from contarm_sim.model.arm_file import arm_to_toml, load_arm
from contarm_sim.model.named import with_parameters
from contarm_sim.model.presets import preset
from contarm_sim.view.report.excited import draw_gain
from contarm_sim.view.style import drawn

FREE = ("section_1.bending_stiffness", "section_2.bending_stiffness", "frame.x")

NAMES = [f"servo_{k}" for k in (4, 3, 9, 5, 2, 8, 6, 1, 7)]


@pytest.fixture(scope="module")
def files(tmp_path_factory):
    """Return an arm, its rig, and a recording whose commands are in mm, less than 0 where a tendon is pulled."""
    folder = tmp_path_factory.mktemp("excite")
    arm = with_parameters(preset("tendon"), {f"section_{k}.links": 2 for k in (1, 2, 3)})
    rig = Rig(markers=(Marker(name="tip"),), actuation=Actuation(channels=tuple(range(9))))
    windings, _ = random_windings(arm, 24, 1)
    tip = recorded(arm, rig, windings, seed=1).positions[:, 0]
    with (folder / "poses.csv").open("w") as file:
        rows = csv.writer(file)
        rows.writerow(["t", *NAMES, "x", "y", "z"])
        rows.writerows(np.column_stack([np.arange(24), -1e3 * windings, 1e3 * tip]).tolist())
    (folder / "day.toml").write_text(f"""kind = "static"
data = "poses.csv"
time = {{column = "t", unit = "s"}}
[commands]
drive = "windings"
columns = {json.dumps(NAMES)}
unit = "mm"
pull = "negative"
[[markers]]
name = "tip"
columns = ["x", "y", "z"]
unit = "mm"
xi = 1.0
""")
    (folder / "arm.toml").write_text(arm_to_toml(arm))
    save_rig(rig, folder / "rig.toml")
    return folder


def test_commands_are_written_as_the_recording_has_them(contarm, files):
    arm, day = load_arm(files / "arm.toml"), load_recording(files / "day.toml")
    free = [word for name in FREE for word in ("--free", name)]
    code, out, err = contarm("excite", files / "arm.toml", files / "day.toml", *free, "--candidates", 6, "--count", 2,
                             "--out", "it", "--json")  # fmt: skip
    assert code == 0, err
    found = excite(arm, day.rig, FREE, candidates=6, count=2, recording=day)
    told, rows = json.loads(out), list(csv.DictReader(Path("it/commands.csv").read_text().splitlines()))
    assert told["sd_after"] == pytest.approx(found.sd_after.tolist(), rel=1e-6)
    assert told["chosen"] == [found.patterns[k] for k in found.chosen]
    assert list(rows[0]) == ["block", *NAMES]
    given = np.array([[float(row[name]) for name in NAMES] for row in rows])
    np.testing.assert_allclose(given, -1e3 * found.commands, atol=1e-6)
    assert Path("it/gain.png").is_file()
    back, blocks = written_of(day.rig, files / "day.toml").read("it/commands.csv")
    np.testing.assert_allclose(back, found.commands, atol=1e-9)
    assert blocks == found.blocks.tolist()


def test_candidates_of_a_file_and_limits_are_in_the_units_of_the_recording(contarm, files):
    table = Path("possible.csv")
    table.write_text(
        "\n".join([",".join(NAMES), *(",".join(["0"] * k + [f"{-4 - k}"] + ["0"] * (8 - k)) for k in range(9))])
    )
    words = ("excite", files / "arm.toml", files / "day.toml", "--free", *FREE, "--candidates", table, "--count", 3)
    code, out, err = contarm(*words, "--limits", -10, 1, "--figures", "none", "--out", "it")
    assert code == 0, err
    assert "refused" in out
    assert "smaller by" in out
    rows = list(csv.DictReader(Path("it/commands.csv").read_text().splitlines()))
    assert len(rows) == 3
    assert min(float(row[name]) for row in rows for name in NAMES) >= -10
    code, _, err = contarm(*words, "--limits", -4.5, 1, "--figures", "none")
    assert code == 2
    assert "1 of 9" in err


def test_a_rig_has_si_units_and_bad_input_is_said_in_one_line(contarm, files):
    code, out, _ = contarm("excite", files / "arm.toml", files / "rig.toml", "--free", "frame.x", "--candidates", 2,
                           "--count", 1, "--figures", "none")  # fmt: skip
    assert code == 0
    assert "commands, m" in out
    assert "Without any recording" in out
    for more, said in (
        ((files / "rig.toml",), "--free"),
        (("--free", "frame.x"), "RIG.toml"),
        ((files / "rig.toml", "--free", "frame.q"), "frame.q"),
        ((files / "rig.toml", "--free", "frame.x", "damping_time"), "at rest does not show its damping"),
        ((files / "rig.toml", "--free", "frame.x", "--limits", 1, -1), "the lowest first"),
        ((files / "rig.toml", "--free", "frame.x", "--candidates", 2, "--count", 3), "--count"),
        ((files / "rig.toml", "--free", "frame.x", "--candidates", "missing.csv"), "missing.csv"),
    ):
        code, out, err = contarm("excite", files / "arm.toml", *more)
        assert (code, out, err.count("\n")) == (2, "", 1)
        assert said in err


@pytest.mark.parametrize("width", ["page", "column"])
def test_the_figure_is_clean_and_leaves_out_what_is_not_determined(files, width):
    arm, day = load_arm(files / "arm.toml"), load_recording(files / "day.toml")
    found = excite(arm, day.rig, [*FREE, "damping_time"], candidates=6, count=3)
    assert np.isinf(found.steps[:, 3]).all()
    assert (np.diff(found.steps[:, :3], axis=0) <= 1e-12).all()
    sheet = drawn(lambda made: draw_gain(made, replace(found)), width)
    assert not faults(sheet)
    steps = 1 + 0.02 * np.arange(len(found.steps))[::-1, None] * np.ones(len(found.names))
    small = drawn(lambda made: draw_gain(made, replace(found, steps=steps)), width)
    low, high = small.axes[0].get_ylim()
    assert sum(low <= place <= high for place in small.axes[0].get_yticks()) >= 3
    assert [text.get_text() for text in sheet.legends[0].get_texts()] != []
    assert "damping_time" not in {text.get_text() for text in sheet.legends[0].get_texts()}
