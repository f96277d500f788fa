"""What one sends to somebody: slow motion, a loop, links, pictures and videos of the player, in Chromium."""

import struct
from io import BytesIO

import numpy as np
import pytest
from browser import pixels_near
from files_of_page import KEEP, duration_of, file_of, link_of
from PIL import Image, ImageSequence
from player_page import LEFT, RIGHT, projected, state_of

from skpose import Bone, Motion, Skeleton
from skpose.datasets import make_gait
from skpose.keypoints import Keypoints
from skpose.motions import align_motions
from skpose.view import player
from skpose.view._page import asset

pytestmark = pytest.mark.slow

DRAWN = """
const [seconds, done] = arguments, seen = new Set(), begin = performance.now();
let n = 0;
const note = () => {
  n++;
  seen.add(JSON.stringify(skpose.stage.views.map((view) => view.figures.map((figure) => figure.points))));
  if (performance.now() - begin < 1000 * seconds || n < 12) requestAnimationFrame(note); else done([n, seen.size]);
};
note();
"""
AT = "skpose.stage.clips[{clip}].points({moment}, 'world')"


@pytest.fixture(scope="module")
def walks():
    gait = make_gait(n_subjects=2, n_sequences=1, duration=1.0, frame_rate=20, random_state=0)
    walks = gait[gait.actions == "walk"].motions
    return walks[0], walks[1][:14]


# --- between recorded frames ------------------------------------------------------------------------------------------


@pytest.mark.parametrize("aligned", [False, True])
def test_slow_motion_has_a_picture_of_its_own_for_each_frame_of_the_display(browser, walks, aligned):
    """Ten frames a second: two seconds at 0.1 × had 3 or 4 pictures."""
    page = player(walks, alignment=align_motions(*walks)) if aligned else player(walks[0])
    browser.open(page, still=True)
    browser.choose("#speed", "0.1")
    browser.click("#play")
    shown = browser.driver.execute_async_script(
        "const [done] = arguments; let n = 0, drawn = skpose.state.drawn; const begin = performance.now();"
        "const note = () => (n++, performance.now() - begin < 2000 ? requestAnimationFrame(note)"
        " : done([n, skpose.state.drawn - drawn])); note()"
    )
    frames, different = browser.driver.execute_async_script(DRAWN, 1.0)
    assert shown[1] >= shown[0] - 2  # each frame of the display
    assert different >= max(frames - 2, 10)  # and each is another picture


def test_bones_keep_their_lengths_between_frames(browser, walks):
    browser.open(player(walks[0]))
    parents = [p + 1 for p in walks[0].skeleton.parents]
    lengths = np.array([np.linalg.norm(bone.offset) for bone in walks[0].skeleton.bones])
    for place in ("world", "forward"):
        for moment in np.arange(0, 19, 0.37):
            points = np.array(browser.js(f"skpose.stage.clips[0].points({moment}, '{place}')"))
            found = np.linalg.norm(points[1:] - points[parents], axis=1)
            np.testing.assert_allclose(found, lengths, atol=6e-5)  # twice the rounding of positions


def test_what_is_between_is_near_to_what_was_recorded_there(browser):
    """Every other frame of an arm that swings, and those left out: a line in space is ten times as far away."""
    time = np.arange(81)[:, None] / 40
    angles = np.sin(2 * np.pi * time + [0.0, 0.5, 1.0])
    browser.open(player([Motion(Skeleton.chain(3), angles, 40), Motion(Skeleton.chain(3), angles[::2], 20)]))
    off, straight = [], []
    for frame in range(3, 77, 2):
        recorded = np.array(browser.js(AT.format(clip=0, moment=frame)))
        ends = [np.array(browser.js(AT.format(clip=0, moment=frame + side))) for side in (-1, 1)]
        off.append(np.array(browser.js(AT.format(clip=1, moment=frame / 2))) - recorded)
        straight.append(np.mean(ends, axis=0) - recorded)
    assert np.linalg.norm(off) < 0.1 * np.linalg.norm(straight)


def test_recorded_frames_are_as_recorded_and_steps_go_to_them(browser, walks):
    browser.open(player(walks[0]))
    browser.js("(skpose.state.position = 7.4)")
    for key, expected in ((".", 8), (",", 7)):
        browser.press(key, css="canvas")
        assert browser.js("skpose.state.position") == expected
    browser.js("(skpose.state.position = 7.4)")
    browser.press(",", css="canvas")
    assert browser.js("skpose.state.position") == 7
    assert browser.find("#clock").text == "0.35 s"


def test_missing_frames_are_not_made_up(browser):
    motion = Motion(Skeleton.chain(1), np.linspace(0, 1, 4)[:, None], 10, frame_numbers=[2, 3, 7, 8])
    browser.open(player(motion))
    moments = browser.js("[0, 0.5, 1, 1.5, 3, 4.9, 5, 5.5].map((tick) => skpose.clock.frames(tick)[0])")
    np.testing.assert_allclose(moments, [0, 0.5, 1, 1, 1, 1, 2, 2.5], atol=1e-9)


def test_points_that_are_not_seen_in_the_next_frame_stay(browser):
    positions = np.zeros((4, 2, 3))
    positions[:, 1, 0] = [1.0, 2.0, 3.0, 4.0]
    positions[:, 0, 1] = 1.0
    positions[2, 1] = np.nan
    browser.open(player(Keypoints(positions, ["a", "b"], 10)))
    local = [browser.js(f"skpose.stage.clips[0].locals({moment})[1][0]") for moment in (1, 1.5)]
    assert local[0] == local[1]
    assert browser.js("[0.5, 1.5, 2.5].map((moment) => skpose.stage.clips[0].shows(moment, 2))") == [True, True, False]


# --- the loop ---------------------------------------------------------------------------------------------------------


def test_the_loop_is_set_by_keys_and_marks(browser, walks):
    browser.open(player(walks[0]))
    browser.press(*"....", "i", *"....", "o", css="canvas")
    assert browser.js("[skpose.loop.from, skpose.loop.to]") == [4, 8]
    assert browser.find("#to").get_attribute("aria-valuetext") == "0.40 seconds after the start"
    assert {browser.find(f"#{end}").accessible_name for end in ("from", "to")} == {
        "Start of the loop",
        "End of the loop",
    }
    browser.press("ARROW_RIGHT", css="#from")
    browser.press("ARROW_LEFT", css="#to")
    assert browser.js("[skpose.loop.from, skpose.loop.to]") == [5, 7]
    browser.press("END", css="#from")  # takes the other along
    assert browser.js("[skpose.loop.from, skpose.loop.to]") == [19, 19]
    browser.press("l", css="canvas")
    assert browser.js("[skpose.loop.from, skpose.loop.to, skpose.loop.isWhole]") == [0, 19, True]


def test_what_plays_stays_in_the_loop(browser, walks):
    browser.open(player(walks[0]))
    browser.press(*"....", "i", *"....", "o", "HOME", css="canvas")
    browser.choose("#speed", "4")
    browser.click("#play")
    browser.driver.execute_script(
        "window.seen = []; const note = () => (seen.push(skpose.moment()), requestAnimationFrame(note)); note()"
    )
    browser.wait("seen.length > 20 && new Set(seen.map(Math.floor)).size > 3")
    seen = np.array(browser.js("seen.slice(1)"))
    assert seen.min() >= 4
    assert seen.max() <= 8


# --- links ------------------------------------------------------------------------------------------------------------


def test_a_link_opens_the_same(browser, walks):
    page = player(walks, labels=["a", "b"])
    browser.open(page)
    browser.choose("#layout", "overlay")
    browser.choose("#joint", "left_hand")
    browser.click("#trails")
    browser.press(*"...", "i", *"....", "o", ",", "ARROW_LEFT", "+", "ARROW_UP", css="canvas")
    browser.wait("location.hash.includes('camera')")
    browser.wait("skpose.link.address === location.href")
    address, before = browser.js("location.href"), state_of(browser)
    browser.driver.get("about:blank")
    browser.driver.get(address)
    browser.wait("window.skpose && skpose.state.drawn > 0")
    after = state_of(browser)
    for name in ("azimuth", "elevation", "zoom"):
        assert after[name] == pytest.approx(before[name], abs=1e-4)
    assert after["tick"] == before["tick"] == 6
    assert not after["playing"]
    assert browser.js("[skpose.loop.from, skpose.loop.to]") == [3, 7]
    assert browser.js("['layout', 'joint'].map((id) => document.getElementById(id).value)") == ["overlay", "left_hand"]
    assert browser.find("#trails").is_selected()
    browser.driver.execute_script("location.hash = 't=0.5'")
    browser.wait("skpose.tick() === 10")
    assert browser.find("#layout").get_attribute("value") == "side"  # what the link does not say is as usual


def test_a_link_has_what_is_switched_off(browser, walks):
    browser.open(player(walks, alignment=align_motions(*walks)))
    boxes = ["ground", "axes", "follow", "differences", "align"]
    browser.driver.execute_script("document.getElementById('place').value = 'world'")
    for box in boxes:
        browser.driver.execute_script(f"document.getElementById('{box}').click()")
    browser.wait("location.hash.includes('align=0')")
    address = browser.js("skpose.link.address")
    browser.driver.get("about:blank")
    browser.driver.get(address)
    browser.wait("window.skpose && skpose.state.drawn > 0")
    checked = browser.js(f"{boxes}.map((id) => document.getElementById(id).checked)")
    assert not any(checked)


def test_a_joint_whose_name_is_a_number_is_in_a_link(browser):
    chain = Skeleton([Bone("07", None, (0, 0.5, 0), "xyz"), Bone("1e3", "07", (0, 0.4, 0), "x")])
    browser.open(player(Motion(chain, np.zeros((5, 4)), 10)))
    browser.choose("#joint", "1e3")
    browser.wait("location.hash.includes('joint=1e3')")
    address = browser.js("skpose.link.address")
    browser.driver.get("about:blank")
    browser.driver.get(address)
    browser.wait("window.skpose && skpose.state.drawn > 0")
    assert browser.find("#joint").get_attribute("value") == "1e3"


def test_playing_writes_no_time_and_no_history(browser, walks):
    browser.open(player(walks[0]), still=False)
    entries = browser.js("history.length")
    browser.choose("#speed", "0.5")
    browser.wait("location.hash === '#speed=0.5'")
    browser.click("#play")
    browser.wait("/^#t=[0-9.]+&speed=0.5$/.test(location.hash)")
    assert browser.js("history.length") == entries


@pytest.mark.parametrize(
    "fragment",
    [
        "nonsense",
        "t=",
        "t=NaN",
        "t=1e999",
        "t=-5",
        "loop=5",
        "loop=2,1",
        "loop=a,b",
        "camera=1,2",
        "camera=1e300,9,0,1e9,-1e9",
        "joint=constructor&layout=__proto__&trails=2",
        "t=%E0%A4%A&=&&&%",
        "apart=-1&dim=99",
        "x" * 9000,
    ],
)
def test_nonsense_in_a_link_is_ignored(browser, walks, fragment):
    browser.open(player(walks[0]))
    browser.driver.execute_script("location.hash = arguments[0]", fragment)
    browser.settle()
    browser.driver.refresh()
    browser.wait("window.skpose && skpose.state.drawn > 0")
    state = state_of(browser)
    assert 0 <= state["tick"] < 20
    assert np.isfinite([state["azimuth"], state["elevation"], state["zoom"], *state["shift"]]).all()
    assert np.isfinite(projected(state, state["views"][0]["points"][0])).all()
    assert browser.driver.get_log("browser") == []


def test_the_link_is_copied(browser, walks):
    browser.open(player(walks[0]))
    assert link_of(browser) == browser.js("skpose.link.address")


# --- files ------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("paper", [True, False])
def test_picture(browser, walks, paper):
    browser.open(player(walks[0], labels=["a walk: 1/2"]))
    size = browser.js("[skpose.stage.canvas.clientWidth, skpose.stage.canvas.clientHeight]")
    if not paper:
        browser.driver.execute_script("document.getElementById('paper').checked = false")
    name, kind, content = file_of(browser, "#picture")
    assert (name, kind) == ("a_walk_1_2.png", "image/png")
    image = Image.open(BytesIO(content))
    np.testing.assert_allclose(image.size, np.multiply(2, size), atol=2)
    corner = np.array(image.convert("RGBA"))[5, 5]
    assert corner.tolist() == ([255, 255, 255, 255] if paper else [0, 0, 0, 0])


def test_gif(browser, walks):
    browser.open(player(walks[0], title="walk"), size=(420, 600))
    browser.press("i", *"....", "o", css="canvas")
    name, kind, content = file_of(browser, "#gif")
    assert (name, kind) == ("walk.gif", "image/gif")
    image = Image.open(BytesIO(content))
    size = browser.js("[skpose.stage.canvas.clientWidth, skpose.stage.canvas.clientHeight]")
    np.testing.assert_allclose(image.size, size, atol=2)
    pictures = [frame.convert("RGB") for frame in ImageSequence.Iterator(image)]
    assert len(pictures) == 6  # five frames of 0.05 s, in 0.04 s each
    assert image.info["duration"] == 40
    assert image.info["loop"] == 0
    browser.press("HOME", css="canvas")
    expected = browser.picture()
    first = np.asarray(pictures[0]).astype(int)[: len(expected), : expected.shape[1]]
    off = np.abs(first - expected[: len(first), : first.shape[1]])[8:-8, 8:-8]  # without the mark of the focus
    assert off.mean() < 1.0
    assert np.percentile(off, 99) <= 12
    assert not np.array_equal(np.asarray(pictures[0]), np.asarray(pictures[-1]))


def test_video(browser, walks):
    browser.open(player(walks[0], title="walk"), size=(420, 600))
    if not browser.js("Boolean(globalThis.MediaRecorder)"):
        pytest.skip("this browser does not record")
    name, kind, content = file_of(browser, "#video")
    assert (name, kind) == ("walk.webm", "video/webm")
    assert len(content) > 2000
    assert duration_of(content) > 1.0 - 0.1  # a browser that has other work to do takes longer


RECORD = """<!DOCTYPE html><html><head><title>record</title></head><body><script>{script}
window.stated = async (bytes, duration) => {{
  const file = withDuration(Uint8Array.from(bytes), duration);
  return [...new Uint8Array(await new Blob([file]).arrayBuffer())];
}};
</script></body></html>"""


def element(identity, content, n_bytes):
    """An element of EBML whose size takes so many bytes."""
    size = (len(content) | 1 << 7 * n_bytes).to_bytes(n_bytes, "big")
    return bytes.fromhex(identity) + size + content


@pytest.mark.parametrize("n_bytes", [1, 2, 8])
def test_a_video_without_a_duration_gets_one(browser, n_bytes):
    scale, cluster = element("2ad7b1", b"\x0f\x42\x40", 1), element("1f43b675", b"\x01" * 40, 2)
    start = element("1a45dfa3", b"\x42\x82\x84webm", 1)
    browser.open(RECORD.format(script=asset("record.js")))
    for before, duration, expected in (
        (scale, 1234.5, element("4489", struct.pack(">d", 1234.5), 1) + scale),
        (scale + element("4489", struct.pack(">d", 7.0), 1), 1234.5, None),  # which has one
    ):
        file = start + element("1549a966", before, n_bytes) + cluster
        found = bytes(
            browser.driver.execute_async_script(
                "const [bytes, duration, done] = arguments; stated(bytes, duration).then(done)", list(file), duration
            )
        )
        assert found == (file if expected is None else start + element("1549a966", expected, 8) + cluster)


@pytest.mark.parametrize("how", ["document.getElementById('cancel').click()", "dispatchEvent(new Event('resize'))"])
def test_a_gif_can_be_cancelled(browser, walks, how):
    """A page of another size cancels it too, as all pictures have one."""
    browser.open(player(walks[0]))
    browser.choose("#speed", "0.1")
    browser.driver.execute_script(KEEP)
    browser.click("#share")
    browser.click("#gif")
    browser.wait("document.getElementById('progress').value > 0")
    browser.driver.execute_script(how)
    browser.wait("document.getElementById('work').hidden")
    assert browser.find("#said").text == "Cancelled."
    assert browser.js("files.length") == 0


# --- figures in one picture -------------------------------------------------------------------------------------------


def test_figures_are_spread_and_others_step_back(browser, walks):
    browser.open(player(walks, labels=["a", "b"], overlay=True))
    together = [np.array(points) for points in state_of(browser)["views"][0]["points"]]
    assert browser.find("#apart").is_displayed()
    browser.driver.execute_script(
        "const one = document.getElementById('apart'); one.value = '1'; one.dispatchEvent(new Event('change'))"
    )
    browser.settle()
    spread = [np.array(points) for points in state_of(browser)["views"][0]["points"]]
    moved = [(after - before)[0] for before, after in zip(together, spread, strict=True)]
    assert np.linalg.norm(moved[1] - moved[0]) == pytest.approx(1.0)
    assert moved[0][1] == 0
    before = browser.picture()
    browser.choose("#dim", "0")
    after = browser.picture()
    assert pixels_near(after, LEFT) >= pixels_near(before, LEFT) > 300  # the colours of the two
    assert pixels_near(after, RIGHT) < 0.1 * pixels_near(before, RIGHT)
    browser.choose("#layout", "side")
    assert not browser.find("#apart").is_displayed()


def test_names_that_begin_the_same_differ_on_a_phone(browser, walks):
    stem = "subject_07_a_long_name_of_a_recording_that_all_have_"
    labels = [f"{stem}first.bvh", f"{stem}second.bvh"]
    browser.open(player(walks, labels=labels), size=(420, 800), touch=True)
    browser.settle()
    assert browser.js("skpose.stage.names") == ["…first.bvh", "…second.bvh"]
    assert browser.js("skpose.stage.written.map(({ name }) => name)") == labels
    x, y = browser.js("[skpose.stage.written[1].x + 10, skpose.stage.written[1].y - 4]")
    browser.fingers([(x, y)])
    assert browser.find("#tip").text == labels[1]
    assert browser.js("skpose.stage.shortened('abcdefghijklmnopqrstuvwxyz', 60)").count("…") == 1
    assert browser.js("skpose.stage.shortened('abcdefghijklmnopqrstuvwxyz', 60)")[0::].startswith("a")
    assert browser.js("skpose.stage.shortened('abcdefghijklmnopqrstuvwxyz', 60)").endswith("z")


# --- the camera, and fingers ------------------------------------------------------------------------------------------

EYE = """(() => {
  const { camera, views: [{ view }] } = skpose.stage;
  const far = camera.distance / camera.zoom;
  return view.target[1] + far * Math.sin(camera.elevation)
    + camera.shift[1] * camera.distance * Math.cos(camera.elevation);
})()"""


@pytest.mark.parametrize("modifiers", [0, 8], ids=["turn", "move"])
@pytest.mark.parametrize("zoom", ["+", "-", ""])
def test_the_camera_stays_above_the_ground(browser, walks, modifiers, zoom):
    browser.open(player(walks[0]))
    for _ in range(4):
        for dy in (-400, 300, -400):
            begin, end = (300, 450), (320, 450 + dy)
            browser.mouse(
                ("moved", *begin), ("pressed", *begin), ("moved", *end), ("released", *end), modifiers=modifiers
            )
            if zoom:
                browser.press(zoom, css="canvas")
            assert browser.js(EYE) > 0
    browser.mouse(("moved", 300, 50), ("pressed", 300, 50), ("moved", 300, 500), ("released", 300, 500))
    browser.mouse(("moved", 300, 50), ("pressed", 300, 50), ("moved", 300, 500), ("released", 300, 500))
    assert state_of(browser)["elevation"] == pytest.approx(1.55)  # from straight above


def test_a_swipe_over_a_page_that_is_longer_than_the_window_scrolls_it(browser, walks):
    browser.open(player(walks[0]), size=(420, 800), touch=True)
    browser.driver.execute_script("document.body.style.height = '1600px'; document.body.style.minHeight = '1600px'")
    browser.wait("skpose.stage.canvas.style.touchAction === 'pan-y'")
    azimuth = browser.js("skpose.stage.camera.azimuth")
    browser.fingers([(200, 300)], [(230, 301)], [(280, 302)])
    turned = browser.js("skpose.stage.camera.azimuth")
    assert turned < azimuth - 0.2
    assert browser.js("scrollY") == 0
    browser.fingers(*[[(200, y)] for y in range(420, 100, -40)])
    browser.wait("scrollY > 100")
    assert browser.js("skpose.stage.camera.azimuth") == pytest.approx(turned, abs=0.05)  # until it was a swipe


def test_a_swipe_in_a_frame_is_for_the_page_around(browser, walks):
    style = "margin: 0; height: 3000px"
    browser.open(
        f"<!DOCTYPE html><meta name=viewport content='width=device-width'><body style='{style}'>"
        f"{player(walks[0])._repr_html_()}</body>",
        size=(420, 800),
        touch=True,
    )
    assert browser.find("figcaption").text == "motion: 1 motion, positions within 0.025 mm"
    assert browser.find("iframe").get_attribute("title") == "motion"
    browser.driver.switch_to.frame(browser.find("iframe"))
    browser.wait("window.skpose && skpose.state.drawn > 0")
    assert browser.js("skpose.stage.canvas.style.touchAction") == "pan-y"
    assert not browser.find("#copy").is_displayed()  # it has no address
    browser.fingers(*[[(200, y)] for y in range(250, 30, -40)])  # the frame is at the corner of the page
    browser.driver.switch_to.default_content()
    browser.wait("scrollY > 50")


def test_a_page_that_is_the_player_alone_turns_by_one_finger(browser, walks):
    browser.open(player(walks[0]), size=(420, 800), touch=True)
    assert browser.js("skpose.stage.canvas.style.touchAction") == "none"
    before = state_of(browser)
    browser.fingers([(200, 150)], [(200, 190)])
    assert state_of(browser)["elevation"] > before["elevation"]
