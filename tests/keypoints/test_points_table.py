"""Keypoints as a table of pandas: the numbers, their names, and the way back."""

import numpy as np
import pytest

from skpose.io import load_keypoints
from skpose.keypoints import Keypoints, layouts

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


@pytest.mark.parametrize("sure", [None, 0.7])
@pytest.mark.parametrize("name", ["coco17", "plug_in_gait39"])
def test_its_csv_is_read_as_the_same_keypoints(tmp_path, name, sure):
    layout = layouts[name]
    positions = np.random.default_rng(1).normal(size=(5, len(layout.names), 3))
    positions[1:3, 4] = np.nan
    confidences = None if sure is None else np.full(positions.shape[:2], sure)
    seen = Keypoints(positions, layout.names, 30, confidences)
    seen.to_pandas().to_csv(tmp_path / "seen.csv")
    read = load_keypoints(tmp_path / "seen.csv", frame_rate=30)
    assert read.names == seen.names
    np.testing.assert_array_equal(read.positions, seen.positions)
    np.testing.assert_array_equal(read.confidences, seen.confidences)
