"""Keypoints from arrays of numpy: keys, shapes, layouts, and what is refused."""

import io
from dataclasses import replace

import numpy as np
import pytest

from skpose.io import MocapFormatError, load_keypoints
from skpose.keypoints import Keypoints, Layout, layouts

NAMES = ["hip", "knee", "ankle"]
POSITIONS = np.random.default_rng(3).uniform(-0.8, 0.8, (12, 3, 3))
POSITIONS[4, 1, 2] = np.nan
SCORES = np.random.default_rng(4).uniform(0.1, 1.0, (12, 3))
SCORES[5, 0] = 0.0


def npy(array):
    file = io.BytesIO()
    np.save(file, array)
    return io.BytesIO(file.getvalue())


def npz(save=np.savez, **arrays):
    file = io.BytesIO()
    save(file, **arrays)
    return io.BytesIO(file.getvalue())


LAYOUT = Layout(
    "three",
    names=NAMES,
    parents={NAMES[0]: None, NAMES[1]: NAMES[0], NAMES[2]: NAMES[1], "middle": NAMES[0]},
    midpoints={"middle": (NAMES[0], NAMES[1])},
    up="z",
)


def same(found, expected):
    np.testing.assert_array_equal(found.positions, expected.positions)
    np.testing.assert_array_equal(found.confidences, expected.confidences)
    assert (found.names, found.frame_rate, found.up) == (expected.names, expected.frame_rate, expected.up)


def refused(file, match, **options):
    with pytest.raises(MocapFormatError):
        load_keypoints(file, **({"names": NAMES, "frame_rate": 25} | options))


@pytest.mark.parametrize("dtype", [np.float64, np.float32, ">f8", np.float16])
@pytest.mark.parametrize("order", ["C", "F"])
def test_arrays(dtype, order):
    array = np.asarray(POSITIONS.astype(dtype), order=order)
    same(load_keypoints(npy(array), names=NAMES, frame_rate=25), Keypoints(array, NAMES, 25))


def test_keys(tmp_path):
    expected = Keypoints(POSITIONS, NAMES, 30, SCORES)
    for positions in ("positions", "keypoints"):
        for confidences in ("confidences", "scores"):
            for rate in ("frame_rate", "fps"):
                arrays = {positions: POSITIONS, confidences: SCORES, rate: 30, "names": NAMES, "other": [object()]}
                same(load_keypoints(npz(**arrays)), expected)
                same(load_keypoints(npz(np.savez_compressed, **arrays)), expected)
    np.savez(tmp_path / "a.npz", positions=POSITIONS, scores=SCORES, fps=[30.0], names=np.array(NAMES, "S"))
    same(load_keypoints(tmp_path / "a.npz"), expected)
    with pytest.warns(UserWarning, match="replaces the 30 Hz"):
        given = load_keypoints(tmp_path / "a.npz", frame_rate=60, names=["a", "b", "c"], up="x")
    assert (given.frame_rate, given.names, given.up) == (60, ("a", "b", "c"), "x")


@pytest.mark.parametrize("twice", [{"keypoints": POSITIONS}, {"fps": 30}, {"scores": SCORES}])
def test_two_keys_of_the_same_are_refused(twice):
    refused(npz(positions=POSITIONS, frame_rate=30, confidences=SCORES, **twice), "both")


def test_a_fourth_number_is_the_confidence():
    array = np.concatenate([POSITIONS, SCORES[:, :, None]], axis=2)
    expected = Keypoints(POSITIONS, NAMES, 25, SCORES)
    same(load_keypoints(npy(array), names=NAMES, frame_rate=25), expected)
    same(load_keypoints(npz(keypoints=array), names=NAMES, frame_rate=25), expected)
    refused(npz(keypoints=array, scores=SCORES), "confidences")
    assert np.isnan(expected.positions[5, 0]).all()


def test_layouts():
    expected = LAYOUT.keypoints(POSITIONS, 25.0, SCORES)
    file = {"positions": POSITIONS, "scores": SCORES, "fps": 25.0}
    same(load_keypoints(npz(**file), LAYOUT), expected)
    coco = np.random.default_rng(0).normal(0, 0.4, size=(3, 17, 3))
    same(load_keypoints(npz(positions=coco, fps=25.0), "coco17"), layouts["coco17"].keypoints(coco, 25.0))
    same(load_keypoints(npz(**file), LAYOUT, up="-z"), replace(LAYOUT, up="-z").keypoints(POSITIONS, 25.0, SCORES))
    with pytest.raises(ValueError, match="layout"):
        load_keypoints(npz(**file), "coco")
    with pytest.raises(MocapFormatError):
        load_keypoints(npz(**file), LAYOUT, names=["hip", "knee"])


def test_two_dimensions_are_refused_in_words():
    message = (
        r"found \(12, 3, 2\): these are keypoints in two dimensions\. Lengths of bones are not known from a picture"
    )
    refused(npy(POSITIONS[:, :, :2]), message)
    refused(npz(keypoints=POSITIONS[:, :, :2]), message)


def test_what_is_missing():
    with pytest.raises(ValueError, match="frame_rate="):
        load_keypoints(npy(POSITIONS), names=NAMES)
    with pytest.raises(ValueError, match="layout="):
        load_keypoints(npy(POSITIONS), frame_rate=25)


def test_the_files_own_names_are_brought_into_the_order_of_the_layout(tmp_path):
    layout, positions = layouts["coco17"], np.random.default_rng(0).normal(0, 0.4, size=(4, 17, 3))
    np.savez(tmp_path / "a.npz", positions=positions, names=layout.names[::-1], fps=25)
    found = load_keypoints(tmp_path / "a.npz", layout)
    np.testing.assert_array_equal(found.positions[:, :17], positions[:, ::-1])
    np.savez(tmp_path / "b.npz", positions=positions, names=[*layout.names[:-1], "tail"], fps=25)
    with pytest.raises(MocapFormatError):
        load_keypoints(tmp_path / "b.npz", layout)
