"""Cholesky factors of a block-tridiagonal matrix, in lanes.

The blocks are the block rows [D B] of a band: D is on the diagonal, B right of it. Elimination from the top makes them
[U X], with D = UᵀU, X = U⁻ᵀB, and XᵀX subtracted from the next D; one pass over the rows computes both. Widths are
padded to whole lanes, and four rows are computed at once, so that their sums stay in registers: a library's Cholesky,
which would be called some fifty times a step for blocks of forty dofs, takes twice the time.

Row p of block i is row i · m + p, with m = n · LANES, and 2 n registers wide.
"""

import math
from typing import NamedTuple

from numba import types

from skpose._compiled.path.energy import LANES
from skpose._compiled.simd.jit import by_address, inlined
from skpose._compiled.simd.lanes import full_like, rows, sum_of_lanes
from skpose._compiled.simd.signatures import FLAG, INTEGER, MATRIX, tuple_type

AT_ONCE = 4  # rows


class Band(NamedTuple):
    """A band, and the solution of equations with it."""

    n_blocks: int
    n: int  # registers in a row of a block
    first: int  # register of the band
    solution: int  # first register of the solution


BAND = tuple_type(Band, *[INTEGER] * len(Band._fields))


@by_address(lambda: types.void(MATRIX, *[INTEGER] * 8))
def _subtract(cells, target, width, source, source_width, n_rows, n_chunks, factor, lane):
    """Subtract Wᵀ · source from four rows, `width` registers long, in registers from the target on.

    W is four columns of as many rows as the source, and as wide ones: lanes of the register `factor`, and of those
    below it.
    """
    chunks = rows(cells, 0)
    for c in range(n_chunks):
        at, of = target + c, source + c
        second, third, fourth = at + width, at + 2 * width, at + 3 * width
        a, b, d, e = chunks[at], chunks[second], chunks[third], chunks[fourth]
        for k in range(n_rows):
            r, w = chunks[of + k * source_width], cells[factor + k * source_width]
            a, b = a - w[lane] * r, b - w[lane + 1] * r
            d, e = d - w[lane + 2] * r, e - w[lane + 3] * r
        chunks[at], chunks[second], chunks[third], chunks[fourth] = a, b, d, e


@inlined
def _subtract_row(chunks, target, source, weight, n_chunks):
    """Subtract a multiple of the registers from the source on."""
    for c in range(n_chunks):
        chunks[target + c] = chunks[target + c] - weight * chunks[source + c]


@by_address(lambda: FLAG(MATRIX, BAND))
def factorise_band(cells, band):
    """Factorise UᵀU in place, X right of U; return whether that is possible.

    The diagonal of U holds the inverses of its numbers.
    """
    n, width, m, chunks = band.n, 2 * band.n, band.n * LANES, rows(cells, 0)
    for i in range(band.n_blocks):
        top, end = band.first + i * m * width, n if i == band.n_blocks - 1 else width
        above = top - m * width
        for p in range(0, m, AT_ONCE):
            first, lane, here = p // LANES, p % LANES, top + p * width
            if i > 0:  # XᵀX of the block row above
                factor = above + n + first
                _subtract(cells, here + first, width, factor, width, m, n - first, factor, lane)
            factor = top + first
            _subtract(cells, here + first, width, factor, width, p, end - first, factor, lane)
            for q in range(AT_ONCE):
                row = here + q * width
                for k in range(q):
                    source = here + k * width
                    _subtract_row(chunks, row + first, source + first, cells[source + first, lane + q], end - first)
                pivot = cells[row + first, lane + q]
                if not pivot > 0.0:
                    return False
                for j in range(lane + q):
                    cells[row + first, j] = 0.0
                scale = 1.0 / math.sqrt(pivot)
                for c in range(row + first, row + end):
                    chunks[c] = scale * chunks[c]
                cells[row + first, lane + q] = scale
    return True


@by_address(lambda: types.void(MATRIX, BAND))
def substitute_forward(cells, band):
    """Solve Uᵀ y = x in place, x in the solution."""
    n, width, m, chunks = band.n, 2 * band.n, band.n * LANES, rows(cells, 0)
    for i in range(band.n_blocks):
        end = n if i == band.n_blocks - 1 else width
        for p in range(m):
            first, lane, row = p // LANES, p % LANES, band.first + (i * m + p) * width
            at = band.solution + i * n + first
            value = cells[at, lane] * cells[row + first, lane]
            # Left of the diagonal there are zeros; the diagonal itself holds no number of U.
            _subtract_row(chunks, at, row + first, value, end - first)
            cells[at, lane] = value


@by_address(lambda: types.void(MATRIX, BAND))
def substitute_back(cells, band):
    """Solve U x = y in place, y in the solution."""
    n, width, m, chunks = band.n, 2 * band.n, band.n * LANES, rows(cells, 0)
    for i in range(band.n_blocks - 1, -1, -1):
        end = n if i == band.n_blocks - 1 else width
        for p in range(m - 1, -1, -1):
            first, lane, row = p // LANES, p % LANES, band.first + (i * m + p) * width
            at, total = band.solution + i * n + first, full_like(chunks, 0.0)
            value = cells[at, lane]
            cells[at, lane] = 0.0
            for c in range(end - first):
                total = total + chunks[at + c] * chunks[row + first + c]
            cells[at, lane] = (value - sum_of_lanes(total)) * cells[row + first, lane]
