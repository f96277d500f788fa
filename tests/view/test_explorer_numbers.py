"""The scripts that compute poses and distances in a page: each number is compared with the library's own."""

import numpy as np
import pytest
from conftest import MIXED, random_tree, whole_turns
from numbers_page import TREES, Numbers, poses_of
from scipy.spatial.transform import Rotation

from skpose import Bone, Skeleton, forward_kinematics, pose_distances
from skpose.metrics import Spatial
from skpose.skeleton._interpolation import straight_line
from skpose.skeleton._rotations import nearest_vectors
from skpose.view._skeleton import skeleton_data

pytestmark = pytest.mark.slow

TWO_PI = 2 * np.pi
FOUR = "angle", "position", "rotation", "spatial"


@pytest.fixture(scope="module")
def numbers(browser):
    return Numbers(browser)


@pytest.fixture(params=[*TREES, "CMU"])
def tree(request):
    return request.getfixturevalue("cmu").skeleton if request.param == "CMU" else TREES[request.param]


def assert_distances_agree(numbers, skeleton, X, Y, n_steps=10, rtol=1e-9, atol=0.0):
    """Compare the four distances of pairs of poses with the library's."""
    found = numbers.distances(skeleton, X, Y, n_steps)
    for metric in FOUR:
        measured = Spatial(n_steps) if metric == "spatial" else metric
        expected = pose_distances(X, Y, skeleton=skeleton, metric=measured).diagonal()
        np.testing.assert_allclose([one[metric] for one in found], expected, rtol=rtol, atol=atol, err_msg=metric)


# --- poses ------------------------------------------------------------------------------------------------------------


def test_positions_are_those_of_forward_kinematics(numbers, tree):
    X = poses_of(tree, 6, extent=7.0)
    found = np.reshape(numbers.positions(tree, X), (6, -1, 3))
    np.testing.assert_allclose(found, forward_kinematics(X, tree), rtol=0, atol=1e-12)


def test_orientations_turn_the_bones(numbers, tree):
    X = poses_of(tree, 4)
    q = np.reshape(numbers.orientations(tree, X), (4, -1, 4))
    F = np.concatenate([forward_kinematics(X, tree), np.zeros((4, 1, 3))], axis=1)  # the root is joint −1
    for j, bone in enumerate(tree.bones):
        frame = j if tree.offset_frame == "own" else tree.parents[j]
        turned = np.tile(bone.offset, (4, 1))
        if frame >= 0:
            turned = Rotation.from_quat(q[:, frame][:, [1, 2, 3, 0]]).apply(turned)
        np.testing.assert_allclose(turned, F[:, j] - F[:, tree.parents[j]], atol=1e-12)


def test_poses_between_are_those_of_the_straight_line(numbers, tree):
    a, b = poses_of(tree, 2, seed=1, extent=7.0)
    found = numbers.between(tree, [a, b], np.linspace(0, 1, 8))
    np.testing.assert_allclose(found, straight_line(tree.bones, a, b, 8, TWO_PI), rtol=0, atol=1e-12)
    assert found[0] == a.tolist()


# --- distances --------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("n_steps", [1, 2, 10])
def test_distances_are_those_of_the_library(numbers, tree, n_steps):
    assert_distances_agree(numbers, tree, poses_of(tree, 5, seed=2), poses_of(tree, 5, seed=3), n_steps)


def test_small_distances_are_as_exact(numbers, tree):
    X = poses_of(tree, 3, seed=4)
    assert_distances_agree(numbers, tree, X, X + 1e-5 * poses_of(tree, 3, seed=5), rtol=1e-8)


def test_a_pose_has_no_distance_from_itself(numbers, tree):
    X = poses_of(tree, 3, extent=9.0)
    assert numbers.distances(tree, X, X, 10) == [dict.fromkeys(FOUR, 0)] * 3


def test_whole_turns_change_only_angles(numbers, tree):
    X, Y = poses_of(tree, 4, seed=6), poses_of(tree, 4, seed=7)
    turns = whole_turns(Y, tree, np.random.default_rng(0).integers(-3, 4, Y.shape))
    assert np.abs(turns).max() > 6
    expected, found = numbers.distances(tree, X, Y, 10), numbers.distances(tree, X, Y + turns, 10)
    for metric in FOUR[1:]:
        np.testing.assert_allclose([one[metric] for one in found], [one[metric] for one in expected], rtol=1e-9)
    np.testing.assert_allclose([one["angle"] for one in found], np.linalg.norm(Y + turns - X, axis=1), rtol=1e-12)


def test_weights_count(numbers):
    tree = random_tree(12, kinds=MIXED)
    X, Y = poses_of(tree, 3), poses_of(tree, 3, seed=1)
    unlike = tree.with_weights(np.linspace(0.0, 2.0, tree.n_joints))
    assert_distances_agree(numbers, unlike, X, Y)
    for one, other in zip(numbers.distances(tree, X, Y, 10), numbers.distances(unlike, X, Y, 10), strict=True):
        assert one["angle"] == other["angle"]
        assert all(abs(one[metric] - other[metric]) > 1e-3 for metric in FOUR[1:])


@pytest.mark.parametrize("offset_frame", ["own", "parent"])
def test_half_a_turn_has_the_direction_that_the_library_takes(numbers, offset_frame):
    """The direction matters: the length of the line depends on it."""
    rng = np.random.default_rng(3)
    rest = Rotation.from_rotvec([0.3, -0.7, 0.4]).as_matrix()
    bones = [
        Bone("upper", None, (0.4, 0.1, 0.0), "rotvec", rest),
        Bone("lower", "upper", (0.3, 0.0, 0.2), "rotvec", rest.T),
        Bone("hand", "lower", (0.2, 0.1, 0.1), "y", rest),
        Bone("finger", "hand", (0.2, 0.1, 0.1), "ZXY", rest),
        Bone("nail", "finger", (0.1, 0.3, 0.1)),
    ]
    tree = Skeleton(bones, offset_frame)
    X = rng.uniform(-2, 2, (24, tree.n_dofs))
    Y = X.copy()
    Y[:, 6:] += np.pi * rng.choice([-1, 1], (24, 4))
    for ball in (slice(0, 3), slice(3, 6)):
        axes = rng.normal(size=(24, 3))
        halves = Rotation.from_rotvec(np.pi * axes / np.linalg.norm(axes, axis=1)[:, None])
        Y[:, ball] = (Rotation.from_rotvec(X[:, ball]) * halves).as_rotvec()
    assert_distances_agree(numbers, tree, X, Y)
    assert_distances_agree(numbers, tree, Y, X)
    forth, back = numbers.distances(tree, X, Y, 10), numbers.distances(tree, Y, X, 10)
    np.testing.assert_allclose([d["spatial"] for d in forth], [d["spatial"] for d in back], rtol=1e-9)


def test_rounding_does_not_decide_the_direction_of_half_a_turn(numbers):
    """The first number of the code of a pose, by which its sign is chosen, is zero but for noise."""
    tree = Skeleton([Bone("upper", None, (0.4, 0.1, 0), "rotvec"), Bone("lower", "upper", (0.3, 0, 0.2), "rotvec")])
    rng, ends = np.random.default_rng(0), []
    for signs in skeleton_data(tree)["signs"]:
        before, after = (Rotation.from_quat(np.roll(q, -1)).inv() for q in signs)
        codes = Rotation.from_quat(rng.normal(size=(30, 4)) * [1, 1, 1, 1e-9])
        halves = Rotation.from_quat(rng.normal(size=(30, 4)) * [1, 1, 1, 0])
        ends.append([(before * q * after).as_rotvec() for q in (codes, codes * halves)])
    X, Y = np.concatenate(ends, axis=2)
    assert_distances_agree(numbers, tree, X, Y)
    assert_distances_agree(numbers, tree, Y, X)


def test_poses_without_rotation(numbers, tree):
    X = np.concatenate([np.zeros((1, tree.n_dofs)), poses_of(tree, 1)])
    found = np.reshape(numbers.positions(tree, X), (2, -1, 3))
    np.testing.assert_allclose(found, forward_kinematics(X, tree), rtol=0, atol=1e-12)
    assert_distances_agree(numbers, tree, X, X[::-1])


def test_rotation_vectors_of_a_line_do_not_jump(numbers):
    tree = Skeleton([Bone("hand", None, (1, 0, 0), "rotvec")])
    a, b = np.array([5.0, 0.2, 0.1]), np.array([-1.0, 0.1, 0.3])
    found = np.array(numbers.between(tree, [a, b], np.linspace(0, 1, 30)))[:-1]
    np.testing.assert_allclose(found, nearest_vectors(found, np.tile(a, (29, 1))), atol=1e-12)
    assert np.abs(np.diff(found, axis=0)).max() < 0.3


def test_a_line_through_no_rotation(numbers):
    """Half-way there is no rotation but for rounding, so that only the start says about which axis its turns are."""
    tree = Skeleton([Bone("hand", None, (1, 0, 0), "rotvec")])
    axis, parts = np.array([0.48, -0.6, 0.64]), np.linspace(0, 1, 9)[:-1]
    found = numbers.between(tree, [(TWO_PI + 0.5) * axis, -0.5 * axis], parts)
    np.testing.assert_allclose(found, np.outer(TWO_PI + 0.5 - parts, axis), atol=1e-12)


def test_twins_of_euler_angles_are_one_pose_and_two_lines(numbers):
    """DESIGN: (x, y, z) and (x + π, π − y, z + π) are one rotation, and the straight line between them is long."""
    arm = Skeleton([Bone("elbow", None, (0.3, 0, 0), "xyz"), Bone("wrist", "elbow", (0.25, 0, 0), "y")])
    a = np.array([0.4, 0.9, -0.3, 0.5])
    b = np.array([0.4 + np.pi, np.pi - 0.9, -0.3 + np.pi, 0.5])
    (found,) = numbers.distances(arm, [a], [b], 10)
    assert found["position"] < 1e-15
    assert found["rotation"] < 1e-7
    assert found["spatial"] > 0.5
    np.testing.assert_allclose(found["spatial"], pose_distances([a], [b], skeleton=arm)[0, 0], rtol=1e-9)


def test_pairs_of_walks(numbers, cmu):
    X, skeleton = np.concatenate([motion.angles for motion in cmu.motions[:6]])[::7], cmu.skeleton
    n = len(X) // 2
    assert_distances_agree(numbers, skeleton, X[:n], X[n : 2 * n])


def test_pairs_on_ball_joints(numbers, hdm05):
    balls = hdm05.to_rotvec()
    X = np.concatenate([motion.angles for motion in balls.motions[:20]])[::40]
    n = len(X) // 2
    assert_distances_agree(numbers, balls.skeleton, X[:n], X[n : 2 * n])
