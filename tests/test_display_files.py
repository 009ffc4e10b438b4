"""Films and reports of a trajectory as values, and as files that are opened again."""

import base64
import re
import shutil
import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest
from references import along, resting

import contarm_sim
from contarm_sim.errors import InputError
from contarm_sim.model.arm import Arm
from contarm_sim.motion.rest import poses_at_rest
from contarm_sim.motion.simulate import simulate
from contarm_sim.view.notebook import films, places

ARM = Arm(links=8, gravity=(0.0, 0.0, 9.81))
SMALL = {"size": (160, 120), "fps": 5}


@pytest.fixture(scope="module")
def run():
    return simulate(ARM, along(ARM, "circle", 1.0, max_bend=0.8), "chain")


@pytest.fixture(scope="module")
def folder(run, tmp_path_factory):
    folder = tmp_path_factory.mktemp("reports") / "run"
    run.report(folder, name="circle <b>")
    return folder


def _embedded(page):
    kind, data = re.search(r'src="data:(\w+/\w+);base64,([A-Za-z0-9+/=]+)"', page).groups()
    return kind, base64.b64decode(data)


@pytest.mark.gl
def test_a_film_is_shown_and_written(gl, run, tmp_path):
    film = run.film(tmp_path / "a.mp4", **SMALL)
    assert (tmp_path / "a.mp4").read_bytes() == film.content
    kind, shown = _embedded(film._repr_html_())
    assert (kind, shown) == ("video/mp4", film.content)
    assert b"ftyp" in shown[:16]
    assert film.seconds == pytest.approx(6 / 5)
    assert repr(film).startswith("Film(160 x 120, 1.2 s, ")
    film.save(tmp_path / "b.mp4")
    assert (tmp_path / "b.mp4").read_bytes() == film.content
    for bad in ("b.gif", "none/b.mp4"):
        with pytest.raises(InputError, match="path"):
            film.save(tmp_path / bad)


@pytest.mark.gl
def test_a_film_without_a_file_is_left_nowhere(gl, run, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    seen = []
    film = run.film(speed=2, camera="orbit", on_frame=lambda done, total: seen.append((done, total)), **SMALL)
    assert film.path is None
    assert seen[-1] == (3, 3)
    assert not list(tmp_path.iterdir())


@pytest.mark.gl
def test_what_is_embedded_is_bounded(gl, run, tmp_path, monkeypatch):
    monkeypatch.setattr(films, "LARGEST", 6000)
    moving = run.film(tmp_path / "a.gif", **SMALL)
    assert len(moving.content) > 6000
    assert "too large" in moving._repr_html_()
    monkeypatch.setattr(films, "LARGEST", 60_000)
    large = run.film(size=(640, 480), fps=5, speed=0.2)
    assert len(large.content) > 60_000
    assert len(large.shown[1]) <= 60_000
    assert len(large._repr_html_()) < 85_000


@pytest.mark.gl
def test_a_film_for_editors_is_shown_as_one_for_browsers(gl, run, tmp_path):
    film = run.film(tmp_path / "a.mov", plain=True, transparent=True, **SMALL)
    kind, shown = _embedded(film._repr_html_())
    assert (kind, len(shown) < len(film.content)) == ("video/mp4", True)
    assert poses_at_rest(ARM, resting(ARM, np.array([[0.5, 0.2]] * 3))).film(size=(160, 120)).seconds == 1.5


@pytest.mark.gl
def test_films_that_cannot_be_are_refused_and_leave_nothing(gl, run, tmp_path):
    for given in (
        {"path": tmp_path / "a.avi"}, {"path": tmp_path / "none" / "a.mp4"}, {"path": 3}, {"path": "a\0b.mp4"},
        {"size": 3}, {"size": (160, "a")},
        {"size": "big"}, {"fps": -1}, {"fps": "x"}, {"speed": 0}, {"speed": 1e-6, "fps": 1000}, {"camera": "x"},
        {"size": (161, 120)}, {"transparent": True}, {"on_frame": 3}, {"plots": "x"}, {"transparent": 1},
        {"size": (16, 16)}, {"size": (99_999, 99_999)}, {"fps": 1e6}, {"path": "/proc/a.mp4"},
        {"path": "x" * 5000 + ".mp4"}, {"path": "~nobody-here/a.mp4"},
    ):  # fmt: skip
        with pytest.raises(InputError):
            run.film(**given)
    with pytest.raises(InputError):
        run.first(0).film()
    assert not list(tmp_path.iterdir())


def test_refusals_of_films_name_what_was_given_and_what_would_do(run, tmp_path):
    for given, said in (
        ({"transparent": True}, "transparent is True for a film without a file, a .mp4; allowed: .*webm"),
        ({"transparent": True, "path": tmp_path / "a.mp4"}, "transparent is True for a .mp4; allowed: .*webm"),
        ({"fps": 1e6}, "fps is 1e.06, which makes"),
        ({"size": (16, 16)}, r"size is \(16, 16\); allowed: at least 96 pixels"),
        ({"size": (99_999, 99_999)}, "at most 16384 pixels"),
        ({"plots": "x"}, "plots is 'x'; allowed: True or False"),
    ):
        with pytest.raises(InputError, match=said):
            run.film(**given)


@pytest.mark.gl
def test_names_may_have_any_case_and_begin_at_home(gl, run, tmp_path, monkeypatch):
    monkeypatch.setenv("HOME", str(tmp_path))
    monkeypatch.chdir(tmp_path)
    assert run.film("~/X.MP4", **SMALL).path == tmp_path / "X.MP4"
    run.save("~/t.npz")
    assert contarm_sim.load("~/t.npz") == run == contarm_sim.Trajectory.load("~/t.npz")
    assert sorted(file.name for file in tmp_path.iterdir()) == ["X.MP4", "t.npz"]
    for bad in (3, "~nobody-here/t.npz", "a\0.npz"):
        with pytest.raises(InputError, match="path"):
            run.save(bad)
        with pytest.raises(InputError, match="path"):
            contarm_sim.load(bad)


def test_who_waits_is_told(monkeypatch, capsys):
    monkeypatch.setattr(places, "PATIENCE", 0.0)
    monkeypatch.setattr(sys.stderr, "isatty", lambda: True)
    show = places.told(None)
    show(1, 3)
    show(3, 3)
    assert [words.strip() for words in capsys.readouterr().err.split("\r")] == [
        "",
        *["filming: 1 of 3 frames"] * 2,
        "",
        "",
    ]


@pytest.mark.usefixtures("blank_figures")
def test_a_report_of_a_stopped_motion_says_where_it_stopped(run):
    report = replace(run.first(50), status="interrupted").report()
    assert "It was stopped at 0.49\u00a0s; all numbers" in report.page
    assert "interrupted at 0.49 s" in repr(report)
    assert report.summary["duration"] is None


def test_a_report_leaves_what_a_run_leaves(run, folder):
    names = {file.name for file in folder.iterdir()}
    assert names >= {"report.html", "summary.json", "samples.csv", "trajectory.npz", "arm.xml", "arm.toml", "path.png"}
    assert contarm_sim.load(folder) == run == contarm_sim.load(str(folder / "trajectory.npz"))
    assert "circle &lt;b&gt;" in (folder / "report.html").read_text()


def test_a_report_is_shown_in_a_frame(run, folder, tmp_path):
    report = run.report()
    page = report._repr_html_()
    assert page.startswith("<iframe")
    assert "allow-same-origin" not in page  # the page can read nothing of the notebook
    assert len(page) < 3_000_000
    assert "constant curvature: " in repr(report)
    assert len(repr(report)) < 600
    report.save(tmp_path / "r.html")
    assert (tmp_path / "r.html").read_text() == report.page
    with pytest.raises(InputError, match="path"):
        report.save(tmp_path / "r.txt")


@pytest.mark.usefixtures("blank_figures")
def test_a_folder_is_filled_anew_and_never_one_that_holds_something_else(run, folder, tmp_path):
    again = tmp_path / "again"
    shutil.copytree(folder, again)
    (again / "video.mp4").write_bytes(b"of another motion")
    (again / "notes.txt").write_text("mine")
    run.first(50).report(again)
    assert not (again / "video.mp4").exists()
    assert (again / "notes.txt").read_text() == "mine"
    assert len(contarm_sim.load(again)) == 50
    taken = tmp_path / "taken"
    taken.mkdir()
    (taken / "thesis.tex").write_text("x")
    for bad in (taken, taken / "thesis.tex", taken / "thesis.tex" / "x", "a\0b", "x" * 5000, "", 3):
        with pytest.raises(InputError, match="folder"):
            run.report(bad)
    assert sorted(file.name for file in tmp_path.iterdir()) == ["again", "taken"]
    assert [file.name for file in taken.iterdir()] == ["thesis.tex"]
    assert run.report(tmp_path / "runs" / "one").folder == tmp_path / "runs" / "one"  # as `contarm run --out` makes it


def test_reports_that_cannot_be_are_refused(run, tmp_path):
    rest = poses_at_rest(ARM, resting(ARM, np.array([[0.5, 0.2]])))
    for samples in (rest, run.first(1), run.first(0)):
        with pytest.raises(InputError, match="trajectory"):
            samples.report(tmp_path / "x")
    for name, value in (("name", 3), ("film", "x.mp4"), ("on_frame", 3), ("controller", 3), ("controller", "foo")):
        with pytest.raises(InputError, match=f"^{name} is "):
            run.report(**{name: value})
    assert not list(tmp_path.iterdir())


def test_what_no_run_left_is_refused_in_one_line(folder, tmp_path):
    (tmp_path / "broken.npz").write_bytes(b"PK")
    other = tmp_path / "other"
    shutil.copytree(folder, other)
    (other / "arm.toml").write_text("links = 9\n")
    for bad in (tmp_path, tmp_path / "none", tmp_path / "broken.npz", other, "", "a\0b", "x" * 5000, 3, None):
        with pytest.raises(InputError) as error:
            contarm_sim.load(bad)
        assert len(str(error.value).splitlines()) == 1


def test_it_says_which_file_is_missing_and_that_the_folder_is_wanted(folder, tmp_path):
    with pytest.raises(InputError, match="allowed: the folder that it is in"):
        contarm_sim.load(folder / "summary.json")
    part = tmp_path / "part"
    shutil.copytree(folder, part)
    (part / "arm.toml").unlink()
    with pytest.raises(InputError, match=r"part', which has no arm\.toml"):
        contarm_sim.load(part)


def test_it_opens_without_the_engine(folder):
    program = (
        f"import sys, contarm_sim; print(len(contarm_sim.load({str(folder)!r})), "
        "[name for name in sys.modules if name.startswith(('mujoco', 'matplotlib'))])"
    )
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    assert done.stdout.split(maxsplit=1)[1].strip() == "[]"
