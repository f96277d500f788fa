"""The terms of a path's Hessian that Gauss-Newton leaves out: forces on samples times second derivatives.

Steps are in lanes; the rows of screws, moments, forces and pairs are those of `normal_equations`.
"""

from skpose._compiled.pose.rotation import second_derivatives
from skpose._compiled.simd.jit import inlined, internal


@internal
def add_second_derivatives(tree, f, d, substeps, P, screws, moments, forces):
    """Add what the joint positions' second derivatives by dof d and others add to the forces that resist it.

    For axes a and c, where c is a or an axis between a and the root, ∂²p = c × (a × (p − o)). So Σ w·∂²p =
    c·(M − tr M)a with M = Σ (p − o) wᵀ over the joints that a moves.
    """
    n, n_frames, o = tree.column.shape[0], tree.frame_parent.shape[0], 3 * tree.pivot[f]
    for s in range(substeps + 1):
        m, at, row, t = 12 * (s * n_frames + f), s * 3 * tree.offset.shape[0] + o, 12 * s, s / substeps
        ox, oy, oz = P[at], P[at + 1], P[at + 2]
        u, v, w = moments[m + 9], moments[m + 10], moments[m + 11]
        k = 6 * (n * s + d)
        a, b, c = screws[k], screws[k + 1], screws[k + 2]
        trace = moments[m] + moments[m + 4] + moments[m + 8] - ox * u - oy * v - oz * w
        along = u * a + v * b + w * c
        x = moments[m] * a + moments[m + 1] * b + moments[m + 2] * c - along * ox - trace * a
        y = moments[m + 3] * a + moments[m + 4] * b + moments[m + 5] * c - along * oy - trace * b
        z = moments[m + 6] * a + moments[m + 7] * b + moments[m + 8] * c - along * oz - trace * c
        forces[row] = forces[row] + (1.0 - t) * x
        forces[row + 1] = forces[row + 1] + (1.0 - t) * y
        forces[row + 2] = forces[row + 2] + (1.0 - t) * z
        forces[row + 6] = forces[row + 6] + t * x
        forces[row + 7] = forces[row + 7] + t * y
        forces[row + 8] = forces[row + 8] + t * z


@inlined
def _add_to_pair(pairs, row, t, value):
    """Add a number of two dofs and one sample."""
    before, between, after = (1.0 - t) * (1.0 - t), t * (1.0 - t), t * t
    pairs[row], pairs[row + 1] = pairs[row] + before * value, pairs[row + 1] + after * value
    pairs[row + 2], pairs[row + 3] = pairs[row + 2] + between * value, pairs[row + 3] + between * value


@internal
def add_ball(tree, f, substeps, poses, P, screws, moments, pairs, rows_of):
    """Add what the axes of a ball joint change with its rotation vector, times the moment of the forces on it.

    The pairs of the joint's dofs with its first one are at these rows.
    """
    n, n_frames, d = tree.column.shape[0], tree.frame_parent.shape[0], tree.first_dof[f]
    for s in range(substeps + 1):
        m, k, t = 12 * (s * n_frames + f), 6 * (n * s + d), s / substeps
        at = 3 * (s * tree.offset.shape[0] + tree.pivot[f])
        u, v, w = moments[m + 9], moments[m + 10], moments[m + 11]
        a = moments[m + 5] - moments[m + 7] - (P[at + 1] * w - P[at + 2] * v)
        b = moments[m + 6] - moments[m + 2] - (P[at + 2] * u - P[at] * w)
        c = moments[m + 1] - moments[m + 3] - (P[at] * v - P[at + 1] * u)
        along = (
            a * screws[k] + b * screws[k + 1] + c * screws[k + 2],
            a * screws[k + 6] + b * screws[k + 7] + c * screws[k + 8],
            a * screws[k + 12] + b * screws[k + 13] + c * screws[k + 14],
        )
        vector = poses[d] + t * poses[n + d], poses[d + 1] + t * poses[n + d + 1], poses[d + 2] + t * poses[n + d + 2]
        (xx,), (yx, yy), (zx, zy, zz) = second_derivatives(vector, along)
        _add_to_pair(pairs, rows_of[0], t, xx)
        _add_to_pair(pairs, rows_of[1], t, yx)
        _add_to_pair(pairs, rows_of[1] + 4, t, yy)
        _add_to_pair(pairs, rows_of[2], t, zx)
        _add_to_pair(pairs, rows_of[2] + 4, t, zy)
        _add_to_pair(pairs, rows_of[2] + 8, t, zz)
