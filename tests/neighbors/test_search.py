"""The exact search: lower bounds are lower bounds, and the result is that of brute force."""

import numpy as np
import pytest
from conftest import SKELETONS

from skpose import pose_distances
from skpose._utils import parallel
from skpose.datasets import make_gait
from skpose.metrics import Angle, Spatial
from skpose.metrics._registry import METRICS, resolve
from skpose.neighbors import _graph, _search
from skpose.neighbors._index import PoseIndex

HUMANOID = SKELETONS["humanoid"]
MEASURED_DIRECTLY = [metric for metric in METRICS if metric != "geodesic"]
BOUNDED = [metric for metric in METRICS if METRICS[metric]().lower_bound() is not None]
N_STEPS = 1, 2, 3, 4, 5, 11, 100


@pytest.fixture(autouse=True)
def filter_small_searches(monkeypatch):
    monkeypatch.setattr(_search, "LEAST_WORK_TO_FILTER", 0)


@pytest.fixture(params=[True, False], ids=["always filter", "as estimated"])
def always_filter(request, monkeypatch):
    """Filter always, and only where the cost estimate says so."""
    if request.param:
        monkeypatch.setattr(_search.Search, "_saves_work", lambda *_: True)


def search_of(poses, skeleton, metric, *, brute=False, n_jobs=1):
    index = PoseIndex(poses, skeleton, resolve(metric, skeleton), brute=brute)
    index.sort_groups()
    return _graph.search_of(index, n_jobs)


def nearest(search, queries, k):
    """Distances and indices (n_queries, k)."""
    found = search.nearest(queries, np.full(len(queries), -1), k)
    np.testing.assert_array_equal(found.queries, np.repeat(np.arange(len(queries)), k))
    return found.distances.reshape(-1, k), found.indices.reshape(-1, k)


def within(search, queries, radius, **options):
    """A matrix of distances, NaN where there is no neighbour."""
    found = search.within(queries, np.full(len(queries), -1), np.full(len(queries), radius), **options)
    assert (np.diff(found.queries) >= 0).all()
    D = np.full((len(queries), len(search.index.poses)), np.nan)
    D[found.queries, found.indices] = found.distances
    assert np.isfinite(D).sum() == len(found.queries)
    return D


def brute_nearest(D, k):
    """By distance and then by index."""
    order = np.argsort(D, axis=1, kind="stable")[:, :k]
    return np.take_along_axis(D, order, axis=1), order


def clustered(skeleton, n, seed=0, spread=0.03):
    """Poses in clusters, so that bounds rule out many; every fifth is there twice."""
    rng = np.random.default_rng(seed)
    centres = rng.uniform(-1, 1, size=(10, skeleton.n_dofs))
    X = centres[rng.integers(10, size=n)] + spread * rng.normal(size=(n, skeleton.n_dofs))
    X[::5] = X[rng.permutation(n)[: len(X[::5])]]
    return X


# --- lower bounds ----------------------------------------------------------------------------------------------------


@pytest.mark.filterwarnings("ignore::sklearn.exceptions.ConvergenceWarning")  # their lengths are bounded too
@pytest.mark.parametrize("metric", BOUNDED)
def test_no_distance_is_below_that_of_the_metric_that_bounds_it(metric, skeleton):
    rng = np.random.default_rng(0)
    X = rng.uniform(-4, 4, size=(2, skeleton.n_dofs))
    near = [X + distance * rng.normal(size=X.shape) for distance in (0.0, 1e-8, 1e-3, 0.3)]
    Y = np.concatenate([*near, X + 2 * np.pi * rng.integers(-1, 2, X.shape), rng.uniform(-4, 4, size=X.shape)])
    D = pose_distances(X, Y, skeleton=skeleton, metric=metric)
    bounds = pose_distances(X, Y, skeleton=skeleton, metric=METRICS[metric]().lower_bound())
    assert (bounds <= (1 + 1e-12) * D + 1e-9 * np.abs(skeleton.offsets).sum()).all()


# --- searches --------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("metric", MEASURED_DIRECTLY)
@pytest.mark.parametrize("kind", ["clustered", "random", "identical", "one"])
@pytest.mark.usefixtures("always_filter")
def test_neighbours_are_those_of_brute_force(metric, kind):
    rng = np.random.default_rng(1)
    X = {
        "clustered": lambda: clustered(HUMANOID, 700),
        "random": lambda: rng.uniform(-3, 3, size=(700, HUMANOID.n_dofs)),
        "identical": lambda: np.repeat(rng.uniform(-3, 3, size=(1, HUMANOID.n_dofs)), 700, axis=0),
        "one": lambda: rng.uniform(-3, 3, size=(1, HUMANOID.n_dofs)),
    }[kind]()
    queries = np.concatenate([X[:20], X[:20] + 0.01 * rng.normal(size=X[:20].shape), X[:1] + 1])
    D = pose_distances(queries, X, skeleton=HUMANOID, metric=metric)
    search = search_of(X, HUMANOID, metric)
    for k in [k for k in (1, 5, 15, 50, 699) if k < len(X)] + [len(X)]:
        for got, expected in zip(nearest(search, queries, k), brute_nearest(D, k), strict=True):
            np.testing.assert_array_equal(got, expected)
    for radius in (0.0, np.quantile(D, 0.01), np.quantile(D, 0.5), D.max(), np.inf):
        np.testing.assert_array_equal(within(search, queries, radius), np.where(radius >= D, D, np.nan))


@pytest.mark.parametrize(
    "metric", [Angle(wrap=True), Spatial(wrap=False), *(Spatial(n_steps) for n_steps in N_STEPS)], ids=repr
)
@pytest.mark.usefixtures("always_filter")
def test_parameters_of_the_metric(metric):
    """Differences of more than π; and steps with a sample at the middle, without one, and with one near the middle."""
    rng = np.random.default_rng(0)
    X = clustered(HUMANOID, 400) + 2 * np.pi * rng.integers(-1, 2, size=(400, HUMANOID.n_dofs))
    D = pose_distances(X[:50], X, skeleton=HUMANOID, metric=metric)
    search = search_of(X, HUMANOID, metric)
    for got, expected in zip(nearest(search, X[:50], 6), brute_nearest(D, 6), strict=True):
        np.testing.assert_array_equal(got, expected)
    for radius in np.quantile(D, [0.1, 0.9]):
        np.testing.assert_array_equal(within(search, X[:50], radius), np.where(radius >= D, D, np.nan))


@pytest.mark.slow
@pytest.mark.parametrize("metric", MEASURED_DIRECTLY)
@pytest.mark.usefixtures("always_filter")
def test_the_split_of_the_work_changes_nothing(metric, monkeypatch):
    X = clustered(HUMANOID, 300)
    queries = X[:50]
    expected = {k: nearest(search_of(X, HUMANOID, metric), queries, k) for k in (3, 40)}
    radius = np.median(expected[40][0])
    near = within(search_of(X, HUMANOID, metric), queries, radius)
    monkeypatch.setattr(_search, "GROUPS_AT_ONCE", 4)
    monkeypatch.setattr(_search, "QUERIES", 33)
    monkeypatch.setattr(parallel, "LITTLE_WORK", 1)
    monkeypatch.setattr(parallel, "WORK_PER_TASK", 1e5)
    for n_jobs, brute in ((1, False), (3, False), (3, True)):
        search = search_of(X, HUMANOID, metric, n_jobs=n_jobs, brute=brute)
        for k in expected:
            np.testing.assert_array_equal(nearest(search, queries, k), expected[k])
        np.testing.assert_array_equal(within(search, queries, radius), near)


def test_few_lengths_are_measured_where_poses_are_dense():
    X, _ = make_gait(4, 3, rotations="file", random_state=0).poses(frame_rate=120)
    queries = X[::50] + 1e-3
    for k in (1, 15):
        search = search_of(X, HUMANOID, "spatial")
        nearest(search, queries, k)
        assert k <= search.n_measured / len(queries) < 2 * k + 8


# --- geodesics -------------------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def walk():
    X, _ = make_gait(2, 1, rotations="file", random_state=0).poses(frame_rate=30)
    return X[:120]


@pytest.fixture(scope="module")
def walk_queries(walk):
    """Poses of the walk, poses near it, and their distances to all of it."""
    near = walk[4:8] + 0.05 * np.random.default_rng(0).normal(size=(4, HUMANOID.n_dofs))
    queries = np.concatenate([walk[:4], near])
    return queries, pose_distances(queries, walk, skeleton=HUMANOID, metric="geodesic", n_jobs=2)


@pytest.fixture(scope="module")
def walk_and_whole_turns(walk):
    """The walk and some of its poses again, by whole turns away, and the distances of the first five to all."""
    whole_turns = 2 * np.pi * np.random.default_rng(0).integers(-1, 2, size=(20, HUMANOID.n_dofs))
    X = np.concatenate([walk, walk[:20] + whole_turns])
    return X, pose_distances(X[:5], X, skeleton=HUMANOID, metric="geodesic")


@pytest.mark.parametrize("brute", [False, True])
def test_geodesic_neighbours_are_those_of_brute_force(brute, walk, walk_queries):
    queries, D = walk_queries
    search = search_of(walk, HUMANOID, "geodesic", brute=brute, n_jobs=2)
    for got, expected in zip(nearest(search, queries, 5), brute_nearest(D, 5), strict=True):
        np.testing.assert_array_equal(got, expected)
    n_solved = search.n_measured
    assert n_solved == D.size if brute else 5 * len(queries) <= n_solved < 0.2 * D.size
    radius = np.quantile(D, 0.1)
    np.testing.assert_array_equal(within(search, queries, radius), np.where(radius >= D, D, np.nan))


@pytest.mark.parametrize("brute", [False, True])
def test_whole_turns_do_not_change_a_geodesic_distance(brute, walk, walk_and_whole_turns):
    X, D = walk_and_whole_turns
    assert (D[range(5), range(len(walk), len(walk) + 5)] < 1e-12).all()
    search = search_of(X, HUMANOID, "geodesic", brute=brute, n_jobs=2)
    for got, expected in zip(nearest(search, walk[:5], 2), brute_nearest(D, 2), strict=True):
        np.testing.assert_array_equal(got, expected)
    np.testing.assert_array_equal(within(search, walk[:5], 0.0), np.where(D == 0, 0.0, np.nan))
