"""The mirror image of poses: left and right exchanged.

Let G be the rotation of a joint since angle zero, in the axes of the root, and k the partner of joint j. The mirror
image of G is M G_k S_j, with the reflection M of the world and a constant reflection S_j. S_j takes the directions of
the bones at angle zero to their partners' directions, S_j d_j = d_k, so that bones point to the mirror images of their
partners. If the skeleton is its own mirror image at angle zero, S = M for all joints. Some files are not: all bones lie
along x, for example, and the angles of each frame form the person. There the bones that a joint carries show its S if
they point in several directions. A single direction leaves the twist about it open: it is chosen by quarter turns that
bring the mean pose of the joint nearest to the mirror image of its partner's.
"""

from itertools import permutations, product

import numpy as np
from scipy.spatial.transform import Rotation

from skpose._utils.validation import check_choice
from skpose.skeleton._bone import Bone, axes_of, with_columns
from skpose.skeleton._rest import NOWHERE, ROOT, axes_at_zero, degrees_between, directions_at_zero, find_carriers
from skpose.skeleton._root import continuous_root_angles, root_orientations
from skpose.skeleton._rotations import continuous_columns, fit_columns, rotations_of
from skpose.skeleton._sides import partners
from skpose.skeleton._skeleton import Skeleton

PARALLEL = 1e-12  # axes that differ by less are one
MISSED = 1e-3  # rad by which a mirrored rotation may miss the axes of a joint
ASYMMETRY = 45.0  # degrees between a bone and the mirror image of its partner, at angle zero
LINE = 2e-2  # second singular value over the first; directions with less are on one line
REFLECTIONS = [
    matrix
    for order, signs in product(permutations(range(3)), product((1, -1), repeat=3))
    if np.linalg.det(matrix := np.eye(3)[list(order)] * signs) < 0.0
]


def mirror_poses(
    skeleton: Skeleton, poses: np.ndarray, root_angles: np.ndarray, root_axes: str, axis: str, up: str
) -> tuple[np.ndarray, np.ndarray, str, np.ndarray, list[int]]:
    """The mirror image of poses in time, see `Motion.mirrored`: poses, angles of the root, and their axes.

    Also the signs (3,), -1 for the mirrored axis of the world, and the joint on the other side of each.
    """
    check_choice("axis", axis, ("x", "y", "z"))
    other = partners(skeleton.joint_names)
    for j, parent in enumerate(skeleton.parents):
        if skeleton.parents[other[j]] != (other[parent] if parent >= 0 else ROOT):
            names = skeleton.joint_names[j], skeleton.joint_names[other[j]]
            raise ValueError(
                f"left and right must be mirror images, but {names[0]!r} and {names[1]!r} differ in parents"
            )
    rest = Rotation.from_matrix(axes_at_zero(skeleton)).as_matrix()  # of rotations written with a few digits, too
    world = axis if axis != up else next(letter for letter in "xyz" if letter != up)  # not upside down
    reflections = _reflections(skeleton, poses, other, rest, axis, world)

    each = list(with_columns(skeleton.bones))
    columns = []
    for j, k in enumerate(other):
        (bone, _), (partner, at) = each[j], each[k]
        # In its own axes, B at angle zero, a joint rotates by L, and G = G_parent B L Bᵀ.
        before, after = (rest[k].T @ reflections[i] @ rest[j] for i in (int(skeleton.parents[j]), j))
        columns.append(_reflect(partner, bone, poses[:, at], before, after))
    root = _mirror_root(root_angles, root_axes, _mirror_of(world), reflections[ROOT])
    return np.concatenate(columns, axis=1), *root, _mirror_of(world), other


def _mirror_root(angles: np.ndarray, axes: str, world: np.ndarray, reflection: np.ndarray) -> tuple[np.ndarray, str]:
    """The angles of the root whose orientation R becomes M R S, and their axes."""
    if (reflection == np.diag(world)).all():
        return angles * [-world["xyz".index(letter)] for letter in axes.lower()], axes
    if not len(angles):
        return angles, axes
    rotations = Rotation.from_matrix(np.diag(world) @ root_orientations(angles, axes).as_matrix() @ reflection)
    return continuous_root_angles(rotations, axes)


def _mirror_of(axis: str) -> np.ndarray:
    """The signs (3,) of the reflection across an axis."""
    return np.where(np.arange(3) == "xyz".index(axis), -1.0, 1.0)


def _reflect(partner: Bone, bone: Bone, given: np.ndarray, before: np.ndarray, after: np.ndarray) -> np.ndarray:
    """The columns of a joint for the rotations Bᵀ L A of its partner, with det A = det B = −1.

    A displacement d of a slide becomes Aᵀ d.
    """
    if (before == after).all():
        if bone.is_ball and partner.is_ball:
            return -given @ after
        if bone.n_dofs == partner.n_dofs and not bone.is_ball and not partner.is_ball:
            # Aᵀ takes a rotation about n to one about Aᵀn, by the opposite angle: the same axes in the same order?
            signs = np.einsum("da,ab,db->d", axes_of(partner), after, axes_of(bone))
            same_order = partner.dofs.islower() == bone.dofs.islower() and partner.is_slide == bone.is_slide
            if same_order and (np.abs(np.abs(signs) - 1.0) < PARALLEL).all():
                return np.sign(signs) * (given if bone.is_slide else -given)
    if bone.is_slide or partner.is_slide:
        raise ValueError(f"{bone.name!r} and {partner.name!r} slide along axes that are not mirror images")
    if not len(given):
        return np.zeros((0, bone.n_dofs))
    rotations = rotations_of(partner, given) if partner.n_dofs else Rotation.identity(len(given))
    rotations = Rotation.from_matrix(before.T @ rotations.as_matrix() @ after)
    if bone.n_dofs == 3:
        return continuous_columns(bone, rotations)
    columns, missed = fit_columns(bone, rotations)
    if missed.max() > MISSED:
        degrees = np.degrees(missed.max())
        raise ValueError(
            f"{partner.name!r}, mirrored, misses the axes of {bone.name!r} by {degrees:.3g}°: use to_rotvec()"
        )
    return columns


def _reflections(
    skeleton: Skeleton, poses: np.ndarray, other: list[int], rest: np.ndarray, axis: str, world: str
) -> np.ndarray:
    """The S of each joint, and the root's as the last, (n_joints + 1, 3, 3)."""
    directions = directions_at_zero(skeleton)
    off = {letter: degrees_between(directions, directions[other] * _mirror_of(letter)).max() for letter in "xyz"}
    if off[axis] < ASYMMETRY:
        return np.tile(np.diag(_mirror_of(axis)), (skeleton.n_joints + 1, 1, 1))
    fitting = [letter for letter in "xyz" if off[letter] < ASYMMETRY]
    if fitting:
        raise ValueError(f"left and right are not mirror images across {axis} at angle zero: pass axis={fitting[0]!r}")
    carriers = np.where(directions.any(axis=1), find_carriers(skeleton), NOWHERE)
    carried = {j: np.flatnonzero(carriers == j).tolist() for j in (ROOT, *range(skeleton.n_joints))}
    means = np.empty_like(rest)  # of each joint's rotation relative to its parent, in the axes of the root
    for j, (bone, columns) in enumerate(with_columns(skeleton.bones)):
        own = rotations_of(bone, poses[:, columns]).mean().as_matrix() if bone.n_dofs and len(poses) else np.eye(3)
        means[j] = rest[j] @ own @ rest[j].T
    found = np.empty((skeleton.n_joints + 1, 3, 3))
    for j in (ROOT, *range(skeleton.n_joints)):
        k = other[j] if j >= 0 else ROOT
        parent = int(skeleton.parents[j]) if j >= 0 else ROOT
        expected = np.diag(_mirror_of(world)) if j == ROOT else means[k].T @ found[parent] @ means[j]
        bones = [b for b in carried[j] if other[b] in carried[k]]
        if j >= 0 and min(skeleton.bones[j].n_dofs, skeleton.bones[k].n_dofs) < 3:
            found[j] = found[parent]  # joints with few dofs keep their axes
        else:
            found[j] = _fit(directions[bones], directions[[other[b] for b in bones]], expected, j == k)
    for j, bones in carried.items():
        apart = degrees_between(directions[bones] @ found[j].T, directions[[other[b] for b in bones]])
        if len(bones) and apart.max() >= ASYMMETRY:
            name = skeleton.joint_names[bones[apart.argmax()]]
            raise ValueError(f"the bone of {name!r} misses the mirror image of its partner by {apart.max():.0f}°")
    return found


def _fit(start: np.ndarray, end: np.ndarray, expected: np.ndarray, in_the_middle: bool) -> np.ndarray:
    """The reflection that takes directions (n, 3) to others; if ambiguous, the one nearest to the expected one.

    For a joint in the middle it is its own inverse.
    """
    if len(start):
        u, values, vh = np.linalg.svd(end.T @ start)
        if values[1] > LINE * values[0]:
            return (u * [1.0, 1.0, -np.linalg.det(u @ vh)]) @ vh
        start, end = vh[0], u[:, 0]
    choices = [s for s in REFLECTIONS if not in_the_middle or (s == s.T).all()]
    near = [s for s in choices if not len(start) or end @ s @ start > np.cos(np.radians(ASYMMETRY))]
    simple = [s for s in near if np.abs(s.diagonal()).sum() == 3.0]
    best = max(simple or near or choices, key=lambda s: (s * expected).sum() + (0.0 if near else 9.0 * end @ s @ start))
    return Rotation.align_vectors(end, best @ start)[0].as_matrix() @ best if len(start) else best
