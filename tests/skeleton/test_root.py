"""The orientation of the root as part of the poses."""

from dataclasses import replace

import numpy as np
import pytest
from conftest import MIXED, random_tree
from scipy.spatial.transform import Rotation

from skpose import Bone, Motion, Skeleton, forward_kinematics, pose_distances

UP = {"x": [1.0, 0, 0], "y": [0, 1.0, 0], "z": [0, 0, 1.0]}
TREES = {frame: random_tree(4, kinds=MIXED, offset_frame=frame) for frame in ("own", "parent")}


def random_motion(skeleton, seed=0, n=20, axes="ZXY"):
    rng = np.random.default_rng(seed)
    angles, root = rng.uniform(-3, 3, (n, skeleton.n_dofs)), rng.uniform(-3, 3, (n, len(axes)))
    return Motion(skeleton, angles, 30, rng.normal(size=(n, 3)), root, axes)


def orientations(motion):
    if not motion.root_axes:
        return Rotation.identity(len(motion))
    return Rotation.from_euler(motion.root_axes, motion.root_angles)


@pytest.mark.parametrize("frame", TREES)
@pytest.mark.parametrize(("part", "up"), [("whole", "y"), ("tilt", "y"), ("tilt", "z")])
def test_all_positions_are_rotated_by_the_joint_at_the_root(frame, part, up):
    motion = random_motion(TREES[frame])
    rooted = motion.with_root(part, up=up)
    assert rooted.skeleton.joint_names == ("root", *motion.skeleton.joint_names)
    np.testing.assert_array_equal(rooted.angles[:, 3:], motion.angles)
    R = Rotation.from_rotvec(rooted.angles[:, :3])
    before, after = (forward_kinematics(m.angles, m.skeleton) for m in (motion, rooted))
    np.testing.assert_array_equal(after[:, 0], 0.0)
    np.testing.assert_allclose(after[:, 1:], np.einsum("nab,njb->nja", R.as_matrix(), before), atol=1e-12)
    # Nothing is left out: the heading that the motion keeps, times the joint, is the orientation before.
    whole = orientations(rooted) * R
    np.testing.assert_allclose(whole.as_matrix(), orientations(motion).as_matrix(), atol=1e-12)
    np.testing.assert_array_equal(rooted.root_positions, motion.root_positions)
    if part == "whole":
        np.testing.assert_array_equal(rooted.root_angles, 0.0)


@pytest.mark.parametrize("up", UP)
def test_the_tilt_does_not_depend_on_the_heading_in_the_world(up):
    seed = 0
    motion = random_motion(TREES["own"], seed)
    heading = np.random.default_rng(seed).uniform(-9, 9, len(motion))
    moved = Rotation.from_rotvec(heading[:, None] * UP[up]) * orientations(motion)
    other = Motion(motion.skeleton, motion.angles, 30, root_angles=moved.as_euler("xyz"))
    a, b = (m.with_root("tilt", up=up) for m in (motion, other))
    np.testing.assert_allclose(a.angles, b.angles, atol=1e-9)
    np.testing.assert_allclose(a.angles[:, "xyz".index(up)], 0.0, atol=1e-12)  # about a horizontal axis
    assert np.linalg.norm(a.angles[:, :3], axis=1).max() <= np.pi
    assert (a.root_axes, a.up) == (up, up)
    gap = np.exp(1j * (b.root_angles[:, 0] - a.root_angles[:, 0] - heading))
    np.testing.assert_allclose(gap, 1.0, atol=1e-9)
    # The tilt shows which direction of the skeleton points up: nothing else.
    for m in (a, b):
        vertical = Rotation.from_rotvec(m.angles[:, :3]).inv().apply(UP[up])
        np.testing.assert_allclose(vertical, orientations(motion).inv().apply(UP[up]), atol=1e-9)
    c, d = (m.with_root("whole", up=up) for m in (motion, other))
    assert np.abs(c.angles - d.angles).max() > 0.1


@pytest.mark.parametrize(("part", "up"), [("whole", "y"), ("tilt", "y"), ("tilt", "z")])
@pytest.mark.parametrize("axes", ["ZXY", "zx", ""])
def test_without_root_is_the_inverse(part, up, axes):
    motion = random_motion(TREES["parent"], axes=axes)
    motion = replace(motion, up=up, root_name="Hips", frame_numbers=np.arange(len(motion)) * 2 + 5)
    there = motion.with_root(part).without_root()
    assert there.skeleton == motion.skeleton
    np.testing.assert_array_equal(there.angles, motion.angles)
    np.testing.assert_array_equal(there.root_positions, motion.root_positions)
    np.testing.assert_array_equal(there.frame_numbers, motion.frame_numbers)
    assert (there.up, there.root_name, there.frame_rate) == (up, "Hips", motion.frame_rate)
    np.testing.assert_allclose((orientations(there).inv() * orientations(motion)).magnitude(), 0.0, atol=1e-12)
    if len(axes) == 3 and part == "whole":
        assert there.root_axes == axes
    # And of poses that with_root did not make: the joint at the root may have become something else.
    rooted = motion.with_root(part).to_euler("ZXY")
    np.testing.assert_allclose(
        (orientations(rooted.without_root()).inv() * orientations(motion)).magnitude(), 0.0, atol=1e-9
    )


@pytest.mark.parametrize("turned", ["z up", "head down", "along x"])
def test_tilt_is_the_same_however_the_skeleton_stands_at_angle_zero(turned):
    """Leans to the side by 10 and 40°, of people headed anywhere, are as far apart as those of one that stands."""
    # The skeleton at angle zero relative to one that stands along y, and the axis of the world that points up.
    rest, up = {
        "z up": (Rotation.identity(), "z"),
        "head down": (Rotation.from_euler("x", 180, degrees=True), "y"),
        "along x": (Rotation.from_euler("z", -90, degrees=True), "y"),
    }[turned]
    offsets = {
        "spine": [0, 0.5, 0],
        "head": [0, 0.3, 0.02],
        "left_foot": [0.1, -0.9, 0.1],
        "right_foot": [-0.1, -0.9, 0.1],
    }
    world = Rotation.from_euler("x", 90, degrees=True) if up == "z" else Rotation.identity()

    def motion(rest, up, world):
        bones = [
            Bone(name, "spine" if name == "head" else None, rest.apply(offset), "rotvec")
            for name, offset in offsets.items()
        ]
        skeleton = Skeleton(bones)
        headings = Rotation.from_euler("y", [[0], [50], [170], [-100]], degrees=True)
        leans = Rotation.from_euler("z", [[10], [40], [10], [40]], degrees=True)
        root = world * headings * leans * rest.inv()
        return Motion(skeleton, np.zeros((4, 12)), 30, root_angles=root.as_euler("xyz"), up=up).with_root("tilt")

    usual, other = motion(Rotation.identity(), "y", Rotation.identity()), motion(rest, up, world)
    expected, found = (pose_distances(one.angles, skeleton=one.skeleton, metric="position") for one in (usual, other))
    assert expected[0, 2] == pytest.approx(0.0, abs=1e-9)
    np.testing.assert_allclose(found, expected, atol=1e-9)
    angle, other_angle = (
        (Rotation.from_rotvec(one.angles[0, :3]).inv() * Rotation.from_rotvec(one.angles[1, :3])).magnitude()
        for one in (usual, other)
    )
    assert np.degrees(angle) == pytest.approx(30.0)
    assert np.degrees(other_angle) == pytest.approx(30.0)
    assert rotations_of_root(other.without_root()) == pytest.approx(rotations_of_root(other), abs=1e-9)


def rotations_of_root(motion):
    """The world orientation of the skeleton in each frame, as matrices."""
    root = Rotation.from_euler(motion.root_axes, motion.root_angles).as_matrix()
    if "root_rotvec_x" in motion.skeleton.dof_names:
        root = root @ Rotation.from_rotvec(motion.angles[:, :3]).as_matrix()
    return root
