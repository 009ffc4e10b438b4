"""The arm in MuJoCo's own viewer, steered by keys; needs a display."""

from __future__ import annotations

import queue
import time
from typing import Any

import mujoco
import numpy as np

from contarm_sim.engine.plant import engine_room
from contarm_sim.kinematics import arc
from contarm_sim.kinematics.arc import LARGEST_BEND
from contarm_sim.mjcf import scene_spec
from contarm_sim.model.arm import Arm
from contarm_sim.view.live.session import PERIOD, Session
from contarm_sim.view.rendering.draw import GHOST, TARGET
from contarm_sim.view.rendering.overlays import add_ball, add_line, placed
from contarm_sim.view.rendering.window import window

_STEP = np.radians(5.0)
_KEYS = {262: (1.0, 0.0), 263: (-1.0, 0.0), 265: (0.0, 1.0), 264: (0.0, -1.0)}  # GLFW: right, left, up, down
_SPACE, _BACKSPACE = 32, 259
_PICTURE = 1 / 60


def show(arm: Arm, controller: str = "servo") -> None:
    """Show the arm until the window is closed, or Ctrl-C.

    Raises:
        RenderingError: there is no display, or no window can be opened on it.
    """
    session, keys = Session(arm, controller), queue.SimpleQueue[int]()
    model = scene_spec(arm).compile()
    data = mujoco.MjData(model)
    try:
        with window(model, data, keys.put) as shown, engine_room():
            shown.cam.lookat[:], shown.cam.distance = model.stat.center, 3.2 * arm.length
            shown.cam.azimuth, shown.cam.elevation = 120.0, -14.0
            _loop(session, model, data, shown, keys)
    except KeyboardInterrupt:
        pass


def _loop(session: Session, model: Any, data: Any, shown: Any, keys: queue.SimpleQueue[int]) -> None:
    """Keep in step with the clock; draw what is drawn over the model."""
    paused, due, before = False, 0.0, time.perf_counter()
    while shown.is_running():
        while not keys.empty():
            key = keys.get()
            paused = paused != (key == _SPACE)
            if key == _BACKSPACE:
                session.reset()
            elif key in _KEYS:
                session.aim(session.goal + _STEP * np.array(_KEYS[key]))
        now = time.perf_counter()
        due += 0.0 if paused else min(now - before, 0.25)
        before = now
        while due >= PERIOD:
            session.tick()
            due -= PERIOD
        with shown.lock():
            data.qpos[:], data.time = session.plant.data.qpos, session.plant.data.time
            mujoco.mj_forward(model, data)
            _draw_over(session, data, shown.user_scn)
        shown.set_texts((None, mujoco.mjtGridPos.mjGRID_TOPLEFT, *_said(session, paused)))
        shown.sync()
        time.sleep(max(0.0, _PICTURE - (time.perf_counter() - now)))


def _draw_over(session: Session, data: Any, scene: Any) -> None:
    """Draw the analytic arc, and the target on its meridian of the dome."""
    base = data.body("base")
    arm, reading = session.arm, session.reading
    scene.ngeom = 0
    add_line(scene, placed(base, arc.position(reading.bend, arm.length, np.linspace(0, 1, 33))), 6.0, GHOST)
    _, plane = arc.to_polar(reading.goal)
    meridian = arc.from_polar(np.linspace(0.0, LARGEST_BEND, 49), plane)
    add_line(scene, placed(base, arc.position(meridian, arm.length)), 1.5, TARGET)
    add_ball(scene, placed(base, arc.position(reading.goal, arm.length)), 0.02 * arm.length, TARGET)


def _said(session: Session, paused: bool) -> tuple[str, str]:
    """Return the two columns of the caption."""
    reading = session.reading
    angle, plane = (float(np.degrees(x)) for x in arc.to_polar(reading.bend))
    left = "tip error\nbend\ntension\n\narrows\nSpace\nBackspace"
    tensions = " ".join(f"{x:.0f}" for x in reading.tensions)
    right = f"{1e3 * reading.error:.2f} mm\n{angle:.0f} deg towards {plane:.0f} deg\n{tensions} N\n\nbend the arm"
    right += f"\n{'resume' if paused else 'pause'}\nstart again"
    return left, right + (f"\n{session.problem}" if session.problem else "")
