"""Block-tridiagonal normal equations, solved by Cholesky in lanes.

One branch of the skeleton at a time, as branches move no joint in common. The free poses' blocks, each as wide as the
branch has dofs, are the block rows [D B] of a band: D is on the diagonal and B right of it. Elimination from the top
makes them [U X], with D = UᵀU, X = U⁻ᵀB, and XᵀX subtracted from the next D; one pass over the rows computes U and X.
Widths are padded to whole lanes, and four rows are computed at once, so that their sums stay in registers: a library's
Cholesky, which would be called some fifty times a step for blocks of forty dofs, takes twice the time.
"""

import math
from typing import NamedTuple

import numpy as np
from numba import types

from skpose._compiled.jit import internal, separate
from skpose._compiled.lanes import full_like, rows, sum_of_lanes
from skpose._compiled.normal_equations import EQUATIONS, first_row
from skpose._compiled.path_energy import LANES, STEPS
from skpose._compiled.signatures import FLAG, FLAG_MATRIX, MATRIX, REAL, TREE


class Rectangle(NamedTuple):
    """Part of the band: its rows, and in each of them n_chunks registers from a first one on."""

    row: int
    n_rows: int
    chunk: int
    n_chunks: int


@internal
def _n_rows(tree, b, n_nodes):
    """Return the number of rows in the band of a branch: block rows [U X], padded to whole lanes."""
    n = -(-(tree.branch[b + 1] - tree.branch[b]) // LANES)
    return (n_nodes - 2) * n * LANES * 2 * n


@internal
def band_shape(tree, n_nodes):
    """Return the shape of the bands of all branches, one after another."""
    total = 0
    for b in range(tree.branch.shape[0] - 1):
        total += _n_rows(tree, b, n_nodes)
    return total, LANES


@internal
def _fill_band(tree, equations, damping, fixed, lo, hi, band):
    """Copy the free poses' blocks, dofs lo:hi, to the block rows [D B] of the band.

    Padded and fixed dofs get a row of the identity. Row p of block i is band[(i · m + p) · 2 · n + c, l] for column
    c · LANES + l, m = n · LANES padded dofs.
    """
    pairs, n_blocks = equations.pairs, equations.gradient.shape[0] - 2
    m = -(-(hi - lo) // LANES) * LANES
    cells = band.reshape(n_blocks * m, 2 * m)
    for i in range(n_blocks):  # the step from pose i on ends at pose i + 1, where another begins
        block = cells[i * m : (i + 1) * m]
        block[:] = 0.0
        before, after = first_row(equations, i // STEPS, 0), first_row(equations, (i + 1) // STEPS, 0)
        lane, next_lane = i % STEPS, (i + 1) % STEPS
        for f in range(1, tree.frame_parent.shape[0]):
            if not lo <= tree.first_dof[f] < hi:
                continue
            for d in range(tree.first_dof[f], tree.end_dof[f]):
                row = 4 * equations.first_pair[d]
                for r in range(tree.first_run[f], tree.first_run[f + 1]):
                    for e in range(tree.runs[r, 0], min(tree.runs[r, 1], d + 1)):
                        block[e - lo, d - lo] = pairs[before + row + 1, lane] + pairs[after + row, next_lane]
                        block[d - lo, m + e - lo] = pairs[after + row + 2, next_lane]
                        block[e - lo, m + d - lo] = pairs[after + row + 3, next_lane]
                        row += 4
        for p in range(m):
            block[p, p] += damping
            if p >= hi - lo or fixed[i + 1, lo + p]:
                for q in range(m):
                    block[p, q] = block[q, p] = block[p, m + q] = 0.0
                block[p, p] = 1.0
            if p < hi - lo and fixed[i + 2, lo + p]:
                for q in range(m):
                    block[q, m + p] = 0.0


@internal
def _subtract(band, width, target, source, column):
    """Subtract Wᵀ · source from four rows of the band, the target; W is the source rows in this column and three more.

    A row of the band has `width` registers.
    """
    chunks = rows(band, 0)
    row, i = target.row * width, column % LANES
    for c in range(target.chunk, target.chunk + target.n_chunks):
        a, b = chunks[row + c], chunks[row + width + c]
        d, e = chunks[row + 2 * width + c], chunks[row + 3 * width + c]
        for k in range(source.row, source.row + source.n_rows):
            r = chunks[k * width + c + source.chunk - target.chunk]
            w = band[k * width + column // LANES]
            a, b, d, e = a - w[i] * r, b - w[i + 1] * r, d - w[i + 2] * r, e - w[i + 3] * r
        chunks[row + c], chunks[row + width + c] = a, b
        chunks[row + 2 * width + c], chunks[row + 3 * width + c] = d, e


@internal
def _factorise(band, n_blocks, n):
    """Factorise UᵀU in place, X right of U; return whether that is possible. A block is n registers wide.

    The diagonal of U holds the inverses of its numbers.
    """
    m, width = n * LANES, 2 * n
    chunks = rows(band, 0)
    for i in range(n_blocks):
        top, end = i * m, n if i == n_blocks - 1 else width  # nothing is right of the last block
        for p in range(0, m, 4):
            row, first = top + p, p // LANES
            if i > 0:  # XᵀX of the block row above
                above = Rectangle(top - m, m, n + first, n - first)
                _subtract(band, width, Rectangle(row, 4, first, n - first), above, m + p)
            _subtract(band, width, Rectangle(row, 4, first, end - first), Rectangle(top, p, first, end - first), p)
            for q in range(p, p + 4):
                for k in range(p, q):
                    w = band[(top + k) * width + q // LANES, q % LANES]
                    for c in range(first, end):
                        at = (top + q) * width + c
                        chunks[at] = chunks[at] - w * chunks[(top + k) * width + c]
                pivot = band[(top + q) * width + q // LANES, q % LANES]
                if not pivot > 0.0:
                    return False
                for j in range(q % LANES):
                    band[(top + q) * width + q // LANES, j] = 0.0
                scale = 1.0 / math.sqrt(pivot)
                for c in range(first, end):
                    chunks[(top + q) * width + c] = scale * chunks[(top + q) * width + c]
                band[(top + q) * width + q // LANES, q % LANES] = scale
    return True


@internal
def _substitute(band, n_blocks, n, x):
    """Solve UᵀU x = b in place, x of shape (n_blocks · n, LANES)."""
    m, width = n * LANES, 2 * n
    flat = x.reshape(n_blocks * m)
    chunks, solution = rows(band, 0), rows(x, 0)
    for i in range(n_blocks):
        for p in range(m):
            row = (i * m + p) * width
            flat[i * m + p] *= band[row + p // LANES, p % LANES]
            value = flat[i * m + p]
            for c in range(p // LANES, n if i == n_blocks - 1 else width):
                # Left of the diagonal there are zeros; the pivot's own number is restored below.
                solution[i * n + c] = solution[i * n + c] - value * chunks[row + c]
            flat[i * m + p] = value
    for i in range(n_blocks - 1, -1, -1):
        for p in range(m - 1, -1, -1):
            row = (i * m + p) * width
            total = full_like(solution, 0.0)
            inverse = band[row + p // LANES, p % LANES]
            value = flat[i * m + p]
            flat[i * m + p] = 0.0
            for c in range(p // LANES, n if i == n_blocks - 1 else width):
                total = total + solution[i * n + c] * chunks[row + c]
            flat[i * m + p] = (value - sum_of_lanes(total)) * inverse


@separate(lambda: FLAG(TREE, EQUATIONS, REAL, FLAG_MATRIX, MATRIX))
def factorise(tree, equations, damping, fixed, band):
    """Factorise H + λ, without the dofs that are fixed, in the band; return whether it is positive definite."""
    n_nodes, start = equations.gradient.shape[0], 0
    for b in range(tree.branch.shape[0] - 1):
        lo, hi, stop = tree.branch[b], tree.branch[b + 1], start + _n_rows(tree, b, n_nodes)
        _fill_band(tree, equations, damping, fixed, lo, hi, band[start:stop])
        if not _factorise(band[start:stop], n_nodes - 2, -(-(hi - lo) // LANES)):
            return False
        start = stop
    return True


@separate(lambda: types.void(TREE, EQUATIONS, MATRIX, MATRIX))
def solve(tree, equations, band, step):
    """Compute step = −(H + λ)⁻¹ gradient by the factors in the band; of fixed dofs the gradient has to be zero."""
    n_nodes, start = equations.gradient.shape[0], 0
    for b in range(tree.branch.shape[0] - 1):
        lo, hi, stop = tree.branch[b], tree.branch[b + 1], start + _n_rows(tree, b, n_nodes)
        n = -(-(hi - lo) // LANES)
        x = np.zeros(((n_nodes - 2) * n, LANES))
        flat = x.reshape(n_nodes - 2, n * LANES)
        for i in range(n_nodes - 2):
            for d in range(lo, hi):
                flat[i, d - lo] = -equations.gradient[i + 1, d]
        _substitute(band[start:stop], n_nodes - 2, n, x)
        for i in range(n_nodes - 2):
            for d in range(lo, hi):
                step[i + 1, d] = flat[i, d - lo]
        start = stop
