"""Distances depend on rotations, not on the numbers in which the rotations are written."""

import numpy as np
import pytest
import reference
from conftest import MIXED, random_tree
from scipy.spatial.transform import Rotation

from skpose import Bone, Motion, Skeleton, geodesic, pose_distances
from skpose.datasets import humanoid
from skpose.metrics import Spatial
from skpose.metrics._registry import METRICS
from skpose.skeleton import poses_from_rotations, rotations_from_poses

OF_ROTATIONS = [name for name in METRICS if name != "angle"]


@pytest.fixture(scope="module")
def skeleton():
    return humanoid().to_rotvec()


@pytest.fixture(scope="module")
def X(skeleton):
    return np.random.default_rng(0).normal(scale=0.4, size=(6, skeleton.n_dofs))


@pytest.fixture(scope="module")
def expected(X, skeleton):
    return {metric: pose_distances(X, skeleton=skeleton, metric=metric) for metric in OF_ROTATIONS}


def assert_distances(Y, skeleton, expected):
    """To 1e-12; geodesics, whose iterations enlarge the difference of one bit, to 1e-9."""
    for metric in OF_ROTATIONS:
        rtol = 1e-9 if metric == "geodesic" else 0.0
        np.testing.assert_allclose(pose_distances(Y, skeleton=skeleton, metric=metric), expected[metric], rtol, 1e-12)


@pytest.mark.parametrize("order", ["xyz", "ZXY"])
def test_the_order_of_euler_angles(order, skeleton, X, expected):
    written = Motion(skeleton, X, frame_rate=12).to_euler(order)
    assert {bone.dofs for bone in written.skeleton.bones if bone.n_dofs == 3} == {order}
    assert_distances(written.to_rotvec().angles, skeleton, expected)


def test_the_sign_of_quaternions(skeleton, X, expected):
    form = "quaternion_wxyz"
    quaternions = rotations_from_poses(X, skeleton, form=form)
    signs = np.random.default_rng(1).choice([-1.0, 1.0], quaternions.shape[:2])[..., None]
    assert_distances(poses_from_rotations(signs * quaternions, skeleton, form=form), skeleton, expected)


def test_rotation_vectors_past_a_turn(skeleton, X, expected):
    longer, first = X.copy(), np.cumsum([0, *(bone.n_dofs for bone in skeleton.bones)])
    for i, bone in zip(first, skeleton.bones, strict=False):
        if bone.is_ball:
            size = np.linalg.norm(X[:, i : i + 3], axis=1, keepdims=True)
            longer[:, i : i + 3] *= 1 + 2 * np.pi * np.array([[1], [-1], [2], [0], [-3], [1]]) / size
    assert_distances(longer, skeleton, expected)


@pytest.mark.parametrize("turn", [np.pi, np.nextafter(np.pi, 4), np.pi + 1e-9])
def test_half_a_turn_is_as_long_from_both_ends_and_in_both_directions(turn):
    skeleton = random_tree(4, n=5, kinds=["rotvec"])
    poses = np.random.default_rng(2).normal(size=(3, skeleton.n_dofs))
    poses[0, :3], poses[1, :3], poses[2] = 0.0, turn * np.array([0.6, 0, 0.8]), poses[1]
    poses[2, :3] *= -1  # the same rotation
    for metric in ("spatial", "geodesic"):
        D = pose_distances(poses, poses.copy(), skeleton=skeleton, metric=metric)
        np.testing.assert_allclose(D[0, 1], D[1, 0], rtol=1e-12)
        np.testing.assert_allclose(D[0, 2], D[0, 1], rtol=1e-7)
        np.testing.assert_allclose(D[1, 2], 0.0, atol=1e-7)


def test_one_ball_joint_follows_its_arc():
    skeleton, angle = Skeleton([Bone("hand", None, (0, 0, 0.7), "rotvec")]), 2.5
    start = Rotation.from_rotvec([0.3, -1.1, 0.4])
    across = np.array([0.6, 0.8, 0.0])  # to the bone: the hand moves along a great circle
    X = np.array([start.as_rotvec(), (start * Rotation.from_rotvec(angle * across)).as_rotvec()])
    lengths = {"position": 2 * 0.7 * np.sin(angle / 2), "rotation": 0.7 * angle}
    lengths["spatial"] = lengths["geodesic"] = 10 * 2 * 0.7 * np.sin(angle / 20)
    for metric, length in lengths.items():
        np.testing.assert_allclose(pose_distances(X, skeleton=skeleton, metric=metric)[0, 1], length, rtol=1e-10)


def test_one_rotation_in_two_triples_of_euler_angles_is_one_pose():
    skeleton = Skeleton([Bone("hand", None, (0.3, 0.2, 0.4), "xyz")])
    twins = np.array([[0.4, 0.9, -0.2], [0.4 + np.pi, np.pi - 0.9, -0.2 + np.pi]])
    assert pose_distances(twins, skeleton=skeleton, metric="spatial")[0, 1] > 1.0
    assert pose_distances(twins, skeleton=skeleton, metric="geodesic")[0, 1] < 1e-14
    np.testing.assert_allclose(geodesic(*twins, skeleton).path, np.tile(twins[0], (11, 1)), atol=1e-12)


def test_a_geodesic_is_no_longer_than_either_line():
    skeleton = random_tree(5, n=6, kinds=MIXED)
    X = np.random.default_rng(3).uniform(-3, 3, size=(6, skeleton.n_dofs))
    D = pose_distances(X, skeleton=skeleton, metric="geodesic")
    for i, a in enumerate(X):
        for j, b in enumerate(X[:i]):
            for line in (reference.line(a, b, 10, True, skeleton), reference.between([a, b], skeleton, 10)):
                assert D[i, j] <= reference.path_length(line, skeleton) * (1 + 1e-9)


@pytest.mark.parametrize("n_steps", [1, 3, 200])
def test_slerp_with_any_number_of_steps(n_steps):
    skeleton = random_tree(6, n=4, kinds=["rotvec"])
    X = np.random.default_rng(4).uniform(-3, 3, size=(12, skeleton.n_dofs))
    expected = reference.distances(X, X[:3], skeleton, "spatial", n_steps=n_steps)
    for dtype, tolerance in ((np.float64, 1e-12), (np.float32, 2e-5)):
        found = pose_distances(X.astype(dtype), X[:3].astype(dtype), skeleton=skeleton, metric=Spatial(n_steps))
        np.testing.assert_allclose(found, expected, rtol=tolerance, atol=10 * tolerance)
