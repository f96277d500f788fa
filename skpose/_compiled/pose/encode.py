"""The codes of poses: all that a metric needs of one pose, computed once per pose and not once per pair."""

import math

from skpose._compiled.pose.forward import SQRT2, rotate
from skpose._compiled.pose.rotation import canonical, product, quaternion_of
from skpose._compiled.pose.step import plan_of, step_arrays, take_step
from skpose._compiled.pose.tree import TWO_PI
from skpose._compiled.simd.jit import first_class, inlined
from skpose._compiled.simd.lanes import flat, rint, rows
from skpose._compiled.simd.trigonometry import cosine_sine


@inlined
def principal(angle, steps):
    """The angle wrapped to [−π, π], where the steps wrap differences.

    Rounding half to even makes this an odd function, so that the distances stay symmetric at a difference of π.
    """
    if steps.half_turn == math.inf:
        return angle
    return angle - TWO_PI * rint(angle * (1.0 / TWO_PI))


@inlined
def ball_rotation(pose, tree, k):
    """The rotation of ball joint k, reference included, as a quaternion."""
    f = flat(tree.ball_frame)[k]
    axes, reference, columns = flat(tree.ball_axes), flat(tree.reference), flat(tree.column)
    d = flat(tree.first_dof)[f]
    x, y, z = pose[columns[d]], pose[columns[d + 1]], pose[columns[d + 2]]
    u = axes[9 * f] * x + axes[9 * f + 1] * y + axes[9 * f + 2] * z
    v = axes[9 * f + 3] * x + axes[9 * f + 4] * y + axes[9 * f + 5] * z
    w = axes[9 * f + 6] * x + axes[9 * f + 7] * y + axes[9 * f + 8] * z
    before = reference[4 * f], reference[4 * f + 1], reference[4 * f + 2], reference[4 * f + 3]
    return canonical(product(before, quaternion_of(u, v, w)))


@inlined
def pose_joints(pose, tree, plan, arrays):
    """Compute the joint positions of a pose, as one step of the whole angles from zero."""
    C, S, A, B, Q, _, P, X, D = arrays
    sign, column, shift, dof = flat(tree.sign), flat(tree.column), flat(tree.shift), flat(tree.angle_dof)
    for k in range(plan.n_angles):
        d = dof[k]
        C[k], S[k] = 1.0, 0.0
        c, s = cosine_sine(pose[column[d]] * sign[d] + shift[d])
        A[k], B[k] = 1.0 - c, s
    for k in range(plan.n_balls):
        rotation = ball_rotation(pose, tree, k)
        for i in range(4):
            Q[9 * k + i], Q[9 * k + 4 + i] = 0.0, SQRT2 * rotation[i]
        Q[9 * k + 8] = 0.0
    for k in range(plan.n_slides):
        X[k], D[k] = 0.0, pose[column[flat(tree.slide_dof)[k]]]
    for j in range(1, plan.first_moving):
        for i in range(3):
            P[3 * j + i] = P[3 * plan.joint_parent[j] + i] + plan.offset[3 * j + i]
    for i in range(3 * plan.first_moving, 3 * plan.n_joints):
        P[i] = 0.0
    take_step(plan, arrays)


@first_class
def encode_angles(pose, tree, steps, scratch, code):
    """Write the angles themselves; the one code that needs no skeleton."""
    angles, put = rows(pose, 0), rows(code, 0)
    for d in range(pose.shape[0]):
        put[d] = principal(angles[d], steps)


@first_class
def encode_positions(pose, tree, steps, scratch, code):
    """Write F(θ): the scaled joint positions in the skeleton's order, without the root's."""
    plan, put, order = plan_of(tree), rows(code, 0), flat(tree.code_joint)
    arrays = step_arrays(tree, scratch)
    pose_joints(rows(pose, 0), tree, plan, arrays)
    for j in range(1, plan.n_joints):
        for i in range(3):
            put[3 * order[j] - 3 + i] = arrays.P[3 * j + i] * plan.scale[j]


@inlined
def _rotate_quaternion(Q, q, axis, cos, sin):
    """Rotate the quaternion (w, x, y, z) at row q about an axis, given the cosine and sine of half the angle."""
    a, b, c = q + 1 + axis, q + 1 + (axis + 1) % 3, q + 1 + (axis + 2) % 3
    Q[a], Q[q] = rotate(Q[a], Q[q], cos, sin)
    Q[b], Q[c] = rotate(Q[b], Q[c], cos, sin)


@first_class
def encode_rotations(pose, tree, steps, scratch, code):
    """Write the world orientation of every frame but the root's, as unit quaternions (w, x, y, z) of either sign."""
    plan, angles, put, Q = plan_of(tree), rows(pose, 0), rows(code, 0), rows(scratch, 0)
    sign, column, shift = flat(tree.sign), flat(tree.column), flat(tree.shift)
    for i in range(4):
        Q[i] = 1.0 if i == 0 else 0.0
    for f in range(1, tree.frame_parent.shape[0]):
        q, p, end = 4 * f, 4 * plan.frame_parent[f], plan.end_dof[f]
        for i in range(4):
            Q[q + i] = Q[p + i]
        if plan.ball[f] >= 0:
            rotation = ball_rotation(angles, tree, plan.ball[f])
            Q[q], Q[q + 1], Q[q + 2], Q[q + 3] = product((Q[p], Q[p + 1], Q[p + 2], Q[p + 3]), rotation)
        elif end == plan.first_dof[f]:
            _rotate_quaternion(
                Q, q, plan.single_axis[f], plan.fixed_rotation[4 * f + 2], plan.fixed_rotation[4 * f + 3]
            )
        for d in range(end if plan.ball[f] >= 0 or flat(tree.slide)[f] >= 0 else plan.first_dof[f], end):
            cos, sin = cosine_sine((angles[column[d]] * sign[d] + shift[d]) * 0.5)
            _rotate_quaternion(Q, q, plan.single_axis[f] + end - 1 - d, cos, sin)
        for i in range(4):
            put[q - 4 + i] = Q[q + i]


def count_line_codes(tree):
    """How many numbers of the code of a curve's end describe its dofs; the positions follow."""
    return 5 * tree.angle_dof.shape[0] + 4 * tree.ball_frame.shape[0] + tree.slide_dof.shape[0]


n_line_codes = inlined(count_line_codes)  # what compiled functions call


@first_class
def encode_curve_end(pose, tree, steps, scratch, code):
    """Write what a line needs of its ends.

    For the angles θ, n each: θ, cos θ/2N, sin θ/2N, cos θ, sin θ, the last two of shifted angles. For each ball joint
    four numbers, its quaternion times √2. The displacements of slides. Then the joint positions (3 n_joints),
    not scaled.
    """
    plan, angles, put = plan_of(tree), rows(pose, 0), rows(code, 0)
    sign, column, dof, n = flat(tree.sign), flat(tree.column), flat(tree.angle_dof), plan.n_angles
    arrays = step_arrays(tree, scratch)
    pose_joints(angles, tree, plan, arrays)
    for k in range(n):
        d = dof[k]
        angle = principal(angles[column[d]] * sign[d], steps)
        put[k] = angle
        put[n + k], put[2 * n + k] = cosine_sine(angle * (0.5 / steps.n_steps))
        put[3 * n + k], put[4 * n + k] = arrays.C[k], arrays.S[k]
    at = 5 * n
    for k in range(plan.n_balls):
        for i in range(4):
            put[at + 4 * k + i] = arrays.Q[9 * k + i]
    for k in range(plan.n_slides):
        put[at + 4 * plan.n_balls + k] = arrays.X[k]
    first = at + 4 * plan.n_balls + plan.n_slides - 3
    for i in range(3, 3 * plan.n_joints):
        put[first + i] = arrays.P[i]
