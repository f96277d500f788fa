"""The median: closed forms, the definition by scipy, poses that it coincides with, and outliers."""

import numpy as np
import pytest
import reference
from conftest import SKELETONS, whole_turns
from scipy.optimize import minimize
from sklearn.exceptions import ConvergenceWarning

from skpose import Skeleton, forward_kinematics, pose_distances
from skpose.geodesics import GeometricMedianResult, frechet_mean, geometric_median

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


@pytest.mark.parametrize("metric", ALL)
def test_a_pose_of_more_than_half_the_weight_is_the_median(metric):
    X, weights = arms(), np.ones(9)
    weights[4] = 8.5
    median = geometric_median(X, ARM, metric=metric, sample_weight=weights)
    F = [forward_kinematics(poses, ARM) for poses in (median.pose[None], X[4:5])]
    np.testing.assert_allclose(*F, atol=1e-9)
    assert (median.converged, median.gradient_norm) == (True, 0.0)


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


def test_how_far_the_outliers_are_does_not_matter():
    """Under "angle", where there is room for them."""
    X = np.concatenate([arms(7, scale=0.05), arms(3, scale=0.01) + np.array([2.0, 1.0, 0.0])])
    farther = np.concatenate([X[:7], 5 * X[7:]])
    medians = [geometric_median(poses, ARM, metric="angle").pose for poses in (X, farther)]
    np.testing.assert_allclose(*medians, atol=0.01)


@pytest.mark.parametrize("metric", ALL)
def test_weights_count_poses_and_zero_leaves_them_out(metric):
    X, counts = arms(5), [3, 0, 1, 2, 2]
    far = X.copy()
    far[1] += 1.0
    weighted = geometric_median(far, ARM, metric=metric, sample_weight=counts, tol=1e-6)
    repeated = geometric_median(np.repeat(X, counts, axis=0), ARM, metric=metric, tol=1e-6)
    np.testing.assert_allclose(weighted.pose, repeated.pose, atol=1e-4)
    np.testing.assert_allclose(weighted.deviation, repeated.deviation, rtol=1e-6)


@pytest.mark.parametrize("metric", ["position", "rotation", "spatial", "geodesic"])
def test_whole_turns_do_not_matter(metric):
    skeleton = SKELETONS["mixed joints"]
    X = np.random.default_rng(0).normal(scale=0.2, size=(5, skeleton.n_dofs))
    turns = whole_turns(X, skeleton, np.random.default_rng(1).integers(-1, 2, X.shape))
    one, other = (geometric_median(poses, skeleton, metric=metric) for poses in (X, X + turns))
    np.testing.assert_allclose(one.deviation, other.deviation, rtol=1e-5)


@pytest.mark.parametrize("metric", ALL)
def test_one_pose_is_its_own_median(metric):
    X = arms(1)
    for poses in (X, np.repeat(X, 4, axis=0)):
        median = geometric_median(poses, ARM, metric=metric)
        assert isinstance(median, GeometricMedianResult)
        np.testing.assert_allclose(median.pose, X[0], atol=1e-8)
        assert median.deviation < 1e-8


@pytest.mark.parametrize("metric", ["position", "rotation"])
def test_equal_poses_have_a_median_to_rounding(metric):
    for pose in np.random.default_rng(0).normal(size=(20, ARM.n_dofs)):
        assert geometric_median(np.tile(pose, (3, 1)), ARM, metric=metric).converged


def test_real_walks_with_frames_of_another_action(cmu):
    """A fifth of the poses are of another movement."""
    actions = list(zip(cmu, cmu.actions, strict=True))
    walks, other = next(
        (one.resample(6), another.resample(6))
        for one, action in actions
        for another, word in actions
        if action == "walk" and word not in ("walk", "run/jog") and one.skeleton == another.skeleton
    )  # fmt: skip
    X = np.concatenate([walks.angles[:16], other.angles[:4]])
    median, mean = geometric_median(X, walks.skeleton), frechet_mean(X, walks.skeleton)
    assert median.converged
    weights = np.full(len(X), 1 / len(X))
    assert median.deviation < total("position", mean.pose, X, weights, walks.skeleton)


def test_warns_when_it_does_not_converge():
    with pytest.warns(ConvergenceWarning, match="the median did not converge.*max_iter=1 iterations; raise max_iter$"):
        median = geometric_median(arms(), ARM, max_iter=1, tol=1e-9)
    assert repr(median).endswith("not converged in 1 iterations)")


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"X": np.zeros((2, 5))}, "X has 5 columns, but the skeleton has 3 degrees of freedom"),
        ({"metric": "cosine"}, "'metric' parameter of geometric_median must be a str among"),
        ({"sample_weight": [1, 2]}, r"sample_weight must have shape \(9,\), one for each pose, got \(2,\)"),
        ({"sample_weight": np.zeros(9)}, "finite, nowhere negative, and somewhere positive"),
        ({"max_iter": 0}, "'max_iter' parameter of geometric_median must be an int"),
    ],
)
def test_bad_input_is_refused(arguments, message):
    with pytest.raises(ValueError, match=message):
        geometric_median(**({"X": arms(), "skeleton": ARM} | arguments))
