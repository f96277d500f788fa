"""Forward kinematics with every frame as a whole rotation matrix: of one pose, or of one pose in each lane."""

import math

from skpose._compiled.pose.rotation import product, quaternion_at, quaternion_of, turn_back
from skpose._compiled.simd.jit import inlined, internal
from skpose._compiled.simd.lanes import rows
from skpose._compiled.simd.trigonometry import cosine_sine

SQRT2 = math.sqrt(2.0)


@internal
def workspace_rows(tree):
    """The number of rows of the scratch array that all kernels share."""
    return 4 * tree.column.shape[0] + 9 * tree.frame_parent.shape[0] + 3 * tree.offset.shape[0]


@internal
def workspace(tree, scratch):
    """The rows of a scratch array of shape (workspace_rows,), or (workspace_rows, lanes).

    Cosines C and sines S of the angles, n_dofs rows each; orientations H, 9 n_frames rows, the root's set to the
    identity; positions P, 3 n_joints + 3 rows, the root's set to zero.
    """
    n, h = tree.column.shape[0], 9 * tree.frame_parent.shape[0]
    H, P = rows(scratch, 2 * n), rows(scratch, 2 * n + h)
    for i in range(9):
        H[i] = 1.0 if i % 4 == 0 else 0.0
    for i in range(3):
        P[i] = 0.0
    return rows(scratch, 0), rows(scratch, n), H, P


@inlined
def size_of(tree):
    """The sum of all offsets along the axes, times the largest scale, m: the unit of rounding errors of lengths."""
    total, largest = 0.0, 0.0
    for j in range(tree.offset.shape[0]):
        largest = max(largest, tree.scale[j])
        for i in range(3):
            total += abs(tree.offset[j, i])
    return total * largest


@inlined
def rotate(u, v, c, s):
    """Rotate the two columns of a matrix that a rotation about the third axis mixes."""
    return c * u + s * v, c * v - s * u


@internal
def frame_quaternion(tree, dofs, f):
    """The rotation of a ball joint's frame from its parent's, as a unit quaternion."""
    d = tree.first_dof[f]
    return product(quaternion_at(tree.reference, f), quaternion_of(dofs[d], dofs[d + 1], dofs[d + 2]))


@internal
def orient(tree, dofs, C, S, H):
    """Compute the world orientation H of every frame, row by row, from dofs in the tree's order.

    C and S are the cosines and sines of the angles; C also holds the dofs of ball joints and slides.
    """
    for f in range(1, tree.frame_parent.shape[0]):
        p, a, end = tree.frame_parent[f], tree.single_axis[f], tree.end_dof[f]
        if tree.ball[f] >= 0:
            w, u, v, t = frame_quaternion(tree, dofs, f)
            q = SQRT2 * w, SQRT2 * u, SQRT2 * v, SQRT2 * t
            for i in range(0, 9, 3):
                row, before = 9 * f + i, 9 * p + i
                H[row], H[row + 1], H[row + 2] = turn_back((H[before], H[before + 1], H[before + 2]), q)
            for d in range(tree.first_dof[f], end):
                C[d] = dofs[d]
            continue
        if tree.slide[f] >= 0:
            C[end - 1] = dofs[end - 1]
            for i in range(9):
                H[9 * f + i] = H[9 * p + i]
            continue
        for d in range(tree.first_dof[f], end):
            C[d], S[d] = cosine_sine(dofs[d] + tree.shift[d])
        b, c = (a + 1) % 3, (a + 2) % 3
        n_dofs = end - tree.first_dof[f]
        for i in range(0, 9, 3):
            row, before = 9 * f + i, 9 * p + i
            if n_dofs < 2:
                u, v = H[before + b], H[before + c]
                H[row + a] = H[before + a]
                if n_dofs == 1:
                    H[row + b], H[row + c] = rotate(u, v, C[end - 1], S[end - 1])
                else:
                    H[row + b], H[row + c] = rotate(u, v, tree.fixed_rotation[f, 0], tree.fixed_rotation[f, 1])
                continue
            x, y, z = H[before], H[before + 1], H[before + 2]
            if n_dofs > 2:
                x, y = rotate(x, y, C[end - 3], S[end - 3])
            z, x = rotate(z, x, C[end - 2], S[end - 2])
            y, z = rotate(y, z, C[end - 1], S[end - 1])
            H[row], H[row + 1], H[row + 2] = x, y, z


@inlined
def slide_direction(tree, H, k, row, i):
    """Coordinate i of the direction of slide k in the world, whose frame's orientation is at this row."""
    h = row + 3 * i
    return H[h] * tree.slide_axis[k, 0] + H[h + 1] * tree.slide_axis[k, 1] + H[h + 2] * tree.slide_axis[k, 2]


@internal
def place_joints(tree, C, H, P):
    """Compute the joint positions P from the frames H, and slides from C; the root's is unchanged."""
    for j in range(1, tree.offset.shape[0]):
        p, f = 3 * tree.joint_parent[j], 9 * tree.joint_frame[j]
        x, y, z = tree.offset[j, 0], tree.offset[j, 1], tree.offset[j, 2]
        for i in range(3):
            h = f + 3 * i
            P[3 * j + i] = P[p + i] + (H[h] * x + H[h + 1] * y + H[h + 2] * z)
        if tree.joint_slide[j] >= 0:
            k = tree.joint_slide[j]
            for i in range(3):
                P[3 * j + i] = P[3 * j + i] + slide_direction(tree, H, k, f, i) * C[tree.slide_dof[k]]


@internal
def place(tree, dofs, scratch, P):
    """Compute the joint positions of one pose, dofs in the tree's order."""
    C, S, H, positions = workspace(tree, scratch)
    orient(tree, dofs, C, S, H)
    place_joints(tree, C, H, positions)
    for i in range(P.shape[0]):
        P[i] = positions[i]
