"""The descriptions of real arms and their recordings: files with the columns of the data load, and mean what they say.

The data themselves are others' and are not here: the files are written by the test.
"""

import importlib.util
from pathlib import Path

import numpy as np
import pytest

from contarm_sim.identify.prediction.base import AtRest
from contarm_sim.model.arm_file import load_arm

ROOT = Path(__file__).parents[1]
ARMS = ROOT / "examples" / "arms"
SERVOS = {"v4": (4, 3, 9, 5, 2, 8, 6, 1, 7), "v6": (1, 20, 23, 9, 6, 11, 24, 2, 3)}


@pytest.fixture(scope="module")
def benchmark():
    spec = importlib.util.spec_from_file_location("identification", ROOT / "benchmarks" / "identification.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def tendon_file(folder, build, pulls):
    """Write a file as the data are: one row for each pull [mm] of nine tendons."""
    names = ["timestamp", "pattern_label", *(f"servo_{one}_mm" for one in SERVOS[build]), "tip_x", "tip_y", "tip_z"]
    rows = [[10 + k, label, *row, 0.5 * k, 2, 190] for k, (label, row) in enumerate(pulls)]
    file = folder / f"tendon_{build}.csv"
    file.write_text("\n".join(",".join(map(str, row)) for row in [names, *rows]))
    return file


@pytest.mark.parametrize("build", SERVOS)
def test_pulling_a_tendon_bends_the_arm_towards_it(benchmark, tmp_path, build):
    arm = load_arm(ARMS / f"tendon_{build}.toml")
    pulls = [(f"rep1_tendon{k}_pull", 3.0 * np.eye(9)[k]) for k in range(9)]
    recording = benchmark.loaded(f"tendon_{build}", arm, [tendon_file(tmp_path, build, pulls)])
    np.testing.assert_allclose(recording.positions[4, 0], [2e-3, 2e-3, 0.19])
    np.testing.assert_allclose(recording.commands, 3e-3 * np.eye(9))
    tips = AtRest(recording)([arm], [recording.rig])[0][:, 0]
    angles = np.concatenate([group.routing.angles for group in arm.groups])
    towards = np.cos(np.arctan2(tips[:, 1], tips[:, 0]) - angles)
    assert (towards > 0.9).all()
    assert (np.hypot(tips[:, 0], tips[:, 1]) > 0.005).all()


def test_holds_are_of_the_pattern_before_them(benchmark, tmp_path):
    arm = load_arm(ARMS / "tendon_v4.toml")
    pulls = [("rep1_seg1_dir0", np.ones(9)), ("rep1_seg1_dir0_hold", np.zeros(9)), ("rep2_seg1_dir60", np.ones(9))]
    recording = benchmark.loaded("tendon_v4", arm, [tendon_file(tmp_path, "v4", pulls)])
    assert recording.blocks.tolist() == ["rep1_seg1_dir0", "rep1_seg1_dir0", "rep2_seg1_dir60"]
    assert benchmark.held(recording, ("*dir60",)).tolist() == [False, False, True]


def test_motors_of_the_trunk_bend_it_where_its_tendons_are(benchmark, tmp_path):
    arm = load_arm(ARMS / "trunk.toml")
    names = ["ID", *(f"{axis}{k}" for k in (1, 2, 3) for axis in "xyz"), *(f"phi{k}" for k in range(1, 7))]
    straight = [0.1, -0.105, 0.1, 0.1, -0.2, 0.1, 0.1, -0.32, 0.1]
    rows = [[k, *straight, *(30 * np.eye(7)[k])[:6]] for k in range(7)]
    file = tmp_path / "trunk.csv"
    file.write_text("\n".join(",".join(map(str, row)) for row in [names, *rows]))
    recording = benchmark.loaded("trunk", arm, [file])
    assert recording.commands.shape == (7, 6)
    assert recording.commands[0, 0] == pytest.approx(np.radians(30))
    tips = AtRest(recording)([arm], [recording.rig])[0][:, 2]
    assert (tips[:, 1] < -0.28).all()  # y is up
    moved = (tips[:6] - tips[6])[:, [0, 2]]
    angles = np.radians([-47, -109, 204, 162, 92, 42])  # of the bend for each motor, from +x towards +z
    assert (np.cos(np.arctan2(moved[:, 1], moved[:, 0]) - angles) > 0.9).all()


def test_errors_are_less_their_mean_offset(benchmark, tmp_path):
    arm = load_arm(ARMS / "tendon_v4.toml")
    recording = benchmark.loaded(
        "tendon_v4", arm, [tendon_file(tmp_path, "v4", [("a", np.ones(9)), ("b", np.zeros(9))])]
    )
    shifted = recording.positions - [0.01, 0, 0] + 0.003 * np.array([[[0, 0, 1]], [[0, 0, -1]]])
    assert benchmark.off(recording, shifted, np.ones(2, dtype=bool)) == pytest.approx(3.0)
