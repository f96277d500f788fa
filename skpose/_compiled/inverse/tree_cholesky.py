"""Normal equations of one pose, factorised along the tree: H = LᵀDL.

Two dofs are coupled in H = JᵀJ only where one is an ancestor of the other, as otherwise they move no joint in common.
Elimination from the leaves to the root keeps all other entries zero, so it costs n·depth² and not n³. R. Featherstone,
"Efficient factorization of the joint-space inertia matrix for branched kinematic trees", International Journal of
Robotics Research 24(6), 2005, doi:10.1177/0278364905054928.

The first three dofs are the position of the root, ancestors of all. Dof d of the tree is dof d + 3 here.
"""

from typing import NamedTuple

import numpy as np

from skpose._compiled.simd.jit import by_address, jit
from skpose._compiled.simd.signatures import (
    FLAG,
    FLAG_VECTOR,
    INTEGER_MATRIX,
    INTEGER_VECTOR,
    MATRIX,
    REAL,
    VECTOR,
    tuple_type,
)

N_ORIGIN = 3  # dofs of the root's position


class Equations(NamedTuple):
    """The equations H·step = −gradient; of H only the entries of a dof's ancestors and its own are used."""

    matrix: np.ndarray  # (n, n) lower triangle
    factor: np.ndarray  # (n, n) L below the diagonal, D on it
    gradient: np.ndarray  # (n,)
    step: np.ndarray  # (n,)
    fixed: np.ndarray  # (n,) bool: dofs that do not move
    frame_of: np.ndarray  # (n,) the frame of each dof; 0 for the root's position
    first_range: np.ndarray  # (n_frames + 1,) ranges of frame f: ranges[first_range[f]:first_range[f + 1]]
    ranges: np.ndarray  # (n_ranges, 2) dofs of a frame and of its ancestors: first, and the one behind the last


EQUATIONS = tuple_type(
    Equations, MATRIX, MATRIX, VECTOR, VECTOR, FLAG_VECTOR, INTEGER_VECTOR, INTEGER_VECTOR, INTEGER_MATRIX
)


@jit
def equations_of(tree):
    """Equations for a tree, not yet filled, no dof fixed."""
    n = N_ORIGIN + tree.column.shape[0]
    frame_of, ranges = np.zeros(n, np.int64), np.zeros((tree.dof_ranges.shape[0] + 1, 2), np.int64)
    first_range = tree.first_dof_range + 1
    first_range[0], ranges[0, 1] = 0, N_ORIGIN
    ranges[1:] = tree.dof_ranges + N_ORIGIN
    for f in range(1, tree.frame_parent.shape[0]):
        ranges[first_range[f], 0] = 0  # the dofs of the root's joint are the first ones of the tree
        frame_of[N_ORIGIN + tree.first_dof[f] : N_ORIGIN + tree.end_dof[f]] = f
    zeros, fixed = np.zeros((n, n)), np.zeros(n, np.bool_)
    return Equations(zeros, zeros.copy(), np.zeros(n), np.zeros(n), fixed, frame_of, first_range, ranges)


@by_address(lambda: FLAG(EQUATIONS, REAL))
def factorise(equations, damping):
    """Factorise the matrix plus a multiple of the identity; return whether that is positive definite."""
    matrix, factor, fixed = equations.matrix, equations.factor, equations.fixed
    first_range, ranges, n = equations.first_range, equations.ranges, equations.factor.shape[0]
    for k in range(n):  # a fixed dof has a row of the identity
        f = equations.frame_of[k]
        for s in range(first_range[f], first_range[f + 1]):
            for j in range(ranges[s, 0], min(ranges[s, 1], k + 1)):
                factor[k, j] = 0.0 if fixed[k] or fixed[j] else matrix[k, j]
        factor[k, k] = 1.0 if fixed[k] else matrix[k, k] + damping
    for k in range(n - 1, -1, -1):
        pivot = factor[k, k]
        if not pivot > 0.0:
            return False
        f = equations.frame_of[k]
        for s in range(first_range[f + 1] - 1, first_range[f] - 1, -1):
            for i in range(min(ranges[s, 1], k) - 1, ranges[s, 0] - 1, -1):
                share = factor[k, i] / pivot
                for r in range(first_range[f], s + 1):
                    for j in range(ranges[r, 0], min(ranges[r, 1], i + 1)):
                        factor[i, j] -= share * factor[k, j]
                factor[k, i] = share
    return True


@by_address(lambda: REAL(EQUATIONS, REAL))
def solve(equations, damping):
    """Compute the step from the factors; return the decrease of the quadratic model, without the damping."""
    factor, step, gradient = equations.factor, equations.step, equations.gradient
    first_range, ranges, n, lowered = equations.first_range, equations.ranges, factor.shape[0], 0.0
    for k in range(n):
        step[k] = 0.0 if equations.fixed[k] else -gradient[k]
    for k in range(n - 1, -1, -1):
        f = equations.frame_of[k]
        for s in range(first_range[f], first_range[f + 1]):
            for i in range(ranges[s, 0], min(ranges[s, 1], k)):
                step[i] -= factor[k, i] * step[k]
    for k in range(n):
        value = step[k] / factor[k, k]
        f = equations.frame_of[k]
        for s in range(first_range[f], first_range[f + 1]):
            for i in range(ranges[s, 0], min(ranges[s, 1], k)):
                value -= factor[k, i] * step[i]
        step[k] = value
        lowered += 0.5 * value * (damping * value - gradient[k])
    return lowered
