"""The player in Chromium: several motions, colours, settings of the system, unusual motions, use without a mouse."""

import re

import numpy as np
import pytest
from browser import changed, pixels_near
from player_page import LEFT, projected, state_of

from skpose import Bone, Motion, Skeleton, forward_kinematics
from skpose.datasets import humanoid, make_gait
from skpose.motions import align_motions
from skpose.view import geodesic_player, player

pytestmark = pytest.mark.slow

ARM = Skeleton([Bone("left_arm", None, (1, 0, 0), "z"), Bone("right_arm", None, (0, 1, 0), "z")])


@pytest.fixture(scope="module")
def walks():
    """Two walks of two people, of different length."""
    gait = make_gait(n_subjects=2, n_sequences=1, duration=1.0, frame_rate=20, random_state=0)
    walks = gait[gait.actions == "walk"].motions
    return walks[0], walks[1][:14]


@pytest.fixture(scope="module")
def comparison(walks):
    """A page of two motions that are aligned."""
    return player(walks, labels=["slow", "quick"], alignment=align_motions(*walks))


def colour_of(browser, name):
    """Return a colour of the style sheet, three numbers of 0 to 255."""
    text = browser.js(f"getComputedStyle(document.documentElement).getPropertyValue('--{name}')")
    return tuple(int(text[i : i + 2], 16) for i in (1, 3, 5))


# --- several motions --------------------------------------------------------------------------------------------------


def test_motions_side_by_side_and_on_top_of_each_other(browser, walks):
    browser.open(player(walks, labels=["slow", "quick"]))
    assert browser.problems() == []
    views = state_of(browser)["views"]
    assert [view["clips"] for view in views] == [[0], [1]]
    assert views[0]["area"]["x"] + views[0]["area"]["width"] == views[1]["area"]["x"]  # on a wide window
    before = browser.picture()
    browser.choose("#layout", "overlay")
    assert [view["clips"] for view in state_of(browser)["views"]] == [[0, 1]]
    assert changed(before, browser.picture()) > 1000
    assert browser.open(player(walks, overlay=True)).js("skpose.stage.views.length") == 1


def test_each_motion_keeps_its_own_time(browser):
    motions = [Motion(ARM, np.zeros((n, 2)), rate) for n, rate in [(21, 20), (11, 20), (5, 10)]]
    browser.open(player(motions))
    assert browser.js("skpose.clock.count") == 21
    browser.press(*"......", css="canvas")
    assert browser.js("skpose.clock.frames(skpose.tick())") == [6, 6, 3]
    browser.press("END", css="canvas")
    assert browser.js("skpose.clock.frames(skpose.tick())") == [20, 10, 4]  # the last frame stays


@pytest.mark.parametrize(("offset", "columns"), [((0, 2, 0), 2), ((2, 0.1, 0), 1)], ids=["upright", "lying"])
def test_views_are_placed_such_that_the_figures_are_large(browser, offset, columns):
    pole = Motion(Skeleton([Bone("tip", None, offset, "z")]), [[0.0]], 30)
    browser.open(player([pole, pole]), size=(500, 800))
    first, second = (view["area"] for view in state_of(browser)["views"])
    assert (second["x"] == first["width"]) == (columns == 2)
    assert (second["y"] == first["height"]) == (columns == 1)


def test_frames_that_belong_together_are_shown_together(browser, walks, comparison):
    browser.open(comparison)
    path = align_motions(*walks).path
    assert state_of(browser)["ticks"] == len(path)
    for tick in (0, len(path) // 2, len(path) - 1):
        browser.press("HOME", *["."] * tick, css="canvas")
        assert browser.js("skpose.clock.frames(skpose.tick())") == path[tick].tolist()
        times = [f"{motion.times[frame]:.2f} s" for motion, frame in zip(walks, path[tick], strict=True)]
        assert browser.find("#clock").text == " | ".join(times)
    browser.click("#align")
    assert state_of(browser)["ticks"] == len(walks[0])
    assert state_of(browser)["tick"] == len(walks[0]) - 1  # still the end
    browser.press("HOME", *"....", css="canvas")
    assert browser.js("skpose.clock.frames(skpose.tick())") == [4, 4]
    assert path[4].tolist() != [4, 4]


@pytest.mark.parametrize("theme", ["light", "dark"])
def test_colours_are_the_differences_of_the_joints(browser, theme):
    """The left arm is off by up to 1 m, at the end; the right one nowhere."""
    a = Motion(ARM, np.zeros((11, 2)), 10)
    turn = 2 * np.arcsin(np.linspace(0, 1, 11) / 2)
    b = Motion(ARM, np.column_stack([-turn, np.zeros(11)]), 10)
    alignment = align_motions(a, b)
    assert alignment.joint_distances.max() == pytest.approx(1.0)
    browser.open(player([a, b], alignment=alignment), theme=theme)
    assert browser.find("#most").text == "100 cm apart"
    low, middle, high = (np.array(colour_of(browser, f"heat-{i}")) for i in range(3))
    for tick in (0, len(alignment.path) // 2, len(alignment.path) - 1):
        browser.press("HOME", *["."] * tick, css="canvas")
        picture, state = browser.picture(), state_of(browser)
        share = alignment.joint_distances[tick, 0]
        mixed = low + 2 * share * (middle - low) if share < 0.5 else middle + (2 * share - 1) * (high - middle)
        for view in (0, 1):
            points = np.array(state["views"][view]["points"][0])
            halves = np.rint(projected(state, (points[0] + points[1:]) / 2, view)).astype(
                int
            )  # the middles of the bones
            for (x, y), expected in zip(halves, [mixed, low], strict=True):
                np.testing.assert_allclose(picture[y, x], expected, atol=6)
    browser.click("#differences")
    picture, (x, y) = browser.picture(), halves[0]
    np.testing.assert_allclose(picture[y, x], colour_of(browser, "left"), atol=6)


def test_the_joint_under_the_pointer_says_how_far_it_is_off(browser, walks, comparison):
    browser.open(comparison)
    browser.press(*".....", css="canvas")
    alignment, names = align_motions(*walks), walks[0].skeleton.joint_names
    state = state_of(browser)
    foot = names.index("left_toes")
    for view in (0, 1):
        browser.mouse(("moved", *projected(state, state["views"][view]["points"][0], view)[foot + 1]))
        expected = f"left_toes: {100 * alignment.joint_distances[5, foot]:.1f} cm apart"
        assert browser.find("#tip").text == expected


def test_shortest_path_and_straight_line(browser):
    start, end = [0.2, 0.3, 0.0], [2.4, 0.2, 0.1]
    chain = Skeleton.chain(3)
    browser.open(geodesic_player(start, end, chain))
    assert browser.problems() == []
    assert browser.find("h1").text == "shortest path, 7.17 m and straight line, 8.03 m"
    assert browser.js("skpose.clock.count") == 61
    for key, pose in (("HOME", start), ("END", end)):
        browser.press(key, css="canvas")
        for view in state_of(browser)["views"]:
            points = np.array(view["points"][0])
            np.testing.assert_allclose(points[1:] - points[0], forward_kinematics([pose], chain)[0], atol=5e-4)


# --- the system's settings --------------------------------------------------------------------------------------------

CONTRAST = """
const [done] = arguments, parts = [];
for (const one of document.querySelectorAll("body *")) {
  const own = [...one.childNodes].some((node) => node.nodeType === 3 && node.textContent.trim());
  const box = one.getBoundingClientRect();
  const unseen = ["SCRIPT", "STYLE", "NOSCRIPT", "OPTION"].includes(one.tagName);
  if (!own || unseen || !box.width || !one.checkVisibility()) continue;
  let behind = one, colour;
  do { colour = getComputedStyle(behind).backgroundColor; behind = behind.parentElement; }
  while (behind && colour.endsWith(", 0)"));
  parts.push([one.tagName + " " + one.textContent.trim().slice(0, 30), getComputedStyle(one).color, colour]);
}
done(parts)
"""


def luminance(colour):
    """Relative luminance of WCAG 2."""
    values = np.array(re.findall(r"[\d.]+", colour)[:3], dtype=float) / 255
    return np.where(values <= 0.03928, values / 12.92, ((values + 0.055) / 1.055) ** 2.4) @ [0.2126, 0.7152, 0.0722]


def contrast(one, other):
    low, high = sorted([luminance(one), luminance(other)])
    return (high + 0.05) / (low + 0.05)


@pytest.mark.parametrize("theme", ["light", "dark"])
def test_dark_and_light(browser, comparison, theme):
    browser.open(comparison, theme=theme)
    paper = browser.picture("body")[60, 500]
    assert (paper.mean() > 200) == (theme == "light")
    button = browser.find("#theme")
    assert button.accessible_name == {"light": "Dark colours", "dark": "Light colours"}[theme]
    browser.click("#theme")
    other = browser.picture("body")[60, 500]
    assert (other.mean() < 60) == (theme == "light")
    for again in ({"light": "dark", "dark": "light"}[theme], theme):  # the system changes: the button counts
        browser.set(theme=again)
        browser.settle()
    np.testing.assert_array_equal(browser.picture("body")[60, 500], other)


def test_the_system_changes_from_light_to_dark(browser, comparison):
    browser.open(comparison, theme="light")
    before = browser.picture()
    browser.set(theme="dark")
    browser.wait("document.documentElement.dataset.theme === 'dark'")
    assert before.mean() > 200 > 60 > browser.picture().mean()


@pytest.mark.parametrize("theme", ["light", "dark"])
def test_texts_and_edges_stand_out_from_what_is_behind(browser, comparison, theme):
    browser.open(comparison, theme=theme)
    browser.click("#help")
    parts = browser.driver.execute_async_script(CONTRAST)
    assert len(parts) > 30
    for name, colour, behind in parts:
        assert contrast(colour, behind) >= 4.5, (name, colour, behind)
    style = "getComputedStyle(document.querySelector(arguments[0])).getPropertyValue(arguments[1])"
    paper = browser.js(style, "body", "background-color")
    for css in ("#theme", "#speed", "dialog"):
        assert contrast(browser.js(style, css, "border-top-color"), paper) >= 3, css
    texts = ["left", "right", "axis-x", "axis-y", "axis-z"]
    lines = ["middle", *(f"motion-{i}" for i in range(5)), *(f"heat-{i}" for i in range(3))]
    for name in [*texts, *lines]:
        least = 4.5 if name in texts else 3
        assert contrast(str(colour_of(browser, name)), paper) >= least, name


# --- without a mouse --------------------------------------------------------------------------------------------------


def test_every_control_is_reached_by_the_keyboard_has_a_name_and_shows_its_focus(browser, comparison):
    browser.open(comparison)
    from selenium.webdriver.common.keys import Keys

    css = "button, input, select, canvas"
    usable = [
        one for one in browser.driver.find_elements("css selector", css) if one.is_displayed() and one.is_enabled()
    ]
    assert len(usable) >= 15
    reached = []
    browser.find("body").send_keys(Keys.TAB)
    for _ in range(len(usable)):
        one = browser.driver.switch_to.active_element
        reached.append(one.get_attribute("id"))
        assert one.accessible_name.strip(), reached[-1]
        width, style = (one.value_of_css_property(f"outline-{name}") for name in ("width", "style"))
        assert (width, style) == ("3px", "solid"), reached[-1]
        one.send_keys(Keys.TAB)
    assert sorted(reached) == sorted(one.get_attribute("id") for one in usable)
    assert browser.find("#clock").get_attribute("aria-live") == "off"  # or else every frame is read aloud
    assert reached.index("canvas") < reached.index("play") < reached.index("time") < reached.index("speed")


def test_all_is_used_by_the_keyboard(browser, comparison):
    browser.open(comparison)
    browser.press(" ", css="#play")
    assert browser.js("skpose.state.playing")
    browser.press("ENTER", css="#play")
    assert not browser.js("skpose.state.playing")
    for control, value in [("#speed", "2"), ("#joint", "left_thigh"), ("#place", "spot"), ("#layout", "overlay")]:
        browser.press({"2": "2", "left_thigh": "left_t", "spot": "in", "overlay": "on"}[value], css=control)
        assert browser.find(control).get_attribute("value") == value
    for control in ("#ground", "#axes", "#trails", "#differences", "#align"):
        before = browser.find(control).is_selected()
        browser.press(" ", css=control)
        assert browser.find(control).is_selected() != before
    browser.press("ENTER", css="#help")
    assert browser.find("#about").is_displayed()
    assert browser.driver.switch_to.active_element.text == "Help"  # the first line, so that all of it is seen
    browser.press("ESCAPE")
    assert not browser.find("#about").is_displayed()
    assert browser.driver.switch_to.active_element.get_attribute("id") == "help"


def test_only_space_does_something_outside_the_picture(browser, comparison):
    browser.open(comparison)
    before = state_of(browser)
    browser.press("END", "0", "+", ".", "i", css="body")
    assert state_of(browser) == before
    browser.press(" ", css="body")
    assert state_of(browser)["playing"]
    browser.press(" ", css="#speed")  # which opens the menu
    browser.press("ESCAPE", css="#speed")
    assert state_of(browser)["playing"]
    browser.press(" ", css="#play")
    assert not state_of(browser)["playing"]


# --- unusual motions --------------------------------------------------------------------------------------------------

NAMES = [
    "<script>window.foreign = 1</script>",
    "</script>",
    "<img src=x onerror='window.foreign = 1'>",
    "\"quoted\" & 'so'",
    "\u05e9\u05dc\u05d5\u05dd \u05d9\u05d3",  # from right to left
    "x" * 5000,
]


def test_names_stay_text(browser):
    skeleton = Skeleton(Bone(name, None, (np.cos(i), np.sin(i), 0), "z") for i, name in enumerate(NAMES))
    label = "</title></script><script>window.foreign = 1</script>"
    browser.open(player([Motion(skeleton, np.zeros((2, 6)), 30)] * 2, labels=[label, "b"], overlay=True, title=label))
    assert browser.driver.title == label
    options = [
        one.get_attribute("textContent") for one in browser.driver.find_elements("css selector", "#joint option")
    ]
    assert options == ["none", *NAMES]
    state = state_of(browser)
    for place, name in zip(projected(state, state["views"][0]["points"][0])[1:], NAMES, strict=True):
        browser.mouse(("moved", *place))
        assert browser.js("[...document.querySelectorAll('#tip span')].map((one) => one.textContent)")[0] == name
        box = browser.find("#tip").rect
        assert box["x"] >= 0
        assert box["x"] + box["width"] <= 1000
        browser.driver.execute_script("arguments[0].value = arguments[1]", browser.find("#joint"), name)
        browser.driver.execute_script("arguments[0].dispatchEvent(new Event('change'))", browser.find("#joint"))
        browser.settle()
    assert browser.problems() == []
    assert browser.js("window.foreign") is None
    assert browser.js("document.querySelectorAll('script').length") == 3  # data, program and its start
    assert browser.js("document.querySelectorAll('img').length") == 0


def many_joints():
    """A person with fingers: 140 joints."""
    tips = [Bone(f"finger {i}", "left_hand", (0.01 * (i % 12), 0.02, 0.01 * (i // 12)), "x") for i in range(118)]
    return Skeleton([*humanoid().bones, *tips])


@pytest.mark.parametrize(
    "motion",
    [
        Motion(ARM, [[0.1, 0.2]], 30),
        Motion(Skeleton([Bone("a", None, (0, 0, 0), "z"), Bone("b", "a", (0, 0, 0), "z")]), np.zeros((3, 2)), 30),
        Motion(many_joints(), np.zeros((4, many_joints().n_dofs)), 30),
        Motion(Skeleton.chain(2), np.random.default_rng(0).normal(scale=0.01, size=(40_000, 2)).cumsum(axis=0), 120),
        Motion(Skeleton([Bone("a", None, (1e-4, 0, 0), "z")]), np.zeros((3, 1)), 30),
        Motion(
            Skeleton([Bone("a", None, (170.0, 0, 0), "z")]), np.zeros((3, 1)), 0.5, [[0, 0, 1e5 * i] for i in range(3)]
        ),
    ],
    ids=["one frame", "no length", "140 joints", "five minutes", "0.1 mm", "170 m"],
)
def test_unusual_motions(browser, motion):
    browser.open(player(motion), still=False)
    browser.press("END", css="canvas")
    for control in ("#trails", "#follow", "#axes"):
        browser.click(control)
    for place in ("spot", "forward", "world"):
        browser.choose("#place", place)
    state = state_of(browser)
    assert state["tick"] == len(motion) - 1
    flat = projected(state, state["views"][0]["points"][0])
    assert np.isfinite(flat).all()
    area = state["views"][0]["area"]
    assert ((flat >= 0) & (flat <= [area["width"], area["height"]])).all()
    assert browser.find("#play").is_enabled() == (len(motion) > 1)
    assert browser.js("skpose.stage.size > 0 && skpose.stage.camera.distance > 0")
    assert len(np.unique(browser.picture().reshape(-1, 3), axis=0)) > 5
    assert browser.problems() == []


def test_short_bones_are_not_thinner_than_those_on_both_sides(browser):
    lengths = {"left_a": 0.5, "left_b": 0.0, "left_short": 0.05, "left_c": 0.0, "left_d": 0.5, "left_end": 0.05}
    names = list(lengths)
    bones = [Bone(n, p, (0, lengths[n], 0), "z") for n, p in zip(names, [None, *names], strict=False)]
    browser.open(player(Motion(Skeleton(bones), np.zeros((1, 6)), 30)), density=2)
    (points,) = state_of(browser)["views"][0]["points"]
    middles = [(np.array(points[i]) + points[i + 1]) / 2 for i in range(6)]
    picture = browser.picture()
    rows = (2 * projected(state_of(browser), middles)[:, 1]).round().astype(int)
    first, _, short, _, last, end = (pixels_near(picture[[row]], LEFT) for row in rows)
    assert short >= 0.9 * min(first, last) > 10
    assert end < 0.9 * last  # which joins nothing


def test_browsers_that_are_too_old_say_so(browser):
    page = player(Motion(ARM, [[0.1, 0.2]], 30)).html
    page = page.replace("typeof DecompressionStream", "typeof Missing").replace(
        re.search(r"script-src '[^']*' '[^']*'", page)[0], "script-src 'unsafe-inline'"
    )
    browser.open(page)
    browser.wait("!document.getElementById('failure').hidden")
    assert browser.find("#failure").text == "This page needs a browser of 2023 or later."


# --- where it is shown ------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("size", [(320, 568), (420, 860), (800, 600), (1300, 860), (2560, 1300)], ids=str)
def test_nothing_is_cut_off_at_any_width(browser, comparison, size):
    browser.open(comparison, size=size, touch=size[0] < 500)
    assert browser.js("document.documentElement.scrollWidth") <= size[0]
    boxes = browser.js(
        "[...document.querySelectorAll('header *, #controls *')].filter((one) => one.checkVisibility() && "
        "one.tagName !== 'OPTION').map((one) => [one.id || one.tagName, one.getBoundingClientRect().toJSON()])"
    )
    for name, box in boxes:
        assert box["left"] >= 0, name
        assert box["right"] <= size[0] + 0.5, name
        assert box["bottom"] <= size[1] + 0.5, name
    stage = browser.find("#stage").rect
    assert stage["height"] >= 180
    assert stage["width"] == size[0]
    state = state_of(browser)
    for i, view in enumerate(state["views"]):
        flat, area = projected(state, view["points"][0], i), view["area"]
        assert (flat[:, 0] >= area["x"]).all()
        assert (flat[:, 0] <= area["x"] + area["width"]).all()


def test_another_size_of_the_window(browser, comparison):
    browser.open(comparison, size=(1000, 700))
    browser.set(size=(500, 900))
    browser.wait("skpose.stage.canvas.clientWidth === 500")
    browser.settle()
    assert browser.js("skpose.stage.canvas.width") == 500
    state = state_of(browser)
    flat = projected(state, state["views"][1]["points"][0], 1)
    assert (flat[:, 0] >= 0).all()
    assert (flat[:, 0] <= 500).all()


def test_a_notebook_shows_the_strip(browser, walks):
    browser.open(f"<!DOCTYPE html><body style='color: #000000'>{walks[0]._repr_html_()}</body>")
    picture = browser.picture("svg")
    for colour in ((0, 114, 178), (213, 94, 0), (0, 0, 0)):
        assert pixels_near(picture, colour) > 50
    assert browser.find("svg").accessible_name == repr(walks[0])
