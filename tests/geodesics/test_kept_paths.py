"""Geodesics from a pose that moves: each path starts from the one before, and ends where a new search ends."""

import numpy as np
import pytest
from conftest import SKELETONS

from skpose import Skeleton, pose_distances
from skpose._compiled.path import kept_paths
from skpose._compiled.path.geodesic import TOL
from skpose.geodesics import frechet_mean
from skpose.kinematics._tree import to_tree_order, tree_of
from skpose.metrics import Geodesic, _geodesic


def near_poses(skeleton, n=6, scale=0.3, seed=0):
    return np.random.default_rng(seed).normal(scale=scale, size=(n, skeleton.n_dofs))


def sample_of(X, skeleton, wrap=True):
    return Geodesic(wrap=wrap).sample(X, np.full(len(X), 1 / len(X)), skeleton, 1)


def searched(pose, X, skeleton, wrap=True):
    """Geodesics by a new search each."""
    return sample_of(X, skeleton, wrap).linearize(pose, 0.0)


@pytest.mark.parametrize("wrap", [True, False])
@pytest.mark.parametrize("name", ["chain", "bvh", "tree", "mixed joints", "weights"])
def test_followed_paths_are_those_of_a_new_search(name, wrap):
    skeleton = SKELETONS[name]
    X = near_poses(skeleton)
    poses = sample_of(X, skeleton, wrap)
    pose = np.zeros(poses.dofs.shape[1])
    rng = np.random.default_rng(1)
    for _ in range(4):
        view, fresh = poses.linearize(pose, 0.0), searched(pose, X, skeleton, wrap)
        np.testing.assert_allclose(view.lengths, fresh.lengths, rtol=1e-3)
        anew = sample_of(X, skeleton, wrap)
        anew.linearize(pose, 0.0)
        same = (poses.kept.substeps == 1) & (anew.kept.substeps == 1)  # others are refined, in one of the two maybe
        assert same.any()
        np.testing.assert_allclose(view.lengths[same], fresh.lengths[same], rtol=1e-6)
        np.testing.assert_allclose(view.energies[same], fresh.energies[same], rtol=1e-6)
        atol = 1e-4 * np.abs(fresh.gradients).max()
        np.testing.assert_allclose(view.gradients[same], fresh.gradients[same], atol=atol)
        assert view.n_unconverged == 0
        pose = poses.retract(pose, rng.normal(scale=0.05, size=len(pose)))


def test_a_path_is_found_in_the_end_where_the_base_has_jumped():
    """To the other side of a half turn: the kept path goes the long way, and a new search replaces it."""
    skeleton = Skeleton.chain(2)
    X = near_poses(skeleton, 1, 0.0)
    poses = sample_of(X, skeleton)
    for angle in (2.8, -2.8, 0.1, 3.0):
        pose = np.array([angle, 0.2])
        np.testing.assert_allclose(poses.linearize(pose, 0.0).lengths, searched(pose, X, skeleton).lengths, rtol=1e-3)


def test_at_the_same_base_nothing_moves():
    skeleton = SKELETONS["humanoid"]
    poses = sample_of(near_poses(skeleton), skeleton)
    pose = np.zeros(poses.dofs.shape[1])
    poses.linearize(pose, 0.0)
    nodes = poses.kept.nodes[:, :11].copy()
    assert (poses.kept.n_nodes == 11).all()
    poses.linearize(pose, 0.0)
    np.testing.assert_allclose(poses.kept.nodes[:, :11], nodes, atol=1e-12)


def test_a_kept_path_is_where_the_search_starts():
    """A path that is spoilt leads to a longer curve, or to a new search: it is read."""
    skeleton = SKELETONS["humanoid"]
    poses = sample_of(near_poses(skeleton, 2), skeleton)
    pose = np.zeros(poses.dofs.shape[1])
    poses.linearize(pose, 0.0)
    before = poses.kept.nodes[:, :11].copy()
    poses.kept.nodes[:, 1:10] += 0.01 * np.sin(np.arange(9))[:, None]
    poses.linearize(pose, 1.0)  # coarsely
    assert 1e-6 < np.abs(poses.kept.nodes[:, :11] - before).max() < 0.1


def test_the_mean_is_that_of_new_searches(monkeypatch):
    """As if no path were kept."""
    skeleton = Skeleton.chain(3)
    X = np.linspace(-1.2, 1.2, 15)[:, None] * [1.0, 0.4, 0.2] + np.random.default_rng(0).normal(
        scale=0.05, size=(15, 3)
    )
    kept = frechet_mean(X, skeleton, metric="geodesic", tol=1e-5)
    original = _geodesic.follow_geodesics

    def forgetful(tree, pose, ends, first, last, search, paths, found):
        paths.n_nodes[:] = 0
        original(tree, pose, ends, first, last, search._replace(gradient_norm=TOL), paths, found)

    monkeypatch.setattr(_geodesic, "follow_geodesics", forgetful)
    anew = frechet_mean(X, skeleton, metric="geodesic", tol=1e-5)
    np.testing.assert_allclose(kept.pose, anew.pose, atol=1e-3)
    np.testing.assert_allclose(kept.variance, anew.variance, rtol=1e-4)


def test_memory_is_that_of_the_finest_path():
    skeleton = Skeleton.chain(3)
    kept = sample_of(near_poses(skeleton), skeleton).kept
    assert kept.nodes.shape == (6, kept_paths.MOST_NODES * 10 + 1, 3)
    assert not kept.n_nodes.any()


@pytest.mark.slow
def test_means_of_hdm05_are_those_of_new_searches(hdm05):
    """Poses far apart, whose paths are refined: the variances agree to what refinements leave."""
    X, _ = hdm05.poses(12)
    X = X[np.random.default_rng(0).permutation(len(X))[:12]]
    mean = frechet_mean(X, hdm05.skeleton, metric="geodesic", n_jobs=2)
    assert mean.converged
    fresh = searched(to_tree_order(tree_of(hdm05.skeleton), mean.pose), X, hdm05.skeleton)
    np.testing.assert_allclose(mean.variance, (fresh.lengths**2).mean(), rtol=5e-3)
    D = pose_distances(X, skeleton=hdm05.skeleton, metric="geodesic", n_jobs=2)
    assert mean.variance < (D**2).mean(axis=1).min()


def test_means_of_walks_take_few_iterations(cmu):
    motion = next(motion for motion, action in zip(cmu, cmu.actions, strict=True) if action == "walk").resample(6)
    X = motion.angles[:12]
    mean = frechet_mean(X, motion.skeleton, metric="geodesic")
    assert (mean.converged, mean.n_iter < 9) == (True, True)  # 12 without the combination of steps
    distances = pose_distances(mean.pose[None], X, skeleton=motion.skeleton, metric="geodesic")
    np.testing.assert_allclose(mean.variance, (distances**2).mean(), rtol=1e-4)
