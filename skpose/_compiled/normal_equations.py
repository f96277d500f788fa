"""Gradient, Gauss-Newton matrix and Hessian of a path's energy, block by block.

The matrix is block tridiagonal: a pose shares chords with the pose before it and the pose after it. Sample k lies at
the fraction t from one pose to the next, so that it moves with 1 − t of the one and t of the other, and adds to four
blocks. No Jacobian is ever formed: its products are sums over the joints that a dof moves, gathered from the tips of
the skeleton to the root.
"""

from typing import NamedTuple

import numpy as np
from numba import types

from skpose._compiled.jit import internal, separate, unfolded
from skpose._compiled.path_energy import PATH, add_gradient, substeps_of, sum_moments
from skpose._compiled.rotation import second_derivatives
from skpose._compiled.signatures import CUBE, MATRIX, TREE, named


class NormalEquations(NamedTuple):
    """The system of a damped step, of all poses; the blocks of the two ends are filled but not read."""

    diagonal: np.ndarray  # (n_nodes, n_dofs, n_dofs) lower triangles only
    off_diagonal: np.ndarray  # (n_nodes - 1, n_dofs, n_dofs) the block right of each diagonal one
    gradient: np.ndarray  # (n_nodes, n_dofs) of half the energy, m²/rad


EQUATIONS = named(NormalEquations, CUBE, CUBE, MATRIX)


@unfolded
def equations_for(path):
    """Return normal equations for a path, not yet filled."""
    n_nodes, n = path.poses.shape
    return NormalEquations(np.empty((n_nodes, n, n)), np.empty((n_nodes - 1, n, n)), np.empty((n_nodes, n)))


@unfolded
def _blocks_of(equations, node):
    """Return the part of the equations that belongs to the samples between a pose and the next one."""
    return NormalEquations(
        equations.diagonal[node : node + 2],
        equations.off_diagonal[node : node + 1],
        equations.gradient[node : node + 2],
    )


@unfolded
def mean_diagonal(equations):
    """Return the mean of the diagonal over the free poses: the scale of the damping."""
    total, n_free = 0.0, equations.gradient.shape[0] - 2
    for i in range(1, n_free + 1):
        for d in range(equations.gradient.shape[1]):
            total += equations.diagonal[i, d, d] / (n_free * equations.gradient.shape[1])
    return total


@internal
def _sum_products(tree, P, Q, sums):
    """Sum p qᵀ, p, q and 1, weighted, over the joints that each frame moves, (n_frames, 16), for two samples p, q."""
    sums[:] = 0.0
    for j in range(1, tree.offset.shape[0]):
        total, weight = sums[tree.joint_frame[j]], tree.scale[j] * tree.scale[j]
        for i in range(3):
            p, q = weight * P[3 * j + i], weight * Q[3 * j + i]
            for k in range(3):
                total[3 * i + k] += p * Q[3 * j + k]
            total[9 + i] += p
            total[12 + i] += q
        total[15] += weight
    for f in range(tree.frame_parent.shape[0] - 1, 0, -1):
        for i in range(sums.shape[1]):
            sums[tree.frame_parent[f], i] += sums[f, i]


@internal
def _add_square(tree, P, screws, t, sums, blocks):
    """Add JᵀJ of one sample, twice, as it ends one chord and starts the next.

    As in the composite-rigid-body algorithm: Σ (a × p + b)·(c × p + e), over the joints p that both of two dofs with
    screws (a, b) and (c, e) move, is linear in either screw, with coefficients made of the sums of p pᵀ and p.
    """
    _sum_products(tree, P, P, sums)
    diagonal, off_diagonal = blocks.diagonal, blocks.off_diagonal[0]
    before, after, between = (1.0 - t) * (1.0 - t), t * t, t * (1.0 - t)
    for f in range(1, tree.frame_parent.shape[0]):
        xx, xy, xz, yx, yy, yz, zx, zy, zz, px, py, pz, _, _, _, n = sums[f]
        trace = xx + yy + zz
        for d in range(tree.first_dof[f], tree.end_dof[f]):
            a, b, c, u, v, w = screws[:, d]
            j0 = (trace - xx) * a - xy * b - xz * c + py * w - pz * v
            j1 = (trace - yy) * b - yx * a - yz * c + pz * u - px * w
            j2 = (trace - zz) * c - zx * a - zy * b + px * v - py * u
            j3 = b * pz - c * py + n * u
            j4 = c * px - a * pz + n * v
            j5 = a * py - b * px + n * w
            for s in range(tree.first_run[f], tree.first_run[f + 1]):
                for e in range(tree.runs[s, 0], min(tree.runs[s, 1], d + 1)):
                    jj = j0 * screws[0, e] + j1 * screws[1, e] + j2 * screws[2, e]
                    jj += j3 * screws[3, e] + j4 * screws[4, e] + j5 * screws[5, e]
                    diagonal[0, d, e] += 2.0 * before * jj
                    diagonal[1, d, e] += 2.0 * after * jj
                    off_diagonal[d, e] += 2.0 * between * jj
                    if e < d:
                        off_diagonal[e, d] += 2.0 * between * jj


@internal
def _subtract_products(tree, path, k, t, sums, blocks):
    """Subtract JᵀK and KᵀJ, J and K the Jacobians of sample k and of the next one, as a chord joins them.

    As `_add_square`, with the sums of p qᵀ, p and q over the joints of the two samples.
    """
    _sum_products(tree, path.P[k], path.P[k + 1], sums)
    screws, others = path.screws[k], path.screws[k + 1]
    diagonal, off_diagonal = blocks.diagonal, blocks.off_diagonal[0]
    u = t + 1.0 / substeps_of(path)  # where the next one is
    before, after, across, back = (t - 1.0) * (1.0 - u), -t * u, (t - 1.0) * u, t * (u - 1.0)
    for f in range(1, tree.frame_parent.shape[0]):
        xx, xy, xz, yx, yy, yz, zx, zy, zz, px, py, pz, qx, qy, qz, n = sums[f]
        trace = xx + yy + zz
        for d in range(tree.first_dof[f], tree.end_dof[f]):
            a, b, c, u, v, w = screws[:, d]
            j0 = (trace - xx) * a - xy * b - xz * c + qy * w - qz * v
            j1 = (trace - yy) * b - yx * a - yz * c + qz * u - qx * w
            j2 = (trace - zz) * c - zx * a - zy * b + qx * v - qy * u
            j3 = b * pz - c * py + n * u
            j4 = c * px - a * pz + n * v
            j5 = a * py - b * px + n * w
            a, b, c, u, v, w = others[:, d]
            k0 = (trace - xx) * a - yx * b - zx * c + py * w - pz * v
            k1 = (trace - yy) * b - xy * a - zy * c + pz * u - px * w
            k2 = (trace - zz) * c - xz * a - yz * b + px * v - py * u
            k3 = b * qz - c * qy + n * u
            k4 = c * qx - a * qz + n * v
            k5 = a * qy - b * qx + n * w
            for s in range(tree.first_run[f], tree.first_run[f + 1]):
                for e in range(tree.runs[s, 0], min(tree.runs[s, 1], d + 1)):
                    jk = j0 * others[0, e] + j1 * others[1, e] + j2 * others[2, e]
                    jk += j3 * others[3, e] + j4 * others[4, e] + j5 * others[5, e]
                    kj = k0 * screws[0, e] + k1 * screws[1, e] + k2 * screws[2, e]
                    kj += k3 * screws[3, e] + k4 * screws[4, e] + k5 * screws[5, e]
                    diagonal[0, d, e] += before * (jk + kj)
                    diagonal[1, d, e] += after * (jk + kj)
                    off_diagonal[d, e] += across * jk + back * kj
                    if e < d:
                        off_diagonal[e, d] += across * kj + back * jk


@separate(lambda: types.void(TREE, PATH, EQUATIONS))
def normal_equations(tree, path, equations):
    """Compute the blocks of the normal equations, and the gradient of half the energy."""
    equations.diagonal[:], equations.off_diagonal[:], equations.gradient[:] = 0.0, 0.0, 0.0
    n_frames, n_samples, substeps = tree.frame_parent.shape[0], path.P.shape[0], substeps_of(path)
    sums, moments = np.empty((n_frames, 16)), np.empty((n_frames, 12))
    for k in range(n_samples - 1):
        node = k // substeps
        t = (k - node * substeps) / substeps
        blocks = _blocks_of(equations, node)
        if k > 0:
            sum_moments(tree, path.P[k - 1], path.P[k], path.P[k + 1], moments)
            add_gradient(tree, path.screws[k], moments, t, blocks.gradient)
            _add_square(tree, path.P[k], path.screws[k], t, sums, blocks)
        if substeps > 1 or 0 < k < n_samples - 2:
            _subtract_products(tree, path, k, t, sums, blocks)


@internal
def _add_second_derivatives(tree, path, k, t, moments, blocks):
    """Add the term that Gauss-Newton leaves out: forces on a sample times second derivatives of its joint positions.

    For axes a and c, where c is a or an axis between a and the root, ∂²p = c × (a × (p − o)). So Σ w·∂²p =
    c·(M − tr M)a with M = Σ (p − o) wᵀ over the joints that a moves.
    """
    P, screws = path.P[k], path.screws[k]
    diagonal, off_diagonal = blocks.diagonal, blocks.off_diagonal[0]
    for f in range(1, tree.frame_parent.shape[0]):
        xx, xy, xz, yx, yy, yz, zx, zy, zz, u, v, w = moments[f]
        o = 3 * tree.pivot[f]
        ox, oy, oz = P[o], P[o + 1], P[o + 2]
        trace = xx + yy + zz - ox * u - oy * v - oz * w
        for d in range(tree.first_dof[f], tree.end_dof[f]):
            a, b, c = screws[0, d], screws[1, d], screws[2, d]
            along = u * a + v * b + w * c
            x = xx * a + xy * b + xz * c - along * ox - trace * a
            y = yx * a + yy * b + yz * c - along * oy - trace * b
            z = zx * a + zy * b + zz * c - along * oz - trace * c
            for s in range(tree.first_run[f], tree.first_run[f + 1]):
                for e in range(tree.runs[s, 0], min(tree.runs[s, 1], d + 1)):
                    second = x * screws[0, e] + y * screws[1, e] + z * screws[2, e]
                    diagonal[0, d, e] += (1.0 - t) * (1.0 - t) * second
                    diagonal[1, d, e] += t * t * second
                    off_diagonal[d, e] += t * (1.0 - t) * second
                    if e < d:
                        off_diagonal[e, d] += t * (1.0 - t) * second
        if tree.ball[f] >= 0:
            moment = yz - zy - (oy * w - oz * v), zx - xz - (oz * u - ox * w), xy - yx - (ox * v - oy * u)
            _add_ball(tree.first_dof[f], path, k, t, moment, blocks)


@internal
def _add_ball(first, path, k, t, moment, blocks):
    """Add what the axes of a ball joint, dofs first to first + 2, change with its rotation vector, times the moment."""
    node, screws = min(k // substeps_of(path), path.poses.shape[0] - 2), path.screws[k]
    before, after = path.poses[node], path.poses[node + 1]
    x = before[first] + t * (after[first] - before[first])
    y = before[first + 1] + t * (after[first + 1] - before[first + 1])
    z = before[first + 2] + t * (after[first + 2] - before[first + 2])
    a, b, c = moment
    along = (
        a * screws[0, first] + b * screws[1, first] + c * screws[2, first],
        a * screws[0, first + 1] + b * screws[1, first + 1] + c * screws[2, first + 1],
        a * screws[0, first + 2] + b * screws[1, first + 2] + c * screws[2, first + 2],
    )
    second = second_derivatives((x, y, z), along)
    for j in range(3):
        for i in range(j + 1):
            d, e = first + j, first + i
            blocks.diagonal[0, d, e] += (1.0 - t) * (1.0 - t) * second[j, i]
            blocks.diagonal[1, d, e] += t * t * second[j, i]
            blocks.off_diagonal[0, d, e] += t * (1.0 - t) * second[j, i]
            if i < j:
                blocks.off_diagonal[0, e, d] += t * (1.0 - t) * second[j, i]


@separate(lambda: types.void(TREE, PATH, EQUATIONS))
def add_second_derivatives(tree, path, equations):
    """Make the normal equations the exact Hessian."""
    substeps, moments = substeps_of(path), np.empty((tree.frame_parent.shape[0], 12))
    for k in range(1, path.P.shape[0] - 1):
        node = k // substeps
        t = (k - node * substeps) / substeps
        sum_moments(tree, path.P[k - 1], path.P[k], path.P[k + 1], moments)
        _add_second_derivatives(tree, path, k, t, moments, _blocks_of(equations, node))
