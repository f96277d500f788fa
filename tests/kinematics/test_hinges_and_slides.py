"""Joints of robots: hinges about any axis, and slides, in what is computed of poses."""

import warnings

import numpy as np
import pytest
import reference
from conftest import random_tree, weighted
from scipy.spatial.transform import Rotation
from sklearn.neighbors import NearestNeighbors

from skpose import (
    Bone,
    Motion,
    Skeleton,
    forward_kinematics,
    geodesic,
    inverse_kinematics,
    metric_tensor,
    pose_distances,
    position_jacobian,
)
from skpose.geodesics import frechet_mean, interpolate
from skpose.io import load_motion, save_bvh, save_npz
from skpose.kinematics import retarget
from skpose.kinematics._tree import tree_of
from skpose.metrics import Spatial
from skpose.neighbors import PoseKNeighborsTransformer
from skpose.skeleton._shared import straight_line
from skpose.statistics import PoseTangentPCA

KINDS = ("hinge", "slide", "rotvec", "hinge", "", "slide", "zy", "hinge", "ZXY", "slide", "x", "hinge")
TREES = {
    "hinges, own": random_tree(5, kinds=("hinge",)),
    "hinges, parent": random_tree(6, kinds=("hinge", "hinge", ""), offset_frame="parent"),
    "hinges after ball joints": random_tree(7, kinds=("rotvec", "hinge", "hinge"), offset_frame="parent"),
    "slides": random_tree(8, kinds=("slide",)),
    "all, own": random_tree(9, kinds=KINDS),
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


TREES |= {f"robot {i}": robot(i) for i in range(3)}


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


def test_angle_refuses_columns_of_two_units():
    with pytest.raises(
        ValueError,
        match='"angle" needs columns in rad',
    ):
        pose_distances(np.zeros((2, 12)), skeleton=TREES["slides"], metric="angle")


def test_nearest_neighbours_are_those_of_all_distances(tree):
    rng = np.random.default_rng(1)
    X, Q = rng.uniform(-2, 2, size=(300, tree.n_dofs)), rng.uniform(-2, 2, size=(5, tree.n_dofs))
    D = pose_distances(Q, X, skeleton=tree, metric="spatial")
    expected, _ = NearestNeighbors(n_neighbors=5, metric="precomputed").fit(np.zeros((300, 300))).kneighbors(D)
    search = PoseKNeighborsTransformer(tree, metric="spatial", n_neighbors=4).fit(X)
    np.testing.assert_allclose(np.sort(search.transform(Q).data.reshape(5, -1)), np.sort(expected), rtol=1e-9)


def test_geodesics_are_minima(tree):
    rng = np.random.default_rng(2)
    a = rng.uniform(-1, 1, size=tree.n_dofs)
    b = a + rng.uniform(-0.5, 0.5, size=tree.n_dofs)
    found = geodesic(a, b, tree)
    assert found.converged
    position, spatial = (pose_distances([a], [b], skeleton=tree, metric=m)[0, 0] for m in ("position", "spatial"))
    assert position * (1 - 1e-12) <= found.length <= spatial * (1 + 1e-9)
    if all(bone.n_dofs < 2 for bone in tree.bones):  # no other path of the same joints has less energy
        h, n = 1e-5, tree.n_dofs
        slope = np.empty((len(found.path) - 2, n))
        for i in range(slope.shape[0]):
            for d in range(n):
                step = np.zeros_like(found.path)
                step[i + 1, d] = h
                slope[i, d] = (
                    reference.path_energy(found.path + step, tree) - reference.path_energy(found.path - step, tree)
                ) / (2 * h)
        assert np.abs(slope).max() < 2e-4


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
    with pytest.raises(ValueError, match=r"in end lift_slide is 0\.5 m, its limits 0 m and 0\.4 m\. Take"):
        geodesic([0.0, 0.0], [0.5, 2.0], base, joint_limits="enforce")


@pytest.mark.parametrize("axis", "xyz")
@pytest.mark.parametrize("frame", ["own", "parent"])
def test_a_hinge_along_an_axis_is_that_axis(axis, frame):
    directions = np.eye(3)["xyz".index(axis)]
    rest = Rotation.from_euler("xyz", [0.3, 0.2, -0.5]).as_matrix()

    def arm(**dofs):
        return Skeleton(
            [Bone("a", None, (1, 2, 3), "zyx"), Bone("b", "a", (3, -1, 2), rest_rotation=rest, **dofs)], frame
        )

    X = np.random.default_rng(0).normal(size=(6, 4))
    for metric in ("position", "rotation", "spatial", "geodesic"):
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


def test_parallel_axes_and_right_angles_need_no_frames_of_their_own():
    rng = np.random.default_rng(0)
    bones, parent = [], None
    for i in range(30):
        axis = rng.choice([1, -1]) * np.eye(3)[rng.integers(3)]
        bones.append(Bone(f"b{i}", parent, rng.normal(size=3), "hinge", axis=axis))
        parent = f"b{i}" if i % 10 else None
    tree = tree_of(Skeleton(bones, "parent"))
    assert len(tree.frame_parent) == 31
    # Frames that are tilted about the axis before are free, too: the zero of that angle takes the tilt.
    tilt = Rotation.from_euler("y", 10, degrees=True).as_matrix()
    leg = [
        Bone("pitch", None, (0, 0, 0.1), "hinge", axis=(0, 1, 0)),
        Bone("roll", "pitch", (0, 0, -0.1), "hinge", tilt, axis=(1, 0, 0)),
        Bone("yaw", "roll", (0, 0, -0.1), "hinge", axis=(0, 0, 1)),
        Bone("knee", "yaw", (0, 0, -0.3), "hinge", tilt.T, axis=(0, 1, 0)),
    ]
    assert len(tree_of(Skeleton(leg, "parent")).frame_parent) == 5


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


def test_slides_between_frames_are_not_wrapped():
    between = moved([[0.0, 0, 0, 0], [8.0, 0, 0, 0]]).resample(20.0)
    assert between.angles[1, 0] == pytest.approx(4.0)
    assert moved([[0.0, 0, 0, 0], [8.0, 7, 0, 0]]).unwrap().angles[1] == pytest.approx([8.0, 7 - 2 * np.pi, 0, 0])
    keys = interpolate(
        np.array([[0.0, 0, 0, 0], [8.0, 0.3, 0, 0], [1.0, 0, 0, 0]]), skeleton=LIFT, times=[0, 1, 2], frame_rate=4
    )
    assert keys.angles[:, 0].max() > 7.0
    mean = frechet_mean(np.array([[0.0, 0, 0, 0], [8.0, 0.2, 0, 0]]), LIFT, metric="position")
    assert mean.pose[0] == pytest.approx(4.0, abs=1e-3)


def test_mirrored_slides_are_mirror_images():
    poses = np.random.default_rng(0).uniform(-1, 1, size=(5, 4))
    mirrored = moved(poses).mirrored(axis="y")
    expected = reference.forward_kinematics(poses, LIFT)[:, [2, 3, 0, 1]] * [1, -1, 1]
    np.testing.assert_allclose(reference.forward_kinematics(mirrored.angles, LIFT), expected, atol=1e-12)
    again = mirrored.mirrored(axis="y")
    np.testing.assert_allclose(again.angles, poses, atol=1e-12)


def test_files_keep_hinges_and_slides(tmp_path):
    motion = moved(np.random.default_rng(0).uniform(-1, 1, size=(5, 4)))
    save_npz(tmp_path / "lift.npz", motion)
    again = load_motion(tmp_path / "lift.npz")
    assert again.skeleton == LIFT
    np.testing.assert_array_equal(again.angles, motion.angles)
    with pytest.raises(ValueError, match="joint 'left_lift' slides, and BVH files have rotations alone"):
        save_bvh(tmp_path / "lift.bvh", motion)
    hinges = Skeleton([Bone("a", None, (0, 1, 0), "hinge", axis=(1, 2, 2)), Bone("b", "a", (0, 1, 0))], "parent")
    save_bvh(tmp_path / "hinge.bvh", Motion(hinges, [[0.3], [0.9]], 10.0, up="y"))
    read = load_motion(tmp_path / "hinge.bvh", up="y")
    np.testing.assert_allclose(
        reference.forward_kinematics(read.angles, read.skeleton)[:, -1],
        reference.forward_kinematics([[0.3], [0.9]], hinges)[:, -1],
        atol=1e-6,
    )


@pytest.mark.parametrize(
    ("bone", "message"),
    [
        (Bone("a", None, (0, 1, 0), "hinge"), r"bone 'a': axis must be three finite numbers, not all zero"),
        (Bone("a", None, (0, 1, 0), "hinge", axis=(0, 0, 0)), "not all zero"),
        (Bone("a", None, (0, 1, 0), "xyz", axis=(0, 0, 1)), 'it belongs to dofs="hinge" and "slide"'),
        (Bone("a", None, (0, 1, 0), "hinge", axis=(0, 0, 1), dof_name=""), "dof_name must be a non-empty string"),
        (Bone("a", None, (0, 1, 0), "z", dof_name="elbow"), "dof_name must be None"),
        (Bone("a", None, (0, 1, 0), "slide", axis=(0, 0, 1), limits=((1.0, 0.0),)), "pair in m for each of its 1 dofs"),
    ],
)
def test_wrong_hinges_and_slides_are_refused(bone, message):
    with pytest.raises(ValueError, match=message):
        Skeleton([bone])


def test_two_dofs_of_one_name_are_refused():
    hinge = Bone("a", None, (0, 1, 0), "hinge", axis=(0, 0, 1), dof_name="elbow")
    with pytest.raises(ValueError, match="two dofs have the name 'elbow'"):
        Skeleton([hinge, hinge._replace(name="b", parent="a")])


def test_directions_do_not_show_slides():
    lift = Skeleton(
        [Bone("lift", None, (0, 0, 1), "slide", axis=(0, 0, 1)), Bone("arm", "lift", (0, 0, 0.2), "rotvec")]
    )
    down = Skeleton([lift["lift"]._replace(axis=(0, 0, -1)), lift["arm"]])
    motion = Motion(lift, [[0.5, 0, 0, 0]], 30.0, up="z")
    for target in (down, Skeleton([lift["lift"]._replace(dofs="", axis=None, dof_name=None), lift["arm"]])):
        with pytest.raises(ValueError, match="joint 'lift' slides: method=\"positions\" finds it"):
            retarget(motion, target, method="orientations")
    found = retarget(motion, lift, method="numbers")
    np.testing.assert_array_equal(found.angles, motion.angles)


def test_steps_of_slides_are_not_wrapped():
    poses = np.array([[0.0, 0.1, 0, 0], [9.0, 0.2, 0, 0], [-9.0, 0.3, 0, 0]])
    spread = PoseTangentPCA(LIFT).fit(poses)
    assert spread.explained_variance_[0] == pytest.approx(2 * np.var([0.0, 9.0, -9.0], ddof=1))  # of two joints
    np.testing.assert_allclose(spread.inverse_transform(spread.transform(poses))[:, 0], poses[:, 0], atol=1e-6)
    line = straight_line(LIFT.bones, poses[0], poses[1], 3, 2 * np.pi)
    assert line[1, 0] == pytest.approx(4.5)


def test_the_mean_of_what_rotation_ignores_is_that_of_the_numbers():
    poses = np.random.default_rng(0).uniform(0, 2, size=(7, 4))
    found = frechet_mean(poses, LIFT, metric="rotation")
    np.testing.assert_allclose(found.pose[[0, 2]], poses[:, [0, 2]].mean(axis=0), atol=1e-9)


def test_metres_are_no_degrees():
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        pose_distances([[30.0, 0, 50.0, 0]], skeleton=LIFT, metric="position")
    with pytest.warns(UserWarning, match="beyond 18.8 in 1 of 2 columns"):
        pose_distances([[30.0, 90, 50.0, 0]], skeleton=LIFT, metric="position")


def test_words_of_slides_are_metres():
    lift = Bone("lift", None, (0, 0, 1), "slide", axis=(0, 0, 1), limits=((0.0, 0.04),))
    table = Skeleton([lift, Bone("arm", "lift", (1, 0, 0), "z", limits=((0.0, 1.0),))])._repr_html_()
    assert "0 to 0.04 m" in table
    assert "0 to 57°" in table
    with pytest.raises(ValueError, match=r"left_lift_slide slides by 0\.5 m"):
        moved(np.linspace([0.0, 0, 0, 0], [0.5, 0, 0, 0], 9)).repeat(2)
