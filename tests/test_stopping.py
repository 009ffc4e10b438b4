"""Ctrl-C, SIGTERM and SIGHUP: what was recorded is kept, what is half drawn goes, and nothing hidden is left."""

import json
import os
import signal
import subprocess
import sys
import time
import weakref
from contextlib import suppress
from pathlib import Path

import numpy as np
import pytest
from waiting import PATIENCE, wait_for

from contarm_sim.errors import InputError
from contarm_sim.files import appearing, remove_leftovers, write_whole
from contarm_sim.stopping import SIGNALS, break_off, breakable, came, exit_code, listening, unbroken
from contarm_sim.view.report.output import check_output, output_file

NUMBERS = {"summary.json", "samples.csv", "trajectory.npz", "arm.xml", "arm.toml"}
FIGURES = {"path.png", "budget.png", "muscles.png"}
RUN = ["run", "--duration", "1", "--turns", "0.2", "--out", "r"]


def test_a_signal_waits_for_an_unbroken_block_and_not_for_a_breakable_part():
    done = []

    def whole():
        with unbroken():
            with unbroken():
                signal.raise_signal(signal.SIGTERM)
                done.append("inner")
            done.append("outer")

    def in_parts():
        with breakable():
            signal.raise_signal(signal.SIGHUP)
            done.append("never")

    with listening():
        with pytest.raises(KeyboardInterrupt):
            whole()
        with unbroken():
            with pytest.raises(KeyboardInterrupt):
                in_parts()
            signal.raise_signal(signal.SIGHUP)
            with pytest.raises(KeyboardInterrupt):
                break_off()
        assert (came(), exit_code()) == (signal.SIGTERM, 143)  # the first
    assert done == ["inner", "outer"]
    assert came() is None


def test_a_signal_that_the_process_ignores_stays_ignored():
    before = signal.signal(signal.SIGHUP, signal.SIG_IGN)  # as nohup does
    try:
        with listening():
            signal.raise_signal(signal.SIGHUP)
            assert came() is None
        assert signal.getsignal(signal.SIGHUP) is signal.SIG_IGN
    finally:
        signal.signal(signal.SIGHUP, before)


def test_an_interruption_that_python_swallows_comes_again():
    class Thing:
        def __del__(self):
            signal.raise_signal(signal.SIGINT)

    with listening():
        Thing()
        with pytest.raises(KeyboardInterrupt):
            time.sleep(5)


PLACES = {
    "view.report.run_figures.draw_path": NUMBERS,
    "view.report.run_figures.draw_muscles": NUMBERS | {"path.png", "budget.png"},
    "view.report.page.space": NUMBERS | FIGURES,
    "view.report.run.RunReport.film": NUMBERS | FIGURES | {"report.html"},
}


@pytest.mark.parametrize(
    ("place", "number"), [*((place, signal.SIGINT) for place in PLACES), *((list(PLACES)[1], n) for n in SIGNALS[1:])]
)
@pytest.mark.usefixtures("blank_figures")
def test_numbers_are_whole_before_anything_is_drawn(contarm, monkeypatch, tmp_path, place, number):
    parts = place.split(".")
    module = "contarm_sim." + ".".join(parts[:3])
    if parts[2] == "run_figures":
        module = "contarm_sim.view.report.run"

    def stop(*given):
        if isinstance(given[0], Path):
            given[0].write_text("half a picture")
        signal.raise_signal(number)

    monkeypatch.setattr(f"{module}.{'.'.join(parts[3:])}", stop)
    code, out, err = contarm(*RUN, "--json")
    assert code == 128 + number
    assert os.listdir(tmp_path) == ["r"]
    assert set(os.listdir(tmp_path / "r")) == PLACES[place]
    summary = json.loads((tmp_path / "r/summary.json").read_text())
    assert summary == json.loads(out)
    assert (summary["video"], summary["interrupted"]) == ("interrupted", False)
    assert len(np.load(tmp_path / "r/trajectory.npz")["time"]) == 101
    said = err.splitlines()[-1]
    assert "missing" in said
    assert said.endswith("contarm render r")
    missing = {"video.mp4", "report.html", *FIGURES} - PLACES[place]
    assert all((name in said) is (name in missing) for name in {"video.mp4", "report.html", *FIGURES})


@pytest.mark.parametrize("words", ["run --duration 1 --turns 0.2 --out s", "render r --out r.mp4"])
@pytest.mark.usefixtures("blank_figures")
def test_an_interruption_that_a_library_takes_for_a_failure_is_one(contarm, monkeypatch, tmp_path, words):
    from contarm_sim.errors import RenderingError
    from contarm_sim.view.rendering import video

    def failing(*given):
        with suppress(KeyboardInterrupt):
            signal.raise_signal(signal.SIGTERM)
        raise RenderingError("nothing to draw with: tried egl (argument 1: KeyboardInterrupt)")

    assert contarm(*RUN, "--no-video")[0] in (0, 1)
    monkeypatch.setattr(video, "write_video", failing)
    monkeypatch.setitem(video.WRITERS, ".mp4", failing)
    code, _, err = contarm(*words.split())
    assert code == 143
    assert "nothing to draw with" not in err
    assert ("video.mp4 is missing" in err) is (words.startswith("run"))


def test_a_signal_while_numbers_are_written_waits_for_them(contarm, monkeypatch, tmp_path):
    from contarm_sim.results.trajectory import Trajectory

    save = Trajectory.save

    def stopped(self, path):
        signal.raise_signal(signal.SIGTERM)
        save(self, path)

    monkeypatch.setattr(Trajectory, "save", stopped)
    code, _, err = contarm(*RUN, "--no-video")
    assert (code, set(os.listdir(tmp_path / "r"))) == (143, NUMBERS)
    assert json.loads((tmp_path / "r/summary.json").read_text())["video"] == "not asked for"
    assert "path.png, budget.png, muscles.png, report.html are missing" in err


@pytest.mark.parametrize("number", SIGNALS)
@pytest.mark.usefixtures("blank_figures")
def test_a_stopped_recording_is_kept_to_where_it_came(contarm, monkeypatch, tmp_path, number):
    from contarm_sim.control.servo import LengthFeedback

    update, came = LengthFeedback.update, []

    def stopped(self, index, *given, **named):
        if index == 50 and not came:
            came.append(index)
            signal.raise_signal(number)
        return update(self, index, *given, **named)

    monkeypatch.setattr(LengthFeedback, "update", stopped)
    code, _, err = contarm(*RUN)
    assert code == 128 + number
    assert err.index("interrupted: what was recorded is") < err.index("written: r") < err.index("interrupted at 0.50 s")
    assert set(os.listdir(tmp_path / "r")) == NUMBERS | FIGURES | {"report.html"}
    assert len(np.load(tmp_path / "r/trajectory.npz")["time"]) == 51
    summary = json.loads((tmp_path / "r/summary.json").read_text())
    assert (summary["verdict"], summary["video"]) == ("interrupted", "interrupted")


@pytest.mark.parametrize("number", SIGNALS)
@pytest.mark.parametrize(
    "words", ["validate --quick --out v", "figures fan --figures png --out f", "muscle --out m.png"]
)
def test_other_commands_leave_nothing_and_say_one_line(contarm, monkeypatch, tmp_path, number, words):
    from matplotlib.figure import Figure

    import contarm_sim.view.report.validation as written

    monkeypatch.setattr(Figure, "savefig", lambda *given, **kinds: signal.raise_signal(number))
    monkeypatch.setattr(written, "write_samples", lambda *given: signal.raise_signal(number))
    code, out, err = contarm(*words.split())
    assert (code, out) == (128 + number, "")
    said = "interrupted" if number == signal.SIGINT else f"ended by {number.name}"
    assert err.splitlines()[-1] == f"contarm: {said}"
    assert os.listdir(tmp_path) == []


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGINT, signal.SIGHUP])
def test_stopped_while_filming_the_numbers_stay(tmp_path, number):
    """A real signal to a real process."""
    words = [sys.executable, "-m", "contarm_sim", "run", "--duration", "8", "--turns", "1", "--out", "stopped"]
    process = subprocess.Popen(words, cwd=tmp_path, stderr=subprocess.PIPE, stdout=subprocess.DEVNULL, text=True)
    wait_for(lambda: process.poll() is not None or (tmp_path / "stopped/report.html").exists())
    time.sleep(0.5)  # filming by now
    process.send_signal(number)
    _, err = process.communicate(timeout=PATIENCE)
    assert "Traceback" not in err
    assert process.returncode == 128 + number, err
    assert os.listdir(tmp_path) == ["stopped"]
    assert set(os.listdir(tmp_path / "stopped")) == NUMBERS | FIGURES | {"report.html"}
    assert json.loads((tmp_path / "stopped/summary.json").read_text())["video"] == "interrupted"


def test_a_file_appears_whole_with_the_permissions_of_any_other_and_follows_no_link(tmp_path):
    (tmp_path / "other").write_text("precious")
    (tmp_path / ".a.csv.part").symlink_to("other")
    before = os.umask(0o027)
    try:
        (tmp_path / "plain").write_text("")
        write_whole(tmp_path / "a.csv", "new")
    finally:
        os.umask(before)
    assert (tmp_path / "other").read_text() == "precious"
    assert (tmp_path / "a.csv").stat().st_mode == (tmp_path / "plain").stat().st_mode

    def broken_off():
        with appearing(tmp_path / "a.csv") as scratch:
            assert scratch.suffix == ".csv"
            scratch.write_text("half")
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        broken_off()
    assert (tmp_path / "a.csv").read_text() == "new"
    assert sorted(os.listdir(tmp_path)) == [".a.csv.part", "a.csv", "other", "plain"]


@pytest.mark.parametrize("words", ["ik --tip 0.2355 0 0.2355 --out a.svg", "muscle --out a.svg"])
def test_a_link_laid_for_the_scratch_file_is_not_followed(contarm, tmp_path, words):
    (tmp_path / "precious").write_text("precious")
    (tmp_path / ".a.svg.part").symlink_to("precious")
    code, _, err = contarm(*words.split())
    assert code == 0, err
    assert (tmp_path / "precious").read_text() == "precious"
    assert not (tmp_path / "a.svg").is_symlink()
    assert sorted(os.listdir(tmp_path)) == [".a.svg.part", "a.svg", "precious"]


def test_what_killed_processes_left_goes_at_the_next_start(tmp_path):
    """Scratch folders and files of the dead go, those of the living and everybody's own files stay."""
    program = (
        "import sys, time; from pathlib import Path; from contarm_sim.files import appearing\n"
        "from contarm_sim.view.report.output import OutputFolder\n"
        "with OutputFolder(Path('run')) as opened, appearing(Path('a.csv')):\n"
        "    (opened.folder / 'half').write_text('x'); print('ready', flush=True); time.sleep(60)"
    )
    processes = [subprocess.Popen([sys.executable, "-c", program], cwd=tmp_path, stdout=subprocess.PIPE) for _ in "12"]
    for process in processes:
        process.stdout.readline()
    (tmp_path / ".mine.contarm-notes").write_text("precious")
    left = set(os.listdir(tmp_path))
    assert len(left) == 5
    processes[0].kill()
    processes[0].wait()
    for name in left:
        os.utime(tmp_path / name, (0, 0))
    remove_leftovers(tmp_path)
    stayed = set(os.listdir(tmp_path))
    assert len(stayed) == 3
    assert ".mine.contarm-notes" in stayed
    processes[1].kill()
    processes[1].wait()
    check_output(tmp_path / "new")
    assert os.listdir(tmp_path) == [".mine.contarm-notes"]
    for process in processes:
        process.stdout.close()


def test_of_two_that_write_one_name_one_is_told(tmp_path):
    def write(text, inner=None):
        with output_file(tmp_path / "a.csv") as scratch:
            scratch.write_text(text)
            if inner is not None:
                write(inner)

    with pytest.raises(InputError, match="another process has written"):
        write("second", "first")
    assert (tmp_path / "a.csv").read_text() == "first"
    assert os.listdir(tmp_path) == ["a.csv"]


def test_an_interruption_in_a_callback_of_a_weak_reference_comes_again():
    class Thing:
        pass

    thing = Thing()
    held = weakref.ref(thing, lambda _: signal.raise_signal(signal.SIGINT))
    with listening():
        del thing
        with pytest.raises(KeyboardInterrupt):
            time.sleep(5)
    assert held() is None
