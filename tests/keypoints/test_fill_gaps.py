"""Gaps in keypoints."""

import numpy as np
import pytest

from skpose import Keypoints

RATE = 50.0


@pytest.fixture
def line():
    """Points that move along straight lines, one with gaps of 1, 3 and 10 frames, and two at each end."""
    t = np.arange(40)[:, None, None]
    truth = t * np.array([[0.01, 0.0, -0.02], [0.03, 0.01, 0.0]]) + np.array([[1.0, 2.0, 3.0], [0.0, 0.1, 0.0]])
    positions = truth.copy()
    for gap in (slice(0, 2), slice(5, 6), slice(9, 12), slice(20, 30), slice(38, 40)):
        positions[gap, 0] = np.nan
    return truth, Keypoints(positions, ["hand", "foot"], RATE)


@pytest.mark.parametrize(("longest", "filled"), [(None, 14), (3 / RATE, 4), (1 / RATE, 1), (0.0, 0)])
def test_gaps_are_filled_by_lines_and_ends_stay(line, longest, filled):
    truth, keypoints = line
    found = keypoints.fill_gaps(longest, confidence=0.25)
    new = (found.confidences > 0.0) & (keypoints.confidences == 0.0)
    assert new.sum() == filled
    assert not new[[0, 1, 38, 39]].any()
    np.testing.assert_allclose(found.positions[new], truth[new], atol=1e-12)
    np.testing.assert_array_equal(found.confidences[new], 0.25)
    np.testing.assert_array_equal(found.positions[~new], keypoints.positions[~new])
    np.testing.assert_array_equal(found.confidences[~new], keypoints.confidences[~new])
