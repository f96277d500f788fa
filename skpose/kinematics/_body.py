"""The anatomical axes of a person's body and limbs at angle zero.

The body has axes forward, left and up where the person stands at angle zero. A knee and an elbow bend about their
*flexion axis* a: with u along the limb before the joint and v after it, a is along u × v where the limb is bent. It is
the axis of the hinge if the joint is one. Otherwise it follows from the rest pose if the person stands there with
straight limbs, since knees bend backward and elbows forward, and otherwise from the frames in which a motion bends it.
"""

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np
from scipy.spatial.transform import Rotation

from skpose.kinematics._anatomy import (
    ANKLE,
    ARM,
    BALL,
    HAND,
    HEAD,
    HEAD_TOP,
    HIP,
    KNEE,
    LEG,
    SHOULDER,
    SIDES,
    TOE,
    Anatomy,
    common_parent,
    pair_of,
    path_up,
)
from skpose.skeleton import Skeleton
from skpose.skeleton._bone import axes_of
from skpose.skeleton._rest import ROOT, axes_at_zero, find_carriers, find_movers, positions_at_zero, unit

NEAR = 0.8  # cosine of the angle to an axis of the root up to which a skeleton stands along it, or faces it
FACING = np.cos(np.radians(45.0))  # of the angle between hips and shoulders of a person who stands
HANGING = np.cos(np.radians(60.0))  # of the angle between a leg and the direction down there
UPRIGHT = np.cos(np.radians(10.0))  # of a shank at angle zero; the foot of a more tilted shank is as tilted
POINTED = np.cos(np.radians(15.0))  # of the largest angle to the shank of a foot that does not show forward
BENT = np.sin(np.radians(15.0))  # of a bend that shows its axis
AGREES = np.cos(np.radians(60.0))  # of the angle between the axis by the rest pose and in a motion, which counts beyond
RAISED = np.cos(np.radians(45.0))  # of the angle to up of an arm that does not show by which path it was raised
ONE_AXIS = 0.8  # length of the mean of the axes of bends, if they have one


def body_axes(at: Mapping[str, np.ndarray], across: str = SHOULDER) -> np.ndarray:
    """The axes (3, 3) of the trunk at angle zero, forward, left and up, by the positions (3,) of landmarks.

    Left is along the line of the shoulders, or of the hips: in some rest poses one is rotated against the other. The
    axes are those of the root within 37° of it.
    """
    pairs = {mark: pair for mark in (SHOULDER, HIP, ANKLE) if (pair := pair_of(at, mark))}  # from above
    middles = [np.mean(pair, axis=0) for pair in pairs.values()]
    up = _snap(unit(middles[0] - (middles[1] if len(middles) > 1 else 0.0)))
    left, right = pairs.get(across, next(iter(pairs.values())))
    left = _snap(unit(left - right - ((left - right) @ up) * up))
    left = unit(left - (left @ up) * up)
    return np.stack([np.cross(left, up), left, up], axis=1)


def is_standing(at: Mapping[str, np.ndarray], axes: np.ndarray) -> bool:
    """Whether legs hang at angle zero, and hips face where shoulders do."""
    lines = [unit(pair[0] - pair[1]) for mark in (HIP, SHOULDER) if (pair := pair_of(at, mark))]
    if len(lines) == 2 and lines[0] @ lines[1] < FACING:
        return False
    legs = [[at.get(f"{side}_{mark}") for mark in (HIP, ANKLE)] for side in SIDES]
    return all(unit(a - b) @ axes[:, 2] > HANGING for a, b in legs if a is not None and b is not None)


def _snap(direction: np.ndarray) -> np.ndarray:
    """The axis of the root near a direction, or the direction itself."""
    axis = int(np.abs(direction).argmax())
    return np.eye(3)[axis] * np.sign(direction[axis]) if abs(direction[axis]) > NEAR else direction


class Segment(NamedTuple):
    """A segment that is known by its axes at angle zero."""

    joint: int  # that carries it; -1 is the root
    axes: np.ndarray  # (3, 3) forward, left and up in the columns


def find_segments(skeleton: Skeleton, person: Anatomy) -> dict[str, Segment]:
    """Pelvis, chest and head; and the feet, "left_foot" and "right_foot", where the person stands on them."""
    zero, carriers, movers = positions_at_zero(skeleton), find_carriers(skeleton), find_movers(skeleton)
    at, found = {mark: zero[joint] for mark, joint in person.joints.items()}, {}
    for name, mark in (("chest", SHOULDER), ("pelvis", HIP)):
        if (pair := pair_of(person.joints, mark)) and (zero[pair[0]] != zero[pair[1]]).any():
            both = {carriers[joint] for joint in pair}
            joint = both.pop() if len(both) == 1 else movers[common_parent(skeleton, *pair)]
            found[name] = Segment(joint, body_axes(at, mark))
    if "chest" in found and HEAD in person.joints:
        head, top = person.joints[HEAD], person.joints.get(HEAD_TOP, ROOT)
        joint = carriers[top] if skeleton.offset_frame == "own" else movers[head]
        found["head"] = Segment(joint, found["chest"].axes)
    if "pelvis" in found and is_standing(at, body := body_axes(at)):
        for side in SIDES:
            ankle, knee = at.get(f"{side}_{ANKLE}"), at.get(f"{side}_{KNEE}")
            end = next((f"{side}_{mark}" for mark in (BALL, TOE) if f"{side}_{mark}" in at), "")
            if ankle is not None and knee is not None and end:
                axes, is_flat = foot_axes(unit(knee - ankle), at[end] - ankle, body)
                if is_flat:
                    found[f"{side}_foot"] = Segment(carriers[person.joints[end]], axes)
    return found


def foot_axes(shank: np.ndarray, forward: np.ndarray, body: np.ndarray) -> tuple[np.ndarray, bool]:
    """The axes of a foot at angle zero, by the directions up the shank and to the toes, and whether it is flat there.

    A leg that is spread has a foot that is tilted with it. A foot that points along the shank is not flat.
    """
    up = body[:, 2] if shank @ body[:, 2] > UPRIGHT else shank
    is_flat = bool(unit(forward) @ -up <= POINTED)
    up = up if is_flat else body[:, 0]  # the instep
    forward = unit(forward - (forward @ up) * up)
    return np.stack([forward, np.cross(up, forward), up], axis=1), is_flat


class Bend(NamedTuple):
    """A knee or an elbow of a skeleton."""

    name: str  # "left_knee" and so on
    joints: tuple[int, int, int]  # at the start of the limb, at the knee or the elbow, and at the end
    carriers: list[int]  # the joints that carry the bones between these, and the hand or the foot
    hinge: np.ndarray | None  # (3,) the axis at angle zero if it is a hinge, up to its sign
    at_rest: np.ndarray | None  # (3,) the flexion axis by the rest pose, if the person stands there
    is_straight: bool  # whether the limb is straight there


class Poses(NamedTuple):
    """Poses of a skeleton in the axes of the world."""

    positions: np.ndarray  # (n_frames, n_joints, 3) from the root
    since_zero: Mapping[int, Rotation]  # (n_frames,) of the root, -1, and of each joint


def find_bends(skeleton: Skeleton, person: Anatomy) -> list[Bend]:
    """Knees and elbows of both sides, as far as they are known."""
    zero, axes, carriers = positions_at_zero(skeleton), axes_at_zero(skeleton), find_carriers(skeleton)
    at = {mark: zero[joint] for mark, joint in person.joints.items()}
    body = body_axes(at) if pair_of(person.joints, HIP) or pair_of(person.joints, SHOULDER) else None
    stands = body is not None and is_standing(at, body)
    found = []
    for limb, sign in ((LEG, -1.0), (ARM, 1.0)):
        for side in [side for side in SIDES if all(f"{side}_{mark}" in person.joints for mark in limb)]:
            start, middle, end = (person.joints[f"{side}_{mark}"] for mark in limb)
            tips = (BALL, TOE) if limb == LEG else (HAND,)
            ends = [person.joints[f"{side}_{mark}"] for mark in tips if f"{side}_{mark}" in person.joints][:1]
            path = path_up(skeleton, end)
            path = path[: path.index(start)]
            joint = carriers[path[path.index(middle) - 1]]  # it carries the first bone after the knee
            bone = skeleton.bones[joint] if joint != ROOT else None
            is_hinge = bone is not None and bone.n_dofs == 1 and not bone.is_slide and joint != carriers[middle]
            along, is_straight = unit(zero[middle] - zero[start]), True
            across = np.zeros(3)
            if stands and body is not None and along @ body[:, 2] < RAISED:
                across = np.cross(along, unit(zero[end] - zero[middle]))
                is_straight = bool(np.linalg.norm(across) <= BENT)
                across = np.cross(along, sign * body[:, 0]) if is_straight else across
            found.append(
                Bend(
                    f"{side}_{limb[1]}",
                    (start, middle, end),
                    sorted({carriers[j] for j in [*path, *ends]}),
                    axes[joint] @ axes_of(bone)[0] if is_hinge and bone is not None else None,
                    unit(across) if np.linalg.norm(across) > BENT else None,
                    is_straight,
                )
            )
    return found


def flexion_axis(bend: Bend, joint: int, poses: Poses | None) -> np.ndarray | None:
    """The flexion axis (3,) at angle zero, relative to the root, that a joint carries; None if nothing shows it."""
    shown = None if poses is None else _shown_axis(bend, joint, poses)
    known = bend.at_rest
    if shown is not None and (known is None or not bend.is_straight or shown @ known < AGREES):
        known = shown
    if bend.hinge is None or known is None:
        return known
    return bend.hinge * np.sign(bend.hinge @ (known if shown is None else shown))


def _shown_axis(bend: Bend, joint: int, poses: Poses) -> np.ndarray | None:
    """The mean axis of a limb where it is bent in a motion."""
    start, middle, end = (poses.positions[:, joint] for joint in bend.joints)
    axes = poses.since_zero[joint].inv().apply(np.cross(unit(middle - start), unit(end - middle)))
    axes = axes[np.linalg.norm(axes, axis=1) > BENT]
    mean = axes.sum(axis=0)
    return unit(mean) if len(axes) and np.linalg.norm(mean) > ONE_AXIS * np.linalg.norm(axes, axis=1).sum() else None
