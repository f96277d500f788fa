"""Transposed copies of distances, in squares that fit into the cache and on threads: a triangle's mirror image."""

import functools

import numpy as np

from skpose._parallel.threads import in_threads

EDGE = 128  # of the squares; in both smaller and larger ones a number takes more time
WORTH_A_THREAD = 2**19  # numbers, some milliseconds


def mirror(distances: np.ndarray, n_threads: int) -> None:
    """Copy the upper triangle into the lower one, and clear the diagonal."""

    def fill_rows(top: int) -> None:
        rows = slice(top, top + EDGE)
        _copy_transposed(distances[:top, rows], distances[rows, :top])
        square = distances[rows, rows]
        square[...] = np.triu(square, 1) + np.triu(square, 1).T

    tops = range(0, len(distances), EDGE)[::-1]  # the longest rows first, so that no thread waits for another
    in_threads((functools.partial(fill_rows, top) for top in tops), _worthwhile(distances.size // 2, n_threads))


def write_transposed(distances: np.ndarray, target: np.ndarray, n_threads: int) -> None:
    """Write ``distances.T`` into the target."""

    def fill_rows(top: int) -> None:
        rows = slice(top, top + EDGE)
        _copy_transposed(distances[:, rows], target[rows])

    tops = range(0, len(target), EDGE)
    in_threads((functools.partial(fill_rows, top) for top in tops), _worthwhile(target.size, n_threads))


def _copy_transposed(source: np.ndarray, target: np.ndarray) -> None:
    for left in range(0, target.shape[1], EDGE):
        columns = slice(left, left + EDGE)
        target[:, columns] = source[columns].T


def _worthwhile(n_numbers: int, n_threads: int) -> int:
    return max(1, min(n_threads, n_numbers // WORTH_A_THREAD))
