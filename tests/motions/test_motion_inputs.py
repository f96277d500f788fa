"""What may be motions, on which skeleton they are compared, and words for what may not."""

import re
from pathlib import Path

import numpy as np
import pandas as pd
import polars as pl
import pytest
from conftest import SKELETONS
from scipy.sparse import csr_array

from skpose import Motion, Skeleton, forward_kinematics, motion_distances
from skpose.datasets import MotionDataset, make_gait
from skpose.metrics import Spatial
from skpose.motions._inputs import check_motion, check_motions, check_single_motions

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
        list,
        tuple,
        lambda motions: iter(motions),
        lambda motions: [motion.tolist() for motion in motions],
        lambda motions: [np.asfortranarray(motion) for motion in motions],
        lambda motions: [np.repeat(motion, 2, axis=0)[::2] for motion in motions],
        lambda motions: [(m := motion.copy(), m.setflags(write=False))[0] for motion in motions],
        lambda motions: [pd.DataFrame(motion, columns=CHAIN.dof_names) for motion in motions],
        lambda motions: [pl.DataFrame(motion, schema=list(CHAIN.dof_names)) for motion in motions],
        lambda motions: pd.Series(motions),
        lambda motions: np.array([*motions, None], dtype=object)[:3],
    ],
    ids=[
        "list", "tuple", "iterator", "lists", "Fortran", "strided", "read-only",
        "pandas", "polars", "series of arrays", "array of arrays",
    ],
)  # fmt: skip
def test_all_kinds_of_lists_of_arrays(convert):
    np.testing.assert_array_equal(motion_distances(convert(X), skeleton=CHAIN), EXPECTED)
    np.testing.assert_array_equal(motion_distances(X, convert(X), skeleton=CHAIN).argmin(axis=1), [0, 1, 2])


@pytest.mark.parametrize("convert", [np.asarray, np.ndarray.tolist, np.asfortranarray, list])
def test_motions_of_equal_length_in_one_array(convert):
    expected = motion_distances(list(BLOCK), skeleton=CHAIN)
    np.testing.assert_array_equal(motion_distances(convert(BLOCK), skeleton=CHAIN), expected)


def test_whole_numbers_and_half_precision_are_computed_in_float64():
    whole = [np.array([[0, 1], [2, 3]]), np.array([[1, 1]])]
    D = motion_distances(whole, skeleton=CHAIN)
    assert D.dtype == np.float64
    np.testing.assert_array_equal(motion_distances([m.astype(np.float16) for m in whole], skeleton=CHAIN), D)


def test_the_arrays_stay_as_they_were():
    copies = [a.copy() for a in X]
    motion_distances(X, skeleton=CHAIN, normalize=False)
    for a, copy in zip(X, copies, strict=True):
        np.testing.assert_array_equal(a, copy)


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


def test_a_skeleton_that_is_given_is_the_one(gait):
    slow = at(gait, 6)
    skeleton = gait.skeleton.with_weights("mass")
    expected = motion_distances([motion.angles for motion in slow], skeleton=skeleton)
    np.testing.assert_array_equal(motion_distances(slow, skeleton=skeleton), expected)
    assert (expected != motion_distances(slow))[np.triu_indices(len(slow), 1)].all()


def test_weights_are_those_of_the_skeleton_of_the_motions(gait):
    slow = at(gait, 6)
    skeleton = slow[0].skeleton.with_weights(dict.fromkeys(slow[0].skeleton.joint_names[5:], 0))
    motions = [Motion(skeleton, motion.angles, motion.frame_rate) for motion in slow[:2]]
    D = motion_distances(motions, metric="position")
    F = [forward_kinematics(motion.angles, skeleton)[:, :5].reshape(len(motion), -1) for motion in motions]
    assert D[0, 1] <= np.linalg.norm(F[0] - F[1], axis=1).mean() / 2 + 1e-12
    np.testing.assert_array_equal(
        D, motion_distances([m.angles for m in motions], skeleton=skeleton, metric="position")
    )


def test_ball_joints(gait):
    slow = MotionDataset(at(gait, 6))
    euler, ball = motion_distances(slow, metric="rotation"), motion_distances(slow.to_rotvec(), metric="rotation")
    np.testing.assert_allclose(euler, ball, rtol=1e-9)


def test_rates_are_one_but_for_the_rounding_of_files(gait):
    a, b = at(gait, 12)[:2]
    rounded = Motion(b.skeleton, b.angles, 1 / round(1 / 12, 5))
    assert rounded.frame_rate != 12
    np.testing.assert_array_equal(motion_distances([a, rounded]), motion_distances([a, b]))
    for given in (([a, gait[1]],), ([a], [gait[1]])):
        with pytest.raises(
            ValueError, match=r"one frame rate.* X\[0\] has 12 Hz and .\[.\] 60 Hz: pass .*resample\(12\)"
        ):
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


MOTIONS = re.escape("X must be motions: a list of arrays (n_frames, n_dofs) or of skpose.Motion, got ")
ARRAY = re.escape("or an array (n_motions, n_frames, n_dofs), got an array of shape ")
ONE = re.escape("must be one motion, a skpose.Motion or an array (n_frames, n_dofs), got ")


@pytest.mark.parametrize(
    ("given", "error", "message"),
    [
        (X[0], ValueError, ARRAY + r"\(5, 2\): pass \[X\] for one motion, X\[:, None\] for motions of one frame"),
        (X[0].tolist(), ValueError, ARRAY + r"\(5, 2\): pass \[X\] for one motion"),
        (pd.DataFrame(X[0]), ValueError, ARRAY + r"\(5, 2\): pass \[X\] for one motion$"),
        (pl.DataFrame(X[0]), ValueError, ARRAY + r"\(5, 2\): pass \[X\] for one motion$"),
        (X[0][0], ValueError, ARRAY + r"\(2,\)$"),
        (BLOCK[None], ValueError, ARRAY + r"\(1, 3, 4, 2\)$"),
        (BLOCK[:0], ValueError, ARRAY + r"\(0, 4, 2\)$"),
        (BLOCK[:, :0], ValueError, r"X\[0\] has no frames: leave it out"),
        ([], ValueError, MOTIONS + "none"),
        ([X[0], X[0][:0]], ValueError, r"X\[1\] has no frames: leave it out"),
        ("walk.bvh", TypeError, MOTIONS + r"'walk\.bvh': skpose\.io\.load_motion\(path\) reads"),
        (Path("walk.bvh"), TypeError, MOTIONS + r".*walk\.bvh.*: skpose\.io\.load_motion\(path\) reads"),
        (["walk.bvh"], TypeError, r"X\[0\] " + ONE + r"'walk\.bvh': skpose\.io\.load_motion\(path\) reads"),
        ({"a": X[0]}, TypeError, MOTIONS + r"a dict: pass list\(X.values\(\)\)"),
        ([{"a": X[0]}], TypeError, r"X\[0\] " + ONE + "a dict$"),
        (None, TypeError, MOTIONS + "None"),
        (3, TypeError, MOTIONS + "3"),
        ([X[0], None], TypeError, r"X\[1\] " + ONE + "None"),
        ([1.0, 2.0], TypeError, r"X\[0\] " + ONE + r"1\.0"),
        ([X[0], X[1][0]], TypeError, r"X\[1\] " + ONE + r"an array of shape \(2,\)"),
        ([X[0][0], X[0]], TypeError, r"X\[0\] " + ONE + r"an array of shape \(2,\)"),
        ([[[1.0, 2.0], [1.0]]], TypeError, r"X\[0\] " + ONE + "a list of list"),
        (pd.DataFrame(X[0]).groupby([0, 0, 1, 1, 1]), TypeError, r"X\[0\] " + ONE + "a tuple of DataFrame and"),
        ([BLOCK], ValueError, r"X\[0\] must have shape \(n_poses, 2\), got \(3, 4, 2\)"),
        (CHAIN, TypeError, MOTIONS + "a Skeleton: pass it as skeleton="),
        ([CHAIN], TypeError, r"X\[0\] " + ONE + "a Skeleton: pass it as skeleton="),
        ([X[0], np.full((2, 2), np.nan)], ValueError, r"Input X\[1\] contains NaN"),
        ([X[0], np.full((2, 2), np.inf)], ValueError, r"Input X\[1\] contains infinity"),
        ([X[0], X[0] * 1j], ValueError, "Complex data not supported"),
        ([csr_array(X[0])], TypeError, r"Sparse data was passed for X\[0\]"),
        ([X[0], np.ones((2, 3))], ValueError, r"X\[1\] has 3 columns, but the skeleton has 2 degrees of freedom"),
        ([pd.DataFrame(X[0], columns=CHAIN.dof_names[::-1])], ValueError, r"columns of X\[0\].* order"),
        ([pl.LazyFrame(X[0])], TypeError, r"X\[0\] must be an array of poses, got a LazyFrame.*X\[0\]\.collect"),
    ],
    ids=lambda value: "" if isinstance(value, type) else None,
)  # fmt: skip
def test_what_is_no_list_of_motions_is_refused_in_words(given, error, message):
    with pytest.raises(error, match=message):
        motion_distances(given, skeleton=CHAIN)


def test_no_list_of_motions_but_one_or_datasets(gait):
    for given, message in (
        (gait[0], MOTIONS + r"one Motion: pass \[X\]"),
        ([gait, gait], r"X\[0\] " + ONE + r"a MotionDataset of 4: join datasets by \[\*first, \*second\]"),
        ([[gait[0]], [gait[1]]], r"X\[0\] " + ONE + "a list of Motion"),
        ([gait[0], gait[1].angles], r"X must be all .* 1 Motion, and 1 other, X\[1\] among them: pass motion\.angles"),
    ):
        with pytest.raises(TypeError, match=message):
            motion_distances(given)
    with pytest.raises(TypeError, match=r"X and Y must be all .* got 4 Motions, and 1 other, Y\[0\] among them"):
        motion_distances(gait, [gait[0].angles], skeleton=gait.skeleton)
    with pytest.raises(ValueError, match=r"X\[1\] has no frames: leave it out"):
        motion_distances([gait[0], gait[1][:0]])


def test_skeletons_that_do_not_fit_are_refused_by_the_name_of_the_motion(gait):
    with pytest.raises(ValueError, match=r"^X\[0\]: the motion's angles do not carry over to this skeleton"):
        motion_distances(list(gait), skeleton=CHAIN)
    other = Motion(CHAIN, X[0], 60)
    with pytest.raises(ValueError, match=r"X\[0\].*X\[1\]|X\[1\].*X\[0\]"):
        motion_distances([gait[0], other])
    with pytest.raises(TypeError, match=r"skeleton must be a skpose\.Skeleton, got "):
        motion_distances(X, skeleton="chain")


def test_widths_without_a_skeleton():
    wide = np.ones((2, 3))
    with pytest.raises(ValueError, match=r"X\[0\] has 2 columns and X\[1\] has 3; poses of one skeleton"):
        motion_distances([X[0], wide], metric="angle")
    with pytest.raises(ValueError, match="X has 2 columns and Y has 3; poses of one skeleton"):
        motion_distances(X, [wide], metric="angle")
    with pytest.raises(ValueError, match="the metric 'position' needs a skeleton"):
        motion_distances(X, metric="position")


@pytest.mark.parametrize(
    ("parameters", "message"),
    [
        ({"window": 1.5}, r"'window' parameter .* range \[0.0, 1.0\] or None"),
        ({"window": np.nan}, "'window' parameter"),
        ({"window": 0.1, "alignment": "frames"}, 'window is the band of alignment="dtw", got window=0.1'),
        ({"alignment": "subsequence", "window": 0}, 'window is the band of alignment="dtw", got window=0 with'),
        ({"alignment": "open"}, "'alignment' parameter"),
        ({"alignment": "frames"}, r"equal length, but X\[0\] has 5 frames and X\[1\] 7: resample them, or take"),
        ({"alignment": "frames", "Y": X[1:], "X": X[:1]}, r"X\[0\] has 5 frames and Y\[0\] 7"),
        ({"metric": "euclidean"}, "'metric' parameter"),
        ({"metric": Spatial(0)}, "'n_steps' parameter of Spatial"),
        ({"normalize": "yes"}, "'normalize' parameter"),
    ],
)
def test_parameters_are_checked(parameters, message):
    with pytest.raises(ValueError, match=message):
        motion_distances(**{"X": X, "skeleton": CHAIN} | parameters)


def test_rows_are_motions_of_one_frame_for_estimators():
    (checked,) = check_motions({"X": X[0]}, CHAIN, rows=True)
    np.testing.assert_array_equal(checked.sequences.poses, X[0])
    np.testing.assert_array_equal(checked.sequences.lengths, 1)


def test_one_motion_where_one_belongs(gait):
    for given, skeleton in ((X[0], CHAIN), (X[0].tolist(), CHAIN), (pd.DataFrame(X[0]), CHAIN), (gait[0], None)):
        checked = check_motion(given, skeleton, "query")
        assert checked.sequences.n_motions == 1
        np.testing.assert_array_equal(checked.sequences.motion(0), getattr(given, "angles", given))
        assert checked.skeleton == (skeleton or gait[0].skeleton)
        assert checked.frame_rate == (None if skeleton else 60)
    for given, message in (
        (gait, r"^query " + ONE + r"a MotionDataset of 4: pass one of them, such as query\[0\]"),
        ([gait[0]], r"^query " + ONE + r"a list of Motion: pass one of them, such as query\[0\]"),
        (X, r"^query " + ONE + r"a list of ndarray: pass one of them, such as query\[0\]"),
        (BLOCK, r"^query " + ONE + r"an array of shape \(3, 4, 2\): pass one of them, such as query\[0\]"),
        (X[0][0], r"^query " + ONE + r"an array of shape \(2,\)$"),
        ("walk.bvh", r"^query " + ONE + r"'walk\.bvh': skpose\.io\.load_motion"),
    ):
        with pytest.raises(TypeError, match=message):
            check_motion(given, CHAIN, "query")
    with pytest.raises(ValueError, match=r"^query has no frames: leave it out"):
        check_motion(X[0][:0], CHAIN, "query")
    with pytest.raises(ValueError, match=r"^Input query contains NaN"):
        check_motion(X[0] * np.nan, CHAIN, "query")


def test_motions_that_are_given_one_by_one_have_one_skeleton(gait):
    a, b = check_single_motions({"a": gait[0], "b": gait[2]}, None)
    assert a.skeleton == b.skeleton == Skeleton.mean([gait[0].skeleton, gait[2].skeleton])
    with pytest.raises(TypeError, match=r"^a and b must be all skpose\.Motion or all arrays.*, b among them"):
        check_single_motions({"a": gait[0], "b": gait[2].angles}, None)
    with pytest.raises(ValueError, match=r"b has 12 Hz and a 60 Hz|a has 60 Hz and b 12 Hz"):
        check_single_motions({"a": gait[0], "b": gait[2].resample(12)}, None)


@pytest.mark.parametrize("name", SKELETONS)
def test_every_kind_of_skeleton(name):
    skeleton = SKELETONS[name]
    motions = [RNG.normal(size=(n, skeleton.n_dofs)) for n in (2, 3)]
    D = motion_distances(motions, skeleton=skeleton)
    as_motions = [Motion(skeleton, angles, 30) for angles in motions]
    np.testing.assert_array_equal(motion_distances(as_motions), D)
