"""Data frames and series of polars are poses, labels and weights as those of pandas are."""

import numpy as np
import polars as pl
import pytest
from sklearn.base import clone

from skpose import (
    MedoidShift,
    Motion,
    PoseDistanceTransformer,
    PoseKNeighborsTransformer,
    PoseRadiusNeighborsTransformer,
    Skeleton,
    SpatialMDS,
    forward_kinematics,
    geodesic,
    pose_distances,
    rotations_from_poses,
)
from skpose.geodesics import frechet_mean
from skpose.plot import MDSDisplay, PoseDisplay

ARM = Skeleton.chain(3)
X = np.random.default_rng(0).uniform(-1, 1, (20, 3))
FRAME = pl.DataFrame(X, schema=list(ARM.dof_names))
REVERSED = FRAME.select(FRAME.columns[::-1])
WRONG = r"column 0 is 'joint_3_rz' and should be 'joint_1_rz'\); select them with \w+\[list\(skeleton.dof_names\)\]"

FUNCTIONS = {
    "pose_distances": lambda X: pose_distances(X, skeleton=ARM),
    "pose_distances, Y": lambda Y: pose_distances(X.copy(), Y, skeleton=ARM),
    "forward_kinematics": lambda X: forward_kinematics(X, ARM),
    "frechet_mean": lambda X: frechet_mean(X, ARM).pose,
    "rotations_from_poses": lambda X: rotations_from_poses(X, ARM, form="6d"),
    "Motion": lambda X: Motion(ARM, X, 10).angles,
}


@pytest.mark.parametrize("name", FUNCTIONS)
def test_functions_take_data_frames_and_check_their_columns(name):
    np.testing.assert_array_equal(FUNCTIONS[name](FRAME), FUNCTIONS[name](X))
    assert FUNCTIONS[name](FRAME[list(ARM.dof_names)]).shape == FUNCTIONS[name](X).shape  # the remedy works
    with pytest.raises(ValueError, match=WRONG):
        FUNCTIONS[name](REVERSED)


@pytest.mark.parametrize(
    "estimator",
    [
        PoseDistanceTransformer(ARM), PoseKNeighborsTransformer(ARM), PoseRadiusNeighborsTransformer(ARM),
        SpatialMDS(skeleton=ARM), MedoidShift(ARM, bandwidth=1.0),
    ],
    ids=lambda estimator: type(estimator).__name__,
)  # fmt: skip
def test_estimators_take_data_frames_and_check_their_columns(estimator):
    fitted, expected = clone(estimator).fit(FRAME), clone(estimator).fit(X)
    assert list(fitted.feature_names_in_) == list(ARM.dof_names)
    use, same = (getattr(one, "transform", None) or one.predict for one in (fitted, expected))
    found, known = use(FRAME), same(X.copy())  # which is not the very array of fit
    for one in (found, known):
        assert np.shape(one)[0] == len(X)
    np.testing.assert_array_equal(*(one.toarray() if hasattr(one, "toarray") else one for one in (found, known)))
    with pytest.raises(ValueError, match=WRONG):
        clone(estimator).fit(REVERSED)
    with pytest.raises(ValueError, match=WRONG):
        use(REVERSED)


def test_one_pose_is_a_series_a_row_or_a_data_frame_of_one_row():
    expected = geodesic(X[0], X[1], ARM).path
    for start in (pl.Series(X[0]), FRAME.row(0), FRAME[0]):
        np.testing.assert_array_equal(geodesic(start, X[1], ARM).path, expected)
    with pytest.raises(ValueError, match=WRONG):
        geodesic(REVERSED[0], X[1], ARM)
    with pytest.raises(ValueError, match="start must be one pose, got a data frame of 2 rows"):
        geodesic(FRAME[:2], X[1], ARM)
    assert PoseDisplay.from_pose(FRAME[0], ARM).positions.shape == (3, 3)


def test_series_of_weights_and_labels():
    weights = np.arange(20.0)
    mean = frechet_mean(FRAME, ARM, sample_weight=pl.Series(weights))
    np.testing.assert_array_equal(mean.pose, frechet_mean(X, ARM, sample_weight=weights).pose)
    labels = pl.Series(["a", "b"] * 10)
    display = MDSDisplay.from_embedding(pl.DataFrame(X[:, :2]), labels)
    assert [text.get_text() for text in display.ax_.get_legend().get_texts()] == ["a", "b"]
    motion = Motion(ARM, FRAME, 10, frame_numbers=pl.Series(range(20)))
    assert len(motion) == 20


def test_output_as_a_data_frame():
    D = PoseDistanceTransformer(ARM).set_output(transform="polars").fit_transform(FRAME)
    assert isinstance(D, pl.DataFrame)
    np.testing.assert_array_equal(D.to_numpy(), pose_distances(X, skeleton=ARM))


def test_a_lazy_frame_has_no_values_yet():
    with pytest.raises(TypeError, match=r"X must be an array of poses, got a LazyFrame, .*: pass X\.collect\(\)"):
        pose_distances(FRAME.lazy(), skeleton=ARM)


def test_missing_values_are_refused():
    holes = FRAME.with_columns(joint_1_rz=pl.lit(None, dtype=pl.Float64))
    with pytest.raises(ValueError, match="contains NaN"):
        pose_distances(holes, skeleton=ARM)
