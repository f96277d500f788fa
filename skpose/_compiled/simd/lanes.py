"""Several numbers in one vector register, as a type of numba's.

LLVM vectorises a loop over lanes only where it can prove that no store touches a later load, which it cannot do for
parts of one scratch array. Here the lanes are a value instead. ``rows(A, first)`` is where the rows of an array begin:
of a two-dimensional array, `rows(A, 0)[i]` is row i as one LLVM vector; ``+ - * /`` and the functions below work on all
its lanes, and ``rows(A, 0)[i] = v`` puts it back. Of a one-dimensional array the same reads and writes one number, and
of one of shape (n, 1, 2) a register of two lanes. So a kernel written with `rows` compiles to each: many poses at once,
one, or two.

The functions here are plain Python, which runs with ``NUMBA_DISABLE_JIT=1``; `lanes_llvm` holds what
they compile to. Compiled rows check no bounds and count no references: the array must outlive them, as a function's
argument does. (Counting references in an inner loop halves its speed.)
"""

import numpy as np

VECTOR_BYTES = 64  # one register of the widest common kind, two of the next
CACHE_LINE = 64  # bytes
PAIR = 2  # lanes of a row of an array (n, 1, 2)


def lanes(dtype) -> int:
    """How many numbers of this dtype are computed at once."""
    return VECTOR_BYTES // dtype.itemsize


def empty_aligned(n_rows, width, dtype):
    """An empty array (n_rows, width) at the start of a cache line: a row across two takes twice the time."""
    raw = np.empty(n_rows * width + CACHE_LINE, dtype)
    skip = (-raw.ctypes.data % CACHE_LINE) // raw.itemsize
    return raw[skip : skip + n_rows * width].reshape((n_rows, width))


def empty_pairs(n_rows, dtype):
    """An empty array (n_rows, 1, 2), whose rows are registers of two lanes."""
    return np.empty((n_rows, 1, PAIR), dtype)


def empty_rows(array, n_rows):
    """An empty array with so many rows like those of an array."""
    return np.empty((n_rows, *array.shape[1:]), array.dtype)


class Rows:
    """Rows of an array from a first one on: numbers, or arrays of lanes."""

    def __init__(self, array: np.ndarray, first: int):
        self._array = array[first:]

    def __getitem__(self, i):
        # A copy, as a register is one: it keeps its value when the row is overwritten.
        return self._array[i].copy()

    def __setitem__(self, i, value):
        self._array[i] = value


def rows(array, first):
    """The rows of an array from this one on; of a one-dimensional array, its numbers."""
    return Rows(array, first)


def flat(array):
    """The numbers of a contiguous array of any shape, one after another."""
    return Rows(array.reshape(-1), 0)


def copy_to(target, source):
    """Copy all numbers of a contiguous array to another of its shape.

    numba's ``target[:] = source`` compiles for a second, with its error message.
    """
    target[...] = source


def full_like(rows, value):
    """A number in the form that these rows hold: the same in every lane."""
    return np.full_like(rows[0], value)[()]


def sqrt(value):
    """The square root of every lane."""
    return np.sqrt(value)


def rint(value):
    """Round every lane to the nearest integer, halves to the even one."""
    return np.rint(value)


def minimum(a, b):
    """The smaller of the two, lane by lane."""
    return np.minimum(a, b)


def least(value):
    """The smallest number of all lanes."""
    return np.min(value)


def greater(value, bound):
    """1 in the lanes where the value is more than the bound, else 0."""
    return np.where(value > bound, np.ones_like(value), np.zeros_like(value))[()]


def any_greater(value, bound):
    """Whether the value is more than the bound in any lane."""
    return bool(np.any(value > bound))


def next_lane(value):
    """In every lane the value of the next one; the last lane keeps its own."""
    return np.append(value[1:], value[-1])


def sum_of_lanes(value):
    """The sum of all lanes, one after another."""
    return np.cumsum(value)[-1]
