"""The live page under visitors who mean harm: strangers, malformed messages, floods."""

import http.client
import json
import subprocess
import sys
import time
from dataclasses import make_dataclass
from types import SimpleNamespace

import pytest
from waiting import PATIENCE, wait_for

from contarm_sim.errors import GuardError
from contarm_sim.view.live.keeping import Keeper
from contarm_sim.view.live.page import free_port, page
from contarm_sim.view.live.session import Session

viser = pytest.importorskip("viser")
msgspec = pytest.importorskip("msgspec")
websockets = pytest.importorskip("websockets")
zstandard = pytest.importorskip("zstandard")

# `contarm view` with a tunnel that only says that it was asked for.
PROGRAM = """
import sys
import viser._viser
from contarm_sim.__main__ import main

class Tunnel:
    def __init__(self, *_):
        print("a tunnel was asked for", flush=True)
        raise RuntimeError("no tunnel in tests")

viser._viser.ViserTunnel = Tunnel
sys.argv = ["contarm", "view", "--json"]
sys.exit(main())
"""

CAMERA = {
    "wxyz": [1.0, 0.0, 0.0, 0.0],
    "position": [1.0, -1.0, 1.0],
    "fov": 1,
    "near": 0.01,
    "far": 1000,
    "image_height": 600,
    "image_width": 800,
    "look_at": [0.0, 0.0, 0.0],
    "up_direction": [0.0, 0.0, 1.0],
}
DRAG = {
    "phase": "update",
    "name": "/arm/target",
    "instance_index": None,
    "start_position": [0.0, 0.0, 0.3],
    "start_screen_pos": [0.5, 0.5],
    "end_position": [0.2, 0.0, 0.2],
    "end_screen_pos": [0.6, 0.5],
    "button": "left",
    "modifier": None,
    "owner": "",
}


class Visitor:
    """A page without a browser: speaks with the server as viser's page does."""

    def __init__(self, port):
        from websockets.sync.client import connect

        plain = {"compression": None, "max_size": None, "proxy": None, "close_timeout": 1, "ping_interval": None}
        self.socket = connect(f"ws://127.0.0.1:{port}", subprotocols=[f"viser-v{viser.__version__}"], **plain)
        self.controls, self.values, self.seen, self.status, self.time = {}, {}, set(), "", 0.0
        self.send("ViewerCameraMessage", **CAMERA)
        self.wait(lambda: self.controls and self.time > 0)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.socket.close()

    def send(self, kind, **fields):
        self.socket.send(msgspec.msgpack.encode({"type": kind, **fields}))

    def set(self, label, **updates):
        self.send("GuiUpdateMessage", uuid=self.controls[label], updates=updates)

    def read(self):
        """Take one window of messages: the uuids of controls by label, their values, the simulated time [s]."""
        raw = self.socket.recv(timeout=PATIENCE)
        length = int.from_bytes(raw[8:16], "little")
        window = msgspec.msgpack.decode(zstandard.ZstdDecompressor().decompress(raw[16 : 16 + length]))
        for message in window["messages"]:
            self.seen.add(message["type"])
            if "label" in message.get("props", {}):
                self.controls[message["props"]["label"]] = message["uuid"]
                self.values[message["uuid"]] = message.get("value")
            if message["type"] == "GuiUpdateMessage":
                updates = message["updates"]
                if "value" in updates:
                    self.values[message["uuid"]] = updates["value"]
                elif "t = " in str(updates):
                    self.status = str(updates)
                    self.time = float(self.status.split("t = ")[1].split(" s")[0])

    def wait(self, condition):
        """Read on until something is true."""
        end = time.monotonic() + PATIENCE
        while not condition():
            assert time.monotonic() < end, "waited in vain"
            self.read()

    def goes_on(self):
        """Wait for two more readings of another time; a reset sets it back."""
        for _ in range(2):
            before = self.time
            self.wait(lambda before=before: self.time != before)

    def shown(self, label):
        """Return the value that a control shows."""
        return self.values.get(self.controls[label])


@pytest.fixture(scope="module")
def view(tmp_path_factory):
    """Serve a page; yields its port, and what the process has said so far."""
    out, err = (tmp_path_factory.mktemp("view") / name for name in ("out", "err"))
    with out.open("w") as said, err.open("w") as complained:
        process = subprocess.Popen([sys.executable, "-c", PROGRAM], stdout=said, stderr=complained, text=True)
    try:
        wait_for(lambda: out.read_text().endswith("}\n") or process.poll() is not None)
        assert process.poll() is None, err.read_text()
        port = int(json.loads(out.read_text())["url"].rsplit(":", 1)[1])
        yield port, lambda: (process.poll(), out.read_text(), err.read_text())
    finally:
        process.kill()
        process.wait(PATIENCE)


@pytest.fixture
def port(view):
    """Serve a page that must still run afterwards, and have said nothing but its address: no tunnel, no traceback."""
    port, said = view
    yield port
    with Visitor(port) as another:
        another.goes_on()
    code, out, err = said()
    assert code is None
    assert list(json.loads(out)) == ["url"]
    assert err.count("\n") == 1, err


def _asked(port, headers, upgrade):
    """Return the status with which a request is answered."""
    connection = http.client.HTTPConnection("127.0.0.1", port, timeout=PATIENCE)
    connection.putrequest("GET", "/", skip_host=True)
    if upgrade:
        headers = [*headers, ("Upgrade", "websocket"), ("Connection", "Upgrade"), ("Sec-WebSocket-Version", "13")]
        headers += [
            ("Sec-WebSocket-Key", "AAAAAAAAAAAAAAAAAAAAAA=="),
            ("Sec-WebSocket-Protocol", f"viser-v{viser.__version__}"),
        ]
    for name, value in headers:
        connection.putheader(name, value)
    connection.endheaders()
    try:
        return connection.getresponse().status
    finally:
        connection.close()


@pytest.mark.parametrize("upgrade", [False, True])
def test_the_page_is_given_to_this_machine_alone(port, upgrade):
    here = f"localhost:{port}"
    welcome = [
        [("Host", f"127.0.0.1:{port}")],
        [("Host", f"127.0.0.1:{port}"), ("Origin", f"http://127.0.0.1:{port}")],
        [("Host", here), ("Origin", f"http://{here}")],
        [("Host", "localhost:9000"), ("Origin", "http://localhost:9000")],  # through ssh -L 9000:127.0.0.1:...
        [("Host", "[::1]:9000"), ("Origin", "http://[::1]:9000")],
        [("Host", "localhost"), ("Origin", "http://localhost")],
    ]
    refused = [
        [],
        [("Host", f"evil.example:{port}")],
        [("Host", f"evil.example:{port}"), ("Origin", f"http://evil.example:{port}")],  # a name rebound to 127.0.0.1
        [("Host", f"localhost.evil.example:{port}")],
        [("Host", f"evil.example@{here}")],
        [("Host", f"0.0.0.0:{port}")],
        [("Host", here), ("Origin", "https://evil.example")],
        [("Host", here), ("Origin", f"http://127.0.0.1:{port}")],
        [("Host", here), ("Origin", f"http://localhost:{port + 1}")],  # another program's page on this machine
        [("Host", here), ("Origin", f"http://{here}.evil.example")],
        [("Host", here), ("Origin", "null")],
        [("Host", here), ("Host", "evil.example")],
        [("Host", here), ("Origin", f"http://{here}"), ("Origin", "https://evil.example")],
    ]
    for headers in welcome:
        assert _asked(port, headers, upgrade) == (101 if upgrade else 200), headers
    for headers in refused:
        assert _asked(port, headers, upgrade) == 403, headers


def test_nobody_can_have_the_page_made_public(port):
    with Visitor(port) as visitor:
        visitor.send("ShareUrlRequest")
        visitor.send("ShareUrlDisconnect")
        visitor.goes_on()  # what was said before was heard by then


def test_a_page_of_another_version_is_told_so_and_nobody_else(port):
    from websockets.exceptions import ConnectionClosed
    from websockets.sync.client import connect

    with connect(f"ws://127.0.0.1:{port}", subprotocols=["viser-v0.0.0"], proxy=None) as socket:
        with pytest.raises(ConnectionClosed) as closed:
            socket.recv(timeout=PATIENCE)
        assert closed.value.rcvd.code == 1002


MALFORMED = {
    "drag of two components": ("SceneNodeDragMessage", {**DRAG, "end_position": [0.1, 0.2]}),
    "drag of nothing": ("SceneNodeDragMessage", {**DRAG, "end_position": [None, None, None]}),
    "drag to the eye": ("SceneNodeDragMessage", {**DRAG, "end_position": CAMERA["position"]}),
    "camera of one number": ("ViewerCameraMessage", {**CAMERA, "position": 5}),
    "camera of words": ("ViewerCameraMessage", {**CAMERA, "fov": "wide"}),
    "no fields": ("ViewerCameraMessage", {}),
    "unknown field": ("ViewerCameraMessage", {**CAMERA, "excluded_self_client": 1}),
    "unknown type": ("NoSuchMessage", {}),
}


@pytest.mark.parametrize("name", MALFORMED)
def test_a_malformed_message_changes_nothing(port, name):
    kind, fields = MALFORMED[name]
    with Visitor(port) as visitor:
        visitor.send(kind, **fields)
        visitor.goes_on()


@pytest.mark.parametrize("raw", [b"", b"\xc1", b"\x81", b"\x91" * 50_000, b"\x05", "words", b"\x00" * 60_000_000])
def test_what_is_no_message_changes_nothing(port, raw):
    from websockets.exceptions import ConnectionClosed

    with Visitor(port) as visitor:
        try:
            visitor.socket.send(raw)
        except ConnectionClosed:
            assert len(raw) > 1_000_000  # too large to be read at all


CONTROLS = ("bend angle [deg]", "payload [g]", "controller", "mounted", "Pause", "Reset")


@pytest.mark.parametrize(
    "updates",
    [
        {"update_cb": 5}, {"props": 5}, {"gui_api": 1}, {"removed": 1}, {"value": 5, "props": 5}, {"no_such": 1}, {},
        {"value": "lqr"}, {"value": None}, {"value": [1, 2]}, {"value": {"value": 1}}, {"value": float("nan")},
    ],
    ids=str,
)  # fmt: skip
def test_a_control_takes_nothing_but_its_values(port, updates):
    with Visitor(port) as visitor, Visitor(port) as other:
        before = [other.shown(label) for label in CONTROLS]
        for label in CONTROLS:
            visitor.set(label, **updates)
        for speed in (1.5, 1.0):
            visitor.set("speed", value=speed)
            other.wait(lambda speed=speed: other.shown("speed") == speed)
        assert [other.shown(label) for label in CONTROLS] == before
        visitor.set("bend angle [deg]", value=30)
        other.wait(lambda: other.shown("bend angle [deg]") == 30)
        visitor.set("Reset", value=True)
        other.wait(lambda: other.shown("bend angle [deg]") == 0)
        other.goes_on()


def test_what_no_page_says_is_not_passed_on(port):
    with Visitor(port) as visitor, Visitor(port) as other:
        visitor.send("GuiFormDirtyMessage", uuid="x")
        visitor.goes_on()
        other.goes_on()
        assert "GuiFormDirtyMessage" not in other.seen


def test_good_messages_still_steer(port):
    with Visitor(port) as visitor, Visitor(port) as other:
        for phase in ("start", "update", "end"):
            visitor.send("SceneNodeDragMessage", **{**DRAG, "phase": phase})
        other.wait(lambda: (other.shown("bend angle [deg]") or 0) > 10)
        visitor.set("controller", value="pressure")
        other.wait(lambda: other.shown("controller") == "pressure")
        for paused in (True, False):
            visitor.set("Pause", value=True)
            other.wait(lambda paused=paused: ("paused" in other.status) == paused)


def test_the_page_is_not_served_by_a_viser_that_cannot_be_guarded(arm, monkeypatch):
    from websockets.asyncio.server import serve

    around = SimpleNamespace(**{**vars(websockets), "asyncio": SimpleNamespace(server=SimpleNamespace(serve=serve))})
    camera = make_dataclass("ViewerCameraMessage", ["position", "zoom"])
    for name, changed in (("viser.infra._infra.websockets", around), ("viser._messages.ViewerCameraMessage", camera)):
        with monkeypatch.context() as patch:
            patch.setattr(name, changed)
            port = free_port(None)
            with pytest.raises(GuardError, match=f"viser {viser.__version__}"), page(Session(arm), port, Keeper(print)):
                pass
            assert free_port(port) == port


def test_a_flood_stops_nothing_and_its_last_word_counts(port):
    with Visitor(port) as visitor, Visitor(port) as other:
        for i in range(6_000):
            visitor.set(("payload [g]", "gravity [m/s²]", "bend angle [deg]")[i % 3], value=i % 7)
        for label, value in (("payload [g]", 0), ("gravity [m/s²]", 0.5), ("bend angle [deg]", 42)):
            visitor.set(label, value=value)
        other.goes_on()
        other.wait(lambda: other.shown("bend angle [deg]") == 42)
        start = other.time
        other.wait(lambda: other.time > start + 1)
        visitor.set("gravity [m/s²]", value=0)
        other.wait(lambda: other.shown("gravity [m/s²]") == 0)
