"""Distances and kernels as a step of a pipeline."""

import numpy as np
import pandas as pd
import pytest
from conftest import SKELETONS

from skpose import pose_distances
from skpose.metrics import Angle, Spatial
from skpose.preprocessing import PoseDistanceTransformer

HUMANOID = SKELETONS["humanoid"]


@pytest.fixture(scope="module")
def X():
    return np.random.default_rng(0).normal(size=(20, HUMANOID.n_dofs))


@pytest.mark.parametrize("metric", ["auto", Spatial(3, wrap=False), Angle(wrap=True)], ids=str)
def test_distances_are_those_of_pose_distances(metric, X):
    transformer = PoseDistanceTransformer(HUMANOID, metric=metric).fit(X[:15])
    expected = pose_distances(X, X[:15], skeleton=HUMANOID, metric=metric)
    np.testing.assert_array_equal(transformer.transform(X), expected)
    expected = pose_distances(X[:15], skeleton=HUMANOID, metric=metric)
    np.testing.assert_array_equal(transformer.fit_transform(X[:15]), expected)


@pytest.mark.parametrize("kernel", ["rbf", "laplacian"])
def test_kernels(kernel, X):
    D, transformer = pose_distances(X, skeleton=HUMANOID), PoseDistanceTransformer(HUMANOID, kernel=kernel, gamma=0.3)
    expected = np.exp(-0.3 * (D**2 if kernel == "rbf" else D))
    np.testing.assert_allclose(transformer.fit_transform(X), expected, rtol=1e-12)
    np.testing.assert_allclose(transformer.transform(X), expected, rtol=1e-9)
    scaled, scale = PoseDistanceTransformer(HUMANOID, kernel=kernel).fit(X), 2 / np.mean(D**2)
    np.testing.assert_allclose(scaled.gamma_, scale if kernel == "rbf" else np.sqrt(scale))


def test_scale_is_that_of_an_svm_for_standardised_features(X):
    X = (X - X.mean(axis=0)) / X.std(axis=0)
    transformer = PoseDistanceTransformer(metric="angle", kernel="rbf").fit(X)
    np.testing.assert_allclose(transformer.gamma_, 1 / (X.shape[1] * X.var()))
    assert PoseDistanceTransformer(metric="angle", kernel="rbf").fit(np.ones((3, 2))).gamma_ == 1.0


def test_column_names_are_checked_by_the_skeleton(X):
    frame = pd.DataFrame(X, columns=HUMANOID.dof_names)
    transformer = PoseDistanceTransformer(HUMANOID).fit(frame)
    np.testing.assert_array_equal(transformer.feature_names_in_, HUMANOID.dof_names)
    for bad in (frame[frame.columns[::-1]], X[:, :3]):
        with pytest.raises(ValueError, match=r"column"):
            PoseDistanceTransformer(HUMANOID).fit(bad)
