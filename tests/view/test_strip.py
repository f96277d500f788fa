"""The picture of a motion in a notebook."""

import re
import xml.etree.ElementTree as ET

import numpy as np
import pytest
from conftest import SKELETONS

from skpose import Bone, Motion, Skeleton, forward_kinematics
from skpose.datasets import make_gait
from skpose.skeleton._sides import sides
from skpose.view._scene import scene_of
from skpose.view._shape import find_shape
from skpose.view._strip import _project

SVG = "{http://www.w3.org/2000/svg}"
COLOURS = {"left": "#0072b2", "right": "#d55e00", "": "#868d96"}


def outlines(motion):
    """The first corners (n, 2) of the outlines of all parts by colour, in half px."""
    found = {}
    for path in ET.fromstring(motion._repr_html_()).iter(f"{SVG}path"):
        corners = re.findall(r"m(-?\d+) ?(-?\d+)", path.get("d"))
        found.setdefault(path.get("fill"), []).extend([float(x), float(y)] for x, y in corners)
    return {colour: np.array(corners) for colour, corners in found.items() if corners}


@pytest.mark.parametrize("name", ["humanoid", "bvh", "mixed joints"])
def test_eight_poses_have_all_parts_in_the_colours_of_their_sides(name):
    skeleton = SKELETONS[name]
    motion = Motion(skeleton, np.random.default_rng(0).normal(size=(50, skeleton.n_dofs)), 25)
    found, side_of, parts = outlines(motion), sides(skeleton.joint_names), find_shape(skeleton).parts
    assert sum(map(len, found.values())) == 8 * sum(len(part.hulls) for part in parts)
    for side in ("left", "right"):
        n = sum(len(part.hulls) for part in parts if part.joint >= 0 and side_of[part.joint] == side)
        assert len(found.get(COLOURS[side], [])) == 8 * n
    texts = [text.text for text in ET.fromstring(motion._repr_html_()).iter(f"{SVG}text")]
    assert texts == [f"{time:.2f} s" for time in motion.times[np.rint(np.linspace(0, 49, 8)).astype(int)]]


def test_a_walk_is_seen_from_the_side():
    motion = make_gait(1, 1, random_state=0).motions[0]
    flat = _project(scene_of(motion), find_shape(motion.skeleton))
    width = np.ptp(forward_kinematics(motion.angles, motion.skeleton)[..., 0], axis=1).max()  # from arm to arm
    assert np.ptp(flat[..., 2], axis=1).max() == pytest.approx(width, abs=0.2)


@pytest.mark.parametrize("up", "yz")
def test_it_is_upright_and_goes_to_the_right(up):
    nose, head = np.roll([[0.0, 0.0, -0.3], [0.0, 1.0, 0.0]], "xyz".index(up) - 1, axis=1)
    path = np.linspace([0, 0, 0], 10 * nose, 5)
    skeleton = Skeleton([Bone("left_nose", None, tuple(nose), "z"), Bone("right_head", None, tuple(head), "z")])
    found = outlines(Motion(skeleton, np.zeros((5, 2)), 25, path, up=up))
    assert (found[COLOURS["left"]][:, 0] > found[COLOURS["right"]][:, 0] + 20).all()
    assert (found[COLOURS["left"]][:, 1] > found[COLOURS["right"]][:, 1] - 40).all()


@pytest.mark.parametrize("n_frames", [0, 1, 20_000])
def test_it_is_small_for_any_number_of_frames(n_frames):
    motion = Motion(SKELETONS["humanoid"], np.zeros((n_frames, SKELETONS["humanoid"].n_dofs)), 120)
    text = motion._repr_html_()
    assert len(text) < 20_000
    assert text.count("</text>") == min(n_frames, 8)
