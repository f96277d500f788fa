"""An eigenvector of a small symmetric matrix. LAPACK's rounding depends on the number of threads that it may use."""

import math

import numpy as np

from skpose._compiled.simd.jit import internal

MAX_SWEEPS = 20  # a 4 × 4 matrix takes four to six
NOTHING = 1e-17  # element off the diagonal that no rounding shows, relative to the two on it


@internal
def greatest_eigenvector(A):
    """Return the eigenvector of the greatest eigenvalue of a symmetric matrix, which is destroyed.

    Jacobi's rotations: each makes one pair of elements off the diagonal zero, until all are.
    """
    n = A.shape[0]
    V = np.zeros((n, n))  # its rows are the eigenvectors
    for i in range(n):
        V[i, i] = 1.0
    for _ in range(MAX_SWEEPS):
        is_diagonal = True
        for p in range(n):
            for q in range(p + 1, n):
                if abs(A[p, q]) > NOTHING * (abs(A[p, p]) + abs(A[q, q])):
                    is_diagonal = False
                    _rotate(A, V, p, q)
        if is_diagonal:
            break
    best = 0
    for i in range(1, n):
        if A[i, i] > A[best, best]:
            best = i
    return V[best]


@internal
def _rotate(A, V, p, q):
    """Rotate rows and columns p and q so that A[p, q] is zero; the same rows of V."""
    slope = (A[q, q] - A[p, p]) / (2.0 * A[p, q])
    tan = math.copysign(1.0 / (abs(slope) + math.hypot(slope, 1.0)), slope)
    cos = 1.0 / math.hypot(tan, 1.0)
    sin = tan * cos
    for k in range(A.shape[0]):
        A[k, p], A[k, q] = cos * A[k, p] - sin * A[k, q], sin * A[k, p] + cos * A[k, q]
    for k in range(A.shape[0]):
        A[p, k], A[q, k] = cos * A[p, k] - sin * A[q, k], sin * A[p, k] + cos * A[q, k]
        V[p, k], V[q, k] = cos * V[p, k] - sin * V[q, k], sin * V[p, k] + cos * V[q, k]
    A[p, q] = A[q, p] = 0.0
