"""The damped normal equations of a path, solved by Cholesky, one branch of the skeleton at a time.

Branches move no joint in common. The poses' blocks of a branch are a band, see `band_cholesky`: its factors cost the
cube of the number of dofs.
"""

from typing import NamedTuple

import numpy as np
from numba import types

from skpose._compiled.path.band_cholesky import Band, factorise_band, substitute_back, substitute_forward
from skpose._compiled.path.energy import LANES, STEPS
from skpose._compiled.path.normal_equations import EQUATIONS, first_row
from skpose._compiled.pose.signatures import TREE
from skpose._compiled.simd.jit import by_address, internal
from skpose._compiled.simd.lanes import empty_aligned, rows
from skpose._compiled.simd.signatures import FLAG, FLAG_MATRIX, INTEGER, INTEGER_MATRIX, MATRIX, REAL, tuple_type


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
def _clear(cells, first, n):
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
    _clear(factors.cells, band.first, n_free * m * 2 * band.n)
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
        _clear(cells, band.solution, n_free * band.n)
        for i in range(n_free):
            for d in range(first, end):
                numbers[(band.solution + i * band.n) * LANES + d - first] = -equations.gradient[i + 1, d]
        substitute_forward(cells, band)
        substitute_back(cells, band)
        for i in range(n_free):
            for d in range(first, end):
                step[i + 1, d] = numbers[(band.solution + i * band.n) * LANES + d - first]
