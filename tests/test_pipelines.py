"""The library inside scikit-learn's own tools, on generated gait."""

import numpy as np
import pytest
from sklearn.cluster import DBSCAN, HDBSCAN, AgglomerativeClustering
from sklearn.manifold import TSNE, Isomap, trustworthiness
from sklearn.metrics import homogeneity_score
from sklearn.model_selection import GridSearchCV, GroupKFold, cross_val_score
from sklearn.neighbors import KNeighborsClassifier, LocalOutlierFactor
from sklearn.pipeline import make_pipeline
from sklearn.svm import SVC

from skpose import PoseKNeighborsTransformer, forward_kinematics, pose_distances
from skpose._cli.studies.compare import COMPARED
from skpose.cluster import MedoidShift
from skpose.datasets import make_gait
from skpose.keypoints import Layout, fit_skeleton
from skpose.neighbors import PoseRadiusNeighborsTransformer
from skpose.preprocessing import PoseDistanceTransformer, PoseFromPositions


@pytest.fixture(scope="module")
def gait():
    return make_gait(n_subjects=3, n_sequences=2, duration=2.0, random_state=0)


@pytest.fixture(scope="module")
def data(gait):
    X, sequence = gait.poses(frame_rate=12)
    return X, gait.actions[sequence], sequence


@pytest.fixture(scope="module")
def distances(gait, data):
    D = pose_distances(data[0], skeleton=gait.skeleton)
    D.flags.writeable = False
    return D


@pytest.mark.parametrize(
    ("parameters", "classifier"),
    [
        ({}, KNeighborsClassifier(1, metric="precomputed")),
        ({}, KNeighborsClassifier(5, metric="precomputed", weights="distance")),
        ({"kernel": "rbf"}, SVC(kernel="precomputed")),
        ({"kernel": "laplacian", "metric": "position"}, SVC(kernel="precomputed")),
    ],
)
def test_classifiers_on_precomputed_matrices(parameters, classifier, gait, data):
    X, y, sequence = data
    pipeline = make_pipeline(PoseDistanceTransformer(gait.skeleton, **parameters), classifier)
    scores = cross_val_score(pipeline, X, y, groups=sequence, cv=GroupKFold(3))
    assert scores.mean() > 0.9


def test_nearest_neighbour_in_a_pipeline_is_that_of_the_distances(gait, data, distances):
    X, y, _ = data
    train, test = np.arange(0, len(X), 2), np.arange(1, len(X), 2)
    knn = make_pipeline(PoseDistanceTransformer(gait.skeleton), KNeighborsClassifier(1, metric="precomputed"))
    nearest = distances[np.ix_(test, train)].argmin(axis=1)
    np.testing.assert_array_equal(knn.fit(X[train], y[train]).predict(X[test]), y[train][nearest])


@pytest.mark.slow
def test_grid_search_over_metrics_by_sequence(gait, data):
    X, y, sequence = data
    knn = make_pipeline(PoseDistanceTransformer(gait.skeleton), KNeighborsClassifier(1, metric="precomputed"))
    grid = {"posedistancetransformer__metric": list(COMPARED), "kneighborsclassifier__n_neighbors": [1, 5]}
    searches = [
        GridSearchCV(knn, grid, cv=GroupKFold(3), n_jobs=n_jobs).fit(X, y, groups=sequence) for n_jobs in (1, 2)
    ]
    one, two = (search.cv_results_["mean_test_score"] for search in searches)
    np.testing.assert_array_equal(one, two)
    assert one.min() > 0.8


@pytest.mark.parametrize(
    "clusterer",
    [
        DBSCAN(eps=0.5, metric="precomputed"),
        HDBSCAN(metric="precomputed", copy=True),
        AgglomerativeClustering(12, metric="precomputed", linkage="average"),
    ],
    ids=lambda clusterer: type(clusterer).__name__,
)
def test_clustering_of_distances(clusterer, data, distances):
    assert homogeneity_score(data[1], clusterer.fit_predict(distances)) > 0.5


def test_k_nearest_neighbours_from_a_graph_are_those_from_a_matrix(gait, data):
    X, y, sequence = data
    graphs = make_pipeline(
        PoseKNeighborsTransformer(gait.skeleton, n_neighbors=5), KNeighborsClassifier(5, metric="precomputed")
    )
    matrices = make_pipeline(PoseDistanceTransformer(gait.skeleton), KNeighborsClassifier(5, metric="precomputed"))
    one, two = (cross_val_score(each, X, y, groups=sequence, cv=GroupKFold(3)) for each in (graphs, matrices))
    np.testing.assert_array_equal(one, two)
    grid = {"posekneighborstransformer__metric": ["angle", "spatial"]}
    search = GridSearchCV(graphs, grid, cv=GroupKFold(3)).fit(X, y, groups=sequence)
    assert search.cv_results_["mean_test_score"].min() > 0.8


@pytest.mark.slow
def test_grid_search_from_keypoints_to_classes(gait):
    """A layout of the joints, noisy positions with gaps, the skeleton that fits them, poses, neighbours, classes."""
    X, sequence = gait.poses(frame_rate=5)
    person, rng = gait.skeleton, np.random.default_rng(0)
    parents = {"root": None} | {bone.name: bone.parent or "root" for bone in person.bones}
    layout = Layout("humanoid", parents, parents, rigid=["left_pelvis", "right_pelvis"])
    positions = np.concatenate([np.zeros((len(X), 1, 3)), forward_kinematics(X, person)], axis=1)
    positions += rng.normal(scale=0.005, size=positions.shape)
    positions[rng.uniform(size=positions.shape[:2]) < 0.1] = np.nan
    skeleton = fit_skeleton(positions, layout)
    assert skeleton.joint_names == layout.points
    keypoints = positions.reshape(len(X), -1)

    knn = make_pipeline(
        PoseFromPositions(skeleton, regularization=0.02),
        PoseKNeighborsTransformer(skeleton, n_neighbors=5),
        KNeighborsClassifier(5, metric="precomputed"),
    )
    grid = {"posefrompositions__regularization": [0.0, 0.02], "posekneighborstransformer__metric": ["angle", "spatial"]}
    searches = [
        GridSearchCV(knn, grid, cv=GroupKFold(3), n_jobs=n_jobs).fit(keypoints, gait.actions[sequence], groups=sequence)
        for n_jobs in (1, 2)
    ]
    one, two = (search.cv_results_["mean_test_score"] for search in searches)
    np.testing.assert_array_equal(one, two)
    assert one.min() > 0.9


def test_outlier_factors_of_a_graph_are_those_of_a_matrix(gait, data, distances):
    graph = PoseKNeighborsTransformer(gait.skeleton, n_neighbors=10).fit_transform(data[0])
    on_graph, on_matrix = (LocalOutlierFactor(10, metric="precomputed").fit(D) for D in (graph, distances))
    np.testing.assert_allclose(on_graph.negative_outlier_factor_, on_matrix.negative_outlier_factor_, rtol=1e-9)


def test_the_maximum_with_its_transpose_is_a_symmetric_graph_that_hdbscan_takes(gait, data, distances):
    n_neighbors = 60
    graph = PoseKNeighborsTransformer(gait.skeleton, n_neighbors=n_neighbors).fit_transform(data[0])
    symmetric = graph.maximum(graph.T)
    rank = distances.argsort(axis=1).argsort(axis=1)
    nearest = rank <= n_neighbors
    either = (nearest | nearest.T) & ~np.eye(len(rank), dtype=bool)
    np.testing.assert_array_equal(symmetric.toarray() > 0, either)
    np.testing.assert_allclose(symmetric.toarray()[either], distances[either], rtol=1e-12)
    on_graph = HDBSCAN(min_samples=5, metric="precomputed", copy=True).fit_predict(symmetric)
    # The pose itself counts as a neighbour in a matrix, where its zero is on the diagonal.
    on_matrix = HDBSCAN(min_samples=6, min_cluster_size=5, metric="precomputed", copy=True).fit_predict(distances)
    assert np.mean(on_graph == on_matrix) > 0.99  # ties between reachabilities leave a choice


@pytest.mark.parametrize(
    "clusterer",
    [
        DBSCAN(eps=0.5, metric="precomputed"),
        HDBSCAN(metric="precomputed", copy=True),
        MedoidShift(bandwidth=0.3, metric="precomputed"),
    ],
    ids=lambda clusterer: type(clusterer).__name__,
)
def test_clustering_of_graphs(clusterer, gait, data, distances):
    X, y, _ = data
    graph = make_pipeline(PoseRadiusNeighborsTransformer(gait.skeleton, radius=3.0), clusterer)
    labels = graph.fit_predict(X)
    assert homogeneity_score(y, labels) > 0.5
    if isinstance(clusterer, DBSCAN):
        np.testing.assert_array_equal(labels, clusterer.fit_predict(distances))


@pytest.mark.parametrize(
    "embedding",
    [
        TSNE(metric="precomputed", init="random", perplexity=10, random_state=0),
        Isomap(n_neighbors=10, metric="precomputed"),
    ],
    ids=lambda embedding: type(embedding).__name__,
)
def test_embeddings_of_graphs(embedding, gait, data, distances):
    X = data[0][:200]
    flat = make_pipeline(PoseKNeighborsTransformer(gait.skeleton, n_neighbors=35), embedding).fit_transform(X)
    assert trustworthiness(distances[:200, :200], flat, metric="precomputed") > 0.9
