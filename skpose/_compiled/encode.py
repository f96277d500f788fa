"""The codes of poses: all that a metric needs of one pose, computed once per pose and not once per pair."""

import math

from skpose._compiled.forward import rotated
from skpose._compiled.jit import inlined, jit
from skpose._compiled.lanes import flat, minimum, rint, rows
from skpose._compiled.step import parts_of, plan_of, take_step
from skpose._compiled.tree import TWO_PI

# π in three parts, the first two of so few bits that their multiples by less than 2²² are exact.
_PI_PARTS = 3.1415926534682512, 1.2154201018028943e-10, -5.016557612668332e-20
_SINE = tuple((-1.0) ** k / math.factorial(2 * k + 1) for k in range(11))
_COSINE = tuple((-1.0) ** k / math.factorial(2 * k) for k in range(12))


@inlined
def series(coefficients, t, value):
    """Evaluate a polynomial by Horner's rule; `value` is a zero of the right kind."""
    for k in range(len(coefficients) - 1, -1, -1):
        value = value * t + coefficients[k]
    return value


@inlined
def cosine_sine(angle):
    """Return cosine and sine of an angle, to 2e-16 up to a million turns.

    Multiples of π are subtracted, and the rest goes into Taylor's series. numba has neither function in lanes; one by
    one, by the C library, they take twenty times as long.
    """
    half_turns = rint(angle * (1.0 / math.pi))
    rest = ((angle - half_turns * _PI_PARTS[0]) - half_turns * _PI_PARTS[1]) - half_turns * _PI_PARTS[2]
    bound = 0.0 * rest + 1.6  # more than π/2: an angle so large that no digit is left stays within
    rest = 0.0 - minimum(0.0 - minimum(rest, bound), bound)
    odd = half_turns - 2.0 * rint(half_turns * 0.5)
    sign = 1.0 - 2.0 * (odd * odd)
    t = rest * rest
    return sign * series(_COSINE, t, 0.0 * t), sign * (rest * series(_SINE, t, 0.0 * t))


@inlined
def _principal(angle, steps):
    """Return the angle wrapped to [−π, π], where the steps wrap differences.

    Rounding half to even makes this an odd function, so that the distances stay symmetric at a difference of π.
    """
    if steps.half_turn == math.inf:
        return angle
    return angle - TWO_PI * rint(angle * (1.0 / TWO_PI))


@inlined
def _pose_joints(pose, tree, plan, parts):
    """Compute the joint positions of a pose, as one step of the whole angles from zero."""
    C, S, A, B, _, P = parts
    sign, column, shift = flat(tree.sign), flat(tree.column), flat(tree.shift)
    for d in range(plan.n_dofs):
        C[d], S[d] = 1.0, 0.0
        c, s = cosine_sine(pose[column[d]] * sign[d] + shift[d])
        A[d], B[d] = 1.0 - c, s
    for j in range(1, plan.first_moving):
        for i in range(3):
            P[3 * j + i] = P[3 * plan.joint_parent[j] + i] + plan.offset[3 * j + i]
    for i in range(3 * plan.first_moving, 3 * plan.n_joints):
        P[i] = 0.0
    take_step(plan, parts)


@jit
def encode_angles(pose, tree, steps, scratch, code):
    """Write the angles themselves; the one code that needs no skeleton."""
    angles, put = rows(pose, 0), rows(code, 0)
    for d in range(pose.shape[0]):
        put[d] = _principal(angles[d], steps)


@jit
def encode_positions(pose, tree, steps, scratch, code):
    """Write F(θ): the joint positions in the skeleton's order, without the root's."""
    plan, put, order = plan_of(tree), rows(code, 0), flat(tree.skeleton_joint)
    parts = parts_of(tree, scratch)
    _pose_joints(rows(pose, 0), tree, plan, parts)
    for j in range(1, plan.n_joints):
        for i in range(3):
            put[3 * order[j] - 3 + i] = parts.P[3 * j + i]


@inlined
def _rotate_quaternion(Q, q, axis, cos, sin):
    """Rotate the quaternion (w, x, y, z) at row q about an axis, given the cosine and sine of half the angle."""
    a, b, c = q + 1 + axis, q + 1 + (axis + 1) % 3, q + 1 + (axis + 2) % 3
    Q[a], Q[q] = rotated(Q[a], Q[q], cos, sin)
    Q[b], Q[c] = rotated(Q[b], Q[c], cos, sin)


@jit
def encode_rotations(pose, tree, steps, scratch, code):
    """Write the world orientation of every frame but the root's, as unit quaternions (w, x, y, z) of either sign."""
    plan, angles, put, Q = plan_of(tree), rows(pose, 0), rows(code, 0), rows(scratch, 0)
    sign, column, shift = flat(tree.sign), flat(tree.column), flat(tree.shift)
    for i in range(4):
        Q[i] = 1.0 if i == 0 else 0.0
    for f in range(1, tree.frame_parent.shape[0]):
        q, end = 4 * f, plan.end_dof[f]
        for i in range(4):
            Q[q + i] = Q[4 * plan.frame_parent[f] + i]
        if end == plan.first_dof[f]:
            _rotate_quaternion(Q, q, plan.fixed_axis[f], plan.fixed_rotation[4 * f + 2], plan.fixed_rotation[4 * f + 3])
        for d in range(plan.first_dof[f], end):
            cos, sin = cosine_sine((angles[column[d]] * sign[d] + shift[d]) * 0.5)
            _rotate_quaternion(Q, q, end - 1 - d, cos, sin)
        for i in range(4):
            put[q - 4 + i] = Q[q + i]


@jit
def encode_curve_end(pose, tree, steps, scratch, code):
    """Write θ, cos θ/2N, sin θ/2N, cos θ, sin θ (n_dofs each, the last two of shifted angles) and F(θ) (3 n_joints)."""
    plan, angles, put = plan_of(tree), rows(pose, 0), rows(code, 0)
    sign, column, n = flat(tree.sign), flat(tree.column), plan.n_dofs
    parts = parts_of(tree, scratch)
    _pose_joints(angles, tree, plan, parts)
    for d in range(n):
        angle = _principal(angles[column[d]] * sign[d], steps)
        put[d] = angle
        put[n + d], put[2 * n + d] = cosine_sine(angle * (0.5 / steps.n_steps))
        put[3 * n + d], put[4 * n + d] = parts.C[d], parts.S[d]
    for i in range(3, 3 * plan.n_joints):
        put[5 * n + i - 3] = parts.P[i]
