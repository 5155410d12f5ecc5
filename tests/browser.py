"""A page in headless Chromium, driven through its own pipe: clicks, keys and windows as narrow as a telephone's.

Speaks the DevTools protocol over two file descriptors, so that nothing is installed for it and no port is opened.
"""

from __future__ import annotations

import base64
import itertools
import json
import os
import select
import shutil
import subprocess
import time
from pathlib import Path

_NAMES = ("chromium", "chromium-browser", "google-chrome", "chrome") if os.name == "posix" else ()

BROWSER = next(filter(None, map(shutil.which, _NAMES)), None)

#: Why a test that needs one is skipped.
NO_BROWSER = "no Chromium to open the page with"

_QUIET = (
    "--headless=new",
    "--no-sandbox",
    "--disable-gpu",
    "--disable-quic",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
    "--hide-scrollbars",
)

#: Seconds to wait for an answer.
_PATIENCE = 60.0


class Browser:
    """One tab; a context manager that ends the browser with all its processes.

    Parameters
    ----------
    folder : Path
        For the profile; empty.
    """

    def __init__(self, folder: Path):
        (self._in, self._to), (self._from, self._out) = os.pipe(), os.pipe()
        flags = [*_QUIET, "--host-resolver-rules=MAP * ~NOTFOUND", f"--user-data-dir={folder / 'profile'}"]
        # The shell gives the pipe the numbers that Chromium expects.
        start = f'exec "$0" "$@" 3<&{self._in} 4>&{self._out}'
        self._process = subprocess.Popen(
            ["bash", "-c", start, BROWSER, *flags, "--remote-debugging-pipe", "about:blank"],
            pass_fds=(self._in, self._out),
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
        )
        self._numbers, self._rest, self._answers, self.events = itertools.count(1), b"", {}, []
        self._session = None
        target = self.send("Target.createTarget", url="about:blank")["targetId"]
        self._session = self.send("Target.attachToTarget", targetId=target, flatten=True)["sessionId"]
        for part in ("Page", "Runtime", "Network", "Log"):
            self.send(f"{part}.enable")

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self._process.terminate()
        self._process.wait()
        for end in (self._in, self._to, self._from, self._out):
            os.close(end)

    def send(self, method, **parameters):
        """Return the answer to a command."""
        number = next(self._numbers)
        message = {"id": number, "method": method, "params": parameters}
        if self._session:
            message["sessionId"] = self._session
        os.write(self._to, json.dumps(message).encode() + b"\0")
        until = time.monotonic() + _PATIENCE
        while number not in self._answers:
            self._receive(until, method)
        answer = self._answers.pop(number)
        if "error" in answer:
            raise RuntimeError(f"{method}: {answer['error']['message']}")
        return answer["result"]

    def _receive(self, until, method):
        ready, _, _ = select.select([self._from], [], [], max(0.0, until - time.monotonic()))
        if not ready or self._process.poll() is not None:
            raise TimeoutError(f"{method}: the browser does not answer")
        self._rest += os.read(self._from, 2**20)
        *whole, self._rest = self._rest.split(b"\0")
        for message in map(json.loads, whole):
            if "id" in message:
                self._answers[message["id"]] = message
            else:
                self.events.append(message)

    def open(self, path: Path, width: int, height: int = 900, hash: str = ""):
        """Open a file in a window of so many pixels, and wait until it is drawn."""
        size = {"width": width, "height": height, "deviceScaleFactor": 1, "mobile": False}
        self.send("Emulation.setDeviceMetricsOverride", **size)
        self._load("about:blank")  # another part of the same page would not be loaded anew
        self._load(path.resolve().as_uri() + hash)
        self.settle()

    def _load(self, url: str):
        self.events.clear()
        self.send("Page.navigate", url=url)
        until = time.monotonic() + _PATIENCE
        while not any(event["method"] == "Page.loadEventFired" for event in self.events):
            self._receive(until, "load")

    def settle(self):
        """Wait until what was asked for is drawn."""
        drawn = "new Promise(done => requestAnimationFrame(() => requestAnimationFrame(done)))"
        self.send("Runtime.evaluate", expression=drawn, awaitPromise=True)

    def value(self, expression):
        """Return what a script's expression is."""
        found = self.send("Runtime.evaluate", expression=expression, returnByValue=True)
        if "exceptionDetails" in found:
            raise RuntimeError(found["exceptionDetails"]["exception"].get("description"))
        return found["result"].get("value")

    def click(self, selector):
        """Click in the middle of an element, once it is in view."""
        shown = f"document.querySelector({json.dumps(selector)})"
        self.value(f"{shown}.scrollIntoView({{block: 'center'}})")
        box = self.value(
            f"(({{x, y, width, height}}) => [x + width / 2, y + height / 2])({shown}.getBoundingClientRect())"
        )
        for kind in ("mousePressed", "mouseReleased"):
            at = {"x": box[0], "y": box[1], "button": "left", "clickCount": 1}
            self.send("Input.dispatchMouseEvent", type=kind, **at)
        self.settle()

    def press(self, key):
        """Press a key such as ArrowRight or Tab."""
        codes = {"Tab": 9, "End": 35, "Home": 36, "ArrowLeft": 37, "ArrowUp": 38, "ArrowRight": 39, "ArrowDown": 40}
        for kind in ("keyDown", "keyUp"):
            self.send("Input.dispatchKeyEvent", type=kind, key=key, code=key, windowsVirtualKeyCode=codes[key])
        self.settle()

    def complaints(self):
        """Return what went wrong in the page since it was opened, and what it asked of a network."""
        wrong = [event["params"] for event in self.events if event["method"] == "Runtime.exceptionThrown"]
        wrong += [e["params"] for e in self.events if e["method"] == "Log.entryAdded" and _bad(e["params"]["entry"])]
        asked = [e["params"]["request"]["url"] for e in self.events if e["method"] == "Network.requestWillBeSent"]
        return wrong + [url for url in asked if not url.startswith(("file:", "data:", "blob:"))]

    def picture(self, path: Path, *, whole: bool = True):
        """Write what is seen as a PNG file."""
        taken = self.send("Page.captureScreenshot", captureBeyondViewport=whole)
        Path(path).write_bytes(base64.b64decode(taken["data"]))


def _bad(entry) -> bool:
    return entry["level"] == "error"
