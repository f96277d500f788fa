"""A lower bound of the length of a straight line: two chords, from one end to its middle and on to the other end.

By the triangle inequality a chord is no longer than the chords that it replaces, so this is a bound where the middle is
one of the line's samples: where the number of steps is even. It costs one forward kinematics, and none of the dofs'
steps, as the middle of two angles is their sum where the code holds half of each.

For float32: `middle_slack` is the largest rounding error of the bound. In a lane where rounding may choose the
wrong side of a half turn, the bound is zero.
"""

import math

import numpy as np

from skpose._compiled.pose.encode import pose_joints, principal, put_balls_and_joints
from skpose._compiled.pose.measure import last_chord, start_joints
from skpose._compiled.pose.step import displace_joints, plan_of, step_arrays
from skpose._compiled.simd.jit import first_class, inlined
from skpose._compiled.simd.lanes import any_greater, flat, full_like, greater, minimum, rows, sqrt
from skpose._compiled.simd.trigonometry import cosine_sine

NEAR_HALF_TURN = 1e-4  # |cos of half the difference| below which the shorter side is not certain
ROUNDINGS = 64  # per dof on the path from the root to a joint, each 2⁻²⁴ of the distance moved; a count gives some 20


def count_middle_codes(tree):
    """How many numbers of the code describe the dofs; the positions follow."""
    return 2 * tree.angle_dof.shape[0] + 4 * tree.ball_frame.shape[0] + tree.slide_dof.shape[0]


n_middle_codes = inlined(count_middle_codes)  # what compiled functions call


@first_class
def encode_middle(pose, tree, steps, scratch, code):
    """Write what the middle of a line needs of its ends.

    For the angles θ, n each: cos θ/2, sin θ/2 of shifted angles. For each ball joint its quaternion times √2. The
    displacements of slides. Then the joint positions (3 n_joints), not scaled.
    """
    plan, angles, put = plan_of(tree), rows(pose, 0), rows(code, 0)
    sign, column, shift, dof = flat(tree.sign), flat(tree.column), flat(tree.shift), flat(tree.angle_dof)
    arrays = step_arrays(tree, scratch)
    pose_joints(angles, tree, plan, arrays)
    n = plan.n_angles
    for k in range(n):
        d = dof[k]
        put[k], put[n + k] = cosine_sine((principal(angles[column[d]] * sign[d], steps) + shift[d]) * 0.5)
    put_balls_and_joints(plan, arrays, put, 2 * n)


@inlined
def _set_middle(plan, a, b, steps, arrays):
    """Set all dofs to the middle of the line; return 1 in the lanes where that is certain, else 0."""
    C, S, Q, n = arrays.C, arrays.S, arrays.Q, plan.n_angles
    least = full_like(b, 1.0)
    for d in range(n):
        ac, bs = a[d] * b[d], a[n + d] * b[n + d]
        c, s = ac - bs, a[n + d] * b[d] + a[d] * b[n + d]
        half_gap = ac + bs  # its cosine, negative where the difference is wrapped: the middle is then the opposite
        if steps.half_turn < math.inf and any_greater(0.0 - half_gap, -NEAR_HALF_TURN):  # rare
            sign = 1.0 - 2.0 * greater(0.0 - half_gap, 0.0)
            c, s, least = c * sign, s * sign, minimum(least, half_gap * half_gap)
        C[d], S[d] = c, s
    for k in range(plan.n_balls):
        at, q = 2 * n + 4 * k, 9 * k
        dot = full_like(b, 0.0)
        for i in range(at, at + 4):
            dot = dot + a[i] * b[i]
        least = minimum(least, dot * dot)
        sign = 1.0 - 2.0 * greater(0.0 - dot, 0.0)
        size = sqrt(1.0 / (2.0 + sign * dot))
        for i in range(4):
            Q[q + i], Q[q + 4 + i] = full_like(b, 0.0), (a[at + i] + sign * b[at + i]) * size
        Q[q + 8] = full_like(b, 0.0)
    for k in range(plan.n_slides):
        at = 2 * n + 4 * plan.n_balls + k
        arrays.X[k], arrays.D[k] = full_like(b, 0.0), 0.5 * (a[at] + b[at])
    return greater(least, NEAR_HALF_TURN * NEAR_HALF_TURN)


@first_class
def measure_two_chords(x, Y, first, last, tree, steps, scratch, results):
    """Compute ‖F(m) − F(a)‖ + ‖F(b) − F(m)‖, m the middle of the line from a to b."""
    plan, a, n_codes = plan_of(tree), flat(x), x.shape[0]
    arrays, before = step_arrays(tree, scratch), n_middle_codes(tree) - 3
    for k in range(first, last):
        b = rows(Y, k * n_codes)
        certain = _set_middle(plan, a, b, steps, arrays)
        start_joints(plan, a, before, arrays.P)
        length = sqrt(displace_joints(plan, arrays))
        rows(results.distances, k - first)[0] = (length + last_chord(plan, b, before, arrays.P)) * certain


def middle_slack(tree):
    """The rounding error by which two chords in float32 may exceed exact ones, m; infinite out of float32's range."""
    if len(tree.slide_dof):  # their reach is unknown
        return math.inf
    depth, reach = np.zeros(len(tree.frame_parent)), np.zeros(len(tree.offset))
    for f in range(1, len(depth)):
        depth[f] = depth[tree.frame_parent[f]] + max(1, tree.end_dof[f] - tree.first_dof[f])
    for j in range(1, len(reach)):
        reach[j] = reach[tree.joint_parent[j]] + np.abs(tree.offset[j]).sum()
    roundings = ROUNDINGS * (1.0 + depth[tree.joint_frame])
    size = np.linalg.norm(tree.scale * reach)
    if not size > 1e-12 or max(size, reach.max()) > 1e12:  # positions are squared before and after they are scaled
        return math.inf
    return 2.0 * 2.0**-24 * np.linalg.norm(roundings * tree.scale * reach)
