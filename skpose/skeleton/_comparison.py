"""Skeletons on which equal numbers are different poses: other joints, other dofs, another rest pose."""

import re
from collections.abc import Sequence

import numpy as np

from skpose._validation.skeletons import SkeletonLike
from skpose.skeleton._rest import directions_at_zero

LARGEST_DIFFERENCE = 45.0  # degrees: people of one set differ by less, T-poses and A-poses by more
HAND_OF_AMASS = re.compile(r"(left|right)_(hand|(index|middle|pinky|ring|thumb)[123])")


def mismatch(a: SkeletonLike, b: SkeletonLike) -> str:
    """Return in words why equal angles are different poses on two skeletons; empty if they are the same pose."""
    if a.offset_frame != b.offset_frame:
        return f"their offset frames are {a.offset_frame!r} and {b.offset_frame!r}"
    bones_a, bones_b = ({bone.name: bone for bone in skeleton.bones} for skeleton in (a, b))
    alone = [name for name in [*bones_a, *bones_b] if name not in bones_a or name not in bones_b]
    if alone:
        return _only_one_has(alone)
    for name in bones_a:
        for field in ("parent", "dofs", "axis", "dof_name"):
            in_a, in_b = getattr(bones_a[name], field), getattr(bones_b[name], field)
            if in_a != in_b:
                convertible = field == "dofs" and min(bones_a[name].n_dofs, bones_b[name].n_dofs) > 1
                remedy = '; as ball joints they compare: to_rotvec() of both, or rotations="rotvec"' * convertible
                return f"joint {name!r} has {field} {in_a!r} in one and {in_b!r} in the other{remedy}"
    return ""


def check_comparable(skeletons: Sequence[SkeletonLike], names: Sequence[str], other_rest: str, other_rig: str) -> None:
    """Refuse skeletons on which equal numbers are different poses; names and two remedies are for the messages."""
    for i, other in enumerate(skeletons[1:], start=1):
        difference = mismatch(skeletons[0], other)
        if difference:
            raise ValueError(f"{names[i]} has no bone-wise mean with {names[0]}: {difference}. {other_rig}")
    check_rest_poses(skeletons, names, other_rest)


def check_rest_poses(skeletons: Sequence[SkeletonLike], names: Sequence[str], remedy: str) -> None:
    """Refuse skeletons with the same joints of which two have bones, or rest rotations, that are far apart.

    Each bone is compared by its direction at angle zero; each joint with dofs by its rest rotation, too.
    """
    if len(skeletons) < 2:
        return
    joints = skeletons[0].joint_names
    order = [[skeleton.joint_names.index(name) for name in joints] for skeleton in skeletons]
    directions = np.stack([directions_at_zero(s)[i] for s, i in zip(skeletons, order, strict=True)])
    rests = np.stack([s.rest_rotations[i] for s, i in zip(skeletons, order, strict=True)])
    rests = rests.reshape(*rests.shape[:2], 9)
    moves = np.array([bool(bone.dofs) for bone in skeletons[0].bones])
    known = np.linalg.norm(directions, axis=-1) > 0.0
    worst, words = LARGEST_DIFFERENCE, ""
    for i in range(len(skeletons) - 1):  # with all that follow: those of one first skeleton may differ among themselves
        cosines = np.einsum("ja,nja->nj", directions[i], directions[i + 1 :])
        cosines[~(known[i] & known[i + 1 :])] = 1.0
        traces = np.einsum("ja,nja->nj", rests[i], rests[i + 1 :])
        for what, cosine in (
            ("bone {!r} points in directions that are {:.0f}° apart at angle zero", cosines),
            ("joint {!r} has rest rotations that are {:.0f}° apart", np.where(moves, (traces - 1.0) / 2.0, 1.0)),
        ):
            k, j = np.unravel_index(cosine.round(9).argmin(), cosine.shape)  # a joint before those that follow it
            angle = float(np.degrees(np.arccos(np.clip(cosine[k, j], -1.0, 1.0))))
            if angle > worst + 1e-6:
                worst = angle
                words = f"{names[i]} and {names[i + 1 + k]} have different rest poses: {what.format(joints[j], angle)}"
    if words:
        raise ValueError(
            f"{words}, so that equal numbers are different poses; expected at most {LARGEST_DIFFERENCE:.0f}°. {remedy}"
        )


def _only_one_has(names: Sequence[str]) -> str:
    """Return in words that joints of these names are in one of two skeletons, and the remedy where there is one."""
    more = f" (and {len(names) - 1} more)" if len(names) > 1 else ""
    hands = all(HAND_OF_AMASS.fullmatch(name) for name in names)
    remedy = "; without their hands, load_motion(..., hands=False), motions of SMPL and SMPL-H have one skeleton"
    return f"only one of them has a joint {names[0]!r}{more}{remedy * hands}"
