"""The player in Chromium: what it draws is compared with forward kinematics, and used by mouse, fingers and keys."""

from dataclasses import replace

import numpy as np
import pytest
from browser import changed, pixels_near
from conftest import in_space
from player_page import LEFT, RIGHT, projected, state_of
from scipy.spatial.transform import Rotation

from skpose import Bone, Motion, Skeleton
from skpose.datasets import make_gait
from skpose.view import player

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def walk():
    """A walk of one second that begins somewhere and in some direction."""
    motion = make_gait(1, 1, duration=1.0, frame_rate=20, random_state=0).motions[0]
    n = len(motion)
    path = np.linspace([3.0, 1.0, 2.0], [4.0, 1.0, 3.5], n)
    turns = np.column_stack([np.full(n, 0.1), np.linspace(0.5, 1.5, n), np.zeros(n)])
    return replace(motion, root_positions=path, root_angles=turns, root_axes="xyz")


def expected_points(motion, place="world"):
    """Positions of root and joints (n_frames, n_joints + 1, 3), the lowest at height zero."""
    points = np.concatenate([motion.root_positions[:, None], in_space(motion)], axis=1)
    points[..., 1] -= points[..., 1].min()
    if place == "world":
        return points
    points[..., [0, 2]] -= motion.root_positions[:, None][..., [0, 2]]
    if place == "forward":
        for i, angles in enumerate(motion.root_angles):
            _, y, _, w = Rotation.from_euler(motion.root_axes, angles).as_quat()
            points[i] = Rotation.from_rotvec([0, -2 * np.arctan2(y, w), 0]).apply(points[i])
    return points


# --- what is seen -----------------------------------------------------------------------------------------------------


def test_page_opens_without_a_message_and_without_the_network(browser, walk):
    browser.open(player(walk, labels=["a walk"]))
    assert browser.problems() == []
    assert browser.driver.title == "a walk"
    assert browser.find("h1").text == "a walk"
    assert browser.find("#summary").text == f"20 frames at 20 Hz, {walk.skeleton.n_joints} joints"


def test_the_policy_of_the_page_forbids_the_network_and_foreign_programs(browser, walk):
    foreign = (
        "<script>window.foreign = 1</script><img src=x.png onerror='window.foreign = 1'><script src=x.js></script>"
    )
    page = player(walk)
    page.html = page.html.replace("</main>", f"{foreign}</main>")
    browser.open(page)
    assert sum("Content Security Policy" in message for message in browser.problems()) >= 3
    assert browser.js("window.foreign") is None


@pytest.mark.parametrize("place", ["world", "spot", "forward"])
def test_joints_are_where_forward_kinematics_has_them(browser, walk, place):
    browser.open(player(walk))
    browser.choose("#place", place)
    expected = expected_points(walk, place)
    for frame, keys in [(0, ["HOME"]), (7, ["."] * 7), (19, ["END"])]:
        browser.press(*keys, css="canvas")
        state = state_of(browser)
        assert state["tick"] == frame
        np.testing.assert_allclose(state["views"][0]["points"][0], expected[frame], atol=2e-4)


@pytest.mark.parametrize("up", "xz")
def test_what_points_up_in_the_file_points_up(browser, up):
    order = {"x": [2, 0, 1], "z": [1, 2, 0]}[up]  # of the world's axes
    offset = np.zeros(3)
    offset["xyz".index(up)] = 1.7
    offset["xyz".index(up) - 1] = 0.3
    skeleton = Skeleton([Bone("head", None, offset, "z")])
    browser.open(player(Motion(skeleton, [[0.0]], 30, up=up)))
    head = state_of(browser)["views"][0]["points"][0][1]
    np.testing.assert_allclose(head, offset[order], atol=1e-4)
    assert head[1] == pytest.approx(1.7, abs=1e-4)


def test_picture_has_the_limbs_in_their_colours(browser, walk):
    picture = browser.open(player(walk)).picture()
    assert pixels_near(picture, LEFT) > 300
    assert pixels_near(picture, RIGHT) > 300
    # A joint is where it is projected: the colour of its side is there.
    state = state_of(browser)
    flat = projected(state, state["views"][0]["points"][0])
    names = walk.skeleton.joint_names
    ends = [j for j in range(len(names)) if j not in walk.skeleton.parents]
    sided = [j for j in ends if names[j].startswith(("left", "right"))]
    assert len(sided) >= 4
    for j in sided:
        x, y = np.rint(flat[j + 1]).astype(int)
        around = picture[y - 3 : y + 4, x - 3 : x + 4]
        assert pixels_near(around, LEFT if names[j].startswith("left") else RIGHT) > 0, names[j]


@pytest.mark.parametrize("density", [1, 2])
def test_picture_is_as_sharp_as_the_display(browser, walk, density):
    browser.open(player(walk), density=density)
    assert browser.js("skpose.stage.canvas.width / skpose.stage.canvas.clientWidth") == pytest.approx(density, 0.01)


def test_ground_and_axes_are_shown_on_request(browser, walk):
    with_them = browser.open(player(walk)).picture()
    height = len(with_them)
    parts = {  # of the picture, without the figure
        "ground": (slice(height - 160, height - 80), slice(120, 300)),
        "axes": (slice(height - 75, height), slice(0, 75)),
    }
    for control, others in (("ground", "axes"), ("axes", "ground")):
        browser.click(f"#{control}")
        without = browser.picture()
        assert changed(with_them[parts[control]], without[parts[control]]) > 20
        if control == "axes":
            assert changed(with_them[parts[others]], without[parts[others]]) == 0
        browser.click(f"#{control}")
        assert changed(with_them, browser.picture()) == 0


def test_the_shadow_is_on_the_ground_below(browser):
    """Of a level bar a little above the ground, on one leg."""
    bones = [Bone("leg", None, (0, -0.2, 0), "z"), Bone("bar", None, (1, 0, 0), "z")]
    browser.open(player(Motion(Skeleton(bones), [[0.0, 0.0]], 30)))
    state, picture = state_of(browser), browser.picture()
    x, y = np.rint(projected(state, [[0.7, 0.0, 0.0]])[0]).astype(int)
    assert (picture[y - 2 : y + 3, x - 2 : x + 3].sum(axis=2) < 3 * 245).sum() > 10
    browser.click("#ground")
    assert pixels_near(browser.picture()[y - 2 : y + 3, x - 2 : x + 3], (255, 255, 255), 4) == 25


def test_trails_lead_to_where_joints_were(browser, walk):
    browser.open(player(walk))
    browser.press("END", css="canvas")
    browser.choose("#place", "spot")
    state = state_of(browser)
    hand = walk.skeleton.joint_names.index("left_hand")
    browser.choose("#joint", "left_hand")
    before = browser.picture()
    browser.click("#trails")
    drawn = browser.picture()
    path = expected_points(walk, "spot")[10:20, hand + 1]
    track = np.rint(projected(state, path)).astype(int)
    on_track = [
        changed(before[y - 2 : y + 3, x - 2 : x + 3], drawn[y - 2 : y + 3, x - 2 : x + 3]) > 0 for x, y in track
    ]
    assert sum(on_track) >= 5  # the others may be behind a limb
    browser.choose("#joint", "")
    assert changed(drawn, browser.picture()) > 50  # now those of all ends


def test_follow_keeps_the_root_in_the_middle(browser, walk):
    browser.open(player(walk))
    root = expected_points(walk)[:, 0]
    for frame, keys in [(0, ["HOME"]), (19, ["END"])]:
        browser.press(*keys, css="canvas")
        np.testing.assert_allclose(
            np.array(state_of(browser)["views"][0]["target"])[[0, 2]], root[frame, [0, 2]], atol=1e-3
        )
    browser.click("#follow")
    fixed = [state_of(browser)["views"][0]["target"]]
    browser.press("HOME", css="canvas")
    assert fixed == [state_of(browser)["views"][0]["target"]]
    for frame in (0, 19):  # and yet all of the path is in the picture
        flat = projected(state_of(browser), expected_points(walk)[frame])
        area = state_of(browser)["views"][0]["area"]
        assert ((flat > 0) & (flat < [area["width"], area["height"]])).all()


# --- time -------------------------------------------------------------------------------------------------------------


def test_it_plays_by_itself_and_from_the_end_to_the_start(browser, walk):
    browser.open(player(walk), still=False)
    assert browser.find("#play").text == "Pause"
    browser.wait("skpose.tick() > 3")
    assert browser.js("Number(skpose.stage.clock.count)") == 20
    browser.wait("(window.seen ??= []).push(skpose.tick()) && seen.some((tick, i) => i && tick < seen[i - 1])")
    browser.click("#play")
    assert browser.find("#play").text == "Play"
    assert not browser.js("skpose.state.playing")


def test_it_stays_still_for_those_who_ask_for_reduced_motion(browser, walk):
    browser.open(player(walk), still=True)
    assert browser.js("[skpose.tick(), skpose.state.playing, skpose.state.position]") == [0, False, 0]
    assert browser.find("#play").text == "Play"
    browser.click("#play")
    browser.wait("skpose.tick() > 2")  # but not for ever


@pytest.mark.parametrize("speed", ["0.1", "1", "4"])
def test_speed(browser, walk, speed):
    browser.open(player(walk), still=False)
    browser.choose("#speed", speed)
    rows = browser.driver.execute_async_script(
        "const [done] = arguments, rows = [];"
        "const note = () => rows.push([skpose.state.before, skpose.state.position]) < 40 ? requestAnimationFrame(note)"
        " : done(rows); note();"
    )
    time, position = np.array(rows).T
    passed, moved = np.diff(time) / 1e3, np.diff(position)
    usual = (passed > 0) & (passed < 0.2) & (moved > 0)  # without pauses of the machine, and the jump to the start
    assert usual.sum() >= 3
    np.testing.assert_allclose(moved[usual] / 20 / passed[usual], float(speed), rtol=1e-6)


def test_scrubbing(browser, walk):
    browser.open(player(walk), still=False)
    slider = browser.find("#time")
    browser.driver.execute_script("arguments[0].dispatchEvent(new Event('input'))", slider)
    assert not browser.js("skpose.state.playing")
    browser.press("HOME", "ARROW_RIGHT", "ARROW_RIGHT", css="#time")
    assert browser.js("[skpose.tick(), skpose.state.playing]") == [2, False]
    assert slider.get_attribute("aria-valuetext") == "0.10 seconds, frame 3 of 20"
    assert browser.find("#clock").text == "0.10 s"
    browser.driver.execute_script("arguments[0].value = 11; arguments[0].dispatchEvent(new Event('input'))", slider)
    browser.settle()
    points = state_of(browser)["views"][0]["points"][0]
    np.testing.assert_allclose(points, expected_points(walk)[11], atol=2e-4)
    browser.press("END", css="#time")
    assert browser.js("skpose.tick()") == 19


def test_times_of_frames_that_are_missing(browser):
    motion = Motion(Skeleton.chain(1), np.linspace(0, 1, 4)[:, None], 10, frame_numbers=[2, 3, 7, 8])
    browser.open(player(motion))
    assert browser.js("skpose.clock.count") == 7
    seen = []
    for _ in range(7):
        seen.append((browser.js("skpose.clock.frames(skpose.tick())[0]"), browser.find("#clock").text))
        browser.press(".", css="canvas")
    assert [frame for frame, _ in seen] == [0, 1, 1, 1, 1, 2, 3]
    assert [text for _, text in seen][::5] == ["0.20 s", "0.70 s"]


# --- mouse, fingers and keys ------------------------------------------------------------------------------------------


def test_keys_in_the_picture(browser, walk):
    browser.open(player(walk))
    start = state_of(browser)
    browser.press(" ", css="canvas")
    assert browser.js("skpose.state.playing")
    browser.press(" ", "HOME", ".", ".", ".", ",", css="canvas")
    assert browser.js("[skpose.tick(), skpose.state.playing]") == [2, False]
    browser.press("END", css="canvas")
    assert browser.js("skpose.tick()") == 19
    for key, name, sign in [
        ("ARROW_LEFT", "azimuth", 1),
        ("ARROW_RIGHT", "azimuth", -1),
        ("ARROW_UP", "elevation", -1),
        ("ARROW_DOWN", "elevation", 1),
        ("+", "zoom", 1),
        ("-", "zoom", -1),
    ]:
        before = state_of(browser)[name]
        browser.press(key, css="canvas")
        assert np.sign(state_of(browser)[name] - before) == sign, key
    browser.press("+", "ARROW_LEFT", "0", css="canvas")
    end = state_of(browser)
    assert [end[name] for name in ("azimuth", "elevation", "zoom", "shift")] == [
        start[name] for name in ("azimuth", "elevation", "zoom", "shift")
    ]


def test_dragging_turns_the_figure(browser, walk):
    browser.open(player(walk))
    before, start = browser.picture(), state_of(browser)
    browser.mouse(("moved", 200, 200), ("pressed", 200, 200), ("moved", 260, 220), ("released", 260, 220))
    after, end = browser.picture(), state_of(browser)
    assert end["azimuth"] < start["azimuth"]  # the front follows the mouse
    assert end["elevation"] > start["elevation"]
    assert changed(before, after) > 1000
    browser.mouse(("moved", 100, 100))  # the button is up
    assert state_of(browser)["azimuth"] == end["azimuth"]
    browser.click("#home")
    assert changed(before, browser.picture()) == 0


def test_shift_and_dragging_moves_it(browser, walk):
    browser.open(player(walk))
    start = state_of(browser)
    flat = projected(start, start["views"][0]["points"][0])
    browser.mouse(("moved", 200, 200), ("pressed", 200, 200), ("moved", 250, 170), ("released", 250, 170), modifiers=8)
    end = state_of(browser)
    assert end["azimuth"] == start["azimuth"]
    moved = projected(end, end["views"][0]["points"][0]) - flat
    np.testing.assert_allclose(np.median(moved, axis=0), [50, -30], rtol=0.1)  # with the mouse


def test_wheel_zooms(browser, walk):
    browser.open(player(walk))
    for delta, sign in ((-200, 1), (300, -1)):
        before = state_of(browser)["zoom"]
        browser.wheel(300, 200, delta)
        browser.wait(f"skpose.stage.camera.zoom !== {before}")
        assert np.sign(state_of(browser)["zoom"] - before) == sign


def test_two_fingers_zoom_and_one_turns(browser, walk):
    browser.open(player(walk), touch=True, size=(420, 800))
    start = state_of(browser)
    browser.fingers([(200, 150), (200, 250)], [(200, 100), (200, 300)])
    wide = state_of(browser)
    assert wide["zoom"] == pytest.approx(2 * start["zoom"])
    assert wide["azimuth"] == start["azimuth"]
    browser.fingers([(200, 150)], [(240, 150)])
    assert state_of(browser)["azimuth"] < start["azimuth"]
    assert state_of(browser)["zoom"] == wide["zoom"]


def test_hovering_names_the_joint(browser, walk):
    browser.open(player(walk))
    browser.press(".", ".", ".", css="canvas")
    state = state_of(browser)
    flat = projected(state, expected_points(walk)[3])
    apart = np.linalg.norm(flat[:, None] - flat, axis=2) + 1e9 * np.eye(len(flat))
    clear = np.flatnonzero(apart.min(axis=1) > 6)
    assert len(clear) >= 8
    names = ["root", *walk.skeleton.joint_names]
    for j in clear:
        browser.mouse(("moved", *(flat[j] + [1, 1])))
        assert browser.find("#tip").text == names[j]
    browser.mouse(("moved", 20, 20))
    assert not browser.find("#tip").is_displayed()


def test_tapping_names_the_joint(browser, walk):
    browser.open(player(walk), touch=True, size=(420, 800))
    state = state_of(browser)
    flat = projected(state, state["views"][0]["points"][0])
    foot = int(np.argmax(flat[:, 1]))
    browser.fingers([tuple(flat[foot])])
    assert browser.find("#tip").text == ["root", *walk.skeleton.joint_names][foot]


def test_choosing_a_joint_labels_it(browser, walk):
    browser.open(player(walk))
    options = [option.text for option in browser.driver.find_elements("css selector", "#joint option")]
    assert options == ["none", *walk.skeleton.joint_names]
    before = browser.picture()
    browser.choose("#joint", "left_hand")
    state = state_of(browser)
    x, y = projected(state, state["views"][0]["points"][0])[1 + walk.skeleton.joint_names.index("left_hand")].astype(
        int
    )
    after = browser.picture()
    assert changed(before[y - 12 : y + 12, x - 60 : x + 60], after[y - 12 : y + 12, x - 60 : x + 60]) > 40
