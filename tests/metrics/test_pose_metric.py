"""`pose_metric`: one compiled function of two poses, for estimators and compiled code."""

import pickle
from contextlib import nullcontext

import numpy as np
import pytest
from conftest import SKELETONS, with_either_wrap
from joblib import Parallel, delayed
from numba import config, njit
from numba.core.errors import NumbaWarning
from sklearn.base import clone
from sklearn.metrics import pairwise_distances
from sklearn.model_selection import GridSearchCV
from sklearn.neighbors import KNeighborsClassifier

from skpose import Skeleton, pose_distances, pose_metric
from skpose.metrics import Spatial
from skpose.metrics._registry import METRICS

HUMANOID = SKELETONS["humanoid"]


@pytest.fixture
def X():
    return np.random.default_rng(0).normal(size=(12, HUMANOID.n_dofs))


@pytest.mark.parametrize("metric", with_either_wrap(METRICS), ids=repr)
def test_equals_pose_distances(metric, X):
    skeleton = HUMANOID
    if metric.iterative:  # a smaller skeleton and poses near each other, to be quick
        skeleton = SKELETONS["tree"]
        X = 0.1 * X[:, : skeleton.n_dofs]
    X[:, 3] += 6.0
    f = pose_metric(skeleton, metric=metric)
    expected = pose_distances(X, skeleton=skeleton, metric=metric)
    np.testing.assert_allclose(pairwise_distances(X, metric=f), expected, rtol=1e-12, atol=1e-14)


def test_takes_rows_of_any_kind(X):
    f, expected = pose_metric(HUMANOID, metric="spatial"), pose_distances(X[:2], skeleton=HUMANOID)[0, 1]
    frozen = X.copy()
    frozen.setflags(write=False)
    for rows in (np.asfortranarray(X), frozen):
        np.testing.assert_allclose(f(rows[0], rows[1]), expected, rtol=1e-14)
    single = X.astype(np.float32)
    np.testing.assert_allclose(f(single[0], single[1]), expected, rtol=1e-6)


def test_compiled_code_can_call_it(X):
    f = pose_metric(HUMANOID, metric="spatial")

    @njit
    def total(X):
        return f(X[0], X[1]) + f(X[1], X[2])

    D = pose_distances(X, skeleton=HUMANOID)
    np.testing.assert_allclose(total(X), D[0, 1] + D[1, 2], rtol=1e-12)


@pytest.mark.skipif(bool(config.DISABLE_JIT), reason="nothing is compiled")
def test_its_callers_are_not_cached_on_disk():
    """It holds an address of this process."""
    f = pose_metric(HUMANOID, metric="position")

    @njit(cache=True)
    def distance(x, y):
        return f(x, y)

    with pytest.warns(NumbaWarning, match="dynamic globals"):
        distance(np.zeros(HUMANOID.n_dofs), np.ones(HUMANOID.n_dofs))


def test_equal_arguments_give_the_same_function():
    f = pose_metric(HUMANOID, metric="spatial")
    assert pose_metric(HUMANOID, metric=Spatial()) is f
    assert pose_metric(HUMANOID, metric=Spatial(9)) is not f
    assert pickle.loads(pickle.dumps(f)) is f
    assert clone(KNeighborsClassifier(metric=f)).metric is f


@pytest.mark.slow
@pytest.mark.skipif(bool(config.DISABLE_JIT), reason="a plain closure, which nothing can pickle")
def test_in_other_processes_and_in_searches(X):
    y, f = np.arange(len(X)) % 2, pose_metric(HUMANOID, metric="spatial")
    assert Parallel(2, "loky")(delayed(f)(X[0], X[1]) for _ in range(2)) == 2 * [f(X[0], X[1])]
    knn = KNeighborsClassifier(1, metric=f, algorithm="brute")
    search = GridSearchCV(knn, {"metric": [f, pose_metric(metric="angle")]}, cv=3, n_jobs=2).fit(X, y)
    assert np.isfinite(search.cv_results_["mean_test_score"]).all()


def test_true_metrics_work_in_a_ball_tree(X):
    for metric in ("angle", "position", "rotation"):
        f = pose_metric(HUMANOID, metric=metric)
        tree, brute = (KNeighborsClassifier(1, metric=f, algorithm=a).fit(X, range(12)) for a in ("ball_tree", "brute"))
        np.testing.assert_allclose(tree.kneighbors(X + 0.1)[0], brute.kneighbors(X + 0.1)[0], rtol=1e-12)


@pytest.mark.parametrize("n_bones", [15, 16])
def test_spatial_warns_where_scikit_learn_picks_a_ball_tree(n_bones):
    with pytest.warns(UserWarning, match='algorithm="brute"') if n_bones == 15 else nullcontext():
        pose_metric(Skeleton.chain(n_bones), metric="spatial")
    pose_metric(Skeleton.chain(n_bones), metric="position")  # without a warning


def test_other_lengths_are_refused():
    f, g = pose_metric(Skeleton.chain(3), metric="position"), pose_metric(metric="angle")
    with pytest.raises(ValueError, match="3 numbers"):
        f(np.zeros(3), np.zeros(4))
    with pytest.raises(ValueError, match="same length"):
        g(np.zeros(3), np.zeros(4))
