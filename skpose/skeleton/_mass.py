"""Weights of joints that stand for the mass of a person.

After P. de Leva, "Adjustments to Zatsiorsky-Seluyanov's segment inertia parameters", Journal of Biomechanics 29(9),
1996, table 4, doi:10.1016/0021-9290(95)00178-6: means of the figures for women and for men.

A segment of mass m with its centre of mass at the fraction c of its length counts as m (1 − c) at the near end and m c
at the far end, which preserves its momentum and centre of mass.
"""

import re
from typing import NamedTuple

import numpy as np

from skpose._utils.validation import SkeletonLike
from skpose.skeleton._sides import PATTERNS

ROOT = -1


class Segment(NamedTuple):
    """A part of a person."""

    mass: float  # relative to the person's
    centre: float  # of mass, relative to the length, from the near end


def _mean(women: tuple[float, float], men: tuple[float, float]) -> Segment:
    """The mean of two rows of the table, in % of the mass and of the length."""
    return Segment((women[0] + men[0]) / 200.0, (women[1] + men[1]) / 200.0)


HEAD = _mean((6.68, 100.0 - 48.41), (6.94, 100.0 - 50.02))  # with the neck; the table measures from the vertex
TRUNK = (15.45 + 15.96 + 14.65 + 16.33) / 200.0  # its upper and its middle part; the pelvis belongs to the root
ARM = (  # from the shoulder on
    _mean((2.55, 57.54), (2.71, 57.72)),
    _mean((1.38, 45.59), (1.62, 45.74)),
    _mean((0.56, 74.74), (0.61, 79.00)),
)
LEG = (  # from the hip on
    _mean((14.78, 36.12), (14.16, 40.95)),
    _mean((4.81, 44.16), (4.33, 44.59)),
    _mean((1.29, 40.14), (1.37, 44.15)),
)
# Names, without the side, of the bones of a limb, and of its joints.
LIMBS = (
    (
        ARM,
        (("upperarm", "humerus", "arm", "uparm"), ("forearm", "radius", "lowerarm", "lowarm"), ("hand",)),
        (("shoulder",), ("elbow",), ("wrist",)),
    ),
    (
        LEG,
        (
            ("thigh", "femur", "upleg", "upperleg"),
            ("shank", "tibia", "leg", "lowerleg", "lowleg", "shin", "calf"),
            ("foot",),
        ),
        (("hip",), ("knee",), ("ankle",)),
    ),
)
NECK = ("neck", "lowerneck", "upperneck")


def mass_weights(skeleton: SkeletonLike) -> np.ndarray:
    """The fraction (n_joints,) of a person's mass that each joint stands for."""
    weights = np.zeros(skeleton.n_joints + 1)  # the last is the root's, whose index is ROOT
    children: list[list[int]] = [[] for _ in range(skeleton.n_joints + 1)]
    for joint, parent in enumerate(skeleton.parents):
        children[parent].append(joint)
    for segments, bones, joints in LIMBS:
        for points in _limbs(skeleton, bones, joints, children):
            for segment, near, far in zip(segments, points[:-1], points[1:], strict=True):
                weights[near] += segment.mass * (1.0 - segment.centre)
                weights[far] += segment.mass * segment.centre / len(far)
    neck, top = _head(skeleton, children)
    weights[neck] += HEAD.mass * (1.0 - HEAD.centre)
    weights[top] += HEAD.mass * HEAD.centre / len(top)
    spine = [neck]
    while spine[-1] != ROOT:
        spine.append(int(skeleton.parents[spine[-1]]))
    lengths = [float(np.linalg.norm(skeleton.offsets[joint])) for joint in spine[:-1]]
    for end, start, length in zip(spine[:-1], spine[1:], lengths, strict=True):
        weights[[start, end]] += 0.5 * TRUNK * length / (sum(lengths) or 1.0)
    return weights[:-1]


def _limbs(
    skeleton: SkeletonLike,
    bones: tuple[tuple[str, ...], ...],
    joints: tuple[tuple[str, ...], ...],
    children: list[list[int]],
) -> list[tuple[list[int], ...]]:
    """For both sides the joints where the segments of a limb meet: its start, two joints, its ends."""
    by_joint = bool(_named(skeleton, joints[1]))
    found = [_named(skeleton, names, 2) for names in (joints if by_joint else bones)]
    limbs: list[tuple[list[int], ...]] = []
    for upper, lower, last in zip(*found, strict=True):
        if by_joint or skeleton.offset_frame == "parent":  # a joint is where the bone of its name starts
            limbs.append(([upper], [lower], [last], children[last] or [last]))
        else:  # there may be other bones between two of them, such as the half of the forearm that CMU names lwrist
            limbs.append((*([int(skeleton.parents[bone])] for bone in (upper, lower, last)), [last]))
    return limbs


def _head(skeleton: SkeletonLike, children: list[list[int]]) -> tuple[int, list[int]]:
    """The joint at the base of the neck, and the ends of the head."""
    (head,) = _named(skeleton, ("head",), 1)
    first, necks = head, _named(skeleton, NECK)
    while skeleton.parents[first] in necks:
        first = int(skeleton.parents[first])
    if skeleton.offset_frame == "own":
        return int(skeleton.parents[first]), [head]
    return first, children[head] or [head]


def _named(skeleton: SkeletonLike, names: tuple[str, ...], expected: int = 0) -> list[int]:
    """The joints with one of these names apart from the side: "mixamorig:LeftUpLeg" has "upleg".

    If a number is expected, only joints with the first name that is found count, and another number is refused.
    """
    plain = [re.sub(r"^Bip\d+", "", name.split(":")[-1]) for name in skeleton.joint_names]
    words = [{re.sub("[^a-z]", "", pattern.sub("", name).lower()) for pattern in PATTERNS} for name in plain]
    if not expected:
        return [j for j, found in enumerate(words) if found & {*names}]
    joints = next((some for name in names if (some := [j for j, found in enumerate(words) if name in found])), [])
    if len(joints) != expected:
        got = [skeleton.joint_names[j] for j in joints]
        raise ValueError(f'weights="mass" needs {expected} joint(s) named {" or ".join(names)}, got {got}')
    return joints
