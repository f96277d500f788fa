"""The measures: distances from one encoded pose x to the groups of lanes first:last of others, Y.

They write into the `Results`: row k of its arrays is group first + k.
"""

import math

import numpy as np

from skpose._compiled.pose.rotation import TIE
from skpose._compiled.pose.step import for_scale, no_squares, plan_of, step_arrays, take_step, weighted_sum
from skpose._compiled.pose.tree import SLERP_TERMS, TWO_PI, Squares, Steps
from skpose._compiled.simd.jit import first_class, inlined
from skpose._compiled.simd.lanes import any_greater, flat, full_like, greater, minimum, rows, sqrt

STEPS_PER_BOUND = 3  # of a line that may be longer than a limit; more bounds take more than they save


@inlined
def turns_off(gap, steps):
    """The whole turns (−1, 0 or 1) to subtract from a difference of angles to wrap it to [−π, π]."""
    return greater(gap, steps.half_turn) - greater(0.0 - gap, steps.half_turn)


@inlined
def to_points(a, b, n):
    """The Euclidean distances of a point a to others b, of n coordinates."""
    zero = full_like(b, 0.0)
    one, two, three = zero, zero, zero  # several sums, so that no addition waits for the one before
    for d in range(0, n - 2, 3):
        p, q, r = b[d] - a[d], b[d + 1] - a[d + 1], b[d + 2] - a[d + 2]
        one, two, three = one + p * p, two + q * q, three + r * r
    for d in range(n - n % 3, n):
        gap = b[d] - a[d]
        one = one + gap * gap
    return sqrt(one + two + three)


@inlined
def to_boxes(a, low, high, n):
    """The Euclidean distances of a point a to boxes, of n coordinates, given two corners of each."""
    zero = full_like(low, 0.0)
    one, two = zero, zero
    for d in range(0, n - 1, 2):
        p = minimum(minimum(a[d] - low[d], high[d] - a[d]), zero)
        q = minimum(minimum(a[d + 1] - low[d + 1], high[d + 1] - a[d + 1]), zero)
        one, two = one + p * p, two + q * q
    if n % 2 == 1:
        p = minimum(minimum(a[n - 1] - low[n - 1], high[n - 1] - a[n - 1]), zero)
        one = one + p * p
    return sqrt(one + two)


@first_class
def measure_euclidean(x, Y, first, last, tree, steps, scratch, results):
    """Compute ‖y − x‖₂, every difference wrapped where the metric wraps."""
    a, n = flat(x), x.shape[0]
    for k in range(first, last):
        b = rows(Y, k * n)
        if steps.half_turn == math.inf:
            rows(results.distances, k - first)[0] = to_points(a, b, n)
        else:
            total = full_like(b, 0.0)
            for d in range(n):
                gap = b[d] - a[d]
                gap = gap - turns_off(gap, steps) * TWO_PI
                total = total + gap * gap
            rows(results.distances, k - first)[0] = sqrt(total)


@first_class
def measure_boxes(x, Y, first, last, tree, steps, scratch, results):
    """Compute the Euclidean distances from a point x to boxes, whose codes are the lower corner, then the upper one."""
    a, n = flat(x), x.shape[0]
    for k in range(first, last):
        rows(results.distances, k - first)[0] = to_boxes(a, rows(Y, 2 * n * k), rows(Y, 2 * n * k + n), n)


# The coefficients in t of φ² / 4m for two unit quaternions at squared distance m = 1 + t, 0 ≤ m ≤ 2.
#
# φ = 4 arcsin(√m / 2), whose square is analytic in m up to m = 4: interpolation in Chebyshev's points on [0, 2] gains a
# factor 3 + √8 per degree and is exact to rounding at degree 24.
_SERIES = np.polynomial.Chebyshev.interpolate(lambda m: (2.0 * np.arcsin(np.sqrt(m) / 2.0)) ** 2 / m, 24, (0, 2))
_SQUARED_ANGLE = tuple(np.polynomial.chebyshev.cheb2poly(_SERIES.coef))


@first_class
def measure_rotations(x, Y, first, last, tree, steps, scratch, results):
    """Compute √Σ ℓ² φ² over the bones, φ the angle between the orientations of the bone's frame."""
    a, weight, n_frames = flat(x), flat(tree.weight), tree.weight.shape[0]
    for k in range(first, last):
        b = rows(Y, k * x.shape[0])
        total = full_like(b, 0.0)
        for f in range(1, n_frames):
            if weight[f] == 0.0:
                continue
            minus, plus = full_like(b, 0.0), full_like(b, 0.0)
            for i in range(4 * f - 4, 4 * f):
                q = b[i]
                minus, plus = minus + (q - a[i]) * (q - a[i]), plus + (q + a[i]) * (q + a[i])
            m = minimum(minus, plus)  # q and −q are one rotation
            t, share = m - 1.0, full_like(b, 0.0)
            for i in range(len(_SQUARED_ANGLE) - 1, -1, -1):  # here, LLVM unrolls the loop; in a function, it does not
                share = share * t + _SQUARED_ANGLE[i]
            total = total + weight[f] * 4.0 * m * share
        rows(results.distances, k - first)[0] = sqrt(total)


@inlined
def _drop_references(steps):
    """The steps with an address instead of the array, whose references would be counted in inner loops."""
    return Steps(steps.n_steps, steps.half_turn, steps.cos_turn, steps.sin_turn, flat(steps.slerp))


@inlined
def _half_step(a, b, d, n, steps):
    """Cosine and sine of half a step of angle d on the straight line, and the whole difference."""
    gap = b[d] - a[d]
    c, s = b[n + d], b[2 * n + d]
    c, s = c * a[n + d] + s * a[2 * n + d], s * a[n + d] - c * a[2 * n + d]
    if any_greater(gap * gap, 0.99 * steps.half_turn * steps.half_turn):  # rare
        turns = turns_off(gap, steps)
        gap = gap - turns * TWO_PI
        # cos and sin of half the angle that is subtracted from a step, for turns in {−1, 0, 1}
        cos_off, sin_off = turns * turns * (steps.cos_turn - 1.0) + 1.0, turns * steps.sin_turn
        c, s = c * cos_off + s * sin_off, s * cos_off - c * sin_off
    return c, s, gap


@inlined
def _start_ball(a, b, at, Q, q, slerp):
    """Set a ball joint's state at row q to the start of the slerp from a to b; return 1 − cos φ.

    Its quaternions stand at `at` in the codes, times √2. With e the difference of the two, the shorter one, and
    m = 1 − cos φ, the sample after a is (1 − κ/2) a + s (e + m a), with s = sin(φ/N)/sin φ and κ = 2 − 2 cos(φ/N).
    """
    dot = full_like(b, 0.0)
    for i in range(at, at + 4):
        dot = dot + a[i] * b[i]
    sign = 1.0 - 2.0 * greater(0.0 - dot, 2.0 * TIE)
    m = full_like(b, 0.0)
    for i in range(at, at + 4):
        e = sign * b[i] - a[i]
        m = m + e * e
    m = 0.25 * m
    t = m + m - 1.0
    # Even and odd powers apart: four sums, so that no addition waits for the one before.
    square = t * t
    share, curvature = full_like(b, slerp[SLERP_TERMS - 1]), full_like(b, slerp[2 * SLERP_TERMS - 1])
    odd_share, odd_curvature = full_like(b, 0.0), full_like(b, 0.0)
    for k in range(SLERP_TERMS - 3, -1, -2):
        share, odd_share = share * square + slerp[k], odd_share * square + slerp[k + 1]
        curvature = curvature * square + slerp[SLERP_TERMS + k]
        odd_curvature = odd_curvature * square + slerp[SLERP_TERMS + k + 1]
    share, curvature = share + odd_share * t, m * (curvature + odd_curvature * t)  # the latter is κ/2
    along = share * m + curvature
    for i in range(4):
        Q[q + i] = a[at + i]
        Q[q + 4 + i] = share * (sign * b[at + i] - a[at + i]) + along * a[at + i]
    Q[q + 8] = curvature + curvature
    return m


@inlined
def _last_chord(plan, b, before, P):
    """The distance from the joints P to encoded poses b."""
    squares = no_squares(plan.scale[plan.n_joints - 1], P)
    for j in range(1, plan.n_joints):
        i, k = 3 * j, before + 3 * j
        p, q, r = b[k] - P[i], b[k + 1] - P[i + 1], b[k + 2] - P[i + 2]
        scale, one, two, three, total = for_scale(plan.scale[j], P, squares)
        squares = Squares(scale, one + p * p, two + q * q, three + r * r, total)
    return sqrt(weighted_sum(squares))


@inlined
def _line(plan, a, b, steps, arrays, limit):
    """The length of the straight line from an encoded pose a to others b, and whether that was computed.

    Elsewhere it is more than the limit in every lane, and so is what is returned: the length so far and of the chord
    from there on, a lower bound by the triangle inequality.
    """
    C, S, A, B, n = arrays.C, arrays.S, arrays.A, arrays.B, plan.n_angles
    before = 5 * n + 4 * plan.n_balls + plan.n_slides - 3
    apart = full_like(b, 0.0)
    for d in range(n):
        c, s, gap = _half_step(a, b, d, n, steps)
        apart = apart + gap * gap
        A[d], B[d] = 2.0 * s * s, 2.0 * s * c
        C[d], S[d] = a[3 * n + d], a[4 * n + d]
    for k in range(plan.n_balls):
        apart = apart + _start_ball(a, b, 5 * n + 4 * k, arrays.Q, 9 * k, steps.slerp)
    for k in range(plan.n_slides):
        at = 5 * n + 4 * plan.n_balls + k
        gap = b[at] - a[at]
        apart = apart + gap * gap
        arrays.X[k], arrays.D[k] = full_like(b, a[at]), gap * (1.0 / steps.n_steps)
    for i in range(3, 3 * plan.n_joints):
        arrays.P[i] = full_like(b, a[before + i])
    length = full_like(b, 0.0)
    for step in range(1, steps.n_steps):
        length = length + sqrt(take_step(plan, arrays))
        if limit < math.inf and step % STEPS_PER_BOUND == 0 and step < steps.n_steps - 1:
            bound = length + _last_chord(plan, b, before, arrays.P)
            if not any_greater(0.0 - bound, 0.0 - limit):
                return bound, False
    # From a pose to itself the samples differ by rounding; the distance is zero.
    return (length + _last_chord(plan, b, before, arrays.P)) * greater(apart, 0.0), True


@first_class
def measure_line(x, Y, first, last, tree, steps, scratch, results):
    """Compute the length of the straight line in the dofs, Σ ‖F(c_n) − F(c_{n−1})‖, sec. 2.2 of the paper.

    Where that is above the limit in a whole group, it may be a lower bound that is above it, too.
    """
    plan, a, bare = plan_of(tree), flat(x), _drop_references(steps)
    arrays = step_arrays(tree, scratch)
    for k in range(first, last):
        length, is_complete = _line(plan, a, rows(Y, k * x.shape[0]), bare, arrays, results.limit[0])
        rows(results.distances, k - first)[0] = length
        if not is_complete:
            results.n_ruled_out[0] += 1
