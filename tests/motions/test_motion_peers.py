"""Dynamic time warping against aeon and dtaidistance, on their conventions and on ours; see the extra "peers"."""

import numpy as np
import pytest
from conftest import SKELETONS

from skpose import forward_kinematics, motion_distances, pose_distances
from skpose._compiled.warping.paths import Paths, accumulate

aeon = pytest.importorskip("aeon.distances")
dtw_ndim = pytest.importorskip("dtaidistance.dtw_ndim")

SKELETON = SKELETONS["humanoid"]
LENGTHS = [40, 1, 25, 130, 64]
pytestmark = pytest.mark.filterwarnings("ignore:unsafe cast from uint64 to int64")  # by numba, of aeon's own code


@pytest.fixture(scope="module")
def motions():
    rng = np.random.default_rng(0)
    return [np.cumsum(rng.normal(0, 0.1, size=(n, SKELETON.n_dofs)), axis=0) for n in LENGTHS]


@pytest.fixture(scope="module")
def positions(motions):
    """Joint positions (n_frames, 3 n_joints) of each motion: the Euclidean distance of two rows is "position"."""
    return [forward_kinematics(X, SKELETON).reshape(len(X), -1) for X in motions]


@pytest.fixture(scope="module")
def sums(motions):
    """Least sums of the distances, not squared."""
    return motion_distances(motions, skeleton=SKELETON, metric="position", normalize=False)


@pytest.fixture(scope="module")
def sums_of_squares(motions):
    """Least sums of squared distances, by our recursion."""
    D = np.zeros((len(motions), len(motions)))
    for i, a in enumerate(motions):
        for j, b in enumerate(motions):
            costs = pose_distances(a, b.copy(), skeleton=SKELETON, metric="position") ** 2
            accumulate(costs, Paths(1.0, False))
            D[i, j] = costs[-1, -1]
    return D


def test_aeon_sums_squared_distances(positions, sums_of_squares):
    theirs = aeon.dtw_pairwise_distance([np.ascontiguousarray(p.T) for p in positions])
    np.testing.assert_allclose(theirs, sums_of_squares, rtol=1e-10, atol=1e-12)


def test_dtaidistance_takes_the_root_of_it(positions, sums_of_squares):
    theirs = dtw_ndim.distance_matrix_fast(positions, parallel=False)
    np.testing.assert_allclose(theirs, np.sqrt(sums_of_squares), rtol=1e-10, atol=1e-12)


def test_dtaidistance_with_distances_that_are_not_squared_is_ours(positions, sums, motions):
    theirs = dtw_ndim.distance_matrix_fast(positions, parallel=False, inner_dist="euclidean")
    np.testing.assert_allclose(theirs, sums, rtol=1e-10, atol=1e-12)
    frames = np.add.outer(LENGTHS, LENGTHS)
    D = motion_distances(motions, skeleton=SKELETON, metric="position")
    np.testing.assert_allclose(theirs / frames, D, rtol=1e-10, atol=1e-12)


def test_dtaidistance_in_an_archive_is_a_subsequence(positions, motions):
    """`psi` relaxes the ends of the second series."""
    query, archive = 2, 3
    expected = dtw_ndim.distance(
        positions[query], positions[archive], psi=(0, 0, LENGTHS[archive], LENGTHS[archive]), inner_dist="euclidean"
    )
    D = motion_distances(
        [motions[query]],
        [motions[archive]],
        skeleton=SKELETON,
        metric="position",
        alignment="subsequence",
        normalize=False,
    )
    assert D[0, 0] == pytest.approx(expected, rel=1e-10)


def test_aeon_on_points_whose_squared_distances_are_ours(motions, sums):
    """The root of a Euclidean distance is one too (I. J. Schoenberg, 1938), and classical scaling finds its points."""
    frames = np.concatenate(motions)
    D = pose_distances(frames, skeleton=SKELETON, metric="position")
    centred = D - D.mean(axis=0)
    values, vectors = np.linalg.eigh(-0.5 * (centred - centred.mean(axis=1, keepdims=True)))
    assert values.min() > -1e-9 * values.max()
    points = vectors * np.sqrt(np.maximum(values, 0))
    series = [np.ascontiguousarray(part.T) for part in np.split(points, np.cumsum(LENGTHS)[:-1])]
    np.testing.assert_allclose(aeon.dtw_pairwise_distance(series), sums, rtol=1e-9, atol=1e-12)
