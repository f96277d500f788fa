"""Means under "angle", "rotation" and "spatial", against the definitions of the distances and scipy's optimiser."""

import numpy as np
import pytest
import reference
from conftest import SKELETONS, in_turns, whole_turns
from scipy.optimize import approx_fprime, minimize
from sklearn.exceptions import ConvergenceWarning

from skpose import Skeleton, forward_kinematics, pose_distances
from skpose.geodesics import frechet_mean
from skpose.metrics import Angle

ALL = ["angle", "position", "rotation", "spatial", "geodesic"]
JOINTS = ["chain", "bvh", "tree", "ball joints", "mixed joints", "weights"]


def spread_poses(skeleton, n=8, scale=0.25, seed=0):
    """Poses within half a turn of each other, where "spatial" is smooth."""
    return np.random.default_rng(seed).normal(scale=scale, size=(n, skeleton.n_dofs))


def objective(skeleton, metric, X, weights):
    """The sum of squared distances as a function of the pose, by definition."""
    wrap = metric == "spatial"
    return lambda pose: weights @ reference.distances([pose], X, skeleton, metric, wrap=wrap)[0] ** 2


def test_the_mean_under_angle_is_that_of_the_columns():
    skeleton = SKELETONS["mixed joints"]
    X, weights = spread_poses(skeleton), np.random.default_rng(1).dirichlet(np.ones(8))
    mean = frechet_mean(X, skeleton, metric="angle", sample_weight=weights)
    np.testing.assert_allclose(mean.pose, weights @ X, atol=1e-14)
    np.testing.assert_allclose(mean.variance, weights @ ((X - weights @ X) ** 2).sum(axis=1))
    assert (mean.n_iter, mean.converged) == (0, True)


def test_wrapped_angles_have_a_mean_on_the_circle():
    X = np.array([[3.0], [-3.0], [2.9]])
    plain, wrapped = (frechet_mean(X, Skeleton.chain(1), metric=metric) for metric in ("angle", Angle(wrap=True)))
    np.testing.assert_allclose(plain.pose, X.mean(axis=0))
    np.testing.assert_allclose(wrapped.pose % (2 * np.pi), [(3.0 + 2 * np.pi - 3.0 + 2.9) / 3], atol=1e-3)
    distances = pose_distances(wrapped.pose[None], X, metric=Angle(wrap=True))
    np.testing.assert_allclose(wrapped.variance, (distances**2).mean())


@pytest.mark.slow
@pytest.mark.parametrize(("name", "metric"), in_turns(JOINTS, ["rotation", "spatial"]))
def test_the_gradient_of_the_definition_is_zero_there(name, metric):
    skeleton = SKELETONS[name]
    X, weights = spread_poses(skeleton), np.random.default_rng(1).dirichlet(np.ones(8))
    mean = frechet_mean(X, skeleton, metric=metric, sample_weight=weights, tol=1e-5)
    assert mean.converged
    f = objective(skeleton, metric, X, weights)
    np.testing.assert_allclose(mean.variance, f(mean.pose), rtol=1e-9)
    at_start = np.linalg.norm(approx_fprime(X[0], f, 1e-6))
    assert np.linalg.norm(approx_fprime(mean.pose, f, 1e-6)) < 1e-3 * at_start
    for pose in X:
        assert f(pose) > mean.variance


@pytest.mark.parametrize("metric", ["rotation", "spatial"])
def test_scipy_finds_the_same(metric):
    skeleton = Skeleton.chain(3)
    X, weights = spread_poses(skeleton, scale=0.4), np.random.default_rng(1).dirichlet(np.ones(8))
    mean = frechet_mean(X, skeleton, metric=metric, sample_weight=weights, tol=1e-6)
    other = minimize(objective(skeleton, metric, X, weights), X[0], method="Nelder-Mead", tol=1e-9)
    np.testing.assert_allclose(mean.pose, other.x, atol=1e-4)
    np.testing.assert_allclose(mean.variance, other.fun, rtol=1e-8)


def test_two_poses_of_one_joint_have_the_rotation_half_way_between():
    """A ball joint turns from one to the other about one axis, under every metric but "angle"."""
    skeleton = Skeleton.chain(1)
    for metric in ALL:
        mean = frechet_mean([[0.2], [1.4]], skeleton, metric=metric, tol=1e-6)
        np.testing.assert_allclose(mean.pose, [0.8], atol=1e-5)


@pytest.mark.parametrize("metric", ALL)
def test_weights_count_poses_and_zero_leaves_them_out(metric):
    skeleton = SKELETONS["mixed joints"]
    X, counts = spread_poses(skeleton, 5), [3, 0, 1, 2, 1]
    X[1] += 0.5
    weighted = frechet_mean(X, skeleton, metric=metric, sample_weight=counts, tol=1e-5)
    repeated = frechet_mean(np.repeat(X, counts, axis=0), skeleton, metric=metric, tol=1e-5)
    F = [forward_kinematics(mean.pose[None], skeleton) for mean in (weighted, repeated)]
    np.testing.assert_allclose(*F, atol=2e-3)
    np.testing.assert_allclose(weighted.variance, repeated.variance, rtol=1e-5)


@pytest.mark.parametrize("metric", ["rotation", "spatial"])
def test_whole_turns_do_not_matter(metric):
    """Those of rotation vectors are −q in the place of q."""
    skeleton = SKELETONS["mixed joints"]
    X = spread_poses(skeleton)
    turns = whole_turns(X, skeleton, np.random.default_rng(1).integers(-1, 2, X.shape))
    one, other = (frechet_mean(poses, skeleton, metric=metric, tol=1e-5) for poses in (X, X + turns))
    np.testing.assert_allclose(one.variance, other.variance, rtol=1e-6)


@pytest.mark.parametrize("metric", ["rotation", "spatial"])
def test_warns_when_it_does_not_converge(metric):
    skeleton = SKELETONS["humanoid"]
    X = spread_poses(skeleton, scale=0.6)
    with pytest.warns(ConvergenceWarning, match="raise max_iter"):
        frechet_mean(X, skeleton, metric=metric, max_iter=1, tol=1e-6)
