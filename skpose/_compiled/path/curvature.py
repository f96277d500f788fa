"""The terms of a path's Hessian that Gauss-Newton leaves out: forces on samples times second derivatives.

Steps are in lanes; the rows of screws, moments, forces and pairs are those of `normal_equations`.
"""

from skpose._compiled.pose.rotation import second_derivatives
from skpose._compiled.simd.jit import inlined, internal


@inlined
def screw_at(screws, row):
    """Return the six numbers of a screw from a row on."""
    return screws[row], screws[row + 1], screws[row + 2], screws[row + 3], screws[row + 4], screws[row + 5]


@internal
def add_second_derivatives(tree, f, d, substeps, screws, moments, forces):
    """Add what the joint positions' second derivatives by dof d and others add to the forces that resist it.

    A dof moves p at the rate a × p + b, its screw. For the axis c of this dof or of one between it and the root, ∂²p =
    c × (a × p + b). So Σ w·∂²p = c·((M − tr M)a + b × Σ w) with M = Σ p wᵀ over the joints that the dof moves.
    """
    n, n_frames = tree.column.shape[0], tree.frame_parent.shape[0]
    for s in range(substeps + 1):
        m, row, t = 12 * (s * n_frames + f), 12 * s, s / substeps
        u, v, w = moments[m + 9], moments[m + 10], moments[m + 11]
        a, b, c, p, q, r = screw_at(screws, 6 * (n * s + d))
        trace = moments[m] + moments[m + 4] + moments[m + 8]
        x = moments[m] * a + moments[m + 1] * b + moments[m + 2] * c - trace * a + (q * w - r * v)
        y = moments[m + 3] * a + moments[m + 4] * b + moments[m + 5] * c - trace * b + (r * u - p * w)
        z = moments[m + 6] * a + moments[m + 7] * b + moments[m + 8] * c - trace * c + (p * v - q * u)
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
