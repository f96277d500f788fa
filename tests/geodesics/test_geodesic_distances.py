"""Geodesic distances from the frames of a motion: those of new searches, found from frame to frame."""

import numpy as np
import pytest
from conftest import SKELETONS
from sklearn.exceptions import ConvergenceWarning

from skpose import Skeleton, pose_distances
from skpose.geodesics import _sequence, geodesic_distances
from skpose.metrics import Geodesic

NAMES = ["chain", "bvh", "tree", "mixed joints", "weights"]


def frames_and_poses(name, n_frames=12, n_poses=10, speed=0.002, seed=0):
    """A motion of small steps, and poses about it."""
    skeleton, rng = SKELETONS[name], np.random.default_rng(seed)
    start, velocity = rng.normal(scale=0.3, size=(2, skeleton.n_dofs))
    motion = start + speed * np.arange(n_frames)[:, None] * velocity
    return motion, rng.normal(scale=0.5, size=(n_poses, skeleton.n_dofs)), skeleton


@pytest.fixture
def starts(monkeypatch):
    """For each frame and some poses, how many paths of the frame before there are to start from."""
    follow, counts = _sequence.follow_geodesics, []

    def recorded(tree, pose, ends, first, last, search, kept, found):
        counts.append(np.count_nonzero(kept.n_nodes))
        follow(tree, pose, ends, first, last, search, kept, found)

    monkeypatch.setattr(_sequence, "follow_geodesics", recorded)
    return counts


@pytest.mark.parametrize("name", NAMES)
def test_distances_are_those_of_new_searches(name, starts):
    motion, poses, skeleton = frames_and_poses(name)
    found = geodesic_distances(motion, poses, skeleton)
    assert found.shape == (12, 10)
    searched = pose_distances(motion, poses, skeleton=skeleton, metric="geodesic")
    np.testing.assert_allclose(found, searched, rtol=2e-3)
    assert np.median(np.abs(found / searched - 1.0)) <= 1e-6
    np.testing.assert_allclose(found[0], searched[0], rtol=1e-6)
    line = pose_distances(motion, poses, skeleton=skeleton)
    assert (pose_distances(motion, poses, skeleton=skeleton, metric="position") <= found * (1 + 1e-12)).all()
    assert (found <= line * (1 + 1e-6)).all()
    assert sorted(starts) == [0, 0, *[2] * 11, *[8] * 11]  # of eight poses, and of the other two


@pytest.mark.parametrize("n_jobs", [2, 3])
def test_a_column_depends_on_no_other_one_and_not_on_threads(n_jobs):
    motion, poses, skeleton = frames_and_poses("tree", n_poses=20)
    found = geodesic_distances(motion, poses, skeleton)
    np.testing.assert_array_equal(found, geodesic_distances(motion, poses, skeleton, n_jobs=n_jobs))
    np.testing.assert_array_equal(found[:, 7:12], geodesic_distances(motion, poses[7:12], skeleton))


def test_a_new_search_begins_where_the_pose_has_moved_by_a_tenth_of_the_distance(starts):
    """Since the last search, however small the steps are."""
    arm = Skeleton.chain(1)
    geodesic_distances(np.linspace(0.0, 0.5, 51)[:, None], [[1.0]], arm)
    searched = np.flatnonzero(np.array(starts) == 0)
    distances = np.linspace(1.0, 0.5, 51)
    expected = [0]
    for i in range(1, 51):  # a chord of an arm of one meter is a little shorter than its angle
        if 2.0 * np.sin(0.5 * (distances[expected[-1]] - distances[i])) > 0.1 * 20 * np.sin(0.05 * distances[i - 1]):
            expected.append(i)
    assert len(expected) == 7
    np.testing.assert_array_equal(searched, expected)


def test_where_the_motion_jumps_a_new_search_begins(starts):
    motion, poses, skeleton = frames_and_poses("tree", n_poses=8)
    motion[6:] += 1.0
    found = geodesic_distances(motion, poses, skeleton)
    assert starts == [0, *[8] * 5, 0, *[8] * 5]
    np.testing.assert_array_equal(found[6:], geodesic_distances(motion[6:], poses, skeleton))


def test_a_pose_of_the_motion_itself():
    motion, _, skeleton = frames_and_poses("mixed joints")
    found = geodesic_distances(motion, motion[4:6], skeleton)
    assert (found[[4, 5], [0, 1]] <= 1e-12).all()
    assert (np.delete(found[:, 0], 4) > 1e-3).all()
    searched = pose_distances(motion, motion[4:6], skeleton=skeleton, metric="geodesic")
    np.testing.assert_allclose(found, searched, rtol=1e-5, atol=1e-12)


@pytest.mark.parametrize("wrap", [True, False])
def test_whole_turns(wrap):
    motion, poses, skeleton = frames_and_poses("chain", n_frames=4)
    found = geodesic_distances(motion, poses, skeleton, metric=Geodesic(wrap=wrap))
    motion[2:] += 2.0 * np.pi  # in the middle of it
    turned = geodesic_distances(motion, poses, skeleton, metric=Geodesic(wrap=wrap))
    if wrap:
        np.testing.assert_allclose(turned, found, rtol=1e-5)
    else:
        assert (turned[2:] > 2.0 * found[2:]).all()


def test_more_steps_and_float32():
    motion, poses, skeleton = frames_and_poses("tree")
    found = geodesic_distances(motion.astype("f4"), poses.astype("f4"), skeleton, metric=Geodesic(20))
    searched = pose_distances(motion, poses, skeleton=skeleton, metric=Geodesic(20))
    assert found.dtype == np.float64
    np.testing.assert_allclose(found, searched, rtol=2e-3)


def test_one_frame_and_no_way_to_converge(monkeypatch):
    arm = Skeleton.chain(2)
    assert geodesic_distances([[0.0, 0.0]], [[0.5, 0.5], [1.0, 0.0]], arm).shape == (1, 2)
    follow = _sequence.follow_geodesics

    def unconverged(*arguments):
        follow(*arguments)
        arguments[-1].converged[0] = False

    monkeypatch.setattr(_sequence, "follow_geodesics", unconverged)
    with pytest.warns(ConvergenceWarning, match="3 of 6 geodesics did not converge"):
        geodesic_distances([[0.0, 0.0], [0.1, 0.0], [0.2, 0.0]], [[0.5, 0.5], [1.0, 0.0]], arm)


@pytest.mark.parametrize(
    ("X", "Y", "error"),
    [
        ([[0.0]], [[0.0, 0.0]], "X has"),
        ([[0.0, 0.0]], [[0.0]], "Y has"),
        ([[0.0, np.nan]], [[0.0, 0.0]], "Input X contains NaN"),
        ([0.0, 0.0], [[0.0, 0.0]], "2D array"),
        (np.zeros((0, 2)), [[0.0, 0.0]], "0 sample"),
    ],
)
def test_what_is_no_motion_or_no_poses_is_refused(X, Y, error):
    with pytest.raises(ValueError, match=error):
        geodesic_distances(X, Y, Skeleton.chain(2))


def test_degrees_are_noticed():
    with pytest.warns(UserWarning, match="degrees"):
        geodesic_distances([[90.0, 45.0]], [[0.0, 0.0]], Skeleton.chain(2))


@pytest.mark.parametrize("rotations", [None, "rotvec"])
def test_real_walks(cmu, rotations, starts):
    motion = cmu.motions[0].to_rotvec() if rotations else cmu.motions[0]
    frames, poses, skeleton = motion.angles[:20], motion.angles[30:60:6], motion.skeleton
    found = geodesic_distances(frames, poses, skeleton)
    searched = pose_distances(frames, poses, skeleton=skeleton, metric="geodesic")
    np.testing.assert_allclose(found, searched, rtol=5e-3)
    assert np.mean(np.abs(found / searched - 1.0)) <= 2e-4
    assert np.count_nonzero(starts) >= 10  # frames at which there is a path to follow
