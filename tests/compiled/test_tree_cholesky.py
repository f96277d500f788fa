"""Equations along a tree against dense numpy: factors, solutions, fixed dofs, matrices that are not definite."""

import numpy as np
import pytest
from conftest import MIXED, random_tree
from entries import from_python

from skpose import Skeleton
from skpose._compiled.inverse.tree_cholesky import N_ORIGIN, equations_of, factorise, solve
from skpose.kinematics._tree import tree_of_all_joints
from skpose.skeleton._root import with_root_joint

factorise, solve = from_python(factorise), from_python(solve)

SKELETONS = {
    "chain": Skeleton.chain(4),
    "tree": random_tree(0),
    "ball joints": random_tree(2, n=6, kinds=["rotvec"]),
    "mixed joints": random_tree(3, kinds=MIXED, offset_frame="parent"),
}


def coupled(tree, n):
    """Return which two dofs move a joint in common: one is the origin's, of the same frame or of one above."""
    above = np.zeros((n, n), bool)
    above[:, :N_ORIGIN] = True
    for f in range(1, len(tree.frame_parent)):
        g = f
        while g > 0:
            own, its = (slice(N_ORIGIN + tree.first_dof[h], N_ORIGIN + tree.end_dof[h]) for h in (f, g))
            above[own, its] = True
            g = tree.frame_parent[g]
    return np.tril(above)


@pytest.fixture(params=SKELETONS)
def system(request):
    """A tree, its equations, filled at random, and the dense matrix."""
    tree = tree_of_all_joints(with_root_joint(SKELETONS[request.param]))
    equations, rng = equations_of(tree), np.random.default_rng(0)
    n = len(equations.gradient)
    # JᵀJ of a Jacobian whose rows, those of joints, are zero for dofs that do not move them.
    pattern = coupled(tree, n)
    jacobian = np.concatenate([rng.normal(size=(3, n)) * pattern[k] for k in range(n)])
    dense = jacobian.T @ jacobian
    assert (dense[~(pattern | pattern.T)] == 0).all()
    equations.matrix[:] = np.where(pattern, dense, np.nan)  # nothing else is read
    equations.gradient[:] = rng.normal(size=n)
    return tree, equations, dense


@pytest.mark.parametrize("damping", [0.0, 0.3, 1e3])
def test_solutions_are_those_of_dense_equations(system, damping):
    tree, equations, dense = system
    damped = dense + damping * np.eye(len(dense))
    assert factorise(tree, equations, damping)
    lowered = solve(tree, equations, damping)
    step = np.linalg.solve(damped, -equations.gradient)
    np.testing.assert_allclose(equations.step, step, rtol=1e-8, atol=1e-10)
    np.testing.assert_allclose(lowered, -(equations.gradient @ step + 0.5 * step @ dense @ step), rtol=1e-8)


def test_factors_have_no_entries_but_those_of_the_matrix(system):
    tree, equations, dense = system
    assert factorise(tree, equations, 0.1)
    used = coupled(tree, len(dense))
    L = np.where(used, equations.factor, 0.0)
    D = np.diag(np.diag(L)).copy()
    np.fill_diagonal(L, 1.0)
    np.testing.assert_allclose(L.T @ D @ L, dense + 0.1 * np.eye(len(dense)), atol=1e-9)
    assert (equations.factor[~used] == 0).all()


def test_fixed_dofs_do_not_move_and_the_others_as_without_them(system):
    tree, equations, dense = system
    fixed = np.random.default_rng(1).uniform(size=len(dense)) < 0.4
    equations.fixed[:] = fixed
    assert factorise(tree, equations, 0.2)
    lowered = solve(tree, equations, 0.2)
    free = ~fixed
    part = dense[np.ix_(free, free)]
    step = np.linalg.solve(part + 0.2 * np.eye(len(part)), -equations.gradient[free])
    assert (equations.step[fixed] == 0).all()
    np.testing.assert_allclose(equations.step[free], step, rtol=1e-8, atol=1e-10)
    np.testing.assert_allclose(lowered, -(equations.gradient[free] @ step + 0.5 * step @ part @ step), rtol=1e-8)


def test_a_matrix_that_is_not_positive_definite_is_refused(system):
    tree, equations, dense = system
    least = np.linalg.eigvalsh(dense)[0]
    assert factorise(tree, equations, -0.5 * least)
    assert not factorise(tree, equations, -1.5 * least)
    equations.matrix[0, 0] = np.nan
    assert not factorise(tree, equations, 0.0)
