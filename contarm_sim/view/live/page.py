"""The page itself: a server, the scene and the controls on it, all showing one session."""

from __future__ import annotations

import io
import socket
from collections.abc import Iterator
from contextlib import contextmanager, redirect_stdout
from typing import Any

from contarm_sim.errors import InputError, MissingError
from contarm_sim.kinematics.arrays import Array
from contarm_sim.view.live.keeping import Keeper
from contarm_sim.view.live.session import Session
from contarm_sim.view.live.wishes import Wishes

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


class Page:
    """A page that shows a session.

    Attributes:
        server, scene, panel: of the page.
        wishes: of the people who look at it.
    """

    def __init__(self, server: Any, session: Session, keeper: Keeper) -> None:
        from contarm_sim.view.live.panel import Panel
        from contarm_sim.view.live.scene import Scene

        self.server, self.wishes = server, Wishes()
        server.gui.configure_theme(show_logo=False, show_share_button=False)
        self.scene = Scene(server, session)
        self.panel = Panel(server, session, self.wishes.put, self.scene.turn, self._show_another, keeper)
        self._let_drag()

    def _show_another(self) -> None:
        """Draw another arm."""
        self.scene.clear()
        self.scene.build()
        self._let_drag()

    def _let_drag(self) -> None:
        self.scene.target.on_drag("left")(self._drag)

    async def _drag(self, event: Any) -> None:
        if event.phase != "end":
            self.wishes.put(self._follow, event.client.camera.position, event.end_position)
        else:
            self.wishes.put(self._let_go, event.end_position)

    def _follow(self, eye: Array, through: Array) -> None:
        aims = self.panel.aims
        if hasattr(aims, "pull"):
            aims.pull(self.scene.in_base(through))
        else:
            self.panel.aim(self.scene.bend_seen(eye, through))

    def _let_go(self, through: Array) -> None:
        aims = self.panel.aims
        if hasattr(aims, "let_go"):
            aims.let_go(self.scene.in_base(through))


@contextmanager
def page(session: Session, port: int | None, keeper: Keeper) -> Iterator[Page]:
    """Serve a page that shows a session while inside.

    Raises:
        MissingError: viser, which makes the page, is not installed.
        InputError: the port is taken.
        GuardError: this viser cannot be kept to this machine.
    """
    try:
        import viser  # noqa: F401
    except ImportError:
        raise MissingError("viser", "view") from None
    from contarm_sim.view.live.guard import open_server

    with redirect_stdout(io.StringIO()):  # its banner; stdout is for whoever asked for JSON
        server = open_server(HOST, free_port(port), "contarm_sim")
    try:
        yield Page(server, session, keeper)
    finally:
        with redirect_stdout(io.StringIO()):
            server.stop()
