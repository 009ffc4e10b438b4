"""The page: a server on this machine, and the loop that keeps the arm in step with the clock."""

from __future__ import annotations

import io
import queue
import socket
import time
from collections.abc import Callable
from contextlib import redirect_stdout
from typing import Any

from contarm_sim.arm import Arm
from contarm_sim.errors import DivergenceError, InputError, MissingError
from contarm_sim.live.session import PERIOD, Session
from contarm_sim.simulation.control import Controller
from contarm_sim.simulation.plant import engine_room

HOST = "127.0.0.1"
PORT = 8080
_TRIED = 20
_PICTURES, _PLOTS = 1 / 30, 1 / 8
_MOST_BEHIND = 0.25
"""Wall-clock time [s] that is made up for; more is given up, and said."""


def free_port(port: int | None) -> int:
    """Return a port that is free: the one given, or the first from `PORT` on.

    Raises:
        InputError: the one given is taken, or none is free.
    """
    for tried in [port] if port is not None else range(PORT, PORT + _TRIED):
        with socket.socket() as probe:
            probe.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
            try:
                probe.bind((HOST, tried))
                return tried
            except OSError:
                continue
    raise InputError("port", port if port is not None else f"{PORT} to {PORT + _TRIED - 1}", "a port that is free")


def serve(
    arm: Arm, controller: Controller = "servo", port: int | None = None, on_ready: Callable[[str], None] | None = None
) -> None:
    """Serve the page until Ctrl-C; `on_ready` is told its address.

    Any number of browsers may come and go; all show and steer the same arm.

    Raises:
        MissingError: viser, which makes the page, is not installed.
        InputError: the port is taken, or an unknown controller.
    """
    try:
        import viser
    except ImportError:
        raise MissingError("viser", "view") from None
    from contarm_sim.live.panel import Panel
    from contarm_sim.live.scene import Scene

    session = Session(arm, controller)
    wishes: queue.SimpleQueue[Callable[[], None]] = queue.SimpleQueue()
    with redirect_stdout(io.StringIO()):  # its banner; stdout is for whoever asked for JSON
        server = viser.ViserServer(host=HOST, port=free_port(port), label="contarm_sim", verbose=False)
    try:
        server.gui.configure_theme(show_logo=False, show_share_button=False, control_width="medium")
        scene = Scene(server, session)
        panel = Panel(server, session, wishes.put, scene.turn)

        async def drag(event: Any) -> None:
            if event.phase != "end":
                eye, through = event.client.camera.position, event.end_position
                wishes.put(lambda: panel.aim(scene.bend_seen(eye, through)))

        scene.target.on_drag("left")(drag)
        if on_ready is not None:
            on_ready(f"http://{HOST}:{server.get_port()}")
        with engine_room():
            _loop(session, scene, panel, server, wishes)
    except KeyboardInterrupt:
        pass
    finally:
        with redirect_stdout(io.StringIO()):
            server.stop()


def _loop(session: Session, scene: Any, panel: Any, server: Any, wishes: queue.SimpleQueue[Callable[[], None]]) -> None:
    """Step as much as the clock asks for; send pictures only where somebody looks."""
    due, before, next_picture, next_plot = 0.0, time.perf_counter(), 0.0, 0.0
    busy, behind = 0.0, False
    while True:
        while not wishes.empty():
            try:
                wishes.get()()
            except InputError as error:
                session.problem = str(error)
        now = time.perf_counter()
        due += 0.0 if panel.paused else panel.speed * (now - before)
        before = now
        if due > _MOST_BEHIND * panel.speed:
            due, behind = 0.0, True
        while due >= PERIOD:
            try:
                session.tick()
            except DivergenceError as error:
                session.problem = f"{error}; started again"
            panel.note()
            due -= PERIOD
        if now >= next_picture and server.get_clients():
            scene.show()
            next_picture = now + _PICTURES
            if now >= next_plot:
                panel.show(busy, behind)
                next_plot, behind = now + _PLOTS, False
        spent = time.perf_counter() - now
        rest = max(PERIOD / panel.speed - spent, 0.002)
        busy += 0.05 * (spent / (spent + rest) - busy)
        time.sleep(rest)
