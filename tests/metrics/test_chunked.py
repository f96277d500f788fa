"""`pose_distances_chunked` keeps the contract of scikit-learn's `pairwise_distances_chunked`."""

import numpy as np
import pytest
from conftest import random_tree
from scipy.sparse import csr_array
from sklearn import config_context
from sklearn.metrics import pairwise_distances_chunked

from skpose import pose_distances, pose_distances_chunked
from skpose.metrics._registry import METRICS

TREE = random_tree(0)
QUICK = [name for name in METRICS if name != "geodesic"]
MEMORY = 10 * 100 * 8 / 2**20  # MiB for ten rows of a hundred


@pytest.fixture(scope="module")
def X():
    return np.random.default_rng(0).normal(size=(100, TREE.n_dofs))


def nearest(chunk, start):
    return chunk.argmin(axis=1), chunk.min(axis=1)


@pytest.mark.parametrize("Y", [None, slice(0, 100, 1)])
@pytest.mark.parametrize(
    "reduce_func",
    [
        None,
        lambda chunk, start: chunk.sum(axis=1) + start,
        nearest,
        lambda chunk, start: csr_array(chunk < 7),
        lambda chunk, start: [list(np.flatnonzero(row < 7)) for row in chunk],
    ],
    ids=["chunks", "array", "tuple", "sparse", "lists"],
)
def test_results_are_those_of_scikit_learn(X, Y, reduce_func):
    """On plain Euclidean distances, chunk by chunk."""
    Y = None if Y is None else X[Y] + 0.01
    options = {"reduce_func": reduce_func, "working_memory": MEMORY}
    ours = list(pose_distances_chunked(X, Y, metric="angle", **options))
    theirs = list(pairwise_distances_chunked(X, Y, metric="euclidean", **options))
    assert len(ours) == len(theirs) == 10
    for our, their in zip(ours, theirs, strict=True):
        assert type(our) is type(their)
        for a, b in zip(*((part if isinstance(part, tuple) else (part,)) for part in (our, their)), strict=True):
            if hasattr(a, "toarray"):
                a, b = a.toarray(), b.toarray()
            if isinstance(a, list):
                assert a == b
            else:
                np.testing.assert_allclose(a, b, atol=1e-6)


@pytest.mark.parametrize("metric", QUICK)
@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_chunks_are_the_rows_of_the_matrix(X, metric, dtype):
    X, Y = X.astype(dtype), X[:30].astype(dtype) + dtype(0.1)
    expected = pose_distances(X, Y, skeleton=TREE, metric=metric)
    chunks = list(pose_distances_chunked(X, Y, skeleton=TREE, metric=metric, working_memory=MEMORY))
    assert [len(chunk) for chunk in chunks] == ([33, 33, 33, 1] if dtype == np.float64 else [66, 34])
    assert {chunk.dtype for chunk in chunks} == {expected.dtype}
    np.testing.assert_array_equal(np.concatenate(chunks), expected)
    whole = np.concatenate(list(pose_distances_chunked(X, skeleton=TREE, metric=metric, working_memory=MEMORY)))
    np.testing.assert_allclose(
        whole, pose_distances(X, skeleton=TREE, metric=metric), rtol=1e-4 if dtype == np.float32 else 1e-9
    )
    assert (whole.diagonal() == 0).all()


def test_working_memory_is_scikit_learns_unless_given(X):
    assert len(list(pose_distances_chunked(X, metric="angle"))) == 1
    with config_context(working_memory=MEMORY):
        assert len(list(pose_distances_chunked(X, metric="angle"))) == 10
    assert [len(chunk) for chunk in pose_distances_chunked(X, metric="angle", working_memory=1e-9)] == [1] * 100


def test_a_chunk_is_computed_when_it_is_asked_for(X):
    starts = []
    chunks = pose_distances_chunked(
        X, reduce_func=lambda chunk, start: starts.append(start), metric="angle", working_memory=MEMORY
    )
    assert starts == []
    next(chunks)
    assert starts == [0]


def test_none_of_a_function_that_keeps_its_results_is_none(X):
    """As scikit-learn has it: where a return was forgotten, the distances do not pass for the result."""
    sums = []
    options = {"reduce_func": lambda chunk, start: sums.extend(chunk.sum(axis=1)), "working_memory": MEMORY}
    assert list(pose_distances_chunked(X, metric="angle", **options)) == [None] * 10
    np.testing.assert_allclose(sums, pose_distances(X, metric="angle").sum(axis=1), rtol=1e-12)
    assert list(pairwise_distances_chunked(X, **options)) == [None] * 10


@pytest.mark.parametrize(
    ("arguments", "error", "message"),
    [
        ({"reduce_func": lambda chunk, start: 1.0}, TypeError, "reduce_func must return a sequence, an array or"),
        ({"reduce_func": lambda chunk, start: chunk[:-1]}, ValueError, "returned 99 entries for a chunk of 100 rows"),
        ({"reduce_func": lambda chunk, start: (chunk, [])}, ValueError, "returned 0 entries for a chunk of 100 rows"),
        ({"reduce_func": 3}, ValueError, "'reduce_func' parameter of pose_distances_chunked"),
        ({"working_memory": 0}, ValueError, "'working_memory' parameter of pose_distances_chunked"),
        ({"metric": "spatial"}, ValueError, "the metric 'spatial' needs a skeleton"),
        ({"Y": np.zeros((2, 3))}, ValueError, f"X has {TREE.n_dofs} columns and Y has 3"),
    ],
)
def test_bad_input_is_refused_in_the_users_words(X, arguments, error, message):
    with pytest.raises(error, match=message):
        list(pose_distances_chunked(X, **({"metric": "angle"} | arguments)))


def test_the_default_metric_is_that_of_the_matrix():
    X = np.random.default_rng(0).uniform(-1, 1, size=(9, TREE.n_dofs))
    chunks = np.concatenate(list(pose_distances_chunked(X, skeleton=TREE, working_memory=MEMORY)))
    np.testing.assert_allclose(chunks, pose_distances(X, skeleton=TREE), rtol=1e-12)
