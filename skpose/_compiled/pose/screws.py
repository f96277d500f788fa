"""The screws of a pose: by what motion of all points in space each dof moves the joints."""

from numba import types

from skpose._compiled.pose.forward import orient, place_joints, workspace
from skpose._compiled.pose.jacobian import rotation_axes
from skpose._compiled.pose.signatures import TREE
from skpose._compiled.simd.jit import by_address, internal
from skpose._compiled.simd.lanes import flat
from skpose._compiled.simd.signatures import MATRIX, VECTOR


@internal
def set_screws(tree, C, S, H, P, screws):
    """Compute the screw of every dof: row 6 d + i is number i of dof d's.

    The screw is the axis a and the velocity b = o × a of a point at the root, with o on the axis: the dof moves a point
    p of its frame, or of one below it, at the rate a × p + b. Of a slide a is zero, and b its direction. The six rows
    stand together: rows of lanes that are 64 apart, as those of 64 dofs would be, share one set of the processor's
    cache and drive each other out of it.
    """
    rotation_axes(tree, C, S, H, 6, screws)
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
    C, S, H, positions = workspace(tree, scratch)
    orient(tree, dofs, C, S, H)
    place_joints(tree, C, H, positions)
    for i in range(P.shape[0]):
        P[i] = positions[i]
    set_screws(tree, C, S, H, positions, flat(screws))
