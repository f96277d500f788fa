"""Files of the explorer in Chromium: pictures and videos of the points with the pose next to them."""

from io import BytesIO

import numpy as np
import pytest
from browser import pixels_near
from explorer_page import apart, click, places
from files_of_page import duration_of, file_of, link_of
from PIL import Image, ImageSequence

from skpose.datasets import make_actions
from skpose.view import explorer

pytestmark = pytest.mark.slow
SIZE = "[skpose.sheet.canvas.clientWidth, skpose.sheet.canvas.clientHeight]"


@pytest.fixture(scope="module")
def page():
    actions = make_actions(2, 1, actions=["kick", "squat", "wave"], random_state=0)
    return explorer(actions, frame_rate=8, metrics=["spatial"], title="three actions")


@pytest.mark.parametrize("paper", [True, False])
@pytest.mark.parametrize("size", [(1300, 860), (420, 850)], ids=str)
def test_picture_has_the_points_as_the_page_and_the_pose_next_to_it(browser, page, size, paper):
    browser.open(page, size=size, density=2)
    if not paper:
        browser.driver.execute_script("document.getElementById('paper').checked = false")
    plane, figure = browser.picture("#canvas"), browser.picture("#figure")
    whole = browser.js(SIZE)
    name, kind, content = file_of(browser, "#picture")
    assert (name, kind) == ("three_actions.png", "image/png")
    image = Image.open(BytesIO(content)).convert("RGBA")
    np.testing.assert_allclose(image.size, np.multiply(2, whole), atol=2)
    assert image.getpixel((3, 3)) == ((255,) * 4 if paper else (0,) * 4)
    onto = Image.new("RGBA", image.size, (255, 255, 255, 255))
    drawn = np.asarray(Image.alpha_composite(onto, image).convert("RGB")).astype(int)
    height, width = (min(a, b) for a, b in zip(plane.shape[:2], drawn.shape[:2], strict=True))
    off = np.abs(drawn[:height, :width] - plane[:height, :width]).max(axis=2)[8:-8, 8:-8]  # without the focus
    assert (off > 40).mean() < 2e-3
    tall = size[0] < 600
    top, left = (height, 0) if tall else (0, width)
    other = drawn[top:, left:]
    for colour in ((0, 114, 178), (192, 79, 0)):  # of the sides
        assert pixels_near(other, colour) >= pixels_near(figure, colour) > 300


def test_picture_is_of_the_state_of_the_page(browser, page):
    """Another pose, zoom and group make another picture; the page itself stays as it is."""
    browser.open(page)
    first = file_of(browser, "#picture")[2]
    assert file_of(browser, "#picture")[2] == first
    before = browser.picture("#points")
    where = places(browser)
    click(browser, where[apart(where)[4]])
    browser.press("+", "+", css="#canvas")
    second = file_of(browser, "#picture")[2]
    assert second != first
    browser.press("0", css="#canvas")
    browser.driver.execute_script("location.hash = 'pose=0'")
    browser.wait("skpose.state.current === 0")
    browser.mouse(("moved", 2, 2))
    assert browser.picture("#points").shape == before.shape


def test_picture_says_what_the_colours_mean(browser, page):
    browser.open(page)
    key = "skpose.sheet.keyOf(skpose.state).groups.map(({ words, colour }) => [words, colour])"
    assert len({colour for _, colour in browser.js(key)}) > 1
    browser.choose("#colour", "time")
    longest = browser.find("#most").text
    words, shades = zip(*browser.js(key), strict=True)
    assert words[0] == "0.00 s"
    assert words[-1] == longest
    assert len(set(shades)) == 3


def test_gif_is_the_motion_that_plays(browser, page):
    browser.open(page, size=(420, 860))
    duration = browser.js("skpose.poses.duration(skpose.poses.range(skpose.state.current))")
    name, kind, content = file_of(browser, "#gif")
    assert (name, kind) == ("three_actions.gif", "image/gif")
    image = Image.open(BytesIO(content))
    pictures = [(frame.info["duration"], np.asarray(frame.convert("RGB"))) for frame in ImageSequence.Iterator(image)]
    assert sum(seconds for seconds, _ in pictures) == pytest.approx(1e3 * duration, abs=40)
    first, last = pictures[0][1], pictures[len(pictures) // 2][1]
    assert (first != last).any()
    size = np.multiply(min(1, 800 / max(browser.js(SIZE))), browser.js(SIZE))
    np.testing.assert_allclose(image.size, size, atol=2)


def test_gif_of_two_poses_is_that_of_the_paths(browser, page):
    browser.open(page, size=(420, 860))
    where = places(browser)
    a, b = apart(where)[[3, -3]]
    click(browser, where[a])
    click(browser, where[b], modifiers=8)
    browser.wait("skpose.state.comparison?.geodesic")
    image = Image.open(BytesIO(file_of(browser, "#gif")[2]))
    assert sum(frame.info["duration"] for frame in ImageSequence.Iterator(image)) == pytest.approx(2000, abs=40)


def test_video(browser, page):
    browser.open(page, size=(420, 700))
    if not browser.js("Boolean(globalThis.MediaRecorder)"):
        pytest.skip("this browser does not record")
    name, kind, content = file_of(browser, "#video")
    assert (name, kind) == ("three_actions.webm", "video/webm")
    assert len(content) > 2000
    whole = browser.js("skpose.poses.duration(skpose.poses.range(skpose.state.current))")
    assert duration_of(content) > max(1.0, whole) - 0.1  # a browser that has other work to do takes longer
    assert browser.problems() == []


def test_the_link_is_copied(browser, page):
    browser.open(page)
    assert link_of(browser) == browser.js("skpose.link.address")
