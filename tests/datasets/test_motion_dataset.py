"""A MotionDataset is a sequence of motions with the labels that they have."""

import pickle

import numpy as np
import pandas as pd
import polars as pl
import pytest

from skpose import Motion, Skeleton, pose_distances
from skpose._cli.studies.compare import prepare
from skpose.datasets import MotionDataset, make_gait, walks_and_runs

GAIT = make_gait(3, 1, random_state=0)
ARM = Skeleton.chain(2)


def same(a, b):
    return len(a) == len(b) and all(x is y for x, y in zip(a, b, strict=True))


def test_a_number_gives_a_motion():
    assert GAIT[0] is GAIT.motions[0]
    assert GAIT[-1] is GAIT.motions[5]
    assert GAIT[np.int64(2)] is GAIT.motions[2]
    assert list(GAIT) == list(GAIT.motions)
    for outside in (6, -7):
        with pytest.raises(IndexError, match=f"the dataset has 6 motions, and no motion {outside}"):
            GAIT[outside]


@pytest.mark.parametrize(
    "chosen",
    [
        slice(2, 5), slice(None, None, -2), [0, 3], np.array([5, -1]), [], GAIT.actions == "walk",
        list(GAIT.actions == "run"), pd.Series(GAIT.actions) == "run", pl.Series(GAIT.actions.tolist()) == "run",
    ],
    ids=str,
)  # fmt: skip
def test_everything_else_gives_a_dataset(chosen):
    part = GAIT[chosen]
    assert isinstance(part, MotionDataset)
    rows = np.arange(6)[chosen if isinstance(chosen, slice) else np.asarray(chosen, dtype=None if len(chosen) else int)]
    assert same(part, [GAIT.motions[row] for row in rows])
    for name in ("subjects", "trials", "actions"):
        np.testing.assert_array_equal(getattr(part, name), getattr(GAIT, name)[rows])


@pytest.mark.parametrize("chosen", ["walk", 1.0, None, True, [0.5], ["a"], [[0, 1]]], ids=str)
def test_other_keys_are_refused_in_words(chosen):
    with pytest.raises(TypeError, match=r'such as dataset\[dataset\.actions == "walk"\], got '):
        GAIT[chosen]


def test_masks_and_indices_that_do_not_fit():
    with pytest.raises(IndexError, match="a mask must have one value for each of the 6 motions, got 2"):
        GAIT[[True, False]]
    with pytest.raises(IndexError, match="the dataset has 6 motions, and no motion 6"):
        GAIT[[0, 6]]


def test_labels_are_optional():
    bare = MotionDataset(GAIT.motions)
    assert repr(bare) == "MotionDataset(6 motions)"
    assert repr(MotionDataset(GAIT.motions, GAIT.subjects)) == "MotionDataset(6 motions of 3 subjects)"
    assert repr(MotionDataset(GAIT.motions, actions=GAIT.actions)) == "MotionDataset(6 motions: 3 run, 3 walk)"
    for a, b in zip(bare.poses(12), GAIT.poses(12), strict=True):
        np.testing.assert_array_equal(a, b)
    assert bare.skeleton == GAIT.skeleton
    for other in (bare.to_rotvec(), bare.with_root(), bare[:2], bare.retarget(GAIT.skeleton)):
        assert not hasattr(other, "subjects")
    labelled = MotionDataset(GAIT.motions, trials=GAIT.trials).to_rotvec()[[1, 0]]
    np.testing.assert_array_equal(labelled.trials, GAIT.trials[[1, 0]])
    assert pickle.loads(pickle.dumps(GAIT)).actions.tolist() == GAIT.actions.tolist()


@pytest.mark.parametrize("missing", [None, np.nan, pd.NA], ids=str)
def test_a_missing_label_is_no_word(missing):
    labels = pd.Series(["a", "b", missing, "c", "d", "e"], dtype=object)
    with pytest.raises(ValueError, match=r"actions has no label for motions\[2\], but (None|nan|<NA>): use a word"):
        MotionDataset(GAIT.motions, actions=labels)


@pytest.mark.parametrize("name", ["subjects", "trials", "actions"])
def test_labels_that_are_missing_are_refused_in_words(name):
    bare = MotionDataset(GAIT.motions)
    with pytest.raises(AttributeError, match=f"the dataset has no {name}: pass one label for each motion"):
        getattr(bare, name)


def test_what_needs_labels_says_so():
    with pytest.raises(AttributeError, match="the dataset has no actions"):
        walks_and_runs(MotionDataset(GAIT.motions))
    unknown = MotionDataset(GAIT.motions, actions=GAIT.actions)
    assert same(walks_and_runs(unknown), GAIT)
    with pytest.raises(AttributeError, match="the dataset has no subjects"):
        prepare(unknown)


def test_labels_come_as_any_array():
    for convert in (list, np.array, pd.Series, pl.Series):
        dataset = MotionDataset(GAIT.motions, convert(range(6)), convert([f"{i:02}" for i in range(6)]))
        assert dataset.subjects.tolist() == list("012345")
        assert dataset.trials[1] == "01"


def test_motions_are_motions():
    with pytest.raises(TypeError, match="motions must be a sequence of Motions, got a Motion: put it into a list"):
        MotionDataset(GAIT[0])
    with pytest.raises(TypeError, match=r"motions\[1\] must be a skpose.Motion, got Skeleton"):
        MotionDataset([GAIT[0], GAIT[0].skeleton])


def test_a_dataset_without_motions():
    empty = GAIT[[]]
    assert len(empty) == 0
    assert list(empty) == []
    with pytest.raises(ValueError, match="the dataset has no motions, and so no poses"):
        empty.poses()


@pytest.mark.parametrize("rate", ["12", "a", 0, -1, np.nan, [12], True, None.__class__])
def test_a_frame_rate_is_a_positive_number(rate):
    message = r"frame_rate must be a positive number of Hz, got "
    with pytest.raises(ValueError, match=message):
        GAIT.poses(rate)
    with pytest.raises(ValueError, match=message):
        GAIT[0].resample(rate)
    with pytest.raises(ValueError, match=message):
        Motion(ARM, np.zeros((2, 2)), rate)


@pytest.mark.parametrize("rate", [12, 12.0, np.float32(12), np.array(12), np.int16(12)])
def test_any_number_is_a_frame_rate(rate):
    assert len(GAIT[0].resample(rate)) == len(GAIT[0].resample(12.0))


def test_a_dataset_is_no_array_of_poses():
    for X in (GAIT, [GAIT]):
        with pytest.raises(TypeError, match=r"X must be an array of poses, got a MotionDataset: pass dataset\.poses"):
            pose_distances(X, skeleton=GAIT.skeleton)
    with pytest.raises(TypeError, match=r"a MotionDataset is no array: pass its poses, dataset\.poses"):
        np.asarray(GAIT)
