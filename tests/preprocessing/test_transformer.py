import numpy as np
import pandas as pd
import pytest
from conftest import SKELETONS
from sklearn.utils.validation import check_is_fitted

from skpose import PoseDistanceTransformer, pose_distances
from skpose.metrics import Angle, Spatial

HUMANOID = SKELETONS["humanoid"]


@pytest.fixture(scope="module")
def X():
    return np.random.default_rng(0).normal(size=(20, HUMANOID.n_dofs))


@pytest.fixture(scope="module")
def D(X):
    return pose_distances(X, skeleton=HUMANOID)


@pytest.mark.parametrize("metric", ["auto", "rotation", Spatial(3, wrap=False), Angle(wrap=True)], ids=str)
def test_distances_are_those_of_pose_distances(metric, X):
    transformer = PoseDistanceTransformer(HUMANOID, metric=metric).fit(X[:15])
    expected = pose_distances(X, X[:15], skeleton=HUMANOID, metric=metric)
    np.testing.assert_array_equal(transformer.transform(X), expected)
    expected = pose_distances(X[:15], skeleton=HUMANOID, metric=metric)
    np.testing.assert_array_equal(transformer.fit_transform(X[:15]), expected)
    assert transformer.n_samples_fit_ == 15


@pytest.mark.parametrize("kernel", ["rbf", "laplacian"])
def test_kernels(kernel, X, D):
    transformer = PoseDistanceTransformer(HUMANOID, kernel=kernel, gamma=0.3)
    expected = np.exp(-0.3 * (D**2 if kernel == "rbf" else D))
    np.testing.assert_allclose(transformer.fit_transform(X), expected, rtol=1e-12)
    np.testing.assert_allclose(transformer.transform(X), expected, rtol=1e-9)
    scaled = PoseDistanceTransformer(HUMANOID, kernel=kernel).fit(X)
    scale = 2 / np.mean(D**2)
    np.testing.assert_allclose(scaled.gamma_, scale if kernel == "rbf" else np.sqrt(scale))


def test_scale_is_that_of_an_svm_for_standardised_features(X):
    X = (X - X.mean(axis=0)) / X.std(axis=0)
    transformer = PoseDistanceTransformer(metric="angle", kernel="rbf").fit(X)
    np.testing.assert_allclose(transformer.gamma_, 1 / (X.shape[1] * X.var()))
    assert PoseDistanceTransformer(metric="angle", kernel="rbf").fit(np.ones((3, 2))).gamma_ == 1.0


@pytest.mark.parametrize("metric", ["angle", "position"])
def test_kernels_of_euclidean_distances_are_positive_definite(metric, X):
    for kernel in ("rbf", "laplacian"):
        K = PoseDistanceTransformer(HUMANOID, metric=metric, kernel=kernel).fit_transform(X)
        assert np.linalg.eigvalsh(K).min() > -1e-12


def test_column_names_and_widths_are_checked_by_the_skeleton(X):
    frame = pd.DataFrame(X, columns=HUMANOID.dof_names)
    transformer = PoseDistanceTransformer(HUMANOID).fit(frame)
    check_is_fitted(transformer)
    np.testing.assert_array_equal(transformer.feature_names_in_, HUMANOID.dof_names)
    np.testing.assert_array_equal(transformer.transform(frame), transformer.transform(frame.copy()))
    with pytest.raises(ValueError, match=f"column 0 is .* and should be '{HUMANOID.dof_names[0]}'"):
        PoseDistanceTransformer(HUMANOID).fit(frame[frame.columns[::-1]])
    with pytest.raises(ValueError, match=f"X has 3 columns, but the skeleton has {HUMANOID.n_dofs} degrees of freedom"):
        PoseDistanceTransformer(HUMANOID).fit(X[:, :3])
    with pytest.raises(ValueError, match="the metric 'spatial' needs a skeleton"):
        PoseDistanceTransformer(metric="spatial").fit(X)


def test_repr_is_readable():
    assert repr(PoseDistanceTransformer(HUMANOID)) == f"PoseDistanceTransformer(skeleton={HUMANOID!r})"
