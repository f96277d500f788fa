"""The energy of a path, eq. 6 of the paper, its gradient and Hessian.

A path is a row of poses; its energy Σ ‖F(θ_i) − F(θ_{i−1})‖² is a sum of squares. Its gradient is
2 (2F(θ_i) − F(θ_{i−1}) − F(θ_{i+1}))ᵀ J_i. (Eq. 12 of the paper loses the sign of the first inner derivative, so that
F(θ_i) drops out of its eq. 7 and 13.)

Some poses of the path are free, and between each two there may be `substeps` chords, over poses that lie evenly on the
straight line in angle space and move with the free ones: their energy counts what happens between these. One chord is
the plain eq. 6.
"""

import math

import numpy as np

from skpose._compiled.forward import orient, place_joints, workspace, workspace_rows
from skpose._compiled.jacobian import turn_axes
from skpose._compiled.jit import jit

FINE = 8  # chords into which each chord of a path is divided to measure it again


@jit
def place(tree, angles, scratch, P, screws):
    """Joint positions of one pose, angles in the tree's order, and the screw of every dof, (6, n_dofs).

    The screw is the axis a and the velocity b = o × a of what passes the root, o on the axis: the dof moves a point p
    that hangs on it at the rate a × p + b.
    """
    C, S, H, positions = workspace(tree, scratch)
    orient(tree, angles, C, S, H)
    place_joints(tree, H, positions)
    for i in range(P.shape[0]):
        P[i] = positions[i]
    turn_axes(tree, C, S, H, screws[:3].T)
    for f in range(1, tree.frame_parent.shape[0]):
        o = 3 * tree.pivot[f]
        for d in range(tree.first_dof[f], tree.end_dof[f]):
            x, y, z = screws[0, d], screws[1, d], screws[2, d]
            screws[3, d] = P[o + 1] * z - P[o + 2] * y
            screws[4, d] = P[o + 2] * x - P[o] * z
            screws[5, d] = P[o] * y - P[o + 1] * x


@jit
def divided(path, parts):
    """The path with every step divided into equal parts."""
    n_steps, n_dofs = path.shape[0] - 1, path.shape[1]
    out = np.empty((n_steps * parts + 1, n_dofs))
    for i in range(out.shape[0]):
        step = min(i // parts, n_steps - 1)
        t = (i - step * parts) / parts
        for d in range(n_dofs):
            out[i, d] = path[step, d] + t * (path[step + 1, d] - path[step, d])
    for d in range(n_dofs):
        out[-1, d] = path[-1, d]  # exactly
    return out


@jit
def chords(tree, path):
    """Sum of the path's chords, and of their squares."""
    C, S, H, P = workspace(tree, np.empty(workspace_rows(tree)))
    length, energy = 0.0, 0.0
    for i in range(path.shape[0]):
        orient(tree, path[i], C, S, H)
        square = place_joints(tree, H, P)
        if i > 0:
            length += math.sqrt(square)
            energy += square
    return length, energy


@jit
def curve_length(tree, path):
    """Length of the path measured on a grid `FINE` times finer."""
    return chords(tree, divided(path, FINE))[0]


@jit
def evaluate(tree, path, substeps, scratch, P, screws):
    """Place all samples of the path; half its energy."""
    samples = divided(path, substeps)
    half = 0.0
    for i in range(samples.shape[0]):
        place(tree, samples[i], scratch, P[i], screws[i])
        if i > 0:
            for k in range(3, P.shape[1]):
                half += 0.5 * (P[i, k] - P[i - 1, k]) ** 2
    return half


@jit
def sum_moments(tree, before, P, after, moments):
    """Sums of p wᵀ and of w over the joints p that hang on each frame, (n_frames, 12); w is the force 2p − p₋ − p₊."""
    moments[:] = 0.0
    for j in range(1, tree.offset.shape[0]):
        total = moments[tree.joint_frame[j]]
        for k in range(3):
            w = 2.0 * P[3 * j + k] - before[3 * j + k] - after[3 * j + k]
            for i in range(3):
                total[3 * i + k] += P[3 * j + i] * w
            total[9 + k] += w
    for f in range(tree.frame_parent.shape[0] - 1, 0, -1):
        for i in range(moments.shape[1]):
            moments[tree.frame_parent[f], i] += moments[f, i]


@jit
def add_gradient(tree, screws, moments, t, gradient):
    """Add what a sample's forces do to the two free poses about it: the moment along each axis."""
    for f in range(1, tree.frame_parent.shape[0]):
        _, xy, xz, yx, _, yz, zx, zy, _, u, v, w = moments[f]
        for d in range(tree.first_dof[f], tree.end_dof[f]):
            slope = (yz - zy) * screws[0, d] + (zx - xz) * screws[1, d] + (xy - yx) * screws[2, d]
            slope += u * screws[3, d] + v * screws[4, d] + w * screws[5, d]
            gradient[0, d] += (1.0 - t) * slope
            gradient[1, d] += t * slope


@jit
def _add_bends(tree, P, screws, moments, t, diagonal, beside):
    """Add what Gauss-Newton leaves out: forces times second derivatives of the joint positions.

    For axes a and c, c at or before a from the root on, ∂²p = c × (a × (p − o)), so that Σ w·∂²p = c·(M − tr M)a with
    M = Σ (p − o) wᵀ over the joints that hang on a.
    """
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
                    bend = x * screws[0, e] + y * screws[1, e] + z * screws[2, e]
                    diagonal[0, d, e] += (1.0 - t) * (1.0 - t) * bend
                    diagonal[1, d, e] += t * t * bend
                    beside[d, e] += t * (1.0 - t) * bend
                    if e < d:
                        beside[e, d] += t * (1.0 - t) * bend


@jit
def _add_products(tree, P, screws, Q, other, same, weights, sums, diagonal, beside):
    """Add multiples of JᵀK, J and K the Jacobians of two samples, to the blocks of the two free poses about them.

    As in the composite-rigid-body algorithm: Σ (a × p + b)·(c × q + e) over the joints p, q that hang on the deeper of
    two dofs with screws (a, b) and (c, e) is linear in the other's screw, with coefficients made of the sums of p qᵀ, p
    and q. With weights (s, t, u, v) the lower triangles of the diagonal blocks get s and t times JᵀK + KᵀJ, the block
    beside them u JᵀK + v KᵀJ. Where the two samples are the `same`, half the work will do.
    """
    sums[:] = 0.0
    for j in range(1, tree.offset.shape[0]):
        total = sums[tree.joint_frame[j]]
        for i in range(3):
            for k in range(3):
                total[3 * i + k] += P[3 * j + i] * Q[3 * j + k]
            total[9 + i] += P[3 * j + i]
            total[12 + i] += Q[3 * j + i]
        total[15] += 1.0
    for f in range(tree.frame_parent.shape[0] - 1, 0, -1):
        for i in range(sums.shape[1]):
            sums[tree.frame_parent[f], i] += sums[f, i]
    before, after, across, back = weights
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
            if same:
                for s in range(tree.first_run[f], tree.first_run[f + 1]):
                    for e in range(tree.runs[s, 0], min(tree.runs[s, 1], d + 1)):
                        jj = j0 * screws[0, e] + j1 * screws[1, e] + j2 * screws[2, e]
                        jj += j3 * screws[3, e] + j4 * screws[4, e] + j5 * screws[5, e]
                        diagonal[0, d, e] += 2.0 * before * jj
                        diagonal[1, d, e] += 2.0 * after * jj
                        beside[d, e] += (across + back) * jj
                        if e < d:
                            beside[e, d] += (across + back) * jj
                continue
            a, b, c, u, v, w = other[:, d]
            k0 = (trace - xx) * a - yx * b - zx * c + py * w - pz * v
            k1 = (trace - yy) * b - xy * a - zy * c + pz * u - px * w
            k2 = (trace - zz) * c - xz * a - yz * b + px * v - py * u
            k3 = b * qz - c * qy + n * u
            k4 = c * qx - a * qz + n * v
            k5 = a * qy - b * qx + n * w
            for s in range(tree.first_run[f], tree.first_run[f + 1]):
                for e in range(tree.runs[s, 0], min(tree.runs[s, 1], d + 1)):
                    jk = j0 * other[0, e] + j1 * other[1, e] + j2 * other[2, e]
                    jk += j3 * other[3, e] + j4 * other[4, e] + j5 * other[5, e]
                    kj = k0 * screws[0, e] + k1 * screws[1, e] + k2 * screws[2, e]
                    kj += k3 * screws[3, e] + k4 * screws[4, e] + k5 * screws[5, e]
                    diagonal[0, d, e] += before * (jk + kj)
                    diagonal[1, d, e] += after * (jk + kj)
                    beside[d, e] += across * jk + back * kj
                    if e < d:
                        beside[e, d] += across * kj + back * jk


@jit
def normal_equations(tree, substeps, P, screws, diagonal, beside, gradient):
    """Blocks of the normal equations, and the gradient of half the energy.

    Sample k lies at the fraction t of the way between two free poses, so that it moves with 1 - t of the one and t of
    the other. Of the diagonal blocks only the lower triangle is filled. The ends have blocks too, which nobody reads.
    """
    diagonal[:], beside[:], gradient[:] = 0.0, 0.0, 0.0
    n_frames, n_samples = tree.frame_parent.shape[0], P.shape[0]
    sums, moments = np.empty((n_frames, 16)), np.empty((n_frames, 12))
    for k in range(n_samples - 1):
        node = k // substeps
        t = (k - node * substeps) / substeps
        blocks = diagonal[node : node + 2]
        if k > 0:
            sum_moments(tree, P[k - 1], P[k], P[k + 1], moments)
            add_gradient(tree, screws[k], moments, t, gradient[node : node + 2])
            weights = ((1.0 - t) * (1.0 - t), t * t, t * (1.0 - t), t * (1.0 - t))
            _add_products(tree, P[k], screws[k], P[k], screws[k], True, weights, sums, blocks, beside[node])
        if substeps > 1 or 0 < k < n_samples - 2:
            u = t + 1.0 / substeps
            weights = ((t - 1.0) * (1.0 - u), -t * u, (t - 1.0) * u, t * (u - 1.0))
            _add_products(tree, P[k], screws[k], P[k + 1], screws[k + 1], False, weights, sums, blocks, beside[node])


@jit
def add_curvature(tree, substeps, P, screws, diagonal, beside):
    """Make the normal equations the exact Hessian."""
    moments = np.empty((tree.frame_parent.shape[0], 12))
    for k in range(1, P.shape[0] - 1):
        node = k // substeps
        t = (k - node * substeps) / substeps
        sum_moments(tree, P[k - 1], P[k], P[k + 1], moments)
        _add_bends(tree, P[k], screws[k], moments, t, diagonal[node : node + 2], beside[node])
