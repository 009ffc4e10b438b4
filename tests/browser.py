"""A real browser, driven over its debugging port: what a person with a mouse would see and do."""

import base64
import itertools
import json
import shutil
import subprocess
import time
import urllib.request
from pathlib import Path

BROWSER = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")


class Page:
    """One tab of a headless browser of its own; a context manager."""

    def __init__(self, url, profile, width=1280, height=800):
        self.errors, self._ids = [], itertools.count(1)
        flags = [
            "--headless=new",
            "--no-sandbox",
            "--enable-unsafe-swiftshader",
            "--use-angle=swiftshader",
            "--disable-dev-shm-usage",
        ]
        flags += ["--remote-debugging-port=0", f"--user-data-dir={profile}", f"--window-size={width},{height}"]
        self._process = subprocess.Popen([BROWSER, *flags, "about:blank"], stderr=subprocess.DEVNULL)
        try:
            self._open(url, Path(profile) / "DevToolsActivePort")
        except BaseException:
            self._process.kill()
            raise

    def _open(self, url, said):
        from websockets.sync.client import connect

        wait_for(said.exists)
        port = said.read_text().split()[0]
        with urllib.request.urlopen(f"http://127.0.0.1:{port}/json") as answer:
            target = next(one for one in json.load(answer) if one["type"] == "page")
        self._socket = connect(target["webSocketDebuggerUrl"], max_size=None)
        for domain in ("Runtime", "Page", "Log"):
            self.ask(f"{domain}.enable")
        self.ask("Page.navigate", url=url)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self._socket.close()
        self._process.terminate()
        self._process.wait(20)

    def ask(self, method, **params):
        """Send a command and return its answer; errors of the page met on the way are kept in `errors`."""
        number = next(self._ids)
        self._socket.send(json.dumps({"id": number, "method": method, "params": params}))
        while True:
            said = json.loads(self._socket.recv(timeout=60))
            if said.get("id") == number:
                assert "error" not in said, said
                return said["result"]
            what = said.get("params", {})
            if said.get("method") == "Runtime.exceptionThrown":
                self.errors.append(what["exceptionDetails"]["text"])
            elif said.get("method") == "Log.entryAdded" and what["entry"]["level"] == "error":
                self.errors.append(what["entry"]["text"] + " " + what["entry"].get("url", ""))

    def run(self, script):
        """Return the value of a JavaScript expression."""
        return self.ask("Runtime.evaluate", expression=script, returnByValue=True)["result"].get("value")

    def text(self):
        """Return all that can be read."""
        return self.run("document.body && document.body.innerText") or ""

    def drag(self, start, end, steps=12):
        """Press the left button at a point [pixels], move to another, let go."""
        at = dict(zip("xy", start, strict=True))
        self.ask("Input.dispatchMouseEvent", type="mouseMoved", **at)
        self.ask("Input.dispatchMouseEvent", type="mousePressed", button="left", buttons=1, clickCount=1, **at)
        for i in range(1, steps + 1):
            at = {k: a + (b - a) * i / steps for k, a, b in zip("xy", start, end, strict=True)}
            self.ask("Input.dispatchMouseEvent", type="mouseMoved", button="left", buttons=1, **at)
            time.sleep(0.05)
        self.ask("Input.dispatchMouseEvent", type="mouseReleased", button="left", buttons=0, clickCount=1, **at)

    def click(self, label):
        """Press the button that says so."""
        script = "Array.from(document.querySelectorAll('button')).find(b => b.innerText.trim() === %s).click()"
        self.run(script % json.dumps(label))

    def screenshot(self, path):
        """Save what is seen as a PNG."""
        Path(path).write_bytes(base64.b64decode(self.ask("Page.captureScreenshot", format="png")["data"]))


def wait_for(condition, seconds=120):
    """Wait until something is true and return it."""
    end = time.monotonic() + seconds
    while not (found := condition()):
        assert time.monotonic() < end, "waited in vain"
        time.sleep(0.05)
    return found
