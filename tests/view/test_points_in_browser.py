"""Keypoints in Chromium: points that are seen, and the bones between them, upright."""

from dataclasses import replace

import numpy as np
import pytest
from browser import changed, pixels_near
from player_page import LEFT, RIGHT, projected, state_of

from skpose import Keypoints
from skpose.datasets import make_gait
from skpose.keypoints import layouts
from skpose.view import player

pytestmark = pytest.mark.slow

HIDDEN = slice(10, 15)  # frames in which the left knee is not seen


def squatting(up="y", n=30, drop=()):
    """Points of somebody upright who moves forward and down; x to the left, y up, z forward, or these axes turned."""
    layout = layouts["coco17"]
    parts = "ankle", "knee", "hip", "wrist", "elbow", "shoulder", "ear", "eye"
    height = {part: 0.1 + 1.6 / 7 * i for i, part in enumerate(parts)}
    points = []
    for name in layout.names:
        side, _, part = name.rpartition("_")
        points.append([{"left": 0.15, "right": -0.15}.get(side, 0.0), height.get(part, 1.65), 0.1 * (part == "nose")])
    share = np.linspace(0, 1, n)[:, None, None]
    positions = np.array(points) * (1 - share * [0, 0.2, 0]) + [2.0, 0.0, 1.0] + share * [0, 0, 0.7]
    positions[HIDDEN, layout.names.index("left_knee")] = np.nan
    order = {"x": [1, 2, 0], "y": [0, 1, 2], "z": [2, 0, 1]}[up]
    found = Keypoints(positions[..., order], layout.names, 30, up=up)
    return found.select([name for name in found.names if name not in drop])


def test_page_opens_without_a_message_and_says_what_it_holds(browser):
    browser.open(squatting().play())
    assert browser.problems() == []
    assert browser.find("#summary").text == "30 frames at 30 Hz, 19 points"
    facts = browser.js("document.getElementById('facts').textContent")
    assert "Bones of the layout coco17." in facts
    assert "mm of the recording's" in facts
    options = browser.js("[...document.getElementById('place').options].map((option) => option.value)")
    assert options == ["world", "spot"]  # where points face is not known


@pytest.mark.parametrize("up", "xyz")
def test_points_are_seen_where_they_are_and_stand_upright(browser, up):
    keypoints = squatting(up)
    browser.open(keypoints.play())
    state = state_of(browser)
    upright = squatting("y").positions[0]  # the axes are turned in a cycle, so that nothing is mirrored
    found = np.array(state["views"][0]["points"][0])
    np.testing.assert_allclose(found[1:18] - found[1], upright - upright[0], atol=1e-3)
    assert found[1:, 1].min() == pytest.approx(0, abs=0.03)  # the lowest of all frames is on the ground
    flat = projected(state, found)
    names = list(layouts["coco17"].names)
    nose, ankle = flat[1 + names.index("nose")], flat[1 + names.index("left_ankle")]
    assert nose[1] < ankle[1] - 200  # px
    picture = browser.picture()
    for name, colour in (("left_wrist", LEFT), ("right_wrist", RIGHT)):
        x, y = np.rint(flat[1 + names.index(name)]).astype(int)
        assert np.abs(picture[y - 2 : y + 3, x - 2 : x + 3] - colour).max(axis=2).min() < 30


def test_what_is_not_seen_is_not_drawn(browser):
    browser.open(squatting().play())
    browser.choose("#joint", "left_knee")
    drawn = {}
    for frame in (9, 12, 15):
        browser.press("HOME", *["."] * frame, css="canvas")
        assert state_of(browser)["tick"] == frame
        flat = browser.js("skpose.stage.views[0].figures[0].flat.map(Boolean)")
        knee = 1 + list(layouts["coco17"].names).index("left_knee")
        assert flat[0] is False  # the middle
        assert flat[knee] == (frame != 12)
        assert sum(flat) == 19 - (frame == 12)
        drawn[frame] = browser.picture()[4:-4, 4:-4]  # without the ring of the focus
    blue = {frame: pixels_near(picture, LEFT) for frame, picture in drawn.items()}
    assert blue[12] < 0.8 * min(blue[9], blue[15])  # shank and thigh are missing


def test_a_point_that_is_lost_has_no_name_under_the_pointer(browser):
    browser.open(squatting().play())
    knee = 1 + list(layouts["coco17"].names).index("left_knee")
    browser.press("HOME", *["."] * 9, css="canvas")
    state = state_of(browser)
    x, y = projected(state, np.array(state["views"][0]["points"][0])[[knee]])[0]
    browser.mouse(("moved", x, y))
    assert browser.find("#tip").text == "left_knee"
    browser.press(".", ".", css="canvas")
    assert browser.js("document.getElementById('tip').hidden")
    browser.mouse(("moved", x + 1, y))
    assert browser.js("skpose.stage.hover") is None
    assert browser.problems() == []


def test_points_without_bones(browser):
    browser.open(squatting(drop=["nose"]).play())
    picture = browser.picture()
    assert pixels_near(picture, LEFT) > 100
    browser.open(squatting().play())
    assert pixels_near(browser.picture(), LEFT) > 2 * pixels_near(picture, LEFT)
    assert browser.problems() == []


def test_trails_have_gaps_where_the_point_is_lost(browser):
    trails, seen = [], squatting()
    seen = squatting(
        drop=[name for name in seen.names if name not in ("left_knee", "right_ankle")]
    )  # none hides a trail
    for keypoints in (seen, seen.fill_gaps()):
        browser.open(keypoints.play())
        browser.choose("#joint", "left_knee")
        browser.press("HOME", *["."] * 20, css="canvas")
        browser.click("#trails")
        drawn = browser.picture()
        browser.click("#trails")
        trails.append(changed(drawn, browser.picture()))
    assert 0 < trails[0] < 0.8 * trails[1]


def test_next_to_a_motion_and_on_top_of_it(browser):
    walk = make_gait(1, 1, duration=1.0, frame_rate=30, random_state=0).motions[0]
    browser.open(player([squatting(), walk], labels=["points", "walk"], overlay=True))
    assert browser.find("#place").get_attribute("value") == "spot"
    assert state_of(browser)["views"][0]["clips"] == [0, 1]
    browser.choose("#layout", "side")
    assert len(state_of(browser)["views"]) == 2
    assert browser.problems() == []


def test_points_that_are_seen_in_few_frames(browser):
    keypoints = squatting(n=300)
    positions = np.full(keypoints.positions.shape, np.nan)
    positions[101] = keypoints.positions[101]
    browser.open(replace(keypoints, positions=positions, confidences=None).play())
    browser.press("HOME", css="canvas")
    assert browser.problems() == []
    assert browser.js("skpose.stage.camera.distance") > 0
