"""Chromium without a window, driven by selenium, for tests of pages.

`Browser.open` shows a page, `problems` lists what its console and the network saw, and the rest is a user: mouse,
fingers, keys, settings of the system.
"""

import json
import os
import shutil
from io import BytesIO

import matplotlib.image
import numpy as np
import pytest

BROWSERS = "chromium", "chromium-browser", "google-chrome", "google-chrome-stable"
PATIENCE = 60  # s, for what happens at once on an idle machine


def programs():
    """Return the paths of Chromium and of its driver; the test is skipped where one is missing."""
    binary = next(filter(None, map(shutil.which, BROWSERS)), None)
    driver = shutil.which("chromedriver")
    if not binary or not driver:
        missing = "Chromium" if not binary else "chromedriver"
        pytest.skip(f"there is no {missing} for tests in a browser; on Debian: apt-get install chromium-driver")
    return binary, driver


class Browser:
    def __init__(self, folder):
        selenium = pytest.importorskip("selenium", reason="tests in a browser need selenium: pip install '.[test]'")
        from selenium.webdriver import Chrome, ChromeOptions, ChromeService

        binary, driver = programs()
        options = ChromeOptions()
        options.binary_location = binary
        sandbox = ["--no-sandbox"] if getattr(os, "geteuid", lambda: 1)() == 0 else []  # which root must not have
        for argument in ["--headless=new", "--disable-gpu", "--disable-dev-shm-usage", "--hide-scrollbars", *sandbox]:
            options.add_argument(argument)
        options.set_capability("goog:loggingPrefs", {"browser": "ALL", "performance": "ALL"})
        self.driver = Chrome(options, ChromeService(driver))
        self.driver.set_script_timeout(PATIENCE)
        self.folder, self.n_pages, self.version = folder, 0, selenium.__version__

    def close(self):
        self.driver.quit()

    # --- pages ---

    def open(self, page, *, size=(1000, 700), density=1, theme="light", still=True, touch=False):
        """Show a page, and wait until it has drawn something."""
        self.set(size=size, density=density, theme=theme, still=still, touch=touch)
        self.n_pages += 1
        path = self.folder / f"{self.n_pages}.html"
        path.write_text(page if isinstance(page, str) else page.html, encoding="utf-8")
        for log in ("browser", "performance"):
            self.driver.get_log(log)  # of the page before
        self.url = path.as_uri()
        self.driver.get(self.url)
        if not isinstance(page, str):
            self.wait("window.skpose && skpose.state.drawn > 0")
        return self

    def set(self, *, size=(1000, 700), density=1, theme="light", still=True, touch=False):
        """Set what the system says: size of the window, px, pixels in a px, dark or light, reduced motion, a finger."""
        self.tool(
            "Emulation.setDeviceMetricsOverride",
            {"width": size[0], "height": size[1], "deviceScaleFactor": density, "mobile": touch},
        )
        features = {
            "prefers-color-scheme": theme,
            "prefers-reduced-motion": "reduce" if still else "no-preference",
        }
        media = [{"name": name, "value": value} for name, value in features.items()]
        self.tool("Emulation.setEmulatedMedia", {"features": media})
        self.tool("Emulation.setTouchEmulationEnabled", {"enabled": touch, "maxTouchPoints": 2})

    def tool(self, command, parameters):
        """Call Chromium's development tools."""
        return self.driver.execute_cdp_cmd(command, parameters)

    def js(self, expression, *arguments):
        """Return the value of an expression in the page; `arguments` is an array there."""
        return self.driver.execute_script(f"return {expression}", *arguments)

    def wait(self, expression):
        """Wait until an expression is true in the page."""
        from selenium.webdriver.support.ui import WebDriverWait

        WebDriverWait(self.driver, PATIENCE, 0.02).until(lambda _: self.js(expression), message=expression)

    def settle(self):
        """Wait until all that was asked for has been drawn."""
        code = "const done = arguments[0]; requestAnimationFrame(() => requestAnimationFrame(() => done()))"
        self.driver.execute_async_script(code)
        self.wait("!window.skpose?.state.stale")

    def problems(self):
        """Return all messages in the console, and all requests but the one for the page itself."""
        messages = [entry["message"] for entry in self.driver.get_log("browser")]
        events = [json.loads(entry["message"])["message"] for entry in self.driver.get_log("performance")]
        requests = [e["params"]["request"]["url"] for e in events if e["method"] == "Network.requestWillBeSent"]
        assert requests.count(self.url) == 1, "the log of requests does not work"
        return messages + [url for url in requests if url != self.url]

    def corner(self):
        """Return where the canvas begins in the page, px."""
        box = self.js("skpose.stage.canvas.getBoundingClientRect().toJSON()")
        return box["left"], box["top"]

    # --- a user ---

    def find(self, css):
        return self.driver.find_element("css selector", css)

    def click(self, css):
        self.find(css).click()
        self.settle()

    def choose(self, css, value):
        """Choose an option of a menu by its value."""
        from selenium.webdriver.support.ui import Select

        Select(self.find(css)).select_by_value(value)
        self.settle()

    def press(self, *keys, css=None):
        """Press keys, one after another, in an element or where the focus is; names are those of selenium's Keys."""
        from selenium.webdriver.common.keys import Keys

        into = self.find(css) if css else self.driver.switch_to.active_element
        for key in keys:
            into.send_keys(getattr(Keys, key, key))
        self.settle()

    def mouse(self, *events, modifiers=0, button="left"):
        """Move and press the mouse at places of the canvas, px: ("moved", x, y), ("pressed", …), ("released", …)."""
        left, top = self.corner()
        held = 0
        for kind, x, y in events:
            held = {"pressed": 1, "released": 0}.get(kind, held)
            click = {"button": button, "clickCount": 1} if kind != "moved" else {}
            place = {"x": left + x, "y": top + y, "modifiers": modifiers, "buttons": held}
            self.tool("Input.dispatchMouseEvent", {"type": f"mouse{kind.capitalize()}", **place, **click})
        self.settle()

    def wheel(self, x, y, delta):
        left, top = self.corner()
        wheel = {"type": "mouseWheel", "x": left + x, "y": top + y, "deltaX": 0, "deltaY": delta}
        self.tool("Input.dispatchMouseEvent", wheel)
        self.settle()

    def fingers(self, *steps):
        """Put down fingers, move them from step to step, lift them; a step is a list of places of the canvas, px.

        A display reports a finger once a frame. Of steps that come faster Chromium scrolls by some only, by chance.
        """
        left, top = self.corner()
        for i, step in enumerate(steps):
            points = [{"x": left + x, "y": top + y, "id": k} for k, (x, y) in enumerate(step)]
            self.tool("Input.dispatchTouchEvent", {"type": "touchMove" if i else "touchStart", "touchPoints": points})
            self.settle()
        self.tool("Input.dispatchTouchEvent", {"type": "touchEnd", "touchPoints": []})
        self.settle()

    def picture(self, css="canvas"):
        """Return what is seen of an element, (height, width, 3) of 0 to 255."""
        self.settle()
        image = matplotlib.image.imread(BytesIO(self.find(css).screenshot_as_png))
        return np.rint(255 * image[..., :3]).astype(int)


def pixels_near(picture, colour, tolerance=24):
    """Return how many pixels have a colour."""
    return int((np.abs(picture - colour).max(axis=2) <= tolerance).sum())


def changed(before, after):
    """Return how many pixels differ."""
    return int((np.abs(before - after).max(axis=2) > 16).sum())
