"""The explorer in Chromium: it opens, shows poses where Python has them, plays, compares, encloses and is linked to."""

import numpy as np
import pytest
from browser import pixels_near
from pages import data_of

from skpose import forward_kinematics, pose_distances
from skpose.datasets import make_gait
from skpose.view import explorer
from skpose.view._scene import unpack

pytestmark = pytest.mark.slow

SHIFT = 8  # of the mouse
FIRST = (0, 114, 178)  # the colour of the first group on white


@pytest.fixture(scope="module")
def gait():
    """Four motions of two people."""
    return make_gait(n_subjects=2, n_sequences=1, duration=1.0, frame_rate=24, random_state=0)


@pytest.fixture(scope="module")
def page(gait):
    return explorer(gait, metrics=["spatial", "angle"])


@pytest.fixture(scope="module")
def poses(page):
    return unpack(data_of(page)["poses"])


def places(browser):
    """Where the points are in the canvas, px."""
    return np.array(browser.js("Array.from({ length: skpose.poses.count }, (_, i) => skpose.stage.at(i))"))


def lonely(where):
    """Points so far from all others that a click finds no other one."""
    far = np.linalg.norm(where[:, None] - where, axis=2) + 1e9 * np.eye(len(where))
    return [int(i) for i in np.argsort(-far.min(axis=1))]


def click(browser, place, modifiers=0):
    browser.mouse(("moved", *place), ("pressed", *place), ("released", *place), modifiers=modifiers)


@pytest.mark.parametrize("size", [(420, 860), (1300, 860)], ids=str)
@pytest.mark.parametrize("dark", [False, True])
def test_page_opens_without_a_message_and_fits_into_the_window(browser, page, size, dark):
    picture = browser.show(page, size=size, dark=dark).picture()
    assert browser.problems() == []
    assert browser.text("h1") == "48 poses of 4 motions"
    assert browser.js("document.documentElement.scrollWidth") <= size[0]
    assert dark or pixels_near(picture, FIRST) > 100


def test_points_are_where_python_has_them(browser, page):
    browser.show(page)
    for one in data_of(page)["embeddings"]:
        browser.choose("#metric", one["metric"])
        where, Y = places(browser), unpack(one["points"])
        scale = np.ptp(where, axis=0) / np.ptp(Y, axis=0)
        assert scale[0] == pytest.approx(scale[1], rel=1e-9)
        expected = Y.mean(axis=0) + (where - where.mean(axis=0)) / scale * [1, -1]
        np.testing.assert_allclose(expected, Y, atol=1e-9 * np.ptp(Y))


def test_a_pose_under_the_pointer_is_shown_and_a_click_plays_it(browser, page, poses, gait):
    browser.show(page)
    where = places(browser)
    row = lonely(where)[0]
    browser.mouse(("moved", *where[row]))
    np.testing.assert_allclose(
        browser.js("skpose.view.points")[1:], forward_kinematics(poses[row : row + 1], gait.skeleton)[0], atol=1e-9
    )
    assert data_of(page)["labels"][row // 12] in browser.text("#tip")
    click(browser, where[row])
    assert browser.js("skpose.state.current") == row


def test_two_poses_are_compared_by_their_distances(browser, page, poses, gait):
    browser.show(page)
    where = places(browser)
    a, b = lonely(where)[:2]
    click(browser, where[a])
    click(browser, where[b], modifiers=SHIFT)
    found = browser.js("skpose.state.comparison.distances")
    for metric, distance in found.items():
        expected = pose_distances(poses[[a]], poses[[b]], skeleton=gait.skeleton, metric=metric)[0, 0]
        assert distance == pytest.approx(expected, rel=1e-8)
        assert f"{float(f'{expected:.4g}'):g}"[:5] in browser.text("#distances")
    assert browser.text("#caption").startswith("straight line, ")
    browser.press("End")
    np.testing.assert_allclose(
        browser.js("skpose.view.points")[1:], forward_kinematics(poses[[b]], gait.skeleton)[0], atol=1e-9
    )


def test_a_lasso_lists_the_motions_inside(browser, page):
    browser.show(page)
    where = places(browser)
    inside = where[:, 0] < np.median(where[:, 0])
    right = float(np.median(where[:, 0]))
    corners = [(4.0, 4.0), (right, 4.0), (right, 550.0), (4.0, 550.0)]
    path = [corners[0], *corners, corners[0]]
    moves = [("moved", *place) for place in path[1:]]
    browser.mouse(("pressed", *path[0]), *moves, ("released", *path[0]), modifiers=SHIFT)
    assert sorted(browser.js("skpose.state.inside")) == np.flatnonzero(inside).tolist()
    assert browser.text("#count").startswith(f"{inside.sum()} poses of ")


def test_keys_go_from_point_to_point_and_wheel_keys_zoom(browser, page):
    browser.show(page)
    first = browser.js("skpose.state.current")
    browser.press("ArrowRight")
    where, reached = places(browser), browser.js("skpose.state.hover")
    assert where[reached, 0] > where[first, 0]
    browser.press("+")
    assert browser.js("skpose.stage.zoom") == pytest.approx(1.25)
    browser.press("0")
    assert browser.js("skpose.stage.zoom") == 1


def test_a_link_restores_what_is_shown(browser, page):
    browser.show(page, "#metric=angle&colour=subject&compared=3,30,0.5&plane=2,0.1,0.2")
    state = "[metric.value, skpose.state.comparison.second, skpose.state.share, skpose.stage.zoom]"
    assert browser.js(state) == ["angle", 30, 0.5, 2]
    browser.wait_for("location.hash.includes('compared=3,30,0.5')")
    browser.show(page, browser.run("location.hash"))
    assert browser.js(state) == ["angle", 30, 0.5, 2]


def test_groups_have_figures_with_their_names(browser, page):
    browser.show(page, size=(1300, 860))
    figures = browser.js("skpose.state.figures")
    assert sorted(" ".join(one["words"]) for one in figures) == ["run", "walk"]
    browser.run("document.getElementById('figures').click()")
    assert browser.js("skpose.state.figures") == []


def test_a_picture_of_the_points_with_the_pose_is_a_file(browser, page):
    browser.show(page)
    browser.run("URL.createObjectURL = (blob) => (window.file = blob, 'blob:x')")
    browser.click("#picture")
    browser.wait_for("window.file?.type === 'image/png'")
    assert browser.js("window.file.size") > 10_000


def test_a_picture_without_a_background_is_transparent_between_the_points(browser, page):
    browser.show(page, "#figures=0")
    browser.run("URL.createObjectURL = (blob) => (window.file = blob, 'blob:x')")
    browser.run("document.getElementById('paper').checked = false")
    browser.click("#picture")
    browser.wait_for("window.file?.type === 'image/png'")
    opacities = """createImageBitmap(file).then((bitmap) => {
      const context = new OffscreenCanvas(bitmap.width, bitmap.height).getContext("2d");
      context.drawImage(bitmap, 0, 0);
      const { data } = context.getImageData(0, 0, bitmap.width, bitmap.height);
      return [0, 255].map((one) => data.filter((value, i) => i % 4 === 3 && value === one).length / (data.length / 4));
    })"""
    transparent, opaque = browser.run(opacities)
    assert transparent > 0.8
    assert opaque > 0.001
