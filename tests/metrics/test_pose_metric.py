"""`pose_metric`: one compiled function of two poses, equal to `pose_distances`, for estimators and compiled code."""

import pickle

import numpy as np
import pytest
from conftest import SKELETONS, metric_of, with_either_wrap
from joblib import Parallel, delayed
from numba import config, njit
from numba.core.errors import NumbaWarning
from numba.core.registry import CPUDispatcher
from sklearn.base import clone
from sklearn.metrics import pairwise_distances
from sklearn.model_selection import GridSearchCV, cross_val_score
from sklearn.neighbors import KNeighborsClassifier

from skpose import Skeleton, pose_distances, pose_metric
from skpose.metrics import Spatial
from skpose.metrics._registry import METRICS

HUMANOID = SKELETONS["humanoid"]
CURVES = ["spatial", "geodesic"]  # need not obey the triangle inequality


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
    metric = metric_of(metric.name, **metric.get_params() | {"n_steps": 7})
    f = pose_metric(skeleton, metric=metric)
    expected = pose_distances(X, skeleton=skeleton, metric=metric)
    np.testing.assert_allclose(pairwise_distances(X, metric=f), expected, rtol=1e-12, atol=1e-14)


def test_takes_rows_of_any_kind(X):
    f, expected = pose_metric(HUMANOID, metric="spatial"), pose_distances(X[:2], skeleton=HUMANOID)[0, 1]
    fortran, frozen = np.asfortranarray(X), X.copy()
    frozen.setflags(write=False)
    for rows in (fortran, frozen, np.repeat(X, 2, axis=1)[:, ::2]):
        np.testing.assert_allclose(f(rows[0], rows[1]), expected, rtol=1e-14)
    single = X.astype(np.float32)
    np.testing.assert_allclose(f(single[0], single[1]), expected, rtol=1e-6)
    assert f(np.zeros(HUMANOID.n_dofs, dtype=int), np.zeros(HUMANOID.n_dofs)) == 0


def test_is_a_dispatcher_that_compiled_code_can_call(X):
    f = pose_metric(HUMANOID, metric="spatial")
    assert isinstance(f, CPUDispatcher)

    @njit
    def total(X):
        return f(X[0], X[1]) + f(X[1], X[2])

    D = pose_distances(X, skeleton=HUMANOID)
    np.testing.assert_allclose(total(X), D[0, 1] + D[1, 2], rtol=1e-12)


@pytest.mark.skipif(bool(config.DISABLE_JIT), reason="nothing is compiled")
def test_what_calls_it_is_not_cached_on_disk():
    """It holds an address of this process, which would be anything in another one."""
    f = pose_metric(HUMANOID, metric="position")

    @njit(cache=True)
    def distance(x, y):
        return f(x, y)

    with pytest.warns(NumbaWarning, match="it uses dynamic globals"):
        distance(np.zeros(HUMANOID.n_dofs), np.ones(HUMANOID.n_dofs))


@pytest.mark.skipif(bool(config.DISABLE_JIT), reason="nothing is compiled")
def test_another_skeleton_takes_the_same_compiled_function(X):
    """The functions of two skeletons hold no array, only an address each."""
    for skeleton in (HUMANOID, Skeleton.chain(5)):
        f = pose_metric(skeleton, metric="position")
        f(X[0, : skeleton.n_dofs], X[1, : skeleton.n_dofs])
        (code,) = f.inspect_llvm().values()
        assert code.count("constant [") < 20  # there were some thirty arrays more


@pytest.mark.slow
@pytest.mark.skipif(bool(config.DISABLE_JIT), reason="a plain closure, which nothing can pickle")
def test_in_another_process():
    f, (x, y) = pose_metric(Skeleton.chain(2)), np.array([[0.0, 1.0], [2.0, -1.0]])
    assert Parallel(2, "loky")(delayed(f)(x, y) for _ in range(2)) == 2 * [f(x, y)]


def test_equal_arguments_give_the_same_function():
    f = pose_metric(Skeleton.chain(2), metric="spatial")
    assert pose_metric(Skeleton.chain(2)) is f
    assert pose_metric(Skeleton.chain(2), metric=Spatial()) is f
    assert pose_metric(Skeleton.chain(2), metric=Spatial(9)) is not f
    assert pickle.loads(pickle.dumps(f)) is f
    assert clone(KNeighborsClassifier(metric=f)).metric is f


@pytest.mark.slow
def test_survives_other_processes_and_searches(X):
    y = np.arange(len(X)) % 2
    f, g = pose_metric(HUMANOID, metric="spatial"), pose_metric(metric="angle")
    knn = KNeighborsClassifier(1, metric=f, algorithm="brute")
    here = cross_val_score(knn, X, y, cv=3)
    np.testing.assert_array_equal(cross_val_score(knn, X, y, cv=3, n_jobs=2), here)
    search = GridSearchCV(knn, {"metric": [f, g], "n_neighbors": [1, 3]}, cv=3, n_jobs=2).fit(X, y)
    assert len(search.cv_results_["params"]) == 4


@pytest.mark.parametrize("metric", [name for name in METRICS if name not in CURVES])
def test_true_metrics_work_in_a_ball_tree(metric, X):
    y = np.arange(len(X)) % 2
    f = pose_metric(HUMANOID, metric=metric)
    tree, brute = (KNeighborsClassifier(1, metric=f, algorithm=a).fit(X[:8], y[:8]) for a in ("ball_tree", "brute"))
    np.testing.assert_allclose(tree.kneighbors(X[8:])[0], brute.kneighbors(X[8:])[0], rtol=1e-12)


def test_wrong_lengths_are_refused():
    f, g = pose_metric(Skeleton.chain(3), metric="position"), pose_metric(metric="angle")
    with pytest.raises(ValueError, match="the skeleton has 3 degrees of freedom"):
        f(np.zeros(3), np.zeros(4))
    with pytest.raises(ValueError, match="the two poses differ in length"):
        g(np.zeros(3), np.zeros(4))
    with pytest.raises(ValueError, match="the metric 'spatial' needs a skeleton"):
        pose_metric(metric="spatial")
    with pytest.raises(ValueError, match="The 'metric' parameter of pose_metric must be"):
        pose_metric(metric="euclidean")
