"""Frame rates: those that files state, those that are given in their place, and those that no recording has."""

import io
import warnings

import numpy as np
import pytest
from conftest import DATA

from skpose.io import MocapFormatError, load_amass, load_bvh, load_motion

HEAD = (DATA / "biped.bvh").read_text().partition("Frames:")[0]
ROW = " ".join(["1"] * HEAD.count("rotation") + ["2"] * HEAD.count("position")) + "\n"


def bvh(frame_time, n_frames=3):
    return io.StringIO(f"{HEAD}Frames: {n_frames}\nFrame Time: {frame_time}\n{ROW * n_frames}")


def amass(n_frames=4, **changed):
    arrays = {"poses": np.zeros((n_frames, 72)), "trans": np.zeros((n_frames, 3)), "mocap_framerate": 120.0} | changed
    file = io.BytesIO()
    np.savez(file, **{key: value for key, value in arrays.items() if value is not None})
    file.seek(0)
    return file


@pytest.mark.parametrize("load", [load_bvh, load_motion])
def test_a_rate_that_is_given_replaces_that_of_a_bvh_file_and_is_said(load):
    """Without a word the file's rate was kept, and the caller's was lost."""
    with pytest.warns(
        UserWarning, match="frame_rate=60 replaces the 25 Hz of Frame Time, so that it lasts 0.417 times as long"
    ):
        motion = load(bvh(0.04), frame_rate=60)
    assert motion.frame_rate == 60
    np.testing.assert_array_equal(motion.angles, load(bvh(0.04)).angles)


@pytest.mark.filterwarnings("ignore:bones have the lengths of a person of mean height", "ignore:.*along:UserWarning")
@pytest.mark.parametrize("load", [load_amass, load_motion])
def test_a_rate_that_is_given_replaces_that_of_an_amass_file_and_is_said(load):
    with pytest.warns(
        UserWarning, match="frame_rate=60 replaces the 120 Hz of mocap_framerate, so that it lasts 2 times"
    ):
        assert load(amass(), frame_rate=60).frame_rate == 60
    for rate in (0.0, np.nan, -3.0, None):
        assert load(amass(mocap_framerate=rate), frame_rate=60).frame_rate == 60
        with pytest.raises(MocapFormatError):
            load(amass(mocap_framerate=rate))
    assert load(amass()).frame_rate == load(amass(), frame_rate=120).frame_rate == 120


@pytest.mark.parametrize(
    ("frame_time", "said"),
    [
        ("33.333", r"Frame Time is 33.333 s, which is 0.03 frames a second: if it is in milliseconds, the rate is "
                   r"30.0003 Hz, frame_rate=30; if it is the number of frames a second, .* frame_rate=33.33"),
        ("30", r"the rate is 33.3333 Hz, frame_rate=33.33; if it is the number of frames a second, .* frame_rate=30"),
        ("120", "if it is the number of frames a second, the rate is 120 Hz, frame_rate=120"),
        ("8.3333", "if it is in milliseconds, the rate is 120 Hz, frame_rate=120"),
        ("0.000033333", "3e.04 frames a second: if it is a thousandth of what is meant, .* frame_rate=30"),
        ("0.0000001", "1e.07 frames a second: frame_rate= chooses the rate where it is not that of the recording"),
        ("1000000", "1e-06 frames a second: frame_rate= chooses"),
        ("1", "1 frames a second: frame_rate= chooses the rate where it is not that of the recording"),
    ],
)  # fmt: skip
def test_rates_of_no_recording_are_said(frame_time, said):
    with pytest.warns(UserWarning, match=said):
        motion = load_bvh(bvh(frame_time))
    assert motion.frame_rate == pytest.approx(1 / float(frame_time))
    with warnings.catch_warnings():
        warnings.simplefilter("error", UserWarning)
        warnings.filterwarnings("ignore", message=".*end to end")
        assert len(load_bvh(bvh(frame_time, 1))) == 1  # a single pose has no rate
        assert load_bvh(bvh(frame_time), frame_rate=30).frame_rate == 30  # as the message advises


@pytest.mark.parametrize("frame_time", ["0.5", "0.1", "0.0416667", "0.0083333", "0.001", "0.0005"])
def test_rates_of_recordings_are_not(frame_time):
    assert load_bvh(bvh(frame_time)).frame_rate == pytest.approx(1 / float(frame_time))
