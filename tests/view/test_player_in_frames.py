"""The player in a frame of another page: a notebook, or a site with a button for dark colours."""

import numpy as np
import pytest

from skpose.datasets import make_gait
from skpose.motions import align_motions
from skpose.view import explorer, player
from skpose.view._page import HEIGHT

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def comparison():
    """The page with the most controls: two motions that are aligned."""
    gait = make_gait(n_subjects=2, n_sequences=1, duration=0.5, frame_rate=20, random_state=0)
    a, b = gait[gait.actions == "walk"].motions
    return player([a, b], alignment=align_motions(a, b))


def open_framed(browser, page, theme="light", style=""):
    """Show a page in the frame of another page; the driver is then in the frame."""
    document = f"<!DOCTYPE html><style>{style}</style><body style='margin: 0'>{page._repr_html_()}</body>"
    browser.open(document, theme=theme)
    browser.driver.switch_to.frame(browser.find("iframe"))
    browser.wait("window.skpose && skpose.state.drawn > 0")


def test_a_notebook_shows_the_player(browser, comparison):
    open_framed(browser, comparison)
    assert browser.js("window.innerHeight") == HEIGHT
    assert len(np.unique(browser.picture().reshape(-1, 3), axis=0)) > 5
    browser.driver.switch_to.default_content()
    assert [problem for problem in browser.problems() if problem != "about:srcdoc"] == []


@pytest.mark.parametrize("kind", ["player", "explorer"])
def test_the_help_can_be_closed_in_a_frame(browser, comparison, kind):
    """A frame of a notebook may run scripts, and not send forms."""
    gait = make_gait(n_subjects=1, n_sequences=1, duration=0.5, frame_rate=12, random_state=0)
    open_framed(browser, comparison if kind == "player" else explorer(gait, metrics=["position"]))
    browser.click("#help")
    assert browser.find("#about").is_displayed()
    assert browser.js("document.getElementById('about').scrollTop") == 0
    browser.click("#close")
    assert not browser.find("#about").is_displayed()


@pytest.mark.parametrize("system", ["light", "dark"])
def test_colours_are_those_of_the_page_around(browser, comparison, system):
    """Follow what the style sheet of the page states, and not the system, also when it changes."""
    open_framed(browser, comparison, theme=system, style=".dark { color-scheme: dark } .light { color-scheme: light }")
    frame = "document.documentElement.dataset.theme"
    assert browser.js(frame) == system  # the page states nothing
    for theme in ("dark", "light", "dark"):
        browser.driver.switch_to.default_content()
        browser.driver.execute_script("document.documentElement.className = arguments[0]", theme)
        browser.driver.switch_to.frame(browser.find("iframe"))
        browser.wait(f"{frame} === '{theme}'")
        assert (browser.picture("body")[60, 300].mean() < 60) == (theme == "dark")
    browser.click("#theme")
    assert browser.js(frame) == "light"
    browser.driver.switch_to.default_content()
    for theme in ("light", "dark"):  # the player's own button counts
        browser.driver.execute_script("document.documentElement.className = arguments[0]", theme)
        browser.driver.switch_to.frame(browser.find("iframe"))
        browser.settle()
        assert browser.js(frame) == "light"
        browser.driver.switch_to.default_content()


@pytest.mark.parametrize("touch", [False, True], ids=["mouse", "finger"])
@pytest.mark.parametrize("width", [320, 388, 420, 640, 960])
def test_a_frame_shows_all_controls_without_scrolling(browser, comparison, width, touch):
    browser.open(comparison, size=(width, HEIGHT), touch=touch)
    assert browser.js("document.documentElement.scrollHeight") <= HEIGHT
    assert browser.js("document.documentElement.scrollWidth") <= width
    last = browser.find("#differences").rect
    assert last["y"] + last["height"] <= HEIGHT
    assert browser.find("#stage").rect["height"] >= 200
