"""The mirror image of a triangle, in squares and on threads, is exactly the triangle."""

import numpy as np
import pytest

from skpose.metrics import _mirror

EDGE = _mirror.EDGE
SIZES = [0, 1, EDGE - 1, EDGE, EDGE + 1, 3 * EDGE + 5]
N_THREADS = pytest.mark.parametrize("n_threads", [1, 2, 5])


@pytest.fixture(autouse=True)
def small_matrices_on_threads(monkeypatch):
    monkeypatch.setattr(_mirror, "WORTH_A_THREAD", 1)


@N_THREADS
@pytest.mark.parametrize("n", SIZES)
@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_the_lower_triangle_is_the_upper_one(n, dtype, n_threads):
    whole = np.random.default_rng(n).normal(size=(n + 3, n + 2)).astype(dtype)
    whole[np.tril_indices(n)] = np.nan  # nothing of it is read
    upper = np.triu(whole[:n, :n], 1)
    outside = whole[n:].copy(), whole[:n, n:].copy()
    _mirror.mirror(whole[:n, :n], n_threads)
    np.testing.assert_array_equal(whole[:n, :n], upper + upper.T)
    np.testing.assert_array_equal(whole[n:], outside[0])
    np.testing.assert_array_equal(whole[:n, n:], outside[1])
