"""The training script: a few hundred steps of it, stopped, gone on with, and what it says when it cannot."""

import csv
import importlib.util
import signal
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from films import decoded
from waiting import PATIENCE, wait_for

pytest.importorskip("gymnasium")

SCRIPT = Path(__file__).parents[1] / "scripts" / "train.py"
learns = pytest.mark.skipif(
    importlib.util.find_spec("stable_baselines3") is None, reason="the extra `train` is not installed"
)


def words(*given):
    return [sys.executable, str(SCRIPT), *map(str, given)]


def train(folder, *given):
    return subprocess.run(words(*given), cwd=folder, capture_output=True, text=True, timeout=PATIENCE)


def points(folder):
    with (folder / "curve.csv").open(newline="") as file:
        return list(csv.DictReader(file))


@learns
def test_it_trains_scores_draws_and_goes_on(tmp_path):
    done = train(tmp_path, "--steps", 256, "--seeds", 2, "--out", "p", "--arm", "two", "--no-film")
    assert (done.returncode, done.stderr) == (0, "")
    assert [line.split()[0] for line in done.stdout.splitlines()[-4:-1]] == ["learned", "baseline", "random"]
    folder = tmp_path / "p"
    assert {file.name for file in folder.iterdir()} == {
        "arm.toml", "curve.csv", "curve.png", "policy.zip", "settings.json",
    }  # fmt: skip
    first = points(folder)
    assert [point["steps"] for point in first] == ["0", "256"]
    assert first[0]["reward_mean"] != first[1]["reward_mean"]  # something was learned, for better or worse

    again = train(tmp_path, "--resume", "p", "--steps", 512, "--no-film")
    assert (again.returncode, again.stderr) == (0, "")
    assert [point["steps"] for point in points(folder)] == ["0", "256", "512"]
    assert points(folder)[:2] == first
    assert again.stdout.startswith("going on after 256 steps\n")

    other = train(tmp_path, "--out", "p")
    assert (other.returncode, other.stdout) == (2, "")
    assert "train.py: out is p; allowed: a folder that is not there yet; --resume goes on" in other.stderr


@learns
@pytest.mark.gl
def test_the_film_shows_learned_and_baseline_side_by_side(tmp_path):
    done = train(tmp_path, "--task", "reach", "--steps", 64, "--seeds", 1, "--out", "p")
    assert (done.returncode, done.stderr) == (0, "")
    pictures, _ = decoded(tmp_path / "p" / "film.mp4", (480, 960))
    assert len(pictures) == 4 * 41
    moved = np.abs(pictures[40] - pictures[0])[40:]  # below the captions
    assert (moved[:, 480:] > 60).sum() > 1000  # the baseline moves


@learns
def test_ctrl_c_keeps_what_was_learned(tmp_path):
    running = subprocess.Popen(
        words("--steps", 1_000_000, "--seeds", 2, "--out", "p"), cwd=tmp_path, stderr=subprocess.PIPE, text=True
    )
    wait_for(lambda: (tmp_path / "p" / "policy.zip").exists() or running.poll() is not None)
    before = (tmp_path / "p" / "policy.zip").read_bytes()
    running.send_signal(signal.SIGINT)
    said = running.communicate(timeout=PATIENCE)[1]
    assert running.returncode == 130
    assert said.startswith("stopped after ")
    assert said.endswith("go on with: python scripts/train.py --resume p\n")
    assert len(said.splitlines()) == 1
    assert (tmp_path / "p" / "policy.zip").read_bytes() != before


@learns
def test_stable_baselines_checks_the_vector():
    """Its episodes are the native vector's, reset in the same step."""
    from stable_baselines3.common.vec_env import VecMonitor

    from contarm_sim.envs.sb3 import ArmVecEnv
    from contarm_sim.envs.vector import ArmVectorEnv

    envs, native = ArmVecEnv(3, task="reach", time_limit=0.2), ArmVectorEnv(3, task="reach", time_limit=0.2)
    envs.seed(5)
    np.testing.assert_array_equal(envs.reset(), native.reset(seed=5)[0])
    monitored, rng = VecMonitor(envs), np.random.default_rng(0)
    for tick in range(1, 9):
        action = rng.uniform(-1, 1, (3, 2))
        observations, rewards, done, infos = monitored.step(action)
        assert done.all() == done.any() == (tick % 4 == 0)
        found = native.step(action)
        np.testing.assert_array_equal(rewards, found[1])
        if done.any():
            last, found = found[0], native.reset(options={"reset_mask": np.ones(3, bool)})
            for place, info in enumerate(infos):
                np.testing.assert_array_equal(info["terminal_observation"], last[place])
                assert info["TimeLimit.truncated"] is True
                assert info["episode"]["l"] == 4
        np.testing.assert_array_equal(observations, found[0])
    envs.close()


@learns
def test_mistakes_are_said_in_one_line(tmp_path):
    (tmp_path / "empty").mkdir()
    for given, said in (
        (("--steps", 0), "steps is 0; allowed: a whole number, at least 1"),
        (("--seeds", -1), "seeds is -1"),
        (("--arm", "tow"), "arm is 'tow'; allowed: an Arm, a preset"),
        (("--task", "hold", "--actions", "bend"), "actions is 'bend'; allowed: pressures for hold"),
        (("--resume", "empty"), "resume is empty; allowed: a folder that this script made"),
        (("--out", "/proc/p", "--seeds", 1), "/proc/p"),
        (("--resume", "empty", "--task", "reach"), "resume is given with --task"),
    ):
        done = train(tmp_path, *given)
        assert done.returncode == 2
        assert done.stderr.startswith("train.py: ")
        assert said in done.stderr
        assert done.stderr.count("\n") == 1
    assert [file.name for file in tmp_path.iterdir()] == ["empty"]


def test_without_the_extra_one_line_says_what_to_install(tmp_path):
    code = f"""if True:
        import runpy, sys
        sys.modules["stable_baselines3"] = None
        sys.path.insert(0, {str(SCRIPT.parent)!r})
        sys.argv = ["train.py"]
        runpy.run_path({str(SCRIPT)!r}, run_name="__main__")"""
    done = subprocess.run([sys.executable, "-c", code], cwd=tmp_path, capture_output=True, text=True)
    assert done.returncode == 2
    assert done.stderr == ("train.py: stable-baselines3 is not installed; get it with: pip install '.[train]'\n")
    assert not list(tmp_path.iterdir())


def test_the_curve_has_all_policies_and_nothing_outside(tmp_path, monkeypatch):
    monkeypatch.syspath_prepend(str(SCRIPT.parent))
    from learning import Point, _curve, draw_curve, read_points, write_points

    from contarm_sim.view.style import drawn

    made = [Point(1000 * i, 2.0 * i, 0.1 * i, 5 * i, 0.3 / (1 + i) ** 3, 0.5 / (1 + i)) for i in range(9)]
    write_points(tmp_path / "curve.csv", made)
    assert read_points(tmp_path / "curve.csv") == made
    others = {
        "baseline": {"reward_mean": 0.8, "error_mean_m": 2e-4},
        "random": {"reward_mean": 0.07, "error_mean_m": 0.31},
    }
    told = {"task": "reach", "seeds": 50, "length": 0.37}
    draw_curve(tmp_path, "curve", made, others, told)
    assert (tmp_path / "curve.png").stat().st_size > 10_000
    for width in ("page", "column"):
        sheet = drawn(_curve(made, others, told), width)
        sheet.canvas.draw()
        reward, error = sheet.axes
        assert [line.get_ydata()[-1] for line in reward.lines] == pytest.approx([0.8, 0.8, 0.07])
        assert [line.get_ydata()[-1] for line in error.lines] == pytest.approx([300 / 729, 0.2, 310])
        low, high = error.get_ylim()
        assert low < 0.2
        assert high > 310
        named = [text.get_text() for text in sheet.legends[0].get_texts()]
        assert named == ["learned", "closed-form baseline", "chance", "within 1 % of length"]
        page = sheet.bbox
        for axis in sheet.axes:
            box = axis.get_tightbbox()
            assert page.x0 <= box.x0
            assert box.x1 <= page.x1
        legend = sheet.legends[0].get_window_extent()
        assert page.x0 <= legend.x0
        assert legend.x1 <= page.x1
        assert not any(legend.overlaps(axis.get_tightbbox()) for axis in sheet.axes)
