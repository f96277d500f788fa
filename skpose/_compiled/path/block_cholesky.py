"""The damped normal equations of a path, solved by Cholesky, one branch of the skeleton at a time.

Branches move no joint in common. The poses' blocks of a branch are a band: its factors cost the cube of the number of
dofs.

The blocks are the block rows [D B] of a band: D is on the diagonal, B right of it. Elimination from the top makes them
[U X], with D = UᵀU, X = U⁻ᵀB, and XᵀX subtracted from the next D; one pass over the rows computes both. Widths are
padded to whole lanes, and four rows are computed at once, so that their sums stay in registers: a library's Cholesky,
which would be called some fifty times a step for blocks of forty dofs, takes twice the time.

Row p of block i is row i · m + p, with m = n · LANES, and 2 n registers wide.
"""

import math
from typing import NamedTuple

import numpy as np
from numba import types

from skpose._compiled.path.energy import LANES, STEPS
from skpose._compiled.path.normal_equations import EQUATIONS, first_row
from skpose._compiled.pose.signatures import TREE
from skpose._compiled.simd.jit import by_address, inlined, internal
from skpose._compiled.simd.lanes import empty_aligned, full_like, rows, sum_of_lanes
from skpose._compiled.simd.signatures import FLAG, FLAG_MATRIX, INTEGER, INTEGER_MATRIX, MATRIX, REAL, tuple_type

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


class Factors(NamedTuple):
    """The factors of a path's normal equations."""

    n_free: int  # poses
    branches: np.ndarray  # (n_branches, 5) first dof, end, registers in a row of a block, first of band, of solution
    cells: np.ndarray  # (n_registers, LANES) bands and solutions


FACTORS = tuple_type(Factors, INTEGER, INTEGER_MATRIX, MATRIX)


@by_address(lambda: FACTORS(TREE, INTEGER))
def factors_for(tree, n_nodes):
    """Factors for a path of so many poses, not yet filled."""
    n_free, n_dofs = n_nodes - 2, tree.column.shape[0]
    begins = np.zeros(n_dofs, np.int64)  # 1 at the first dof of a branch, which all its frames have as an ancestor
    for f in range(1, tree.frame_parent.shape[0]):
        if tree.end_dof[f] > tree.first_dof[f]:
            begins[tree.dof_ranges[tree.first_dof_range[f], 0]] = 1
    branches, k, end = np.zeros((begins.sum(), 5), np.int64), -1, 0
    for d in range(n_dofs):
        k += begins[d]
        branches[k, 0] = d if begins[d] else branches[k, 0]
        branches[k, 1] = d + 1
    for k in range(branches.shape[0]):
        n = -(-(branches[k, 1] - branches[k, 0]) // LANES)
        branches[k, 2], branches[k, 3], branches[k, 4] = n, end, end + n_free * n * LANES * 2 * n
        end = branches[k, 4] + n_free * n
    return Factors(n_free, branches, empty_aligned(end, LANES, np.float64))


@internal
def _band_of(factors, k):
    branch = factors.branches[k]
    return Band(factors.n_free, branch[2], branch[3], branch[4])


@internal
def clear(cells, first, n):
    """Set registers to zero, which takes less time than number by number."""
    chunks = rows(cells, 0)
    for at in range(first, first + n):
        chunks[at] = 0.0


@by_address(lambda: types.void(TREE, EQUATIONS, REAL, FLAG_MATRIX, INTEGER, FACTORS))
def _fill(tree, equations, damping, fixed, k, factors):
    """Copy the numbers of a branch's dofs to its band, D damped.

    A fixed dof keeps the damping alone; padded dofs get a row of the identity.
    """
    first, end, band = factors.branches[k, 0], factors.branches[k, 1], _band_of(factors, k)
    pairs, n_free, numbers = equations.pairs, factors.n_free, factors.cells.reshape(factors.cells.size)
    start, m = band.first * LANES, band.n * LANES
    width = 2 * m
    clear(factors.cells, band.first, n_free * m * 2 * band.n)
    for row in range(n_free * m):
        numbers[start + row * width + row % m] = 1.0
    any_fixed = fixed.any()
    for i in range(n_free):  # the step from pose i on ends at pose i + 1, where another begins
        before, after = first_row(equations, i // STEPS, 0), first_row(equations, (i + 1) // STEPS, 0)
        lane, next_lane, block = i % STEPS, (i + 1) % STEPS, start + i * m * width
        for f in range(1, tree.frame_parent.shape[0]):
            if not first <= tree.first_dof[f] < end:
                continue
            for d in range(tree.first_dof[f], tree.end_dof[f]):
                row, p = 4 * equations.first_pair[d], d - first
                for r in range(tree.first_dof_range[f], tree.first_dof_range[f + 1]):
                    for e in range(tree.dof_ranges[r, 0], min(tree.dof_ranges[r, 1], d + 1)):
                        value = pairs[before + row + 1, lane] + pairs[after + row, next_lane]
                        forward, back = pairs[after + row + 2, next_lane], pairs[after + row + 3, next_lane]
                        row += 4
                        if any_fixed:
                            value = 0.0 if fixed[i + 1, d] or fixed[i + 1, e] else value
                            forward = 0.0 if fixed[i + 1, d] or fixed[i + 2, e] else forward
                            back = 0.0 if fixed[i + 2, d] or fixed[i + 1, e] else back
                        q = e - first
                        numbers[block + q * width + p] = value
                        if i < n_free - 1:
                            numbers[block + p * width + m + q] = forward
                            numbers[block + q * width + m + p] = back
                numbers[block + p * width + p] += damping


@by_address(lambda: FLAG(TREE, EQUATIONS, REAL, FLAG_MATRIX, FACTORS))
def factorise(tree, equations, damping, fixed, factors):
    """Factorise H + λ, without the dofs that are fixed; return whether it is positive definite."""
    for k in range(factors.branches.shape[0]):
        _fill(tree, equations, damping, fixed, k, factors)
        if not factorise_band(factors.cells, _band_of(factors, k)):
            return False
    return True


@by_address(lambda: types.void(EQUATIONS, FACTORS, MATRIX))
def solve(equations, factors, step):
    """Compute step = −(H + λ)⁻¹ gradient by the factors; of fixed dofs the gradient has to be zero."""
    cells, n_free = factors.cells, factors.n_free
    numbers = cells.reshape(cells.size)
    for k in range(factors.branches.shape[0]):
        first, end, band = factors.branches[k, 0], factors.branches[k, 1], _band_of(factors, k)
        clear(cells, band.solution, n_free * band.n)
        for i in range(n_free):
            for d in range(first, end):
                numbers[(band.solution + i * band.n) * LANES + d - first] = -equations.gradient[i + 1, d]
        substitute_forward(cells, band)
        substitute_back(cells, band)
        for i in range(n_free):
            for d in range(first, end):
                step[i + 1, d] = numbers[(band.solution + i * band.n) * LANES + d - first]
