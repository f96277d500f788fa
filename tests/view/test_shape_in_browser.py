"""Figures with volume in Chromium: the same spheres as in Python, ghosts, and people with heads among keypoints."""

import json

import numpy as np
import pytest
from browser import changed, pixels_near
from conftest import SKELETONS
from player_page import LEFT, projected, state_of
from test_points_in_browser import squatting

from skpose import Motion, forward_kinematics
from skpose.datasets import make_gait
from skpose.keypoints import layouts
from skpose.kinematics._shared import find_shape
from skpose.view import player
from skpose.view._page import asset
from skpose.view._points import points_data

DOCUMENT = """<!DOCTYPE html><html lang="en"><head><meta charset="utf-8"><title>shape</title></head><body><script>
{script}
window.centres = (shape, poses) => poses.map((points) => centresOf(shape, points, () => true));
window.outline = (discs, squash) => outlineOf(discs, squash).map((one) => [one.x, one.y]);
</script></body></html>"""
GREY = (89, 97, 107)  # of the middle


@pytest.mark.slow
def test_spheres_are_where_python_has_them(browser):
    browser.open(DOCUMENT.format(script=asset("shape.js")))
    for skeleton in (SKELETONS["humanoid"], SKELETONS["tree"], SKELETONS["chain"]):
        X = np.random.default_rng(0).normal(size=(5, skeleton.n_dofs))
        points = np.concatenate([np.zeros((5, 1, 3)), forward_kinematics(X, skeleton)], axis=1)
        shape = find_shape(skeleton)
        found = browser.js("centres(...arguments)", json.loads(json.dumps(shape.data())), points.tolist())
        np.testing.assert_allclose(found, shape.centres(points), atol=1e-3 * np.ptp(points))  # of four digits
    assert browser.problems() == []


@pytest.mark.slow
def test_outlines_are_flat_by_a_share_of_their_height(browser):
    browser.open(DOCUMENT.format(script=asset("shape.js")))
    discs = [{"x": 0, "y": 0, "radius": 10}, {"x": 40, "y": 8, "radius": 5}]
    for squash in (1.0, 0.2):
        found = np.array(browser.js("outline(...arguments)", discs, squash))
        assert found[:, 0].min() == pytest.approx(-10)
        assert found[:, 0].max() == pytest.approx(45)
        assert found[:, 1].min() == pytest.approx(-10 * squash, abs=0.1)


@pytest.mark.slow
def test_a_person_has_a_head_above_the_neck(browser):
    motion = make_gait(1, 1, random_state=0).motions[0]
    browser.open(player(motion))
    state = state_of(browser)
    points = np.array(state["views"][0]["points"][0])
    shape = find_shape(motion.skeleton)
    top = shape.centres(points)[:, 1].argmax()
    x, y = np.rint(projected(state, shape.centres(points)[[top]])[0]).astype(int)
    assert points[1 + motion.skeleton.joint_names.index("neck"), 1] < shape.centres(points)[top, 1]
    np.testing.assert_allclose(browser.picture()[y, x], GREY, atol=25)


@pytest.mark.slow
def test_ghosts_are_off_at_first_and_pale(browser):
    browser.open(player(make_gait(1, 1, random_state=0).motions[0]))
    browser.press("HOME", *["."] * 20, css="canvas")
    inner = slice(4, -4)  # without the ring of the focus
    before = browser.picture()[inner, inner]
    browser.click("#ghosts")
    after = browser.picture()[inner, inner]
    assert changed(before, after) > 2000
    assert pixels_near(after, LEFT) <= 1.05 * pixels_near(before, LEFT)  # none of them has the full colour
    browser.click("#ghosts")
    assert changed(before, browser.picture()[inner, inner]) == 0
    assert browser.problems() == []


def test_keypoints_have_a_head_where_the_layout_has_ears():
    keypoints = squatting()
    names = list(layouts["coco17"].names)
    ears = {1 + names.index(f"{side}_ear") for side in ("left", "right")}

    def heads(layout, points):
        shape = points_data(points, "", layout)["shape"]
        return [one for one in shape["spheres"] if set(one["at"]) == ears]

    assert len(heads(layouts["coco17"], keypoints)) >= 2  # skull and chin
    no_ears = layouts["coco17"].without(["left_ear", "right_ear"])
    rest = keypoints.select([name for name in keypoints.names if not name.endswith("ear")])
    shape = points_data(rest, "", no_ears)["shape"]
    assert max(len(hulls) for _, hulls in shape["parts"]) > 1  # a trunk
    hips = {1 + rest.names.index(f"{side}_hip") for side in ("left", "right")}
    large = [one for one in shape["spheres"] if "along" in one and one["radius"] > 0.04]
    assert len(large) == 2
    assert all(set(one["at"]) <= hips for one in large)  # and no head


def test_points_without_bones_are_balls_and_all_points_are_there():
    keypoints = squatting(drop=["nose"])
    shape = points_data(keypoints, "", None)["shape"]
    assert [hulls for _, hulls in shape["parts"]] == [((i,),) for i in range(len(keypoints.names))]
    assert [one["at"] for one in shape["spheres"]] == [(i + 1,) for i in range(len(keypoints.names))]


def test_a_page_has_the_shape_of_each_motion():
    humanoid = SKELETONS["humanoid"]
    motion = Motion(humanoid, np.zeros((2, humanoid.n_dofs)), 30)
    chain = Motion(SKELETONS["chain"], np.zeros((2, 4)), 30)
    page = player([motion, chain])
    text = page.html.split('id="data">')[1].split("</script>")[0]
    shapes = [one["shape"] for one in json.loads(text)["motions"]]
    assert shapes == [json.loads(json.dumps(find_shape(s).data())) for s in (humanoid, SKELETONS["chain"])]
