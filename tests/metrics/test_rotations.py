"""Distances are those of rotations, for all numbers that the rotations can be written in."""

from itertools import permutations

import numpy as np
import pytest
import reference
from conftest import MIXED, random_tree
from scipy.spatial.transform import Rotation

from skpose import Bone, Motion, Skeleton, geodesic, pose_distances, poses_from_rotations, rotations_from_poses
from skpose.datasets import humanoid
from skpose.metrics import Spatial
from skpose.metrics._registry import METRICS

OF_ROTATIONS = [name for name in METRICS if name != "angle"]
ORDERS = [order for letters in permutations("xyz") for order in ("".join(letters), "".join(letters).upper())]


@pytest.fixture(scope="module")
def skeleton():
    return humanoid().to_rotvec()


@pytest.fixture(scope="module")
def X(skeleton):
    return np.random.default_rng(0).normal(scale=0.4, size=(6, skeleton.n_dofs))


def assert_same_distances(X, Y, skeleton):
    """To 1e-12; geodesics, which start from 36 bits, to 1e-9: iterations enlarge the difference of one bit."""
    for metric in OF_ROTATIONS:
        expected = pose_distances(X, skeleton=skeleton, metric=metric)
        rtol = 1e-9 if metric == "geodesic" else 0.0
        np.testing.assert_allclose(pose_distances(Y, skeleton=skeleton, metric=metric), expected, rtol, 1e-12)


def balls_of(skeleton):
    """The columns of each ball joint."""
    first = np.cumsum([0, *(bone.n_dofs for bone in skeleton.bones)])
    return [slice(i, i + 3) for i, bone in zip(first, skeleton.bones, strict=False) if bone.is_ball]


@pytest.mark.parametrize("order", ORDERS)
def test_every_order_of_euler_angles(order, skeleton, X):
    written = Motion(skeleton, X, frame_rate=12).to_euler(order)
    assert {bone.dofs for bone in written.skeleton.bones if bone.n_dofs == 3} == {order}
    assert_same_distances(X, written.to_rotvec().angles, skeleton)


@pytest.mark.parametrize("form", ["quaternion_wxyz", "quaternion_xyzw"])
def test_quaternions_of_either_sign(form, skeleton, X):
    quaternions = rotations_from_poses(X, skeleton, form=form)
    signs = np.random.default_rng(1).choice([-1.0, 1.0], quaternions.shape[:2])[..., None]
    assert_same_distances(X, poses_from_rotations(signs * quaternions, skeleton, form=form), skeleton)


def test_rotation_vectors_past_a_turn(skeleton, X):
    longer = X.copy()
    for ball in balls_of(skeleton):
        size = np.linalg.norm(X[:, ball], axis=1, keepdims=True)
        longer[:, ball] *= 1 + 2 * np.pi * np.array([[1], [-1], [2], [0], [-3], [1]]) / size
    assert_same_distances(X, longer, skeleton)


@pytest.mark.parametrize("turn", [np.pi, np.nextafter(np.pi, 4), np.nextafter(np.pi, 3), np.pi + 1e-9])
@pytest.mark.parametrize("axis", [(1, 0, 0), (0, -1, 0), (0, 0, 1), (0.6, 0, 0.8), (0, -0.8, 0.6)])
def test_half_a_turn_is_as_long_from_both_ends_and_in_both_directions(axis, turn):
    """At half a turn there are two slerps; other joints make them unlike."""
    skeleton = random_tree(4, n=5, kinds=["rotvec"])
    poses = np.random.default_rng(2).normal(size=(3, skeleton.n_dofs))
    poses[0, :3], poses[1, :3], poses[2] = 0.0, turn * np.array(axis), poses[1]
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
    expected = {
        "position": 2 * 0.7 * np.sin(angle / 2),
        "rotation": 0.7 * angle,
        "spatial": 10 * 2 * 0.7 * np.sin(angle / 20),
        "geodesic": 10 * 2 * 0.7 * np.sin(angle / 20),
    }
    for metric, length in expected.items():
        np.testing.assert_allclose(pose_distances(X, skeleton=skeleton, metric=metric)[0, 1], length, rtol=1e-10)


def test_one_rotation_in_other_numbers_is_one_pose():
    """Fact 6 of the design: the two triples of Euler angles of one rotation, which no wrapping makes equal."""
    skeleton = Skeleton([Bone("hand", None, (0.3, 0.2, 0.4), "xyz")])
    twins = np.array([[0.4, 0.9, -0.2], [0.4 + np.pi, np.pi - 0.9, -0.2 + np.pi]])
    assert pose_distances(twins, skeleton=skeleton, metric="spatial")[0, 1] > 1.0
    assert pose_distances(twins, skeleton=skeleton, metric="geodesic")[0, 1] < 1e-14
    found = geodesic(*twins, skeleton)
    assert found.converged
    np.testing.assert_allclose(found.path, np.tile(twins[0], (11, 1)), atol=1e-12)


@pytest.mark.parametrize("kinds", [MIXED, ["xyz", "ZXY", "y", "zx"]])
def test_a_geodesic_is_no_longer_than_either_line(kinds):
    skeleton = random_tree(5, n=6, kinds=kinds)
    X = np.random.default_rng(3).uniform(-3, 3, size=(8, skeleton.n_dofs))
    D = pose_distances(X, skeleton=skeleton, metric="geodesic")
    for i, a in enumerate(X):
        for j, b in enumerate(X[:i]):
            for line in (reference.line(a, b, 10, True, skeleton), reference.between([a, b], skeleton, 10)):
                assert D[i, j] <= reference.path_length(line, skeleton) * (1 + 1e-9)


@pytest.mark.parametrize("n_steps", [1, 2, 3, 10, 200])
def test_slerp_with_any_number_of_steps(n_steps):
    skeleton = random_tree(6, n=4, kinds=["rotvec"])
    X = np.random.default_rng(4).uniform(-3, 3, size=(12, skeleton.n_dofs))
    expected = reference.distances(X, X[:3], skeleton, "spatial", n_steps=n_steps)
    for dtype, tolerance in ((np.float64, 1e-12), (np.float32, 2e-5)):
        found = pose_distances(X.astype(dtype), X[:3].astype(dtype), skeleton=skeleton, metric=Spatial(n_steps))
        np.testing.assert_allclose(found, expected, rtol=tolerance, atol=10 * tolerance)
