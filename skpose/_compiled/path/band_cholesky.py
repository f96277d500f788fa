"""Cholesky factors of a block-tridiagonal matrix with a border, in lanes.

The blocks are the block rows [D B W] of a band: D is on the diagonal, B right of it and W the border. Elimination from
the top makes them [U X Y], with D = UᵀU, X = U⁻ᵀB, Y = U⁻ᵀW, and XᵀX and XᵀY subtracted from the next D and W; one pass
over the rows computes all three. Widths are padded to whole lanes, and four rows are computed at once, so that their
sums stay in registers: a library's Cholesky, which would be called some fifty times a step for blocks of forty dofs,
takes twice the time.

Row p of block i is row i · m + p, with m = n · LANES. A single block is a dense matrix.
"""

import math

from numba import types

from skpose._compiled.path.elimination import SUPERNODE, n_registers
from skpose._compiled.path.energy import LANES
from skpose._compiled.simd.jit import by_address, inlined, internal
from skpose._compiled.simd.lanes import full_like, rows, sum_of_lanes
from skpose._compiled.simd.signatures import FLAG, INTEGER, MATRIX

AT_ONCE = 4  # rows


@by_address(lambda: types.void(MATRIX, *[INTEGER] * 8))
def subtract(cells, target, width, source, source_width, n_rows, n_chunks, factor, lane):
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


@inlined
def _scale(chunks, target, scale, n_chunks):
    for c in range(n_chunks):
        chunks[target + c] = scale * chunks[target + c]


@internal
def _ends(supernode, i):
    """The ends of the registers of block row i that are not zero: of the band and of the border."""
    ancestors = n_registers((i + 2) * supernode.n_ancestors)  # those at the next pose are the last
    return supernode.n if i == supernode.n_blocks - 1 else supernode.edge, min(
        supernode.width, supernode.edge + ancestors
    )


@by_address(lambda: FLAG(MATRIX, SUPERNODE))
def factorise_band(cells, supernode):
    """Factorise UᵀU in place, X and Y right of U; return whether that is possible.

    The diagonal of U holds the inverses of its numbers.
    """
    n, width, m, chunks = supernode.n, supernode.width, supernode.n * LANES, rows(cells, 0)
    for i in range(supernode.n_blocks):
        (end, border_end), top = _ends(supernode, i), supernode.band + i * m * width
        border, above = supernode.edge, top - m * width
        for p in range(0, m, AT_ONCE):
            first, lane, here = p // LANES, p % LANES, top + p * width
            if i > 0:  # XᵀX and XᵀY of the block row above
                factor = above + n + first
                subtract(cells, here + first, width, factor, width, m, n - first, factor, lane)
                subtract(cells, here + border, width, above + border, width, m, border_end - border, factor, lane)
            factor = top + first
            subtract(cells, here + first, width, factor, width, p, end - first, factor, lane)
            subtract(cells, here + border, width, top + border, width, p, border_end - border, factor, lane)
            for q in range(AT_ONCE):
                row = here + q * width
                for k in range(q):
                    source = here + k * width
                    weight = cells[source + first, lane + q]
                    _subtract_row(chunks, row + first, source + first, weight, end - first)
                    _subtract_row(chunks, row + border, source + border, weight, border_end - border)
                pivot = cells[row + first, lane + q]
                if not pivot > 0.0:
                    return False
                for j in range(lane + q):
                    cells[row + first, j] = 0.0
                scale = 1.0 / math.sqrt(pivot)
                _scale(chunks, row + first, scale, end - first)
                _scale(chunks, row + border, scale, border_end - border)
                cells[row + first, lane + q] = scale
    return True


@by_address(lambda: types.void(MATRIX, SUPERNODE))
def substitute_forward(cells, supernode):
    """Solve Uᵀ y = x in place, x in the solution; subtract Yᵀy from the border's numbers there."""
    n, width, m, chunks = supernode.n, supernode.width, supernode.n * LANES, rows(cells, 0)
    border = supernode.solution + supernode.n_blocks * n
    for i in range(supernode.n_blocks):
        end, border_end = _ends(supernode, i)
        for p in range(m):
            first, lane, row = p // LANES, p % LANES, supernode.band + (i * m + p) * width
            at = supernode.solution + i * n + first
            value = cells[at, lane] * cells[row + first, lane]
            # Left of the diagonal there are zeros; the diagonal itself holds no number of U.
            _subtract_row(chunks, at, row + first, value, end - first)
            _subtract_row(chunks, border, row + supernode.edge, value, border_end - supernode.edge)
            cells[at, lane] = value


@by_address(lambda: types.void(MATRIX, SUPERNODE))
def substitute_back(cells, supernode):
    """Solve U x = y − Y z in place, y in the solution and z the border's numbers there."""
    n, width, m, chunks = supernode.n, supernode.width, supernode.n * LANES, rows(cells, 0)
    border = supernode.solution + supernode.n_blocks * n
    for i in range(supernode.n_blocks - 1, -1, -1):
        end, border_end = _ends(supernode, i)
        for p in range(m - 1, -1, -1):
            first, lane, row = p // LANES, p % LANES, supernode.band + (i * m + p) * width
            at, total = supernode.solution + i * n + first, full_like(chunks, 0.0)
            value = cells[at, lane]
            cells[at, lane] = 0.0
            for c in range(end - first):
                total = total + chunks[at + c] * chunks[row + first + c]
            for c in range(border_end - supernode.edge):
                total = total + chunks[border + c] * chunks[row + supernode.edge + c]
            cells[at, lane] = (value - sum_of_lanes(total)) * cells[row + first, lane]
