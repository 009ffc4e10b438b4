"""The loop that keeps the arm on the page in step with the clock."""

from __future__ import annotations

import logging
import threading
import time
from collections.abc import Callable
from typing import Any

from contarm_sim.engine.plant import engine_room
from contarm_sim.errors import DivergenceError, InputError
from contarm_sim.model.arm import Arm
from contarm_sim.view.live.keeping import Keeper
from contarm_sim.view.live.pace import Pace
from contarm_sim.view.live.page import HOST, Page, page
from contarm_sim.view.live.session import Session

_LOG = logging.getLogger(__name__)
_MOST_BEHIND = 0.25
"""Wall-clock time [s] that is made up for; more is given up, and said."""


def serve(
    arm: Arm,
    controller: str = "servo",
    port: int | None = None,
    on_ready: Callable[[str], object] = lambda url: None,
    say: Callable[[str], object] = lambda news: None,
    command: str = "contarm view",
) -> None:
    """Serve the page until Ctrl-C; recordings are drawn to their end.

    Any number of browsers may come and go; all show and steer the same arm.

    Args:
        port: default the first free one from 8080 on.
        on_ready: is told the page's address.
        say: is told what is kept of recordings, and where.
        command: that recordings name as what made them.

    Raises:
        MissingError: viser, which makes the page, is not installed.
        InputError: the port is taken, or an unknown controller.
        GuardError: this viser cannot be kept to this machine.
    """
    session, keeper = Session(arm, controller), Keeper(say, command)
    try:
        with page(session, port, keeper) as shown, engine_room():
            on_ready(f"http://{HOST}:{shown.server.get_port()}")
            threading.Thread(target=shown.scene.learn_shades, daemon=True).start()
            _loop(session, shown)
    except KeyboardInterrupt:
        recording = session.recording
        run = None if recording is None else recording.trajectory()
        if run is not None:
            keeper.keep(run)
    finally:
        keeper.finish()


def _loop(session: Session, shown: Page) -> None:
    """Step as much as the clock asks for; send pictures only where somebody looks."""
    panel, before = shown.panel, time.perf_counter()
    due, next_picture, next_curves, pace = 0.0, 0.0, 0.0, Pace(before)
    while True:
        for wish in shown.wishes.take():
            if _try(session, wish):
                session.trouble = ""
        now, lost = time.perf_counter(), 0.0
        due += 0.0 if panel.paused else panel.speed * (now - before)
        backlog, before = due / panel.speed, now
        if backlog > _MOST_BEHIND:
            due, lost = 0.0, backlog
        while due >= session.period:
            try:
                session.tick()
            except DivergenceError as error:
                session.trouble = f"{error}; the simulation started again"
            _try(session, shown.scene.note)
            _try(session, panel.note)
            due -= session.period
        if now >= next_picture and shown.server.get_clients():
            shown.scene.show()
            next_picture = now + pace.picture
            if now >= next_curves:
                panel.show(pace.words(), pace.thinning, shown.scene.arrows)
                next_curves = now + pace.curves
        pace.note(now, backlog, lost)
        time.sleep(max(session.period / panel.speed - (time.perf_counter() - now), 0.002))


def _try(session: Session, action: Callable[[], Any]) -> bool:
    """Do what somebody asked for, and return whether that could be done; the others' arm goes on in any case."""
    try:
        action()
        return True
    except InputError as error:
        session.trouble = str(error)
    except Exception:
        _LOG.exception("a wish was given up")
    return False
