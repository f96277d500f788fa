"""The parts of the geodesic's solver, each against dense numpy: gradient, Gauss-Newton blocks, Hessian, solution."""

from typing import NamedTuple

import numpy as np
import pytest
from conftest import MIXED, random_tree
from entries import from_python

from skpose._compiled.path.block_cholesky import factorise, factors_for, solve
from skpose._compiled.path.energy import LANES, STEPS, evaluate, path_of, samples_for
from skpose._compiled.path.normal_equations import NormalEquations, equations_for, normal_equations
from skpose._compiled.pose.tree import Tree
from skpose.kinematics import position_jacobian
from skpose.kinematics._tree import from_tree_order, to_tree_order, tree_of

factorise, factors_for, solve = map(from_python, (factorise, factors_for, solve))
evaluate, path_of = from_python(evaluate), from_python(path_of)
normal_equations, equations_for, samples_for = map(from_python, (normal_equations, equations_for, samples_for))

N_NODES = 4
SUBSTEPS = pytest.mark.parametrize("substeps", [1, 4])

# Small, so that the tests run without compilation too; one branch of the tree fills more than two registers.
SKELETONS = {
    "tree": random_tree(0),
    "ball joints": random_tree(2, n=4, kinds=["rotvec"]),
    "mixed joints, weights": random_tree(3, n=6, kinds=MIXED).with_weights([0.5, 2.0, 0.7, 1.0, 0.3, 3.0]),
}


@pytest.fixture(params=SKELETONS, scope="module")
def skeleton(request):
    return SKELETONS[request.param]


class Parts(NamedTuple):
    """Half the energy of a path, and its derivatives in the free poses."""

    half: float
    gradient: np.ndarray  # (n_free · n_dofs,)
    matrix: np.ndarray  # (n_free · n_dofs, n_free · n_dofs)
    tree: Tree
    equations: NormalEquations


def blocks(tree, equations):
    """The blocks on the diagonal, (n_nodes, n_dofs, n_dofs), and those right of them."""
    n_nodes, n = equations.gradient.shape
    diagonal, off_diagonal = np.zeros((n_nodes, n, n)), np.zeros((n_nodes - 1, n, n))
    n_pairs = equations.first_pair[-1]
    pairs = equations.pairs.reshape(-1, n_pairs, 4, LANES)
    ancestors = [
        [
            e
            for first, stop in tree.dof_ranges[tree.first_dof_range[f] : tree.first_dof_range[f + 1]]
            for e in range(first, stop)
        ]
        for f in range(len(tree.frame_parent))
    ]
    for f in range(1, len(tree.frame_parent)):
        for d in range(tree.first_dof[f], tree.end_dof[f]):
            coupled = [e for e in ancestors[f] if e <= d]
            assert equations.first_pair[d + 1] - equations.first_pair[d] == len(coupled)
            for k, e in enumerate(coupled):
                for i in range(n_nodes - 1):
                    first, second, forward, back = pairs[i // STEPS, equations.first_pair[d] + k, :, i % STEPS]
                    diagonal[i, d, e] += first
                    diagonal[i + 1, d, e] += second
                    off_diagonal[i, d, e], off_diagonal[i, e, d] = forward, back
    return diagonal, off_diagonal


def parts(skeleton, poses, substeps, exact=False):
    tree = tree_of(skeleton)
    path = path_of(tree, poses, substeps)
    samples, equations = samples_for(tree, path), equations_for(tree, path)
    half = evaluate(tree, path, samples)
    normal_equations(tree, path, exact, samples, equations)
    n, n_nodes = poses.shape[1], len(poses)
    dense = np.zeros((n_nodes * n, n_nodes * n))
    diagonal, off_diagonal = blocks(tree, equations)
    for i in range(n_nodes):
        here, after = slice(i * n, (i + 1) * n), slice((i + 1) * n, (i + 2) * n)
        dense[here, here] = np.tril(diagonal[i]) + np.tril(diagonal[i], -1).T
        if i < n_nodes - 1:
            dense[here, after], dense[after, here] = off_diagonal[i], off_diagonal[i].T
    free = slice(n, (n_nodes - 1) * n)
    return Parts(half, equations.gradient[1:-1].ravel().copy(), dense[free, free], tree, equations)


@pytest.fixture(scope="module")
def poses(skeleton):
    """Poses in the tree's order and about its axes, far enough apart for second derivatives to matter."""
    return np.cumsum(np.random.default_rng(0).normal(size=(N_NODES, skeleton.n_dofs)) * 0.4, axis=0)


def difference(function, poses, step=1e-5):
    """Derivative of a function of the path in its free poses, by central differences."""
    rows = []
    for i in range(1, N_NODES - 1):
        for d in range(poses.shape[1]):
            move = np.zeros_like(poses)
            move[i, d] = step
            rows.append((function(poses + move) - function(poses - move)) / (2 * step))
    return np.array(rows)


@SUBSTEPS
def test_gradient_is_the_derivative_of_the_energy(substeps, skeleton, poses):
    expected = difference(lambda moved: parts(skeleton, moved, substeps).half, poses)
    np.testing.assert_allclose(parts(skeleton, poses, substeps).gradient, expected, atol=1e-7 * np.abs(expected).max())


@SUBSTEPS
def test_hessian_is_the_derivative_of_the_gradient(substeps, skeleton, poses):
    hessian = parts(skeleton, poses, substeps, exact=True).matrix
    expected = difference(lambda moved: parts(skeleton, moved, substeps).gradient, poses)
    np.testing.assert_allclose(hessian, expected, atol=1e-6 * np.abs(expected).max())


@SUBSTEPS
def test_longer_paths_than_one_register_of_steps(substeps):
    """Fifteen nodes are in three groups of steps: energy, gradient and matrix of the whole are the sums of parts."""
    skeleton = random_tree(3, n=6, kinds=MIXED, offset_frame="parent")
    n, n_nodes = skeleton.n_dofs, 15
    poses = np.cumsum(np.random.default_rng(0).normal(size=(n_nodes, n)) * 0.3, axis=0)
    whole = parts(skeleton, poses, substeps, exact=True)
    half, gradient, matrix = 0.0, np.zeros(whole.gradient.shape), np.zeros(whole.matrix.shape)
    for i in range(n_nodes - 3):  # four nodes have two free ones; of these only the first is not in the part before
        part = parts(skeleton, poses[i : i + 4], substeps, exact=True)
        own = slice(i * n, (i + 2) * n)
        gradient[own], matrix[own, own] = part.gradient, part.matrix
    for i in range(n_nodes - 1):
        half += parts(skeleton, poses[i : i + 2], substeps).half
    np.testing.assert_allclose(whole.half, half, rtol=1e-12)
    np.testing.assert_allclose(whole.gradient, gradient, atol=1e-12 * np.abs(gradient).max())
    np.testing.assert_allclose(whole.matrix, matrix, atol=1e-12 * np.abs(matrix).max())


@SUBSTEPS
def test_normal_equations_are_those_of_the_chords(substeps, skeleton, poses):
    tree = tree_of(skeleton)
    at = np.linspace(0, N_NODES - 1, (N_NODES - 1) * substeps + 1)
    samples = np.stack([np.interp(at, np.arange(N_NODES), column) for column in poses.T], axis=1)
    J = to_tree_order(tree, position_jacobian(from_tree_order(tree, samples, samples), skeleton))
    J *= np.repeat(np.sqrt(skeleton.weights), 3)[:, None]
    share = np.maximum(0, 1 - np.abs(at[:, None] - np.arange(1, N_NODES - 1)))  # of each sample in each free pose
    moved = np.einsum("si,srd->srid", share, J)
    A = np.diff(moved, axis=0).reshape(-1, (N_NODES - 2) * skeleton.n_dofs)
    np.testing.assert_allclose(parts(skeleton, poses, substeps).matrix, A.T @ A, atol=1e-11 * np.abs(A.T @ A).max())


def expected_step(part, damping, fixed):
    """The damped step of the free poses, by dense numpy."""
    free = ~fixed[1:-1].ravel()
    step = np.zeros(free.size)
    damped = part.matrix[np.ix_(free, free)] + damping * np.eye(free.sum())
    step[free] = -np.linalg.solve(damped, part.gradient[free])
    return step


@pytest.mark.parametrize("share_fixed", [0.0, 0.3])
@pytest.mark.parametrize("n_nodes", [3, 10])
def test_solution_of_the_damped_equations(skeleton, n_nodes, share_fixed):
    rng = np.random.default_rng(0)
    poses = np.cumsum(rng.normal(size=(n_nodes, skeleton.n_dofs)) * 0.4, axis=0)
    part = parts(skeleton, poses, 1)
    fixed = np.zeros(poses.shape, bool)
    fixed[1:-1] = rng.random((n_nodes - 2, skeleton.n_dofs)) < share_fixed
    part.equations.gradient[fixed] = 0.0
    step, factors = np.zeros(poses.shape), factors_for(part.tree, n_nodes)
    for _ in range(2):  # what is left from the first time changes nothing
        assert factorise(part.tree, part.equations, 0.5, fixed, factors)
        solve(part.equations, factors, step)
        np.testing.assert_allclose(step[1:-1].ravel(), expected_step(part, 0.5, fixed), rtol=0, atol=1e-12)
