"""The eigenvector of the greatest eigenvalue, compared with LAPACK's."""

import numpy as np
import pytest
from entries import from_python

from skpose._compiled.inverse.eigenvector import greatest_eigenvector

greatest_eigenvector = from_python(greatest_eigenvector)


@pytest.mark.parametrize("size", [1e-150, 1.0, 1e150])
@pytest.mark.parametrize("n", [1, 2, 4, 7])
def test_it_is_that_of_lapack(n, size):
    rng = np.random.default_rng(n)
    for _ in range(50):
        A = rng.normal(size=(n, n)) * size
        A += A.T
        values, vectors = np.linalg.eigh(A)
        found = greatest_eigenvector(A.copy())
        np.testing.assert_allclose(np.linalg.norm(found), 1.0, rtol=1e-14)
        np.testing.assert_allclose(A @ found, values[-1] * found, atol=1e-13 * n * np.abs(values).max())
        if n > 1 and values[-1] - values[-2] > 1e-3 * values[-1]:
            np.testing.assert_allclose(abs(found @ vectors[:, -1]), 1.0, rtol=1e-10)


def test_of_equal_eigenvalues_it_is_one():
    Q = np.linalg.qr(np.random.default_rng(0).normal(size=(4, 4)))[0]
    A = Q @ np.diag([3.0, 3.0, 3.0, 1.0]) @ Q.T
    found = greatest_eigenvector((A + A.T) / 2.0)
    np.testing.assert_allclose(A @ found, 3.0 * found, atol=1e-13)


def test_of_a_diagonal_matrix_it_is_a_unit_vector():
    np.testing.assert_array_equal(greatest_eigenvector(np.zeros((4, 4))), [1, 0, 0, 0])
    np.testing.assert_array_equal(greatest_eigenvector(np.diag([1.0, 2.0, 4.0, 3.0])), [0, 0, 1, 0])
