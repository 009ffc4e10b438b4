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
from contarm_sim.mechanics import shape
from contarm_sim.mechanics.shape import bends_of
from contarm_sim.mjcf import names, scene_spec
from contarm_sim.mjcf.nose import nose_radius
from contarm_sim.mjcf.object_looks import to_scene
from contarm_sim.model.arm import Arm
from contarm_sim.view.live.session import Session
from contarm_sim.view.rendering.draw import ASKED
from contarm_sim.view.rendering.ghost import GHOST
from contarm_sim.view.rendering.overlays import add_ball, add_disk, add_line, placed
from contarm_sim.view.rendering.touch import LIT, add_contacts, contact_words
from contarm_sim.view.rendering.window import window

_STEP = np.radians(5.0)
_KEYS = {262: (1.0, 0.0), 263: (-1.0, 0.0), 265: (0.0, 1.0), 264: (0.0, -1.0)}  # GLFW: right, left, up, down
_SPACE, _BACKSPACE, _ONE = 32, 259, 49
_PICTURE = 1 / 60
_NEWTON = 0.03
"""Length of the arrow of a contact force of 1 N [lengths]."""


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
    paused, due, before, chosen = False, 0.0, time.perf_counter(), 0
    while shown.is_running():
        while not keys.empty():
            key = keys.get()
            paused = paused != (key == _SPACE)
            if key == _BACKSPACE:
                session.reset()
            elif key in _KEYS:
                goal = session.goal.copy()
                goal[2 * chosen : 2 * chosen + 2] += _STEP * np.array(_KEYS[key])
                session.aim(goal)
            elif 0 <= key - _ONE < len(session.arm.sections):
                chosen = key - _ONE
        now = time.perf_counter()
        due += 0.0 if paused else min(now - before, 0.25)
        before = now
        while due >= session.period:
            session.tick()
            due -= session.period
        with shown.lock():
            joints = session.plant.index.qpos
            data.qpos[joints], data.time = session.plant.qpos, session.plant.data.time
            if session.plant.hosted:
                data.qpos[:] = session.plant.data.qpos
            else:
                data.qpos[joints.stop :] = to_scene(session.arm, session.poses)
            mujoco.mj_forward(model, data)
            _draw_over(session, data, shown.user_scn)
        shown.set_texts((None, mujoco.mjtGridPos.mjGRID_TOPLEFT, *_said(session, paused, chosen)))
        shown.sync()
        time.sleep(max(0.0, _PICTURE - (time.perf_counter() - now)))


def _draw_over(session: Session, data: Any, scene: Any) -> None:
    """Draw the analytic arcs, and the target; of one section also its meridian of the dome."""
    base = data.body("base")
    arm, reading = session.arm, session.reading
    scene.ngeom = 0
    add_line(scene, placed(base, shape.position(reading.bend, arm, np.linspace(0, 1, 33))), 6.0, GHOST)
    if len(arm.sections) == 1:
        _, plane = arc.to_polar(reading.goal)
        meridian = arc.from_polar(np.linspace(0.0, LARGEST_BEND, 49), plane)
        add_line(scene, placed(base, arc.position(meridian, arm.length)), 1.5, ASKED)
    add_ball(scene, placed(base, shape.position(reading.goal, arm)), 0.02 * arm.length, ASKED)
    contacts = session.contacts
    if contacts is not None:
        stations = names.stations(arm)
        for station in np.unique(contacts.station):
            body = data.body(stations[station])
            back = nose_radius(arm) if station == arm.links else 0.0
            add_disk(
                scene, body.xpos - back * body.xmat[2::3], body.xmat, 1.06 * arm.disk_radius, 0.006 * arm.length, LIT
            )
        add_contacts(scene, base, contacts, arm, _NEWTON * arm.length, closer=0.0)


def _said(session: Session, paused: bool, chosen: int) -> tuple[str, str]:
    """Return the two columns of the caption."""
    reading = session.reading
    several = len(session.arm.sections) > 1
    bends, of_section = [], []
    for number, own in enumerate(bends_of(reading.bend, session.arm)):
        angle, plane = (float(np.degrees(x)) for x in arc.to_polar(own))
        bends.append(f"{angle:.0f} deg towards {plane:.0f} deg")
        of_section.append(f"bend {number + 1}" if several else "bend")
    keys = f"1 to {len(bends)}\narrows" if several else "arrows"
    touch = [] if session.contacts is None else ["contact"]
    left = "\n".join(["tip error", *of_section, "tension", *touch, "", keys, "Space", "Backspace"])
    tensions = " ".join(f"{x:.0f}" for x in reading.tensions)
    choice = f"choose a section, now {chosen + 1}\nbend it" if several else "bend the arm"
    felt = [] if session.contacts is None else [contact_words(session.contacts).removeprefix("contact: ")]
    right = "\n".join([f"{1e3 * reading.error:.2f} mm", *bends, f"{tensions} N", *felt, "", choice])
    right += f"\n{'resume' if paused else 'pause'}\nstart again"
    return left, right + (f"\n{session.problem}" if session.problem else "")
