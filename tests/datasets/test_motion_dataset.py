"""A MotionDataset is a sequence of motions with labels."""

import pickle

import numpy as np
import pandas as pd
import polars as pl
import pytest

from skpose import Skeleton
from skpose.datasets import MotionDataset, make_gait

GAIT = make_gait(3, 1, random_state=0)
ARM = Skeleton.chain(2)


def same(a, b):
    return len(a) == len(b) and all(x is y for x, y in zip(a, b, strict=True))


def test_a_number_gives_a_motion():
    assert GAIT[0] is GAIT.motions[0]
    assert GAIT[-1] is GAIT.motions[5]
    assert GAIT[np.int64(2)] is GAIT.motions[2]
    assert list(GAIT) == list(GAIT.motions)
    with pytest.raises(IndexError):
        GAIT[6]


@pytest.mark.parametrize(
    "chosen",
    [
        slice(None, None, -2), np.array([5, -1]), [], GAIT.actions == "walk", pd.Series(GAIT.actions) == "run",
        pl.Series(GAIT.actions.tolist()) == "run",
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


def test_labels_are_optional():
    bare = MotionDataset(GAIT.motions)
    assert repr(bare) == "MotionDataset(6 motions)"
    assert repr(MotionDataset(GAIT.motions, GAIT.subjects)) == "MotionDataset(6 motions of 3 subjects)"
    assert repr(MotionDataset(GAIT.motions, actions=GAIT.actions)) == "MotionDataset(6 motions: 3 run, 3 walk)"
    for a, b in zip(bare.poses(12), GAIT.poses(12), strict=True):
        np.testing.assert_array_equal(a, b)
    assert bare.skeleton == GAIT.skeleton
    for other in (bare.with_root(), bare[:2], bare.retarget(GAIT.skeleton)):
        assert not hasattr(other, "subjects")
    labelled = MotionDataset(GAIT.motions, trials=GAIT.trials)[[1, 0]]
    np.testing.assert_array_equal(labelled.trials, GAIT.trials[[1, 0]])
    assert pickle.loads(pickle.dumps(GAIT)).actions.tolist() == GAIT.actions.tolist()
