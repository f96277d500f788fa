"""The picture of a motion in a notebook."""

import re
import xml.etree.ElementTree as ET

import numpy as np
import pytest
from conftest import SKELETONS

from skpose import Bone, Motion, Skeleton, forward_kinematics
from skpose.datasets import make_gait
from skpose.kinematics._shared import find_shape
from skpose.view._scene import scene_of
from skpose.view._strip import _project

SVG = "{http://www.w3.org/2000/svg}"


def drawn(motion):
    """Return the lines (n_lines, 2, 2) by colour, and the texts."""
    root = ET.fromstring(motion._repr_html_())
    lines = {}
    for path in root.iter(f"{SVG}path"):
        numbers = np.array(re.findall(r"-?\d+", path.get("d")), dtype=float).reshape(-1, 2, 2)
        lines.setdefault(path.get("stroke"), []).append(numbers)
    return {colour: np.concatenate(found) for colour, found in lines.items()}, [t.text for t in root.iter(f"{SVG}text")]


def areas(motion):
    """Return the numbers of hulls by colour, of people."""
    root = ET.fromstring(motion._repr_html_())
    found = {}
    for path in root.iter(f"{SVG}path"):
        if path.get("fill") != "none" and path.get("d").endswith("z"):
            found[path.get("fill")] = found.get(path.get("fill"), 0) + path.get("d").count("z")
    return found


@pytest.mark.parametrize("name", [name for name in SKELETONS if name != "humanoid"])
def test_each_of_eight_poses_has_all_bones(name):
    skeleton = SKELETONS[name]
    motion = Motion(skeleton, np.random.default_rng(0).normal(size=(50, skeleton.n_dofs)), 25)
    lines, texts = drawn(motion)
    assert sum(map(len, lines.values())) == 8 * skeleton.n_joints
    assert texts == [f"{time:.2f} s" for time in motion.times[np.rint(np.linspace(0, 49, 8)).astype(int)]]


def test_people_have_parts_in_the_colours_of_their_sides():
    motion = make_gait(1, 1, random_state=0).motions[0]
    names, found = motion.skeleton.joint_names, areas(motion)
    for side, colour in (("left", "#0072b2"), ("right", "#d55e00")):
        parts = [part for part in find_shape(motion.skeleton).parts if names[part.joint].startswith(side)]
        assert found[colour] == 8 * sum(len(part.hulls) for part in parts)
    assert found["#868d96"] > 0


def test_a_walk_is_seen_from_the_side():
    """Feet are apart by a step in some pose, and shoulders nearly one behind the other."""
    motion = make_gait(1, 1, random_state=0).motions[0]
    flat = _project(scene_of(motion), find_shape(motion.skeleton))
    joints = forward_kinematics(motion.angles, motion.skeleton)
    width = np.ptp(joints[..., 0], axis=1).max()  # from arm to arm
    assert np.ptp(flat[..., 2], axis=1).max() == pytest.approx(width, abs=0.2)


def test_proportions_are_kept_and_it_is_seen_from_its_widest_side():
    """An arm of 2 m along the depth z and a neck of 1 m: a line of twice the length to the side."""
    skeleton = Skeleton([Bone("arm", None, (0, 0, 2), "z"), Bone("neck", None, (0, 1, 0), "z")])
    lines, _ = drawn(Motion(skeleton, np.zeros((1, 2)), 25))
    arm, neck = lines["currentColor"]
    assert abs(arm[0, 0] - arm[1, 0]) == pytest.approx(2 * abs(neck[0, 1] - neck[1, 1]), abs=2)
    assert arm[0, 1] == arm[1, 1]  # level
    assert neck[0, 1] < neck[1, 1]  # up, towards smaller y


def test_up_is_the_axis_of_the_motion():
    skeleton = Skeleton([Bone("neck", None, (0, 0, 1), "z"), Bone("arm", None, (0.2, 0, 0), "z")])
    lines, _ = drawn(Motion(skeleton, np.zeros((1, 2)), 25, up="z"))
    neck = lines["currentColor"][0]
    assert neck[0, 0] == neck[1, 0]
    assert neck[0, 1] < neck[1, 1]


def test_who_walks_goes_to_the_right():
    for sign in (1, -1):
        skeleton = Skeleton([Bone("nose", None, (0, 0, 0.3 * sign), "z"), Bone("head", None, (0, 1, 0), "z")])
        walk = Motion(skeleton, np.zeros((5, 2)), 25, np.linspace([0, 0, 0], [0, 0, 4 * sign], 5))
        lines, _ = drawn(walk)
        nose = lines["currentColor"][0]
        assert nose[0, 0] > nose[1, 0]


@pytest.mark.parametrize("n_frames", [0, 1, 2, 7, 20_000])
def test_it_is_small_for_any_number_of_frames(n_frames):
    motion = Motion(SKELETONS["humanoid"], np.zeros((n_frames, SKELETONS["humanoid"].n_dofs)), 120)
    text = motion._repr_html_()
    assert len(text) < 15_000
    assert "Motion(" in text
    if n_frames:
        assert text.count("</text>") == min(n_frames, 8)


def test_bones_without_length_are_drawn():
    skeleton = Skeleton([Bone("a", None, (0, 0, 0), "z"), Bone("b", "a", (0, 0, 0), "z")])
    lines, _ = drawn(Motion(skeleton, np.zeros((3, 2)), 25))
    assert sum(map(len, lines.values())) == 6
