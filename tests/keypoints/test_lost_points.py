"""Points at exactly (0, 0, 0), as some programs write lost ones: noticed at every door, but for the origin itself."""

import io
import json
import warnings

import numpy as np
import pytest
from people import ARM, moving

from skpose.io import load_keypoints
from skpose.keypoints import Keypoints, fit_skeleton, layouts

COCO, H36M = layouts["coco17"], layouts["h36m17"]
SEEN = moving(COCO, n=60)
LOST = SEEN.copy()
LOST[20:30, 9] = 0.0
CENTRED = moving(H36M, n=60)
CENTRED -= CENTRED[:, [H36M.names.index("pelvis")]]


def npz(array):
    file = io.BytesIO()
    np.savez(file, positions=array)
    return file


def npy(array):
    file = io.BytesIO()
    np.save(file, array)
    return file


def text(array):
    return io.BytesIO(json.dumps(array.tolist()).encode())


def table(array):
    header = ",".join(f"{name}_{axis}" for name in COCO.names for axis in "xyz")
    return io.BytesIO("\n".join([header, *(",".join(map(repr, row.ravel().tolist())) for row in array)]).encode())


FILES = [npz, npy, text, table]
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


@pytest.mark.parametrize("write", FILES)
def test_files(write):
    (message,) = messages(load, write, LOST)
    assert "10 positions (1.0 % of all) are exactly (0, 0, 0), of 'left_wrist': some programs write lost" in message
    assert "zeros='missing' reads them as not seen, zeros='seen' as they are" in message
    assert messages(load, write, SEEN) == []
    assert messages(load, write, LOST, zeros="seen") == []
    np.testing.assert_array_equal(load(write, LOST, zeros="seen").positions[20:30, 9], 0.0)
    found, without = load(write, LOST, zeros="missing"), LOST.copy()
    without[20:30, 9] = np.nan
    np.testing.assert_array_equal(found.positions, COCO.keypoints(without, 30).positions)
    np.testing.assert_array_equal(found.confidences[:, 9], np.where(np.isnan(without[:, 9, 0]), 0.0, 1.0))
    with pytest.raises(ValueError, match="zeros must be 'seen' or 'missing', got 'lost'"):
        load(write, LOST, zeros="lost")


@pytest.mark.parametrize("door", ARRAYS)
def test_arrays(door):
    (message,) = messages(ARRAYS[door], LOST)
    assert "10 positions (1.0 % of all) are exactly (0, 0, 0), of 'left_wrist'" in message
    assert "make them NaN: positions[(positions == 0).all(axis=2)] = np.nan" in message
    positions = LOST.copy()
    positions[(positions == 0).all(axis=2)] = np.nan
    assert messages(ARRAYS[door], positions) == []
    assert messages(ARRAYS[door], SEEN) == []


def test_what_is_not_seen_by_its_confidence_is_not_counted():
    sure = np.where((LOST == 0.0).all(axis=2), 0.0, 0.9)
    assert messages(COCO.keypoints, LOST, 30, sure) == []
    assert messages(Keypoints, LOST, COCO.names, 30, sure) == []
    assert messages(load, npz, np.concatenate([LOST, sure[:, :, None]], axis=2)) == []


def test_what_the_library_makes_of_keypoints_is_not_looked_at_again():
    keypoints = load(npz, LOST, layout=None, names=COCO.names, zeros="seen")
    assert messages(lambda: keypoints[10:].select(["left_wrist", "nose"]).fill_gaps()) == []
    assert messages(lambda: Keypoints.concatenate([keypoints, keypoints])) == []
    assert messages(COCO.keypoints, keypoints) == []


def test_the_origin_of_the_others_is_seen():
    """The pelvis of positions relative to it; but not in frames of zeros alone, in which nobody is seen."""
    for door in (lambda array: H36M.keypoints(array, 50), lambda array: load(npy, array, H36M)):
        assert messages(door, CENTRED) == []
        lost = CENTRED.copy()
        lost[7:9, 5] = 0.0
        assert f"2 positions (0.2 % of all) are exactly (0, 0, 0), of {H36M.names[5]!r}" in messages(door, lost)[0]
    empty = CENTRED.copy()
    empty[7:9] = 0.0
    assert f"{2 * 17} positions" in messages(H36M.keypoints, empty, 50)[0]
    found = load(npy, empty, H36M, zeros="missing")
    np.testing.assert_array_equal(np.isnan(found.positions).all(axis=(1, 2)), np.isin(np.arange(60), [7, 8]))
    np.testing.assert_array_equal(found.positions[0], CENTRED[0])


def test_several_points_may_be_the_origin():
    """As of rigs with joints in one place."""
    twice = CENTRED.copy()
    twice[:, 1] = 0.0
    assert messages(Keypoints, twice, H36M.names, 50, up="z") == []
    positions = np.zeros((5, 3, 3))
    positions[:, 2] = [0.0, 0.5, 0.0]
    assert messages(ARM.keypoints, positions, 25) == []


def test_a_point_that_is_never_seen_is_away_from_the_person():
    never = np.add(SEEN, [4.0, 0.0, 3.0])
    never[:, 9] = 0.0
    assert "60 positions (5.9 % of all)" in messages(COCO.keypoints, never, 30)[0]


def test_zeros_alone_say_nothing():
    assert messages(Keypoints, np.zeros((5, 2, 3)), ["hip", "knee"], 30) == []
    assert messages(Keypoints, np.full((5, 2, 3), np.nan), ["hip", "knee"], 30) == []
    assert messages(Keypoints, np.zeros((0, 2, 3)), ["hip", "knee"], 30) == []
