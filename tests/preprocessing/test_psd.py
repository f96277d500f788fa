"""Repaired kernels, compared with the spectrum of their definition and with SVMs."""

import numpy as np
import pytest
from conftest import SKELETONS
from sklearn.svm import SVC

from skpose.preprocessing import PoseDistanceTransformer

HUMANOID = SKELETONS["humanoid"]
REPAIRS = "clip", "shift"


@pytest.fixture(scope="module")
def X():
    """Poses far apart, two of them twice, whose kernels have negative eigenvalues."""
    X = np.random.default_rng(0).normal(size=(60, HUMANOID.n_dofs))
    return np.concatenate([X, X[:2]])


@pytest.fixture(scope="module")
def new(X):
    return X[::6] + 0.3 * np.random.default_rng(1).normal(size=X[::6].shape)


def indefinite(psd="ignore", kernel="rbf"):
    """A transformer whose training kernel is far from positive semidefinite."""
    return PoseDistanceTransformer(HUMANOID, kernel=kernel, gamma=0.02, psd=psd)


@pytest.mark.parametrize("psd", REPAIRS)
@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_the_training_kernel_is_positive_semidefinite_and_that_of_transform(psd, dtype, X):
    X, rounding = X.astype(dtype), len(X) * np.finfo(dtype).eps
    for kernel in ("rbf", "laplacian"):
        transformer = indefinite(psd, kernel)
        K = transformer.fit_transform(X)
        assert K.dtype == dtype
        assert np.linalg.eigvalsh(K.astype(float)).min() > -10 * rounding
        np.testing.assert_array_equal(K, K.T)
        np.testing.assert_allclose(transformer.transform(X), K, atol=2 * rounding)
    assert np.linalg.eigvalsh(indefinite().fit_transform(X).astype(float)).min() < -1000 * rounding


def test_clip_is_the_nearest_positive_semidefinite_matrix(X, new):
    values, vectors = np.linalg.eigh(indefinite().fit_transform(X))
    transformer = indefinite("clip")
    np.testing.assert_allclose(transformer.fit_transform(X), (vectors * values.clip(0)) @ vectors.T, atol=1e-12)
    share = -values[values < 0].sum() / np.abs(values).sum()
    np.testing.assert_allclose(transformer.negative_share_, share, rtol=1e-9)
    kept = vectors[:, values > 0]  # on which new rows are projected
    expected = indefinite().fit(X).transform(new) @ kept @ kept.T
    np.testing.assert_allclose(transformer.transform(new), expected, atol=1e-12)


def test_shift_changes_only_the_kernel_of_equal_poses(X, new):
    K, transformer = indefinite().fit_transform(X), indefinite("shift")
    least = np.linalg.eigvalsh(K).min()
    equal = (X[:, None] == X).all(axis=2)
    np.testing.assert_allclose(transformer.fit_transform(X), K - least * equal, atol=1e-12)
    np.testing.assert_array_equal(transformer.transform(new), indefinite().fit(X).transform(new))


@pytest.mark.parametrize("psd", REPAIRS)
def test_kernels_of_euclidean_distances_stay_as_they_are(psd, X, new):
    for metric in ("angle", "position"):
        repaired = PoseDistanceTransformer(HUMANOID, metric=metric, kernel="rbf", psd=psd)
        plain = PoseDistanceTransformer(HUMANOID, metric=metric, kernel="rbf")
        np.testing.assert_array_equal(repaired.fit_transform(X), plain.fit_transform(X))
        np.testing.assert_array_equal(repaired.transform(new), plain.transform(new))
        assert repaired.negative_share_ == 0


def test_an_svm_finds_the_optimum_of_a_clipped_kernel(X):
    """The dual gap is closed."""
    y, K = np.where(np.random.default_rng(2).random(len(X)) < 0.5, -1, 1), indefinite("clip").fit_transform(X)
    svc = SVC(C=1e3, kernel="precomputed", tol=1e-8).fit(K, y)
    coefficients = np.zeros(len(y))  # α y
    coefficients[svc.support_] = svc.dual_coef_[0]
    norm = 0.5 * coefficients @ K @ coefficients
    primal = norm + 1e3 * np.maximum(0, 1 - y * svc.decision_function(K)).sum()
    np.testing.assert_allclose(np.abs(coefficients).sum() - norm, primal, rtol=1e-4)


def test_distances_are_not_repaired(X):
    with pytest.raises(ValueError, match="psd"):
        PoseDistanceTransformer(HUMANOID, psd="clip").fit(X)
