"""A run folder that is damaged: one clear line that names the file, and exit code 2."""

import json
import re
import sys
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import pytest
from references import along

from contarm_sim.cli.main import main
from contarm_sim.errors import InputError
from contarm_sim.mjcf.xml import write_models
from contarm_sim.model.arm import Arm
from contarm_sim.model.arm_file import arm_to_dict, arm_to_toml, load_arm
from contarm_sim.model.objects import Object
from contarm_sim.motion.simulate import FAST, simulate
from contarm_sim.results.arrays import require_arms_own
from contarm_sim.results.run_folder import load
from contarm_sim.results.trajectory import ARRAYS, Trajectory
from contarm_sim.view.report.run import RunReport


@pytest.fixture(scope="module")
def samples():
    arm = Arm(links=4)
    return simulate(arm, along(arm, "circle", 0.2, max_bend=0.3))


def _arrays(samples):
    """Return the arrays of a file that `save` writes, `about` among them."""
    with TemporaryDirectory() as folder:
        samples.save(Path(folder) / "t.npz")
        with np.load(Path(folder) / "t.npz") as stored:
            return dict(stored)


@pytest.fixture
def render(samples, monkeypatch, capsys, tmp_path):
    """Run `contarm render r` on the samples, once `damage` has had the path of trajectory.npz and the arrays."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "r").mkdir()
    (tmp_path / "r/arm.toml").write_text(arm_to_toml(Arm(links=4)))

    def call(damage):
        damage(tmp_path / "r/trajectory.npz", _arrays(samples))
        monkeypatch.setattr(sys, "argv", ["contarm", "render", "r", "--out", "r.png"])
        with pytest.raises(SystemExit) as ended:
            main()
        assert not (tmp_path / "r.png").exists()
        return ended.value.code, capsys.readouterr().err

    return call


def _empty(path, arrays):
    path.write_bytes(b"")


def _words(path, arrays):
    path.write_bytes(b"not a zip file")


def _pickle(path, arrays):
    np.savez(path, **arrays | {"bend": np.array([{}], dtype=object)})


def _one_array(path, arrays):
    with path.open("wb") as file:
        np.save(file, arrays["bend"])


def _cut(path, arrays):
    np.savez_compressed(path, **arrays)
    path.write_bytes(path.read_bytes()[:-300])


def _scratched(path, arrays):
    """The first array's stream is damaged behind its header; the directory at the end is whole."""
    np.savez_compressed(path, **arrays)
    content = bytearray(path.read_bytes())
    content[60:120] = b"\xff" * 60
    path.write_bytes(content)


def _missing(path, arrays):
    del arrays["qpos"]
    np.savez(path, **arrays)


@pytest.mark.parametrize("damage", [_empty, _words, _one_array, _cut, _scratched, _missing])
def test_a_file_that_is_no_recording_is_one_line(render, damage):
    code, err = render(damage)
    assert code == 2, err
    assert re.fullmatch(r"contarm: r/trajectory\.npz: file is .*; allowed: a trajectory\.npz of contarm run\n", err)


def test_objects_are_not_unpickled(render):
    said = "bend is an array of object; allowed: an array of real numbers"
    assert render(_pickle) == (2, f"contarm: r/trajectory.npz: {said}\n")


@pytest.mark.parametrize(
    ("name", "value", "said"),
    [
        ("stations", np.nan, "stations is nan in sample 3; allowed: finite numbers"),
        ("qpos", np.inf, "qpos is inf in sample 3; allowed: finite numbers"),
        ("time", -np.inf, "time is -inf in sample 3; allowed: finite numbers"),
        ("pressure", np.nan, "pressure is nan in sample 3; allowed: finite numbers, or inf"),
        ("target", None, "target is an array of <U5; allowed: an array of real numbers"),
    ],
)
def test_numbers_that_are_not_finite_are_refused_by_name(render, name, value, said):
    def damage(path, arrays):
        if value is None:
            arrays[name] = np.full(len(arrays["time"]), "words")
        else:
            arrays[name][3] = value
        np.savez(path, **arrays)

    assert render(damage) == (2, f"contarm: r/trajectory.npz: {said}\n")


def test_pressures_that_no_muscle_could_have_are_kept(samples, tmp_path):
    arrays = _arrays(samples)
    arrays["pressure"][3] = np.inf
    np.savez(tmp_path / "t.npz", **arrays)
    assert Trajectory.load(tmp_path / "t.npz").pressure[3, 0] == np.inf


def test_a_scalar_that_is_not_finite_is_refused(samples, tmp_path):
    np.savez(tmp_path / "t.npz", **_arrays(samples) | {"time": np.array(np.nan)})
    with pytest.raises(InputError, match=r"time is of shape \(\); allowed: an array of shape \(T,\)"):
        Trajectory.load(tmp_path / "t.npz")


SHAPED = [("time", (3,)), ("time", (0,)), ("target", (7, 3)), ("target", (7, 2)), ("stations", (7, 5)), ("qpos", (7,)),
          ("stations", (7, 4, 3)), ("qpos", (7, 7)), ("tip_rotation", (7, 3, 2)), ("pressure", (7, 3, 1))]  # fmt: skip


@pytest.mark.parametrize(("name", "shape"), SHAPED)
def test_arrays_of_other_shapes_are_refused_by_name(render, name, shape):
    code, err = render(lambda path, arrays: np.savez(path, **arrays | {name: np.zeros(shape)}))
    assert code == 2, err
    assert re.match(r"contarm: r/trajectory\.npz: \w+ is ", err)
    assert name in err


def _of(arm, arrays):
    about = json.loads(str(arrays["about"])) | {"arm": arm_to_dict(arm)}
    return arrays | {"about": np.array(json.dumps(about))}


@pytest.mark.parametrize(
    ("arm", "said"),
    [(Arm(links=5), "stations is of 4 links"), (Arm(links=4, length=0.371), "links of 0.09275 m"),
     (Arm(links=4, torsional_stiffness=0.1), "qpos is of 8 joint angles; allowed: those of 12")],
)  # fmt: skip
def test_samples_of_another_arm_are_refused(render, tmp_path, arm, said):
    (tmp_path / "r/arm.toml").write_text(arm_to_toml(arm))
    code, err = render(lambda path, arrays: np.savez(path, **_of(arm, arrays)))
    assert (code, said in err, err.count("\n")) == (2, True, 1), err
    assert "r/trajectory.npz" in err
    code, err = render(lambda path, arrays: np.savez(path, **arrays))
    assert code == 2
    assert "r: arm.toml is another arm than that of trajectory.npz" in err


def test_a_run_with_a_mesh_opens_with_the_copy_that_lies_in_its_folder(tmp_path):
    """Also where it was of an arm that `contarm build` wrote, and where it has been moved."""
    (tmp_path / "wedge.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n")
    mesh = Object(name="set", shape="mesh", file=str(tmp_path / "wedge.obj"), scale=0.05, position=(0.3, 0, 0.1))
    arm = Arm(links=4, objects=(mesh,))
    for place in ("built", "first", "second"):
        (tmp_path / place).mkdir()
    write_models(arm, tmp_path / "built")
    (tmp_path / "built/arm.toml").write_text(arm_to_toml(arm, beside=True))
    for folder, own in (("first", arm), ("second", load_arm(tmp_path / "built/arm.toml"))):
        run = simulate(own, along(own, "circle", 0.1, max_bend=0.3), stepping=FAST)
        RunReport(run, poses=2).write(tmp_path / folder)
        assert np.array_equal(load(tmp_path / folder).stations, run.stations)
    (tmp_path / "wedge.obj").unlink()
    (tmp_path / "built").rename(tmp_path / "gone")
    for folder in ("first", "second"):
        moved = (tmp_path / folder).rename(tmp_path / f"{folder}-moved")
        assert load(moved).arm.world.objects[0].file == str(moved / "set.obj")
    toml = moved / "arm.toml"
    toml.write_text(toml.read_text().replace("scale = 0.05", "scale = 0.04"))
    with pytest.raises(InputError, match=r"arm\.toml is another arm"):
        load(moved)


@pytest.mark.parametrize("about", ["", "{", "[]", '{"arm": {}}', '{"arm": {"length": -1}, "status": "finished"}', "0",
                                   '{"arm": {}, "status": "ended", "controller": "servo"}'])  # fmt: skip
def test_a_recording_that_does_not_say_what_it_is_of_is_refused(render, about):
    code, err = render(lambda path, arrays: np.savez(path, **arrays | {"about": np.array(about)}))
    assert (code, err.count("\n")) == (2, 1), err


def test_a_damaged_recording_is_refused_or_reads_the_same(samples, tmp_path):
    """Bits are flipped and ends cut off all over the file: nothing else than an InputError comes of it."""
    file = tmp_path / "t.npz"
    samples.save(file)
    whole, random, refused = file.read_bytes(), np.random.default_rng(0), 0
    for _ in range(300):
        content = bytearray(whole)
        if random.random() < 0.2:
            content = content[: random.integers(len(content))]
        else:
            content[random.integers(len(content))] ^= 1 << int(random.integers(8))
        file.write_bytes(content)
        try:
            again = Trajectory.load(file)
        except InputError:
            refused += 1
        else:
            assert again == samples
    assert refused > 200


def test_recordings_fit_their_arms():
    for arm in (Arm(links=9, torsional_stiffness=0.05, gravity=(5, 5, 0)), Arm(links=8)):
        for extrapolate in (False, True):
            found = simulate(arm, along(arm, "circle", 0.2, max_bend=2), extrapolate=extrapolate)
            require_arms_own(arm, {name: getattr(found, name) for name in ARRAYS}, "here")
