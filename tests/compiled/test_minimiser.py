"""The pieces of the geodesic's solver, each against dense numpy: gradient, Gauss-Newton blocks, Hessian, solution."""

import numpy as np
import pytest

from skpose import position_jacobian
from skpose._compiled.block_cholesky import band_shape, solve
from skpose._compiled.forward import workspace_rows
from skpose._compiled.path_energy import add_curvature, evaluate, normal_equations
from skpose.kinematics._tree import tree_of

N_NODES = 4
SUBSTEPS = pytest.mark.parametrize("substeps", [1, 4])


def parts(skeleton, path, substeps, exact=False):
    """Half the energy, its gradient and the dense matrix of the free poses, from the compiled pieces."""
    tree = tree_of(skeleton)
    n_samples, n = (N_NODES - 1) * substeps + 1, skeleton.n_dofs
    P, screws = np.empty((n_samples, 3 * len(tree.offset))), np.empty((n_samples, 6, n))
    half = evaluate(tree, path, substeps, np.empty(workspace_rows(tree)), P, screws)
    diagonal, beside, gradient = np.empty((N_NODES, n, n)), np.empty((N_NODES - 1, n, n)), np.empty((N_NODES, n))
    normal_equations(tree, substeps, P, screws, diagonal, beside, gradient)
    if exact:
        add_curvature(tree, substeps, P, screws, diagonal, beside)
    dense = np.zeros((N_NODES * n, N_NODES * n))
    for i in range(N_NODES):
        here, after = slice(i * n, (i + 1) * n), slice((i + 1) * n, (i + 2) * n)
        dense[here, here] = np.tril(diagonal[i]) + np.tril(diagonal[i], -1).T
        if i < N_NODES - 1:
            dense[here, after], dense[after, here] = beside[i], beside[i].T
    free = slice(n, (N_NODES - 1) * n)
    return half, gradient[1:-1].ravel(), dense[free, free], (tree, diagonal, beside, gradient)


@pytest.fixture
def path(skeleton):
    """Poses in the tree's order and about its axes, far enough apart for the Hessian to bend."""
    return np.cumsum(np.random.default_rng(0).normal(size=(N_NODES, skeleton.n_dofs)) * 0.4, axis=0)


def difference(function, path, step=1e-5):
    """Derivative of a function of the path in its free poses, by central differences."""
    rows = []
    for i in range(1, N_NODES - 1):
        for d in range(path.shape[1]):
            move = np.zeros_like(path)
            move[i, d] = step
            rows.append((function(path + move) - function(path - move)) / (2 * step))
    return np.array(rows)


@SUBSTEPS
def test_gradient_is_the_derivative_of_the_energy(substeps, skeleton, path):
    _, gradient, _, _ = parts(skeleton, path, substeps)
    expected = difference(lambda path: parts(skeleton, path, substeps)[0], path)
    np.testing.assert_allclose(gradient, expected, atol=1e-7 * np.abs(expected).max())


@SUBSTEPS
def test_hessian_is_the_derivative_of_the_gradient(substeps, skeleton, path):
    _, _, hessian, _ = parts(skeleton, path, substeps, exact=True)
    expected = difference(lambda path: parts(skeleton, path, substeps)[1], path)
    np.testing.assert_allclose(hessian, expected, atol=1e-6 * np.abs(expected).max())


@SUBSTEPS
def test_normal_equations_are_those_of_the_chords(substeps, skeleton, path):
    tree = tree_of(skeleton)
    at = np.linspace(0, N_NODES - 1, (N_NODES - 1) * substeps + 1)
    samples = np.stack([np.interp(at, np.arange(N_NODES), column) for column in path.T], axis=1)
    poses = np.empty_like(samples)
    poses[:, tree.column] = samples * tree.sign
    J = (position_jacobian(poses, skeleton)[:, :, tree.column]) * tree.sign
    share = np.maximum(0, 1 - np.abs(at[:, None] - np.arange(1, N_NODES - 1)))  # of each sample in each free pose
    moved = np.einsum("si,srd->srid", share, J)
    A = np.diff(moved, axis=0).reshape(-1, (N_NODES - 2) * skeleton.n_dofs)
    np.testing.assert_allclose(parts(skeleton, path, substeps)[2], A.T @ A, atol=1e-11 * np.abs(A.T @ A).max())


@pytest.mark.parametrize("share_held", [0.0, 0.3])
def test_solution_is_the_dense_one(share_held, skeleton, path):
    _, gradient, matrix, (tree, diagonal, beside, in_blocks) = parts(skeleton, path, 1)
    held = np.zeros(path.shape, bool)
    held[1:-1] = np.random.default_rng(1).random((N_NODES - 2, skeleton.n_dofs)) < share_held
    in_blocks[held] = 0.0
    step = np.zeros(path.shape)
    assert solve(tree, diagonal, beside, in_blocks, 0.5, held, np.empty(band_shape(tree, N_NODES)), step)
    free = ~held[1:-1].ravel()
    expected = np.zeros(free.size)
    expected[free] = -np.linalg.solve(matrix[np.ix_(free, free)] + 0.5 * np.eye(free.sum()), gradient[free])
    np.testing.assert_allclose(step[1:-1].ravel(), expected, atol=1e-12 * np.abs(expected).max())


def test_what_is_not_positive_definite_has_no_solution(skeleton, path):
    _, _, matrix, (tree, diagonal, beside, gradient) = parts(skeleton, path, 1)
    held, band, step = np.zeros(path.shape, bool), np.empty(band_shape(tree, N_NODES)), np.zeros(path.shape)
    largest = np.linalg.eigvalsh(matrix).max()
    assert not solve(tree, diagonal, beside, gradient, -1.01 * largest, held, band, step)
