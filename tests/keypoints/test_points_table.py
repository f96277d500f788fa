"""Keypoints as a table of pandas: the numbers, their names, and the way back."""

import sys
from dataclasses import replace

import numpy as np
import pandas
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


def test_confidences_are_there_where_they_say_more_than_seen_or_not():
    sure = np.ones((8, 3))
    assert "knee_confidence" not in recording(sure=sure).to_pandas()
    sure[5, 2] = 0.0
    assert "knee_confidence" not in recording(sure=sure).to_pandas()
    sure[6, 0] = 0.5
    seen = recording(sure=sure)
    table = seen.to_pandas()
    assert table.columns[:5].tolist() == ["left hip_x", "left hip_y", "left hip_z", "left hip_confidence", "knee_x"]
    columns = [f"{name}_confidence" for name in NAMES]
    np.testing.assert_array_equal(table[columns], seen.confidences)
    assert table["x_confidence"][5 / 25] == 0
    assert np.isnan(table["x_x"][5 / 25])


@pytest.mark.parametrize("sure", [None, 0.7])
@pytest.mark.parametrize("name", ["coco17", "plug_in_gait39", "body25"])
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


def test_its_csv_states_neither_rate_nor_axis(tmp_path):
    """Times are in a unit that the file does not state: the rate is to be given, as the error says."""
    seen = recording()
    seen.to_pandas().to_csv(tmp_path / "seen.csv")
    with pytest.raises(ValueError, match=r"does not state its frame rate: pass frame_rate=, in Hz; 'time' has 25 Hz"):
        load_keypoints(tmp_path / "seen.csv")
    read = load_keypoints(tmp_path / "seen.csv", frame_rate=25, up="z")
    assert (read.frame_rate, read.up) == (seen.frame_rate, seen.up)
    np.testing.assert_allclose(read.positions, seen.positions, atol=1e-12)


def test_the_table_is_a_copy():
    seen = recording()
    table = seen.to_pandas()
    table.iloc[:] = 0.0
    assert np.isnan(seen.positions).any()
    assert isinstance(table, pandas.DataFrame)


def test_no_frames():
    assert replace(recording(), positions=np.empty((0, 3, 3)), confidences=None).to_pandas().shape == (0, 9)


def test_pandas_is_named_where_it_is_missing(monkeypatch):
    monkeypatch.setitem(sys.modules, "pandas", None)
    with pytest.raises(ImportError, match=r"pip install 'skpose\[pandas\]'"):
        recording().to_pandas()
