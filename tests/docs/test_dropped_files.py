"""The page into which visitors drop files: what it reads, shows and measures is what the library does."""

import json
import re
import sys
import warnings
from pathlib import Path

import numpy as np
import pytest
from conftest import DATA
from rigs import NAMES, RIGS, file_of, person_of, random_segments

from skpose import Motion, pose_distances
from skpose.datasets import humanoid
from skpose.io import load_bvh, save_bvh
from skpose.skeleton._sides import sides
from skpose.view._scene import scene_of
from skpose.view._shape import find_shape

sys.path.insert(0, str(Path(__file__).parents[2] / "docs" / "_extensions"))
import drop
import live_pages

pytestmark = pytest.mark.slow

READ = """(() => {{
  try {{
    const motion = drop.motionOf(drop.readBvh({text}), 0.01);
    const {{ joints, root, headings, size, standing }} = drop.sceneOf(motion, {up});
    const {{ names, parents, sides, weights }} = motion.skeleton;
    const poses = motion.poses.map((pose) => [...pose]);
    const shape = drop.shapeOf(motion.skeleton);
    const {{ rate }} = motion;
    return {{ joints, root, headings, size, standing, names, parents, sides, weights, poses, shape, rate }};
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


@pytest.fixture
def dropped(browser):
    if not browser.run("Boolean(window.drop)"):  # a test before this one may have shown another page
        browser.show(drop.page().html)
        browser.wait_for("Boolean(window.drop && drop.state.values)")
    return browser


def assert_reads_as_the_library(dropped, path, up=None):
    """Compare skeleton, poses, places, and the shape of the figure; return whether it is a person."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        motion = load_bvh(path, scale=0.01, up=up)
    text, scene = path.read_text(encoding="utf-8"), scene_of(motion)
    found = dropped.run(READ.format(text=json.dumps(text), up=json.dumps(motion.up)))
    assert isinstance(found, dict), found
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
    shape = find_shape(motion.skeleton)
    expected = json.loads(json.dumps(shape.data()))
    assert found["shape"]["parts"] == expected["parts"]
    for ours, theirs in zip(found["shape"]["spheres"], expected["spheres"], strict=True):
        assert ours.keys() == theirs.keys()
        assert ours["at"] == theirs["at"]
        assert ours["radius"] == pytest.approx(theirs["radius"])
        assert ours.get("weights", []) == pytest.approx(theirs.get("weights", []), abs=1e-12)
        for shift in ("along", "across"):
            assert ours.get(shift, [0, 0, 0])[:2] == theirs.get(shift, [0, 0, 0])[:2]
            assert ours.get(shift, [0, 0, 0])[2] == pytest.approx(theirs.get(shift, [0, 0, 0])[2])
    return shape.is_person


@pytest.mark.parametrize("name", [path.name for path in sorted(DATA.glob("*.bvh"))])
def test_files_are_read_as_by_the_library(dropped, name):
    assert_reads_as_the_library(dropped, DATA / name)


@pytest.mark.parametrize("up", ["x", "y", "z"])
def test_a_reference_that_stands_still_is_not_the_root(dropped, up, tmp_path):
    (tmp_path / "reference.bvh").write_text(REFERENCE)
    assert_reads_as_the_library(dropped, tmp_path / "reference.bvh", up)


def test_written_files_are_read_again(dropped, tmp_path):
    rng, skeleton = np.random.default_rng(0), humanoid()
    X, path, turns = (rng.normal(size=(7, n)) for n in (skeleton.n_dofs, 3, 3))
    save_bvh(tmp_path / "written.bvh", Motion(skeleton, X, 25, path, turns, "ZXY"), scale=0.01)
    assert assert_reads_as_the_library(dropped, tmp_path / "written.bvh")


@pytest.mark.parametrize("name", NAMES)
def test_people_are_found_by_names_and_lengths_as_by_the_library(dropped, name, tmp_path):
    for twists in (False, True):
        skeleton = person_of(name, twists=twists)[0]
        motion = Motion(skeleton, np.zeros((2, skeleton.n_dofs)), 30)
        save_bvh(tmp_path / f"{twists}.bvh", motion, scale=0.01)
        assert assert_reads_as_the_library(dropped, tmp_path / f"{twists}.bvh", "y")


@pytest.mark.parametrize("name", RIGS)
def test_people_of_known_rigs_are_drawn_as_by_the_library(dropped, name, tmp_path):
    rig, segments = RIGS[name], random_segments(2)
    arm = next(row[0] for row in rig.arm if row[1] == "elbow")
    neck = next(row[0] for row in rig.neck if row[1] in ("neck", ""))
    changes = [{}, {"leave_out": [neck]}, {"stretch": {arm: 5.0}}, {"rename": lambda name: f"x:{name}.001"}]
    people = []
    for i, change in enumerate(changes):
        (tmp_path / f"{i}.bvh").write_text(file_of(rig, segments, **change)[0], encoding="utf-8")
        people.append(assert_reads_as_the_library(dropped, tmp_path / f"{i}.bvh", "y"))
    assert people[0]
    assert not people[2]


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (lambda text: text.partition("CHANNELS")[0], "cut short"),
        (lambda text: "a,b\n1,2\n", "HIERARCHY"),
        (lambda text: text.rsplit(None, 2)[0], "cut short"),
        (lambda text: re.sub(r"Frame Time:.*", "Frame Time: 0", text), "Frame Time"),
        (lambda text: text.replace("OFFSET", "OFSET", 1), "OFSET"),
        (lambda text: text.rsplit(None, 1)[0] + " nan\n", "numbers"),
        (lambda text: text.replace("Yrotation", "Zrotation"), "CHANNELS"),
    ],
)
def test_damaged_files_are_refused(dropped, change, words):
    text = change((DATA / "biped.bvh").read_text(encoding="utf-8"))
    assert words in dropped.run(READ.format(text=json.dumps(text), up='"y"'))


@pytest.mark.parametrize("metric", ["angle", "spatial"])
def test_the_curve_is_the_distance_to_each_frame(dropped, metric, tmp_path):
    again = "Object.assign(drop.state, { values: null, shown: -1 })"  # at once: the page looks every 40 ms
    dropped.run(f"document.getElementById('metric').value = '{metric}'; {again}; 0")
    dropped.wait_for("Boolean(drop.state.values) && drop.state.shown >= 0")
    frame, values = dropped.run("[drop.state.shown, [...drop.state.values]]")
    motions = []
    for one in json.loads(dropped.run("document.getElementById('data').textContent"))["examples"]:
        (tmp_path / one["name"]).write_text(one["text"])
        motions.append(load_bvh(tmp_path / one["name"], scale=0.01))
    walk, run = motions
    expected = pose_distances(walk.angles[[frame]], run.angles, skeleton=walk.skeleton, metric=metric)[0]
    np.testing.assert_allclose(values, expected, rtol=1e-9, atol=1e-9)


def test_nothing_leaves_the_page(dropped):
    assert [address for address in dropped.requests() if not address.startswith(("file:", "data:", "blob:"))] == []
    assert dropped.errors() == []
    assert dropped.run("fetch('https://example.org').then(() => 'sent', () => 'refused')") == "refused"


def test_the_curve_is_there_in_a_page_of_the_site(browser):
    browser.show(f"<h1>Try your files</h1>{live_pages.html_of('drop')}")
    words = "document.querySelector('iframe').contentDocument?.getElementById('words')?.textContent ?? ''"
    browser.wait_for(f"({words}).includes('m away, the nearest one, at')")
    assert browser.errors() == []
