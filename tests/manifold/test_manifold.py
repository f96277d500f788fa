import numpy as np
import pytest
from conftest import SKELETONS
from scipy.stats import mannwhitneyu
from sklearn.decomposition import PCA
from sklearn.metrics import silhouette_score
from sklearn.utils import get_tags

from skpose import pose_distances
from skpose.manifold import SpatialMDS

HUMANOID = SKELETONS["humanoid"]


@pytest.fixture(scope="module")
def X():
    return np.random.default_rng(0).normal(size=(30, HUMANOID.n_dofs)) * 0.3


@pytest.fixture(scope="module")
def D(X):
    return pose_distances(X, skeleton=HUMANOID)


def torgerson(D):
    """Spectrum and vectors of −½ J D² J, by the definition."""
    J = np.eye(len(D)) - 1 / len(D)
    values, vectors = np.linalg.eigh(-0.5 * J @ np.square(D) @ J)
    return values[::-1], vectors[:, ::-1]


def assert_equal_but_for_signs(A, B, **tolerance):
    np.testing.assert_allclose(np.abs(A), np.abs(B), **tolerance)
    np.testing.assert_allclose(A @ A.T, B @ B.T, **tolerance)


@pytest.mark.parametrize("n", [30, 300, pytest.param(2100, marks=pytest.mark.slow)], ids=["dense", "Lanczos", "many"])
def test_angle_metric_is_pca(n):
    X = np.random.default_rng(0).normal(size=(n, 6)) * [6, 5, 4, 3, 2, 1]
    mds, pca = SpatialMDS(n_components=3, metric="angle").fit(X), PCA(3).fit(X)
    assert_equal_but_for_signs(mds.embedding_[:50], pca.transform(X)[:50], atol=1e-8)
    np.testing.assert_allclose(mds.explained_variance_ratio_, pca.explained_variance_ratio_, rtol=1e-8)
    new = np.random.default_rng(1).normal(size=(9, 6))
    assert_equal_but_for_signs(mds.transform(new), pca.transform(new), atol=1e-8)
    assert mds.negative_share_ < 1e-10


@pytest.mark.parametrize("metric", ["position", "rotation", "spatial"])
def test_agrees_with_the_definition(metric, X):
    mds = SpatialMDS(HUMANOID, n_components=4, metric=metric).fit(X)
    values, vectors = torgerson(pose_distances(X, skeleton=HUMANOID, metric=metric))
    np.testing.assert_allclose(mds.eigenvalues_, values[:4], rtol=1e-9)
    assert_equal_but_for_signs(mds.embedding_, vectors[:, :4] * np.sqrt(values[:4]), atol=1e-9)
    np.testing.assert_allclose(mds.explained_variance_ratio_, values[:4] / values[values > 0].sum(), rtol=1e-9)
    np.testing.assert_allclose(mds.negative_share_, -values[values < 0].sum() / np.abs(values).sum(), atol=1e-9)
    columns = np.arange(4)
    assert (mds.embedding_[np.abs(mds.embedding_).argmax(axis=0), columns] > 0).all()


def test_lanczos_agrees_with_the_dense_decomposition():
    D = pose_distances(np.random.default_rng(0).normal(size=(400, HUMANOID.n_dofs)), skeleton=HUMANOID)
    values, vectors = torgerson(D)
    mds = SpatialMDS(n_components=3, metric="precomputed").fit(D)
    np.testing.assert_allclose(mds.eigenvalues_, values[:3], rtol=1e-10)
    assert_equal_but_for_signs(mds.embedding_, vectors[:, :3] * np.sqrt(values[:3]), atol=1e-7)


@pytest.mark.parametrize("parameters", [{}, {"metric": "position"}, {"landmarks": 12}])
def test_transform_of_training_poses_is_their_embedding(parameters, X):
    mds = SpatialMDS(HUMANOID, n_components=3, random_state=0, **parameters)
    embedding = mds.fit_transform(X)
    assert embedding is mds.embedding_
    np.testing.assert_allclose(mds.transform(X), embedding, atol=1e-9)


def test_precomputed_distances(X, D):
    given, own = SpatialMDS(n_components=3, metric="precomputed"), SpatialMDS(HUMANOID, n_components=3)
    before = D.copy()
    np.testing.assert_allclose(given.fit_transform(D[:20, :20]), own.fit_transform(X[:20]), atol=1e-10)
    np.testing.assert_allclose(given.transform(D[20:, :20]), own.transform(X[20:]), atol=1e-10)
    np.testing.assert_array_equal(D, before)
    assert get_tags(given).input_tags.pairwise
    assert not get_tags(own).input_tags.pairwise
    with pytest.raises(ValueError, match=r"must be a square matrix to fit, got shape \(20, 19\)"):
        given.fit(D[:20, :19])
    with pytest.raises(ValueError, match="symmetric"):
        given.fit(np.triu(D))
    with pytest.raises(ValueError, match="Negative values in data passed to SpatialMDS as precomputed distances"):
        given.fit(-D)


def test_distances_of_a_star_have_negative_eigenvalues_and_no_nan():
    """No points of a Euclidean space are at distance 1 from a hub and, four of them, 2 from each other."""
    D = np.full((5, 5), 2.0)
    D[0] = D[:, 0] = 1.0
    np.fill_diagonal(D, 0)
    with pytest.warns(UserWarning, match="only 3 of the leading 5 eigenvalues"):
        mds = SpatialMDS(n_components=5, metric="precomputed").fit(D)
    values, _ = torgerson(D)
    np.testing.assert_allclose(mds.negative_share_, -values[values < 0].sum() / np.abs(values).sum())
    assert mds.negative_share_ > 0.05
    assert np.isfinite(mds.embedding_).all()
    np.testing.assert_array_equal(mds.embedding_[:, 3:], 0)
    np.testing.assert_array_equal(mds.transform(D)[:, 3:], 0)
    np.testing.assert_allclose(mds.explained_variance_ratio_.sum(), 1)


def test_a_few_landmarks_place_euclidean_data_exactly():
    """One landmark more than dimensions determines every point."""
    X = np.random.default_rng(0).normal(size=(200, 3))
    mds = SpatialMDS(n_components=3, landmarks=4, random_state=0, metric="angle").fit(X)
    assert mds.landmark_indices_.shape == (4,)
    np.testing.assert_array_equal(mds.X_fit_, X[mds.landmark_indices_])
    np.testing.assert_allclose(
        pose_distances(mds.embedding_, metric="angle"), pose_distances(X, metric="angle"), atol=1e-8
    )
    same = SpatialMDS(n_components=3, landmarks=4, random_state=0, metric="angle").fit(X)
    np.testing.assert_array_equal(same.embedding_, mds.embedding_)


def test_figures_of_the_paper_on_cmu_sequences(cmu):
    """Section 3.2: modes at 0.40 and 0.80 in the paper, p below 1e-6."""
    shares = {
        metric: [
            SpatialMDS(m.skeleton, n_components=1, metric=metric)
            .fit(m.resample(12).angles)
            .explained_variance_ratio_[0]
            for m in cmu
        ]
        for metric in ("angle", "spatial")
    }
    assert abs(np.median(shares["angle"]) - 0.40) < 0.03
    assert abs(np.median(shares["spatial"]) - 0.81) < 0.03
    assert mannwhitneyu(shares["spatial"], shares["angle"]).pvalue < 1e-6


@pytest.mark.parametrize(("other", "angle", "spatial"), [(("35", "01"), 0.29, 0.04), (("07", "05"), 0.60, 0.13)])
def test_figure_4_two_peoples_walks_mix_under_the_spatial_metric(other, angle, spatial, cmu):
    names = list(zip(cmu.subjects, cmu.trials, strict=True))
    both = cmu[[names.index(("02", "01")), names.index(other)]]
    X, sequence = both.poses(frame_rate=12)
    for metric, expected in (("angle", angle), ("spatial", spatial)):
        points = SpatialMDS(both.skeleton, n_components=2, metric=metric).fit_transform(X)
        assert abs(silhouette_score(points, sequence) - expected) < 0.03
