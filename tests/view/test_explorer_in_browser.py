"""The explorer in Chromium: where its points are, what is shown of them, time, two poses compared, the lasso."""

from dataclasses import replace

import numpy as np
import pytest
from browser import changed, pixels_near
from explorer_page import Held, apart, click, drag, places, shown
from matplotlib.path import Path as Polygon
from scipy.interpolate import interp1d

from skpose import forward_kinematics, geodesic, pose_distances
from skpose.datasets import MotionDataset, make_gait
from skpose.skeleton._interpolation import straight_line
from skpose.view import explorer

pytestmark = pytest.mark.slow
SHIFT = 8  # of the mouse
COLOURS = [(0, 114, 178), (192, 79, 0), (0, 128, 94), (166, 71, 125)]  # of the first groups on white


@pytest.fixture(scope="module")
def gait():
    """Four motions of two people."""
    return make_gait(n_subjects=2, n_sequences=1, duration=1.0, frame_rate=24, random_state=0)


@pytest.fixture(scope="module")
def page(gait):
    return explorer(gait, metrics=["spatial", "angle", "position"])


@pytest.fixture(scope="module")
def held(gait, page):
    return Held(page, gait.skeleton)


# --- points -----------------------------------------------------------------------------------------------------------


def test_page_opens_without_a_message_and_without_the_network(browser, page, gait):
    browser.open(page)
    click(browser, (20, 20))
    assert browser.problems() == []
    assert browser.driver.title == "48 poses of 4 motions"
    assert browser.find("h1").text == "48 poses of 4 motions"
    assert browser.find("#summary").text == f"{gait.skeleton.n_joints} joints"


@pytest.mark.parametrize("metric", ["spatial", "angle", "position"])
@pytest.mark.parametrize("size", [(1000, 700), (420, 900)], ids=str)
def test_points_are_where_python_has_them(browser, page, held, metric, size):
    browser.open(page, size=size)
    browser.choose("#metric", metric)
    where, Y = places(browser), held.embedding(metric)
    width, height = browser.js("[skpose.stage.width, skpose.stage.height]")
    scale = np.ptp(where, axis=0) / np.ptp(Y, axis=0)
    assert scale[0] == pytest.approx(scale[1], rel=1e-9)  # one for both axes
    expected = Y.mean(axis=0) + (where - where.mean(axis=0)) / scale * [1, -1]
    np.testing.assert_allclose(expected, Y, atol=1e-9 * np.ptp(Y))
    assert ((where > 20) & (where < [width - 20, height - 20])).all()
    assert (np.ptp(where, axis=0) > [width - 60, height - 60]).any()  # as large as possible


@pytest.mark.parametrize("density", [1, 2])
def test_points_are_drawn_in_the_colour_of_their_group(browser, page, held, gait, density):
    browser.open(page, density=density)
    browser.choose("#colour", "subject")
    browser.driver.execute_script("document.getElementById('canvas').style.visibility = 'hidden'")  # the marks
    picture, where = browser.picture("#points"), places(browser)
    names = np.unique(gait.subjects).tolist()
    for row, (x, y) in enumerate(np.rint(density * where).astype(int)):
        colour = COLOURS[names.index(gait.subjects[held.motion_of[row]])]
        around = picture[y - density : y + density + 1, x - density : x + density + 1]
        assert pixels_near(around, colour) > 0 or row not in apart(where)
    near = sum(pixels_near(picture, colour) for colour in COLOURS[:2])
    assert 0.5 < near / (len(where) * np.pi * (3.2 * density) ** 2) < 1.1
    assert browser.js("skpose.stage.layer.width / skpose.stage.width") == pytest.approx(density, 0.01)


def test_colours_by_action_motion_and_time(browser, page, held, gait):
    browser.open(page)
    options = [option.text for option in browser.driver.find_elements("css selector", "#colour option")]
    assert options == ["subject", "action", "motion", "time"]
    for by, values in (("action", gait.actions), ("motion", np.array(held.data["labels"])), ("subject", gait.subjects)):
        browser.choose("#colour", by)
        names = list(np.unique(values)) if by != "motion" else values.tolist()
        listed = [button.text.split("\n") for button in browser.driver.find_elements("css selector", "#groups button")]
        sizes = [int((values[held.motion_of] == name).sum()) for name in names]
        assert listed == [[name, str(n)] for name, n in zip(names, sizes, strict=True)]
        packed = np.array(browser.js("Array.from(skpose.stage.colours)"))
        found = np.stack([packed & 255, packed >> 8 & 255, packed >> 16], axis=1)
        groups = [names.index(value) for value in values[held.motion_of]]
        np.testing.assert_array_equal(found, np.array(COLOURS)[groups])
        swatches = browser.js("[...document.querySelectorAll('.swatch')].map((s) => s.style.background)")
        assert swatches == [f"rgb({r}, {g}, {b})" for r, g, b in COLOURS[: len(names)]]
    browser.choose("#colour", "time")
    packed = np.array(browser.js("Array.from(skpose.stage.colours)"))
    times = np.array([held.time(row) for row in range(len(packed))])
    assert not browser.find("#groups").is_displayed()
    assert browser.find("#scale").text.split() == ["0", "s", f"{times.max():.2f}", "s"]
    assert len(np.unique(packed)) == len(np.unique(times.round(6)))
    assert len({(t, c) for t, c in zip(times.round(6), packed, strict=True)}) == len(np.unique(packed))
    assert packed[times.argmax()] == 0x42019E  # the last colour of the scale, blue first


def test_a_group_that_is_pressed_is_seen_alone(browser, page, held, gait):
    browser.open(page)
    browser.choose("#colour", "subject")
    before = browser.picture("#points")
    browser.click("#groups li:nth-child(2) button")
    absent = np.array(browser.js("Array.from(skpose.stage.absent)"), dtype=bool)
    np.testing.assert_array_equal(absent, gait.subjects[held.motion_of] != np.unique(gait.subjects)[1])
    after = browser.picture("#points")
    assert pixels_near(after, COLOURS[0]) < 0.05 * pixels_near(before, COLOURS[0])
    assert pixels_near(after, COLOURS[1]) >= pixels_near(before, COLOURS[1])
    pressed = [b.get_attribute("aria-pressed") for b in browser.driver.find_elements("css selector", "#groups button")]
    assert pressed == ["false", "true"]
    where = places(browser)
    for row in np.flatnonzero(absent)[:9]:  # no click finds it, no arrow and no lasso
        browser.mouse(("moved", *map(float, where[row])))
        assert not absent[browser.js("skpose.state.hover")] or browser.js("skpose.state.hover") == -1
    inside = browser.js("skpose.stage.inside([[-9, -9], [9, -9], [9, 9], [-9, 9]])")
    np.testing.assert_array_equal(np.sort(inside), np.flatnonzero(~absent))
    browser.mouse(("moved", *map(float, where[np.flatnonzero(~absent)[0]])))
    for key in ("ARROW_RIGHT", "ARROW_UP", "ARROW_LEFT", "ARROW_DOWN"):
        browser.press(key, css="#canvas")
        assert not absent[browser.js("skpose.state.hover")]
    browser.mouse(("moved", 1.0, 1.0))
    browser.click("#groups li:nth-child(2) button")
    assert browser.js("skpose.stage.absent") is None
    assert changed(before, browser.picture("#points")) == 0


def test_the_nearest_point_is_found_by_the_grid(browser, page):
    browser.open(page)
    rng = np.random.default_rng(0)
    points = np.concatenate([rng.normal(size=(2000, 2)), rng.normal(scale=1e-3, size=(1000, 2)), np.zeros((2, 2))])
    asked = np.concatenate([rng.uniform(-5, 5, (200, 2)), points[rng.integers(3000, size=200)] + 1e-4])
    within = 0.3
    found = browser.js(
        "(([x, y, asked, within]) => { const grid = new skpose.stage.grid.constructor(x, y);"
        " return asked.map(([u, v]) => grid.nearest(u, v, within)); })(arguments)",
        *(points[:, i].tolist() for i in (0, 1)),
        asked.tolist(),
        within,
    )
    far = np.linalg.norm(asked[:, None] - points, axis=2)
    assert ((far.min(axis=1) < within) == (np.array(found) >= 0)).all()
    assert (np.array(found) < 0).any()
    some = np.array(found) >= 0
    np.testing.assert_allclose(far[some, np.array(found)[some]], far[some].min(axis=1), rtol=1e-12)


# --- a pose -----------------------------------------------------------------------------------------------------------


def test_hovering_shows_the_pose(browser, page, held):
    browser.open(page)
    where = places(browser)
    clear = apart(where)
    assert len(clear) >= 20
    for row in clear[::3]:
        browser.mouse(("moved", *(where[row] + [2, 1])))
        (figure,) = shown(browser)
        np.testing.assert_allclose(figure, held.figure(held.X[row]), atol=1e-9)
        assert browser.find("#tip").text == browser.find("#caption").text == held.name(row)
    browser.mouse(("moved", 5, -40))  # out of the points
    assert not browser.find("#tip").is_displayed()
    browser.mouse(("moved", *where[clear[0]]))
    assert browser.find("#tip").is_displayed()
    browser.mouse(("moved", 5, 5))  # where there are none
    assert not browser.find("#tip").is_displayed()
    np.testing.assert_allclose(shown(browser)[0], held.figure(held.X[0]), atol=1e-9)  # that of the time


@pytest.mark.parametrize(("up", "turn"), [("z", 0.0), ("x", 0.0), ("y", np.pi)])
def test_figures_stand_upright(browser, gait, up, turn):
    """Any axis of the root may point up; half a turn of the root changes it."""
    motions = [replace(m, up=up, root_angles=np.full((len(m), 1), turn), root_axes="x") for m in gait.motions[:2]]
    dataset = MotionDataset(motions)
    page = explorer(dataset, metrics=["angle"])
    browser.open(page)
    held = Held(page, dataset.skeleton)
    assert held.data["up"]["order"] != [0, 1, 2] or held.data["up"]["signs"] == [1, -1, -1]
    np.testing.assert_allclose(shown(browser)[0], held.figure(held.X[0]), atol=1e-9)


def test_the_figure_is_drawn_and_turned(browser, page):
    browser.open(page)
    browser.press("0", css="#figure")  # which has the focus, and its frame, from now on
    before = browser.picture("#figure")
    assert pixels_near(before, (192, 79, 0)) > 300  # its right side
    browser.press("ARROW_LEFT", "+", css="#figure")
    assert changed(before, browser.picture("#figure")) > 500
    browser.press("0", css="#figure")
    assert changed(before, browser.picture("#figure")) == 0


def test_a_click_plays_the_motion_from_there(browser, page, held):
    browser.open(page, still=False)
    assert browser.js("skpose.state.playing")  # at once
    where = places(browser)
    row = next(row for row in apart(where) if held.rows(row)[0] < row < held.rows(row)[-3])
    click(browser, where[row])
    assert browser.find("#play").text == "Pause"
    browser.wait(f"skpose.state.current > {row}")
    seen = browser.driver.execute_async_script(
        "const [done] = arguments, rows = [];"
        "const note = () => rows.push([skpose.state.before, skpose.state.time, skpose.state.current]) < 150"
        " ? requestAnimationFrame(note) : done(rows); note();"
    )
    now, time, current = np.array(seen).T
    assert set(current.astype(int)) <= set(held.rows(row))
    passed, moved = np.diff(now) / 1e3, np.diff(time)
    usual = (passed > 0) & (passed < 0.2) & (moved > 0)  # without the jump from the end to the start
    assert usual.sum() > 20
    np.testing.assert_allclose(moved[usual], passed[usual], rtol=1e-6)  # in real time
    for at, r in zip(time, current.astype(int), strict=True):
        later = [k for k in held.rows(row) if held.time(k) <= at + 1e-6]
        assert r == later[-1]
    assert (np.diff(current) < 0).any() or current.max() == held.rows(row)[-1]
    browser.click("#play")
    (figure,) = shown(browser)
    np.testing.assert_allclose(figure, held.figure(held.X[browser.js("skpose.state.current")]), atol=1e-9)


def test_what_was_clicked_plays_under_the_pointer(browser, page, held):
    browser.open(page)
    where = places(browser)
    row = next(row for row in apart(where) if held.rows(row)[0] < row < held.rows(row)[-1])
    click(browser, where[row])
    browser.press(".", css="#canvas")
    browser.mouse(("moved", *(where[row] + [1, 0])))
    assert browser.js("[skpose.state.hover, skpose.state.current]") == [-1, row + 1]
    browser.mouse(("moved", 5, 5))
    browser.mouse(("moved", *where[row]))
    assert browser.js("skpose.state.hover") == row


def test_a_click_does_not_play_for_those_who_ask_for_reduced_motion(browser, page, held):
    browser.open(page, still=True)
    where = places(browser)
    row = int(apart(where)[5])
    click(browser, where[row])
    assert browser.js("[skpose.state.current, skpose.state.first, skpose.state.playing]") == [row, row, False]
    assert browser.find("#play").text == "Play"
    browser.click("#play")
    browser.wait(f"skpose.state.current !== {row}")  # but not for ever


def test_a_click_far_from_all_points_chooses_none(browser, page):
    browser.open(page)
    where = places(browser)
    grid = np.stack(np.meshgrid(np.arange(40, 600, 10), np.arange(40, 500, 10)), axis=-1).reshape(-1, 2)
    empty = grid[np.linalg.norm(grid[:, None] - where, axis=2).min(axis=1).argmax()]
    click(browser, empty)
    assert browser.js("[skpose.state.first, skpose.state.hover]") == [-1, -1]


def test_scrubbing(browser, page, held):
    browser.open(page, still=False)
    where = places(browser)
    row = int(apart(where)[3])
    click(browser, where[row])
    slider = browser.find("#time")
    browser.driver.execute_script("arguments[0].dispatchEvent(new Event('input'))", slider)
    assert not browser.js("skpose.state.playing")
    browser.press("HOME", "ARROW_RIGHT", "ARROW_RIGHT", css="#time")
    first, n = held.rows(row)[0], len(held.rows(row))
    assert browser.js("[skpose.state.current, skpose.state.playing]") == [first + 2, False]
    assert slider.get_attribute("aria-valuetext") == f"{held.time(first + 2):.2f} seconds, pose 3 of {n}"
    assert browser.find("#clock").text == f"{held.time(first + 2):.2f} s"
    browser.press("END", css="#time")
    assert browser.js("skpose.state.current") == held.rows(row)[-1]


# --- two poses --------------------------------------------------------------------------------------------------------


def compare(browser, where, first, second, by="shift"):
    """Choose two poses and wait for the shortest path."""
    click(browser, where[first])
    if by == "mode":
        browser.click("input[value=compare]")
    click(browser, where[second], modifiers=SHIFT if by == "shift" else 0)
    browser.wait("skpose.state.comparison?.geodesic")
    browser.settle()


def far_pair(held, where):
    """Return two poses that can be clicked, far from each other."""
    clear = apart(where)
    D = pose_distances(held.X[clear], skeleton=held.skeleton, metric="spatial")
    a, b = np.unravel_index(D.argmax(), D.shape)
    return int(clear[a]), int(clear[b])


def rounded(metric, distance):
    digits = 3 if metric == "geodesic" else 4
    return f"{float(f'{distance:.{digits}g}'):g}"


@pytest.mark.parametrize("by", ["shift", "mode"])
def test_two_poses_have_the_five_distances_of_python(browser, page, held, by):
    browser.open(page)
    where = places(browser)
    a, b = far_pair(held, where)
    compare(browser, where, a, b, by)
    assert browser.problems() == []
    table = [row.text.split() for row in browser.driver.find_elements("css selector", "#distances tr")]
    assert [row[0] for row in table] == ["angle", "position", "rotation", "spatial", "geodesic"]
    stated = browser.js("skpose.state.comparison.distances")
    for metric, text, unit in table:
        expected = pose_distances(held.X[[a]], held.X[[b]], skeleton=held.skeleton, metric=metric)[0, 0]
        assert stated[metric] == pytest.approx(expected, rel=1e-6 if metric != "geodesic" else 1e-3)
        assert text == rounded(metric, stated[metric])
        assert unit == ("rad" if metric == "angle" else "m")
    assert browser.find("#pair").text == f"A: {held.name(a)}; B: {held.name(b)}"
    for css, words, metric in (("#shortest", "shortest path", "geodesic"), ("#line", "straight line", "spatial")):
        assert browser.find(css).text == f"{words}, {rounded(metric, stated[metric])} m"


def test_two_figures_go_along_the_paths_at_constant_speed(browser, page, held):
    browser.open(page)
    where = places(browser)
    a, b = far_pair(held, where)
    compare(browser, where, a, b)
    line = straight_line(held.skeleton.bones, held.X[a], held.X[b], 401, 2 * np.pi)
    shortest = geodesic(held.X[a], held.X[b], held.skeleton).resample(401)
    figures = []
    for steps in (0, 15, 30, 60):
        browser.press("HOME", *["ARROW_RIGHT"] * steps, css="#time")
        assert browser.find("#clock").text == f"{100 * steps // 60} %"
        figures.append(shown(browser))
        for found, path, error in zip(figures[-1], (shortest, line), (6e-3, 1e-4), strict=True):
            F = forward_kinematics(path, held.skeleton).reshape(401, -1)
            travelled = np.r_[0, np.linalg.norm(np.diff(F, axis=0), axis=1).cumsum()]
            pose = interp1d(travelled / travelled[-1], path, axis=0)(steps / 60)
            np.testing.assert_allclose(found, held.figure(pose), atol=error if steps not in (0, 60) else 1e-4)
    for found in (figures[0], figures[-1]):
        np.testing.assert_allclose(found[0], found[1], atol=1e-4)  # both begin and end in the two poses
    areas = browser.js("skpose.view.figures.map(({ area }) => [area.x, area.width])")
    assert areas[0][0] + areas[0][1] == areas[1][0]


def test_the_paths_play_and_the_comparison_ends(browser, page, held):
    browser.open(page, still=False)
    where = places(browser)
    a, b = far_pair(held, where)
    compare(browser, where, a, b)
    browser.wait("(window.shares ??= []).push(skpose.state.share) && shares.some((s, i) => i && s < shares[i - 1])")
    assert browser.find("#compared").is_displayed()
    browser.click("#end")
    assert not browser.find("#compared").is_displayed()
    assert not browser.find("#paths").is_displayed()
    browser.click("#play")
    assert len(shown(browser)) == 1


def test_a_newer_comparison_replaces_one_that_is_computed(browser, page, held):
    browser.open(page)
    where = places(browser)
    a, b = far_pair(held, where)
    c = next(int(row) for row in apart(where) if row not in (a, b))
    click(browser, where[a])
    click(browser, where[b], modifiers=SHIFT)
    click(browser, where[c], modifiers=SHIFT)
    browser.wait("skpose.state.comparison?.geodesic")
    browser.settle()
    expected = pose_distances(held.X[[a]], held.X[[c]], skeleton=held.skeleton, metric="geodesic")[0, 0]
    assert browser.js("skpose.state.comparison.distances.geodesic") == pytest.approx(expected, rel=1e-3)
    assert browser.find("#pair").text.endswith(held.name(c))
    assert float(browser.find("#distances tr:last-child td").text.split()[0]) == pytest.approx(expected, rel=2e-3)


def test_marks_are_at_the_two_poses(browser, page, held):
    browser.open(page)
    where = places(browser)
    a, b = far_pair(held, where)
    before = browser.picture("#points")
    compare(browser, where, a, b)
    browser.mouse(("moved", 5, 5))
    after = browser.picture("#points")
    for row in (a, b):
        x, y = np.rint(where[row]).astype(int)
        assert changed(before[y - 8 : y + 9, x - 8 : x + 9], after[y - 8 : y + 9, x - 8 : x + 9]) > 60


# --- the lasso --------------------------------------------------------------------------------------------------------

TRIANGLE = [(0.1, 0.15), (0.8, 0.2), (0.75, 0.45), (0.45, 0.9)]  # shares of the canvas; a corner is not one of a box


def corners_of(browser, shares=TRIANGLE):
    size = np.array(browser.js("[skpose.stage.width, skpose.stage.height]"))
    return np.array(shares) * size


def check_inside(browser, held, where, corners):
    inside = np.flatnonzero(Polygon(corners).contains_points(where))
    assert 5 < len(inside) < len(where) - 5
    np.testing.assert_array_equal(browser.js("skpose.state.inside"), inside)
    motions, counts = np.unique(held.motion_of[inside], return_counts=True)
    listed = [row.text.split("\n") for row in browser.driver.find_elements("css selector", "#motions button")]
    assert len(listed) == len(motions)
    assert sorted(listed) == sorted(
        [held.data["labels"][m], f"{n} of {held.data['counts'][m]}"] for m, n in zip(motions, counts, strict=True)
    )
    assert [int(text.split()[0]) for _, text in listed] == sorted(counts.tolist(), reverse=True)
    assert browser.find("#count").text == f"{len(inside)} poses of {len(motions)} motions"
    np.testing.assert_array_equal(
        np.flatnonzero(np.array(browser.js("Array.from(skpose.stage.faded)")) == 0),
        inside,
    )
    return inside


@pytest.mark.parametrize("by", ["shift", "mode"])
def test_the_lasso_lists_the_motions_inside(browser, page, held, by):
    browser.open(page)
    where, corners = places(browser), corners_of(browser)
    if by == "mode":
        browser.click("input[value=lasso]")
    drag(browser, *corners, modifiers=SHIFT if by == "shift" else 0)
    inside = check_inside(browser, held, where, corners)
    np.testing.assert_allclose(places(browser), where)  # nothing has been moved
    assert browser.js("skpose.state.first") == -1  # nor chosen
    browser.click("#motions button")
    row = browser.js("skpose.state.current")
    assert row in inside
    assert browser.find("#motions .name").text == held.data["labels"][held.motion_of[row]]
    browser.click("#release")
    assert browser.js("[skpose.state.inside, skpose.state.lasso.length, skpose.stage.faded]") == [None, 0, None]
    assert not browser.find("#inside").is_displayed()


def test_what_is_in_the_lasso_stays_chosen_under_another_metric(browser, page, held):
    browser.open(page)
    where, corners = places(browser), corners_of(browser)
    drag(browser, *corners, modifiers=SHIFT)
    inside = check_inside(browser, held, where, corners)
    before = browser.picture("#points")
    browser.choose("#metric", "angle")
    np.testing.assert_array_equal(browser.js("skpose.state.inside"), inside)
    assert browser.js("skpose.state.lasso.length") == 0
    assert changed(before, browser.picture("#points")) > 500
    assert browser.find("#inside").is_displayed()


def test_the_lasso_moves_with_the_points(browser, page, held):
    browser.open(page)
    where, corners = places(browser), corners_of(browser)
    drag(browser, *corners, modifiers=SHIFT)
    inside = check_inside(browser, held, where, corners)
    browser.press("+", css="#canvas")
    moved = np.array(browser.js("skpose.state.lasso.map((corner) => skpose.stage.seen(corner))"))
    middle = np.array(browser.js("[skpose.stage.width / 2, skpose.stage.height / 2]"))
    np.testing.assert_allclose(moved, middle + 1.25 * (corners - middle), atol=1e-3)
    np.testing.assert_array_equal(np.flatnonzero(Polygon(moved).contains_points(places(browser))), inside)
