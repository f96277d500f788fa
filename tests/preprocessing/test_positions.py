"""Poses from positions, as a transformer: one row for one row, back and forth."""

import numpy as np
import pandas as pd
import pytest
import reference
from conftest import SKELETONS
from scipy.spatial.transform import Rotation
from sklearn.base import clone
from sklearn.exceptions import NotFittedError
from sklearn.pipeline import make_pipeline

from skpose import Bone, Keypoints, Motion, PoseKNeighborsTransformer, Skeleton, forward_kinematics, inverse_kinematics
from skpose.preprocessing import PoseFromPositions

HUMANOID = SKELETONS["humanoid"]
COLUMNS = [f"{joint}_{axis}" for joint in HUMANOID.joint_names for axis in "xyz"]


@pytest.fixture(scope="module")
def poses():
    return np.random.default_rng(0).uniform(-0.5, 0.5, size=(12, HUMANOID.n_dofs))


@pytest.fixture(scope="module")
def X(poses):
    """Positions, each row moved and turned differently."""
    rng, relative = np.random.default_rng(1), reference.forward_kinematics(poses, HUMANOID)
    turns = Rotation.from_quat(rng.normal(size=(len(relative), 4))).as_matrix()
    return (relative @ turns.transpose(0, 2, 1) + rng.normal(size=(len(relative), 1, 3))).reshape(len(relative), -1)


@pytest.fixture(scope="module")
def fitted(X):
    return PoseFromPositions(HUMANOID).fit(X)


def test_poses_have_the_given_positions_up_to_the_movement_of_the_root(fitted, X):
    poses = fitted.transform(X)
    back = fitted.inverse_transform(poses)
    np.testing.assert_array_equal(back, forward_kinematics(poses, HUMANOID).reshape(12, -1))
    for given, found in zip(X.reshape(12, -1, 3), back.reshape(12, -1, 3), strict=True):
        given, found = given - given.mean(axis=0), found - found.mean(axis=0)
        turn, _ = Rotation.align_vectors(given, found)
        np.testing.assert_allclose(turn.apply(found), given, atol=1e-4)


def test_poses_do_not_depend_on_the_root():
    """Three joints around the root determine its axes."""
    pelvis = [Bone(name, None, offset) for name, offset in zip("abc", np.eye(3) / 5, strict=True)]
    skeleton = Skeleton(
        [*pelvis, Bone("knee", "a", (0.1, -0.4, 0), "rotvec"), Bone("ankle", "knee", (0, -0.4, 0), "x")]
    )
    poses = np.random.default_rng(3).uniform(0.2, 1.0, size=(6, 4))
    F = forward_kinematics(poses, skeleton)
    turned = Rotation.from_euler("xyz", [1.0, -2.0, 0.5]).apply(F.reshape(-1, 3)) + np.array([3.0, 0.0, -1.0])
    transformer = PoseFromPositions(skeleton).fit(F.reshape(6, -1))
    for given in (F, turned):
        np.testing.assert_allclose(transformer.transform(given.reshape(6, -1)), poses, atol=1e-6)


def test_rows_are_independent(fitted, X):
    X = X.copy()
    X[3, 6:9] = np.nan  # a joint that other rows have
    together = fitted.transform(X)
    np.testing.assert_array_equal(fitted.transform(X[::-1]), together[::-1])
    np.testing.assert_array_equal(fitted.transform(X[[4]]), together[[4]])
    np.testing.assert_array_equal(inverse_kinematics(X[5].reshape(1, -1, 3), HUMANOID).poses, together[[5]])
    np.testing.assert_array_equal(PoseFromPositions(HUMANOID, n_jobs=2).fit(X[:1]).transform(X), together)
    X[3, 6] = 1.0  # one coordinate of three does not make a joint
    np.testing.assert_array_equal(fitted.transform(X[[3]]), together[[3]])


def test_a_row_without_joints_gets_the_rest_pose_and_a_warning(fitted, X):
    with pytest.warns(UserWarning, match="frame 2"):
        poses = fitted.transform(np.where(np.arange(12)[:, None] == 2, np.nan, X))
    np.testing.assert_allclose(poses[2], 0.0, atol=1e-12)


def test_regularization(X):
    balls = HUMANOID.to_rotvec()
    noisy = X + np.random.default_rng(2).normal(scale=0.01, size=X.shape)
    start = np.zeros((12, balls.n_dofs))
    expected = inverse_kinematics(noisy.reshape(12, -1, 3), balls, initial=start, regularization=0.05).poses
    np.testing.assert_array_equal(PoseFromPositions(balls, regularization=0.05).fit(noisy).transform(noisy), expected)


@pytest.mark.parametrize("limit", [1.1, np.nextafter(1.0, 0)])
def test_poses_stay_inside_limits_also_in_float32(limit):
    bones = [Bone("shoulder", None, (0, 0, 0)), Bone("elbow", "shoulder", (0.3, 0, 0))]
    elbow = Skeleton([*bones, Bone("wrist", "elbow", (0.25, 0, 0), "z", limits=[(-limit, limit)])])
    bent = np.array([[0, 0, 0, 0.3, 0, 0, 0.3, side * 0.25, 0] for side in (1, -1)])
    for dtype in (np.float32, np.float64):
        found = PoseFromPositions(elbow, joint_limits="enforce").fit(bent).transform(bent.astype(dtype))
        assert found.dtype == dtype
        assert (np.abs(found.astype(np.float64)) <= limit).all()
        np.testing.assert_allclose(np.abs(found), limit, rtol=2e-7 if dtype == np.float32 else 1e-6)


def test_data_frames_go_in_and_out(X):
    frame = pd.DataFrame(X, columns=COLUMNS)
    transformer = PoseFromPositions(HUMANOID).set_output(transform="pandas").fit(frame)
    poses = transformer.transform(frame)
    assert list(poses.columns) == list(transformer.get_feature_names_out()) == list(HUMANOID.dof_names)
    neighbours = PoseKNeighborsTransformer(HUMANOID, n_neighbors=2)  # which checks the names
    assert make_pipeline(transformer, neighbours).fit_transform(frame).nnz == 3 * len(X)
    with pytest.raises(ValueError, match="abdomen_y"):
        clone(transformer).fit(frame[[*COLUMNS[1::-1], *COLUMNS[2:]]])


def test_bad_input_is_refused(X):
    keypoints = Keypoints(X.reshape(12, -1, 3), HUMANOID.joint_names, 10)
    motion = Motion(HUMANOID, np.zeros((3, HUMANOID.n_dofs)), 10)
    for bad in (keypoints, motion, HUMANOID, np.ones((5, 67)), np.ones((5, 22, 3)), np.full_like(X, np.inf)):
        transformer = PoseFromPositions(HUMANOID).fit(X)
        with pytest.raises((TypeError, ValueError)):
            transformer.fit(bad)
        with pytest.raises(NotFittedError):
            transformer.transform(X)
    with pytest.raises(ValueError, match="skeleton"):
        PoseFromPositions().fit(X)
    with pytest.raises(ValueError, match="limits"):
        PoseFromPositions(HUMANOID, joint_limits="enforce").fit(X)


def test_degrees_are_noticed(fitted, poses):
    with pytest.warns(UserWarning, match="values of X reach"):
        fitted.inverse_transform(np.degrees(poses) * 10)
