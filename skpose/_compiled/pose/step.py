"""One step of all angles along a line, and the joints placed anew: in lanes."""

from skpose._compiled.pose.forward import rotate
from skpose._compiled.pose.rotation import turn_back
from skpose._compiled.pose.tree import BALL, HINGE, Plan, Squares, StepArrays
from skpose._compiled.simd.jit import inlined
from skpose._compiled.simd.lanes import flat, full_like, rows


@inlined
def plan_of(tree):
    """Return the part of a tree that a step reads."""
    first_moving = 1
    while first_moving < tree.joint_frame.shape[0] and tree.joint_frame[first_moving] == 0:
        first_moving += 1
    return Plan(
        tree.angle_dof.shape[0],
        tree.ball_frame.shape[0],
        tree.slide_dof.shape[0],
        tree.batch_kind.shape[0],
        tree.first_joint.shape[0] - 1,
        tree.first_leaf.shape[0] - 1,
        first_moving,
        tree.first_leaf[-1],
        tree.offset.shape[0],
        flat(tree.frame_parent),
        flat(tree.first_dof),
        flat(tree.end_dof),
        flat(tree.end_angle),
        flat(tree.ball),
        flat(tree.single_axis),
        flat(tree.fixed_rotation),
        flat(tree.batch_kind),
        flat(tree.first_frame),
        flat(tree.first_joint),
        flat(tree.first_leaf),
        flat(tree.joint_parent),
        flat(tree.joint_frame),
        flat(tree.joint_slide),
        flat(tree.slide_axis),
        flat(tree.offset),
        flat(tree.scale),
    )


@inlined
def step_arrays(tree, scratch):
    """Return the rows of a scratch array that a step uses, the root's frame and position set."""
    n, q, h = tree.angle_dof.shape[0], 9 * tree.ball_frame.shape[0], 6 * tree.frame_parent.shape[0]
    H, P, x = rows(scratch, 4 * n + q), rows(scratch, 4 * n + q + h), 4 * n + q + h + 3 * tree.offset.shape[0]
    for i in range(6):
        H[i] = 1.0 if i % 4 == 0 else 0.0
    for i in range(3):
        P[i] = 0.0
    return StepArrays(
        rows(scratch, 0),
        rows(scratch, n),
        rows(scratch, 2 * n),
        rows(scratch, 3 * n),
        rows(scratch, 4 * n),
        H,
        P,
        rows(scratch, x),
        rows(scratch, x + tree.slide_dof.shape[0]),
    )


@inlined
def _rotate_batch(n_dofs, first, last, plan, C, S, H):
    """Compute the orientations of frames that have the same number of dofs."""
    for f in range(first, last):
        before, row, d = 6 * plan.frame_parent[f], 6 * f, plan.end_angle[f] - 1
        cx, sx = C[d], S[d]
        cy, sy, cz, sz = cx, sx, cx, sx
        if n_dofs > 1:
            cy, sy = C[d - 1], S[d - 1]
        if n_dofs > 2:
            cz, sz = C[d - 2], S[d - 2]
        for i in range(0, 6, 3):
            x, y, z = H[before + i], H[before + i + 1], H[before + i + 2]
            if n_dofs > 2:
                x, y = rotate(x, y, cz, sz)
            if n_dofs > 1:
                z, x = rotate(z, x, cy, sy)
            y, z = rotate(y, z, cx, sx)
            H[row + i], H[row + i + 1], H[row + i + 2] = x, y, z


@inlined
def advance(Q, q):
    """Add one step to the quaternion of a ball joint at row q; return it.

    Nine rows hold the quaternion times √2, its last change, and the change's relative decrease 2 − 2 cos(φ/N).
    """
    decrease = Q[q + 8]
    w, x, y, z = Q[q], Q[q + 1], Q[q + 2], Q[q + 3]
    a, b, c, d = Q[q + 4], Q[q + 5], Q[q + 6], Q[q + 7]
    a, b, c, d = a - decrease * w, b - decrease * x, c - decrease * y, d - decrease * z
    w, x, y, z = w + a, x + b, y + c, z + d
    Q[q], Q[q + 1], Q[q + 2], Q[q + 3] = w, x, y, z
    Q[q + 4], Q[q + 5], Q[q + 6], Q[q + 7] = a, b, c, d
    return w, x, y, z


@inlined
def _rotate_balls(first, last, plan, Q, H):
    """Compute the orientations of ball joints' frames."""
    for f in range(first, last):
        before, row = 6 * plan.frame_parent[f], 6 * f
        quaternion = advance(Q, 9 * plan.ball[f])
        for i in range(0, 6, 3):
            x, y, z = turn_back((H[before + i], H[before + i + 1], H[before + i + 2]), quaternion)
            H[row + i], H[row + i + 1], H[row + i + 2] = x, y, z


@inlined
def _rotate_hinge(f, plan, cos, sin, H):
    """Compute the orientation of a frame that is rotated about any one axis."""
    before, row, a = 6 * plan.frame_parent[f], 6 * f, plan.single_axis[f]
    b, c = (a + 1) % 3, (a + 2) % 3
    for i in range(0, 6, 3):
        u, v = rotate(H[before + i + b], H[before + i + c], cos, sin)
        H[row + i + a], H[row + i + b], H[row + i + c] = H[before + i + a], u, v


@inlined
def _set_coordinate(P, j, p, value, square):
    """Set one coordinate of a joint to its parent's plus a value; add the square of its change."""
    new = P[p] + value
    move = new - P[j]
    P[j] = new
    return square + move * move


@inlined
def _place_joint(H, h, P, j, p, x, y, z, squares):
    """Place joint j at (x, y, z) from joint p, in the frame at row h; add the square of its displacement."""
    a, b, c, d, e, f = H[h], H[h + 1], H[h + 2], H[h + 3], H[h + 4], H[h + 5]
    first = _set_coordinate(P, 3 * j, 3 * p, a * x + b * y + c * z, squares.first)
    second = _set_coordinate(P, 3 * j + 1, 3 * p + 1, d * x + e * y + f * z, squares.second)
    third = (b * f - c * e) * x + (c * d - a * f) * y + (a * e - b * d) * z
    third = _set_coordinate(P, 3 * j + 2, 3 * p + 2, third, squares.third)
    return Squares(squares.scale, first, second, third, squares.total)


@inlined
def _place_along_x(H, h, P, j, p, x, squares):
    """Place joint j as `_place_joint` does, at (x, 0, 0)."""
    first = _set_coordinate(P, 3 * j, 3 * p, H[h] * x, squares.first)
    second = _set_coordinate(P, 3 * j + 1, 3 * p + 1, H[h + 3] * x, squares.second)
    third = _set_coordinate(P, 3 * j + 2, 3 * p + 2, (H[h + 1] * H[h + 5] - H[h + 2] * H[h + 4]) * x, squares.third)
    return Squares(squares.scale, first, second, third, squares.total)


@inlined
def _rotate_frames(plan, arrays):
    """Compute the orientations of all frames but the leaves."""
    C, S, H = arrays.C, arrays.S, arrays.H
    for b in range(plan.n_batches):
        kind, first, last = plan.batch_kind[b], plan.first_frame[b], plan.first_frame[b + 1]
        # A literal number lets the compiler remove the branches on it.
        if kind == BALL:
            _rotate_balls(first, last, plan, arrays.Q, H)
        elif kind == 3:
            _rotate_batch(3, first, last, plan, C, S, H)
        elif kind == 2:
            _rotate_batch(2, first, last, plan, C, S, H)
        elif kind == 1:
            _rotate_batch(1, first, last, plan, C, S, H)
        elif kind == HINGE:
            for f in range(first, last):
                _rotate_hinge(f, plan, C[plan.end_angle[f] - 1], S[plan.end_angle[f] - 1], H)
        else:
            for f in range(first, last):
                _rotate_hinge(f, plan, plan.fixed_rotation[4 * f], plan.fixed_rotation[4 * f + 1], H)


@inlined
def _leaf_offset(plan, arrays, f, x, y):
    """Return the offset (x, y, 0) of a leaf's joint, rotated by its angles."""
    C, S = arrays.C, arrays.S
    d, n_dofs = plan.end_angle[f] - 1, plan.end_dof[f] - plan.first_dof[f]
    u, v, w = full_like(arrays.P, x), C[d] * y, S[d] * y
    if n_dofs > 1:
        u, w = rotate(u, w, C[d - 1], S[d - 1])
    if n_dofs > 2:
        v, u = rotate(v, u, C[d - 2], S[d - 2])
    return u, v, w


@inlined
def _ball_offset(Q, q, x):
    """Return the offset (x, 0, 0) of a ball joint's leaf, rotated by one step."""
    a, b, c, d = advance(Q, q)
    return (1.0 - (c * c + d * d)) * x, (b * c + a * d) * x, (b * d - a * c) * x


@inlined
def no_squares(scale, P):
    """Return sums of squares with nothing in them, for joints of a scale."""
    zero = full_like(P, 0.0)
    return Squares(scale, zero, zero, zero, zero)


@inlined
def weighted_sum(squares):
    """Return the weighted sum of squares."""
    return squares.total + (squares.scale * squares.scale) * (squares.first + squares.second + squares.third)


@inlined
def for_scale(scale, P, squares):
    """Return sums for joints of this scale; those of another one are weighted now, so that equal ones cost nothing."""
    if scale == squares.scale:
        return squares
    zero = full_like(P, 0.0)
    return Squares(scale, zero, zero, zero, weighted_sum(squares))


@inlined
def take_step(plan, arrays):
    """Add one step to all dofs and place the joints; return the square of their displacement."""
    C, S, A, B = arrays.C, arrays.S, arrays.A, arrays.B
    for d in range(plan.n_angles):
        c, s, a, b = C[d], S[d], A[d], B[d]
        C[d], S[d] = c - a * c - b * s, s - a * s + b * c
    H, P, X, D = arrays.H, arrays.P, arrays.X, arrays.D
    _rotate_frames(plan, arrays)
    squares = no_squares(plan.scale[plan.n_joints - 1], P)
    for b in range(0, plan.n_ranges, 3):
        squares = for_scale(plan.scale[plan.first_joint[b]], P, squares)
        for j in range(plan.first_joint[b], plan.first_joint[b + 1]):
            x, y, z = plan.offset[3 * j], plan.offset[3 * j + 1], plan.offset[3 * j + 2]
            squares = _place_joint(H, 6 * plan.joint_frame[j], P, j, plan.joint_parent[j], x, y, z, squares)
        for j in range(plan.first_joint[b + 1], plan.first_joint[b + 2]):
            h, x = 6 * plan.joint_frame[j], plan.offset[3 * j]
            squares = _place_along_x(H, h, P, j, plan.joint_parent[j], x, squares)
        for j in range(plan.first_joint[b + 2], plan.first_joint[b + 3]):
            k = plan.joint_slide[j]
            X[k] = X[k] + D[k]
            x = plan.slide_axis[3 * k] * X[k] + plan.offset[3 * j]
            y = plan.slide_axis[3 * k + 1] * X[k] + plan.offset[3 * j + 1]
            z = plan.slide_axis[3 * k + 2] * X[k] + plan.offset[3 * j + 2]
            squares = _place_joint(H, 6 * plan.joint_frame[j], P, j, plan.joint_parent[j], x, y, z, squares)
    for b in range(plan.n_leaf_ranges):
        squares = for_scale(plan.scale[plan.first_leaf[b]], P, squares)
        for j in range(plan.first_leaf[b], plan.first_leaf[b + 1]):
            f = plan.joint_frame[j]
            x, y, z = _leaf_offset(plan, arrays, f, plan.offset[3 * j], plan.offset[3 * j + 1])
            squares = _place_joint(H, 6 * plan.frame_parent[f], P, j, plan.joint_parent[j], x, y, z, squares)
    for j in range(plan.first_ball_leaf, plan.n_joints):
        f = plan.joint_frame[j]
        x, y, z = _ball_offset(arrays.Q, 9 * plan.ball[f], plan.offset[3 * j])
        squares = for_scale(plan.scale[j], P, squares)
        squares = _place_joint(H, 6 * plan.frame_parent[f], P, j, plan.joint_parent[j], x, y, z, squares)
    return weighted_sum(squares)
