"""The lower triangle of a symmetric matrix, copied in squares that fit into the cache, by threads."""

import functools

import numpy as np

from skpose._utils.parallel import in_threads

EDGE = 128  # of the squares; in both smaller and larger ones a number takes more time
WORTH_A_THREAD = 2**19  # numbers, some milliseconds


def mirror(distances: np.ndarray, n_threads: int) -> None:
    """Copy the upper triangle into the lower one, and clear the diagonal."""

    def fill_rows(top: int) -> None:
        rows = slice(top, top + EDGE)
        for left in range(0, top, EDGE):
            columns = slice(left, left + EDGE)
            distances[rows, columns] = distances[columns, rows].T
        square = distances[rows, rows]
        square[...] = np.triu(square, 1) + np.triu(square, 1).T

    tops = range(0, len(distances), EDGE)[::-1]  # the longest rows first, so that no thread waits for another
    n_threads = max(1, min(n_threads, distances.size // 2 // WORTH_A_THREAD))
    in_threads((functools.partial(fill_rows, top) for top in tops), n_threads)
