"""A result knows what it is a result of."""

import copy
import pickle
import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest
from references import along, resting

from contarm_sim.errors import InputError, MissingError
from contarm_sim.model.arm import Arm
from contarm_sim.motion.rest import poses_at_rest
from contarm_sim.motion.simulate import simulate
from contarm_sim.results.compare import compare
from contarm_sim.results.trajectory import Trajectory

ARM = Arm(links=8, gravity=(0.0, 1.0, 9.0), payload=0.02)


@pytest.fixture(scope="module")
def run():
    return simulate(ARM, along(ARM, "circle", 0.5, max_bend=0.4))


def test_it_is_compared_with_its_own_arm(run):
    assert run.arm == ARM
    np.testing.assert_array_equal(compare(run).tip_error, run.tip_error)
    with pytest.raises(InputError, match="of another arm"):
        run.check_arm(Arm(length=0.5))


def test_another_arm_in_its_place_is_refused(run):
    for arm in (replace(ARM, length=0.5), replace(ARM, links=9)):
        with pytest.raises(InputError, match="stations"):
            replace(run, arm=arm)
    bad = run.stations.copy()
    bad[3, 2] = np.nan
    for wrong in (
        {"stations": bad},
        {"status": "foo"},
        {"bend": run.bend[:3]},
        {"stations": run.stations[:, :4]},
        {"arm": 3},
        {"qpos": run.qpos[0]},
    ):
        with pytest.raises(InputError):
            replace(run, **wrong)
    for wrong in ([1, 2], None, run.reference):
        with pytest.raises(InputError, match="a Trajectory"):
            compare(wrong)


def test_copies_stay_read_only(run):
    for one in (run, run.reference):
        for again in (copy.deepcopy(one), pickle.loads(pickle.dumps(one))):
            assert again == one
            with pytest.raises(ValueError, match="read-only"):
                again.bend[0] = 1.0


def test_a_place_that_cannot_be_written_to_is_refused(run, tmp_path):
    for path in (tmp_path / "t", tmp_path, tmp_path / "none" / "t.npz"):
        with pytest.raises(InputError, match="path"):
            run.save(path)
    assert not list(tmp_path.iterdir())


def test_what_is_said_of_it_is_two_lines(run):
    said = repr(run)
    assert len(said.splitlines()) == 2
    assert len(repr(compare(run))) < 250
    assert len(said) < 250
    assert "finished" in said
    assert f"{1e3 * run.tip_error.max():.3g} mm" in said


def test_equality_answers(run):
    assert run == simulate(ARM, along(ARM, "circle", 0.5, max_bend=0.4))
    assert run != replace(run, setpoint=run.setpoint + 1e-12)
    assert run != replace(run, arm=replace(ARM, payload=0.0))
    assert run != replace(run, status="interrupted")
    assert replace(run, step_error=np.zeros(len(run))) != replace(run, step_error=None)
    assert run != 3
    assert run.reference == along(ARM, "circle", 0.5, max_bend=0.4)


def test_it_survives_the_disk_with_all_that_it_knows(run, tmp_path):
    for one in (run, poses_at_rest(ARM, resting(ARM, np.array([[0.5, 0.2]])), "pressure")):
        path = tmp_path / f"{one.controller}.npz"
        one.save(path)
        again = Trajectory.load(path)
        assert again == one
        assert (again.versions, again.real_time_factor) == (one.versions, one.real_time_factor)
        assert again.arm.gravity == ARM.gravity


def test_it_opens_without_the_engine(run, tmp_path):
    run.save(tmp_path / "t.npz")
    program = (
        "import sys; from contarm_sim.results.trajectory import Trajectory; from contarm_sim.results.compare import "
        f"compare; t = Trajectory.load({str(tmp_path / 't.npz')!r}); print(compare(t).tip_error.max()); "
        "print([name for name in sys.modules if name.startswith(('mujoco', 'matplotlib', 'pandas'))])"
    )
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    error, loaded = done.stdout.splitlines()
    assert float(error) == run.tip_error.max()
    assert loaded == "[]"


def test_tables(run):
    pandas = pytest.importorskip("pandas")
    frame = run.to_dataframe()
    assert isinstance(frame, pandas.DataFrame)
    assert len(frame) == len(run)
    np.testing.assert_array_equal(frame["tip_z [m]"], run.tip[:, 2])
    np.testing.assert_array_equal(frame["muscle_tensions_2 [N]"], run.muscle_tensions[:, 1])
    assert "setpoint_3 [m]" in frame


def test_datasets(run):
    pytest.importorskip("xarray")
    data = run.to_xarray()
    assert data["stations"].attrs["units"] == "m"
    np.testing.assert_array_equal(data["stations"].sel(axis="z").isel(station=-1), run.tip[:, 2])
    assert data.sizes["time"] == len(run)


def test_without_the_libraries_it_says_what_to_install(run, monkeypatch):
    monkeypatch.setitem(sys.modules, "pandas", None)
    with pytest.raises(MissingError, match=r"pip install .\.\[tables\]"):
        run.to_dataframe()
