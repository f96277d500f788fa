"""Lost points at exactly (0, 0, 0)."""

import io
import warnings

import numpy as np
import pytest
from people import moving

from skpose.io import load_keypoints
from skpose.keypoints import Keypoints, fit_skeleton, layouts

COCO, H36M = layouts["coco17"], layouts["h36m17"]
SEEN = moving(COCO, n=60)
LOST = SEEN.copy()
LOST[20:30, 9] = 0.0
CENTRED = moving(H36M, n=60)
CENTRED -= CENTRED[:, [H36M.names.index("pelvis")]]


def npy(array):
    file = io.BytesIO()
    np.save(file, array)
    return file


ARRAYS = {
    "Keypoints": lambda array: Keypoints(array, COCO.names, 30),
    "Layout.keypoints": lambda array: COCO.keypoints(array, 30),
    "fit_skeleton": lambda array: fit_skeleton(array, COCO),
}


def load(write, array, layout=COCO, **options):
    file = write(array)
    file.seek(0)
    return load_keypoints(file, layout, frame_rate=30, **options)


def messages(call, *arguments, **options):
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        call(*arguments, **options)
    return [str(one.message) for one in caught]


@pytest.mark.parametrize("door", ARRAYS)
def test_arrays(door):
    (message,) = messages(ARRAYS[door], LOST)
    assert "10 positions are exactly (0, 0, 0), such as of 'left_wrist'" in message
    positions = LOST.copy()
    positions[(positions == 0).all(axis=2)] = np.nan
    assert messages(ARRAYS[door], positions) == []
    assert messages(ARRAYS[door], SEEN) == []


def test_the_origin_of_the_others_is_seen():
    """The pelvis of positions relative to it; but not in frames of zeros alone, in which nobody is seen."""
    for door in (lambda array: H36M.keypoints(array, 50), lambda array: load(npy, array, H36M)):
        assert messages(door, CENTRED) == []
        lost = CENTRED.copy()
        lost[7:9, 5] = 0.0
        assert f"2 positions are exactly (0, 0, 0), such as of {H36M.names[5]!r}" in messages(door, lost)[0]
    empty = CENTRED.copy()
    empty[7:9] = 0.0
    assert f"{2 * 17} positions" in messages(H36M.keypoints, empty, 50)[0]
    found = load(npy, empty, H36M, zeros="missing")
    np.testing.assert_array_equal(np.isnan(found.positions).all(axis=(1, 2)), np.isin(np.arange(60), [7, 8]))
    np.testing.assert_array_equal(found.positions[0], CENTRED[0])
