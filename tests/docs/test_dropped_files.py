"""The page into which visitors drop files: what it reads, shows and measures is what the library does."""

import json
import re
import warnings

import numpy as np
import pytest
from pages_to_try import DATA, drop, live_pages, open_drop_page, open_window, page_data

from skpose import Motion, pose_distances
from skpose._cli.main import main
from skpose.datasets import humanoid
from skpose.io import MocapFormatError, load_bvh, save_bvh
from skpose.skeleton._shared import sides
from skpose.view._scene import scene_of

READ = """(() => {{
  try {{
    const motion = drop.motionOf(drop.readBvh({text}), {scale});
    const {{ joints, root, headings, size, standing }} = drop.sceneOf(motion, {up});
    const {{ names, parents, sides, columns, weights }} = motion.skeleton;
    return {{
      joints, root, headings, size, standing, names, parents, sides, columns, weights, rate: motion.rate,
      poses: motion.poses.map((pose) => Array.from(pose)), shape: drop.shapeOf(motion.skeleton),
    }};
  }} catch (error) {{
    return error.message;
  }}
}})()"""
# A walker below a joint of reference that stands still, with a bone whose position channels replace its OFFSET.
REFERENCE = """HIERARCHY
ROOT reference
{
  OFFSET 0 0 0
  CHANNELS 6 Xposition Yposition Zposition Zrotation Xrotation Yrotation
  JOINT hips
  {
    OFFSET 1 2 3
    CHANNELS 6 Xposition Yposition Zposition Yrotation Xrotation Zrotation
    JOINT left
    {
      OFFSET 0 -4 0
      CHANNELS 6 Xposition Yposition Zposition Xrotation Zrotation Yrotation
      End Site
      {
        OFFSET 0 -5 1
      }
    }
    JOINT right
    {
      OFFSET 1 -4 0
      CHANNELS 2 Xrotation Yrotation
      End Site
      {
        OFFSET 0 -5 1
      }
    }
  }
}
MOTION
Frames: 3
Frame Time: 0.04
1 0 2 0 0 0   0 9 0 10 20 30   0 -6 0 5 6 7   8 9
1 0 2 0 0 0   1 9 2 11 21 31   0 -6 0 6 7 8   9 8
1 0 2 0 0 0   2 9 4 12 22 32   0 -6 0 7 8 9   10 7
"""
ARM = """HIERARCHY
ROOT a
{
  OFFSET 0 0 0
  CHANNELS 6 Xposition Yposition Zposition Zrotation Xrotation Yrotation
  JOINT b
  {
    OFFSET 30 0 0
    CHANNELS 3 Zrotation Xrotation Yrotation
    JOINT c
    {
      OFFSET 20 0 0
      CHANNELS 3 Zrotation Xrotation Yrotation
      End Site
      {
        OFFSET 10 0 0
      }
    }
  }
}
MOTION
Frames: 2
Frame Time: 0.04
0 0 0 0 0 0  10 20 30  40 50 60
0 0 0 0 0 0  20 20 30  40 50 60
"""


@pytest.fixture(scope="module")
def window():
    yield from open_window()


@pytest.fixture(scope="module")
def dropped(window, tmp_path_factory):
    """The page into which files are dropped."""
    return open_drop_page(window, tmp_path_factory.mktemp("drop"))


def read(window, text, *, scale=1.0, up="y"):
    return window.run(READ.format(text=json.dumps(text), scale=scale, up=json.dumps(up)))


def assert_reads_as_the_library(window, path, up=None):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        motion = load_bvh(path, scale=0.01, up=up)
    found = read(window, path.read_text(encoding="utf-8"), scale=0.01, up=motion.up)
    scene = scene_of(motion)
    assert found["names"] == list(motion.skeleton.joint_names)
    assert found["parents"] == motion.skeleton.parents.tolist()
    assert found["sides"] == sides(motion.skeleton.joint_names)
    assert found["weights"] == motion.skeleton.weights.tolist()
    assert found["standing"] == scene.standing
    assert found["rate"] == pytest.approx(motion.frame_rate, rel=1e-12)
    np.testing.assert_allclose(found["poses"], motion.angles, atol=1e-13)
    for name in ("joints", "root", "size"):
        np.testing.assert_allclose(found[name], getattr(scene, name), atol=1e-13 * scene.size)
    np.testing.assert_allclose(np.sin(np.subtract(found["headings"], scene.headings) / 2.0), 0.0, atol=1e-14)


@pytest.mark.parametrize("name", [path.name for path in sorted(DATA.glob("*.bvh"))])
def test_files_are_read_as_by_the_library(dropped, name):
    assert_reads_as_the_library(dropped, DATA / name)


@pytest.mark.parametrize("up", ["x", "y", "z"])
def test_a_reference_that_stands_still_is_not_the_root(dropped, up, tmp_path):
    path = tmp_path / "reference.bvh"
    path.write_text(REFERENCE)
    assert_reads_as_the_library(dropped, path, up)


@pytest.mark.parametrize("order", ["XYZ", "ZXY", "YZX"])
def test_written_files_are_read_again(dropped, order, tmp_path):
    rng = np.random.default_rng(0)
    skeleton = humanoid()
    motion = Motion(
        skeleton, rng.normal(size=(7, skeleton.n_dofs)), 25, rng.normal(size=(7, 3)), rng.normal(size=(7, 3)), order
    )
    save_bvh(tmp_path / "written.bvh", motion, scale=0.01)
    assert_reads_as_the_library(dropped, tmp_path / "written.bvh")


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (lambda text: text[:200], "MOTION"),
        (lambda text: "a,b\n1,2\n", "HIERARCHY"),
        (lambda text: text.rsplit(None, 2)[0], "cut short"),
        (lambda text: re.sub(r"Frame Time:.*", "Frame Time: 0", text), "Frame Time"),
        (lambda text: text.replace("OFFSET", "OFSET", 1), "OFSET"),
        (lambda text: text.rsplit(None, 1)[0] + " nan\n", "no finite number"),
        (lambda text: text.rsplit(None, 1)[0] + " 0x10\n", "no finite number"),
        (lambda text: re.sub(r"Frame Time:.*", "Frame Time: Infinity", text), "Frame Time"),
        (lambda text: re.sub(r"(OFFSET .*)", r"\1\n\1", text, count=1), "OFFSET twice"),
        (lambda text: re.sub(r"(CHANNELS .*)", r"\1\n\1", text, count=1), "CHANNELS twice"),
        (lambda text: text.replace("Yrotation", "Zrotation"), "CHANNELS"),
        (lambda text: re.sub(r"OFFSET \S+", "OFFSET 0x32", text, count=1), "0x32"),
        (lambda text: text.replace("JOINT ", "JOINT\xa0", 1), "not expected"),
        (lambda text: re.sub(r"CHANNELS (\d)", r"CHANNELS 0x\1", text, count=1), "CHANNELS"),
        (lambda text: "\u2028" + text, "HIERARCHY"),
        (lambda text: text + "\u2028", "cut short"),
        (lambda text: re.sub(r"Frame Time:.*", "Frame Time: 1e-309", text), "Frame Time"),
        (lambda text: re.sub(r"Frames:.*", "constructor: 1", text), "Frames"),
    ],
)
def test_what_is_no_whole_file_is_refused_in_words(dropped, change, words, tmp_path):
    text = change((DATA / "biped.bvh").read_text(encoding="utf-8"))
    (tmp_path / "bad.bvh").write_text(text, encoding="utf-8")
    with pytest.raises(MocapFormatError):
        load_bvh(tmp_path / "bad.bvh", scale=0.01)
    assert words in read(dropped, text)


@pytest.mark.parametrize("end", ["", "End Site\n{\nOFFSET 0 9 0\n}\n"])
def test_a_root_alone_has_no_poses(dropped, end, tmp_path):
    text = f"HIERARCHY\nROOT a\n{{\nOFFSET 0 0 0\nCHANNELS 3 Xrotation Yrotation Zrotation\n{end}}}\n"
    text += "MOTION\nFrames: 2\nFrame Time: 0.04\n0 0 0\n1 2 3\n"
    (tmp_path / "root.bvh").write_text(text)
    with pytest.raises(MocapFormatError, match="rotation channels below the root 'a'"):
        load_bvh(tmp_path / "root.bvh", scale=0.01)
    assert "below the root a has rotation channels" in read(dropped, text)


@pytest.mark.parametrize(("factor", "words"), [(1e180, "m far or large"), (5e307, "too large"), (1e-200, "m large")])
def test_sizes_that_cannot_be_shown_are_refused(dropped, factor, words):
    text = re.sub(r"OFFSET (\d+) (\d+)", lambda m: f"OFFSET {int(m[1]) / 10 * factor} {m[2]}", ARM)
    found = read(dropped, text)
    assert words in found
    assert "the unit" in found


@pytest.mark.parametrize("factor", [1e-5, 1e4])
def test_sizes_within_the_limits_are_read_as_by_the_library(dropped, factor, tmp_path):
    text = re.sub(r"OFFSET (\d+)", lambda m: f"OFFSET {int(m[1]) * factor}", ARM)
    (tmp_path / "arm.bvh").write_text(text)
    assert_reads_as_the_library(dropped, tmp_path / "arm.bvh")


def files_of(texts):
    return f"[{', '.join(f'new File([{json.dumps(text)}], {json.dumps(name)})' for name, text in texts.items())}]"


@pytest.mark.parametrize("metric", ["angle", "position", "rotation", "spatial"])
def test_the_curve_is_the_distance_to_each_frame(dropped, metric, tmp_path):
    texts = {one["name"]: one["text"] for one in page_data(drop.page())["examples"]}
    dropped.run(f"drop.read({files_of(texts)})")
    dropped.run(f"document.getElementById('metric').value = '{metric}'; drop.state.shown = -1")
    dropped.run("drop.state.values = null")
    dropped.wait_for("drop.state.values && drop.state.shown >= 0")
    frame, values = dropped.run("[drop.state.shown, Array.from(drop.state.values)]")
    for name, text in texts.items():
        (tmp_path / name).write_text(text)
    walk, run = (load_bvh(tmp_path / name, scale=0.01) for name in texts)
    expected = pose_distances(walk.angles[[frame]], run.angles, skeleton=walk.skeleton, metric=metric)[0]
    np.testing.assert_allclose(values, expected, rtol=1e-9, atol=1e-9)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (lambda text: text.replace("JOINT c", "JOINT d"), "Only one of the two has"),
        (lambda text: text.replace("CHANNELS 3 Zrotation Xrotation", "CHANNELS 3 Xrotation Zrotation"), "ball joints"),
        (lambda text: text.replace("OFFSET 30 0 0", "OFFSET 0 30 0"), "90° apart"),
        (lambda text: text.replace("    JOINT c", "    }\n    JOINT c").replace("}\n  }\n}", "}\n}", 1), "comes after"),
    ],
    ids=["names", "axes", "directions", "parents"],
)
def test_motions_of_other_skeletons_are_shown_and_not_compared(dropped, change, words, tmp_path):
    texts = {"one.bvh": ARM, "other.bvh": change(ARM)}
    for name, text in texts.items():
        (tmp_path / name).write_text(text)
    paths, out = [str(tmp_path / name) for name in texts], str(tmp_path / "D.npy")
    assert main(["distances", *paths, "--scale", "0.01", "--out", out]) == 1
    dropped.run(f"drop.read({files_of(texts)})")
    dropped.wait_for(f"document.getElementById('words').textContent.includes({json.dumps(words)})")
    assert "one: " in dropped.run("document.getElementById('state').textContent")


@pytest.mark.parametrize(("degrees", "compared"), [(44.9, True), (45.1, False)])
def test_bones_may_point_apart_as_far_as_for_the_library(dropped, degrees, compared, tmp_path):
    angle = np.radians(degrees)
    turned = ARM.replace("OFFSET 30 0 0", f"OFFSET {30 * np.cos(angle):.9f} {30 * np.sin(angle):.9f} 0")
    for name, text in (("one.bvh", ARM), ("other.bvh", turned)):
        (tmp_path / name).write_text(text)
    paths, out = [str(tmp_path / name) for name in ("one.bvh", "other.bvh")], str(tmp_path / "D.npy")
    assert main(["distances", *paths, "--scale", "0.01", "--out", out]) == (0 if compared else 1)
    dropped.run(f"drop.read({files_of({'one.bvh': ARM, 'other.bvh': turned})})")
    assert (dropped.run("drop.state.problem") == "") == compared


def test_positions_are_as_near_as_the_page_says(dropped):
    """The player reads what is packed here."""
    texts = {one["name"]: one["text"] for one in page_data(drop.page())["examples"]}
    dropped.run(f"drop.read({files_of(texts)})")
    clips = "document.getElementById('player').contentWindow.skpose?.clock.clips"
    dropped.wait_for(f"{clips}?.[0].label === 'walk'")
    shown, stated = dropped.run(
        f"(() => {{ const clip = {clips}[0];"
        " return [[0, 40, 89].map((frame) => clip.points(frame, 'world')), clip.error]; })()"
    )
    found = read(dropped, texts["walk.bvh"], scale=0.01)
    for points, frame in zip(shown, (0, 40, 89), strict=True):
        expected = np.vstack([np.zeros(3), found["joints"][frame]]) + found["root"][frame]
        off = 1e3 * np.linalg.norm(np.array(points) - expected, axis=1).max()
        assert 0.0 < off <= stated < 0.1


@pytest.mark.parametrize(
    "change",
    [
        lambda text: text.replace("JOINT c", "JOINT a"),
        lambda text: text.replace("JOINT c", "JOINT c  of b "),
        lambda text: text.replace("JOINT b", "JOINT c_end"),
        lambda text: text.replace("Frames: 2\nFrame Time: 0.04", "Frame Time: 0.04\nFrames: 2"),
        lambda text: text.replace("End Site", "END SITE").replace("JOINT", "joint").replace("Zrotation", "ZROTATION"),
        lambda text: text.replace("End Site", "End Site tip"),
        lambda text: text.replace("End Site", "End Site x-joint"),
        lambda text: text.replace("End Site", "End\nSite"),
        lambda text: text.replace("End Site", "End"),
        lambda text: text.replace("JOINT c", "JOINT c\u2028of\u2029b"),
        lambda text: text.replace("JOINT c", "JOINT c\x85"),
        lambda text: text.replace("JOINT c", "JOINT \ufeffc\ufeff"),
        lambda text: text.replace("JOINT c", "JOINT \x1f\u3000c\x1c"),
        lambda text: text.replace("JOINT c", "JOINT MOTION"),
        lambda text: text.replace("Frames: 2\nFrame Time: 0.04\n", "Frames 2 Frame\nTime:0.04 "),
    ],
)
def test_names_and_heads_are_read_as_by_the_library(dropped, change, tmp_path):
    (tmp_path / "arm.bvh").write_text(change(ARM), encoding="utf-8")
    assert_reads_as_the_library(dropped, tmp_path / "arm.bvh")


def test_a_problem_leaves_what_was_shown(dropped):
    before = dropped.run("document.getElementById('state').textContent")
    dropped.run("drop.read([new File(['HIERARCHY'], 'cut.bvh')])")
    failure = "document.getElementById('failure').textContent"
    assert dropped.run(failure) == "cut.bvh: it has no MOTION: is it cut short?."
    before_c, after = ARM.split("JOINT c")
    moved = f"{before_c}JOINT c{after.replace('CHANNELS 3', 'CHANNELS 6 Xposition Yposition Zposition')}"
    moved = moved.replace("30  40", "30  20 0 0 40", 1).replace("30  40", "30  25 0 0 40", 1)
    dropped.run(f"drop.read({files_of({'moved.bvh': moved})})")
    assert dropped.run(failure).startswith("moved: c moves by position channels")
    assert dropped.run("document.getElementById('state').textContent") == before
    assert dropped.run("drop.state.files.length === drop.state.motions.length")


def test_what_is_not_expected_is_stated(dropped):
    before = dropped.run("document.getElementById('state').textContent")
    failure = "document.getElementById('failure').textContent"
    dropped.run("drop.read([{name: 'odd.bvh', text: async () => null.length}])")
    assert dropped.run(failure).startswith("odd.bvh: cannot be read: ")
    dropped.run("drop.state.files = [{label: 'odd', content: null}]")
    dropped.run("document.getElementById('unit').dispatchEvent(new Event('change'))")
    dropped.wait_for(f"{failure}.startsWith('odd: cannot be read: ')")
    assert dropped.run("document.getElementById('state').textContent") == before


def test_nothing_leaves_the_page(dropped):
    assert [address for address in dropped.requests() if not address.startswith(("file:", "data:", "blob:"))] == []
    assert dropped.errors() == []
    refused = dropped.run("fetch('https://example.org').then(() => 'sent', () => 'refused')")
    assert refused == "refused"


def test_the_curve_is_there_in_a_page_of_the_site(window, tmp_path):
    """The frame of a page of the site keeps the page apart, but for what this one needs."""
    (tmp_path / "site.html").write_text(f"<h1>Try your files</h1>{live_pages.html_of('drop')}", encoding="utf-8")
    window.open((tmp_path / "site.html").as_uri())
    words = "document.querySelector('iframe').contentDocument?.getElementById('words')?.textContent ?? ''"
    window.wait_for(f"({words}).includes('m away, the nearest one, at')")
    assert window.errors() == []
