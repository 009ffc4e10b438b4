"""The page itself: a server, the scene and the controls on it, all showing one session."""

from __future__ import annotations

import io
import socket
from collections.abc import Iterator
from contextlib import contextmanager, redirect_stdout
from typing import TYPE_CHECKING, Any

from contarm_sim.errors import InputError, MissingError
from contarm_sim.kinematics.arrays import Array
from contarm_sim.view.live.session import Session
from contarm_sim.view.live.wishes import Wishes

if TYPE_CHECKING:
    from contarm_sim.view.live.panel import Panel
    from contarm_sim.view.live.scene import Scene

HOST = "127.0.0.1"
PORT = 8080
_TRIED = 20


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


@contextmanager
def page(session: Session, port: int | None) -> Iterator[tuple[Any, Scene, Panel, Wishes]]:
    """Serve a page that shows a session while inside; yields (server, scene, panel, wishes).

    Raises:
        MissingError: viser, which makes the page, is not installed.
        InputError: the port is taken.
        GuardError: this viser cannot be kept to this machine.
    """
    try:
        import viser  # noqa: F401
    except ImportError:
        raise MissingError("viser", "view") from None
    from contarm_sim.view.live.aims import SeveralSections
    from contarm_sim.view.live.guard import open_server
    from contarm_sim.view.live.panel import Panel
    from contarm_sim.view.live.scene import Scene

    wishes = Wishes()
    with redirect_stdout(io.StringIO()):  # its banner; stdout is for whoever asked for JSON
        server = open_server(HOST, free_port(port), "contarm_sim")
    try:
        server.gui.configure_theme(show_logo=False, show_share_button=False)
        scene = Scene(server, session)
        panel = Panel(server, session, wishes.put, scene.turn)

        def follow(eye: Array, through: Array) -> None:
            if isinstance(panel.aims, SeveralSections):
                panel.aims.pull(scene.in_base(through))
            else:
                panel.aim(scene.bend_seen(eye, through))

        def let_go(through: Array) -> None:
            if isinstance(panel.aims, SeveralSections):
                panel.aims.let_go(scene.in_base(through))

        async def drag(event: Any) -> None:
            if event.phase != "end":
                wishes.put(follow, event.client.camera.position, event.end_position)
            else:
                wishes.put(let_go, event.end_position)

        scene.target.on_drag("left")(drag)
        yield server, scene, panel, wishes
    finally:
        with redirect_stdout(io.StringIO()):
            server.stop()
