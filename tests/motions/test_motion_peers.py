"""Dynamic time warping against dtaidistance; see the extra "peers"."""

import numpy as np
import pytest
from conftest import SKELETONS

from skpose import forward_kinematics, motion_distances

dtw_ndim = pytest.importorskip("dtaidistance.dtw_ndim")

SKELETON = SKELETONS["humanoid"]
LENGTHS = [40, 1, 25, 130, 64]


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
