"""Weights of joints that stand for the mass of a person.

After P. de Leva, "Adjustments to Zatsiorsky-Seluyanov's segment inertia parameters", Journal of Biomechanics 29(9),
1996, table 4, doi:10.1016/0021-9290(95)00178-6: means of the figures for women and for men.

A segment of mass m with its centre of mass at the fraction c of its length counts as m (1 − c) at the near end and m c
at the far end, which preserves its momentum and centre of mass.
"""

from typing import NamedTuple

import numpy as np

from skpose.kinematics._anatomy import ARM, BALL, HAND, HEAD, HEAD_TOP, LEG, LIMBS, SIDES, TOE, find_anatomy, path_up
from skpose.skeleton import Skeleton


class Segment(NamedTuple):
    """A part of a person."""

    mass: float  # relative to the person's
    centre: float  # of mass, relative to the length, from the near end


def _mean(women: tuple[float, float], men: tuple[float, float]) -> Segment:
    """The mean of two rows of the table, in % of the mass and of the length."""
    return Segment((women[0] + men[0]) / 200.0, (women[1] + men[1]) / 200.0)


HEAD_SEGMENT = _mean((6.68, 100.0 - 48.41), (6.94, 100.0 - 50.02))  # with the neck; the table measures from the vertex
TRUNK = (15.45 + 15.96 + 14.65 + 16.33) / 200.0  # its upper and its middle part; the pelvis belongs to the root
ARM_SEGMENTS = (  # from the shoulder on
    _mean((2.55, 57.54), (2.71, 57.72)),
    _mean((1.38, 45.59), (1.62, 45.74)),
    _mean((0.56, 74.74), (0.61, 79.00)),
)
LEG_SEGMENTS = (  # from the hip on
    _mean((14.78, 36.12), (14.16, 40.95)),
    _mean((4.81, 44.16), (4.33, 44.59)),
    _mean((1.29, 40.14), (1.37, 44.15)),
)


def mass_weights(skeleton: Skeleton) -> np.ndarray:
    """The fraction (n_joints,) of a person's mass that each joint stands for."""
    person = find_anatomy(skeleton, any_proportions=True)
    joints = person.joints
    if not all(f"{side}_{mark}" in joints for side in SIDES for limb in LIMBS for mark in limb) or HEAD not in joints:
        raise ValueError(
            'weights="mass" needs a person, with hips, knees, ankles, shoulders, elbows, wrists and a head'
        )
    weights = np.zeros(skeleton.n_joints + 1)  # the last is the root's, whose index is -1

    def add(segment: Segment, near: int, far: int) -> None:
        weights[near] += segment.mass * (1.0 - segment.centre)
        weights[far] += segment.mass * segment.centre

    for segments, marks, tips in ((LEG_SEGMENTS, LEG, (BALL, TOE)), (ARM_SEGMENTS, ARM, (HAND,))):
        for side in SIDES:
            points = [joints[f"{side}_{mark}"] for mark in marks]
            end = next((joints[f"{side}_{tip}"] for tip in tips if f"{side}_{tip}" in joints), points[-1])
            for segment, near, far in zip(segments, points, [*points[1:], end], strict=True):
                add(segment, near, far)
    # The neck begins where the trunk ends, or at a joint of its own if bones begin at their joints.
    begins = [*person.neck, joints[HEAD]] if skeleton.offset_frame == "parent" else person.trunk[-1:]
    spine = path_up(skeleton, begins[0] if begins else -1)
    add(HEAD_SEGMENT, (*spine, -1)[0], joints.get(HEAD_TOP, joints[HEAD]))
    lengths = np.linalg.norm(skeleton.offsets[spine], axis=1)
    for end, length in zip(spine, lengths, strict=True):
        weights[[skeleton.parents[end], end]] += 0.5 * TRUNK * length / (lengths.sum() or 1.0)
    return weights[:-1]
