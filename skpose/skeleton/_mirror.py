"""The mirror image of poses: left and right exchanged.

Let G be the rotation of a joint since angle zero, in the axes of the root, and k the partner of joint j. Its mirror
image is M G_k S_j, with M the reflection of the world and a constant reflection S_j, for which S_j d_j = d_k takes the
directions of the bones at angle zero to those of their partners: so bones point where the mirror images of their
partners do. Where the skeleton is its own mirror image at angle zero, S = M for all joints. In some files it is not:
all bones lie along x, say, and the angles of each frame make a person of them. There a joint that carries bones in
several directions shows its S. One direction leaves the twist about it open: it is by quarter turns, those that bring
the mean pose of the joint nearest to the mirror image of its partner's.
"""

from itertools import permutations, product
from typing import NamedTuple

import numpy as np
from scipy.spatial.transform import Rotation

from skpose.skeleton._bone import Bone, axes_of
from skpose.skeleton._continuity import continuous_columns
from skpose.skeleton._rest import directions_at_zero
from skpose.skeleton._root import root_orientations
from skpose.skeleton._rotations import fit_columns, rotations_of
from skpose.skeleton._sides import partners
from skpose.skeleton._skeleton import Skeleton

PARALLEL = 1e-12  # axes that differ by less are one
MISSED = 1e-3  # rad by which a mirrored rotation may miss the axes of a joint
ASYMMETRY = 45.0  # degrees between a bone and the mirror image of its partner, at angle zero
LINE = 2e-2  # second singular value over the first, below which directions are on one line
ROOT = -1
REMEDY = (
    'skpose.kinematics.retarget(motion, skeleton, method="orientations") brings the motion onto a skeleton that can be '
    'mirrored: of the same bones with dofs="rotvec", or one whose left and right are mirror images'
)
SIGNED = [np.eye(3)[list(order)] * signs for order in permutations(range(3)) for signs in product((1, -1), repeat=3)]
REFLECTIONS = [matrix for matrix in SIGNED if np.linalg.det(matrix) < 0.0]


class Mirrored(NamedTuple):
    """The mirror image of poses, and of the root."""

    poses: np.ndarray
    root_angles: np.ndarray
    root_axes: str
    world: np.ndarray  # (3,) -1 for the axis of the world across which it is, 1 for the others
    partners: list[int]  # of each joint the one on the other side


def mirror_poses(
    skeleton: Skeleton, poses: np.ndarray, root_angles: np.ndarray, root_axes: str, axis: str, up: str
) -> Mirrored:
    """Return the mirror image of poses in time, see `Motion.mirrored`."""
    if axis not in ("x", "y", "z"):
        raise ValueError(f'axis must be "x", "y" or "z", the one that points to the left or to the right, got {axis!r}')
    other = partners(skeleton.joint_names)
    _check_parents(skeleton, other)
    rest = _rest_axes(skeleton)
    world = axis if axis != up else next(letter for letter in "xyz" if letter != up)  # nobody shall be upside down
    reflections = _reflections(skeleton, poses, other, rest, axis, world)

    ends = np.cumsum([bone.n_dofs for bone in skeleton.bones])
    columns = []
    for j, k in enumerate(other):
        bone, partner = skeleton.bones[j], skeleton.bones[k]
        given = poses[:, ends[k] - partner.n_dofs : ends[k]]
        # In its own axes, B at angle zero, a joint rotates by L, and G = G_parent B L Bᵀ.
        before, after = (rest[k].T @ reflections[i] @ rest[j] for i in (int(skeleton.parents[j]), j))
        columns.append(_reflect(partner, bone, given, before, after))
    root = _mirror_root(root_angles, root_axes, _mirror_of(world), reflections[ROOT])
    return Mirrored(np.concatenate(columns, axis=1), *root, _mirror_of(world), other)


def _mirror_root(angles: np.ndarray, axes: str, world: np.ndarray, reflection: np.ndarray) -> tuple[np.ndarray, str]:
    """Return the angles of the root of which the orientation R becomes M R S, and their axes."""
    if (reflection == np.diag(world)).all():
        return angles * [-world["xyz".index(letter)] for letter in axes.lower()], axes
    orientations = root_orientations(angles, axes).as_matrix() if len(angles) else np.zeros((0, 3, 3))
    axes = axes if len(axes) == 3 else "xyz"
    if not len(angles):
        return np.zeros((0, 3)), axes
    rotations = Rotation.from_matrix(np.diag(world) @ orientations @ reflection)
    return continuous_columns(Bone("root", None, (0.0, 0.0, 0.0), axes), rotations), axes


def _mirror_of(axis: str) -> np.ndarray:
    """Return the signs (3,) of the reflection across an axis."""
    return np.where(np.arange(3) == "xyz".index(axis), -1.0, 1.0)


def _reflect(partner: Bone, bone: Bone, given: np.ndarray, before: np.ndarray, after: np.ndarray) -> np.ndarray:
    """Return columns of a joint that are the rotations Bᵀ L A of its partner, with det A = det B = −1.

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
        raise ValueError(
            f"{bone.name!r} and {partner.name!r} slide along axes that are no mirror images of each other, and have no "
            f"mirror image. {REMEDY}"
        )
    if not len(given):
        return np.zeros((0, bone.n_dofs))
    rotations = rotations_of(partner, given) if partner.n_dofs else Rotation.identity(len(given))
    rotations = Rotation.from_matrix(before.T @ rotations.as_matrix() @ after)
    if bone.n_dofs == 3:
        return continuous_columns(bone, rotations)
    if bone.n_dofs:
        columns, missed = fit_columns(bone, rotations)
    else:
        columns, missed = np.zeros((len(given), 0)), rotations.magnitude()
    worst = missed.argmax()
    if missed[worst] > MISSED:
        raise ValueError(
            f"the rotation of {partner.name!r} at frame {worst}, mirrored, misses the axes {bone.dofs!r} of "
            f"{bone.name!r} by {np.degrees(missed[worst]):.3g}°: left and right need dofs about mirrored axes. {REMEDY}"
        )
    return columns


def _rest_axes(skeleton: Skeleton) -> np.ndarray:
    """Return each joint's axes at angle zero in those of the root, (n_joints, 3, 3)."""
    rest = Rotation.from_matrix(skeleton.rest_rotations.copy()).as_matrix()  # exactly orthonormal
    for j, parent in enumerate(skeleton.parents):
        if parent >= 0:
            rest[j] = rest[parent] @ rest[j]
    return rest


def _check_parents(skeleton: Skeleton, other: list[int]) -> None:
    for j, parent in enumerate(skeleton.parents):
        expected = other[parent] if parent >= 0 else -1
        if skeleton.parents[other[j]] != expected:
            names = [*skeleton.joint_names, "the root"]
            raise ValueError(
                f"left and right must be mirror images, but {names[j]!r} is a child of {names[parent]!r} and "
                f"{names[other[j]]!r} of {names[skeleton.parents[other[j]]]!r}"
            )


def _reflections(
    skeleton: Skeleton, poses: np.ndarray, other: list[int], rest: np.ndarray, axis: str, world: str
) -> np.ndarray:
    """Return the S of each joint, and the root's as the last, (n_joints + 1, 3, 3)."""
    directions = directions_at_zero(skeleton)
    apart = {letter: _degrees_apart(directions, directions[other] * _mirror_of(letter)) for letter in "xyz"}
    if apart[axis].max() < ASYMMETRY:
        return np.tile(np.diag(_mirror_of(axis)), (skeleton.n_joints + 1, 1, 1))
    for letter, angles in apart.items():
        if angles.max() < ASYMMETRY:
            worst = apart[axis].argmax()
            name, partner = skeleton.joint_names[worst], skeleton.joint_names[other[worst]]
            raise ValueError(
                f"left and right must be mirror images across {axis} at angle zero, but the bone of {name!r} and the "
                f"mirror image of that of {partner!r} are {apart[axis][worst]:.0f}° apart: pass axis={letter!r}, "
                "across which they are"
            )
    return _fitted_reflections(skeleton, poses, other, rest, directions, world)


def _degrees_apart(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Return the angles (n,) between unit vectors (n, 3), degrees; zero where one of them is zero."""
    angles = np.degrees(np.arctan2(np.linalg.norm(np.cross(a, b), axis=1), (a * b).sum(axis=1)))
    return np.where(a.any(axis=1) & b.any(axis=1), angles, 0.0)


def _fitted_reflections(
    skeleton: Skeleton, poses: np.ndarray, other: list[int], rest: np.ndarray, directions: np.ndarray, world: str
) -> np.ndarray:
    """Return the S of each joint, and the root's as the last, where the skeleton is not its own mirror image."""
    carried = _find_carried(skeleton, directions)
    means, end = np.empty_like(rest), 0  # of each joint's rotation relative to its parent, in the axes of the root
    for j, bone in enumerate(skeleton.bones):
        columns, end = poses[:, end : end + bone.n_dofs], end + bone.n_dofs
        own = rotations_of(bone, columns).mean().as_matrix() if bone.n_dofs and len(poses) else np.eye(3)
        means[j] = rest[j] @ own @ rest[j].T
    found = np.empty((skeleton.n_joints + 1, 3, 3))
    for j in (ROOT, *range(skeleton.n_joints)):
        k = other[j] if j >= 0 else ROOT
        parent = int(skeleton.parents[j]) if j >= 0 else ROOT
        expected = np.diag(_mirror_of(world)) if j == ROOT else means[k].T @ found[parent] @ means[j]
        bones = [b for b in carried.get(j, []) if other[b] in carried.get(k, [])]
        if j >= 0 and min(skeleton.bones[j].n_dofs, skeleton.bones[k].n_dofs) < 3:
            found[j] = found[parent]  # those of few dofs have axes, which they keep
        elif bones or j != ROOT:
            found[j] = _fit(directions[bones], directions[[other[b] for b in bones]], expected, j == k)
        else:
            found[j] = expected
    for j, bones in carried.items():
        apart = _degrees_apart(directions[bones] @ found[j].T, directions[[other[b] for b in bones]])
        if len(bones) and apart.max() >= ASYMMETRY:
            name, partner = (skeleton.joint_names[i] for i in (bones[apart.argmax()], other[bones[apart.argmax()]]))
            raise ValueError(
                f"at angle zero left and right are mirror images across no axis, and the bone of {name!r} cannot be "
                f"turned to where the mirror image of that of {partner!r} points, but for {apart.max():.0f}°: too few "
                f"dofs rotate it by itself. {REMEDY}"
            )
    return found


def _find_carried(skeleton: Skeleton, directions: np.ndarray) -> dict[int, list[int]]:
    """Return the bones with a direction that rotate with the root and with each joint that has dofs."""
    mover = {ROOT: ROOT}
    carried: dict[int, list[int]] = {ROOT: []}
    for j, bone in enumerate(skeleton.bones):
        parent = int(skeleton.parents[j])
        mover[j] = j if bone.dofs else mover[parent]
        carried.setdefault(mover[j], [])
        if directions[j].any():
            carried[mover[j if skeleton.offset_frame == "own" else parent]].append(j)
    return carried


def _fit(start: np.ndarray, end: np.ndarray, expected: np.ndarray, in_the_middle: bool) -> np.ndarray:
    """Return the reflection that takes directions (n, 3) to others; where they leave it open, near to what is expected.

    That of a joint in the middle is its own inverse.
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
    if not len(start):
        return best
    axis = np.cross(best @ start, end)
    sine, cosine = np.linalg.norm(axis), end @ best @ start
    if sine == 0.0:
        return best
    return Rotation.from_rotvec(axis / sine * np.arctan2(sine, cosine)).as_matrix() @ best
