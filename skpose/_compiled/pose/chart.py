"""Coordinates in which paths are found: joints with three dofs turn freely.

Three Euler angles reach every rotation, but badly: close rotations may have far angles. So a path is found in a tree
whose frames with three dofs are all ball joints. The reference of each lies half-way between its rotations at the start
and at the end. Its coordinates, a rotation vector, are opposite there, and the straight line between is the slerp.
"""

import math

import numpy as np

from skpose._compiled.pose.forward import frame_quaternion
from skpose._compiled.pose.rotation import (
    canonical,
    inverse,
    inverse_jacobian,
    product,
    put_quaternion,
    quaternion_at,
    quaternion_of,
    sign_towards,
    vector_of,
)
from skpose._compiled.pose.signatures import TREE
from skpose._compiled.pose.tree import TWO_PI
from skpose._compiled.simd.jit import by_address, internal, jit
from skpose._compiled.simd.shared import replace
from skpose._compiled.simd.signatures import FLAG

GIMBAL = 1e-14  # cosine of the second Euler angle below which the first one is free; larger, rotations would change
FARTHEST = 1.5 * math.pi  # rotation vectors are at their best near zero, and useless at 2π
NO_TURN = 1e-12  # smaller rotations are rounding errors and have no axis, rad


@by_address(lambda: TREE(TREE, FLAG))
def free_tree(tree, frees_angles):
    """The tree with references of its own; with its frames of three angles as ball joints, if so asked."""
    ball, reference = tree.ball.copy(), tree.reference.copy()
    for f in range(ball.shape[0]):
        if frees_angles and tree.end_dof[f] - tree.first_dof[f] == 3:
            ball[f] = max(ball[f], 0)
    return replace(replace(tree, "ball", ball), "reference", reference)


@internal
def keep_bounded(tree, free, lower, upper):
    """Exclude frames of three angles, one of them with a bound, from the ball joints of a free tree."""
    for f in range(1, tree.ball.shape[0]):
        for d in range(tree.first_dof[f], tree.end_dof[f]):
            if tree.ball[f] < 0 and (lower[d] > -math.inf or upper[d] < math.inf):
                free.ball[f] = -1


@internal
def rotation_of(tree, dofs, f):
    """The rotation of a frame with three dofs, as a canonical quaternion."""
    if tree.ball[f] >= 0:
        return canonical(frame_quaternion(tree, dofs, f))
    d = tree.first_dof[f]
    z = quaternion_of(0.0, 0.0, dofs[d] + tree.shift[d])
    y = quaternion_of(0.0, dofs[d + 1] + tree.shift[d + 1], 0.0)
    x = quaternion_of(dofs[d + 2] + tree.shift[d + 2], 0.0, 0.0)
    return canonical(product(product(z, y), x))


@internal
def set_references(tree, free, start, end):
    """Let the references of a free tree be half-way between two poses."""
    for f in range(1, tree.frame_parent.shape[0]):
        if free.ball[f] >= 0:
            p, q = rotation_of(tree, start, f), rotation_of(tree, end, f)
            sign = sign_towards(p, q)
            w, x, y, z = p[0] + sign * q[0], p[1] + sign * q[1], p[2] + sign * q[2], p[3] + sign * q[3]
            size = math.sqrt(w * w + x * x + y * y + z * z)
            put_quaternion((w / size, x / size, y / size, z / size), free.reference, f)


@internal
def coordinates_of(tree, free, dofs, out):
    """Compute the coordinates of a pose: rotation vectors no longer than half a turn, and angles as they are."""
    for f in range(1, tree.frame_parent.shape[0]):
        first = tree.first_dof[f]
        if free.ball[f] >= 0:
            p, q = quaternion_at(free.reference, f), rotation_of(tree, dofs, f)
            sign = sign_towards(p, q)
            w, x, y, z = product(inverse(p), q)
            out[first], out[first + 1], out[first + 2] = vector_of((sign * w, sign * x, sign * y, sign * z))
        else:
            for d in range(first, tree.end_dof[f]):
                out[d] = dofs[d]


@internal
def _euler_angles(rotation, near, out):
    """Compute the angles of Rz·Ry·Rx, of this rotation, nearest to other angles."""
    w, x, y, z = rotation
    a, b = 1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y + w * z)  # first two numbers of the matrix's first column
    first = math.atan2(b, a) if math.hypot(a, b) > GIMBAL else near[0]
    cos, sin = math.cos(first), math.sin(first)
    second = math.atan2(-2.0 * (x * z - w * y), cos * a + sin * b)
    third = math.atan2(
        sin * 2.0 * (x * z + w * y) - cos * 2.0 * (y * z - w * x),
        cos * (1.0 - 2.0 * (x * x + z * z)) - sin * 2.0 * (x * y - w * z),
    )
    nearest = math.inf
    for angles in ((first, second, third), (first + math.pi, math.pi - second, third + math.pi)):
        one = angles[0] - TWO_PI * np.rint((angles[0] - near[0]) / TWO_PI)
        two = angles[1] - TWO_PI * np.rint((angles[1] - near[1]) / TWO_PI)
        three = angles[2] - TWO_PI * np.rint((angles[2] - near[2]) / TWO_PI)
        far = (one - near[0]) ** 2 + (two - near[1]) ** 2 + (three - near[2]) ** 2
        if far < nearest:
            nearest = far
            out[0], out[1], out[2] = one, two, three


@internal
def dofs_of(tree, free, coordinates, near, out):
    """Invert `coordinates_of`; of the numbers that are one rotation, those nearest to another pose's."""
    angles, found = np.empty(3), np.empty(3)
    for f in range(1, tree.frame_parent.shape[0]):
        first = tree.first_dof[f]
        if free.ball[f] < 0:
            for d in range(first, tree.end_dof[f]):
                out[d] = coordinates[d]
            continue
        rotation = frame_quaternion(free, coordinates, f)
        if tree.ball[f] >= 0:
            out[first], out[first + 1], out[first + 2] = vector_of(
                product(inverse(quaternion_at(tree.reference, f)), rotation)
            )
            follow(near[first : first + 3], out[first : first + 3])
            continue
        for i in range(3):
            angles[i] = near[first + i] + tree.shift[first + i]
        _euler_angles(rotation, angles, found)
        for i in range(3):
            out[first + i] = found[i] - tree.shift[first + i]


@jit
def pose_of(tree, free, coordinates, near):
    """The pose of coordinates; of the numbers that are one rotation, those nearest to another pose's."""
    pose = np.empty(coordinates.shape[0])
    dofs_of(tree, free, coordinates, near, pose)
    return pose


@jit
def chart_at(tree, pose, frees_angles):
    """The free tree whose references are a pose, and the coordinates of the pose."""
    free, coordinates = free_tree(tree, frees_angles), np.empty(pose.shape[0])
    set_references(tree, free, pose, pose)
    coordinates_of(tree, free, pose, coordinates)
    return free, coordinates


@internal
def slopes_of_turns(free, coordinates, slopes):
    """Make derivatives by the coordinates of a pose those by its coordinates in a chart at the pose itself."""
    for f in range(1, free.frame_parent.shape[0]):
        if free.ball[f] >= 0:
            i = free.first_dof[f]
            v, s = coordinates[i : i + 3], slopes[i : i + 3]
            s[0], s[1], s[2] = inverse_jacobian((v[0], v[1], v[2]), (s[0], s[1], s[2]), -0.5)


@internal
def differs(tree, free):
    """Whether frames of three angles are ball joints in the free tree: then there are two straight lines."""
    n_free = 0
    for f in range(free.ball.shape[0]):
        n_free += free.ball[f] >= 0 and tree.ball[f] < 0
    return n_free > 0


@internal
def line_of_angles(tree, free, start, end, path):
    """Compute the coordinates of poses on the straight line of angles; return whether they are well within a turn.

    Ball joints follow their slerp.
    """
    last, dofs = path.shape[0] - 1, start.copy()
    begin, target = np.empty(start.shape[0]), np.empty(start.shape[0])
    coordinates_of(tree, free, start, begin)
    coordinates_of(tree, free, end, target)
    within = True
    for i in range(path.shape[0]):
        for d in range(dofs.shape[0]):
            dofs[d] = start[d] + (i / last) * (end[d] - start[d])
        coordinates_of(tree, free, dofs, path[i])
        for f in range(1, tree.frame_parent.shape[0]):
            first = tree.first_dof[f]
            if tree.ball[f] >= 0:
                for d in range(first, first + 3):
                    path[i, d] = begin[d] + (i / last) * (target[d] - begin[d])
            elif free.ball[f] >= 0 and i > 0:
                within = follow(path[i - 1, first : first + 3], path[i, first : first + 3]) and within
    return within


@internal
def follow(before, vector):
    """Write a rotation vector as the one of its rotation that is nearest to the one before; return if it is short."""
    size, along = 0.0, 0.0
    for i in range(3):
        size += vector[i] * vector[i]
        along += vector[i] * before[i]
    size = math.sqrt(size)
    if size < NO_TURN:  # whole turns are about the axis of the vector before
        size = math.sqrt(before[0] ** 2 + before[1] ** 2 + before[2] ** 2)
        turns = np.rint(size / TWO_PI)
        if turns > 0.0:
            for i in range(3):
                vector[i] = turns * TWO_PI / size * before[i]
        return turns == 0.0
    turns = np.rint((along / size - size) / TWO_PI)
    for i in range(3):
        vector[i] *= 1.0 + turns * TWO_PI / size
    return abs(size + turns * TWO_PI) < FARTHEST
