"""The explorer in Chromium: keys, mouse, fingers, settings of the system, unusual names and collections of motions."""

import numpy as np
import pytest
from browser import changed, pixels_near
from explorer_page import Held, apart, click, drag, places, shown
from matplotlib.path import Path as Polygon

from skpose import Bone, Motion, Skeleton
from skpose.datasets import MotionDataset, make_gait
from skpose.view import explorer

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def gait():
    """Four motions of two people."""
    return make_gait(n_subjects=2, n_sequences=1, duration=1.0, frame_rate=24, random_state=0)


@pytest.fixture(scope="module")
def page(gait):
    return explorer(gait, metrics=["spatial", "angle"])


@pytest.fixture(scope="module")
def held(gait, page):
    return Held(page, gait.skeleton)


def view_of(browser):
    browser.settle()
    return browser.js("[skpose.stage.zoom, ...skpose.stage.centre]")


# --- keys -------------------------------------------------------------------------------------------------------------


def test_arrows_go_from_point_to_point(browser, page, held):
    browser.open(page)
    where = places(browser)
    at = 0  # that of the time
    for key, direction in [
        ("ARROW_RIGHT", [1, 0]),
        ("ARROW_UP", [0, -1]),
        ("ARROW_LEFT", [-1, 0]),
        ("ARROW_DOWN", [0, 1]),
    ] * 2:
        browser.press(key, css="#canvas")
        row = browser.js("skpose.state.hover")
        step = where[row] - where[at]
        assert row != at
        assert step @ direction > abs(step @ direction[::-1])  # rather there than to a side
        ahead = (where - where[at]) @ direction
        across = np.abs((where - where[at]) @ direction[::-1])
        in_sector = np.flatnonzero(ahead > across)
        assert row == in_sector[(ahead + 2 * across)[in_sector].argmin()]
        assert browser.find("#status").get_attribute("textContent") == held.name(row)  # is read aloud
        np.testing.assert_allclose(shown(browser)[0], held.figure(held.X[row]), atol=1e-9)
        at = row


def test_arrows_keep_the_point_in_view(browser, page):
    browser.open(page)
    browser.press(*["+"] * 12, css="#canvas")
    for key in ["ARROW_LEFT", "ARROW_UP", "ARROW_LEFT", "ARROW_DOWN"]:
        browser.press(key, css="#canvas")
        x, y = places(browser)[browser.js("skpose.state.hover")]
        width, height = browser.js("[skpose.stage.width, skpose.stage.height]")
        assert 27 <= x <= width - 27
        assert 27 <= y <= height - 27


def shift_enter(browser):
    from selenium.webdriver.common.keys import Keys

    browser.find("#canvas").send_keys(Keys.SHIFT + Keys.ENTER + Keys.NULL)
    browser.settle()


def test_two_poses_are_chosen_by_keys(browser, page):
    browser.open(page)
    browser.press("ARROW_RIGHT", "ENTER", css="#canvas")
    first = browser.js("skpose.state.first")
    assert browser.js("[skpose.state.current, skpose.state.hover]") == [first, -1]
    browser.press("ARROW_RIGHT", "ARROW_RIGHT", css="#canvas")
    second = browser.js("skpose.state.hover")
    shift_enter(browser)
    assert browser.js("[skpose.state.comparison.first, skpose.state.comparison.second]") == [first, second]
    browser.wait("skpose.state.comparison.geodesic")
    browser.press("ESCAPE", css="#canvas")
    assert browser.js("skpose.state.comparison") is None
    assert not browser.find("#compared").is_displayed()


def test_a_lasso_by_keys(browser, page, held):
    browser.open(page)
    browser.find("input[value=lasso]").click()
    corners = []
    for keys in (["ARROW_RIGHT"] * 9, ["ARROW_UP"] * 6, ["ARROW_LEFT"] * 9 + ["ARROW_DOWN"]):
        browser.press(*keys, "ENTER", css="#canvas")
        corners.append(places(browser)[browser.js("skpose.state.hover")])
    inside = set(browser.js("skpose.state.inside"))
    where = places(browser)
    assert inside <= set(np.flatnonzero(Polygon(corners).contains_points(where, radius=1e-6))) | set(
        np.flatnonzero(Polygon(corners).contains_points(where, radius=-1e-6))
    )
    assert inside >= set(np.flatnonzero(Polygon(corners).contains_points(where))) - {
        int(np.linalg.norm(where - c, axis=1).argmin()) for c in corners
    }
    assert len(inside) > 0
    assert browser.find("#inside").is_displayed()
    browser.press("ESCAPE", css="#canvas")
    assert browser.js("[skpose.state.inside, skpose.state.lasso.length]") == [None, 0]


def test_keys_of_time_and_view(browser, page, held):
    browser.open(page)
    start = view_of(browser)
    browser.press("ARROW_RIGHT", "ENTER", "HOME", css="#canvas")
    row = browser.js("skpose.state.current")
    rows = held.rows(row)
    assert row == rows[0]
    browser.press(".", ".", ",", css="#canvas")
    assert browser.js("skpose.state.current") == rows[1]
    browser.press("END", ".", css="#canvas")
    assert browser.js("skpose.state.current") == rows[-1]
    browser.press("HOME", ",", css="#canvas")
    assert browser.js("skpose.state.current") == rows[0]
    browser.press(" ", css="#canvas")
    assert browser.js("skpose.state.playing")
    browser.press(" ", css="#canvas")
    assert not browser.js("skpose.state.playing")
    browser.press("+", css="#canvas")
    assert view_of(browser)[0] == pytest.approx(1.25 * start[0])
    browser.press("-", "-", css="#canvas")
    assert view_of(browser)[0] == pytest.approx(start[0] / 1.25)
    from selenium.webdriver.common.keys import Keys

    before = view_of(browser)
    browser.find("#canvas").send_keys(Keys.SHIFT + Keys.ARROW_RIGHT + Keys.NULL)
    assert view_of(browser)[1] > before[1]
    browser.press("0", css="#canvas")
    assert view_of(browser) == start


def test_everything_can_be_used_without_a_mouse(browser, page):
    """Tab reaches all controls, each has a name, and the focus is seen."""
    browser.open(page)
    names = []
    for _ in range(20):
        browser.press("TAB")
        names.append(
            browser.js(
                "(({ id, ariaLabel, labels, textContent }) => id + '|'"
                " + (ariaLabel || labels?.[0]?.textContent || textContent).trim())(document.activeElement)"
            )
        )
        if not browser.js("document.activeElement === document.body"):
            assert browser.js("getComputedStyle(document.activeElement).outlineStyle") != "none"
    reached = {name.partition("|")[0] for name in names}
    assert {"theme", "help", "metric", "colour", "canvas", "home", "figure", "play", "time"} <= reached
    assert all(name.partition("|")[2] for name in names)
    browser.press("ENTER", css="#help")
    assert browser.find("#about").is_displayed()
    facts = browser.find("#facts").text
    assert "48 poses of 4 motions, 12 poses a second" in facts
    assert "Joints are within 0.1" in facts
    browser.press("ESCAPE")
    assert not browser.find("#about").is_displayed()


# --- mouse and fingers ------------------------------------------------------------------------------------------------


def test_dragging_moves_the_points_with_the_mouse(browser, page):
    browser.open(page)
    before = places(browser)
    drag(browser, (200, 200), (240, 180), (260, 170))
    np.testing.assert_allclose(places(browser) - before, np.tile([60, -30], (len(before), 1)), atol=1e-6)
    assert browser.js("skpose.state.first") == -1
    browser.click("#home")
    drag(browser, before[7] + [60, 40], before[7] + [30, 30], before[7])
    np.testing.assert_allclose(places(browser)[0], before[0] - [60, 40], atol=1e-6)
    drag(browser, *(places(browser)[7] + [[0, 0], [20, 20], [0, 0]]))  # to the point where it began
    assert browser.js("skpose.state.first") == -1  # no click
    browser.click("#home")
    np.testing.assert_allclose(places(browser), before, atol=1e-6)


def test_the_wheel_zooms_where_the_mouse_is(browser, page):
    browser.open(page)
    before = places(browser)
    mouse = np.array([150.0, 120.0])
    browser.wheel(*mouse, -300)
    browser.wait("skpose.stage.zoom > 1")
    zoom = browser.js("skpose.stage.zoom")
    np.testing.assert_allclose(places(browser), mouse + zoom * (before - mouse), atol=1e-6)
    for _ in range(30):
        browser.wheel(*mouse, 1000)
    assert browser.js("skpose.stage.zoom") == 0.5  # the points are never lost


def test_fingers(browser, page, held):
    browser.open(page, touch=True, size=(420, 900))
    before = places(browser)
    browser.fingers([(150, 150)], [(170, 150)], [(190, 180)])  # one moves
    np.testing.assert_allclose(places(browser) - before, np.tile([40, 30], (len(before), 1)), atol=1e-6)
    browser.click("#home")
    browser.fingers([(150, 150), (250, 150)], [(100, 150), (300, 150)])  # two zoom
    assert browser.js("skpose.stage.zoom") == pytest.approx(2.0)
    np.testing.assert_allclose(places(browser), [200, 150] + 2 * (before - [200, 150]), atol=1e-6)
    assert browser.js("skpose.state.first") == -1
    where = places(browser)
    width, height = browser.js("[skpose.stage.width, skpose.stage.height]")
    inside = ((where > 5) & (where < [width - 5, height - 5])).all(axis=1)
    a, b = [int(row) for row in apart(where, 12) if inside[row]][:2]
    browser.fingers([tuple(where[a])])  # a tap
    assert browser.js("skpose.state.first") == a
    browser.click("input[value=compare]")
    browser.fingers([tuple(where[b])])
    browser.wait("skpose.state.comparison?.geodesic")
    assert browser.js("[skpose.state.comparison.first, skpose.state.comparison.second]") == [a, b]


def test_a_lasso_by_a_finger(browser, page, held):
    browser.open(page, touch=True, size=(420, 900))
    browser.click("input[value=lasso]")
    where = places(browser)
    corners = [(30, 20), (330, 60), (300, 300), (150, 420)]
    browser.fingers(*([corner] for corner in corners))
    expected = np.flatnonzero(Polygon(corners).contains_points(where))
    assert len(expected) > 5
    np.testing.assert_array_equal(browser.js("skpose.state.inside"), expected)


# --- settings of the system -------------------------------------------------------------------------------------------


def test_dark_and_light(browser, page):
    browser.open(page, theme="dark")
    dark = browser.picture("#points")
    assert pixels_near(dark, (20, 23, 27), 6) > 0.8 * dark[..., 0].size
    assert pixels_near(dark, (86, 180, 233)) > 100  # the first group
    browser.click("#theme")
    light = browser.picture("#points")
    assert pixels_near(light, (255, 255, 255), 6) > 0.8 * light[..., 0].size
    assert pixels_near(light, (0, 114, 178)) > 100
    browser.set(theme="light")
    browser.open(page, theme="light")
    assert changed(light, browser.picture("#points")) == 0


@pytest.mark.parametrize("size", [(1300, 800), (420, 900), (320, 700)], ids=str)
def test_nothing_is_cut_off(browser, page, size):
    browser.open(page, size=size, touch=size[0] < 500)
    click(browser, places(browser)[3]) if size[0] > 500 else browser.fingers([tuple(places(browser)[3])])
    assert browser.js("document.documentElement.scrollWidth") <= size[0]
    for css in ("#metric", "#colour", "#modes", "#home", "#theme", "#help", "#play", "#time", "#clock", "#groups"):
        box = browser.find(css).rect
        assert box["x"] >= 0, css
        assert box["x"] + box["width"] <= size[0] + 0.5, css
    for css, least in (("#points", 200), ("#figure", 200)):
        assert min(browser.find(css).size.values()) > least
        picture = browser.picture(css)
        assert len(np.unique(picture.reshape(-1, 3), axis=0)) > 20  # something is drawn


def test_texts_have_contrast(browser, page):
    """Of at least 4.5 to 1 for words; groups 3 to 1."""

    def luminance(rgb):
        c = np.array(rgb) / 255
        return np.where(c <= 0.03928, c / 12.92, ((c + 0.055) / 1.055) ** 2.4) @ [0.2126, 0.7152, 0.0722]

    def colour(name):
        text = browser.js(f"getComputedStyle(document.documentElement).getPropertyValue('--{name}')").strip()
        return [int(text[i : i + 2], 16) for i in (1, 3, 5)]

    for theme in ("light", "dark"):
        browser.open(page, theme=theme)
        paper = luminance(colour("paper"))
        for i in range(10):
            mark = luminance(colour(f"motion-{i}" if i < 5 else f"group-{i}"))
            assert (max(mark, paper) + 0.05) / (min(mark, paper) + 0.05) > 3, (theme, i)


# --- unusual collections ----------------------------------------------------------------------------------------------

NAMES = ["<script>window.evil = 1</script>", "<img src=x onerror='window.evil = 1'>", "שלום"]


def test_names_are_text(browser):
    skeleton = Skeleton(Bone(name, None, (0.1 * i, 1, 0), "z") for i, name in enumerate(NAMES))
    rng = np.random.default_rng(0)
    motions = [Motion(skeleton, rng.normal(size=(4, 3)), 30) for _ in NAMES]
    browser.open(explorer(MotionDataset(motions, NAMES, NAMES, NAMES), title=NAMES[0], frame_rate=None))
    assert browser.find("h1").text == NAMES[0]
    where = places(browser)
    row = int(apart(where)[0])
    click(browser, where[row])
    click(browser, where[int(apart(where)[1])], modifiers=8)
    drag(browser, (1, 1), (600, 1), (600, 500), (1, 500), modifiers=8)
    for by in ("subject", "action", "motion"):
        browser.choose("#colour", by)
        listed = browser.find("#groups").text
        assert all(name in listed for name in NAMES)
    browser.wait("skpose.state.comparison.geodesic || skpose.state.comparison.failure")
    for css in ("#pair", "#motions"):
        assert "<script>" in browser.find(css).text or "<img" in browser.find(css).text
    browser.mouse(("moved", *where[row]))
    assert browser.js("window.evil") is None
    assert browser.problems() == []


def test_motions_without_labels(browser, gait):
    bare = explorer(MotionDataset(gait.motions), metrics=["angle"])
    browser.open(bare)
    options = [option.text for option in browser.driver.find_elements("css selector", "#colour option")]
    assert options == ["motion", "time"]
    assert browser.find("#groups").text.split("\n")[:2] == ["motion 1", "12"]
    assert browser.problems() == []


def test_times_of_motions_that_begin_late_and_lack_frames(browser):
    angles = np.random.default_rng(0).normal(size=(5, 3))
    motion = Motion(Skeleton.chain(3), angles, 10, frame_numbers=[20, 21, 25, 26, 30])
    browser.open(explorer(MotionDataset([motion]), metrics=["angle"], frame_rate=None))
    seen = []
    for _ in range(5):
        seen.append(browser.find("#clock").text)
        browser.press(".", css="#canvas")
    assert seen == ["0.00 s", "0.10 s", "0.50 s", "0.60 s", "1.00 s"]
    rows = browser.js("[0, 0.05, 0.1, 0.3, 0.5, 0.99, 1, 7].map((t) => skpose.poses.rowAt({ first: 0, end: 5 }, t))")
    assert rows == [0, 0, 1, 1, 2, 3, 4, 4]


@pytest.mark.filterwarnings("ignore:.*positive eigenvalues.*", "ignore:all distances are zero.*")
@pytest.mark.parametrize("angles", [[[0.0], [1.0], [0.2]], [[0.5]] * 4], ids=["on a line", "equal"])
def test_poses_on_a_line_or_in_one_place(browser, angles):
    """Points that have no extent."""
    dataset = MotionDataset([Motion(Skeleton.chain(1), angles, 30)])
    browser.open(explorer(dataset, metrics=["angle"], frame_rate=None))
    where = places(browser)
    assert np.isfinite(where).all()
    width, height = browser.js("[skpose.stage.width, skpose.stage.height]")
    assert ((where >= 20) & (where <= [width - 20, height - 20])).all()
    click(browser, where[1])
    assert browser.js("skpose.state.first") >= 0
    browser.press("+", "-", "ARROW_RIGHT", "ENTER", css="#canvas")
    shift_enter(browser)
    browser.wait("skpose.state.comparison.geodesic || skpose.state.comparison.failure")
    assert browser.js("skpose.state.comparison.failure") == ""
    assert np.isfinite(np.array(shown(browser))).all()
    assert browser.problems() == []


def test_in_a_notebook_the_wheel_scrolls_the_notebook(browser, page):
    """Unless the points are in use."""
    host = f"<!DOCTYPE html><body style='margin: 0; height: 3000px'>{page._repr_html_()}</body>"
    browser.open(host, size=(1000, 700))
    frame = browser.find("iframe")
    browser.driver.switch_to.frame(frame)
    browser.wait("document.getElementById('canvas') !== null")
    browser.driver.switch_to.default_content()
    browser.tool("Input.dispatchMouseEvent", {"type": "mouseWheel", "x": 200, "y": 300, "deltaX": 0, "deltaY": 200})
    browser.wait("window.scrollY > 0")
