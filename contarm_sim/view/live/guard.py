"""The door of the page: who may come in, and what may be said there.

viser serves whoever reaches its port, believes what it is told, and makes the page public for anyone who asks. A site
in somebody's browser reaches a port of this machine too. So every request must name this machine, and come from no
other site; and every message must be one of `messages`, of a control that exists, at a pace that leaves time to draw.

The means: while viser starts, `websockets.asyncio.server.serve` serves through this door. Of viser's private names,
`_messages` and `_gui_input_handle_from_uuid` are read. A viser that does otherwise is refused at the start.
"""

from __future__ import annotations

import asyncio
import dataclasses
import http.client
import logging
import re
from collections.abc import Awaitable, Callable, Iterator
from contextlib import contextmanager, suppress
from functools import partial
from http import HTTPStatus
from typing import Any

import viser
import websockets.asyncio.server as web
from websockets.datastructures import Headers
from websockets.exceptions import ConnectionClosed
from websockets.http11 import Request

from contarm_sim.errors import GuardError
from contarm_sim.view.live.dress import dressed
from contarm_sim.view.live.messages import SAID, Said, Update, understood, worded

_LOOPBACK = re.compile(r"(localhost|127\.0\.0\.1|\[::1\])(:[0-9]{1,5})?", re.IGNORECASE | re.ASCII)
_WINDOW, _MOST = 0.01, 300
"""How long messages are gathered [s], and how many in that time are read of all pages; more wait in their sockets."""

_LARGEST = 4096
"""Length of the longest message that is read [bytes]."""

_LOG = logging.getLogger(__name__)
_LOG.addHandler(logging.NullHandler())  # what strangers send is no news on a terminal


def open_server(host: str, port: int, label: str) -> viser.ViserServer:
    """Return a server of viser behind this door.

    Raises:
        GuardError: this viser cannot be guarded; nothing is served.
    """
    for said in SAID:
        theirs = getattr(getattr(viser, "_messages", None), said.__struct_config__.tag, None)
        if theirs is None or {x.name for x in dataclasses.fields(theirs)} != set(said.__struct_fields__):
            raise GuardError(f"its {said.__struct_config__.tag} has other fields", viser.__version__)
    door = _Door()
    with door.in_front():
        server = _Unshared(host=host, port=port, label=label, verbose=False)
    controls: Any = getattr(server.gui, "_gui_input_handle_from_uuid", None)
    if not isinstance(controls, dict) or _answer_to_a_stranger(host, server.get_port()) != HTTPStatus.FORBIDDEN:
        server.stop()
        raise GuardError("it serves past the check of who asks, or hides its controls", viser.__version__)
    door.controls = controls
    return server


def _answer_to_a_stranger(host: str, port: int) -> int | None:
    """Return the status with which the page is refused to someone who calls this machine by another name."""
    connection = http.client.HTTPConnection(host, port, timeout=30)
    try:
        connection.request("GET", "/", headers={"Host": "stranger.invalid"})
        return connection.getresponse().status
    except (OSError, http.client.HTTPException):
        return None
    finally:
        connection.close()


class _Unshared(viser.ViserServer):
    """A server that is never made public, not even by this program."""

    def request_share_url(self, verbose: bool = True) -> None:
        """Do nothing."""


class _Door:
    """Checks of who asks and what is said.

    Attributes:
        controls: what can be set on the page, by its uuid.
    """

    def __init__(self) -> None:
        self.controls: dict[str, Any] = {}

    @contextmanager
    def in_front(self) -> Iterator[None]:
        """Let whatever is served meanwhile be served through this door."""
        serve = web.serve

        def guarded(handler: Any, *args: Any, **options: Any) -> Any:
            options |= {"create_connection": partial(_Connection, self), "max_size": _LARGEST, "logger": _LOG}
            options["process_request"] = partial(_answer, options.get("process_request"))
            return serve(partial(_welcome, handler), *args, **options)

        web.serve = guarded  # type: ignore[misc, assignment]
        try:
            yield
        finally:
            web.serve = serve  # type: ignore[misc]

    def lets_in(self, said: Said) -> bool:
        """Return whether something understood can be done."""
        if not isinstance(said, Update):
            return True
        control, value = self.controls.get(said.uuid), said.updates.value
        if getattr(control, "disabled", True):
            return False
        if isinstance(control, viser.GuiSliderHandle):
            return isinstance(value, float)
        if isinstance(control, viser.GuiDropdownHandle):
            return value in control.options
        return isinstance(control, viser.GuiButtonHandle) and value is True


def _answer(page: Callable[..., Any] | None, connection: web.ServerConnection, request: Request) -> Any:
    """Refuse strangers; let viser answer others."""
    if not _from_here(request.headers):
        return connection.respond(HTTPStatus.FORBIDDEN, "This page is for browsers on its own machine.\n")
    if page is None:
        return None
    if "Accept-Encoding" in request.headers:
        del request.headers["Accept-Encoding"]  # nothing is gained on one machine, and plain text can be dressed
    response = page(connection, request)
    return response if response is None else dressed(response)


def _from_here(headers: Headers) -> bool:
    """Return whether a request names this machine and comes from no other site.

    The port may be another than ours: `ssh -L` listens on one of its own.
    """
    hosts, origins = headers.get_all("Host"), headers.get_all("Origin")
    if len(hosts) != 1 or len(origins) > 1 or not _LOOPBACK.fullmatch(hosts[0]):
        return False
    own = hosts[0].lower()
    return not origins or origins[0].lower() in (f"http://{own}", f"https://{own}")


async def _welcome(handler: Callable[[Any], Awaitable[None]], connection: web.ServerConnection) -> None:
    """Send away pages of another viser, as viser does, but without a word on stdout."""
    if connection.subprotocol == f"viser-v{viser.__version__}":
        await handler(connection)
    else:
        await connection.close(1002, f"Version mismatch: reload the page, this is viser {viser.__version__}")


class _Connection(web.ServerConnection):
    """A connection on which only what is understood arrives, and of many words on one thing the last."""

    def __init__(self, door: _Door, *args: Any, **options: Any) -> None:
        super().__init__(*args, **options)
        self._door = door
        self._heard: dict[str, Said] = {}

    async def recv(self, decode: bool | None = None) -> Any:
        """Return the next message that is let in."""
        while not self._heard:
            await self._listen()
        return worded(self._heard.pop(next(iter(self._heard))))

    def recv_streaming(self, decode: bool | None = None) -> Any:
        """Refuse what would go past `recv`."""
        raise NotImplementedError

    async def _listen(self) -> None:
        """Wait for a message, and gather what comes shortly after it."""
        self._hear(await super().recv(decode=False))
        share = _MOST // (1 + len(self.server.connections))
        with suppress(TimeoutError, ConnectionClosed):
            async with asyncio.timeout(_WINDOW):
                for _ in range(share):
                    self._hear(await super().recv(decode=False))
                await asyncio.sleep(_WINDOW)

    def _hear(self, raw: bytes) -> None:
        said = understood(raw)
        if said is not None and self._door.lets_in(said):
            self._heard.pop(said.about, None)
            self._heard[said.about] = said
