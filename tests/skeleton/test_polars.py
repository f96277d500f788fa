"""Dataframes and series of polars as poses."""

import numpy as np
import polars as pl
import pytest

from skpose import (
    Motion,
    Skeleton,
    forward_kinematics,
    geodesic,
    pose_distances,
)
from skpose.geodesics import frechet_mean
from skpose.plot import PoseDisplay

ARM = Skeleton.chain(3)
X = np.random.default_rng(0).uniform(-1, 1, (20, 3))
FRAME = pl.DataFrame(X, schema=list(ARM.dof_names))
REVERSED = FRAME.select(FRAME.columns[::-1])
WRONG = "columns of"

FUNCTIONS = {
    "pose_distances": lambda X: pose_distances(X, skeleton=ARM),
    "forward_kinematics": lambda X: forward_kinematics(X, ARM),
    "frechet_mean": lambda X: frechet_mean(X, ARM).pose,
    "Motion": lambda X: Motion(ARM, X, 10).angles,
}


@pytest.mark.parametrize("name", FUNCTIONS)
def test_functions_take_data_frames_and_check_their_columns(name):
    np.testing.assert_array_equal(FUNCTIONS[name](FRAME), FUNCTIONS[name](X))
    assert FUNCTIONS[name](FRAME[list(ARM.dof_names)]).shape == FUNCTIONS[name](X).shape  # the remedy works
    with pytest.raises(ValueError, match=WRONG):
        FUNCTIONS[name](REVERSED)


def test_one_pose_is_a_series_a_row_or_a_data_frame_of_one_row():
    expected = geodesic(X[0], X[1], ARM).path
    for start in (pl.Series(X[0]), FRAME.row(0), FRAME[0]):
        np.testing.assert_array_equal(geodesic(start, X[1], ARM).path, expected)
    with pytest.raises(ValueError, match=WRONG):
        geodesic(REVERSED[0], X[1], ARM)
    with pytest.raises(ValueError, match="start must be one pose"):
        geodesic(FRAME[:2], X[1], ARM)
    assert PoseDisplay.from_pose(FRAME[0], ARM).positions.shape == (1, 3, 3)
