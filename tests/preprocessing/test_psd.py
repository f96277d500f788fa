"""Kernels that are repaired, compared with the spectrum of their definition and with SVMs."""

import numpy as np
import pytest
from conftest import SKELETONS
from sklearn.decomposition import KernelPCA
from sklearn.model_selection import GroupKFold, cross_val_score
from sklearn.pipeline import make_pipeline
from sklearn.svm import SVC

from skpose import PoseDistanceTransformer, pose_distances
from skpose.datasets import make_gait

HUMANOID = SKELETONS["humanoid"]
EPS = np.finfo(np.float64).eps
REPAIRS = "clip", "shift"


@pytest.fixture(scope="module")
def X():
    """Poses far apart, two of them twice, whose kernels have negative eigenvalues."""
    X = np.random.default_rng(0).normal(size=(60, HUMANOID.n_dofs))
    return np.concatenate([X, X[:2]])


@pytest.fixture(scope="module")
def new(X):
    return X[::6] + 0.3 * np.random.default_rng(1).normal(size=X[::6].shape)


def indefinite(kernel="rbf", psd="ignore", **parameters):
    """A transformer whose training kernel is far from positive semidefinite."""
    return PoseDistanceTransformer(HUMANOID, kernel=kernel, gamma=0.02, psd=psd, **parameters)


@pytest.mark.parametrize("psd", REPAIRS)
@pytest.mark.parametrize("kernel", ["rbf", "laplacian"])
@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_the_training_kernel_is_positive_semidefinite_up_to_rounding(kernel, psd, dtype, X):
    plain = indefinite(kernel).fit_transform(X.astype(dtype))
    K = indefinite(kernel, psd).fit_transform(X.astype(dtype))
    assert K.dtype == plain.dtype == dtype
    rounding = len(X) * np.finfo(dtype).eps
    assert np.linalg.eigvalsh(K.astype(float)).min() > -10 * rounding
    if kernel == "rbf":
        assert np.linalg.eigvalsh(plain.astype(float)).min() < -1000 * rounding
    np.testing.assert_array_equal(K, K.T)


def test_clip_is_the_nearest_positive_semidefinite_matrix(X):
    values, vectors = np.linalg.eigh(indefinite().fit_transform(X))
    transformer = indefinite(psd="clip")
    np.testing.assert_allclose(transformer.fit_transform(X), (vectors * values.clip(0)) @ vectors.T, atol=1e-12)
    share = -values[values < 0].sum() / np.abs(values).sum()
    np.testing.assert_allclose(transformer.negative_share_, share, rtol=1e-9)
    assert share > 0.001


def test_shift_changes_the_kernel_of_equal_poses_alone(X, new):
    K, transformer = indefinite().fit_transform(X), indefinite(psd="shift")
    least = np.linalg.eigvalsh(K).min()
    equal = (X[:, None] == X).all(axis=2)
    assert equal.sum() == len(X) + 4
    np.testing.assert_allclose(transformer.fit_transform(X), K - least * equal, atol=1e-12)
    np.testing.assert_array_equal(transformer.transform(new), indefinite().fit(X).transform(new))
    np.testing.assert_allclose(transformer.negative_share_, indefinite(psd="clip").fit(X).negative_share_, rtol=1e-9)


@pytest.mark.parametrize("psd", REPAIRS)
@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_transform_of_the_training_poses_is_their_kernel(psd, dtype, X):
    poses = X.astype(dtype)
    transformer = indefinite(psd=psd)
    K = transformer.fit_transform(poses)
    np.testing.assert_allclose(transformer.transform(poses), K, atol=100 * np.finfo(dtype).eps)
    np.testing.assert_array_equal(indefinite(psd=psd).fit(poses).transform(poses), transformer.transform(poses))


def test_clipped_rows_of_new_poses_are_projected(X, new):
    """A new row is the old one less its part along the eigenvectors that the training kernel has lost."""
    values, vectors = np.linalg.eigh(indefinite().fit_transform(X))
    rows = indefinite().fit(X).transform(new)
    kept = vectors[:, values > 0]
    np.testing.assert_allclose(indefinite(psd="clip").fit(X).transform(new), rows @ kept @ kept.T, atol=1e-12)


@pytest.mark.parametrize("psd", REPAIRS)
@pytest.mark.parametrize("metric", ["angle", "position"])
@pytest.mark.parametrize("kernel", ["rbf", "laplacian"])
def test_kernels_of_euclidean_distances_stay_as_they_are(psd, metric, kernel, X, new):
    repaired = PoseDistanceTransformer(HUMANOID, metric=metric, kernel=kernel, psd=psd)
    plain = PoseDistanceTransformer(HUMANOID, metric=metric, kernel=kernel)
    np.testing.assert_array_equal(repaired.fit_transform(X), plain.fit_transform(X))
    np.testing.assert_array_equal(repaired.transform(new), plain.transform(new))
    assert repaired.negative_share_ == 0


def dual_objective(K, y, svc):
    """What an SVM maximises: the sum of α less half of the squared norm of its normal vector."""
    coefficients = np.zeros(len(y))  # α y
    coefficients[svc.support_] = svc.dual_coef_[0]
    return np.abs(coefficients).sum() - 0.5 * coefficients @ K @ coefficients


def test_an_svm_finds_the_optimum_of_a_clipped_kernel(X):
    """No other point is better, that of the kernel as it was included; and the dual gap is closed."""
    y = np.where(np.random.default_rng(2).random(len(X)) < 0.5, -1, 1)
    plain, K = indefinite().fit_transform(X), indefinite(psd="clip").fit_transform(X)
    on_plain, on_repaired = (SVC(C=1e3, kernel="precomputed", tol=1e-8).fit(each, y) for each in (plain, K))
    assert dual_objective(K, y, on_repaired) >= dual_objective(K, y, on_plain)
    values = on_repaired.decision_function(K)
    coefficients = np.zeros(len(y))
    coefficients[on_repaired.support_] = on_repaired.dual_coef_[0]
    primal = 0.5 * coefficients @ K @ coefficients + 1e3 * np.maximum(0, 1 - y * values).sum()
    np.testing.assert_allclose(dual_objective(K, y, on_repaired), primal, rtol=1e-4)


def test_estimators_that_refuse_indefinite_kernels_take_repaired_ones(X):
    with pytest.raises(ValueError, match="There are significant negative eigenvalues"):
        make_pipeline(indefinite(), KernelPCA(kernel="precomputed")).fit(X)
    for psd in REPAIRS:
        points = make_pipeline(indefinite(psd=psd), KernelPCA(kernel="precomputed")).fit_transform(X)
        assert np.isfinite(points).all()


def test_repaired_kernels_classify_in_cross_validation():
    gait = make_gait(4, 2, duration=1.0, random_state=0)
    X, sequence = gait.poses(frame_rate=10)
    y, person = gait.actions[sequence], gait.subjects[sequence]
    scores = {
        psd: cross_val_score(
            make_pipeline(PoseDistanceTransformer(gait.skeleton, kernel="rbf", psd=psd), SVC(kernel="precomputed")),
            X,
            y,
            groups=person,
            cv=GroupKFold(4),
        ).mean()
        for psd in ("ignore", *REPAIRS)
    }
    assert min(scores.values()) > 0.9


def test_equal_poses_have_a_kernel_of_ones():
    for psd in REPAIRS:
        transformer = PoseDistanceTransformer(metric="angle", kernel="rbf", psd=psd)
        np.testing.assert_array_equal(transformer.fit_transform(np.ones((5, 3))), np.ones((5, 5)))
        assert transformer.negative_share_ == 0


def test_distances_are_not_repaired(X):
    with pytest.raises(ValueError, match='psd="clip" repairs a kernel, got kernel=None'):
        PoseDistanceTransformer(HUMANOID, psd="clip").fit(X)
    with pytest.raises(ValueError, match="'psd' parameter of PoseDistanceTransformer must be a str among"):
        PoseDistanceTransformer(HUMANOID, kernel="rbf", psd="flip").fit(X)


def test_the_memory_of_a_repair_is_its_negative_eigenvectors(X):
    D = pose_distances(X, skeleton=HUMANOID)
    n_negative = (np.linalg.eigvalsh(np.exp(-0.02 * D**2)) < -len(X) * EPS).sum()
    repair = indefinite(psd="clip").fit(X)._repair
    assert repair.vectors.shape == (len(X), n_negative)
