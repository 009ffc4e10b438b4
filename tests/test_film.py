"""What is around the picture of the arm, films without the scene, and how films end that cannot go on."""

import json
import os
import signal
import subprocess
import time
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from PIL import Image
from test_rendering import moved, samples_of, spiral
from text_boxes import faults

from contarm_sim.errors import EncodingError, InputError, RenderingError
from contarm_sim.model.arm import Arm
from contarm_sim.view.colours import ERROR, error_colours, rgb
from contarm_sim.view.rendering.caption import PAPER, Caption
from contarm_sim.view.rendering.draw import ArmRenderer
from contarm_sim.view.rendering.encode import CODECS, encoder, encoding
from contarm_sim.view.rendering.film import film
from contarm_sim.view.rendering.insets import error_plot, inset_cards, muscle_plot
from contarm_sim.view.rendering.look import Look, Scale
from contarm_sim.view.rendering.panel import LETTERS, Curve, Panel, Plot, card, fits
from contarm_sim.view.rendering.video import Shot, write_gif, write_pictures, write_still, write_video, write_webp

SIZES = [(854, 480), (1280, 720), (1920, 1080), (640, 720), (720, 720)]
NUMBERS = ["t = 10.00 s", "tip error 100.00 mm = 27.03 %", "bend 120° towards \N{MINUS SIGN}172°"]
NOTE = "constant curvature does not hold: largest in the run 24.98 % of length   simulation explained within 0.032 %"
LEGEND = {"path": [(0.3, 0.3, 0.4)], "tip, error 0 to 92 mm": error_colours(np.linspace(0, 1, 24), 1.0)}


def test_the_line_of_the_present_time_leaves_names_of_limits_to_be_read():
    course = np.linspace(0, 1, 50)
    plot = Plot(["tip error [mm]"], course, [Curve(0 * course, "#ffffff")], 1.0, limits=[(0.7, "1 % of length")])
    panel, least = Panel((346, 194), 15.0, plot), []
    for place in (0.0, 1.0):
        pictures = [np.full((300, 400, 3), 255, np.uint8) for _ in range(2)]
        panel.write(pictures[0], place, "left")
        least.append(pictures[0].astype(int))
    words = (least[0] == least[1]).all(axis=2)
    for place in np.linspace(0.02, 0.98, 40):
        picture = np.full((300, 400, 3), 255, np.uint8)
        panel.write(picture, place, "left")
        changed = (picture.astype(int) != least[0]).any(axis=2)
        letters = words & (least[0].max(axis=2) < 60)  # ink in both pictures
        assert changed.any()
        assert not (changed & letters).any()


# --- Words along the top.


def strip_of(size, runs=1, numbers=NUMBERS):
    """The rows of a caption on black, and the caption."""
    width, height = size
    picture = np.zeros((height, width, 3), np.uint8)
    caption = Caption(width, height, [numbers] * runs, LEGEND, [NOTE] * runs)
    caption.write(picture, [numbers] * runs)
    return picture[: caption.height], caption


@pytest.mark.parametrize("runs", [1, 2])
@pytest.mark.parametrize("size", [*SIZES, (480, 854), (480, 270), (160, 120)])
def test_a_caption_is_not_clipped_and_can_be_read(size, runs):
    strip, caption = strip_of((size[0] * runs, size[1]), runs)
    assert caption.height <= (0.3 if size[1] > 120 else 0.35) * size[1]
    assert caption.size >= 0.02 * size[1]
    grey = strip.min(axis=2)
    assert grey.min() < 120
    assert grey[[0, -1]].min() > 240  # nothing touches an edge
    assert grey[:, [0, -1]].min() > 240
    assert np.all(np.all(strip[:1] == PAPER, axis=2))


@pytest.mark.parametrize("runs", [1, 2])
@pytest.mark.parametrize("size", SIZES)
def test_a_caption_keeps_its_legend(size, runs):
    """Also side by side, where it has a row of its own: its darkest red is there."""
    strip, _ = strip_of((size[0] * runs, size[1]), runs)
    last = np.round(255 * error_colours(np.array([1.0]), 1.0)[0])
    assert np.any(np.all(np.abs(strip - last) <= 1, axis=2))


def test_numbers_do_not_move_the_words_behind_them():
    strips = [strip_of((1280, 720), numbers=[first, *NUMBERS[1:]])[0] for first in ("t = 10.00 s", "t = 19.99 s")]
    differs = np.flatnonzero(np.any(strips[0] != strips[1], axis=(0, 2)))
    assert differs.size
    assert differs.max() < 160


# --- Plots in the corners.


def text_boxes(fig):
    """The boxes of all texts that are drawn on a figure [pixels]."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.text import Text

    FigureCanvasAgg(fig).draw()
    texts = [each for each in fig.findobj(Text) if each.get_visible() and each.get_text().strip()]
    return {(each.get_text(), i): (each.get_window_extent(), each.get_fontsize()) for i, each in enumerate(texts)}


def plots(arm):
    count = 101
    error = np.linspace(0, 0.012, count)[:, None] * [1.0, 0.0, 0.0]
    muscles = sum(group.routing.count for group in arm.groups)
    pressure = 9.1e5 * np.abs(np.sin(np.linspace(0, 6, count)[:, None] + np.arange(muscles)))
    samples = replace(moved(spiral(arm, count), error), pressure=pressure)
    scale = Scale.of(samples)
    return error_plot(samples, scale.error), muscle_plot(samples, scale.pressure, scale.tension)


@pytest.mark.parametrize("size", SIZES)
def test_texts_of_a_plot_are_inside_apart_and_large_enough(size):
    width, height = size
    letters = LETTERS * height
    own = (round(min(0.46 * width, max(0.27 * width, 0.42 * height))), round(0.27 * height))
    for plot in plots(Arm()):
        assert fits(own, letters, plot)
        fig, _ = card(own, letters, plot)
        assert all(size >= 0.02 * height for _, size in text_boxes(fig).values())
        assert [fault for fault in faults(fig) if " pt: " not in fault] == []


def test_plots_say_what_their_lines_are():
    error, needed = plots(Arm())
    said = " ".join(text for text, _ in text_boxes(card((346, 194), 15.0, needed)[0]))
    for words in ("pressure needed [kPa]", "muscle", "1", "2", "3", "highest: 700 kPa", "time [s]"):
        assert words in said
    said = " ".join(text for text, _ in text_boxes(card((346, 194), 15.0, error)[0]))
    for words in ("tip error [mm]", "1 % of length", "time [s]"):
        assert words in said
    assert [curve.colour for curve in error.curves] == [ERROR]
    assert not {rgb(colour) for colour in needed.names.values()} & {rgb(ERROR)}


def test_a_limit_far_above_all_curves_is_left_out():
    error = error_plot(spiral(Arm()), 1e-4)
    assert "% of length" not in " ".join(text for text, _ in text_boxes(card((346, 194), 15.0, error)[0]))


def test_the_name_of_a_limit_is_beside_the_curve():
    time = np.linspace(0, 1, 101)
    for values in (time, 1 - time, np.full(101, 0.2)):
        plot = Plot(["x [-]"], time, [Curve(values, "#000000")], 1.0, limits=[(0.5, "half")])
        fig, ax = card((346, 194), 15.0, plot)
        box = next(box for (text, _), (box, _) in text_boxes(fig).items() if text == "half")
        places = ax.transData.transform(np.column_stack([time, values]))
        inside = np.all((places > [box.x0, box.y0]) & (places < [box.x1, box.y1]), axis=1)
        assert not inside.any()


def test_the_name_of_a_limit_that_every_place_is_crossed_at_is_in_the_head_of_the_card():
    time = np.linspace(0, 1, 401)
    plot = Plot(["x [mm]"], time, [Curve(np.abs(np.sin(40 * time)), "#000000")], 1.0, limits=[(0.1, "limit")])
    fig, ax = card((346, 194), 15.0, plot)
    box = next(box for (text, _), (box, _) in text_boxes(fig).items() if text == "limit")
    assert box.y0 > ax.get_window_extent().y1


def test_poses_at_rest_are_plotted_over_their_number(arm):
    rest = replace(samples_of(arm, np.zeros((7, 2))), time=np.zeros(7))
    assert error_plot(rest, 0.0).course_name == "pose"
    assert list(inset_cards(rest, (1280, 720), 0.0, 1e5, 0.0)) == ["left", "right"]


def test_a_card_has_an_edge_that_shows_on_a_pale_floor(arm):
    panel = inset_cards(spiral(arm), (1280, 720), 0.01, 1e5, 0.0)["left"]
    picture = np.full((720, 1280, 3), 245, np.uint8)
    panel.write(picture, 0.2, "left")
    rows, columns = np.nonzero(np.any(picture != 245, axis=2))
    frame = picture[rows.min() : rows.max() + 1, columns.min() : columns.max() + 1]
    for line in (frame[0], frame[-1], frame[:, 0], frame[:, -1]):
        assert line.max() < 170


# --- Films without the scene.


@pytest.mark.gl
def test_a_cut_out_looks_on_any_ground_as_if_it_were_drawn_there(gl, arm):
    """Opaque where the arm is, clear where nothing is, between at its edges; no floor, sky or shadow."""
    (picture,) = film(spiral(arm), [40], Look(640, 360, transparent=True).plain())
    assert picture.shape == (360, 640, 4)
    opacity = picture[..., 3]
    assert (opacity == 0).mean() > 0.7
    assert (opacity == 255).mean() > 0.02
    edges = (opacity > 0) & (opacity < 255)
    assert 0 < edges.mean() < 0.05
    assert not opacity[:, :40].any()
    assert not opacity[:5].any()
    (scene,) = film(spiral(arm), [40], Look(640, 360).plain())
    inside = opacity == 255
    assert np.median(np.abs(scene[inside].astype(int) - picture[inside][:, :3]).max(axis=1)) <= 3


@pytest.mark.gl
def test_plain_is_the_arm_alone(gl, arm):
    look = Look(640, 360)
    (with_all,), (plain,) = film(spiral(arm), [40], look), film(spiral(arm), [40], look.plain())
    assert np.all(with_all[1, 2] == PAPER)
    assert not np.all(plain[1, 2] == PAPER)
    for picture, there in ((with_all, True), (plain, False)):  # the triad's green
        green = (picture[..., 1] > 120) & (picture[..., 0] < 80) & (picture[..., 2] < 90)
        assert green[60:250].any() == there


def decoded(path, size):
    """Frames of a film with their opacity, shape (T, height, width, 4)."""
    decoder = ["-c:v", "libvpx-vp9"] if path.suffix == ".webm" else []  # the built-in one drops opacity
    command = [encoder(), *decoder, "-i", str(path), "-f", "rawvideo", "-pix_fmt", "rgba", "-"]
    done = subprocess.run(command, capture_output=True, check=True)
    return np.frombuffer(done.stdout, np.uint8).reshape(-1, size[1], size[0], 4), done.stderr.decode()


@pytest.mark.parametrize(("ending", "said"), [(".mov", "prores"), (".webm", "vp9")])
def test_prores_and_vp9_keep_opacity_and_colours(tmp_path, ending, said):
    try:
        program = encoder(CODECS[ending].name)
    except EncodingError as error:
        pytest.skip(str(error))
    frame = np.zeros((120, 160, 4), np.uint8)
    frame[:, 80:] = (200, 60, 40, 255)
    frame[:60, :80] = (40, 60, 200, 128)
    with encoding(program, tmp_path / f"v{ending}", (120, 160), 30, transparent=True) as add:
        for _ in range(5):
            add(frame)
    frames, about = decoded(tmp_path / f"v{ending}", (160, 120))
    assert said in about
    assert len(frames) == 5
    for rows, columns in ((slice(10, 110), slice(90, 150)), (slice(10, 50), slice(10, 70))):
        differs = frames[2, rows, columns].astype(int) - frame[rows, columns]
        assert np.abs(differs).max() <= 8
    assert frames[2, 70:110, 10:70, 3].max() <= 2


def test_films_say_their_colours(tmp_path):
    """Red stays the red that was drawn: players take untagged films of 720 rows for another matrix."""
    frame = np.full((720, 1280, 3), (214, 39, 40), np.uint8)
    with encoding(encoder(), tmp_path / "v.mp4", (720, 1280), 30) as add:
        add(frame)
    frames, about = decoded(tmp_path / "v.mp4", (1280, 720))
    assert "bt709" in about
    assert np.abs(frames[0, ..., :3].astype(int) - frame).max() <= 3


@pytest.mark.gl
def test_pictures_and_stills_may_be_transparent(gl, arm, tmp_path):
    shot = Shot(spiral(arm), Look(160, 120, transparent=True), fps=10)
    write_pictures(shot, tmp_path)
    names = sorted(os.listdir(tmp_path))
    assert names == [f"frame-{i:05d}.png" for i in range(1, 7)]
    write_still(shot, tmp_path / "still.png", 0.2)
    write_webp(shot, tmp_path / "film.webp")
    for name in (names[0], "still.png", "film.webp"):
        with Image.open(tmp_path / name) as picture:
            assert picture.mode == "RGBA"
            assert picture.getextrema()[3] == (0, 255)


@pytest.mark.parametrize(("write", "name"), [(write_video, "v.mp4"), (write_gif, "v.gif")])
def test_what_cannot_be_transparent_is_refused(arm, tmp_path, write, name):
    with pytest.raises(InputError, match="transparent"):
        write(Shot(spiral(arm), Look(160, 120, transparent=True)), tmp_path / name)
    assert os.listdir(tmp_path) == []


def test_an_encoder_without_the_codec_is_said(monkeypatch):
    with pytest.raises(EncodingError, match="no video encoder with no_such") as caught:
        encoder("no_such")
    assert "\n" not in str(caught.value)


# --- The command.


@pytest.fixture(scope="module")
def run_folder(tmp_path_factory):
    from contarm_sim.model.arm_file import arm_to_toml

    folder = tmp_path_factory.mktemp("run")
    spiral(Arm()).save(folder / "trajectory.npz")
    (folder / "arm.toml").write_text(arm_to_toml(Arm()))
    return folder


@pytest.mark.gl
def test_render_takes_sizes_in_pixels_and_writes_folders(gl, contarm, run_folder, tmp_path):
    code, out, err = contarm(
        "render", run_folder, "--size", "200x150", "--fps", 10, "--plain", "--transparent", "--out", "frames/", "--json"
    )  # fmt: skip
    assert code == 0, err
    assert json.loads(out) == {"file": "frames", "width": 200, "height": 150, "frames": 6, "fps": 10.0}
    assert len(os.listdir(tmp_path / "frames")) == 6
    with Image.open(tmp_path / "frames/frame-00001.png") as picture:
        assert (picture.size, picture.mode) == ((200, 150), "RGBA")
    assert contarm("render", run_folder, "--out", "frames/")[0] == 2  # taken


@pytest.mark.parametrize("size", ["1080", "20x20", "1280x", "axb", "9000x9000", "-5x80"])
def test_impossible_sizes_are_one_line(contarm, run_folder, size):
    code, _, err = contarm("render", run_folder, "--size", size)
    assert code == 2
    assert "WIDTHxHEIGHT" in err
    assert err.count("\n") == 1


# --- Films that cannot go on.


def encoders_of(pid):
    """Process ids of the ffmpegs that a process has started."""
    found = []
    for entry in Path("/proc").glob("[0-9]*/stat"):
        try:
            name, rest = entry.read_text().rsplit(")", 1)
        except OSError:
            continue
        if "ffmpeg" in name and int(rest.split()[1]) == pid:
            found.append(int(entry.parent.name))
    return found


@pytest.mark.skipif(not Path("/proc/self/stat").exists(), reason="no /proc to find the encoder in")
def test_an_encoder_that_is_killed_is_said_and_leaves_nothing(tmp_path):
    def film_and_kill():
        with encoding(encoder(), tmp_path / "v.mp4", (720, 1280), 30) as add:
            (process,) = encoders_of(os.getpid())
            os.kill(process, signal.SIGKILL)
            for _ in range(50):
                add(np.zeros((720, 1280, 3), np.uint8))
                time.sleep(0.01)

    with pytest.raises(EncodingError, match="the video encoder failed: ended by SIGKILL"):
        film_and_kill()
    assert encoders_of(os.getpid()) == []


FAILURES = {
    "encoder": (EncodingError("the video encoder failed: ended by SIGKILL"), "ended by SIGKILL"),
    "gl": (RenderingError("nothing to draw with"), "nothing to draw with"),
    "disk": (OSError(28, "No space left on device"), "cannot write: No space left on device"),
    "memory": (MemoryError(), "MemoryError"),
}


@pytest.mark.parametrize("kind", FAILURES)
@pytest.mark.usefixtures("blank_figures")
def test_a_film_that_fails_leaves_the_rest_and_says_why(contarm, monkeypatch, tmp_path, kind):
    from contarm_sim.view.rendering import video

    error, said = FAILURES[kind]

    def failing(*given):
        raise error

    monkeypatch.setattr(video, "write_video", failing)
    code, out, err = contarm("run", "--duration", 1, "--turns", 0.2, "--out", "r", "--json")
    assert code in (0, 1), err
    lines = [line for line in err.splitlines() if line.startswith("no video")]
    assert len(lines) == 1
    assert said in lines[0]
    assert lines[0].endswith("contarm render r")
    names = set(os.listdir(tmp_path / "r"))
    assert {"summary.json", "samples.csv", "trajectory.npz", "path.png", "report.html"} <= names
    assert not any(name.startswith((".", "video")) for name in names)
    for text in (out, (tmp_path / "r/summary.json").read_text()):
        assert json.loads(text)["video"].startswith("none: ")
        assert said in json.loads(text)["video"]
    assert said in (tmp_path / "r/report.html").read_text()


@pytest.mark.gl
def test_a_gl_library_that_fails_is_said_in_one_line(gl, arm, monkeypatch):
    import mujoco

    def failing(*given):
        raise mujoco.FatalError("the context is lost\nreally")

    with ArmRenderer(arm, 40, 30) as renderer:
        monkeypatch.setattr(mujoco, "mjr_render", failing)
        with pytest.raises(RenderingError, match="the GL library failed: the context is lost really"):
            renderer.pose(renderer.bent(np.zeros(2)))


@pytest.mark.usefixtures("blank_figures")
def test_a_fault_while_filming_shows_as_one_and_leaves_the_rest(contarm, monkeypatch, tmp_path):
    from contarm_sim.view.rendering import video

    def wrong(*given):
        raise TypeError("a fault of ours")

    monkeypatch.setattr(video, "write_video", wrong)
    with pytest.raises(TypeError, match="a fault of ours") as found:
        contarm("run", "--duration", 1, "--turns", 0.2, "--out", "r")
    assert found.value.__notes__ == ["Numbers, figures and report.html are whole: r"]
    names = set(os.listdir(tmp_path / "r"))
    assert {"summary.json", "samples.csv", "trajectory.npz", "path.png", "report.html"} <= names
    assert not any(name.startswith((".", "video")) for name in names)


@pytest.mark.usefixtures("blank_figures")
def test_a_figure_that_cannot_be_written_leaves_the_others(contarm, monkeypatch, tmp_path):
    from contarm_sim.view import style

    write = style.write  # blank pictures

    def full(sheet, path):
        if "budget" in path.name:
            raise OSError(28, "No space left on device")
        write(sheet, path)

    monkeypatch.setattr(style, "write", full)
    code, _, err = contarm("run", "--duration", 1, "--turns", 0.2, "--no-video", "--out", "r")
    assert code == 1
    assert "no budget.png: cannot write: No space left on device" in err
    assert "no path.png" not in err
    assert {file.name for file in (tmp_path / "r").glob("*.png")} == {"path.png", "muscles.png"}
    assert "The figure budget was not drawn" in (tmp_path / "r/report.html").read_text()


def test_a_disk_that_fills_up_while_drawing_keeps_the_numbers(contarm, monkeypatch, tmp_path):
    from contarm_sim.view import style
    from contarm_sim.view.report.run import RunReport

    def full(*given):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(style, "write", full)
    monkeypatch.setattr(RunReport, "write_page", full)
    code, _, err = contarm("run", "--duration", 1, "--turns", 0.2, "--no-video", "--out", "r")
    assert code == 1
    for name in ("path.png", "budget.png", "muscles.png"):
        assert f"no {name}: cannot write: No space left on device" in err
    assert "no report.html: cannot write: No space left on device" in err
    assert "Traceback" not in err
    assert set(os.listdir(tmp_path / "r")) == {"summary.json", "samples.csv", "trajectory.npz", "arm.xml", "arm.toml"}


def test_sizes_and_rates_unless_given_are_the_same_for_all_ways_to_film():
    from contarm_sim.cli.render import render
    from contarm_sim.view.rendering.formats import SIZES, USUAL, usual_fps

    default = next(each.default for each in render.params if each.name == "size")
    assert SIZES[default] == SIZES[USUAL] == (Look().width, Look().height)
    assert Shot(spiral(Arm()), Look()).fps == usual_fps(".mp4", True)
    given = [usual_fps(".gif", True), usual_fps(".webp", True), usual_fps(".gif", False), usual_fps(".mp4", True, True)]
    assert given == [15.0, 15.0, 2.0, 20.0]
