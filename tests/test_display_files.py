"""Films and reports of a trajectory as values, and as files that are opened again."""

import base64
import re
import shutil
import subprocess
import sys

import numpy as np
import pytest
from references import along, resting

import contarm_sim
from contarm_sim.errors import InputError, RenderingError
from contarm_sim.model.arm import Arm
from contarm_sim.motion.rest import poses_at_rest
from contarm_sim.motion.simulate import simulate
from contarm_sim.view.notebook import films
from contarm_sim.view.rendering.gl import choose_backend

ARM = Arm(links=8, gravity=(0.0, 0.0, 9.81))
SMALL = {"size": (160, 120), "fps": 5}


@pytest.fixture(scope="session")
def gl():
    try:
        return choose_backend()
    except RenderingError as error:
        pytest.skip(str(error))


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
        {"size": (161, 120)}, {"transparent": True},
    ):  # fmt: skip
        with pytest.raises(InputError):
            run.film(**given)
    with pytest.raises(InputError):
        run.first(0).film()
    assert not list(tmp_path.iterdir())


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
    with pytest.raises(InputError, match="name"):
        run.report(name=3)
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


def test_it_opens_without_the_engine(folder):
    program = (
        f"import sys, contarm_sim; print(len(contarm_sim.load({str(folder)!r})), "
        "[name for name in sys.modules if name.startswith(('mujoco', 'matplotlib'))])"
    )
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    assert done.stdout.split(maxsplit=1)[1].strip() == "[]"
