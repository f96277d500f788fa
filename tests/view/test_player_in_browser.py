"""The player in Chromium: it opens, draws what forward kinematics says, plays, and is used by mouse, keys and links."""

from dataclasses import replace

import numpy as np
import pytest
from browser import pixels_near
from conftest import in_space

from skpose import Keypoints
from skpose.datasets import make_gait
from skpose.keypoints import layouts
from skpose.motions import align_motions
from skpose.view import player

pytestmark = pytest.mark.slow

LEFT, RIGHT = (0, 114, 178), (192, 79, 0)  # colours of the limbs on white
POINTS = "skpose.stage.views.map(({ figures }) => figures.map(({ points }) => points))"


@pytest.fixture(scope="module")
def walk():
    """A walk of one second that begins somewhere and in some direction."""
    motion = make_gait(1, 1, duration=1.0, frame_rate=20, random_state=0).motions[0]
    path = np.linspace([3.0, 1.0, 2.0], [4.0, 1.0, 3.5], len(motion))
    turns = np.linspace([0.1, 0.5, 0.0], [0.1, 1.5, 0.0], len(motion))
    return replace(motion, root_positions=path, root_angles=turns, root_axes="xyz")


@pytest.fixture(scope="module")
def pair():
    gait = make_gait(n_subjects=2, n_sequences=1, duration=1.0, frame_rate=20, random_state=0)
    one, other = gait[gait.actions == "walk"].motions
    return player([one, other], labels=["Anna", "Ben"], alignment=align_motions(one, other))


@pytest.mark.parametrize("size", [(420, 860), (1300, 860)], ids=str)
@pytest.mark.parametrize("dark", [False, True])
def test_page_opens_without_a_message_and_fits_into_the_window(browser, pair, size, dark):
    browser.show(pair, size=size, dark=dark)
    assert browser.problems() == []
    assert browser.text("h1") == "Anna and Ben"
    assert browser.js("document.documentElement.scrollWidth") <= size[0]
    assert browser.js("document.documentElement.dataset.theme") == ("dark" if dark else "light")


def test_foreign_programs_do_not_run(browser, walk):
    page = player(walk)
    page.html = page.html.replace("</main>", "<script>window.foreign = 1</script></main>")
    browser.show(page)
    assert any("Content Security Policy" in text for text in browser.errors())
    assert browser.js("window.foreign") is None


def test_joints_are_where_forward_kinematics_has_them(browser, walk):
    browser.show(player(walk))
    expected = np.concatenate([walk.root_positions[:, None], in_space(walk)], axis=1)
    expected[..., 1] -= expected[..., 1].min()
    for frame, keys in [(0, ["Home"]), (7, ["."] * 7), (19, ["End"])]:
        browser.press(*keys)
        assert browser.js("skpose.tick()") == frame
        np.testing.assert_allclose(browser.js(POINTS)[0][0], expected[frame], atol=2e-4)


def test_limbs_have_the_colours_of_their_sides(browser, walk):
    picture = browser.show(player(walk)).picture()
    assert pixels_near(picture, LEFT) > 300
    assert pixels_near(picture, RIGHT) > 300


def test_it_plays_by_itself_and_pauses(browser, walk):
    browser.show(player(walk), still=False)
    browser.wait_for("skpose.state.playing && skpose.state.position > 1")
    browser.press(" ")
    assert browser.text("#play") == "Play"
    assert browser.js("skpose.state.playing") is False


def test_a_drag_turns_and_zero_resets(browser, walk):
    browser.show(player(walk))
    before = browser.js("skpose.stage.camera.azimuth")
    browser.mouse(("pressed", 300, 300), ("moved", 350, 300), ("moved", 400, 300), ("released", 400, 300))
    assert browser.js("skpose.stage.camera.azimuth") == pytest.approx(before - 0.8)
    browser.press("0")
    assert browser.js("skpose.stage.camera.azimuth") == pytest.approx(before)


def test_matching_frames_and_their_distances(browser, pair):
    browser.show(pair)
    browser.press(*["."] * 5)
    frames, path = browser.js("[skpose.clock.frames(5), [0, 1].map((i) => skpose.clock.pairs.path.at(5, i))]")
    assert (browser.js("skpose.tick()"), frames) == (5, path)
    assert browser.js("skpose.clock.pairs.largest") > 0.1


def test_a_link_restores_what_is_shown(browser, walk):
    page = player(walk)
    browser.show(page, "#t=0.25&loop=0.1,0.6&joint=left_hand&ghosts=1&speed=0.5")
    state = "[skpose.tick(), skpose.loop.from, skpose.loop.to, element('joint').value, element('ghosts').checked]"
    state = state.replace("element(", "document.getElementById(")
    assert browser.js(state) == [5, 2, 12, "left_hand", True]
    browser.wait_for("location.hash.includes('joint=left_hand')")
    browser.show(page, browser.run("location.hash"))
    assert browser.js(state) == [5, 2, 12, "left_hand", True]


def test_the_picture_of_a_moment_is_a_file(browser, walk):
    browser.show(player(walk))
    browser.run("URL.createObjectURL = (blob) => (window.file = blob, 'blob:x')")
    browser.click("#picture")
    browser.wait_for("window.file?.type === 'image/png'")
    assert browser.js("window.file.size") > 5000


def test_the_loop_is_a_gif_with_a_picture_for_every_25th_of_a_second(browser, walk):
    browser.show(player(walk), "#t=0&loop=0,0.35", size=(500, 400))
    browser.run("URL.createObjectURL = (blob) => (window.file = blob, 'blob:x')")
    browser.click("#gif")
    browser.wait_for("window.file?.type === 'image/gif'")
    head = browser.js("file.arrayBuffer().then((bytes) => [...new Uint8Array(bytes)])")
    assert bytes(head[:6]) == b"GIF89a"
    assert bytes(head).count(bytes([0x21, 0xF9, 4, 5, 4, 0])) == 10


def test_keypoints_that_are_missing_are_not_drawn(browser):
    positions = np.random.default_rng(0).normal(size=(4, 17, 3))
    positions[:, 3] = np.nan
    browser.show(player(Keypoints(positions, list(layouts["coco17"].names), 25)))
    flat = browser.js("skpose.stage.views[0].figures[0].flat.map((one) => one !== null)")
    assert [i for i, drawn in enumerate(flat) if not drawn] == [0, 4]  # the middle, and the missing one
    assert browser.problems() == []
