"""Normal equations of one pose, factorised along the tree: H = LᵀDL.

Two dofs are coupled in H = JᵀJ only where one is an ancestor of the other, as otherwise they move no joint in common.
Elimination from the leaves to the root keeps all other entries zero, so it costs n·depth² and not n³. R. Featherstone,
"Efficient factorization of the joint-space inertia matrix for branched kinematic trees", International Journal of
Robotics Research 24(6), 2005, doi:10.1177/0278364905054928.

The first three dofs are the position of the root, ancestors of all. Dof d of the tree is dof d + 3 here.
"""

from typing import NamedTuple

import numpy as np

from skpose._compiled.pose.signatures import TREE
from skpose._compiled.simd.jit import by_address, jit
from skpose._compiled.simd.signatures import FLAG, FLAG_VECTOR, INTEGER_VECTOR, MATRIX, REAL, VECTOR, tuple_type

N_ORIGIN = 3  # dofs of the root's position


class Equations(NamedTuple):
    """The equations H·step = −gradient; of H only the entries of a dof's ancestors and its own are used."""

    matrix: np.ndarray  # (n, n) lower triangle
    factor: np.ndarray  # (n, n) L below the diagonal, D on it
    gradient: np.ndarray  # (n,)
    step: np.ndarray  # (n,)
    fixed: np.ndarray  # (n,) bool: dofs that do not move
    frame_of: np.ndarray  # (n,) the frame of each dof; 0 for the root's position


EQUATIONS = tuple_type(Equations, MATRIX, MATRIX, VECTOR, VECTOR, FLAG_VECTOR, INTEGER_VECTOR)


@jit
def equations_of(tree):
    """Equations for a tree, not yet filled, no dof fixed."""
    n = N_ORIGIN + tree.column.shape[0]
    frame_of = np.zeros(n, np.int64)
    for f in range(1, tree.frame_parent.shape[0]):
        frame_of[N_ORIGIN + tree.first_dof[f] : N_ORIGIN + tree.end_dof[f]] = f
    zeros = np.zeros((n, n))
    return Equations(zeros, zeros.copy(), np.zeros(n), np.zeros(n), np.zeros(n, np.bool_), frame_of)


@by_address(lambda: FLAG(TREE, EQUATIONS, REAL))
def factorise(tree, equations, damping):
    """Factorise the matrix plus a multiple of the identity; return whether that is positive definite."""
    matrix, factor, fixed = equations.matrix, equations.factor, equations.fixed
    n = factor.shape[0]
    for k in range(n):  # a fixed dof has a row of the identity
        f = equations.frame_of[k]
        for j in range(min(N_ORIGIN, k + 1)):
            factor[k, j] = 0.0 if fixed[k] or fixed[j] else matrix[k, j]
        for s in range(tree.first_dof_range[f], tree.first_dof_range[f + 1]):
            for j in range(N_ORIGIN + tree.dof_ranges[s, 0], min(N_ORIGIN + tree.dof_ranges[s, 1], k + 1)):
                factor[k, j] = 0.0 if fixed[k] or fixed[j] else matrix[k, j]
        factor[k, k] = 1.0 if fixed[k] else matrix[k, k] + damping
    for k in range(n - 1, -1, -1):
        pivot = factor[k, k]
        if not pivot > 0.0:
            return False
        f = equations.frame_of[k]
        for s in range(tree.first_dof_range[f + 1] - 1, tree.first_dof_range[f] - 1, -1):
            for i in range(min(N_ORIGIN + tree.dof_ranges[s, 1], k) - 1, N_ORIGIN + tree.dof_ranges[s, 0] - 1, -1):
                share = factor[k, i] / pivot
                for j in range(N_ORIGIN):
                    factor[i, j] -= share * factor[k, j]
                for r in range(tree.first_dof_range[f], s + 1):
                    for j in range(N_ORIGIN + tree.dof_ranges[r, 0], min(N_ORIGIN + tree.dof_ranges[r, 1], i + 1)):
                        factor[i, j] -= share * factor[k, j]
                factor[k, i] = share
        for i in range(min(N_ORIGIN, k) - 1, -1, -1):
            share = factor[k, i] / pivot
            for j in range(i + 1):
                factor[i, j] -= share * factor[k, j]
            factor[k, i] = share
    return True


@by_address(lambda: REAL(TREE, EQUATIONS, REAL))
def solve(tree, equations, damping):
    """Compute the step from the factors; return the decrease of the quadratic model, without the damping."""
    factor, step, gradient = equations.factor, equations.step, equations.gradient
    n = factor.shape[0]
    for k in range(n):
        step[k] = 0.0 if equations.fixed[k] else -gradient[k]
    for k in range(n - 1, -1, -1):
        f = equations.frame_of[k]
        for s in range(tree.first_dof_range[f], tree.first_dof_range[f + 1]):
            for i in range(N_ORIGIN + tree.dof_ranges[s, 0], min(N_ORIGIN + tree.dof_ranges[s, 1], k)):
                step[i] -= factor[k, i] * step[k]
        for i in range(min(N_ORIGIN, k)):
            step[i] -= factor[k, i] * step[k]
    for k in range(n):
        f = equations.frame_of[k]
        value = step[k] / factor[k, k]
        for i in range(min(N_ORIGIN, k)):
            value -= factor[k, i] * step[i]
        for s in range(tree.first_dof_range[f], tree.first_dof_range[f + 1]):
            for i in range(N_ORIGIN + tree.dof_ranges[s, 0], min(N_ORIGIN + tree.dof_ranges[s, 1], k)):
                value -= factor[k, i] * step[i]
        step[k] = value
    lowered = 0.0
    for k in range(n):
        lowered += 0.5 * step[k] * (damping * step[k] - gradient[k])
    return lowered
