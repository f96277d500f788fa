"""The path of least energy between two poses, compiled: the paper's eq. 6, and what keeps its minimiser honest.

The problem
-----------
A path is n + 1 poses; its energy Σ ‖F(θ_i) − F(θ_{i−1})‖² is a sum of squares, with the ends fixed. Its gradient is
2 (2F(θ_i) − F(θ_{i−1}) − F(θ_{i+1}))ᵀ J_i. (Eq. 12 of the paper loses the sign of the first inner derivative, so that
F(θ_i) drops out of its eq. 7 and 13.)

The step
--------
Gauss-Newton: the normal equations of the residuals F(θ_i) − F(θ_{i−1}) are block tridiagonal in the poses, and each
block falls apart into the branches of the skeleton at the root, which move no joint in common. They are damped by a
multiple λ of the identity, since JᵀJ is singular (a twist of the last bone moves nothing), and λ follows the ratio of
actual to predicted decrease, as the radius of a trust region would. What Gauss-Newton leaves out makes its steps too
short, always by much the same factor near the end; so steps are combined as in conjugate gradients, with the damped
normal equations as the preconditioner, and their length is that of the parabola through energy, slope and trial.

Honesty
-------
Few poses can sit where their chords are short while the motion between them is long. So every path is measured again
on a fine grid. Where the two lengths disagree, the energy is taken over `SUBSTEPS` chords between each two free poses,
with those in between on the straight line: what happens there now counts. That is the same problem with residuals
that depend on two poses each, which is how it is written below; the plain one has one chord between free poses.
"""

import functools
import math

import numpy as np

from skpose._kernels import (
    TWO_PI,
    _jit,
    _place_joints,
    _turn_frames,
    _turns,
    _workspace,
    measure_line,
    turn_axes,
    workspace_rows,
)
from skpose._lanes import load, store, zero

FINE = 8  # chords into which each chord of a path is divided to measure it again
GAP = 5e-3  # how far, relatively, the two lengths of an honest path may differ
SUBSTEPS = 4
REFINEMENTS = ((1, 1), (1, SUBSTEPS), (2, SUBSTEPS), (4, SUBSTEPS))  # free steps over n_steps, chords in each
DAMPING = 1e-6, 1e-8  # λ at first and at least, over the mean diagonal of the normal equations
LEAST_RATIO = 1e-4  # of actual to predicted decrease, for a step to be taken
NEAR = 1e-3  # a relative decrease of the energy below which the exact Hessian is tried
ROUNDING = 1e-14  # a predicted decrease that float64 cannot show, relative to the energy
PATIENCE, LOST = 10, 4.0  # every so many iterations a path is given up whose gap is so many times too wide

FLAT = 1e-4  # curvature below which the energy counts as flat, over the mean diagonal of the normal equations
KICK, MAX_KICKS = 1e-2, 2  # how far a path is bent that has stopped on a saddle, rad, and how often
MAX_ITER, TOL = 500, 1e-7  # iterations in each refinement; norm of the gradient, m²/rad
AGREE = 1e-6  # chord and line that differ by no more, relatively, are the geodesic's length
LANES = 8  # float64 numbers in one register

# Sums of products may also be reordered, so that they can be vectorised.
_jit_sums = functools.partial(_jit, fastmath={"contract", "reassoc"})


# --- the path and its measures ---------------------------------------------------------------------------------------


@_jit
def _place(tree, angles, scratch, P, screws):
    """Joint positions of one pose, angles in the tree's order, and the screw of every dof, (6, n_dofs).

    The screw is the axis a and the velocity b = o × a of what passes the root, o on the axis: the dof moves a point p
    that hangs on it at the rate a × p + b.
    """
    C, S, _, _, H, positions = _workspace(tree, scratch)
    for d in range(angles.shape[0]):
        C[d], S[d] = math.cos(angles[d]), math.sin(angles[d])
    _turn_frames(tree, C, S, H)
    _place_joints(tree, H, positions)
    for i in range(P.shape[0]):
        P[i] = positions[i]
    turn_axes(tree, C, S, H, screws[:3].T)
    for f in range(1, tree.rest.shape[0]):
        o = 3 * tree.pivot[f]
        for d in range(tree.first_dof[f], tree.first_dof[f + 1]):
            x, y, z = screws[0, d], screws[1, d], screws[2, d]
            screws[3, d] = P[o + 1] * z - P[o + 2] * y
            screws[4, d] = P[o + 2] * x - P[o] * z
            screws[5, d] = P[o] * y - P[o + 1] * x


@_jit
def divided(path, parts):
    """The path with every step divided into equal parts."""
    n_steps, n_dofs = path.shape[0] - 1, path.shape[1]
    out = np.empty((n_steps * parts + 1, n_dofs))
    for i in range(out.shape[0]):
        step = min(i // parts, n_steps - 1)
        t = (i - step * parts) / parts
        for d in range(n_dofs):
            out[i, d] = (1.0 - t) * path[step, d] + t * path[step + 1, d]
    return out


@_jit
def chords(tree, path):
    """Sum of the path's chords, and of their squares."""
    scratch = np.empty(workspace_rows(tree))
    C, S, _, _, H, P = _workspace(tree, scratch)
    P[:] = 0.0
    length, energy = 0.0, 0.0
    for i in range(path.shape[0]):
        for d in range(path.shape[1]):
            C[d], S[d] = math.cos(path[i, d]), math.sin(path[i, d])
        _turn_frames(tree, C, S, H)
        square = _place_joints(tree, H, P)
        if i > 0:
            length += math.sqrt(square)
            energy += square
    return length, energy


@_jit
def curve_length(tree, path):
    """Length of the path measured on a grid `FINE` times finer."""
    return chords(tree, divided(path, FINE))[0]


@_jit
def _gap(tree, path):
    """How much longer the path is on the fine grid than by its chords, relatively."""
    along = curve_length(tree, path)
    return (along - chords(tree, path)[0]) / along if along > 0.0 else 0.0


@_jit
def _evaluate(tree, path, substeps, scratch, P, screws):
    """Place all samples of the path; half its energy."""
    samples = divided(path, substeps)
    half = 0.0
    for i in range(samples.shape[0]):
        _place(tree, samples[i], scratch, P[i], screws[i])
        if i > 0:
            for k in range(3, P.shape[1]):
                half += 0.5 * (P[i, k] - P[i - 1, k]) ** 2
    return half


# --- the normal equations --------------------------------------------------------------------------------------------


@_jit
def _sum_moments(tree, P, force, moments):
    """Sums of p wᵀ and of w over the joints p that hang on each frame and the forces w on them, (n_frames, 12)."""
    moments[:] = 0.0
    for j in range(1, tree.offset.shape[0]):
        total = moments[tree.joint_frame[j]]
        for k in range(3):
            w = force[3 * j + k]
            for i in range(3):
                total[3 * i + k] += P[3 * j + i] * w
            total[9 + k] += w
    for f in range(tree.rest.shape[0] - 1, 0, -1):
        for i in range(moments.shape[1]):
            moments[tree.frame_parent[f], i] += moments[f, i]


@_jit
def _add_gradient(tree, screws, moments, t, gradient):
    """Add what a sample's forces do to the two free poses about it: the moment along each axis."""
    for f in range(1, tree.rest.shape[0]):
        _, xy, xz, yx, _, yz, zx, zy, _, u, v, w = moments[f]
        for d in range(tree.first_dof[f], tree.first_dof[f + 1]):
            slope = (yz - zy) * screws[0, d] + (zx - xz) * screws[1, d] + (xy - yx) * screws[2, d]
            slope += u * screws[3, d] + v * screws[4, d] + w * screws[5, d]
            gradient[0, d] += (1.0 - t) * slope
            gradient[1, d] += t * slope


@_jit
def _add_curvature(tree, P, screws, moments, t, diagonal, beside):
    """Add what Gauss-Newton leaves out: forces times second derivatives of the joint positions.

    For axes a and c, c at or before a from the root on, ∂²p = c × (a × (p − o)), so that Σ w·∂²p = c·(M − tr M)a with
    M = Σ (p − o) wᵀ over the joints that hang on a.
    """
    for f in range(1, tree.rest.shape[0]):
        xx, xy, xz, yx, yy, yz, zx, zy, zz, u, v, w = moments[f]
        o = 3 * tree.pivot[f]
        ox, oy, oz = P[o], P[o + 1], P[o + 2]
        trace = xx + yy + zz - ox * u - oy * v - oz * w
        for d in range(tree.first_dof[f], tree.first_dof[f + 1]):
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


@_jit
def _add_products(tree, P, screws, Q, other, weights, sums, diagonal, beside):
    """Add multiples of JᵀK, J and K the Jacobians of two samples, to the blocks of the two free poses about them.

    As in the composite-rigid-body algorithm: Σ (a × p + b)·(c × q + e) over the joints p, q that hang on the deeper of
    two dofs with screws (a, b) and (c, e) is linear in the other's screw, with coefficients made of the sums of p qᵀ, p
    and q. With weights (s, t, u, v) the lower triangles of the diagonal blocks get s and t times JᵀK + KᵀJ, the block
    beside them u JᵀK + v KᵀJ.
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
    for f in range(tree.rest.shape[0] - 1, 0, -1):
        for i in range(sums.shape[1]):
            sums[tree.frame_parent[f], i] += sums[f, i]
    before, after, across, back = weights
    for f in range(1, tree.rest.shape[0]):
        xx, xy, xz, yx, yy, yz, zx, zy, zz, px, py, pz, qx, qy, qz, n = sums[f]
        trace = xx + yy + zz
        for d in range(tree.first_dof[f], tree.first_dof[f + 1]):
            a, b, c, u, v, w = screws[:, d]
            j0 = (trace - xx) * a - xy * b - xz * c + qy * w - qz * v
            j1 = (trace - yy) * b - yx * a - yz * c + qz * u - qx * w
            j2 = (trace - zz) * c - zx * a - zy * b + qx * v - qy * u
            j3 = b * pz - c * py + n * u
            j4 = c * px - a * pz + n * v
            j5 = a * py - b * px + n * w
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


@_jit
def _normal_equations(tree, substeps, P, screws, curvature, diagonal, beside, gradient):
    """Blocks of the normal equations, or of the exact Hessian, and the gradient of half the energy.

    Sample k lies at the fraction t of the way between two free poses, so that it moves with 1 - t of the one and t of
    the other. Of the diagonal blocks only the lower triangle is filled. The ends have blocks too, which nobody reads.
    """
    diagonal[:], beside[:], gradient[:] = 0.0, 0.0, 0.0
    n_frames, n_samples = tree.rest.shape[0], P.shape[0]
    sums, moments, force = np.empty((n_frames, 16)), np.empty((n_frames, 12)), np.empty(P.shape[1])
    for k in range(n_samples - 1):
        node = k // substeps
        t = (k - node * substeps) / substeps
        blocks = diagonal[node : node + 2]
        if k > 0:
            for i in range(force.shape[0]):
                force[i] = 2.0 * P[k, i] - P[k - 1, i] - P[k + 1, i]
            _sum_moments(tree, P[k], force, moments)
            _add_gradient(tree, screws[k], moments, t, gradient[node : node + 2])
            if curvature != 0.0:
                _add_curvature(tree, P[k], screws[k], moments, t, blocks, beside[node])
            weights = ((1.0 - t) * (1.0 - t), t * t, t * (1.0 - t), t * (1.0 - t))
            _add_products(tree, P[k], screws[k], P[k], screws[k], weights, sums, blocks, beside[node])
        if substeps > 1 or 0 < k < n_samples - 2:
            u = t + 1.0 / substeps
            weights = ((t - 1.0) * (1.0 - u), -t * u, (t - 1.0) * u, t * (u - 1.0))
            _add_products(tree, P[k], screws[k], P[k + 1], screws[k + 1], weights, sums, blocks, beside[node])


# --- their solution --------------------------------------------------------------------------------------------------


@_jit
def _band_shape(tree, n_nodes):
    """Rows and columns of the band that holds one branch: block rows [U X], padded to whole lanes."""
    widest = 0
    for b in range(tree.branch.shape[0] - 1):
        widest = max(widest, tree.branch[b + 1] - tree.branch[b])
    padded = -(-widest // LANES) * LANES
    return n_nodes * padded * 2 * (padded // LANES), LANES


@_jit
def _fill_band(diagonal, beside, damping, held, lo, hi, band):
    """The free poses' blocks, dofs lo:hi, as block rows [D B] of the band; what is padded or held is left alone.

    Row p of block i is band[((i · m + p) · 2 · n + c, l] for column c · LANES + l, m = n · LANES padded dofs.
    """
    n = -(-(hi - lo) // LANES)
    m = n * LANES
    last = diagonal.shape[0] - 2
    for i in range(1, last + 1):
        rows = band[(i - 1) * m * 2 * n : i * m * 2 * n].reshape(m, 2 * m)
        rows[:] = 0.0
        for p in range(hi - lo):
            rows[p, p] = diagonal[i, lo + p, lo + p] + damping
            for q in range(p):
                rows[q, p] = diagonal[i, lo + p, lo + q]
            if i < last:
                for q in range(hi - lo):
                    rows[p, m + q] = beside[i, lo + p, lo + q]
        for p in range(m):
            if p >= hi - lo or held[i, lo + p]:
                for q in range(m):
                    rows[p, q] = rows[q, p] = rows[p, m + q] = 0.0
                rows[p, p] = 1.0
            if i < last and p < hi - lo and held[i + 1, lo + p]:
                for q in range(m):
                    rows[q, m + p] = 0.0


@_jit
def _subtract(band, n, row, first, last, source, n_rows, shift, column):
    """Four rows of the band from chunk first on −= Σ W_k [row k of the source], W_k its column and the next three."""
    for c in range(first, last):
        a, b = load(band, row * n + c), load(band, (row + 1) * n + c)
        d, e = load(band, (row + 2) * n + c), load(band, (row + 3) * n + c)
        for k in range(source, source + n_rows):
            r = load(band, k * n + c + shift)
            w = band[k * n + column // LANES]
            i = column % LANES
            a, b, d, e = a - w[i] * r, b - w[i + 1] * r, d - w[i + 2] * r, e - w[i + 3] * r
        store(band, row * n + c, a)
        store(band, (row + 1) * n + c, b)
        store(band, (row + 2) * n + c, d)
        store(band, (row + 3) * n + c, e)


@_jit
def _factorise(band, n_blocks, n):
    """Cholesky factor UᵀU in place, X beside U; whether there is one. n: lanes in a block's width."""
    m, width = n * LANES, 2 * n
    for i in range(n_blocks):
        top = i * m
        for p in range(0, m, 4):
            row, first = top + p, p // LANES
            if i > 0:
                _subtract(band, width, row, first, n, top - m, m, n, m + p)
            _subtract(band, width, row, first, width, top, p, 0, p)
            for q in range(p, p + 4):
                for k in range(p, q):
                    w = band[(top + k) * width + q // LANES, q % LANES]
                    for c in range(first, width):
                        at = (top + q) * width + c
                        store(band, at, load(band, at) - w * load(band, (top + k) * width + c))
                pivot = band[(top + q) * width + q // LANES, q % LANES]
                if not pivot > 0.0:
                    return False
                for j in range(q % LANES):
                    band[(top + q) * width + q // LANES, j] = 0.0
                scale = 1.0 / math.sqrt(pivot)
                for c in range(first, width):
                    store(band, (top + q) * width + c, scale * load(band, (top + q) * width + c))
    return True


@_jit
def _substitute(band, n_blocks, n, x):
    """Solve UᵀU x = b in place, x of shape (n_blocks · n, LANES)."""
    m, width = n * LANES, 2 * n
    flat = x.reshape(n_blocks * m)
    for i in range(n_blocks):
        for p in range(m):
            row = (i * m + p) * width
            flat[i * m + p] /= band[row + p // LANES, p % LANES]
            value = flat[i * m + p]
            for c in range(p // LANES, n if i == n_blocks - 1 else width):
                # What lies left of the diagonal is noughts, and the pivot's own place is put right again.
                store(x, i * n + c, load(x, i * n + c) - value * load(band, row + c))
            flat[i * m + p] = value
    partial = np.empty((1, LANES))
    for i in range(n_blocks - 1, -1, -1):
        for p in range(m - 1, -1, -1):
            row = (i * m + p) * width
            total = zero(x)
            pivot = band[row + p // LANES, p % LANES]
            value = flat[i * m + p]
            flat[i * m + p] = 0.0
            for c in range(p // LANES, n if i == n_blocks - 1 else width):
                total = total + load(x, i * n + c) * load(band, row + c)
            store(partial, 0, total)
            for j in range(LANES):
                value -= partial[0, j]
            flat[i * m + p] = value / pivot


@_jit
def _solve(tree, diagonal, beside, gradient, damping, held, band, step):
    """step = −(H + λ)⁻¹ gradient for the dofs that are not held, branch by branch; whether it could be done."""
    n_blocks = diagonal.shape[0] - 2
    for b in range(tree.branch.shape[0] - 1):
        lo, hi = tree.branch[b], tree.branch[b + 1]
        n = -(-(hi - lo) // LANES)
        _fill_band(diagonal, beside, damping, held, lo, hi, band)
        if not _factorise(band, n_blocks, n):
            return False
        x = np.zeros((n_blocks * n, LANES))
        flat = x.reshape(n_blocks, n * LANES)
        for i in range(n_blocks):
            for d in range(lo, hi):
                flat[i, d - lo] = -gradient[i + 1, d]
        _substitute(band, n_blocks, n, x)
        for i in range(n_blocks):
            for d in range(lo, hi):
                step[i + 1, d] = flat[i, d - lo]
    return True


# --- the iteration ---------------------------------------------------------------------------------------------------


@_jit_sums
def _dot(a, b):
    total = 0.0
    for i in range(a.shape[0]):
        for d in range(a.shape[1]):
            total += a[i, d] * b[i, d]
    return total


@_jit
def _combine(step, turn, direction):
    """direction = step + turn · direction."""
    for i in range(step.shape[0]):
        for d in range(step.shape[1]):
            direction[i, d] = step[i, d] + turn * direction[i, d]


@_jit
def _hold(path, lower, upper, gradient, held):
    """Hold the dofs of the free poses that are at a bound which the gradient pushes against; whether these are others.

    What is held, and the ends, have no gradient.
    """
    changed = False
    gradient[0], gradient[-1] = 0.0, 0.0
    for i in range(1, path.shape[0] - 1):
        for d in range(path.shape[1]):
            angle, slope = path[i, d], gradient[i, d]
            hold = (angle <= lower[d] and slope > 0.0) or (angle >= upper[d] and slope < 0.0)
            changed = changed or hold != held[i, d]
            held[i, d] = hold
            if hold:
                gradient[i, d] = 0.0
    return changed


@_jit
def _move(path, direction, size, lower, upper, trial):
    """trial = path + size · direction, the free poses kept within their bounds."""
    for i in range(1, path.shape[0] - 1):
        for d in range(path.shape[1]):
            trial[i, d] = min(max(path[i, d] + size * direction[i, d], lower[d]), upper[d])


@_jit
def _kick(path, lower, upper):
    """Bend the free poses a little, in no direction that a symmetry would have."""
    last = path.shape[0] - 1
    for i in range(1, last):
        for d in range(path.shape[1]):
            bend = KICK * math.sin(math.pi * i / last) * math.cos(1.0 + d * d)
            path[i, d] = min(max(path[i, d] + bend, lower[d]), upper[d])


@_jit
def minimise(tree, path, substeps, lower, upper, max_iter, tol):
    """Lower the energy of the path in place, its ends fixed, the poses between within bounds.

    The energy is that over `substeps` chords a step. Returns the norm of its gradient (of what the bounds leave of it),
    the number of iterations, and whether it converged.
    """
    n_nodes, n_dofs = path.shape
    n_samples = (n_nodes - 1) * substeps + 1
    scratch = np.empty(workspace_rows(tree))
    # The samples of the path, of a trial, and of a second one.
    P, screws = np.empty((3, n_samples, 3 * tree.offset.shape[0])), np.empty((3, n_samples, 6, n_dofs))
    now, other, spare = 0, 1, 2
    half = _evaluate(tree, path, substeps, scratch, P[now], screws[now])
    if n_nodes < 3:
        return 0.0, 0, True
    diagonal, beside = np.empty((n_nodes, n_dofs, n_dofs)), np.empty((n_nodes - 1, n_dofs, n_dofs))
    band = np.empty(_band_shape(tree, n_nodes))
    gradient, held = np.empty(path.shape), np.zeros(path.shape, np.bool_)
    step, last_step, direction = np.zeros(path.shape), np.zeros(path.shape), np.zeros(path.shape)
    trial, second = path.copy(), path.copy()
    scale, damping = 0.0, 0.0
    last_slope = 0.0  # along the step before; nought where the conjugate directions begin anew
    curvature, n_kicks = 0.0, 0  # 1 where the Hessian is exact
    norm = math.inf
    for iteration in range(max_iter):
        _normal_equations(tree, substeps, P[now], screws[now], curvature, diagonal, beside, gradient)
        if _hold(path, lower, upper, gradient, held):
            last_slope = 0.0
        norm = 2.0 * math.sqrt(_dot(gradient, gradient))
        if iteration == 0:
            for i in range(1, n_nodes - 1):
                scale += np.trace(diagonal[i]) / ((n_nodes - 2) * n_dofs)
            damping = DAMPING[0] * scale
        if norm <= tol:
            _normal_equations(tree, substeps, P[now], screws[now], 1.0, diagonal, beside, step)
            if n_kicks == MAX_KICKS or _solve(tree, diagonal, beside, step, FLAT * scale, held, band, direction):
                return norm, iteration, True
            # A saddle, such as the swing of an arm stretched in a plane: leave it, as it is no shortest way.
            n_kicks += 1
            _kick(path, lower, upper)
            half = _evaluate(tree, path, substeps, scratch, P[now], screws[now])
            last_slope, damping = 0.0, DAMPING[0] * scale
            continue
        if not _solve(tree, diagonal, beside, gradient, damping, held, band, step):
            if curvature > 0.0:
                curvature = 0.0
            else:
                damping *= 4.0
            continue
        slope = -_dot(gradient, step)
        predicted = 0.5 * (damping * _dot(step, step) + slope)
        if predicted <= ROUNDING * half:
            return norm, iteration, True
        turn = 0.0
        if last_slope > 0.0:
            turn = min(max((slope + _dot(gradient, last_step)) / last_slope, 0.0), 2.0)
        _combine(step, turn, direction)
        if _dot(gradient, direction) >= 0.0:
            _combine(step, 0.0, direction)
        _move(path, direction, 1.0, lower, upper, trial)
        lowest = _evaluate(tree, trial, substeps, scratch, P[other], screws[other])
        # The parabola through energy, slope and trial is least at this multiple of the direction.
        fall = -_dot(gradient, direction)
        bend = 2.0 * (lowest - half + fall)
        multiple = fall / bend if bend > 0.0 else 1.0
        if abs(multiple - 1.0) > 0.1 and multiple < 4.0:
            _move(path, direction, multiple, lower, upper, second)
            again = _evaluate(tree, second, substeps, scratch, P[spare], screws[spare])
            if again < lowest:
                lowest = again
                trial, second = second, trial
                other, spare = spare, other
        ratio = (half - lowest) / predicted
        if ratio > LEAST_RATIO:
            curvature = 1.0 if substeps > 1 and half - lowest < NEAR * half else 0.0
            _move(trial, step, 0.0, lower, upper, path)
            now, other = other, now
            half = lowest
            step, last_step = last_step, step
            last_slope = slope if ratio > 0.25 and curvature == 0.0 else 0.0
        else:
            last_slope = 0.0
        if ratio > 0.75:
            damping = max(0.1 * damping, DAMPING[1] * scale)
        elif ratio < 0.25:
            damping *= 4.0
        if substeps == 1 and iteration % PATIENCE == PATIENCE - 1 and _gap(tree, path) > LOST * GAP:
            return norm, iteration + 1, False
    return norm, max_iter, False


# --- from pose to pose -----------------------------------------------------------------------------------------------


@_jit
def find_geodesic(start, end, lower, upper, tree, n_steps, max_iter, tol):
    """A path of least energy from start to end, angles in the tree's order, that is as long as it says.

    Returns the path with all its samples, its energy, length and length on the fine grid, the norm of the energy's
    gradient in the free poses, the number of iterations and whether it converged. Where nothing honest was found that
    is no longer than the straight line, the path is that line, unconverged.
    """
    line = np.empty((2, start.shape[0]))
    line[0], line[1] = start, end
    path = divided(line, n_steps)
    n_iter = 0
    for factor, substeps in REFINEMENTS:
        if substeps > 1:
            path = divided(line, n_steps) if factor == 1 else divided(path, 2)
        norm, iterations, converged = minimise(tree, path, substeps, lower, upper, max_iter, tol)
        n_iter += iterations
        samples = divided(path, substeps)
        length, energy = chords(tree, samples)
        along = curve_length(tree, samples)
        straight = curve_length(tree, divided(line, samples.shape[0] - 1))
        if along - length <= GAP * along and along <= straight * (1.0 + ROUNDING):
            return samples, energy, length, along, norm, n_iter, converged
    path = divided(line, n_steps)
    length, energy = chords(tree, path)
    return path, energy, length, curve_length(tree, path), math.nan, n_iter, False


@_jit
def measure_geodesic(x, Y, tree, steps, scratch, out):
    """Length of the geodesic, eq. 3; where chord and straight line agree already, that of the line.

    Leaves lanes alone whose out[1] is not nought, and puts there the gap of those that did not converge.
    """
    measure_line(x, Y, tree, steps, scratch, out)
    n = tree.column.shape[0]
    codes, results = (
        Y.reshape((Y.shape[0], Y.size // Y.shape[0])),
        out.reshape((out.shape[0], out.size // out.shape[0])),
    )
    free = np.full(n, math.inf)
    for w in range(codes.shape[1]):
        line = results[0, w]
        square = 0.0
        for i in range(5 * n, x.shape[0]):
            square += (codes[i, w] - x[i]) ** 2
        chord = math.sqrt(square)
        if results[1, w] != 0.0 or line - chord <= AGREE * line:
            continue
        start, end = np.empty(n), np.empty(n)
        ahead = 0  # 1 or -1 as the first angle that differs does; both directions are to give the same number
        for d in range(n):
            gap = codes[d, w] - x[d]
            if ahead == 0 and gap != 0.0:
                ahead = 1 if gap > 0.0 else -1
            gap -= _turns(gap, steps) * TWO_PI
            start[d] = x[d] if ahead >= 0 else codes[d, w]
            end[d] = start[d] + gap * ahead
        _, _, length, along, _, _, converged = find_geodesic(
            start, end, -free, free, tree, steps.n_steps, MAX_ITER, TOL
        )
        results[0, w] = max(chord, min(length, line))
        if not converged:
            results[1, w] = max((along - length) / along, ROUNDING)
