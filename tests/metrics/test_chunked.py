"""`pose_distances_chunked` compared with scikit-learn's `pairwise_distances_chunked` and with the whole matrix."""

import numpy as np
import pytest
from conftest import random_tree
from scipy.sparse import csr_array
from sklearn import config_context
from sklearn.metrics import pairwise_distances_chunked

from skpose import pose_distances
from skpose.metrics import pose_distances_chunked
from skpose.metrics._registry import METRICS

TREE = random_tree(0)
MEMORY = 10 * 100 * 8 / 2**20  # MiB for ten rows of a hundred


@pytest.fixture(scope="module")
def X():
    return np.random.default_rng(0).normal(size=(100, TREE.n_dofs))


@pytest.mark.parametrize(
    "reduce_func",
    [
        None,
        lambda chunk, start: (chunk.argmin(axis=1) + start, chunk.min(axis=1)),
        lambda chunk, start: csr_array(chunk < 7),
        lambda chunk, start: [list(np.flatnonzero(row < 7)) for row in chunk],
        lambda chunk, start: None,
    ],
    ids=["chunks", "tuple", "sparse", "lists", "None"],
)
def test_results_are_those_of_scikit_learn(X, reduce_func):
    options = {"reduce_func": reduce_func, "working_memory": MEMORY}
    ours = list(pose_distances_chunked(X, X + 0.01, metric="angle", **options))
    theirs = list(pairwise_distances_chunked(X, X + 0.01, **options))
    assert len(ours) == len(theirs) == 10
    for our, their in zip(ours, theirs, strict=True):
        assert type(our) is type(their)
        for a, b in zip(*((part if isinstance(part, tuple) else (part,)) for part in (our, their)), strict=True):
            if isinstance(a, list) or a is None:
                assert a == b
            else:
                np.testing.assert_allclose(*(getattr(c, "toarray", lambda c=c: c)() for c in (a, b)), atol=1e-6)


@pytest.mark.parametrize("metric", [name for name in METRICS if name != "geodesic"])
def test_chunks_are_the_rows_of_the_matrix(X, metric):
    expected = pose_distances(X, X[:30] + 0.1, skeleton=TREE, metric=metric)
    chunks = list(pose_distances_chunked(X, X[:30] + 0.1, skeleton=TREE, metric=metric, working_memory=MEMORY))
    assert [len(chunk) for chunk in chunks] == [33, 33, 33, 1]
    np.testing.assert_array_equal(np.concatenate(chunks), expected)
    whole = np.concatenate(list(pose_distances_chunked(X, skeleton=TREE, metric=metric, working_memory=MEMORY)))
    np.testing.assert_allclose(whole, pose_distances(X, skeleton=TREE, metric=metric), rtol=1e-9)


def test_working_memory_and_lazy_chunks(X):
    with config_context(working_memory=MEMORY):
        assert len(list(pose_distances_chunked(X, metric="angle"))) == 10
    starts = []
    chunks = pose_distances_chunked(
        X, reduce_func=lambda chunk, start: starts.append(start), metric="angle", working_memory=1e-9
    )
    assert starts == []
    next(chunks)
    assert starts == [0]


def test_a_result_of_another_length_is_refused(X):
    with pytest.raises(ValueError, match="reduce_func"):
        list(pose_distances_chunked(X, reduce_func=lambda chunk, start: chunk[:-1], metric="angle"))
