"""The median: closed forms, the definition by scipy, poses that it coincides with, and outliers."""

import numpy as np
import pytest
import reference
from conftest import SKELETONS
from scipy.optimize import minimize
from sklearn.exceptions import ConvergenceWarning

from skpose import Skeleton, pose_distances
from skpose.geodesics import frechet_mean, geometric_median

ALL = ["angle", "position", "rotation", "spatial", "geodesic"]
ARM = Skeleton.chain(3)


def arms(n=9, scale=0.4, seed=0):
    return np.random.default_rng(seed).normal(scale=scale, size=(n, 3))


def total(metric, pose, X, weights, skeleton=ARM):
    return weights @ pose_distances(pose[None], X, skeleton=skeleton, metric=metric)[0]


@pytest.mark.parametrize("metric", ALL)
def test_of_an_odd_number_of_angles_it_is_the_one_in_the_middle(metric):
    """On a line or a circle: the pose of that weight is the minimum exactly, at a kink of the sum."""
    X = np.array([[0.1], [-0.7], [0.35], [0.9], [0.2]])
    median = geometric_median(X, Skeleton.chain(1), metric=metric)
    np.testing.assert_allclose(median.pose, [0.2], atol=1e-9)
    assert median.converged
    np.testing.assert_allclose(median.deviation, total(metric, X[4], X, np.full(5, 0.2), Skeleton.chain(1)), rtol=1e-6)


@pytest.mark.parametrize("metric", ["angle", "position", "rotation", "spatial"])
def test_scipy_finds_the_same(metric):
    X, weights = arms(), np.random.default_rng(1).dirichlet(np.full(9, 5))
    median = geometric_median(X, ARM, metric=metric, sample_weight=weights, tol=1e-6)
    assert median.converged
    wrap = metric == "spatial"
    other = minimize(
        lambda pose: weights @ reference.distances([pose], X, ARM, metric, wrap=wrap)[0],
        X.mean(axis=0), method="Nelder-Mead", options={"xatol": 1e-9, "fatol": 1e-12, "maxiter": 5000},
    )  # fmt: skip
    np.testing.assert_allclose(median.deviation, other.fun, rtol=1e-8)
    np.testing.assert_allclose(median.pose, other.x, atol=1e-4)


@pytest.mark.parametrize("metric", ALL)
@pytest.mark.parametrize("name", ["bvh", "mixed joints", "weights"])
def test_no_pose_near_it_or_given_is_better(name, metric):
    skeleton = SKELETONS[name]
    X = np.random.default_rng(0).normal(scale=0.2, size=(7, skeleton.n_dofs))
    weights = np.random.default_rng(1).dirichlet(np.full(7, 5))
    median = geometric_median(X, skeleton, metric=metric, sample_weight=weights)
    assert median.converged
    np.testing.assert_allclose(median.deviation, total(metric, median.pose, X, weights, skeleton), rtol=1e-6)
    near = median.pose + np.random.default_rng(2).normal(scale=0.05, size=(10, skeleton.n_dofs))
    mean = frechet_mean(X, skeleton, metric=metric, sample_weight=weights).pose
    for pose in [*X, *near, mean]:
        assert total(metric, pose, X, weights, skeleton) > median.deviation * (1 - 1e-6)


@pytest.mark.parametrize("metric", ALL)
def test_it_is_robust_to_outliers(metric):
    """Three poses of ten are far off: the mean goes a third of the way, the median stays among the seven."""
    good = arms(7, scale=0.05)
    bad = arms(3, scale=0.05, seed=1) + np.array([1.2, 0.6, -0.5])
    X, all_of_them = np.concatenate([good, bad]), {}
    centre = frechet_mean(good, ARM, metric=metric).pose
    for find in (frechet_mean, geometric_median):
        pose = find(X, ARM, metric=metric).pose
        all_of_them[find] = pose_distances(pose[None], centre[None], skeleton=ARM, metric=metric)[0, 0]
    farthest = pose_distances(good, centre[None], skeleton=ARM, metric=metric).max()
    assert all_of_them[geometric_median] < farthest < all_of_them[frechet_mean] / 2


@pytest.mark.parametrize("metric", ALL)
def test_weights_count_poses_and_zero_leaves_them_out(metric):
    X, counts = arms(5), [3, 0, 1, 2, 2]
    far = X.copy()
    far[1] += 1.0
    weighted = geometric_median(far, ARM, metric=metric, sample_weight=counts, tol=1e-6)
    repeated = geometric_median(np.repeat(X, counts, axis=0), ARM, metric=metric, tol=1e-6)
    np.testing.assert_allclose(weighted.pose, repeated.pose, atol=1e-4)
    np.testing.assert_allclose(weighted.deviation, repeated.deviation, rtol=1e-6)


def test_warns_when_it_does_not_converge():
    with pytest.warns(ConvergenceWarning, match="the median did not converge.*raise max_iter"):
        median = geometric_median(arms(), ARM, max_iter=1, tol=1e-9)
    assert not median.converged
