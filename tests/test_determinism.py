"""Everything but times is the same bits, whatever the process and however many threads its libraries use."""

import json
import os
import re
import subprocess
import sys

import numpy as np
import pytest
from waiting import PATIENCE

from contarm_sim import sweeps

RUN = ["run", "--duration", "1", "--turns", "0.3", "--gravity", "0", "0", "9.81", "--no-video", "--json"]
TIMED = {"real_time_factor", "speed_up", "wall_time_s"}
"""What a summary says of time that passed while it was computed."""

ENVIRONMENTS = [
    {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1", "PYTHONHASHSEED": "0"},
    {"OMP_NUM_THREADS": "4", "OPENBLAS_NUM_THREADS": "4", "PYTHONHASHSEED": "1"},
]


def _untimed(found):
    """Return a summary without what is timed."""
    if isinstance(found, dict):
        return {key: _untimed(value) for key, value in found.items() if key not in TIMED}
    return [_untimed(each) for each in found] if isinstance(found, list) else found


def _bits(array):
    """Return an array's bits, or what it holds as JSON, untimed."""
    return _untimed(json.loads(str(array))) if array.dtype.kind == "U" else (array.dtype, array.shape, array.tobytes())


def _content(path):
    """Return what a file holds but for times: archives by their members, JSON by its values."""
    data = path.read_bytes()
    if path.suffix == ".npz":
        with np.load(path) as archive:
            return {name: _bits(archive[name]) for name in archive.files}
    if path.suffix == ".json":
        return _untimed(json.loads(data))
    if path.suffix == ".html":
        return re.sub(rb"[0-9.]+ (?:times|x) real time", b"", data)
    return data


def _differing(one, two):
    """Return the names of the files that differ between two folders, at any depth; absent ones too."""
    names = [{str(path.relative_to(root)) for path in root.rglob("*") if path.is_file()} for root in (one, two)]
    shared = names[0] & names[1]
    assert shared
    changed = {name for name in shared if _content(one / name) != _content(two / name)}
    return sorted(changed | (names[0] ^ names[1]))


def _folders(tmp_path, words, environments=ENVIRONMENTS):
    """Run a command in two processes of different threads; return the two folders that they leave."""
    folders = []
    for number, environment in enumerate(environments):
        place = tmp_path / str(number)
        place.mkdir()
        done = subprocess.run(
            [sys.executable, "-m", "contarm_sim", *words, "--out", "out"],
            cwd=place,
            env=os.environ | environment,
            capture_output=True,
            text=True,
            timeout=PATIENCE,
        )
        assert done.returncode == 0, done.stdout + done.stderr
        folders.append(place / "out")
    return folders


SWEEP = """
run = "equilibrium"
[fixed]
gravity.z = 9.81
[vary]
bending_stiffness = [0.05, 0.1]
load.force.x = [0.1, 0.2, 0.3]
"""


def test_a_sweep_leaves_the_same_bits_in_another_process_with_other_threads(tmp_path):
    (tmp_path / "s.toml").write_text(SWEEP)
    here = sweeps.sweep(tmp_path / "s.toml", tmp_path / "here", processes=1).folder
    words = ["sweep", str(tmp_path / "s.toml"), "--processes", "1"]
    (there,) = _folders(tmp_path, words, ENVIRONMENTS[1:])
    assert _differing(here, there) == []


@pytest.mark.parametrize(
    "words",
    [RUN, ["figures", "lengths", "fan", "--links", "8"], ["release", "--duration", "0.3", "--links", "12"]],
    ids=lambda words: words[0],
)
def test_a_command_leaves_the_same_bits_in_another_process_with_other_threads(tmp_path, words):
    assert _differing(*_folders(tmp_path, words)) == []


def test_a_changed_bit_is_seen(tmp_path):
    """The comparison itself: one number, one file, one pixel's worth of difference are named."""
    for name in ("a", "b"):
        (tmp_path / name / "deeper").mkdir(parents=True)
        (tmp_path / name / "summary.json").write_text(json.dumps({"tip": 1.0, "real_time_factor": len(name)}))
        (tmp_path / name / "deeper" / "x.bin").write_bytes(b"same")
    assert _differing(tmp_path / "a", tmp_path / "b") == []
    (tmp_path / "b" / "summary.json").write_text(json.dumps({"tip": 1.0 + 2**-52, "real_time_factor": 9}))
    (tmp_path / "b" / "deeper" / "x.bin").write_bytes(b"samf")
    (tmp_path / "b" / "more").touch()
    assert _differing(tmp_path / "a", tmp_path / "b") == ["deeper/x.bin", "more", "summary.json"]
