"""Block-tridiagonal normal equations, solved by Cholesky in lanes.

One branch of the skeleton at a time, as branches move no joint in common: the free poses' blocks, each as wide as the
branch has dofs, stand in a band of block rows [D B], D on the diagonal and B beside it. Eliminating from the top turns
them into [U X], with D = UᵀU, X = U⁻ᵀB, and XᵀX to be taken off the next D; U and X are rows of one sweep. Widths are
padded to whole lanes, and four rows are swept at once, so that what is subtracted from them stays in registers: a
library's Cholesky, which would be called some fifty times a step for blocks of forty dofs, takes twice the time.
"""

import math

import numpy as np

from skpose._compiled.jit import jit
from skpose._compiled.lanes import full_like, rows

LANES = 8  # float64 numbers in one register


@jit
def band_shape(tree, n_nodes):
    """Rows and columns of the band that holds one branch: block rows [U X], padded to whole lanes."""
    widest = 0
    for b in range(tree.branch.shape[0] - 1):
        widest = max(widest, tree.branch[b + 1] - tree.branch[b])
    padded = -(-widest // LANES) * LANES
    return n_nodes * padded * 2 * (padded // LANES), LANES


@jit
def _fill_band(diagonal, beside, damping, held, lo, hi, band):
    """The free poses' blocks, dofs lo:hi, as block rows [D B] of the band; what is padded or held is left alone.

    Row p of block i is band[((i · m + p) · 2 · n + c, l] for column c · LANES + l, m = n · LANES padded dofs.
    """
    n = -(-(hi - lo) // LANES)
    m = n * LANES
    last = diagonal.shape[0] - 2
    for i in range(1, last + 1):
        rows = band[(i - 1) * m * 2 * n : i * m * 2 * n].reshape(m, 2 * m)
        for p in range(hi - lo):
            for q in range(p):
                rows[q, p] = diagonal[i, lo + p, lo + q]
            rows[p, p] = diagonal[i, lo + p, lo + p] + damping
            for q in range(hi - lo, m):
                rows[p, q] = rows[p, m + q] = 0.0
            for q in range(hi - lo):
                rows[p, m + q] = beside[i, lo + p, lo + q]
        for p in range(m):
            if p >= hi - lo or held[i, lo + p]:
                for q in range(m):
                    rows[p, q] = rows[q, p] = rows[p, m + q] = 0.0
                rows[p, p] = 1.0
            if i < last and p < hi - lo and held[i + 1, lo + p]:
                for q in range(m):
                    rows[q, m + p] = 0.0


@jit
def _subtract(band, n, row, first, last, source, n_rows, shift, column):
    """Four rows of the band from chunk first on −= Σ W_k [row k of the source], W_k its column and the next three."""
    chunks = rows(band, 0)
    for c in range(first, last):
        a, b = chunks[row * n + c], chunks[(row + 1) * n + c]
        d, e = chunks[(row + 2) * n + c], chunks[(row + 3) * n + c]
        for k in range(source, source + n_rows):
            r = chunks[k * n + c + shift]
            w = band[k * n + column // LANES]
            i = column % LANES
            a, b, d, e = a - w[i] * r, b - w[i + 1] * r, d - w[i + 2] * r, e - w[i + 3] * r
        chunks[row * n + c], chunks[(row + 1) * n + c] = a, b
        chunks[(row + 2) * n + c], chunks[(row + 3) * n + c] = d, e


@jit
def _factorise(band, n_blocks, n):
    """Cholesky factor UᵀU in place, X beside U; whether there is one. n: lanes in a block's width."""
    m, width = n * LANES, 2 * n
    chunks = rows(band, 0)
    for i in range(n_blocks):
        top, end = i * m, n if i == n_blocks - 1 else width  # nothing is beside the last block
        for p in range(0, m, 4):
            row, first = top + p, p // LANES
            if i > 0:
                _subtract(band, width, row, first, n, top - m, m, n, m + p)
            _subtract(band, width, row, first, end, top, p, 0, p)
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
    return True


@jit
def _substitute(band, n_blocks, n, x):
    """Solve UᵀU x = b in place, x of shape (n_blocks · n, LANES)."""
    m, width = n * LANES, 2 * n
    flat = x.reshape(n_blocks * m)
    chunks, solution = rows(band, 0), rows(x, 0)
    for i in range(n_blocks):
        for p in range(m):
            row = (i * m + p) * width
            flat[i * m + p] /= band[row + p // LANES, p % LANES]
            value = flat[i * m + p]
            for c in range(p // LANES, n if i == n_blocks - 1 else width):
                # What lies left of the diagonal is noughts, and the pivot's own place is put right again.
                solution[i * n + c] = solution[i * n + c] - value * chunks[row + c]
            flat[i * m + p] = value
    partial = np.empty((1, LANES))
    for i in range(n_blocks - 1, -1, -1):
        for p in range(m - 1, -1, -1):
            row = (i * m + p) * width
            total = full_like(solution, 0.0)
            pivot = band[row + p // LANES, p % LANES]
            value = flat[i * m + p]
            flat[i * m + p] = 0.0
            for c in range(p // LANES, n if i == n_blocks - 1 else width):
                total = total + solution[i * n + c] * chunks[row + c]
            rows(partial, 0)[0] = total
            for j in range(LANES):
                value -= partial[0, j]
            flat[i * m + p] = value / pivot


@jit
def solve(tree, diagonal, beside, gradient, damping, held, band, step):
    """step = −(H + λ)⁻¹ gradient for the dofs that are not held, branch by branch; whether it could be done."""
    n_blocks = diagonal.shape[0] - 2
    for b in range(tree.branch.shape[0] - 1):
        lo, hi = tree.branch[b], tree.branch[b + 1]
        n = -(-(hi - lo) // LANES)
        _fill_band(diagonal, beside, damping, held, lo, hi, band)
        if not _factorise(band, n_blocks, n):
            return False
        x = np.zeros((n_blocks * n, LANES))
        flat = x.reshape(n_blocks, n * LANES)
        for i in range(n_blocks):
            for d in range(lo, hi):
                flat[i, d - lo] = -gradient[i + 1, d]
        _substitute(band, n_blocks, n, x)
        for i in range(n_blocks):
            for d in range(lo, hi):
                step[i + 1, d] = flat[i, d - lo]
    return True
