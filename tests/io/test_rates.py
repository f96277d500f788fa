"""Frame rates: those that files state, those that are given in their place, and those that no recording has."""

import io

import numpy as np
import pytest
from conftest import DATA

from skpose.io import load_bvh

HEAD = (DATA / "biped.bvh").read_text().partition("Frames:")[0]
ROW = " ".join(["1"] * HEAD.count("rotation") + ["2"] * HEAD.count("position")) + "\n"


def bvh(frame_time, n_frames=3):
    return io.StringIO(f"{HEAD}Frames: {n_frames}\nFrame Time: {frame_time}\n{ROW * n_frames}")


def test_a_rate_that_is_given_replaces_that_of_a_bvh_file_and_is_said():
    with pytest.warns(UserWarning, match="frame_rate=60 replaces the 25 Hz"):
        motion = load_bvh(bvh(0.04), frame_rate=60)
    assert motion.frame_rate == 60
    np.testing.assert_array_equal(motion.angles, load_bvh(bvh(0.04)).angles)


@pytest.mark.parametrize("frame_time", ["33.333", "120", "0.000033333", "1"])
def test_rates_of_no_recording_are_said(frame_time):
    with pytest.warns(UserWarning, match="Frame Time is .*frame_rate="):
        motion = load_bvh(bvh(frame_time))
    assert motion.frame_rate == pytest.approx(1 / float(frame_time))
    assert load_bvh(bvh(frame_time, 1)).frame_rate == motion.frame_rate  # a single pose has no rate: no warning
