"""Joints of robots: hinges about any axis, and slides, in what is computed of poses."""

import numpy as np
import pytest
import reference
from conftest import random_tree, weighted
from scipy.spatial.transform import Rotation

from skpose import Bone, Motion, Skeleton, forward_kinematics, geodesic, inverse_kinematics, pose_distances
from skpose.kinematics import metric_tensor, position_jacobian
from skpose.metrics import Spatial

KINDS = ("hinge", "slide", "rotvec", "hinge", "", "slide", "zy", "hinge", "ZXY", "slide", "x", "hinge")
TREES = {
    "hinges after ball joints": random_tree(7, kinds=("rotvec", "hinge", "hinge"), offset_frame="parent"),
    "all, parent": random_tree(10, kinds=KINDS, offset_frame="parent"),
    "all, weights": weighted(random_tree(11, kinds=KINDS, offset_frame="parent"), 0),
}


def robot(seed=0, n=24):
    """A branching robot as files have them: most axes along coordinates, either way, some frames tilted."""
    rng = np.random.default_rng(seed)
    bones = []
    for i in range(n):
        parent = None if i == 0 else f"link{i - 1}" if rng.random() < 0.8 else f"link{rng.integers(i)}"
        tilted = Rotation.from_euler("xyz"[rng.integers(3)], rng.choice([0, 0, 10, 90, 180]), degrees=True)
        offset = rng.choice([0.0, 0.1, -0.2], size=3)
        axis = rng.choice([1, -1]) * np.eye(3)[rng.integers(3)] if rng.random() < 0.8 else rng.normal(size=3)
        kind = "slide" if i % 11 == 7 else "hinge"
        bones.append(Bone(f"link{i}", parent, offset, kind, tilted.as_matrix(), axis=axis, dof_name=f"joint{i}"))
    return Skeleton(bones, "parent")


TREES |= {f"robot {i}": robot(i) for i in range(1)}


@pytest.fixture(params=TREES)
def tree(request):
    return TREES[request.param]


@pytest.fixture
def X(tree):
    X = np.random.default_rng(0).uniform(-3, 3, size=(17, tree.n_dofs))
    X[7] = X[2]
    return X


def test_positions_agree_with_the_reference(tree, X):
    expected = reference.forward_kinematics(X, tree)
    np.testing.assert_allclose(forward_kinematics(X, tree), expected, atol=1e-13 * np.abs(expected).max())


def test_jacobian_agrees_with_central_differences(tree, X):
    h, numeric = 1e-5, np.empty((len(X), 3 * tree.n_joints, tree.n_dofs))
    for d in range(tree.n_dofs):
        ahead, behind = (reference.forward_kinematics(X + h * s * np.eye(tree.n_dofs)[d], tree) for s in (1, -1))
        numeric[:, :, d] = ((ahead - behind) / (2 * h)).reshape(len(X), -1)
    np.testing.assert_allclose(position_jacobian(X, tree), numeric, atol=1e-7)
    scaled = np.repeat(np.sqrt(tree.weights), 3)[:, None] * numeric
    np.testing.assert_allclose(metric_tensor(X, tree), scaled.transpose(0, 2, 1) @ scaled, atol=1e-5)


@pytest.mark.parametrize("metric", ["position", "rotation", "spatial"])
def test_distances_agree_with_the_reference(tree, X, metric):
    expected = reference.distances(X, X[:5], tree, metric, wrap=True)
    found = pose_distances(X, X[:5], skeleton=tree, metric=metric)
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-13 * expected.max())
    single = pose_distances(X.astype(np.float32), X[:5].astype(np.float32), skeleton=tree, metric=metric)
    np.testing.assert_allclose(single, expected, rtol=0, atol=2e-6 * expected.max())


def test_differences_of_slides_are_not_wrapped():
    rail = Skeleton([Bone("cart", None, (0, 0, 1), "slide", axis=(2, 0, 0)), Bone("arm", "cart", (0, 1, 0), "x")])
    assert rail.dof_names == ("cart_slide", "arm_rx")
    a, b = [[-4.0, 0.0]], [[4.0, 0.0]]
    for metric, factor in (("spatial", 1), (Spatial(wrap=False), 1), ("geodesic", 1), ("position", 1)):
        assert pose_distances(a, b, skeleton=rail, metric=metric)[0, 0] == pytest.approx(8 * np.sqrt(2) * factor)
    assert pose_distances(a, b, skeleton=rail, metric="rotation")[0, 0] == 0.0
    found = geodesic(a[0], b[0], rail)
    assert found.length == pytest.approx(8 * np.sqrt(2))
    assert found.path[-1] == pytest.approx(b[0])


def test_inverse_kinematics_finds_the_positions(tree):
    rng = np.random.default_rng(3)
    X = np.cumsum(rng.normal(scale=0.02, size=(20, tree.n_dofs)), axis=0)
    positions = reference.forward_kinematics(X, tree)
    fitted = inverse_kinematics(positions, tree, initial=X[0])
    assert np.nanmax(fitted.residuals) < 1e-5
    again = reference.forward_kinematics(fitted.poses, tree)
    turned = Rotation.from_rotvec(fitted.root_rotations)
    for j in range(tree.n_joints):
        np.testing.assert_allclose(turned.apply(again[:, j]) + fitted.root_positions, positions[:, j], atol=2e-5)


def test_slides_keep_their_limits():
    lift = Bone("lift", None, (0, 0, 1), "slide", limits=((0.0, 0.4),), axis=(0, 0, 1))
    arm = Bone("arm", "lift", (1, 0, 0), "hinge", axis=(0, 1, 0))
    base = Skeleton([Bone("a", None, (1.0, 0, 0)), Bone("b", None, (0, 1.0, 0)), lift, arm])
    positions = reference.forward_kinematics([[0.9, 0.1]], base)
    fitted = inverse_kinematics(positions, base, joint_limits="enforce", weights=[9, 9, 1, 1])
    assert fitted.poses[0, 0] == 0.4
    free = inverse_kinematics(positions, base)
    assert free.poses[0, 0] == pytest.approx(0.9, abs=1e-6)
    path = geodesic([0.0, 0.0], [0.4, 2.0], base, joint_limits="enforce").path
    assert path[:, 0].min() >= 0.0
    assert path[:, 0].max() <= 0.4


@pytest.mark.parametrize(("axis", "frame"), [("x", "own"), ("y", "parent"), ("z", "own")])
def test_a_hinge_along_an_axis_is_that_axis(axis, frame):
    directions = np.eye(3)["xyz".index(axis)]
    rest = Rotation.from_euler("xyz", [0.3, 0.2, -0.5]).as_matrix()

    def arm(**dofs):
        return Skeleton(
            [Bone("a", None, (1, 2, 3), "zyx"), Bone("b", "a", (3, -1, 2), rest_rotation=rest, **dofs)], frame
        )

    X = np.random.default_rng(0).normal(size=(6, 4))
    for metric in ("position", "rotation", "spatial"):
        letters, hinge, against = (
            pose_distances(Y, skeleton=arm(**dofs), metric=metric)
            for Y, dofs in (
                (X, {"dofs": axis}),
                (X, {"dofs": "hinge", "axis": 3 * directions}),
                (X * [1, 1, 1, -1], {"dofs": "hinge", "axis": -directions}),
            )
        )
        np.testing.assert_allclose(hinge, letters, rtol=1e-6, atol=1e-7)
        np.testing.assert_allclose(against, letters, rtol=1e-6, atol=1e-7)


LIFT = Skeleton(
    [
        Bone("left_lift", None, (0, 1, 0), "slide", axis=(1, 2, 2)),
        Bone("left_arm", "left_lift", (0, 0.5, 0), "hinge", axis=(0, 1, 1)),
        Bone("right_lift", None, (0, -1, 0), "slide", axis=(1, -2, 2)),
        Bone("right_arm", "right_lift", (0, -0.5, 0), "hinge", axis=(0, 1, -1)),
    ],
    "parent",
)


def moved(poses):
    return Motion(LIFT, poses, 10.0, up="z")


def test_mirrored_slides_are_mirror_images():
    poses = np.random.default_rng(0).uniform(-1, 1, size=(5, 4))
    mirrored = moved(poses).mirrored(axis="y")
    expected = reference.forward_kinematics(poses, LIFT)[:, [2, 3, 0, 1]] * [1, -1, 1]
    np.testing.assert_allclose(reference.forward_kinematics(mirrored.angles, LIFT), expected, atol=1e-12)
    again = mirrored.mirrored(axis="y")
    np.testing.assert_allclose(again.angles, poses, atol=1e-12)
