"""Kernels of whole motions: the formula, the width that `fit` chooses, the repair, support vector machines."""

import numpy as np
import pytest
from sklearn.model_selection import GridSearchCV, LeaveOneGroupOut, cross_val_score
from sklearn.pipeline import make_pipeline
from sklearn.svm import SVC

from skpose import Skeleton, motion_distances
from skpose.datasets import make_gait
from skpose.motions import MotionDistanceTransformer
from skpose.motions._distances import MotionMatrix

ARM = Skeleton.chain(3)


@pytest.fixture(scope="module")
def motions():
    rng = np.random.default_rng(0)
    return [np.cumsum(rng.normal(size=(n, 3)), axis=0) for n in (4, 7, 2, 5, 6, 3, 8, 5, 4, 9)]


@pytest.mark.parametrize(("kernel", "power"), [("rbf", 2), ("laplacian", 1)])
def test_kernels_are_those_of_their_formula(kernel, power, motions):
    train, new = motions[:7], motions[7:]
    transformer = MotionDistanceTransformer(ARM, kernel=kernel)
    K = transformer.fit_transform(train)
    D = motion_distances(train, skeleton=ARM)
    gamma = (2 / np.mean(D**2)) ** (power / 2)
    assert transformer.gamma_ == pytest.approx(gamma, rel=1e-12)
    np.testing.assert_allclose(K, np.exp(-gamma * D**power), rtol=1e-12)
    np.testing.assert_allclose(
        transformer.transform(new), np.exp(-gamma * motion_distances(new, train, skeleton=ARM) ** power), rtol=1e-12
    )
    np.testing.assert_array_equal(MotionDistanceTransformer(ARM, kernel=kernel).fit(train).transform(new),
                                  transformer.transform(new))  # fmt: skip
    given = MotionDistanceTransformer(ARM, kernel=kernel, gamma=0.3).fit_transform(train)
    np.testing.assert_allclose(given, np.exp(-0.3 * D**power), rtol=1e-12)


@pytest.mark.parametrize("psd", ["ignore", "clip", "shift"])
def test_each_pair_is_aligned_once(psd, motions, monkeypatch):
    shapes, write = [], MotionMatrix.write

    def counted(self, *arguments):
        shapes.append(self.shape)
        return write(self, *arguments)

    monkeypatch.setattr(MotionMatrix, "write", counted)
    MotionDistanceTransformer(ARM, kernel="rbf", psd=psd).fit_transform(motions)
    assert shapes == [(10, 10)]


@pytest.mark.parametrize("psd", ["clip", "shift"])
def test_kernels_are_repaired(psd, motions):
    K = MotionDistanceTransformer(ARM, metric="angle", kernel="rbf", gamma=0.02).fit_transform(motions)
    least = np.linalg.eigvalsh(K)[0]
    assert least < -1e-6, "nothing to repair: take other motions"
    transformer = MotionDistanceTransformer(ARM, metric="angle", kernel="rbf", gamma=0.02, psd=psd)
    repaired = transformer.fit_transform(motions)
    assert np.linalg.eigvalsh(repaired)[0] > -1e-12
    assert transformer.negative_share_ > 0
    np.testing.assert_allclose(transformer.transform(motions), repaired, atol=1e-12)


def test_support_vectors_of_motions_recognise_gait():
    gait = make_gait(n_subjects=4, n_sequences=2, duration=1.5, frame_rate=12, random_state=0)
    svc = make_pipeline(MotionDistanceTransformer(gait.skeleton, kernel="rbf"), SVC(kernel="precomputed"))
    folds = {"groups": gait.subjects, "cv": LeaveOneGroupOut()}
    assert cross_val_score(svc, gait, gait.actions, **folds).mean() == 1.0
    shuffled = np.random.default_rng(1).permutation(gait.actions)
    assert cross_val_score(svc, gait, shuffled, **folds).mean() < 0.9
    grid = {"motiondistancetransformer__metric": ["position", "velocity"], "svc__C": [1, 10]}
    assert GridSearchCV(svc, grid, cv=3).fit(gait, gait.actions).best_score_ > 0.9


def test_what_is_no_kernel_is_refused(motions):
    with pytest.raises(ValueError, match="psd"):
        MotionDistanceTransformer(ARM, psd="clip").fit(motions)
    with pytest.raises(ValueError, match="subsequence"):
        MotionDistanceTransformer(ARM, kernel="rbf", alignment="subsequence").fit(motions)
