"""The Jacobian of the joint positions, in closed form."""

import numpy as np
from numba import types

from skpose._compiled.pose.forward import place, rotate, slide_direction, workspace, workspace_rows
from skpose._compiled.pose.rotation import right_jacobian
from skpose._compiled.pose.signatures import TREE
from skpose._compiled.simd.jit import by_address, internal, jit
from skpose._compiled.simd.lanes import flat
from skpose._compiled.simd.signatures import MATRIX, VECTOR


@internal
def _rotation_axes(tree, C, S, H, axes):
    """Compute the axis of every dof in world coordinates, the velocity of the rotation, of length one.

    Row 6 d + i of the axes is coordinate i of dof d's.

    The axes of a ball joint's dofs, its rotation vector, are of other lengths: the columns of the orientation times Jr.
    A slide rotates nothing: instead of an axis it has the direction of its displacement.
    """
    for f in range(1, tree.frame_parent.shape[0]):
        end = tree.end_dof[f]
        if tree.ball[f] >= 0:
            first = end - 3
            p, q, r = right_jacobian(C[first], C[first + 1], C[first + 2])
            for i in range(3):
                x, y, z = H[9 * f + 3 * i], H[9 * f + 3 * i + 1], H[9 * f + 3 * i + 2]
                for d in range(3):
                    axes[6 * (first + d) + i] = x * p[d] + y * q[d] + z * r[d]
            continue
        if tree.slide[f] >= 0:
            for i in range(3):
                axes[6 * (end - 1) + i] = slide_direction(tree, H, tree.slide[f], 9 * f, i)
            continue
        n_dofs = end - tree.first_dof[f]
        if n_dofs == 1:
            for i in range(3):
                axes[6 * (end - 1) + i] = H[9 * f + 3 * i + tree.single_axis[f]]
            continue
        for i in range(3 if n_dofs > 0 else 0):
            # The columns of H are the axes after all the rotations; undo these, the last one first.
            x, y, z = H[9 * f + 3 * i], H[9 * f + 3 * i + 1], H[9 * f + 3 * i + 2]
            axes[6 * (end - 1) + i] = x
            y, z = rotate(y, z, C[end - 1], 0.0 - S[end - 1])
            axes[6 * (end - 2) + i] = y
            if n_dofs > 2:
                z, x = rotate(z, x, C[end - 2], 0.0 - S[end - 2])
                axes[6 * (end - 3) + i] = z


@internal
def set_screws(tree, C, S, H, P, screws):
    """Compute the screw of every dof: row 6 d + i is number i of dof d's.

    The screw is the axis a and the velocity b = o × a of a point at the root, with o on the axis: the dof moves a point
    p of its frame, or of one below it, at the rate a × p + b. Of a slide a is zero, and b its direction. The six rows
    stand together: rows of lanes that are 64 apart, as those of 64 dofs would be, share one set of the processor's
    cache and drive each other out of it.
    """
    _rotation_axes(tree, C, S, H, screws)
    for f in range(1, tree.frame_parent.shape[0]):
        o = 3 * tree.pivot[f]
        for d in range(tree.first_dof[f], tree.end_dof[f]):
            k = 6 * d
            x, y, z = screws[k], screws[k + 1], screws[k + 2]
            if tree.slide[f] >= 0:
                for i in range(3):
                    screws[k + 3 + i] = screws[k + i]
                    screws[k + i] = 0.0
                continue
            screws[k + 3] = P[o + 1] * z - P[o + 2] * y
            screws[k + 4] = P[o + 2] * x - P[o] * z
            screws[k + 5] = P[o] * y - P[o + 1] * x


@by_address(lambda: types.void(TREE, VECTOR, VECTOR, VECTOR, MATRIX))
def place_with_screws(tree, dofs, scratch, P, screws):
    """Compute the joint positions of one pose, and the screws of its dofs, (n_dofs, 6)."""
    place(tree, dofs, scratch, P)
    C, S, H, positions = workspace(tree, scratch)
    set_screws(tree, C, S, H, positions, flat(screws))


@internal
def write_jacobian(tree, pose, scratch, jacobian):
    """Compute ∂F/∂θ of one pose, (3 n_joints, n_dofs), of the scaled positions; zeros are not written."""
    P, screws = np.empty(3 * tree.offset.shape[0]), np.empty((pose.shape[0], 6))
    place_with_screws(tree, pose, scratch, P, screws)
    for j in range(1, tree.offset.shape[0]):
        row, f, scale = 3 * tree.code_joint[j] - 3, tree.joint_frame[j], tree.scale[j]
        x, y, z = P[3 * j], P[3 * j + 1], P[3 * j + 2]
        for r in range(tree.first_dof_range[f], tree.first_dof_range[f + 1]):
            for d in range(tree.dof_ranges[r, 0], tree.dof_ranges[r, 1]):
                a, b, c, u, v, w = screws[d]
                jacobian[row, d] = scale * (b * z - c * y + u)
                jacobian[row + 1, d] = scale * (c * x - a * z + v)
                jacobian[row + 2, d] = scale * (a * y - b * x + w)


@jit
def position_jacobians(poses, tree, jacobians):
    """Compute ∂F/∂θ of every pose, (n_poses, 3 n_joints, n_dofs), both in the tree's order of dofs."""
    scratch = np.empty(workspace_rows(tree))
    jacobians[:] = 0.0
    for n in range(poses.shape[0]):
        write_jacobian(tree, poses[n], scratch, jacobians[n])
