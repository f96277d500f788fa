"""The explorer in Chromium: one state follows another; what is seen, and what is announced."""

import numpy as np
import pytest
from explorer_page import Held, click, drag, places, shown

from skpose.datasets import MotionDataset, load_hdm05, make_gait
from skpose.view import explorer

pytestmark = pytest.mark.slow
SHIFT = 8  # of the mouse


@pytest.fixture(scope="module")
def gait():
    """Four motions of two people."""
    return make_gait(n_subjects=2, n_sequences=1, duration=1.0, frame_rate=24, random_state=0)


@pytest.fixture(scope="module")
def page(gait):
    return explorer(gait, metrics=["spatial"])


@pytest.fixture(scope="module")
def held(gait, page):
    return Held(page, gait.skeleton)


@pytest.mark.parametrize("key", [",", ".", "HOME", "END", " "])
def test_a_pose_reached_by_an_arrow_gives_way_to_time(browser, page, held, key):
    browser.open(page)
    browser.press("ENTER", ".", ".", "ARROW_RIGHT", css="#canvas")
    assert browser.js("skpose.state.hover") >= 0
    browser.press(key, css="#canvas")
    assert browser.js("skpose.state.hover") == -1
    if key == " ":
        browser.press(" ", css="#canvas")
    row = browser.js("skpose.state.current")
    assert browser.find("#caption").text == held.name(row)
    np.testing.assert_allclose(shown(browser)[0], held.figure(held.X[row]), atol=1e-9)


@pytest.mark.parametrize("end", ["choose", "compare", "close"])
def test_a_search_ends_when_nobody_waits_for_it(browser, page, end):
    """It takes no more of the processor, and its path is not shown."""
    browser.open(page)
    where = places(browser)
    a, b = np.unravel_index(np.linalg.norm(where[:, None] - where, axis=2).argmax(), (len(where),) * 2)
    click(browser, where[a])
    click(browser, where[b], modifiers=SHIFT)
    browser.driver.execute_script("window.search = skpose.state.comparison")
    if end == "close":
        browser.click("#end")
        assert browser.driver.switch_to.active_element.get_attribute("id") == "canvas"
    else:
        click(browser, where[a], modifiers=SHIFT if end == "compare" else 0)
    assert browser.js("search.stopped")
    assert browser.js("skpose.state.comparison === search") is False


def test_a_search_that_is_stopped_throws(browser, page):
    browser.open(page)
    where = places(browser)
    click(browser, where[0])
    click(browser, where[30], modifiers=SHIFT)
    code = "(async ({ constructor: Comparison }) => { const one = new Comparison(skpose.poses, 0, 30, () => {});"
    code += " one.stop(); await one.done; return [one.geodesic, one.failure]; })(skpose.state.comparison)"
    assert browser.js(code) == [None, "the search was stopped"]


def test_what_is_compared_is_announced(browser, page, held):
    browser.open(page)
    where = places(browser)
    click(browser, where[3])
    click(browser, where[30], modifiers=SHIFT)
    browser.wait("skpose.state.comparison?.geodesic")
    browser.settle()
    first, second = browser.js("[skpose.state.comparison.first, skpose.state.comparison.second]")
    path = browser.find("#shortest").text
    assert path.startswith("shortest path, ")
    status = browser.js("document.getElementById('status').textContent")
    assert status == f"{held.name(second)} compared with {held.name(first)}; {path}"


def test_corners_by_keys_begin_a_new_lasso_and_are_announced(browser, page):
    browser.open(page)
    drag(browser, (5, 5), (400, 5), (400, 300), (5, 300), modifiers=SHIFT)
    assert len(browser.js("skpose.state.lasso")) > 1
    browser.find("input[value=lasso]").click()
    for n in (1, 2, 3):
        browser.press("ARROW_RIGHT", "ENTER", css="#canvas")
        assert len(browser.js("skpose.state.lasso")) == n
        status = browser.js("document.getElementById('status').textContent")
        assert f"; lasso of {n} corner{'s' * (n > 1)}" in status
    assert status.endswith(f", {len(browser.js('skpose.state.inside'))} poses inside")
    browser.click("#release")
    assert browser.driver.switch_to.active_element.get_attribute("id") == "canvas"


def test_an_empty_lasso_leaves_all_points_as_they_are(browser, page):
    browser.open(page)
    drag(browser, (2, 2), (12, 2), (12, 12), (2, 12), modifiers=SHIFT)
    assert browser.js("skpose.state.inside") == []
    assert browser.js("skpose.stage.faded") is None


def test_colours_begin_with_what_differs(browser, gait):
    one = gait[gait.subjects == gait.subjects[0]]
    browser.open(explorer(one, metrics=["position"]))
    assert browser.find("#colour").get_attribute("value") == "action"
    browser.open(explorer(MotionDataset(one.motions), metrics=["position"]))
    assert browser.find("#colour").get_attribute("value") == "motion"


@pytest.mark.parametrize("size", [(740, 360), (640, 420)], ids=str)
def test_a_phone_on_its_side_shows_points_and_controls(browser, page, size):
    browser.open(page, size=size, touch=True)
    assert browser.js("document.documentElement.scrollHeight") <= size[1]
    for css in ("#points", "#stage", "#play"):
        box = browser.find(css).rect
        assert 0 <= box["y"] < box["y"] + min(box["height"], 100) <= size[1]


def test_a_frame_of_a_notebook_shows_all_distances(browser, page):
    browser.open(page, size=(900, 600))
    where = places(browser)
    click(browser, where[3])
    click(browser, where[30], modifiers=SHIFT)
    last = browser.find("#distances tr:last-child").rect
    assert last["y"] + last["height"] <= 600


def test_left_and_right_are_named(browser, page):
    browser.open(page)
    named = browser.picture("#figure")[:24, -90:]
    browser.driver.execute_script("window.skpose.poses.data.skeleton.sides.fill(''); skpose.view.fit(true)")
    browser.click("#home")
    assert (named != named[0, 0]).any()
    assert (browser.picture("#figure")[:24, -90:] == named[0, 0]).all()


def test_geodesics_with_the_root_are_near_those_of_python(browser, hdm05_folder):
    """Ball joints and a root that turns: the page may end in another minimum, see docs/view.md."""
    from skpose import geodesic

    dataset = load_hdm05(hdm05_folder).to_rotvec().with_root("tilt")
    chosen = dataset[::40]
    held = Held(page := explorer(chosen, metrics=["position"], frame_rate=2), chosen.skeleton)
    browser.open(page)
    where = places(browser)
    click(browser, where[0])
    click(browser, where[np.linalg.norm(where - where[0], axis=1).argmax()], modifiers=SHIFT)
    code = "(async (a, b) => { const one = new skpose.state.comparison.constructor(skpose.poses, a, b, () => {});"
    code += " await one.done; return one.geodesic.length; })(...arguments)"
    rng = np.random.default_rng(0)
    for a, b in rng.choice(len(held.X), (6, 2)).tolist():
        expected = geodesic(held.X[a], held.X[b], held.skeleton).length
        assert browser.js(code, a, b) == pytest.approx(expected, rel=5e-3)
