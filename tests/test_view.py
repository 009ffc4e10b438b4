"""The live arm: as a session, in a real browser, and in MuJoCo's own viewer."""

import json
import os
import shutil
import signal
import socket
import subprocess
import sys
from contextlib import contextmanager
from dataclasses import replace

import numpy as np
import pytest
from browser import box, browser, drag, needs_browser, open_page
from references import resting
from waiting import PATIENCE, wait_for

from contarm_sim.control.registry import NAMES
from contarm_sim.errors import InputError
from contarm_sim.kinematics import arc
from contarm_sim.kinematics.arc import LARGEST_BEND
from contarm_sim.model.arm import Arm
from contarm_sim.motion.rest import poses_at_rest
from contarm_sim.view.live.page import free_port
from contarm_sim.view.live.session import Session
from contarm_sim.view.live.surroundings import FOV, view_of
from contarm_sim.view.live.wishes import Wishes
from contarm_sim.view.sections import reachable_tips

BEND = np.array([0.9, 0.5])
SMALL = Arm(links=8)
HANGING = replace(SMALL, gravity=(0.0, 0.0, 9.81), payload=0.1)


def _ticks(session, seconds):
    return [session.tick() for _ in range(round(100 * seconds))]


@pytest.mark.parametrize("controller", ["feedforward", "servo", "pressure"])
def test_a_session_comes_to_rest_where_the_same_controller_rests(controller):
    session = Session(SMALL, controller)
    session.aim(BEND)
    reading = _ticks(session, 12)[-1]
    rest = poses_at_rest(SMALL, resting(SMALL, BEND[None]), controller)
    np.testing.assert_allclose(reading.tip, rest.stations[0, -1], atol=3e-6)
    np.testing.assert_allclose(reading.tensions, rest.muscle_tensions[0], rtol=2e-3)


def test_the_seen_tip_fed_back_beats_held_lengths_under_load():
    errors = {}
    for controller in ("servo", "tip"):
        session = Session(HANGING, controller)
        session.aim(BEND)
        errors[controller] = _ticks(session, 10)[-1].error
    assert errors["tip"] < 0.3 * errors["servo"]


def test_a_hanging_arm_under_pressure_does_not_swing_up_by_itself():
    session = Session(HANGING, "pressure")
    session.aim(BEND)
    _ticks(session, 10)
    errors = [reading.error for reading in _ticks(session, 5)]
    assert np.ptp(errors) < 1e-3


def test_every_change_of_controller_or_load_goes_on_from_the_pose_there_was(arm):
    session = Session(arm)
    session.aim(BEND)
    before = _ticks(session, 2)[-1]
    for controller in (*NAMES, *reversed(NAMES)):
        session.change(controller=controller)
        after = session.tick()
        assert np.linalg.norm(after.tip - before.tip) < 3e-3, controller
        before = _ticks(session, 0.5)[-1]
    session.change(arm=replace(arm, payload=0.1, gravity=(0.0, 0.0, 9.81)))
    assert np.linalg.norm(session.tick().tip - before.tip) < 1e-3
    assert session.plant.model.body_mass.sum() == pytest.approx(arm.mass + 0.1)


def test_what_pressures_cannot_hold_is_said_and_waited_for():
    session = Session(SMALL, "pressure")
    session.aim(arc.from_polar(LARGEST_BEND, 0.0))
    said = []
    for _ in range(400):
        reading = session.tick()
        said.append("kPa" in session.problem)
    assert all(said[said.index(True) :])  # it never flickers
    assert 2.0 < np.hypot(*reading.bend) < LARGEST_BEND
    assert reading.error < 0.02 * 0.37
    assert reading.pressures.max() <= 700e3
    session.aim(BEND)
    assert np.linalg.norm(_ticks(session, 8)[-1].bend - BEND) < 1e-3
    assert not session.problem


def test_an_arm_that_needs_shorter_steps_gets_them():
    session = Session(Arm(links=8, mass=0.1, damping_time=0.001))
    session.aim(BEND)
    reading = _ticks(session, 3)[-1]
    assert reading.time == pytest.approx(2.99, abs=0.005)
    assert reading.error < 0.02 * 0.37


def test_reset_starts_the_same_motion_again_and_what_cannot_change_is_refused(arm):
    session, tips = Session(arm), []
    for _ in range(2):
        session.aim(3 * BEND)
        assert np.hypot(*session.goal) == pytest.approx(min(LARGEST_BEND, 3 * np.hypot(*BEND)))
        tips.append([reading.tip for reading in _ticks(session, 1)])
        session.reset()
    np.testing.assert_array_equal(*tips)
    with pytest.raises(InputError, match="links"):
        session.change(arm=replace(arm, links=12))
    with pytest.raises(InputError, match="controller"):
        session.change(controller="lqr")
    assert session.controller == "servo"


def test_of_many_wishes_for_one_thing_the_last_is_kept():
    done, wishes = [], Wishes()
    actions = [lambda value, name=name: done.append((name, value)) for name in "ab"]
    for i in range(5):
        wishes.put(actions[i % 2], i)
    for wish in wishes.take():
        wish()
    assert done == [("b", 3), ("a", 4)]
    assert wishes.take() == []


def test_a_port_in_use_is_refused_and_another_is_found():
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = taken.getsockname()[1]
        with pytest.raises(InputError, match=f"port is {port}"):
            free_port(port)
    assert 8080 <= free_port(None) < 8100


@contextmanager
def _served(*words, **env):
    command = [sys.executable, "-m", "contarm_sim", "view", *words]
    process = subprocess.Popen(
        command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, env={**os.environ, **env}
    )
    try:
        yield process
    finally:
        process.kill()
        process.communicate()


def _text(page):
    """Return all that a page shows in words."""
    return page.inner_text("body")


def _time(page):
    """Return the simulated time that a page shows [s]."""
    return float(_text(page).split("t = ")[1].split(" s")[0])


def _ring(page, arm):
    """Return where a page that was just opened shows the target of a straight, upright arm [pixels]."""
    tips = reachable_tips(arm, 35, 49, LARGEST_BEND).reshape(-1, 3)
    eye, centre = view_of(arm, tips)
    forward = (centre - eye) / np.linalg.norm(centre - eye)
    right = np.cross(forward, [0.0, 0.0, 1.0])
    right /= np.linalg.norm(right)
    away = np.array([0.0, 0.0, arm.length]) - eye
    x, y, z = away @ right, away @ np.cross(right, forward), away @ forward
    box = page.locator("canvas[data-engine]").bounding_box()
    scale = 0.5 * box["height"] / np.tan(0.5 * FOV) / z
    return box["x"] + 0.5 * box["width"] + scale * x, box["y"] + 0.5 * box["height"] - scale * y


@pytest.mark.slow  # twenty seconds
@needs_browser
def test_two_browsers_steer_the_arm_and_may_leave():
    errors = []
    with _served("--json", "--port", str(free_port(None))) as process:
        said = ""
        while not said.endswith("}\n"):
            said += process.stdout.readline()
        url = json.loads(said)["url"]
        with browser() as chromium:
            first, second = open_page(chromium, url, errors, 900, 560), open_page(chromium, url, errors, 640, 400)
            for page in (first, second):
                wait_for(lambda page=page: "Tip error" in _text(page))
            ring = _ring(first, Arm())
            drag(first, ring, (ring[0] + 100, ring[1] + 40), steps=5)
            for page in (first, second):
                wait_for(lambda page=page: "bend 0" not in _text(page))
                assert "towards" in _text(page)
            second.context.close()
            started = _time(first)  # the second has left
            wait_for(lambda: _time(first) > started + 1)
            assert "0.00 mm" not in _text(first)
            first.get_by_role("button", name="Pause").click()
            wait_for(lambda: "paused" in _text(first))
            stopped = _time(first)
            first.wait_for_timeout(1000)
            assert _time(first) == stopped
            first.get_by_role("button", name="Reset").click()
            wait_for(lambda: "bend 0.0" in _text(first))
            assert _time(first) == 0
            first.get_by_role("button", name="Resume").click()
            wait_for(lambda: _time(first) > 0.5)
            for typed in ("0", "-1", "1e9"):  # into the box of the speed
                box(first, "speed").fill(typed)
                before = _time(first)
                wait_for(lambda before=before: _time(first) > before)
            assert not [error for error in errors if "passive event listener" not in error]
        process.send_signal(signal.SIGINT)
        out, err = process.communicate(timeout=PATIENCE)
        assert process.returncode == 0
        assert out == ""
        assert err.splitlines()[-1] == "ended"


def test_a_busy_port_and_a_missing_display_each_take_one_line():
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = str(taken.getsockname()[1])
        with _served("--port", port) as process:
            out, err = process.communicate(timeout=PATIENCE)
    assert (process.returncode, out) == (2, "")
    assert err == f"contarm: port is {port}; allowed: a port that is free\n"
    with _served("--native", DISPLAY="", WAYLAND_DISPLAY="") as process:
        out, err = process.communicate(timeout=PATIENCE)
    assert (process.returncode, out, err.count("\n")) == (1, "", 1)
    assert "no display" in err


@pytest.mark.skipif(not (shutil.which("Xvfb") and shutil.which("xdotool")), reason="no Xvfb or no xdotool here")
def test_the_native_viewer_bends_the_arm_by_keys(tmp_path):
    from PIL import ImageGrab

    read, write = os.pipe()
    flags = ["-displayfd", str(write), "-screen", "0", "900x600x24", "-nolisten", "tcp", "-noreset"]
    screen = subprocess.Popen(["Xvfb", *flags], pass_fds=[write], stderr=subprocess.DEVNULL)
    try:
        display = ":" + os.read(read, 16).decode().strip()

        def picture():
            return np.asarray(ImageGrab.grab(xdisplay=display)).astype(int)

        with _served("--native", DISPLAY=display) as process:
            wait_for(lambda: (picture().sum(2) > 600).mean() > 0.3)
            straight = picture()

            def bent():
                subprocess.run(["xdotool", "key", "Right"], env={**os.environ, "DISPLAY": display}, check=True)
                return (np.abs(picture() - straight)[200:].sum(2) > 60).sum() > 1000

            wait_for(bent)
            process.send_signal(signal.SIGINT)
            assert process.wait(PATIENCE) == 0
    finally:
        screen.terminate()
        screen.wait(PATIENCE)
        os.close(read)
        os.close(write)
