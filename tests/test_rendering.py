import ctypes
import json
import os
import re
import subprocess
import sys
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from waiting import PATIENCE

from contarm_sim.errors import InputError, RenderingError
from contarm_sim.kinematics import arc
from contarm_sim.mjcf import scene_spec
from contarm_sim.mjcf.framing import Frame
from contarm_sim.model.arm import Arm
from contarm_sim.results.trajectory import Trajectory
from contarm_sim.view.rendering.cameras import Camera, extent
from contarm_sim.view.rendering.draw import ArmRenderer, Overlays
from contarm_sim.view.rendering.encode import encoder, encoding
from contarm_sim.view.rendering.film import film, film_beside
from contarm_sim.view.rendering.look import Look, Scale, frame_indices
from contarm_sim.view.rendering.overlays import thin
from contarm_sim.view.rendering.still import still
from contarm_sim.view.rendering.video import Shot, write_gif, write_still, write_video, write_webp

NOTHING = Overlays(path=False, trace=False, target=False, ghost=False, frames=False)
DOWNS = [(0.0, 0.0, 0.0), (0.0, 0.0, 9.81), (9.81, 0.0, 0.0)]


def samples_of(arm, bend, bent=None, rate=100.0):
    """Samples of an arm commanded to `bend` and found bent alike everywhere by `bent`, without a simulation."""
    bend = np.atleast_2d(np.asarray(bend, dtype=float))
    bent = bend if bent is None else np.broadcast_to(bent, bend.shape)
    count, model = len(bend), scene_spec(arm).compile()
    qpos = np.zeros((count, model.nq))
    for i in range(1, arm.links + 1):
        qpos[:, model.joint(f"joint_{i:02d}_x").qposadr[0]] = -bent[:, 1] / arm.links
        qpos[:, model.joint(f"joint_{i:02d}_y").qposadr[0]] = bent[:, 0] / arm.links
    return Trajectory(
        arm=arm,
        controller="servo",
        status="finished",
        time=np.arange(count) / rate,
        target=arc.position(bend, arm.length),
        bend=bend,
        setpoint=np.zeros((count, 3)),
        muscle_lengths=np.zeros((count, 3)),
        muscle_tensions=np.tile([5.0, 20.0, 40.0], (count, 1)),
        pressure=np.tile([1e5, 2e5, 4e5], (count, 1)),
        stations=arc.position(bent[:, None], arm.length, np.linspace(0, 1, arm.links + 1)),
        tip_rotation=arc.rotation(bent),
        qpos=qpos,
    )


def moved(samples, offset):
    """Return samples whose tips are elsewhere by an offset [m]."""
    stations = samples.stations.copy()
    stations[:, -1] += offset
    return replace(samples, stations=stations)


def spiral(arm, count=51):
    angle = np.linspace(0, 2 * np.pi, count)
    return samples_of(arm, (0.2 + 0.2 * angle)[:, None] * np.stack([np.cos(angle), np.sin(angle)], axis=1))


def shot(arm, fps=30.0, size=(160, 120), **given):
    return Shot(spiral(arm), Look(*size), fps, **given)


@cache
def base_pose(arm):
    """Place of the base in the world, shape (3,), and its orientation, shape (3, 3), from the engine."""
    import mujoco

    model = scene_spec(arm).compile()
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    base = data.body("base")
    return base.xpos.copy(), base.xmat.reshape(3, 3).copy()


def pinhole(arm, points, width, height, camera="front", extent=None, frame=None):
    """Pixels (x right, y down) of points of the base frame, by the pinhole formula and the pose of the camera.

    Also how many pixels a metre is there. `extent`: points of the base frame that the camera shows, in a `frame`.
    """
    place, turn = base_pose(arm)
    world = None if extent is None else place + extent @ turn.T
    shown = replace(frame or Frame(), aspect=width / height)
    eye = Camera(camera, arm, world, shown).at(np.zeros(3), 0.0)
    a, e = np.radians([eye.azimuth, eye.elevation])
    ahead = np.array([np.cos(e) * np.cos(a), np.cos(e) * np.sin(a), np.sin(e)])
    right = np.array([np.sin(a), -np.cos(a), 0.0])
    frame = np.stack([right, np.cross(right, ahead), -ahead])
    seen = (place + points @ turn.T - eye.lookat + eye.distance * ahead) @ frame.T
    a_metre = height / 2 / np.tan(np.radians(14.0)) / -seen[..., 2]
    return np.stack([width / 2 + a_metre * seen[..., 0], height / 2 - a_metre * seen[..., 1]], axis=-1), a_metre


def project(*given, **named):
    """Pixels of points, see `pinhole`."""
    return pinhole(*given, **named)[0]


def changed(picture, plain):
    return np.abs(picture.astype(int) - plain.astype(int)).max(axis=2) > 25


def same(picture, other):
    """Equal but for what software GL rounds differently in the first picture of a context."""
    return np.abs(picture.astype(int) - other.astype(int)).max() <= 3


# --- GL libraries: each case in a process of its own, for a process has one GL library for good.


def run_python(code, **environment):
    kept = {
        k: v for k, v in os.environ.items() if k not in ("MUJOCO_GL", "PYOPENGL_PLATFORM", "DISPLAY", "WAYLAND_DISPLAY")
    }
    return subprocess.run(
        [sys.executable, "-W", "error", "-c", code],
        env=kept | environment,
        capture_output=True,
        text=True,
        timeout=PATIENCE,
    )


CHOOSE = """
import json
from contarm_sim.errors import RenderingError
from contarm_sim.view.rendering.gl import choose_backend
try:
    backend = choose_backend()
except RenderingError as error:
    print(json.dumps({"error": str(error), "attempts": error.attempts}))
else:
    print(json.dumps({"name": backend.name, "attempts": backend.attempts}))
"""


def choose(before="", **environment):
    done = run_python(before + CHOOSE, **environment)
    assert done.returncode == 0, done.stderr
    assert done.stderr == ""
    return json.loads(done.stdout)


def needs(library):
    try:
        ctypes.CDLL(library)
    except OSError:
        pytest.skip(f"{library} is not installed")


@pytest.mark.gl
def test_egl_and_osmesa_draw_the_same_picture(tmp_path):
    needs("libEGL.so.1")
    needs("libOSMesa.so.8")
    code = """
import numpy as np
from contarm_sim.model.arm import Arm
from contarm_sim.view.rendering.draw import ArmRenderer
from contarm_sim.view.rendering.gl import choose_backend
with ArmRenderer(Arm(), 160, 120) as renderer:
    np.save({path!r}, renderer.pose(renderer.bent([1.5, 0.5])))
print(choose_backend().name)
"""
    pictures = []
    for name in ("egl", "osmesa"):
        found = choose(MUJOCO_GL=name)
        if found["name"] != name:
            pytest.skip(f"{name} does not work here: {found['attempts'][0][1]}")
        file = tmp_path / f"{name}.npy"
        done = run_python(code.format(path=str(file)), MUJOCO_GL=name)
        assert (done.returncode, done.stdout.strip(), done.stderr) == (0, name, "")
        pictures.append(np.load(file).astype(float))
    assert pictures[0].std() > 20
    assert np.abs(pictures[0] - pictures[1]).mean() < 1


@pytest.mark.gl
def test_osmesa_takes_over_where_egl_has_no_driver(tmp_path):
    needs("libOSMesa.so.8")
    found = choose(MUJOCO_GL="egl", __EGL_VENDOR_LIBRARY_DIRS=str(tmp_path))
    assert found["name"] == "osmesa"
    assert found["attempts"][0][0] == "egl"
    assert "driver" in found["attempts"][0][1]


@pytest.mark.gl
def test_osmesa_takes_over_after_a_failing_egl_module():
    needs("libOSMesa.so.8")
    found = choose("import sys; sys.modules['mujoco.egl'] = None\n", MUJOCO_GL="egl")
    assert [found["name"], found["attempts"][0][0]] == ["osmesa", "egl"]


@pytest.mark.gl
def test_an_unknown_wish_is_said_and_something_else_draws(gl):
    found = choose(MUJOCO_GL="nonsense")
    assert found["attempts"][0] == ["nonsense", "MUJOCO_GL names no library that there is; egl, osmesa, glfw"]
    assert found["name"] in ("egl", "osmesa")


@pytest.mark.gl
def test_a_window_system_is_not_believed_without_a_display(gl):
    found = choose(MUJOCO_GL="glfw", DISPLAY=":9876")
    assert found["attempts"][0] == ["glfw", "the display cannot be opened"]
    assert found["name"] in ("egl", "osmesa")


def test_without_any_library_there_is_one_line_that_helps(tmp_path):
    found = choose("import sys; sys.modules['mujoco.osmesa'] = None\n", __EGL_VENDOR_LIBRARY_DIRS=str(tmp_path))
    assert "\n" not in found["error"]
    assert "apt-get install libegl1 libopengl0 libgl1-mesa-dri" in found["error"]
    assert [name for name, _ in found["attempts"]] == ["egl", "osmesa"]
    assert all(reason in found["error"] for _, reason in found["attempts"])


@pytest.mark.parametrize("wish", ["egl", "osmesa", "nonsense"])
def test_the_physics_needs_no_gl_library_whatever_the_user_wishes(wish, tmp_path):
    (tmp_path / "OpenGL.py").write_text("raise AttributeError('as PyOpenGL does without its library')")
    broken = f"import os, sys; sys.path.insert(0, {str(tmp_path)!r})\n"
    assert run_python(broken + "import mujoco", MUJOCO_GL=wish).returncode != 0  # what there is to protect from
    done = run_python(broken + "import contarm_sim.motion.simulate; print(os.environ['MUJOCO_GL'])", MUJOCO_GL=wish)
    assert (done.stdout.strip(), done.stderr) == (wish, "")


def test_importing_the_package_loads_no_engine():
    heavy = "{'mujoco', 'mediapy', 'PIL', 'scipy'}"
    done = run_python(f"import sys, contarm_sim.view.rendering.video; print(*{heavy}.intersection(sys.modules))")
    assert (done.stdout.strip(), done.stderr) == ("", "")


# --- Pictures.


@pytest.mark.gl
@pytest.mark.parametrize("gravity", DOWNS)
@pytest.mark.parametrize("camera", ["front", "side", "top"])
def test_the_target_is_drawn_where_the_closed_form_says(gl, gravity, camera):
    arm = Arm(gravity=gravity)
    samples = samples_of(arm, [1.2, 0.9], bent=[-1.2, -0.9])
    with ArmRenderer(arm, 320, 240, camera) as renderer:
        plain = renderer.frame(samples, 0, NOTHING)
        picture = renderer.frame(samples, 0, replace(NOTHING, target=True))
    rows, columns = np.nonzero(changed(picture, plain))
    found = [columns.mean() + 0.5, rows.mean() + 0.5]
    np.testing.assert_allclose(found, project(arm, arc.position([1.2, 0.9], arm.length), 320, 240, camera), atol=1.5)


@pytest.mark.gl
def test_target_trace_and_ghost_end_within_two_pixels_of_the_closed_forms_at_720p(gl, arm):
    samples = spiral(arm)
    samples = moved(samples, [0.01, 0.0, 0.0])  # a simulated tip that is not the analytic one
    with ArmRenderer(arm, 1280, 720) as renderer:
        plain = renderer.frame(samples, 45, NOTHING)
        drawn = {
            name: renderer.frame(samples, 45, replace(NOTHING, **{name: True})) for name in ("target", "trace", "ghost")
        }
    places = {name: np.argwhere(changed(picture, plain))[:, ::-1] + 0.5 for name, picture in drawn.items()}
    tip, simulated = (project(arm, at, 1280, 720) for at in (samples.target[45], samples.stations[45, -1]))
    assert np.linalg.norm(tip - simulated) > 8
    assert np.linalg.norm(places["target"].mean(axis=0) - tip) < 2
    assert np.linalg.norm(places["trace"] - simulated, axis=1).min() < 2
    beyond = project(arm, samples.stations[46:, -1], 1280, 720)[3:]
    assert np.linalg.norm(places["trace"][:, None] - beyond, axis=2).min() > 2  # it ends there
    rim = 1.25 * (arm.muscle_radius + 0.5 * arm.muscle.diameter)
    turn = np.linspace(0, 2 * np.pi, 90)
    ring = rim * np.stack([np.cos(turn), np.sin(turn), 0 * turn], axis=1) @ arc.rotation(samples.bend[45]).T
    mouth = project(arm, samples.target[45] + ring, 1280, 720)
    outer = mouth[
        np.argsort(
            np.linalg.norm(mouth - project(arm, arc.position(samples.bend[45], arm.length, 0.9), 1280, 720), axis=1)
        )[:20]
    ]
    distance = np.linalg.norm(places["ghost"][:, None] - outer, axis=2).min(axis=0)
    assert np.median(distance) < 2


@pytest.mark.gl
@pytest.mark.parametrize("gravity", DOWNS)
def test_the_ghost_lies_along_the_analytic_arc(gl, gravity):
    arm, bend = Arm(gravity=gravity), np.array([1.2, 0.9])
    samples = samples_of(arm, bend, bent=-bend)
    with ArmRenderer(arm, 320, 240) as renderer:
        plain = renderer.frame(samples, 0, NOTHING)
        picture = renderer.frame(samples, 0, replace(NOTHING, ghost=True))
    rows, columns = np.nonzero(np.abs(picture.astype(int) - plain.astype(int)).max(axis=2) > 2)
    line, a_metre = pinhole(arm, arc.position(bend, arm.length, np.linspace(0, 1, 100)), 320, 240)
    distance = np.linalg.norm(np.stack([columns + 0.5, rows + 0.5], axis=1)[:, None] - line, axis=2)
    radius = 1.25 * (arm.muscle_radius + 0.5 * arm.muscle.diameter)
    assert distance.min(axis=1).max() < 1.3 * radius * a_metre.max()
    assert np.median(distance.min(axis=0)) < 2  # towards its mouth one may look into the tube


@pytest.mark.gl
@pytest.mark.parametrize("gravity", DOWNS)
def test_the_arm_is_drawn_along_its_arc(gl, gravity):
    arm, bend = Arm(gravity=gravity), np.array([1.2, 0.9])
    with ArmRenderer(arm, 320, 240) as renderer:
        one, other = renderer.pose(renderer.bent(bend)), renderer.pose(renderer.bent(-bend))
    samples = replace(samples_of(arm, bend), muscle_tensions=np.ones((1, 3)))
    with ArmRenderer(arm, 320, 240) as renderer:
        assert same(renderer.frame(samples, 0, NOTHING), one)
    rows, columns = np.nonzero(changed(one, other))
    pixels = np.stack([columns + 0.5, rows + 0.5], axis=1)
    for side in (bend, -bend):
        line = project(arm, arc.position(side, arm.length, np.linspace(0.3, 1, 50)), 320, 240)
        assert np.linalg.norm(pixels[:, None] - line, axis=2).min(axis=0).max() < 3


@pytest.mark.gl
def test_a_sample_is_replayed_and_its_trace_ends_at_its_tip(gl, arm):
    samples = spiral(arm)
    with ArmRenderer(arm, 320, 240) as renderer:
        plain = renderer.frame(samples, 40, NOTHING)
        picture = renderer.frame(samples, 40, replace(NOTHING, trace=True))
        again = renderer.frame(samples, 40, NOTHING)
        other = renderer.frame(samples, 10, NOTHING)
    assert same(again, plain)
    assert changed(plain, other).sum() > 200
    rows, columns = np.nonzero(changed(picture, plain))
    pixels = np.stack([columns + 0.5, rows + 0.5], axis=1)
    tips = project(arm, samples.stations[:41, -1], 320, 240)
    distance = np.linalg.norm(pixels[:, None] - tips, axis=2)
    assert distance.min(axis=1).max() < 6
    assert np.median(distance.min(axis=0)) < 2


@pytest.mark.gl
def test_muscles_show_their_tension(gl, arm):
    samples = samples_of(arm, np.zeros((2, 2)))
    samples = replace(samples, muscle_tensions=[(40.0, 0.0, 0.0), (0.0, 0.0, 40.0)])
    with ArmRenderer(arm, 320, 240) as renderer:
        red, amber = (renderer.frame(samples, i, NOTHING).astype(int) for i in (0, 1))
    redness = [np.sum((p[..., 0] > 140) & (p[..., 1] < 60) & (p[..., 2] < 60)) for p in (red, amber)]
    yellowness = [np.sum((p[..., 0] > 160) & (p[..., 1] > 100) & (p[..., 2] < 60)) for p in (red, amber)]
    assert redness[0] > 2 * redness[1]
    assert yellowness[1] > 2 * yellowness[0]


@pytest.mark.parametrize("gravity", [*DOWNS, (0.0, 0.0, -9.81), (0.0, 9.81, 0.0), (5.0, 5.0, 5.0)])
@pytest.mark.parametrize("size", [(1280, 720), (640, 480), (400, 400), (360, 640)])
@pytest.mark.parametrize("shape", [{}, {"length": 0.06, "muscle_radius": 0.01}, {"length": 3.0}], ids=str)
def test_no_camera_clips_the_arm(gravity, size, shape):
    arm = Arm(gravity=gravity, **shape)
    bend = np.concatenate(
        [arc.from_polar(angle, np.linspace(0, 2 * np.pi, 16)) for angle in np.radians(range(0, 171, 10))]
    )
    turn = np.linspace(0, 2 * np.pi, 12)
    rim = (arm.muscle_radius + 0.5 * arm.muscle.diameter + 0.0015) * np.stack(
        [np.cos(turn), np.sin(turn), 0 * turn], axis=1
    )
    for xi in np.linspace(0, 1, 9):
        edge = arc.position(bend, arm.length, xi)[:, None] + rim @ arc.rotation(bend, xi).swapaxes(1, 2)
        for camera in ("front", "side", "top"):
            places = project(arm, edge, size[0], size[1], camera)
            caption = 0.05 * size[1]
            assert np.all((places > [0, caption]) & (places < size)), (camera, xi)


@pytest.mark.gl
def test_a_still_is_a_png_of_the_size_asked_for(gl, arm, tmp_path):
    from PIL import Image

    still(arm, [1.5, 0.5], tmp_path / "arm.png", 160, 120)
    with Image.open(tmp_path / "arm.png") as picture:
        assert (picture.format, picture.size) == ("PNG", (160, 120))
        assert np.asarray(picture).std() > 20


@pytest.mark.gl
@pytest.mark.parametrize(
    ("given", "name"),
    [
        ({"width": 0}, "width"),
        ({"height": 1.5}, "height"),
        ({"camera": "back"}, "camera"),
    ],
)
def test_a_renderer_refuses_what_it_cannot_draw(gl, arm, given, name):
    with pytest.raises(InputError) as caught:
        ArmRenderer(arm, **{"width": 160, "height": 120} | given)
    assert caught.value.name == name


@pytest.mark.gl
def test_a_picture_beyond_the_library_is_refused_in_one_line(gl, arm):
    with pytest.raises(RenderingError, match="100000 x 16") as caught:
        ArmRenderer(arm, 100_000, 16)
    assert "\n" not in str(caught.value)


def test_lines_keep_their_ends():
    for count in (2, 200, 201, 202, 1001, 1234):
        points = np.arange(3.0 * count).reshape(count, 3)
        kept = thin(points)
        assert len(kept) <= 202
        assert np.array_equal(kept[[0, -1]], points[[0, -1]])


# --- Films.


def test_two_runs_beside_each_other_have_one_scale(arm):
    straight, off = samples_of(arm, np.zeros((5, 2))), samples_of(arm, np.zeros((5, 2)))
    off = moved(off, [0.02, 0.0, 0.0])
    assert Scale.of(straight).error == pytest.approx(0.0, abs=1e-12)
    assert Scale.of(straight, off) == Scale.of(off, straight)
    assert Scale.of(straight, off).error == pytest.approx(0.02)


def test_frames_show_the_nearest_samples(arm):
    samples = samples_of(arm, np.zeros((401, 2)))
    for fps, speed in ((30, 1.0), (24, 0.5), (25, 3.0), (200, 1.0)):
        indices = frame_indices(samples, fps, speed)
        assert len(indices) == int(4.0 * fps / speed) + 1
        times = np.arange(len(indices)) * speed / fps
        assert np.abs(samples.time[indices] - times).max() <= 0.005 + 1e-9
    assert frame_indices(samples_of(arm, np.zeros((1, 2))), 30) == [0]
    assert frame_indices(replace(samples, time=np.zeros(401)), 30) == list(range(401))


@pytest.mark.parametrize("given", [{"fps": 0.0}, {"fps": 30.0, "speed": -1.0}, {"fps": float("nan")}])
def test_a_film_refuses_impossible_rates(arm, given):
    with pytest.raises(InputError):
        frame_indices(spiral(arm), **given)


@pytest.mark.gl
def test_a_video_has_every_frame(gl, arm, tmp_path):
    seen, film = [], tmp_path / "v.mp4"
    write_video(shot(arm), film, lambda done, total: seen.append((done, total)))
    assert [file.name for file in tmp_path.iterdir()] == ["v.mp4"]
    assert seen == [(i, 16) for i in range(1, 17)]
    decode = [encoder(), "-i", str(film), "-f", "rawvideo", "-pix_fmt", "rgb24", "-"]
    decoded = subprocess.run(decode, capture_output=True, check=True)
    about = decoded.stderr.decode()
    assert re.search(r"Video: h264.*yuv420p.*160x120.*30 fps", about)
    frames = np.frombuffer(decoded.stdout, np.uint8).reshape(-1, 120, 160, 3).astype(int)
    assert len(frames) == 16
    *_, drawn = shot(arm).frames()
    assert np.abs(frames[-1] - drawn).mean() < 4


@pytest.mark.gl
def test_a_film_is_the_same_bytes_on_one_processor_and_on_all(tmp_path):
    rows, columns = np.mgrid[:120, :160]
    frames = [np.stack([rows + 3 * i, columns + i, (rows * columns) // (i + 1)], 2).astype(np.uint8) for i in range(40)]
    processors = os.sched_getaffinity(0)
    written = []
    for some in (processors, {min(processors)}):
        try:
            os.sched_setaffinity(0, some)
            with encoding(encoder(), tmp_path / "v.mp4", (120, 160), 30) as add:
                for frame in frames:
                    add(frame)
        finally:
            os.sched_setaffinity(0, processors)
        written.append((tmp_path / "v.mp4").read_bytes())
    assert written[0] == written[1]
    assert b"threads=1 " in written[0]  # as many wherever it is encoded


def test_an_interrupted_video_leaves_what_was_there(gl, arm, tmp_path):
    def stop(done, total):
        if done == 3:
            raise KeyboardInterrupt

    (tmp_path / "v.mp4").write_text("before")
    for write, name in ((write_video, "v.mp4"), (write_video, "new.mp4"), (write_gif, "v.gif"), (write_webp, "v.webp")):
        with pytest.raises(KeyboardInterrupt):
            write(shot(arm), tmp_path / name, stop)
    assert [file.name for file in tmp_path.iterdir()] == ["v.mp4"]
    assert (tmp_path / "v.mp4").read_text() == "before"


@pytest.mark.gl
def test_a_gif_has_every_frame_at_its_time(gl, arm, tmp_path):
    from PIL import Image
    from PIL.GifImagePlugin import GifImageFile

    write_gif(shot(arm, fps=15), tmp_path / "v.gif")
    assert [file.name for file in tmp_path.iterdir()] == ["v.gif"]
    with Image.open(tmp_path / "v.gif") as film:
        assert isinstance(film, GifImageFile)
        assert (film.size, film.n_frames, film.info["loop"]) == ((160, 120), 8, 0)
        durations = []
        for i in range(film.n_frames):
            film.seek(i)
            durations.append(film.info["duration"])
    assert sum(durations) == 530  # 8/15 s in hundredths
    assert set(durations) <= {60, 70}


@pytest.mark.gl
def test_a_webp_has_every_frame(gl, arm, tmp_path):
    from PIL import Image
    from PIL.WebPImagePlugin import WebPImageFile

    write_webp(shot(arm, fps=20), tmp_path / "v.webp")
    with Image.open(tmp_path / "v.webp") as film:
        assert isinstance(film, WebPImageFile)
        assert (film.size, film.n_frames) == ((160, 120), 11)


@pytest.mark.gl
def test_two_runs_stand_side_by_side_and_the_shorter_waits(gl, arm, tmp_path):
    longer = samples_of(arm, np.full((101, 2), 0.8))
    pictures = list(shot(arm, fps=10, size=(320, 120), beside=longer).frames())
    assert len(pictures) == 11
    assert {picture.shape for picture in pictures} == {(120, 320, 3)}
    turned = next(Shot(longer, Look(320, 120), beside=spiral(arm)).frames())
    assert same(pictures[0][60:, 162:], turned[60:, 2:160])
    assert same(pictures[0][60:, 2:160], turned[60:, 162:])
    assert same(pictures[-1][:, :160], pictures[5][:, :160])


@pytest.mark.gl
def test_each_of_two_runs_is_on_its_own_side(gl, arm):
    """By the place of each target in the picture, beside the arm, not by the other run's film."""
    bent, asked = (np.zeros((2, 2)), np.full((2, 2), 0.4)), ([0.15, -0.1, 0.25], [0.2, 0.1, 0.1])
    runs = tuple(replace(samples_of(arm, bend), target=[place] * 2) for bend, place in zip(bent, asked, strict=True))
    path = replace(NOTHING, path=True)  # it takes the same room with the target and without
    look = Look(640, 240, plots=False, captions=False, overlays=path)
    with_target = replace(look, overlays=replace(path, target=True))
    plain, drawn = (next(film_beside((runs[0], [1]), (runs[1], [1]), each)).astype(int) for each in (look, with_target))
    differs = changed(drawn, plain)
    for number, run in enumerate(runs):
        ball = np.argwhere(differs[:, 320 * number : 320 * number + 318])[:, ::-1] + 0.5
        place = project(
            arm, run.target[1], 320, 240, extent=extent(*runs, ghost=False), frame=Frame(top=0.0, cards=(0.0, 0.0))
        )
        assert np.linalg.norm(ball.mean(axis=0) - place) < 2


@pytest.mark.gl
@pytest.mark.parametrize("longer_first", [True, False])
def test_a_gif_of_two_runs_is_as_long_as_the_longer(gl, arm, tmp_path, longer_first):
    from PIL import Image
    from PIL.GifImagePlugin import GifImageFile

    runs = samples_of(arm, np.full((101, 2), 0.8)), spiral(arm)
    one, other = runs if longer_first else runs[::-1]
    both = Shot(one, Look(200, 60), fps=5, beside=other)
    assert both.count == 6
    write_gif(both, tmp_path / "v.gif")
    with Image.open(tmp_path / "v.gif") as film:
        assert isinstance(film, GifImageFile)
        assert film.n_frames == 6


@pytest.mark.gl
def test_a_still_shows_the_sample_nearest_to_its_time(gl, arm, tmp_path):
    from PIL import Image

    write_still(shot(arm), tmp_path / "s.png", 0.252)
    with Image.open(tmp_path / "s.png") as picture:
        written = np.asarray(picture)
    drawn = next(film(spiral(arm), [25], Look(160, 120)))
    assert same(written, drawn)
    with pytest.raises(InputError, match=r"0 to 0\.5 s"):
        write_still(shot(arm), tmp_path / "t.png", 2.0)


@pytest.mark.gl
def test_plots_fill_up_as_time_passes(gl, arm):
    """Where a curve will be it is pale, where it has been it is dark, and the arm in the middle stays free."""
    samples = spiral(arm, 101)
    samples = moved(samples, np.linspace(0, 0.01, 101)[:, None] * [1.0, 0.0, 0.0])  # an error that grows
    look = Look(640, 360)
    (early, late), plain = (list(Shot(samples, each, 1.0).frames()) for each in (look, replace(look, plots=False)))
    for picture, bare in zip((early, late), plain, strict=True):
        differs = changed(picture, bare)
        assert differs[-90:, :150].any()
        assert differs[-90:, -150:].any()
        assert not differs[:, 200:440].any()
    dark = [np.sum(p[-100:, :180].max(axis=2) < 60) for p in (early, late)]
    assert dark[1] > dark[0] + 60


@pytest.mark.gl
@pytest.mark.parametrize("camera", ["orbit", "tip"])
def test_moving_cameras_move(gl, arm, camera):
    samples = spiral(arm)
    with ArmRenderer(arm, 320, 240, camera) as renderer:
        one, other = renderer.frame(samples, 0, NOTHING), renderer.frame(samples, 25, NOTHING)
    floor = slice(-20, None)
    assert changed(one[floor], other[floor]).any() or changed(one, other).mean() > 0.02
    with ArmRenderer(arm, 320, 240, camera) as renderer:
        plain = renderer.frame(samples, 50, NOTHING)
        pixels = np.argwhere(changed(renderer.frame(samples, 50, replace(NOTHING, target=True)), plain))
    if camera == "tip":  # the followed tip is in the middle, and there the target is on it
        np.testing.assert_allclose(pixels.mean(axis=0), [120, 160], atol=6)


@pytest.mark.parametrize(
    ("path", "size", "name"),
    [
        ("v.mp4", (161, 120), "width"),
        ("v.mp4", (160, 121), "height"),
        ("v.avi", (160, 120), "path"),
        ("no/v.mp4", (160, 120), "path"),
    ],
)
def test_a_video_is_refused_before_anything_is_written(arm, tmp_path, path, size, name):
    with pytest.raises(InputError) as caught:
        write_video(shot(arm, size=size), tmp_path / path)
    assert caught.value.name == name
    assert list(tmp_path.iterdir()) == []


def test_a_missing_encoder_is_reported_in_one_line(arm, tmp_path, monkeypatch):
    import imageio_ffmpeg

    def missing():
        raise RuntimeError("No ffmpeg exe could be found.\nInstall it.")

    monkeypatch.setenv("PATH", str(tmp_path))
    assert Path(encoder()).is_file()
    monkeypatch.setattr(imageio_ffmpeg, "get_ffmpeg_exe", missing)
    with pytest.raises(RenderingError, match="install ffmpeg") as caught:
        write_video(shot(arm), tmp_path / "v.mp4")
    assert "\n" not in str(caught.value)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.gl
def test_a_failing_encoder_is_quoted(gl, tmp_path):
    program = tmp_path / "ffmpeg"
    program.write_text(
        "#!/bin/sh\n[ $2 = -encoders ] && echo ' V libx264 H.264' && exit\necho 'Out of luck' >&2\nexit 1\n"
    )
    program.chmod(0o755)
    folder = tmp_path / "films"
    folder.mkdir()
    code = f"""
import sys
sys.path.insert(0, {str(Path(__file__).parent)!r})
from pathlib import Path
from contarm_sim.model.arm import Arm
from contarm_sim.errors import RenderingError
from contarm_sim.view.rendering.video import write_video
from test_rendering import shot
try:
    write_video(shot(Arm(), size=(320, 240)), Path({str(folder)!r}) / "v.mp4")
except RenderingError as error:
    print(error)
"""
    done = run_python(code, PATH=str(tmp_path))
    assert "the video encoder failed: Out of luck" in done.stdout
    assert done.stdout.count("\n") == 1
    assert list(folder.iterdir()) == []
