"""Conversions of rotations and resampling, against scipy."""

import warnings

import numpy as np
import pytest
import reference
from conftest import MIXED, random_tree
from scipy.spatial.transform import Rotation, Slerp

from skpose import Bone, Motion, Skeleton
from skpose.skeleton import poses_from_rotations, rotations_from_poses

ORDERS = ["xyz", "ZXY", "yzx"]
FORMS = {
    "quaternion_wxyz": lambda r: r.as_quat()[..., [3, 0, 1, 2]],
    "quaternion_xyzw": lambda r: r.as_quat(),
    "matrix": lambda r: r.as_matrix(),
    "6d": lambda r: r.as_matrix()[..., :2].swapaxes(-1, -2).reshape(-1, 6),
    "rotvec": lambda r: r.as_rotvec(),
}


def joint(dofs, name="a", parent=None):
    return Bone(name, parent, (0.3, 0.2, 0.1), dofs)


def smooth(n_frames, seed=0, through_lock=False):
    """Smooth Euler triples; the middle angle passes 90° exactly, at the middle frame, if so chosen."""
    t = np.linspace(-1, 1, n_frames)[:, None]
    rng = np.random.default_rng(seed)
    angles = rng.uniform(-2, 2, 3) + np.sin(rng.uniform(1, 2, 3) * t + rng.uniform(0, 3, 3))
    if through_lock:
        angles[:, 1] = np.pi / 2 + 1.5 * t[:, 0]
    return angles


def with_jumps(angles, seed=0):
    """The same rotations, every triple at random one of those that it can be."""
    rng = np.random.default_rng(seed)
    other = rng.random((len(angles), 1)) < 0.5
    angles = np.where(other, angles * [1, -1, 1] + np.pi, angles)
    return angles + 2 * np.pi * rng.integers(-2, 3, size=angles.shape)


def gap(a, b):
    """The largest angle between rotations, rad."""
    return (a.inv() * b).magnitude().max()


def test_skeleton_to_rotvec_and_back():
    limits = [(-1, 1)] * 3
    bones = [Bone("a", None, (1, 0, 0), "ZXY", limits=limits), joint("xz", "b", "a"), joint("", "c", "a")]
    bones += [Bone("d", "c", (1, 0, 0), "y", limits=[(0, 2)]), joint("rotvec", "e", "d")]
    skeleton = Skeleton(bones, "parent")
    balls = skeleton.to_rotvec()
    assert [bone.dofs for bone in balls.bones] == ["rotvec", "rotvec", "", "y", "rotvec"]
    assert [bone.limits for bone in balls.bones] == [None, None, None, ((0, 2),), None]
    assert (balls.offset_frame, balls.joint_names) == ("parent", skeleton.joint_names)
    assert [bone.dofs for bone in balls.to_euler("YZX").bones] == ["YZX", "YZX", "", "y", "YZX"]
    assert [bone.dofs for bone in skeleton.to_euler("YZX").bones] == ["ZXY", "xz", "", "y", "YZX"]
    assert balls.to_rotvec() == balls


@pytest.mark.parametrize("offset_frame", ["own", "parent"])
@pytest.mark.parametrize("order", ORDERS)
def test_converted_motions_keep_all_positions(order, offset_frame):
    skeleton = random_tree(5, kinds=MIXED, offset_frame=offset_frame)
    angles = np.random.default_rng(0).uniform(-4, 4, (40, skeleton.n_dofs))
    motion = Motion(skeleton, angles, 30, np.ones((40, 3)), np.ones((40, 1)), "z")
    expected = reference.forward_kinematics(angles, skeleton)
    balls = motion.to_rotvec()
    for other in (balls, balls.to_euler(order), balls.to_euler(order).to_rotvec(), motion.to_euler(order)):
        positions = reference.forward_kinematics(other.angles, other.skeleton)
        np.testing.assert_allclose(positions, expected, rtol=0, atol=1e-12)
        np.testing.assert_array_equal(other.root_angles, motion.root_angles)
        assert (other.frame_rate, other.root_axes) == (30, "z")
    assert balls.skeleton == skeleton.to_rotvec()


@pytest.mark.parametrize("order", ORDERS)
def test_converted_angles_are_continuous_through_gimbal_lock(order):
    """Of 401 smooth frames the middle one is in gimbal lock; steps stay as small as in the triples that made them."""
    angles = smooth(401, through_lock=True)
    rotations = Rotation.from_euler(order, angles)
    assert np.abs(np.cos(angles[200, 1])) < 1e-15
    ball = Motion(Skeleton([joint("rotvec")]), rotations.as_rotvec(), 100)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        motion = ball.to_euler(order)
    assert gap(Rotation.from_euler(order, motion.angles), rotations) < 1e-13
    np.testing.assert_allclose(np.diff(motion.angles, axis=0), np.diff(angles, axis=0), atol=0.02)
    vectors = motion.to_rotvec().angles
    assert gap(Rotation.from_rotvec(vectors), rotations) < 1e-13
    assert np.abs(np.diff(vectors, axis=0)).max() < 0.05


@pytest.mark.filterwarnings("ignore:values of angles reach:UserWarning")
@pytest.mark.parametrize("order", ["xyz", "ZXY"])
def test_unwrapping_undoes_jumps_between_the_triples_of_one_rotation(order):
    angles = smooth(300)
    jumped = with_jumps(angles)
    jumped[0] = angles[0]
    zeros = np.zeros((300, 3))
    motion = Motion(Skeleton([joint(order)]), jumped, 10, zeros, jumped, order).unwrap()
    np.testing.assert_allclose(motion.angles, angles, atol=1e-12)
    np.testing.assert_allclose(motion.root_angles, angles, atol=1e-12)
    again = motion.unwrap()
    np.testing.assert_array_equal(again.angles, motion.angles)


@pytest.mark.filterwarnings("ignore:values of angles reach:UserWarning")
@pytest.mark.parametrize("order", ["xyz", "YXZ"])
def test_resampling_rotations_is_slerp_where_angles_jump(order):
    """Smooth rotations through gimbal lock, written with jumps; joint and root."""
    angles = smooth(61, 0, through_lock=True)
    rotations = Rotation.from_euler(order, angles)
    jumped = with_jumps(angles, 0)
    motion = Motion(Skeleton([joint(order)]), jumped, 30, np.zeros((61, 3)), jumped, order).resample(100)
    expected = Slerp(np.arange(61) / 30, rotations)(np.arange(len(motion)) / 100)
    assert gap(Rotation.from_euler(order, motion.angles), expected) < 1e-12
    assert gap(Rotation.from_euler(order, motion.root_angles), expected) < 1e-12
    linear = jumped[:-1] + 0.5 * np.diff(jumped, axis=0)  # what interpolation of the numbers would be
    assert gap(Rotation.from_euler(order, linear), Slerp(np.arange(61), rotations)(np.arange(60) + 0.5)) > 1


ARM = Skeleton(
    [joint("rotvec"), joint("", "b", "a"), joint("ZXY", "c", "b"), joint("yx", "d", "c"), joint("Z", "e", "a")]
)


def arm_poses(n_poses=50):
    X = np.random.default_rng(1).uniform(-1.2, 1.2, (n_poses, ARM.n_dofs))
    rotations = [
        Rotation.from_rotvec(X[:, :3]),
        Rotation.from_euler("ZXY", X[:, 3:6]),
        Rotation.from_euler("yx", X[:, 6:8]),
        Rotation.from_euler("Z", X[:, 8:]),
    ]
    return X, rotations


@pytest.mark.parametrize("form", FORMS)
def test_poses_to_and_from_every_form(form):
    X, rotations = arm_poses()
    numbers = rotations_from_poses(X, ARM, form=form)
    assert numbers.shape[:2] == (50, 4)
    for j, r in enumerate(rotations):
        if form in ("quaternion_xyzw", "quaternion_wxyz"):
            scalar = numbers[:, j, 3 if form == "quaternion_xyzw" else 0]
            assert (scalar >= 0).all()
            np.testing.assert_allclose(np.abs(numbers[:, j]), np.abs(FORMS[form](r)), atol=1e-14)
        else:
            np.testing.assert_allclose(numbers[:, j], FORMS[form](r), atol=1e-14)
    np.testing.assert_allclose(poses_from_rotations(numbers, ARM, form=form), X, atol=1e-12)
    if form.startswith("quaternion"):
        np.testing.assert_allclose(poses_from_rotations(-numbers, ARM, form=form), X, atol=1e-12)
        np.testing.assert_allclose(poses_from_rotations(1.0005 * numbers, ARM, form=form), X, atol=1e-12)
    assert poses_from_rotations(numbers[:0], ARM, form=form).shape == (0, 9)


BAD = {
    "quaternion_wxyz": ([2.0, 0, 0, 0], "must be a quaternion of length one"),
    "quaternion_xyzw": ([0.0, 0, 0, 0], "must be a quaternion of length one"),
    "matrix": (np.diag([1.0, 1, -1]), "must be a rotation matrix"),
    "6d": ([1.0, 2, 3, -2, -4, -6], "must be two columns of a rotation matrix"),
    "rotvec": ([0.0, np.inf, 0], "must be finite numbers"),
}


@pytest.mark.parametrize("form", BAD)
def test_error_for_a_bad_rotation_names_joint_and_pose(form):
    numbers = rotations_from_poses(arm_poses()[0], ARM, form=form)
    bad, message = BAD[form]
    for value, expected in [(bad, message), (np.full(np.shape(bad), np.nan), "must be finite numbers")]:
        numbers[7, 1] = value
        with pytest.raises(ValueError, match=r"rotations\[7, 1\], of joint 'c', " + expected):
            poses_from_rotations(numbers, ARM, form=form)
