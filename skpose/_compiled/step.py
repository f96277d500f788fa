"""One step of the angles, in lanes."""

from skpose._compiled.forward import rotated
from skpose._compiled.jit import inlined
from skpose._compiled.lanes import flat, full_like, rows
from skpose._compiled.tree import Plan


@inlined
def plan_of(tree):
    """What a step reads of a tree."""
    first_moving = 1
    while first_moving < tree.joint_frame.shape[0] and tree.joint_frame[first_moving] == 0:
        first_moving += 1
    n_tips = tree.frame_parent.shape[0] - tree.first_frame[-1]
    return Plan(
        tree.column.shape[0],
        tree.batch_dofs.shape[0],
        first_moving,
        tree.offset.shape[0] - n_tips,
        tree.offset.shape[0],
        flat(tree.frame_parent),
        flat(tree.first_dof),
        flat(tree.end_dof),
        flat(tree.fixed_axis),
        flat(tree.fixed_turn),
        flat(tree.batch_dofs),
        flat(tree.first_frame),
        flat(tree.joint_parent),
        flat(tree.joint_frame),
        flat(tree.offset),
    )


@inlined
def parts_of(tree, scratch):
    """The parts of a scratch array that a step works in, the root's frame and position set.

    Cosines C and sines S of the angles, A = 1 - cos δ and B = sin δ of the step, (n_dofs,) each; two rows of every
    orientation, H, (6 n_frames,); positions P, (3 n_joints + 3,).
    """
    n, h = tree.column.shape[0], 6 * tree.frame_parent.shape[0]
    H, P = rows(scratch, 4 * n), rows(scratch, 4 * n + h)
    for i in range(6):
        H[i] = 1.0 if i % 4 == 0 else 0.0
    for i in range(3):
        P[i] = 0.0
    return rows(scratch, 0), rows(scratch, n), rows(scratch, 2 * n), rows(scratch, 3 * n), H, P


@inlined
def _turn_batch(n_dofs, first, last, plan, C, S, H):
    """Orientations of frames that have equally many dofs."""
    for f in range(first, last):
        before, row, d = 6 * plan.frame_parent[f], 6 * f, plan.end_dof[f] - 1
        cx, sx = C[d], S[d]
        cy, sy, cz, sz = cx, sx, cx, sx
        if n_dofs > 1:
            cy, sy = C[d - 1], S[d - 1]
        if n_dofs > 2:
            cz, sz = C[d - 2], S[d - 2]
        for i in range(0, 6, 3):
            x, y, z = H[before + i], H[before + i + 1], H[before + i + 2]
            if n_dofs > 2:
                x, y = rotated(x, y, cz, sz)
            if n_dofs > 1:
                z, x = rotated(z, x, cy, sy)
            y, z = rotated(y, z, cx, sx)
            H[row + i], H[row + i + 1], H[row + i + 2] = x, y, z


@inlined
def _turn_fixed(first, last, plan, H):
    """Orientations of frames without dofs."""
    for f in range(first, last):
        before, row, a = 6 * plan.frame_parent[f], 6 * f, plan.fixed_axis[f]
        b, c = (a + 1) % 3, (a + 2) % 3
        cos, sin = plan.fixed_turn[4 * f], plan.fixed_turn[4 * f + 1]
        for i in range(0, 6, 3):
            u, v = rotated(H[before + i + b], H[before + i + c], cos, sin)
            H[row + i + a], H[row + i + b], H[row + i + c] = H[before + i + a], u, v


@inlined
def _move(P, j, p, value, square):
    """Put one coordinate of a joint, its parent's plus a value; add its squared move."""
    new = P[p] + value
    move = new - P[j]
    P[j] = new
    return square + move * move


@inlined
def _reach(H, h, P, j, p, x, y, z, squares):
    """Put joint j at (x, y, z), in the frame at row h, from joint p; add its squared move."""
    a, b, c, d, e, f = H[h], H[h + 1], H[h + 2], H[h + 3], H[h + 4], H[h + 5]
    first = _move(P, 3 * j, 3 * p, a * x + b * y + c * z, squares[0])
    second = _move(P, 3 * j + 1, 3 * p + 1, d * x + e * y + f * z, squares[1])
    third = (b * f - c * e) * x + (c * d - a * f) * y + (a * e - b * d) * z
    return first, second, _move(P, 3 * j + 2, 3 * p + 2, third, squares[2])


@inlined
def take_step(plan, C, S, A, B, H, P):
    """Turn all angles by one step and place the joints; return the squared distance that these moved."""
    for d in range(plan.n_dofs):
        c, s, a, b = C[d], S[d], A[d], B[d]
        C[d], S[d] = c - a * c - b * s, s - a * s + b * c
    for b in range(plan.n_batches):
        n_dofs, first, last = plan.batch_dofs[b], plan.first_frame[b], plan.first_frame[b + 1]
        # A number that is written out folds the branches on it away.
        if n_dofs == 3:
            _turn_batch(3, first, last, plan, C, S, H)
        elif n_dofs == 2:
            _turn_batch(2, first, last, plan, C, S, H)
        elif n_dofs == 1:
            _turn_batch(1, first, last, plan, C, S, H)
        else:
            _turn_fixed(first, last, plan, H)
    nought = full_like(P, 0.0)
    squares = nought, nought, nought  # by coordinate: three sums, so that an addition need not await the last one
    for j in range(plan.first_moving, plan.first_tip):
        x, y, z = plan.offset[3 * j], plan.offset[3 * j + 1], plan.offset[3 * j + 2]
        squares = _reach(H, 6 * plan.joint_frame[j], P, j, plan.joint_parent[j], x, y, z, squares)
    for j in range(plan.first_tip, plan.n_joints):
        f = plan.joint_frame[j]
        d, n_dofs = plan.end_dof[f] - 1, plan.end_dof[f] - plan.first_dof[f]
        x, y, z = full_like(P, plan.offset[3 * j]), C[d] * plan.offset[3 * j + 1], S[d] * plan.offset[3 * j + 1]
        if n_dofs > 1:
            x, z = rotated(x, z, C[d - 1], S[d - 1])
        if n_dofs > 2:
            y, x = rotated(y, x, C[d - 2], S[d - 2])
        squares = _reach(H, 6 * plan.frame_parent[f], P, j, plan.joint_parent[j], x, y, z, squares)
    return squares[0] + squares[1] + squares[2]
