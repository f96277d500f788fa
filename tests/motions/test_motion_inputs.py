"""Forms of motions, the skeleton on which they are compared, and refused input."""

import numpy as np
import pandas as pd
import polars as pl
import pytest
from conftest import SKELETONS

from skpose import Motion, Skeleton, motion_distances
from skpose.datasets import MotionDataset, make_gait
from skpose.motions import find_motion

CHAIN = Skeleton.chain(2)
RNG = np.random.default_rng(0)
X = [RNG.normal(size=(n, 2)) for n in (5, 7, 3)]
BLOCK = RNG.normal(size=(3, 4, 2))
EXPECTED = motion_distances(X, skeleton=CHAIN)


@pytest.fixture(scope="module")
def gait():
    """Two people with bones of different lengths, at 60 Hz."""
    return make_gait(2, 1, random_state=0)


def at(dataset, rate):
    return [motion.resample(rate) for motion in dataset]


@pytest.mark.parametrize(
    "convert",
    [
        iter,
        lambda motions: [motion.tolist() for motion in motions],
        lambda motions: [np.asfortranarray(motion) for motion in motions],
        lambda motions: [pd.DataFrame(motion, columns=CHAIN.dof_names) for motion in motions],
        lambda motions: [pl.DataFrame(motion, schema=list(CHAIN.dof_names)) for motion in motions],
        pd.Series,
        lambda motions: np.array([*motions, None], dtype=object)[:3],
    ],
    ids=["iterator", "lists", "Fortran", "pandas", "polars", "series of arrays", "array of arrays"],
)
def test_all_kinds_of_lists_of_arrays(convert):
    np.testing.assert_array_equal(motion_distances(convert(X), skeleton=CHAIN), EXPECTED)
    np.testing.assert_array_equal(motion_distances(X, convert(X), skeleton=CHAIN).argmin(axis=1), [0, 1, 2])


def test_datasets_and_lists_of_motions_are_compared_on_the_mean_skeleton(gait):
    slow = at(gait, 6)
    dataset = MotionDataset(slow)
    assert len({motion.skeleton for motion in slow}) > 1
    expected = motion_distances([motion.angles for motion in slow], skeleton=gait.skeleton)
    for given in (dataset, slow, tuple(slow)):
        np.testing.assert_array_equal(motion_distances(given), expected)
    both = motion_distances(dataset[:1], dataset[1:])
    np.testing.assert_allclose(both, expected[:1, 1:], rtol=1e-10)  # one mean of X and Y
    alone = motion_distances(slow[:1], slow[:1])
    own = motion_distances([slow[0].angles], [slow[0].angles], skeleton=slow[0].skeleton)
    np.testing.assert_array_equal(alone, own)


def test_ball_joints():
    slow = at(make_gait(2, 1, rotations="file", random_state=0), 6)
    euler, ball = motion_distances(slow, metric="rotation"), motion_distances(MotionDataset(slow), metric="rotation")
    np.testing.assert_allclose(euler, ball, rtol=1e-9)


def test_rates_are_one_but_for_the_rounding_of_files(gait):
    a, b = at(gait, 12)[:2]
    rounded = Motion(b.skeleton, b.angles, 1 / round(1 / 12, 5))
    assert rounded.frame_rate != 12
    np.testing.assert_array_equal(motion_distances([a, rounded]), motion_distances([a, b]))
    for given in (([a, gait[1]],), ([a], [gait[1]])):
        with pytest.raises(ValueError, match="60 Hz"):
            motion_distances(*given)


def test_degrees_are_warned_of_once_and_by_name():
    degrees = [np.degrees(a) * 3 for a in X]
    with pytest.warns(UserWarning, match=r"values of X reach .* if they are in degrees") as found:
        motion_distances(degrees, degrees[:1], skeleton=CHAIN)
    assert len(found) == 1
    assert found[0].filename == __file__
    with pytest.warns(UserWarning, match="values of Y reach"):
        motion_distances(X, degrees, skeleton=CHAIN)
    motion_distances(degrees, metric="angle")  # whose distance has the unit of the columns


@pytest.mark.parametrize("name", SKELETONS)
def test_every_kind_of_skeleton(name):
    skeleton = SKELETONS[name]
    motions = [RNG.normal(size=(n, skeleton.n_dofs)) for n in (2, 3)]
    D = motion_distances(motions, skeleton=skeleton)
    as_motions = [Motion(skeleton, angles, 30) for angles in motions]
    np.testing.assert_array_equal(motion_distances(as_motions), D)


def test_motions_of_equal_length_in_one_array():
    block = RNG.normal(size=(3, 4, 2))
    expected = motion_distances(list(block), skeleton=CHAIN)
    np.testing.assert_array_equal(motion_distances(block, skeleton=CHAIN), expected)
    np.testing.assert_array_equal(motion_distances(block.tolist(), skeleton=CHAIN), expected)


@pytest.mark.parametrize(
    ("given", "error", "match"),
    [
        (Motion(CHAIN, X[0], 60), TypeError, "X must be a list of motions"),
        ("walk.bvh", TypeError, "X must be a list of motions"),
        (X[0], ValueError, "X must be a list of motions"),
        ([], ValueError, "X must be a list of motions"),
        ([X[0], Motion(CHAIN, X[1], 60)], TypeError, "all Motion objects or all arrays"),
        ([X[0], X[0][:0]], ValueError, r"X\[1\]|minimum of 1"),
        ([X[0], np.ones((2, 3))], ValueError, r"X\[1\] has 3 columns"),
        ([X[0], X[0] * np.nan], ValueError, r"X\[1\] contains NaN"),
        ([Motion(Skeleton.chain(3), np.zeros((2, 3)), 60)], ValueError, r"X\[0\]"),
    ],
)
def test_other_input_is_refused_by_name(given, error, match):
    with pytest.raises(error, match=match):
        motion_distances(given, skeleton=CHAIN)


@pytest.mark.parametrize("given", [[X[0]], np.zeros((1, 2, 2)), MotionDataset([Motion(CHAIN, X[0], 60)])], ids=type)
def test_several_motions_where_one_belongs_are_refused(given):
    with pytest.raises(TypeError, match="query must be one motion"):
        find_motion(given, X, skeleton=CHAIN)


@pytest.mark.parametrize(
    ("parameters", "match"),
    [
        ({"window": 1.5}, "window"),
        ({"window": 0.1, "alignment": "frames"}, "window"),
        ({"alignment": "frames"}, "equal length"),
        ({"metric": "euclidean"}, "metric"),
        ({"metric": "spatial", "skeleton": None}, "skeleton"),
    ],
)
def test_parameters_are_checked(parameters, match):
    with pytest.raises(ValueError, match=match):
        motion_distances(**{"X": X, "skeleton": CHAIN} | parameters)
