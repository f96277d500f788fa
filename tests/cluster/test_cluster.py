import numpy as np
import pandas as pd
import pytest
import reference
from conftest import SKELETONS
from scipy.sparse import csr_array
from sklearn.datasets import make_blobs
from sklearn.exceptions import ConvergenceWarning
from sklearn.metrics import adjusted_rand_score
from sklearn.neighbors import KNeighborsTransformer, RadiusNeighborsTransformer
from sklearn.utils import get_tags

from skpose import pose_distances
from skpose.cluster import MedoidShift
from skpose.datasets import make_gait

HUMANOID = SKELETONS["humanoid"]


@pytest.fixture(scope="module")
def blobs():
    return make_blobs(300, centers=4, cluster_std=0.7, random_state=1)


@pytest.mark.parametrize("bandwidth", [0.1, 0.4, 0.8, 1.5, 4.0])
def test_agrees_with_the_definition(bandwidth):
    rng = np.random.default_rng(0)
    for X in (rng.normal(size=(40, 2)), rng.uniform(-2, 2, size=(30, 3)), rng.normal(size=(25, HUMANOID.n_dofs))):
        skeleton, metric = (HUMANOID, "spatial") if X.shape[1] == HUMANOID.n_dofs else (None, "angle")
        modes = reference.medoid_shift(pose_distances(X, skeleton=skeleton, metric=metric), bandwidth)
        shift = MedoidShift(skeleton, bandwidth=bandwidth, metric=metric).fit(X)
        np.testing.assert_array_equal(shift.cluster_centers_indices_[shift.labels_], modes)
        np.testing.assert_array_equal(shift.cluster_centers_, X[np.unique(modes)])


def test_finds_blobs_by_bandwidth_and_by_number(blobs):
    X, y = blobs
    assert adjusted_rand_score(y, MedoidShift(bandwidth=1.4, metric="angle").fit_predict(X)) > 0.95
    shift = MedoidShift(n_clusters=4, metric="angle").fit(X)
    assert len(shift.cluster_centers_) == 4
    assert adjusted_rand_score(y, shift.labels_) > 0.95
    np.testing.assert_array_equal(MedoidShift(bandwidth=shift.bandwidth_, metric="angle").fit(X).labels_, shift.labels_)


def test_a_number_of_clusters_that_no_bandwidth_gives():
    """The corners of an equilateral triangle are three modes or one."""
    D = 1.0 - np.eye(3)
    with pytest.warns(ConvergenceWarning, match="gives 2 clusters"):
        shift = MedoidShift(n_clusters=2, metric="precomputed").fit(D)
    assert len(shift.cluster_centers_indices_) == 1
    with pytest.raises(ValueError, match="n_clusters=4 is more than the 3 samples"):
        MedoidShift(n_clusters=4, metric="precomputed").fit(D)
    with pytest.raises(ValueError, match="mutually exclusive"):
        MedoidShift(bandwidth=1.0, n_clusters=2, metric="precomputed").fit(D)


def test_a_full_graph_gives_what_the_matrix_gives(blobs):
    X = blobs[0][:150]
    D = pose_distances(X, metric="angle")
    rows, columns = np.divmod(np.arange(D.size), len(D))
    graph = csr_array((D.ravel(), (rows, columns)))  # with explicit zeros on the diagonal
    for bandwidth in (0.3, 0.8, 1.5):
        dense, sparse = (MedoidShift(bandwidth=bandwidth, metric="precomputed").fit(A) for A in (D, graph))
        np.testing.assert_array_equal(sparse.labels_, dense.labels_)
        np.testing.assert_array_equal(sparse.cluster_centers_indices_, dense.cluster_centers_indices_)
    assert graph.nnz == D.size


@pytest.mark.parametrize("bandwidth", [0.3, 0.8, 1.5])
@pytest.mark.parametrize("n_neighbors", [3, 10, 25])
def test_a_graph_agrees_with_the_definition(bandwidth, n_neighbors):
    X = np.random.default_rng(0).normal(size=(40, 2))
    graph = KNeighborsTransformer(n_neighbors=n_neighbors).fit_transform(X)
    D = np.full((40, 40), np.nan)
    rows, columns = graph.nonzero()
    D[rows, columns] = D[columns, rows] = np.linalg.norm(X[rows] - X[columns], axis=1)
    np.fill_diagonal(D, 0)
    shift = MedoidShift(bandwidth=bandwidth, metric="precomputed").fit(graph)
    np.testing.assert_array_equal(shift.cluster_centers_indices_[shift.labels_], reference.medoid_shift(D, bandwidth))


@pytest.mark.parametrize("bandwidth", [0.1, 0.5, 1.4])
def test_a_new_pose_makes_the_step_of_a_sample(blobs, bandwidth):
    X, _ = blobs
    shift = MedoidShift(bandwidth=bandwidth, metric="angle").fit(X[:200])
    np.testing.assert_array_equal(shift.predict(X[:200]), shift.labels_)
    D = pose_distances(X, X[:200].copy(), metric="angle")
    costs = np.exp(-(D[200:] ** 2) / (2 * bandwidth**2)) @ D[:200] ** 2
    np.testing.assert_array_equal(shift.predict(X[200:]), shift.labels_[costs.argmin(axis=1)])
    assert shift.predict(1e6 + X[:1]) == shift.labels_[X[:200].sum(axis=1).argmax()]  # no weight above zero in float64


def test_predict_from_precomputed_distances(blobs):
    X, _ = blobs
    expected = MedoidShift(bandwidth=1.4, metric="angle").fit(X[:200]).predict(X[200:])
    D = pose_distances(X, X[:200].copy(), metric="angle")
    given = MedoidShift(bandwidth=1.4, metric="precomputed").fit(D[:200])
    np.testing.assert_array_equal(given.predict(D[200:]), expected)
    assert get_tags(given).input_tags.pairwise
    with pytest.raises(TypeError, match="Sparse data was passed for X, but dense data is required"):
        given.predict(csr_array(D[200:]))
    with pytest.raises(ValueError, match="must be a square matrix to fit"):
        given.fit(D)


def test_predict_from_graphs(blobs):
    X, _ = blobs
    neighbors = RadiusNeighborsTransformer(radius=2.0).fit(X[:200])
    graph = neighbors.transform(X[:200])
    shift = MedoidShift(bandwidth=0.4, metric="precomputed").fit(graph)
    np.testing.assert_array_equal(shift.predict(graph), shift.labels_)
    with pytest.raises(ValueError, match="neighbor"):
        shift.predict(neighbors.transform(X[:2] + 100.0))
    D = pose_distances(X, X[:200].copy(), metric="angle")
    full = csr_array((D[:200].ravel(), np.divmod(np.arange(200 * 200), 200)))
    of_graph = MedoidShift(bandwidth=0.4, metric="precomputed").fit(full).predict(D[200:])
    of_matrix = MedoidShift(bandwidth=0.4, metric="precomputed").fit(D[:200]).predict(D[200:])
    np.testing.assert_array_equal(of_graph, of_matrix)


@pytest.mark.parametrize("form", ["poses", "matrix", "graph"])
def test_a_weight_is_a_number_of_copies(form):
    rng = np.random.default_rng(0)
    X, weights = rng.normal(size=(60, 2)), rng.integers(0, 4, size=60)
    copies = np.repeat(np.arange(60), weights)

    def fit(rows, **options):
        shift = MedoidShift(bandwidth=0.4, metric="angle" if form == "poses" else "precomputed")
        D = pose_distances(rows, metric="angle")
        n = len(rows)
        graph = csr_array((D.ravel(), np.divmod(np.arange(n * n), n)))
        return shift.fit({"poses": rows, "matrix": D, "graph": graph}[form], **options)

    weighted, copied = fit(X, sample_weight=weights), fit(X[copies])
    np.testing.assert_array_equal(weighted.labels_[copies], copied.labels_)
    np.testing.assert_array_equal(weighted.cluster_centers_indices_, copies[copied.cluster_centers_indices_])
    assert len(weighted.cluster_centers_indices_) > 3
    if form == "poses":
        np.testing.assert_array_equal(weighted.labels_, copied.predict(X))  # also of weight zero


def test_a_default_bandwidth_with_a_single_cluster_warns():
    X = np.random.default_rng(0).uniform(size=(100, 2))
    with pytest.warns(UserWarning, match="n_clusters="):
        assert not MedoidShift(metric="angle").fit_predict(X).any()
    MedoidShift(metric="angle").fit(np.zeros((5, 2)))  # equal poses are one cluster


def test_poses_of_a_skeleton():
    gait = make_gait(2, 1, duration=1.0, random_state=0)
    X, _ = gait.poses(frame_rate=12)
    frame = pd.DataFrame(X, columns=gait.skeleton.dof_names)
    shift = MedoidShift(n_clusters=4, skeleton=gait.skeleton).fit(frame)
    assert shift.cluster_centers_.shape == (4, X.shape[1])
    with pytest.raises(ValueError, match="columns of X"):
        MedoidShift(skeleton=gait.skeleton).fit(frame[frame.columns[::-1]])
