"""Gradient, Gauss-Newton matrix and Hessian of a path's energy, block by block.

The gradient of eq. 6 is 2 (2F(θ_i) − F(θ_{i−1}) − F(θ_{i+1}))ᵀ J_i. (Eq. 12 of the paper loses the sign of the first
inner derivative, so that F(θ_i) drops out of its eq. 7 and 13.)

The matrix is block tridiagonal: a pose shares chords with the pose before it and the pose after it. Each step between
two poses adds to four blocks: sample s lies at the fraction t from one pose to the next, so that it moves with 1 − t of
the one and t of the other. Steps are in lanes, see `energy`, and nothing passes from one to another. No Jacobian
is ever formed: its products are sums over the joints that a dof moves, gathered from the leaves of the skeleton to the
root. Two dofs are coupled only where one moves what the other moves; such pairs alone have numbers.
"""

from typing import NamedTuple

import numpy as np
from numba import types

from skpose._compiled.path.energy import LANES, PATH, SAMPLES, STEPS, place_samples
from skpose._compiled.pose.rotation import second_derivatives
from skpose._compiled.pose.signatures import TREE
from skpose._compiled.simd.jit import by_address, inlined, internal
from skpose._compiled.simd.lanes import empty_aligned, full_like, rows
from skpose._compiled.simd.signatures import FLAG, INTEGER_VECTOR, MATRIX, tuple_type


class NormalEquations(NamedTuple):
    """The system of a damped step, of all poses; the blocks of the two ends are filled but not read.

    Pairs are a dof d and each of the dofs e ≤ d of its frame and of that frame's ancestors, in the order of the dofs.
    Lanes hold steps: lane w of group g is the step from pose g · STEPS + w on.
    """

    first_pair: np.ndarray  # (n_dofs + 1,) the pairs of dof d are first_pair[d]:first_pair[d + 1], its own the last
    # (n_groups · n_pairs · 4, LANES): of d and e of the first pose, of d and e of the second pose, of d of the first
    # and e of the second, and of e of the first and d of the second
    pairs: np.ndarray
    gradient: np.ndarray  # (n_nodes, n_dofs) of half the energy, m²/rad
    sums: np.ndarray  # ((2 substeps + 1) · n_frames · 16, LANES) see `_sum_products`
    moments: np.ndarray  # ((substeps + 1) · n_frames · 12, LANES) see `_sum_moments`
    forces: np.ndarray  # ((substeps + 1) · 12, LANES) see `_set_pairs`


EQUATIONS = tuple_type(NormalEquations, INTEGER_VECTOR, MATRIX, MATRIX, MATRIX, MATRIX, MATRIX)


@internal
def _n_groups(path):
    return -(-(path.poses.shape[0] - 1) // STEPS)


@by_address(lambda: EQUATIONS(TREE, PATH))
def equations_for(tree, path):
    """Normal equations for a path, not yet filled."""
    n_nodes, n = path.poses.shape
    n_groups, n_frames = _n_groups(path), tree.frame_parent.shape[0]
    first_pair = np.zeros(n + 1, np.int64)
    for f in range(1, n_frames):
        for d in range(tree.first_dof[f], tree.end_dof[f]):
            for r in range(tree.first_dof_range[f], tree.first_dof_range[f + 1]):
                first_pair[d + 1] += min(tree.dof_ranges[r, 1], d + 1) - tree.dof_ranges[r, 0]
    for d in range(n):
        first_pair[d + 1] += first_pair[d]
    return NormalEquations(
        first_pair,
        empty_aligned(n_groups * first_pair[n] * 4, LANES, np.float64),
        np.empty((n_nodes, n)),
        empty_aligned((2 * path.substeps + 1) * n_frames * 16, LANES, np.float64),
        empty_aligned((path.substeps + 1) * n_frames * 12, LANES, np.float64),
        empty_aligned((path.substeps + 1) * 12, LANES, np.float64),
    )


@internal
def first_row(equations, group, pair):
    """The first of the four rows of a pair, of a group of steps."""
    return 4 * (group * equations.first_pair[-1] + pair)


@internal
def mean_diagonal(equations):
    """The mean of the diagonal over the free poses: the scale of the damping."""
    total, n_free, n = 0.0, equations.gradient.shape[0] - 2, equations.gradient.shape[1]
    for d in range(n):
        own = equations.first_pair[d + 1] - 1
        for i in range(n_free):  # the step from pose i on ends at pose i + 1, where another begins
            total += equations.pairs[first_row(equations, i // STEPS, own) + 1, i % STEPS]
            total += equations.pairs[first_row(equations, (i + 1) // STEPS, own), (i + 1) % STEPS]
    return total / (n_free * n)


@internal
def _gather(tree, n_sums, sums):
    """Add the sums of every frame to its carrier's."""
    for f in range(tree.frame_parent.shape[0] - 1, 0, -1):
        p = tree.frame_parent[f]
        for i in range(n_sums):
            sums[p * n_sums + i] = sums[p * n_sums + i] + sums[f * n_sums + i]


@internal
def _sum_products(tree, P, Q, sums):
    """Sum p qᵀ, p, q and 1, weighted, over the joints that each frame moves, for two samples p, q: 16 rows a frame."""
    for i in range(16 * tree.frame_parent.shape[0]):
        sums[i] = 0.0
    for j in range(1, tree.offset.shape[0]):
        total, weight = 16 * tree.joint_frame[j], tree.scale[j] * tree.scale[j]
        for i in range(3):
            p, q = weight * P[3 * j + i], weight * Q[3 * j + i]
            for k in range(3):
                sums[total + 3 * i + k] = sums[total + 3 * i + k] + p * Q[3 * j + k]
            sums[total + 9 + i] = sums[total + 9 + i] + p
            sums[total + 12 + i] = sums[total + 12 + i] + q
        sums[total + 15] = sums[total + 15] + weight
    _gather(tree, 16, sums)


@internal
def _sum_moments(tree, s, substeps, P, moments):
    """Sum p wᵀ and w over the joints p that each frame moves, 12 rows a frame; w is the force on sample s.

    It is the sum over the chords to the sample and from it, as far as they belong to the step.
    """
    n_coordinates = 3 * tree.offset.shape[0]
    for i in range(12 * tree.frame_parent.shape[0]):
        moments[i] = 0.0
    for j in range(1, tree.offset.shape[0]):
        total, weight, at = 12 * tree.joint_frame[j], tree.scale[j] * tree.scale[j], s * n_coordinates + 3 * j
        for k in range(3):
            w = full_like(P, 0.0)
            if s > 0:
                w = w + (P[at + k] - P[at + k - n_coordinates])
            if s < substeps:
                w = w + (P[at + k] - P[at + k + n_coordinates])
            w = weight * w
            for i in range(3):
                moments[total + 3 * i + k] = moments[total + 3 * i + k] + P[at + i] * w
            moments[total + 9 + k] = moments[total + 9 + k] + w
    _gather(tree, 12, moments)


@internal
def _add_gradient(tree, first, substeps, screws, moments, slopes, gradient):
    """Add the forces on all samples to the gradient of the poses where the steps begin and end.

    That is their moment along each axis.
    """
    n, n_frames, slope = tree.column.shape[0], tree.frame_parent.shape[0], rows(slopes, 0)
    n_steps = min(STEPS, gradient.shape[0] - 1 - first)
    for f in range(1, n_frames):
        for d in range(tree.first_dof[f], tree.end_dof[f]):
            before, after = full_like(moments, 0.0), full_like(moments, 0.0)
            for s in range(substeps + 1):
                m, row, t = 12 * (s * n_frames + f), 6 * (n * s + d), s / substeps
                turn = (moments[m + 5] - moments[m + 7]) * screws[row]
                turn = turn + (moments[m + 6] - moments[m + 2]) * screws[row + 1]
                turn = turn + (moments[m + 1] - moments[m + 3]) * screws[row + 2]
                move = moments[m + 9] * screws[row + 3] + moments[m + 10] * screws[row + 4]
                along = turn + (move + moments[m + 11] * screws[row + 5])
                before, after = before + (1.0 - t) * along, after + t * along
            slope[0], slope[1] = before, after
            for w in range(n_steps):
                gradient[first + w, d] += slopes[0, w]
                gradient[first + w + 1, d] += slopes[1, w]


@inlined
def _screw_at(screws, row):
    """The six numbers of a screw from a row on."""
    return screws[row], screws[row + 1], screws[row + 2], screws[row + 3], screws[row + 4], screws[row + 5]


@inlined
def _coefficients(products, at, of, n, screw):
    """Σ q × v and Σ v over joints p that move by a screw, v = a × p + b: those of another screw, of joints q.

    Σ (a × p + b)·(c × q + e) is linear in (c, e), as in the composite-rigid-body algorithm. The sums are those of p qᵀ,
    of q (at) and of p (of).
    """
    a, b, c, u, v, w = screw
    xx, xy, xz, yx, yy, yz, zx, zy, zz = products
    trace = xx + yy + zz
    return (
        (trace - xx) * a - xy * b - xz * c + (at[1] * w - at[2] * v),
        (trace - yy) * b - yx * a - yz * c + (at[2] * u - at[0] * w),
        (trace - zz) * c - zx * a - zy * b + (at[0] * v - at[1] * u),
        b * of[2] - c * of[1] + n * u,
        c * of[0] - a * of[2] + n * v,
        a * of[1] - b * of[0] + n * w,
    )


@inlined
def _plus(total, share, coefficients):
    """Six numbers plus a share of six others."""
    a, b, c, u, v, w = total
    return (
        a + share * coefficients[0],
        b + share * coefficients[1],
        c + share * coefficients[2],
        u + share * coefficients[3],
        v + share * coefficients[4],
        w + share * coefficients[5],
    )


@internal
def _forces_of(f, d, n_frames, n, substeps, screws, sums, forces):
    """Compute by what forces on each sample the chords resist dof d, at the first pose and at the second.

    A force is the six coefficients of the screws of other dofs; six rows for the first pose, six for the second.
    """
    zero = full_like(forces, 0.0)
    none = zero, zero, zero, zero, zero, zero
    before = none  # by the motion of the sample before
    for s in range(substeps + 1):
        m, row, t, step = 16 * (2 * s * n_frames + f), 12 * s, s / substeps, 1.0 / substeps
        here = _screw_at(screws, 6 * (n * s + d))
        products, p, _, count = _sums_of(sums, m)
        own = _coefficients(products, p, p, count, here)
        n_chords = 2.0 if 0 < s < substeps else 1.0
        of_first = _plus(_plus(none, t - step - 1.0, before), n_chords * (1.0 - t), own)
        of_second = _plus(_plus(none, step - t, before), n_chords * t, own)
        if s < substeps:
            products, p, q, count = _sums_of(sums, m + 16 * n_frames)
            before = _coefficients(products, q, p, count, here)
            xx, xy, xz, yx, yy, yz, zx, zy, zz = products
            following = _screw_at(screws, 6 * (n * (s + 1) + d))
            after = _coefficients((xx, yx, zx, xy, yy, zy, xz, yz, zz), p, q, count, following)
            of_first, of_second = _plus(of_first, t + step - 1.0, after), _plus(of_second, -t - step, after)
        for i in range(6):
            forces[row + i], forces[row + 6 + i] = of_first[i], of_second[i]


@inlined
def _sums_of(sums, m):
    """What `_sum_products` has of a frame: the sums of p qᵀ, p, q and 1."""
    products = sums[m], sums[m + 1], sums[m + 2], sums[m + 3], sums[m + 4], sums[m + 5], sums[m + 6], sums[m + 7]
    p, q = (sums[m + 9], sums[m + 10], sums[m + 11]), (sums[m + 12], sums[m + 13], sums[m + 14])
    return (*products, sums[m + 8]), p, q, sums[m + 15]


@inlined
def _along(forces, row, screw):
    """The force in six rows along a screw."""
    a, b, c, u, v, w = screw
    turn = forces[row] * a + forces[row + 1] * b + forces[row + 2] * c
    return turn + (forces[row + 3] * u + forces[row + 4] * v + forces[row + 5] * w)


@inlined
def _add_sample(s, t, screw, forces, numbers):
    """Add to the four numbers of a pair the forces on sample s that resist the one dof, along the other's screw."""
    first, second, forward, back = numbers
    of_first, of_second = _along(forces, 12 * s, screw), _along(forces, 12 * s + 6, screw)
    return (
        first + (1.0 - t) * of_first,
        second + t * of_second,
        forward + t * of_first,
        back + (1.0 - t) * of_second,
    )


@inlined
def _set_two_pairs(n, e, both, substeps, screws, forces, pairs, row):
    """Compute the four numbers of a dof and dof e, and of it and dof e + 1, if both is 1.

    Each force is read once for the two of them.
    """
    zero = full_like(screws, 0.0)
    here = following = zero, zero, zero, zero
    for s in range(substeps + 1):
        k, t = 6 * (n * s + e), s / substeps
        here = _add_sample(s, t, _screw_at(screws, k), forces, here)
        following = _add_sample(s, t, _screw_at(screws, k + 6 * both), forces, following)
    for i in range(4):
        pairs[row + i], pairs[row + 4 * both + i] = here[i], following[i]


# Terms of the Hessian that Gauss-Newton leaves out: forces on samples times second derivatives.


@internal
def _add_second_derivatives(tree, f, d, substeps, screws, moments, forces):
    """Add what the joint positions' second derivatives by dof d and others add to the forces that resist it.

    A dof moves p at the rate a × p + b, its screw. For the axis c of this dof or of one between it and the root, ∂²p =
    c × (a × p + b). So Σ w·∂²p = c·((M − tr M)a + b × Σ w) with M = Σ p wᵀ over the joints that the dof moves.
    """
    n, n_frames = tree.column.shape[0], tree.frame_parent.shape[0]
    for s in range(substeps + 1):
        m, row, t = 12 * (s * n_frames + f), 12 * s, s / substeps
        u, v, w = moments[m + 9], moments[m + 10], moments[m + 11]
        a, b, c, p, q, r = _screw_at(screws, 6 * (n * s + d))
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
def _add_ball(tree, f, substeps, poses, P, screws, moments, pairs, rows_of):
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


@internal
def _set_pairs(tree, substeps, exact, group, samples, equations):
    """Compute the numbers of all pairs of a group of steps."""
    n, n_frames = tree.column.shape[0], tree.frame_parent.shape[0]
    screws, P, sums, pairs = (
        rows(samples.screws, 0),
        rows(samples.P, 0),
        rows(equations.sums, 0),
        rows(equations.pairs, 0),
    )
    moments, forces, poses = rows(equations.moments, 0), rows(equations.forces, 0), rows(samples.poses, 0)
    for f in range(1, n_frames):
        for d in range(tree.first_dof[f], tree.end_dof[f]):
            _forces_of(f, d, n_frames, n, substeps, screws, sums, forces)
            if exact:
                _add_second_derivatives(tree, f, d, substeps, screws, moments, forces)
            row = first_row(equations, group, equations.first_pair[d])
            for r in range(tree.first_dof_range[f], tree.first_dof_range[f + 1]):
                end = min(tree.dof_ranges[r, 1], d + 1)
                for e in range(tree.dof_ranges[r, 0], end, 2):
                    both = min(1, end - 1 - e)
                    _set_two_pairs(n, e, both, substeps, screws, forces, pairs, row)
                    row += 4 + 4 * both
        if exact and tree.ball[f] >= 0:
            d = tree.first_dof[f]
            of_first = first_row(equations, group, equations.first_pair[d + 1] - 1)
            of_second = first_row(equations, group, equations.first_pair[d + 2] - 2)
            of_third = first_row(equations, group, equations.first_pair[d + 3] - 3)
            _add_ball(tree, f, substeps, poses, P, screws, moments, pairs, (of_first, of_second, of_third))


@internal
def _add_gradient_of(tree, path, group, samples, equations):
    """Place the samples of a group of steps, and add the forces on them to the gradient."""
    place_samples(tree, path, group * STEPS, True, samples)
    P, screws, moments = rows(samples.P, 0), rows(samples.screws, 0), rows(equations.moments, 0)
    for s in range(path.substeps + 1):
        own = rows(equations.moments, 12 * s * tree.frame_parent.shape[0])
        _sum_moments(tree, s, path.substeps, P, own)
    _add_gradient(tree, group * STEPS, path.substeps, screws, moments, equations.forces, equations.gradient)


@by_address(lambda: types.void(TREE, PATH, SAMPLES, EQUATIONS))
def gradient_of(tree, path, samples, equations):
    """Compute the gradient of half the energy alone; the blocks stay as they are."""
    equations.gradient[:] = 0.0
    for group in range(_n_groups(path)):
        _add_gradient_of(tree, path, group, samples, equations)


@by_address(lambda: types.void(TREE, PATH, FLAG, SAMPLES, EQUATIONS))
def normal_equations(tree, path, exact, samples, equations):
    """Compute the blocks of the normal equations, or of the exact Hessian, and the gradient of half the energy."""
    n_frames, n_coordinates, substeps = tree.frame_parent.shape[0], 3 * tree.offset.shape[0], path.substeps
    equations.gradient[:] = 0.0
    for group in range(_n_groups(path)):
        _add_gradient_of(tree, path, group, samples, equations)
        for s in range(substeps + 1):
            here = rows(samples.P, s * n_coordinates)
            _sum_products(tree, here, here, rows(equations.sums, 32 * s * n_frames))
            if s < substeps:
                after = rows(samples.P, (s + 1) * n_coordinates)
                _sum_products(tree, here, after, rows(equations.sums, (32 * s + 16) * n_frames))
        _set_pairs(tree, substeps, exact, group, samples, equations)
