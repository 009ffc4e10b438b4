"""Pictures of environments: their keywords, Gymnasium's checker and recorder, and an end of Python without a word."""

import ctypes
import os
import subprocess
import sys

import numpy as np
import pytest
from films import decoded
from waiting import PATIENCE

gymnasium = pytest.importorskip("gymnasium")

from gymnasium.utils.env_checker import check_env  # noqa: E402

from contarm_sim.envs.gym import ArmEnv  # noqa: E402
from contarm_sim.envs.registration import NAMES  # noqa: E402
from contarm_sim.errors import InputError, RenderingError  # noqa: E402
from contarm_sim.view.rendering.gl import choose_backend  # noqa: E402

pytestmark = pytest.mark.gl


@pytest.fixture(autouse=True)
def _needs_gl():
    try:
        choose_backend()
    except RenderingError:
        pytest.skip("no GL library here")


@pytest.fixture
def headless(monkeypatch):
    monkeypatch.delenv("DISPLAY", raising=False)
    monkeypatch.delenv("WAYLAND_DISPLAY", raising=False)


def make(task="reach", **given):
    return gymnasium.make(NAMES[task], render_mode="rgb_array", **given)


def python(code, **environment):
    """Run a program where there is no display and nothing says what draws, warnings being errors."""
    left_out = ("MUJOCO_GL", "PYOPENGL_PLATFORM", "DISPLAY", "WAYLAND_DISPLAY")
    kept = {name: value for name, value in os.environ.items() if name not in left_out}
    done = subprocess.run(
        [sys.executable, "-W", "error", "-c", code], env=kept | environment, capture_output=True, text=True,
        timeout=PATIENCE,
    )  # fmt: skip
    assert (done.returncode, done.stderr) == (0, ""), done.stderr
    return done.stdout


@pytest.mark.parametrize("task", NAMES)
@pytest.mark.parametrize("mode", [None, "rgb_array"])
def test_gymnasiums_own_checker_is_content_without_a_display(task, mode, headless):
    check_env(gymnasium.make(NAMES[task], render_mode=mode).unwrapped)


def test_only_where_there_is_a_display_a_window_is_offered(monkeypatch, headless):
    assert ArmEnv().metadata["render_modes"] == ["rgb_array"]
    monkeypatch.setenv("DISPLAY", ":9876")
    assert ArmEnv().metadata["render_modes"] == ["rgb_array", "human"]


def test_width_height_and_camera_are_keywords():
    pictures = []
    for camera in ("front", "side", "top", "tip"):
        env = make(width=160, height=120, camera=camera)
        env.reset(seed=0)
        pictures.append(env.render())
        env.close()
        assert pictures[-1].shape == (120, 160, 3)
        assert np.ptp(pictures[-1]) > 100
    for i, one in enumerate(pictures):
        assert all((one != other).any(axis=2).sum() > 1000 for other in pictures[:i])
    envs = gymnasium.make_vec(NAMES["reach"], 2, render_mode="rgb_array", width=160, height=120, camera="side")
    envs.reset(seed=0)
    assert np.abs(envs.render()[0].astype(int) - pictures[1]).max() <= 3
    envs.close()


def test_the_circling_camera_makes_one_turn_an_episode():
    env = make(width=160, height=120, camera="orbit", actions="lengths", time_limit=0.2)
    env.reset(seed=0)
    seen = [env.render()]
    for _ in range(4):
        env.step(np.zeros(3))
        seen.append(env.render())
    env.close()
    away = [(one != seen[0]).any(axis=2).sum() for one in seen[1:]]
    assert min(away[:3]) > 5 * away[3]  # it is back where it began


def test_sizes_and_cameras_that_cannot_be_are_refused_at_once():
    for given, said in (
        ({"width": 0}, "width is 0; allowed: a positive whole number"),
        ({"height": 2.5}, "height is 2.5"),
        ({"width": 100_000}, "width is 100000; allowed: at most 16384"),
        ({"camera": "left"}, "camera is 'left'; allowed: front, side, top, orbit, tip"),
    ):
        with pytest.raises(InputError, match=said):
            make(**given)


OPEN = {
    "gymnasium": """
import gymnasium
env = gymnasium.make("contarm_sim.envs.gym:contarm/Reach-v0", render_mode="rgb_array", width=80, height=60)
env.reset(seed=0)
print(env.render().std() > 10)
""",
    "vector": """
import gymnasium
envs = gymnasium.make_vec("contarm_sim.envs.gym:contarm/Reach-v0", 2, render_mode="rgb_array", width=80, height=60)
envs.reset(seed=0)
print(envs.render()[0].std() > 10)
""",
    "renderer": """
import numpy as np
from contarm_sim import Arm
from contarm_sim.view.rendering.draw import ArmRenderer
print(ArmRenderer(Arm(), 80, 60).pose(np.zeros(48)).std() > 10)
kept = [ArmRenderer(Arm(), 80, 60) for _ in range(3)]
""",
    "another thread": """
import threading
import numpy as np
from contarm_sim import Arm
from contarm_sim.view.rendering.draw import ArmRenderer
kept = []
def draw():
    kept.append(ArmRenderer(Arm(), 80, 60))
    print(kept[0].pose(np.zeros(48)).std() > 10)
thread = threading.Thread(target=draw)
thread.start()
thread.join()
""",
}
DM = """
import os
from contarm_sim.envs import dm
env = dm.load("reach", random=0)
env.reset()
print(env.physics.render(60, 80, camera_id="front").std() > 10)
assert not {"MUJOCO_GL", "PYOPENGL_PLATFORM"} & set(os.environ)
"""


def osmesa():
    try:
        ctypes.CDLL("libOSMesa.so.8")
    except OSError:
        return False
    return True


@pytest.mark.parametrize("name", OPEN)
def test_what_is_left_open_says_nothing_when_python_ends(name):
    assert python(OPEN[name]) == "True\n"


@pytest.mark.skipif(not osmesa(), reason="libOSMesa is not installed")
@pytest.mark.parametrize("names", [("gymnasium", "vector"), ("renderer", "another thread")], ids=" and ".join)
def test_nor_does_osmesa_where_two_things_are_left_open(names):
    assert python("".join(OPEN[name] for name in names), MUJOCO_GL="osmesa") == "True\nTrue\n"


def test_dm_control_draws_and_ends_without_a_word_where_nothing_says_how():
    pytest.importorskip("dm_control", reason="dm-control does not install on this Python")
    assert python(DM) == "True\n"
    assert python(OPEN["renderer"] + DM) == "True\nTrue\n"


def test_dm_control_draws_where_it_was_imported_before():
    pytest.importorskip("dm_control", reason="dm-control does not install on this Python")
    early = "import warnings\nwith warnings.catch_warnings(action='ignore'):\n    import dm_control.suite\n"
    assert python(early + DM) == "True\n"


def test_dm_control_is_imported_without_a_gl_library(tmp_path):
    pytest.importorskip("dm_control", reason="dm-control does not install on this Python")
    code = """if True:
        from contarm_sim.envs import dm
        env = dm.load("reach", random=0)
        env.reset()
        print(env.step([0.5, 0.0]).reward > 0)"""
    assert python(code, MUJOCO_GL="disable") == "True\n"
    assert python(code, MUJOCO_GL="egl", __EGL_VENDOR_LIBRARY_DIRS=str(tmp_path)) == "True\n"


def test_renderers_do_not_disturb_each_other():
    """Neither one that is closed nor one that is thrown away, nor dm_control's."""
    code = """if True:
        import gc
        import numpy as np
        from contarm_sim import Arm
        from contarm_sim.view.rendering.draw import ArmRenderer
        one, two, three = (ArmRenderer(Arm(), 80, 60) for _ in range(3))
        still, bent = np.zeros(48), np.full(48, 0.05)
        first = one.pose(bent).copy()
        two.pose(still)
        three.pose(still)
        two.__exit__()
        print(np.abs(first - one.pose(bent).astype(int)).max() <= 3)
        del three
        gc.collect()
        print(np.abs(first - one.pose(bent).astype(int)).max() <= 3)"""
    assert python(code) == "True\nTrue\n"


def test_dm_controls_pictures_and_ours_take_turns():
    pytest.importorskip("dm_control", reason="dm-control does not install on this Python")
    code = """
first = env.physics.render(60, 80, camera_id="front").astype(int)
kept[0].pose(np.zeros(48))
print(np.abs(first - env.physics.render(60, 80, camera_id="front")).max() <= 3)
"""
    assert python(DM + OPEN["renderer"] + code).endswith("True\nTrue\nTrue\n")


def test_gymnasiums_recorder_writes_a_film_that_plays(tmp_path):
    pytest.importorskip("moviepy", reason="moviepy, of the extra `gym`, is not installed")
    code = f"""if True:
        import gymnasium
        import contarm_sim.envs.gym
        env = gymnasium.make("contarm/Reach-v0", render_mode="rgb_array", width=160, height=120, time_limit=0.5)
        env = gymnasium.wrappers.RecordVideo(env, {str(tmp_path / "films")!r})
        env.reset(seed=0)
        while not env.step(env.action_space.sample())[3]:
            pass
        env.close()"""
    assert python(code) == ""
    frames, told = decoded(tmp_path / "films" / "rl-video-episode-0.mp4", (120, 160))
    assert "h264" in told
    assert "yuv420p" in told  # what browsers play
    assert "20 fps" in told
    assert 10 <= len(frames) <= 11  # the decoder rounds
    assert np.abs(frames[0] - frames[-1]).max() > 50  # the arm moves
