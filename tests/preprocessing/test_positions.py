"""Poses from positions, as a transformer: one row for one row, back and forth."""

import joblib
import numpy as np
import pandas as pd
import pytest
import reference
from conftest import SKELETONS
from scipy.spatial.transform import Rotation
from sklearn.base import clone
from sklearn.exceptions import NotFittedError
from sklearn.pipeline import make_pipeline

from skpose import (
    Bone,
    Keypoints,
    Motion,
    PoseFromPositions,
    PoseKNeighborsTransformer,
    Skeleton,
    forward_kinematics,
    inverse_kinematics,
)

HUMANOID = SKELETONS["humanoid"]
BALLS = HUMANOID.to_rotvec()
COLUMNS = [f"{joint}_{axis}" for joint in HUMANOID.joint_names for axis in "xyz"]


@pytest.fixture(scope="module")
def poses():
    return np.random.default_rng(0).uniform(-0.5, 0.5, size=(12, HUMANOID.n_dofs))


@pytest.fixture(scope="module")
def relative(poses):
    """Positions relative to the root, by the reference."""
    return reference.forward_kinematics(poses, HUMANOID)


@pytest.fixture(scope="module")
def X(relative):
    """The same, each row moved and turned somewhere else."""
    rng = np.random.default_rng(1)
    turns = Rotation.from_quat(rng.normal(size=(len(relative), 4))).as_matrix()
    return (relative @ turns.transpose(0, 2, 1) + rng.normal(size=(len(relative), 1, 3))).reshape(len(relative), -1)


@pytest.fixture
def fitted(X):
    return PoseFromPositions(HUMANOID).fit(X)


def test_poses_have_the_given_positions_but_for_the_movement_of_the_root(fitted, X):
    poses = fitted.transform(X)
    assert poses.shape == (12, HUMANOID.n_dofs)
    back = fitted.inverse_transform(poses)
    np.testing.assert_array_equal(back, forward_kinematics(poses, HUMANOID).reshape(12, -1))
    for given, found in zip(X.reshape(12, -1, 3), back.reshape(12, -1, 3), strict=True):
        given, found = given - given.mean(axis=0), found - found.mean(axis=0)
        turn, _ = Rotation.align_vectors(given, found)
        np.testing.assert_allclose(turn.apply(found), given, atol=1e-4)


def test_the_movement_of_the_root_is_no_part_of_a_pose():
    """The axes of a root with three joints around it that are no line are known; poses are the same in any of them."""
    pelvis = [Bone(name, None, offset) for name, offset in zip("abc", np.eye(3) / 5, strict=True)]
    skeleton = Skeleton(
        [*pelvis, Bone("knee", "a", (0.1, -0.4, 0), "rotvec"), Bone("ankle", "knee", (0, -0.4, 0), "x")]
    )
    poses = np.random.default_rng(3).uniform(0.2, 1.0, size=(6, 4))
    F = forward_kinematics(poses, skeleton)
    turned = Rotation.from_euler("xyz", [1.0, -2.0, 0.5]).apply(F.reshape(-1, 3)) + np.array([3.0, 0.0, -1.0])
    transformer = PoseFromPositions(skeleton).fit(F.reshape(6, -1))
    for given in (F, turned):
        found = transformer.transform(given.reshape(6, -1))
        np.testing.assert_allclose(found, poses, atol=1e-6)
        np.testing.assert_allclose(transformer.inverse_transform(found), F.reshape(6, -1), atol=1e-6)


def test_rows_have_nothing_to_do_with_each_other(fitted, X):
    X = X.copy()
    X[3, 6:9] = np.nan  # a joint that other rows show
    together = fitted.transform(X)
    np.testing.assert_array_equal(fitted.transform(X[::-1]), together[::-1])
    for i in range(len(X)):
        np.testing.assert_array_equal(fitted.transform(X[[i]]), together[[i]])
    alone = inverse_kinematics(X[5].reshape(1, -1, 3), HUMANOID)
    np.testing.assert_array_equal(alone.poses, together[[5]])


def test_poses_do_not_depend_on_what_was_fitted_or_on_threads(fitted, X):
    np.testing.assert_array_equal(PoseFromPositions(HUMANOID, n_jobs=2).fit(X[:1]).transform(X), fitted.transform(X))
    np.testing.assert_array_equal(PoseFromPositions(HUMANOID).fit_transform(X), fitted.transform(X))


def test_a_joint_of_which_one_coordinate_is_nan_is_not_seen(fitted, X):
    one, all_three = X.copy(), X.copy()
    one[:, 10] = all_three[:, 9:12] = np.nan
    np.testing.assert_array_equal(fitted.transform(one), fitted.transform(all_three))


def test_a_row_without_positions_has_the_rest_pose_and_a_warning(fitted, X):
    X = X.copy()
    X[2] = np.nan
    with pytest.warns(UserWarning, match="in 1 of 12 frames, first in frame 2, no joint is seen") as caught:
        poses = fitted.transform(X)
    assert caught[0].filename == __file__
    np.testing.assert_allclose(poses[2], 0.0, atol=1e-12)


def test_parameters_are_those_of_inverse_kinematics(X):
    noisy = X + np.random.default_rng(2).normal(scale=0.01, size=X.shape)
    start = np.zeros((12, BALLS.n_dofs))
    expected = inverse_kinematics(noisy.reshape(12, -1, 3), BALLS, initial=start, regularization=0.05).poses
    stiff = PoseFromPositions(BALLS, regularization=0.05).fit(noisy)
    np.testing.assert_array_equal(stiff.transform(noisy), expected)
    loose = stiff.set_params(regularization=0.0).transform(noisy)
    assert np.linalg.norm(expected) < np.linalg.norm(loose)

    elbow = Skeleton(
        [
            Bone("shoulder", None, (0, 0, 0)),
            Bone("elbow", "shoulder", (0.3, 0, 0)),
            Bone("wrist", "elbow", (0.25, 0, 0), "z", limits=[(0.0, 1.0)]),
        ]
    )
    bent = [[0, 0, 0, 0.3, 0, 0, 0.3, 0.25, 0]]
    limited = PoseFromPositions(elbow, joint_limits="enforce").fit(bent)
    np.testing.assert_allclose(limited.transform(bent), [[1.0]], atol=1e-6)


@pytest.mark.parametrize("limit", [1.1, 1.2, 1.3, np.nextafter(1.0, 0), 1.0])
def test_float32_poses_stay_inside_limits_too(limit):
    elbow = Skeleton(
        [
            Bone("shoulder", None, (0, 0, 0)),
            Bone("elbow", "shoulder", (0.3, 0, 0)),
            Bone("wrist", "elbow", (0.25, 0, 0), "z", limits=[(-limit, limit)]),
        ]
    )
    bent = np.array([[0, 0, 0, 0.3, 0, 0, 0.3, side * 0.25, 0] for side in (1, -1)], np.float32)
    found = PoseFromPositions(elbow, joint_limits="enforce").fit(bent).transform(bent)
    assert found.dtype == np.float32
    assert (np.abs(found.astype(np.float64)) <= limit).all()  # as numbers of float64: float32 would round the limit
    np.testing.assert_allclose(np.abs(found), limit, rtol=2e-7)
    fixed = Skeleton([*elbow.bones[:2], elbow.bones[2]._replace(limits=[(limit, limit)])])
    found = PoseFromPositions(fixed, joint_limits="enforce").fit(bent).transform(bent)
    np.testing.assert_allclose(found, limit, rtol=2e-7)
    assert (found.astype(np.float64) <= limit).all()


def test_float32_stays_float32(fitted, X, poses):
    found = fitted.transform(X.astype(np.float32))
    assert found.dtype == fitted.inverse_transform(found).dtype == np.float32
    assert fitted.transform(X).dtype == fitted.inverse_transform(poses).dtype == np.float64


def test_data_frames_go_in_and_out(X):
    frame = pd.DataFrame(X, columns=COLUMNS)
    transformer = PoseFromPositions(HUMANOID).set_output(transform="pandas").fit(frame)
    poses = transformer.transform(frame)
    assert list(poses.columns) == list(transformer.get_feature_names_out()) == list(HUMANOID.dof_names)
    np.testing.assert_array_equal(poses, PoseFromPositions(HUMANOID).fit(X).transform(X))
    assert transformer.inverse_transform(poses).shape == X.shape
    neighbours = PoseKNeighborsTransformer(HUMANOID, n_neighbors=2)  # which checks the names
    assert make_pipeline(transformer, neighbours).fit_transform(frame).nnz == 3 * len(X)
    with pytest.raises(ValueError, match="column 0 is 'abdomen_y' and should be 'abdomen_x'"):
        clone(transformer).fit(frame[[*COLUMNS[1::-1], *COLUMNS[2:]]])
    with pytest.raises(ValueError, match=r"missing: 'abdomen_x'; not a position of it: 'hip'"):
        clone(transformer).fit(frame.rename(columns={"abdomen_x": "hip"}))
    clone(transformer).fit(frame.set_axis([f"column {i}" for i in range(X.shape[1])], axis=1))  # by position
    with pytest.raises(ValueError, match="are named after degrees of freedom"):
        transformer.inverse_transform(poses[poses.columns[::-1]])


@pytest.mark.parametrize(
    ("shape", "message"),
    [
        ((5, 67), "X has 67 columns, but the skeleton has 22 joints.*66 columns$"),
        ((5, 69), "with the root.*leave it out"),
        ((5, 44), "in two dimensions.*Lift them to 3-D first"),
        ((5, 42), "Are these poses.*not needed"),
        ((5, 22, 3), r"got \(5, 22, 3\): pass X.reshape\(len\(X\), -1\)"),
        ((5, 22, 2), "do not say how a pose is, lift them"),
        ((5, 21, 3), r"must have shape \(n_samples, 66\).*got \(5, 21, 3\)$"),
    ],
)
def test_other_shapes_are_refused_with_the_remedy(shape, message):
    for X in (np.ones(shape), np.ones(shape).tolist()):
        with pytest.raises(ValueError, match=message):
            PoseFromPositions(HUMANOID).fit(X)


def test_what_is_no_array_of_positions_is_refused(X):
    keypoints = Keypoints(X.reshape(12, -1, 3), HUMANOID.joint_names, 10)
    motion = Motion(HUMANOID, np.zeros((3, HUMANOID.n_dofs)), 10)
    for other, remedy in ((keypoints, "keypoints.select"), (motion, "motion.angles"), (HUMANOID, "skeleton=")):
        with pytest.raises(TypeError, match=f"X must be an array of positions, got .*{remedy}"):
            PoseFromPositions(HUMANOID).fit(other)


def test_what_is_missing_fails_in_fit(X):
    with pytest.raises(ValueError, match=r"PoseFromPositions needs a skeleton, got None: pass skeleton="):
        PoseFromPositions().fit(X)
    with pytest.raises(ValueError, match='joint_limits="enforce" needs a skeleton with limits'):
        PoseFromPositions(HUMANOID, joint_limits="enforce").fit(X)


def test_a_fit_that_fails_leaves_no_fit(fitted, X):
    for wrong in (np.full_like(X, np.inf), X[:, :9]):
        fitted = clone(fitted).fit(X)
        with pytest.raises(ValueError, match=r"infinity|columns"):
            fitted.fit(wrong)
        for method in (fitted.transform, fitted.inverse_transform, fitted.get_feature_names_out):
            with pytest.raises(NotFittedError):
                method(X)


def test_a_fitted_transformer_keeps_its_skeleton(fitted, X):
    before, expected = joblib.hash(fitted), fitted.transform(X)
    fitted.inverse_transform(expected)
    assert joblib.hash(fitted) == before
    np.testing.assert_array_equal(fitted.set_params(skeleton=BALLS).transform(X), expected)


def test_degrees_are_noticed(fitted, poses):
    with pytest.warns(UserWarning, match="values of X reach"):
        fitted.inverse_transform(np.degrees(poses) * 10)
