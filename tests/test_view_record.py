"""What the live page records: samples, the folder, and that nothing is lost."""

import json
import re
import signal
import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest
from test_view_guard import Visitor
from waiting import PATIENCE

from contarm_sim.kinematics import arc
from contarm_sim.model import presets
from contarm_sim.model.arm import Arm
from contarm_sim.results.compare import compare
from contarm_sim.results.trajectory import Trajectory
from contarm_sim.view.live import recording
from contarm_sim.view.live.session import Session

WHOLE = {
    "arm.toml", "arm.xml", "budget.png", "muscles.png", "path.png", "report.html", "samples.csv", "summary.json",
    "trajectory.npz",
}  # fmt: skip


@pytest.mark.parametrize("controller", ["servo", "pressure"])
@pytest.mark.parametrize("make", [presets.paper, presets.two])
def test_a_recording_is_the_motion_that_was_seen(make, controller, monkeypatch):
    monkeypatch.setattr(recording, "_BLOCK", 40)  # more than one
    session = Session(make(), controller)
    session.aim(np.tile([0.5, 0.3], len(session.arm.sections)))
    for _ in range(20):
        session.tick()
    session.record()
    seen = [session.tick() for _ in range(100)]
    run = session.recording.trajectory()
    assert (len(run), run.controller, run.status, run.arm) == (100, controller, "finished", session.arm)
    np.testing.assert_allclose(run.time, 0.01 * np.arange(100), atol=1e-12)
    np.testing.assert_array_equal(run.tip, [reading.tip for reading in seen])
    np.testing.assert_array_equal(run.bend, [reading.bend for reading in seen])
    np.testing.assert_allclose(run.muscle_tensions, [reading.tensions for reading in seen], rtol=1e-9, atol=1e-9)
    np.testing.assert_allclose(compare(run).tip_error, [reading.error for reading in seen], atol=1e-12)


def test_a_recording_ends_with_what_it_is_of(monkeypatch):
    session = Session(Arm())
    loaded = replace(Arm(), payload=0.05)
    changes = (
        lambda: session.change(arm=loaded),
        lambda: session.change(controller="tip"),
        session.reset,
        lambda: session.restart(presets.two()),
    )
    for change in changes:
        session.record()
        session.tick()
        session.tick()
        change()
        session.tick()
        assert session.recording.ended
        assert len(session.recording.trajectory()) == 2
    monkeypatch.setattr(recording, "LONGEST", 0.1)
    session.record()
    for _ in range(20):
        session.tick()
    assert session.recording.ended
    assert session.recording.duration == pytest.approx(0.1)


def test_one_tick_is_no_recording():
    session = Session(Arm())
    session.record()
    session.tick()
    assert session.recording.trajectory() is None


def _recorded(status):
    """Return how long it has been recording [s], as the page says; -1 if it does not."""
    found = re.search(r"recording, ([\d.]+)", status)
    return float(found.group(1).rstrip(".")) if found else -1.0


def test_the_record_button_leaves_a_folder_and_ctrl_c_loses_nothing(tmp_path):
    command = [sys.executable, "-m", "contarm_sim", "view", "--json", "--payload", "0.02"]
    process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, cwd=tmp_path)
    try:
        said = ""
        while not said.endswith("}\n"):
            said += process.stdout.readline()
        with Visitor(int(json.loads(said)["url"].rsplit(":", 1)[1])) as visitor:
            for ended in ("by hand", "by Ctrl-C"):
                visitor.set("Record", value=True)
                visitor.wait(lambda: _recorded(visitor.status) >= 0)
                visitor.set("payload [g]", value=100)  # is not taken while it records
                visitor.set("bend angle [deg]", value=40)
                begun = _recorded(visitor.status)
                visitor.wait(lambda begun=begun: _recorded(visitor.status) >= begun + 2)
                if ended == "by hand":
                    visitor.set("Record", value=True)
                    before = visitor.time
                    visitor.wait(lambda: "report.html" in visitor.status)
                    assert visitor.time > before  # the arm went on meanwhile
                    visitor.set("bend angle [deg]", value=0)
        process.send_signal(signal.SIGINT)
        _, err = process.communicate(timeout=PATIENCE)
    finally:
        process.kill()
        process.communicate()
    assert process.returncode == 0, err
    folders = sorted((tmp_path / "runs").iterdir())
    assert len(folders) == 2
    assert err.splitlines()[-1] == "ended"
    for folder in folders:
        assert {path.name for path in folder.iterdir()} == WHOLE
        run, summary = Trajectory.load(folder / "trajectory.npz"), json.loads((folder / "summary.json").read_text())
        assert run.arm == Arm(payload=0.02)
        assert np.degrees(arc.to_polar(run.bend[-1])[0]) > 5
        assert summary["command"] == "contarm view --json --payload 0.02"
        assert summary["duration"] == run.time[-1] > 0.9
        assert f"drawn: runs/{folder.name}" in err


def test_a_recording_that_cannot_be_written_is_said_on_the_page(tmp_path):
    (tmp_path / "runs").write_text("a file in the way")
    process = subprocess.Popen(
        [sys.executable, "-m", "contarm_sim", "view", "--json"], stdout=subprocess.PIPE, stderr=subprocess.DEVNULL,
        text=True, cwd=tmp_path,
    )  # fmt: skip
    try:
        said = ""
        while not said.endswith("}\n"):
            said += process.stdout.readline()
        with Visitor(int(json.loads(said)["url"].rsplit(":", 1)[1])) as visitor:
            visitor.set("Record", value=True)
            visitor.wait(lambda: "recording, 0." in visitor.status)
            visitor.set("Record", value=True)
            visitor.wait(lambda: "out is" in visitor.status)
            visitor.goes_on()
    finally:
        process.kill()
        process.communicate()
