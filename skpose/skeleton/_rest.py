"""The rest pose of a skeleton: its bones at angle zero. Equal numbers are different poses if rest poses differ."""

from collections.abc import Sequence

import numpy as np

from skpose._utils.validation import SkeletonLike

ROOT = -1  # the index of the root
NOWHERE = -2  # of no joint
NO_DIRECTION = 1e-3  # share of the longest bone: a shorter one, or none, has no direction


def unit(vectors: np.ndarray) -> np.ndarray:
    """Normalise vectors (..., 3); zeros stay zero, and NaN stays NaN."""
    sizes = np.linalg.norm(vectors, axis=-1, keepdims=True)
    return np.divide(vectors, sizes, out=np.zeros_like(vectors), where=sizes != 0.0)


def degrees_between(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """The angles between vectors (..., 3), degrees; zero if one of them is zero."""
    p, q = a * np.linalg.norm(b, axis=-1, keepdims=True), b * np.linalg.norm(a, axis=-1, keepdims=True)
    return np.asarray(np.degrees(2.0 * np.arctan2(np.linalg.norm(p - q, axis=-1), np.linalg.norm(p + q, axis=-1))))


def axes_at_zero(skeleton: SkeletonLike) -> np.ndarray:
    """The axes (n_joints, 3, 3) of each joint at angle zero, in the root's axes."""
    axes = np.empty((skeleton.n_joints + 1, 3, 3))  # the last is the root's, whose index is -1
    axes[-1] = np.eye(3)
    for j, (parent, rest) in enumerate(zip(skeleton.parents, skeleton.rest_rotations, strict=True)):
        axes[j] = axes[parent] @ rest
    return axes[:-1]


def _axes_of_offsets(skeleton: SkeletonLike) -> np.ndarray:
    axes = axes_at_zero(skeleton)
    if skeleton.offset_frame == "parent":
        axes = np.concatenate([axes, np.eye(3)[None]])[skeleton.parents]
    return axes


def directions_at_zero(skeleton: SkeletonLike) -> np.ndarray:
    """The direction (n_joints, 3) of each bone at angle zero, in the axes of the root; zeros without length."""
    lengths = np.linalg.norm(skeleton.offsets, axis=1)
    has_one = lengths > NO_DIRECTION * lengths.max()
    units = np.where(has_one[:, None], skeleton.offsets / np.where(has_one, lengths, 1.0)[:, None], 0.0)
    return np.einsum("jab,jb->ja", _axes_of_offsets(skeleton), units)


def size_of(skeleton: SkeletonLike) -> float:
    """The longest edge of the box around the joints and the root at angle zero."""
    return float(np.ptp(positions_at_zero(skeleton), axis=0).max())


def positions_at_zero(skeleton: SkeletonLike) -> np.ndarray:
    """The positions (n_joints + 1, 3) of the joints at angle zero, and last of the root, at the origin."""
    bones = np.einsum("jab,jb->ja", _axes_of_offsets(skeleton), skeleton.offsets)
    positions = np.zeros((skeleton.n_joints + 1, 3))  # the root's index is -1
    for j, parent in enumerate(skeleton.parents):
        positions[j] = positions[parent] + bones[j]
    return positions


def find_carriers(skeleton: SkeletonLike) -> list[int]:
    """The joint with which each bone rotates; -1 is the root."""
    movers = find_movers(skeleton)
    return movers[:-1] if skeleton.offset_frame == "own" else [movers[int(parent)] for parent in skeleton.parents]


def find_movers(skeleton: SkeletonLike) -> list[int]:
    """The last joint with dofs from the root to each joint, and last to the root itself; -1 is the root."""
    movers = [ROOT] * (skeleton.n_joints + 1)
    for j, bone in enumerate(skeleton.bones):
        movers[j] = j if bone.dofs else movers[int(skeleton.parents[j])]
    return movers


# --- comparison -------------------------------------------------------------------------------------------------------
# Comparison of skeletons on which equal numbers may be different poses: joints, dofs, rest poses.


LARGEST_DIFFERENCE = 45.0  # degrees: people of one set differ by less, T-poses and A-poses by more


def mismatch(a: SkeletonLike, b: SkeletonLike) -> str:
    """Why equal angles are different poses on two skeletons; empty if they are the same pose."""
    if a.offset_frame != b.offset_frame:
        return f"their offset frames are {a.offset_frame!r} and {b.offset_frame!r}"
    bones_a, bones_b = ({bone.name: bone for bone in skeleton.bones} for skeleton in (a, b))
    alone = [name for name in [*bones_a, *bones_b] if name not in bones_a or name not in bones_b]
    if alone:
        return f"only one of them has a joint {alone[0]!r}"
    for name in bones_a:
        for field in ("parent", "dofs", "axis", "dof_name"):
            in_a, in_b = getattr(bones_a[name], field), getattr(bones_b[name], field)
            if in_a != in_b:
                convertible = field == "dofs" and min(bones_a[name].n_dofs, bones_b[name].n_dofs) > 1
                return f"joint {name!r} has {field} {in_a!r} and {in_b!r}" + "; convert to_rotvec()" * convertible
    return ""


def check_comparable(skeletons: Sequence[SkeletonLike], names: Sequence[str], other_rest: str, other_rig: str) -> None:
    """Refuse skeletons on which equal numbers are different poses; names and two remedies are for the messages."""
    for i, other in enumerate(skeletons[1:], start=1):
        if difference := mismatch(skeletons[0], other):
            raise ValueError(f"{names[i]} and {names[0]} have different skeletons: {difference}. {other_rig}")
    check_rest_poses(skeletons, names, other_rest)


def check_rest_poses(skeletons: Sequence[SkeletonLike], names: Sequence[str], remedy: str) -> None:
    """Refuse skeletons with the same joints if two have bones, or rest rotations, that are far apart.

    Each bone is compared by its direction at angle zero; each joint with dofs by its rest rotation, too.
    """
    joints = skeletons[0].joint_names
    order = [[skeleton.joint_names.index(name) for name in joints] for skeleton in skeletons]
    directions = np.stack([directions_at_zero(s)[i] for s, i in zip(skeletons, order, strict=True)])
    rests = np.stack([s.rest_rotations[i].reshape(-1, 9) for s, i in zip(skeletons, order, strict=True)])
    known, moves = np.asarray(directions.any(axis=-1)), np.array([bool(bone.dofs) for bone in skeletons[0].bones])
    for i in range(len(skeletons) - 1):
        of_bones = np.where(known[i] & known[i:], (directions[i] * directions[i:]).sum(axis=-1), 1.0)
        of_rests = np.where(moves, ((rests[i] * rests[i:]).sum(axis=-1) - 1.0) / 2.0, 1.0)
        cosines = np.stack([of_bones, of_rests], axis=-1).round(9)
        k, j, is_rest = map(int, np.unravel_index(cosines.argmin(), cosines.shape))  # a joint before its children
        angle = float(np.degrees(np.arccos(np.clip(cosines[k, j, is_rest], -1.0, 1.0))))
        if angle > LARGEST_DIFFERENCE + 1e-6:
            kind = "rest rotation" if is_rest else "bone"
            found = f"{names[i]} and {names[i + k]} differ in the {kind} of {joints[j]!r}"
            raise ValueError(f"different rest poses: {found} by {angle:.0f}°, at most 45° expected. {remedy}")
