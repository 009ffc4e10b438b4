"""The loop that keeps the arm on the page in step with the clock."""

from __future__ import annotations

import logging
import time
from collections.abc import Callable
from typing import Any

from contarm_sim.engine.plant import engine_room
from contarm_sim.errors import DivergenceError, InputError
from contarm_sim.model.arm import Arm
from contarm_sim.view.live.page import HOST, page
from contarm_sim.view.live.session import Session
from contarm_sim.view.live.wishes import Wishes

_LOG = logging.getLogger(__name__)
_PICTURES, _PLOTS = 1 / 30, 1 / 8
_MOST_BEHIND = 0.25
"""Wall-clock time [s] that is made up for; more is given up, and said."""


def serve(
    arm: Arm, controller: str = "servo", port: int | None = None, on_ready: Callable[[str], None] | None = None
) -> None:
    """Serve the page until Ctrl-C; `on_ready` is told its address.

    Any number of browsers may come and go; all show and steer the same arm.

    Args:
        port: default the first free one from 8080 on.

    Raises:
        MissingError: viser, which makes the page, is not installed.
        InputError: the port is taken, or an unknown controller.
        GuardError: this viser cannot be kept to this machine.
    """
    session = Session(arm, controller)
    try:
        with page(session, port) as (server, scene, panel, wishes), engine_room():
            if on_ready is not None:
                on_ready(f"http://{HOST}:{server.get_port()}")
            _loop(session, scene, panel, server, wishes)
    except KeyboardInterrupt:
        pass


def _loop(session: Session, scene: Any, panel: Any, server: Any, wishes: Wishes) -> None:
    """Step as much as the clock asks for; send pictures only where somebody looks."""
    due, before, next_picture, next_plot = 0.0, time.perf_counter(), 0.0, 0.0
    busy, behind = 0.0, False
    while True:
        for wish in wishes.take():
            try:
                wish()
            except InputError as error:
                session.problem = str(error)
            except Exception:  # whatever one person asks for, the others' arm goes on
                _LOG.exception("a wish was given up")
        now = time.perf_counter()
        due += 0.0 if panel.paused else panel.speed * (now - before)
        before = now
        if due > _MOST_BEHIND * panel.speed:
            due, behind = 0.0, True
        while due >= session.period:
            try:
                session.tick()
            except DivergenceError as error:
                session.problem = f"{error}; the simulation started again"
            panel.note()
            due -= session.period
        if now >= next_picture and server.get_clients():
            scene.show()
            next_picture = now + _PICTURES
            if now >= next_plot:
                panel.show(busy, behind)
                next_plot, behind = now + _PLOTS, False
        spent = time.perf_counter() - now
        rest = max(session.period / panel.speed - spent, 0.002)
        busy += 0.05 * (spent / (spent + rest) - busy)
        time.sleep(rest)
