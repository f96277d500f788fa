"""Normal equations of one pose, and the root's position as three dofs before its own, solved by Cholesky.

Dof d of the tree is dof d + 3 here.
"""

from typing import NamedTuple

import numpy as np

from skpose._compiled.path.block_cholesky import Band, clear, factorise_band, substitute_back, substitute_forward
from skpose._compiled.path.energy import LANES
from skpose._compiled.simd.jit import by_address, internal
from skpose._compiled.simd.lanes import empty_aligned
from skpose._compiled.simd.signatures import FLAG, FLAG_VECTOR, MATRIX, REAL, VECTOR, tuple_type

N_ORIGIN = 3  # dofs of the root's position


class Equations(NamedTuple):
    """The equations H·step = −gradient."""

    matrix: np.ndarray  # (n, n) lower triangle; zero where two dofs move no joint in common
    gradient: np.ndarray  # (n,)
    step: np.ndarray  # (n,)
    fixed: np.ndarray  # (n,) bool: dofs that do not move
    cells: np.ndarray  # (n_registers, LANES) a band of one block, and the solution


EQUATIONS = tuple_type(Equations, MATRIX, VECTOR, VECTOR, FLAG_VECTOR, MATRIX)


@internal
def _band_of(n):
    """The band of n dofs, padded to whole registers."""
    width = -(-n // LANES)
    return Band(1, width, 0, width * LANES * 2 * width)


@internal
def equations_of(tree):
    """Equations for a tree, not yet filled, no dof fixed."""
    n = N_ORIGIN + tree.column.shape[0]
    band = _band_of(n)
    cells = empty_aligned(band.solution + band.n, LANES, np.float64)
    return Equations(np.zeros((n, n)), np.zeros(n), np.zeros(n), np.zeros(n, np.bool_), cells)


@by_address(lambda: FLAG(EQUATIONS, REAL))
def factorise(equations, damping):
    """Factorise the matrix plus a multiple of the identity; return whether that is positive definite.

    Fixed and padded dofs get a row of the identity.
    """
    matrix, fixed, cells, n = equations.matrix, equations.fixed, equations.cells, equations.step.shape[0]
    band, numbers = _band_of(n), cells.reshape(cells.size)
    width = 2 * band.n * LANES
    clear(cells, 0, band.solution)
    for k in range(band.n * LANES):
        numbers[k * width + k] = 1.0
    for k in range(n):
        if not fixed[k]:
            for j in range(k):
                numbers[j * width + k] = 0.0 if fixed[j] else matrix[k, j]
            numbers[k * width + k] = matrix[k, k] + damping
    return factorise_band(cells, band)


@by_address(lambda: REAL(EQUATIONS, REAL))
def solve(equations, damping):
    """Compute the step from the factors; return the decrease of the quadratic model, without the damping."""
    cells, gradient, step, lowered = equations.cells, equations.gradient, equations.step, 0.0
    band, numbers = _band_of(step.shape[0]), cells.reshape(cells.size)
    at = band.solution * LANES
    clear(cells, band.solution, band.n)
    for k in range(step.shape[0]):
        numbers[at + k] = 0.0 if equations.fixed[k] else -gradient[k]
    substitute_forward(cells, band)
    substitute_back(cells, band)
    for k in range(step.shape[0]):
        step[k] = numbers[at + k]
        lowered += 0.5 * step[k] * (damping * step[k] - gradient[k])
    return lowered
