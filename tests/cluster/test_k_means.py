import numpy as np
import pandas as pd
import pytest
import reference
from conftest import SKELETONS, in_turns, metric_of
from sklearn.cluster import KMeans
from sklearn.datasets import make_blobs
from sklearn.metrics import adjusted_rand_score

from skpose import Skeleton, pose_distances
from skpose.cluster import PoseKMeans
from skpose.cluster._k_means import lloyd
from skpose.datasets import make_gait
from skpose.geodesics import frechet_mean
from skpose.geodesics._mean import WeightedMeans
from skpose.metrics import Angle

ARM = Skeleton.chain(3)
METRICS = ["angle", "position", "rotation", "spatial", "geodesic"]


@pytest.fixture(scope="module")
def blobs():
    return make_blobs(300, centers=5, n_features=3, cluster_std=1.2, random_state=3)


@pytest.fixture(scope="module")
def poses():
    """Three groups of poses of an arm."""
    rng = np.random.default_rng(0)
    middles = np.array([[0.0, 0.0, 0.0], [2.0, 0.3, 0.3], [-2.0, -0.3, -0.3]])
    return np.concatenate([middle + rng.normal(scale=0.2, size=(15, 3)) for middle in middles])


def run(X, centers, weights=None, skeleton=None, metric="angle", max_iter=300, tol=0.0, means=None):
    """Run Lloyd's iteration from given centres."""
    weights = np.ones(len(X)) if weights is None else weights
    metric = metric_of(metric, n_steps=5)
    if means is None:
        means = WeightedMeans(X, skeleton, metric, None).means

    def squared(centers):
        return pose_distances(X, centers, skeleton=skeleton, metric=metric) ** 2

    return lloyd(centers.copy(), weights, squared, means, max_iter, tol)


# --- against scikit-learn --------------------------------------------------------------------------------------------


@pytest.mark.parametrize("seed", range(5))
def test_of_angles_it_is_k_means(seed, blobs):
    X, _ = blobs
    rng = np.random.default_rng(seed)
    start, weights = X[rng.choice(len(X), 5, replace=False)], rng.uniform(0.1, 2.0, len(X))
    expected = KMeans(5, init=start, n_init=1, tol=0.0).fit(X, sample_weight=weights)
    found = run(X, start, weights)
    np.testing.assert_allclose(found.centers, expected.cluster_centers_, rtol=0, atol=1e-9)
    assert found.inertia == pytest.approx(expected.inertia_, rel=1e-12)
    assert found.converged


def test_a_cluster_without_samples_gets_the_farthest_one_as_in_scikit_learn(blobs):
    X, _ = blobs
    start = X[:5].copy()
    start[3] = 1e3
    expected = KMeans(5, init=start, n_init=1, tol=0.0).fit(X)
    found = run(X, start)
    np.testing.assert_allclose(found.centers, expected.cluster_centers_, rtol=0, atol=1e-9)


# --- the objective ---------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("metric", "name"), in_turns(list(METRICS), ["chain", "mixed joints"]))
def test_inertia_never_rises(metric, name):
    skeleton = SKELETONS[name]
    X = np.random.default_rng(1).uniform(-1.5, 1.5, size=(10, skeleton.n_dofs))
    inertias = [run(X, X[:3], skeleton=skeleton, metric=metric, max_iter=n).inertia for n in (1, 2, 3)]
    start = pose_distances(X, X[:3], skeleton=skeleton, metric=metric_of(metric, n_steps=5)) ** 2
    assert (np.diff([start.min(axis=1).sum(), *inertias]) <= 1e-12).all()
    assert inertias[0] < 0.95 * start.min(axis=1).sum()


@pytest.mark.parametrize("metric", METRICS)
def test_centres_are_means_and_samples_are_with_the_nearest(metric, poses):
    weights = np.random.default_rng(0).uniform(0.5, 2.0, len(poses))
    k_means = PoseKMeans(ARM, n_clusters=3, metric=metric, tol=0.0, random_state=0).fit(poses, sample_weight=weights)
    D = reference.distances(
        poses, k_means.cluster_centers_, ARM, "position" if metric in ("geodesic", "spatial") else metric
    )
    if metric not in ("geodesic", "spatial"):  # for which the reference takes minutes
        np.testing.assert_array_equal(k_means.labels_, D.argmin(axis=1))
        assert k_means.inertia_ == pytest.approx(weights @ D.min(axis=1) ** 2)
    np.testing.assert_array_equal(np.unique(k_means.labels_), [0, 1, 2])
    assert adjusted_rand_score(np.repeat([0, 1, 2], 15), k_means.labels_) == 1.0
    for k, center in enumerate(k_means.cluster_centers_):
        own = k_means.labels_ == k
        if metric == "angle":
            mean = np.average(poses[own], axis=0, weights=weights[own])
        else:
            mean = frechet_mean(poses[own], ARM, metric=metric, sample_weight=weights[own]).pose
        apart = pose_distances(center[None], mean[None], skeleton=ARM, metric="position").item()
        assert apart < {"angle": 1e-9, "position": 1e-4}.get(metric, 5e-3)


# --- samples ---------------------------------------------------------------------------------------------------------


def test_a_sample_twice_is_a_sample_of_twice_the_weight_in_any_order(poses):
    counts = np.random.default_rng(2).integers(0, 4, size=len(poses))
    order = np.random.default_rng(3).permutation(counts.sum())
    repeated = np.repeat(poses, counts, axis=0)[order]
    for seed in range(4):
        k_means = PoseKMeans(ARM, n_clusters=4, metric="position", random_state=seed)
        a = k_means.fit(poses, sample_weight=counts)
        expected, labels = a.cluster_centers_, a.labels_
        np.testing.assert_allclose(k_means.fit(repeated).cluster_centers_, expected, rtol=0, atol=1e-9)
        np.testing.assert_array_equal(k_means.labels_, np.repeat(labels, counts)[order])
        kept = counts > 0
        k_means.fit(poses[kept], sample_weight=counts[kept])
        np.testing.assert_array_equal(k_means.cluster_centers_, expected)
        assert len(labels) == len(poses)


def test_wrapped_angles_form_one_cluster_around_half_a_turn():
    rng = np.random.default_rng(0)
    X = np.concatenate([rng.normal(np.pi, 0.2, size=(20, 1)), rng.normal(0.0, 0.2, size=(20, 1))])
    X = (X + np.pi) % (2 * np.pi) - np.pi
    truth = np.repeat([0, 1], 20)
    wrapped = PoseKMeans(n_clusters=2, metric=Angle(wrap=True), random_state=0).fit(X)
    assert adjusted_rand_score(truth, wrapped.labels_) == 1.0
    assert adjusted_rand_score(truth, PoseKMeans(n_clusters=2, metric="angle", random_state=0).fit_predict(X)) < 0.9


# --- as an estimator -------------------------------------------------------------------------------------------------


def test_methods_agree_with_distances(poses):
    k_means = PoseKMeans(ARM, n_clusters=3, metric="position", random_state=0).fit(poses)
    new = poses[:9] + 0.1
    D = pose_distances(new, k_means.cluster_centers_, skeleton=ARM, metric="position")
    np.testing.assert_allclose(k_means.transform(new), D, rtol=0, atol=1e-12)
    np.testing.assert_array_equal(k_means.predict(new), D.argmin(axis=1))
    weights = np.arange(9.0)
    assert k_means.score(new, sample_weight=weights) == pytest.approx(-weights @ D.min(axis=1) ** 2)
    assert k_means.score(poses) == pytest.approx(-k_means.inertia_)
    np.testing.assert_array_equal(k_means.predict(poses), k_means.labels_)
    assert k_means.transform(new.astype(np.float32)).dtype == np.float32
    assert list(k_means.get_feature_names_out()) == ["posekmeans0", "posekmeans1", "posekmeans2"]


def test_poses_of_a_skeleton():
    gait = make_gait(2, 1, duration=1.0, random_state=0)
    X, _ = gait.poses(frame_rate=12)
    frame = pd.DataFrame(X, columns=gait.skeleton.dof_names)
    k_means = PoseKMeans(gait.skeleton, n_clusters=3, metric="position", random_state=0).fit(frame)
    assert k_means.cluster_centers_.shape == (3, X.shape[1])
    with pytest.raises(ValueError, match="columns of X"):
        PoseKMeans(gait.skeleton, n_clusters=3).fit(frame[frame.columns[::-1]])
    with pytest.raises(ValueError, match="'n_clusters' parameter of PoseKMeans must be an int"):
        PoseKMeans(gait.skeleton, n_clusters=gait.skeleton).fit(X)
