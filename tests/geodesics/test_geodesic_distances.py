"""Geodesic distances from the frames of a motion: those of new searches, found from frame to frame."""

import numpy as np
import pytest
from conftest import SKELETONS

from skpose import pose_distances
from skpose.geodesics import _sequence, geodesic_distances

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


def test_a_pose_of_the_motion_itself():
    motion, _, skeleton = frames_and_poses("mixed joints")
    found = geodesic_distances(motion, motion[4:6], skeleton)
    assert (found[[4, 5], [0, 1]] <= 1e-12).all()
    assert (np.delete(found[:, 0], 4) > 1e-3).all()
    searched = pose_distances(motion, motion[4:6], skeleton=skeleton, metric="geodesic")
    np.testing.assert_allclose(found, searched, rtol=1e-5, atol=1e-12)


@pytest.mark.parametrize("rotations", [None, "rotvec"])
def test_real_walks(cmu, rotations, starts):
    motion = cmu.motions[0].to_rotvec() if rotations else cmu.motions[0]
    frames, poses, skeleton = motion.angles[:20], motion.angles[30:60:6], motion.skeleton
    found = geodesic_distances(frames, poses, skeleton)
    searched = pose_distances(frames, poses, skeleton=skeleton, metric="geodesic")
    np.testing.assert_allclose(found, searched, rtol=5e-3)
    assert np.mean(np.abs(found / searched - 1.0)) <= 2e-4
    assert np.count_nonzero(starts) >= 10  # frames at which there is a path to follow
