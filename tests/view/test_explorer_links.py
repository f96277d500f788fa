"""Links of the explorer in Chromium: the same metric, pose, comparison, lasso and views; nonsense is ignored."""

import pytest
from explorer_page import click, drag, places

from skpose.datasets import make_gait
from skpose.view import explorer

pytestmark = pytest.mark.slow
STATE = """[
  skpose.state.current, skpose.state.comparison?.first ?? -1, skpose.state.inside?.length ?? -1, skpose.state.group,
  document.getElementById("metric").value, document.getElementById("colour").value, skpose.link.address,
]"""


@pytest.fixture(scope="module")
def page():
    gait = make_gait(n_subjects=2, n_sequences=1, duration=1.0, frame_rate=24, random_state=0)
    return explorer(gait, metrics=["spatial", "position"])


def test_a_link_opens_the_same(browser, page):
    browser.open(page)
    browser.choose("#metric", "position")
    browser.choose("#colour", "motion")
    where = places(browser)
    click(browser, where[3])
    click(browser, where[40], modifiers=8)
    x, y = where[20]
    drag(browser, *[(x + dx, y + dy) for dx, dy in [(-60, -60), (0, -70), (60, -60), (60, 60), (-60, 60)]], modifiers=8)
    browser.press("+", css="#canvas")
    browser.press("ARROW_LEFT", css="#figure")
    browser.wait("skpose.link.address === location.href && location.hash.includes('camera')")
    before, address = browser.js(STATE), browser.js("location.href")
    assert before[0:2] == [40, 3]
    assert before[2] > 0
    browser.driver.get("about:blank")
    browser.driver.get(address)
    browser.wait("window.skpose && skpose.state.drawn > 0")
    assert browser.js(STATE) == before
    browser.driver.execute_script("location.hash = 'pose=5'")
    browser.wait("skpose.state.current === 5")
    assert browser.js("skpose.state.comparison") is None
    assert browser.js("skpose.state.inside") is None


@pytest.mark.parametrize("first", [3, None])
def test_a_link_keeps_the_pose_that_was_chosen_and_the_one_that_is_shown(browser, page, first):
    browser.open(page)
    if first is not None:
        click(browser, places(browser)[first])
    browser.driver.execute_script("const time = document.getElementById('time'); time.value = 9")
    browser.driver.execute_script("document.getElementById('time').dispatchEvent(new Event('input'))")
    asked = "[skpose.state.first, skpose.state.current]"
    before, address = browser.js(asked), browser.js("skpose.link.address")
    assert before == [-1 if first is None else first, 9]
    browser.driver.get("about:blank")
    browser.driver.get(address)
    browser.wait("window.skpose && skpose.state.drawn > 0")
    assert browser.js(asked) == before


def test_a_link_has_the_lasso_of_another_plane(browser, page):
    browser.open(page)
    x, y = places(browser)[20]
    drag(browser, *[(x + dx, y + dy) for dx, dy in [(-60, -60), (60, -60), (60, 60), (-60, 60)]], modifiers=8)
    inside = browser.js("skpose.state.inside")
    assert inside
    browser.choose("#metric", "position")
    address = browser.js("skpose.link.address")
    browser.driver.get("about:blank")
    browser.driver.get(address)
    browser.wait("window.skpose && skpose.state.drawn > 0")
    assert browser.js("skpose.state.inside") == inside
    assert browser.js("skpose.state.lasso") == []
    assert browser.find("#metric").get_attribute("value") == "position"
    assert browser.js("skpose.link.address") == address


@pytest.mark.parametrize(
    "fragment",
    [
        "nonsense&metric=none&colour=constructor",
        "pose=1e99",
        "pose=-1&compared=0,1e9,0.5",
        "compared=a,b,c&group=constructor",
        "group=1.5&lasso=,,,&plane=NaN,1,1",
        "lasso=1,2,3,4,5&plane=0,1e308,-1e308",
        "camera=1&t=%E0%A4%A",
    ],
)
def test_nonsense_in_a_link_is_ignored(browser, page, fragment):
    browser.open(page)
    browser.driver.execute_script("location.hash = arguments[0]", fragment)
    browser.settle()
    browser.driver.refresh()
    browser.wait("window.skpose && skpose.state.drawn > 0")
    browser.settle()
    assert browser.js(STATE)[:4] == [0, -1, -1, -1]
    assert browser.driver.get_log("browser") == []
