"""Keypoints as a pandas dataframe."""

import numpy as np

from skpose.keypoints import Keypoints

NAMES = ["left hip", "knee", "x"]


def recording(n=8, sure=None):
    positions = np.random.default_rng(0).normal(size=(n, 3, 3))
    positions[2:4, 1] = np.nan
    return Keypoints(positions, NAMES, 25.0, sure, up="z")


def test_a_row_for_each_frame_and_three_columns_for_each_point():
    seen = recording()
    table = seen.to_pandas()
    assert table.columns.tolist() == [f"{name}_{axis}" for name in NAMES for axis in "xyz"]
    assert table.index.name == "time"
    np.testing.assert_array_equal(table.index, np.arange(8) / 25)
    for i, name in enumerate(NAMES):
        for j, axis in enumerate("xyz"):
            np.testing.assert_array_equal(table[f"{name}_{axis}"], seen.positions[:, i, j])
    assert table["knee_x"].isna().sum() == 2
    assert table.attrs == {"unit": "m", "frame_rate": 25.0, "up": "z"}
