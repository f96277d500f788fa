"""Chromium without a window, as a user of pages: mouse and keys. `docs/devtools.py` drives it."""

import json
import sys
from io import BytesIO
from pathlib import Path

import matplotlib.image
import numpy as np
import pytest

sys.path.insert(0, str(Path(__file__).parent.parent / "docs"))
from devtools import Window, chromium

DRAWN = "new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(() => done(true))))"


class Browser(Window):
    """One window, in which one page after another is opened."""

    def __init__(self, folder):
        if chromium() is None:
            pytest.skip("tests in a browser need Chromium; on Debian: apt-get install chromium")
        super().__init__()
        self.folder, self.n_pages = folder, 0

    def close(self):
        self.__exit__(None, None, None)

    def show(self, page, fragment="", *, size=(1000, 700), dark=False, still=True):
        """Show a page, and wait until it has drawn something."""
        self.n_pages += 1
        path = self.folder / f"{self.n_pages}.html"
        path.write_text(page if isinstance(page, str) else page.html, encoding="utf-8")
        self.url = path.as_uri()
        self.open(self.url + fragment, *size, dark=dark, still=still)
        if not isinstance(page, str):
            self.wait_for("Boolean(window.skpose && skpose.state.drawn > 0)")
        return self

    def problems(self):
        """Errors in the console, and requests other than for the page itself."""
        return self.errors() + [url for url in self.requests() if url.split("#")[0] != self.url]

    def settle(self):
        """Wait until everything is drawn."""
        self.run(DRAWN)
        self.wait_for("!window.skpose?.state.stale")

    def js(self, expression):
        self.settle()
        return self.run(expression)

    def text(self, css):
        return self.js(f"document.querySelector({json.dumps(css)}).textContent")

    def click(self, css):
        self.run(f"document.querySelector({json.dumps(css)}).click()")

    def choose(self, css, value):
        """Choose a value of a menu."""
        change = "one.value = value; one.dispatchEvent(new Event('change'))"
        self.run(f"((one, value) => {{ {change} }})(document.querySelector({json.dumps(css)}), {json.dumps(value)})")

    def press(self, *keys, css="canvas[tabindex]"):
        """Press keys, one after another, in an element."""
        self.run(f"document.querySelector({json.dumps(css)}).focus()")
        for key in keys:
            text = {"text": key} if len(key) == 1 else {}
            self.call("Input.dispatchKeyEvent", type="keyDown", key=key, **text)
            self.call("Input.dispatchKeyEvent", type="keyUp", key=key)

    def mouse(self, *events, modifiers=0):
        """Move, press and release the mouse at places of the main canvas, px: ("moved", x, y), ("pressed", …), …"""
        box = self.js("skpose.stage.canvas.getBoundingClientRect().toJSON()")
        held = 0
        for kind, x, y in events:
            held = {"pressed": 1, "released": 0}.get(kind, held)
            click = {"button": "left", "clickCount": 1} if kind != "moved" else {}
            place = {"x": box["left"] + x, "y": box["top"] + y, "modifiers": modifiers, "buttons": held}
            self.call("Input.dispatchMouseEvent", type=f"mouse{kind.capitalize()}", **place, **click)

    def picture(self):
        """What the window shows, (height, width, 3) of 0 to 255."""
        self.settle()
        path = self.folder / "picture.png"
        self.screenshot(path)
        return np.rint(255 * matplotlib.image.imread(BytesIO(path.read_bytes()))[..., :3]).astype(int)


def pixels_near(picture, colour, tolerance=24):
    """How many pixels have a colour."""
    return int((np.abs(picture - colour).max(axis=2) <= tolerance).sum())
