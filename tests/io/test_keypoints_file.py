"""Keypoints from arrays of numpy: keys, shapes, layouts, and what is refused."""

import gzip
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
    with pytest.raises(MocapFormatError, match=match):
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
    given = load_keypoints(tmp_path / "a.npz", frame_rate=60, names=["a", "b", "c"], up="x")
    assert (given.frame_rate, given.names, given.up) == (60, ("a", "b", "c"), "x")


def test_a_fourth_number_is_the_confidence():
    array = np.concatenate([POSITIONS, SCORES[:, :, None]], axis=2)
    expected = Keypoints(POSITIONS, NAMES, 25, SCORES)
    same(load_keypoints(npy(array), names=NAMES, frame_rate=25), expected)
    same(load_keypoints(npz(keypoints=array), names=NAMES, frame_rate=25), expected)
    refused(npz(keypoints=array, scores=SCORES), "confidences are given twice")
    assert np.isnan(expected.positions[5, 0]).all()


def test_flags_of_coco_are_seen_or_not():
    flags = np.random.default_rng(5).integers(0, 3, SCORES.shape)
    flags[0, 0] = 2
    expected = Keypoints(POSITIONS, NAMES, 25, np.minimum(flags, 1))
    same(load_keypoints(npz(positions=POSITIONS, scores=flags), names=NAMES, frame_rate=25), expected)
    array = np.concatenate([POSITIONS, flags[:, :, None]], axis=2)
    same(load_keypoints(npy(array), names=NAMES, frame_rate=25), expected)
    refused(npz(positions=POSITIONS, scores=100 * SCORES), "COCO's 0, 1 and 2; found .*: divide percent by 100")


def test_not_seen():
    found = load_keypoints(
        npz(positions=POSITIONS, scores=np.where(SCORES == 0, np.nan, SCORES)), names=NAMES, frame_rate=1
    )
    same(found, Keypoints(POSITIONS, NAMES, 1, SCORES))
    assert np.isnan(found.positions[[4, 5], [1, 0]]).all()


def test_layouts():
    expected = LAYOUT.keypoints(POSITIONS, 25.0, SCORES)
    file = {"positions": POSITIONS, "scores": SCORES, "fps": 25.0}
    same(load_keypoints(npz(**file), LAYOUT), expected)
    coco = np.random.default_rng(0).normal(size=(3, 17, 3))
    same(load_keypoints(npz(positions=coco, fps=25.0), "coco17"), layouts["coco17"].keypoints(coco, 25.0))
    with pytest.raises(ValueError, match=r"layout must be one of body25, .*, got 'coco'"):
        load_keypoints(npz(**file), "coco")
    with pytest.raises(TypeError, match="layout must be a Layout or the name of one, got int"):
        load_keypoints(npz(**file), 17)
    same(load_keypoints(npz(**file), LAYOUT, up="-z"), replace(LAYOUT, up="-z").keypoints(POSITIONS, 25.0, SCORES))
    other = [2, 0, 1]
    given = load_keypoints(
        npz(positions=POSITIONS[:, other], scores=SCORES[:, other]),
        LAYOUT,
        names=["Ankle", "HIP", "knee"],
        frame_rate=25,
    )
    same(given, expected)
    refused(npz(**file), "there are 2 names, and 3 points", layout=LAYOUT, names=["hip", "knee"])
    refused(npy(POSITIONS[:, :2]), "2 points, and the layout 'three' has 3", layout=LAYOUT, names=None)


def test_scale_and_its_warning():
    np.testing.assert_array_equal(
        load_keypoints(npy(POSITIONS * 1000), names=NAMES, frame_rate=25, scale=0.001).positions,
        Keypoints(POSITIONS * 1000 * 0.001, NAMES, 25).positions,
    )
    with pytest.warns(UserWarning, match=r"the points are .* if the file is in millimetres, pass scale=0.001"):
        load_keypoints(npy(POSITIONS * 1000), names=NAMES, frame_rate=25)
    with pytest.raises(ValueError, match="scale must be a positive number, got -1"):
        load_keypoints(npy(POSITIONS), names=NAMES, frame_rate=25, scale=-1)


def test_two_dimensions_are_refused_in_words():
    message = (
        r"found \(12, 3, 2\): these are keypoints in two dimensions\. Lengths of bones are not known from a picture"
    )
    refused(npy(POSITIONS[:, :, :2]), message)
    refused(npz(keypoints=POSITIONS[:, :, :2]), message)


def test_what_is_missing():
    with pytest.raises(ValueError, match="does not state its frame rate: pass frame_rate="):
        load_keypoints(npy(POSITIONS), names=NAMES)
    with pytest.raises(ValueError, match="does not name its points: pass layout=, or names="):
        load_keypoints(npy(POSITIONS), frame_rate=25)
    with pytest.raises(ValueError, match="frame_rate must be a positive number of Hz, got 0"):
        load_keypoints(npy(POSITIONS), names=NAMES, frame_rate=0)


class Bomb:
    def __reduce__(self):
        return pytest.fail, ("a file was unpickled",)


@pytest.mark.parametrize(
    ("file", "message"),
    [
        (npy(POSITIONS.reshape(12, 9)), r"the array: expected shape \(n, n, 3\) or \(n, n, 4\), found \(12, 9\)"),
        (npy(np.array([[["a"] * 3]])), "the array: expected numbers, found an array of dtype <U1"),
        (npy(np.array([Bomb()], dtype=object)), "the array: expected numbers, found a pickled object"),
        (npy(np.full((2, 3, 3), np.inf)), "positions are infinite at frame 0, point 0"),
        (npy(POSITIONS[:, :2]), r"positions must have shape \(n_frames, 3, 3\), got \(12, 2, 3\)"),
        (npz(keypoints=np.array([Bomb()], dtype=object)), "keypoints: expected numbers, found a pickled object"),
        (npz(poses=POSITIONS), "it has no positions or keypoints; its keys are poses"),
        (npz(positions=POSITIONS, keypoints=POSITIONS), "it has both positions and keypoints: keep one of them"),
        (npz(positions=POSITIONS, scores=SCORES[1:]), r"scores: expected shape \(12, 3\), found \(11, 3\)"),
        (npz(positions=POSITIONS, scores=SCORES + 1), "confidences must be from 0, not seen, to 1"),
        (npz(positions=POSITIONS, fps=-1.0), "fps: expected a positive number, found -1"),
        (npz(positions=POSITIONS, names="hip"), r"names: expected shape \(n,\), found \(\)"),
        (
            io.BytesIO(npy(POSITIONS).getvalue()[:-1]),
            "its header states 864 bytes of data, .* and there are 863; is the",
        ),
        (io.BytesIO(npy(POSITIONS).getvalue() + b"\0"), "states 864 bytes of data, .* and there are 865"),
        (io.BytesIO(npy(POSITIONS).getvalue().replace(b"(12, 3, 3)", b"(9999999999999, 9999999, 3)")), "header|states"),
        (io.BytesIO(npz(positions=POSITIONS).getvalue()[:-40]), "the archive: damaged or cut short"),
        (io.BytesIO(gzip.compress(npy(POSITIONS).getvalue())[:-9]), "its gzip compression is damaged"),
        (
            io.BytesIO(b"hello"),
            r"expected keypoints as JSON, CSV with a header, \.npz or \.npy, found 'hello', which begins none",
        ),
        (io.BytesIO(b""), "the file is empty, not keypoints as JSON"),
    ],
)
def test_what_is_refused(file, message):
    refused(file, message, names=None if "names:" in message else NAMES)


def test_the_files_own_names_are_brought_into_the_order_of_the_layout(tmp_path):
    layout, positions = layouts["coco17"], np.random.default_rng(0).normal(size=(4, 17, 3))
    np.savez(tmp_path / "a.npz", positions=positions, names=layout.names[::-1], fps=25)
    found = load_keypoints(tmp_path / "a.npz", layout)
    np.testing.assert_array_equal(found.positions[:, :17], positions[:, ::-1])
    np.savez(tmp_path / "b.npz", positions=positions, names=[*layout.names[:-1], "tail"], fps=25)
    with pytest.raises(
        MocapFormatError, match=r"it has no point 'right_ankle', as the layout 'coco17'.*without\(\['right_ankle'\]\)"
    ):
        load_keypoints(tmp_path / "b.npz", layout)


@pytest.mark.parametrize(
    ("options", "message"), [({"layout": "h36m"}, "layout must be one of"), ({"up": "w"}, "up must")]
)
def test_a_wrong_argument_is_no_fault_of_the_file(options, message):
    with pytest.raises(ValueError, match=message) as caught:
        load_keypoints("no such file.npy", frame_rate=5, **options)
    assert not isinstance(caught.value, MocapFormatError)
