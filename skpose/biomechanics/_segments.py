"""The segments of a person: which joint carries each, and its rotation.

A segment is what is rigid between two joints: the thigh, the trunk. It is found by the landmarks of its skeleton, the
joints with known names. Its *axes* follow the ISB: x forward, y up, z to the right, where the person
stands with hanging arms.
"""

from typing import NamedTuple

import numpy as np
from scipy.spatial.transform import Rotation

from skpose.kinematics import forward_kinematics
from skpose.kinematics._anatomy import SIDES, Anatomy, pair_of
from skpose.kinematics._body import find_segments as find_axes
from skpose.kinematics._lines import find_carriers, find_movers, unit
from skpose.kinematics._orientations import rotations_since_zero
from skpose.skeleton import Motion, Skeleton
from skpose.skeleton._root import root_orientations

# Limbs: the landmarks at which each segment begins and may end; the first that is there is taken.
LIMBS = {
    "thigh": ("hip", ("knee",)),
    "shank": ("knee", ("ankle",)),
    "foot": ("ankle", ("ball", "toe")),
    "upper_arm": ("shoulder", ("elbow",)),
    "forearm": ("elbow", ("wrist",)),
    "hand": ("wrist", ("hand",)),
}


class Segment(NamedTuple):
    """A segment of a skeleton."""

    carrier: int  # the joint with which it rotates; -1 is the root
    start: int  # the joints at its ends; -1 is the root
    end: int
    points: tuple[int, ...]  # the joints that are fixed to it, which need not be those at its ends; -1 is the root
    at_zero: np.ndarray  # (n_points, 3) where these are at angle zero, from its start, m
    along: np.ndarray  # (3,) from its start to its end at angle zero, m


def find_segments(skeleton: Skeleton, person: Anatomy) -> dict[str, Segment]:
    """The segments that a skeleton has, by name: "pelvis", "left_thigh" and so on."""
    carriers, movers, joints = find_carriers(skeleton), find_movers(skeleton), person.joints
    zero = forward_kinematics(np.zeros((1, skeleton.n_dofs)), skeleton)[0]
    zero = np.concatenate([zero, np.zeros((1, 3))])  # the root
    segments: dict[str, Segment] = {}

    def add(name: str, carrier: int, start: int, end: int) -> None:
        if not np.any(zero[end] - zero[start]) and name != "head":
            return  # without a length it has no direction
        carried = [j for j in range(skeleton.n_joints) if carriers[j] == carrier]
        points = tuple(sorted({*carried, *(int(skeleton.parents[j]) for j in carried)}))
        segments[name] = Segment(carrier, start, end, points, zero[list(points)] - zero[start], zero[end] - zero[start])

    trunk = find_axes(skeleton, person)
    for name, axes, mark in (("pelvis", "pelvis", "hip"), ("trunk", "chest", "shoulder")):
        if axes in trunk and (both := pair_of(joints, mark)):
            add(name, trunk[axes].joint, *both)
    for side in SIDES:
        for name, (begin, ends) in LIMBS.items():
            found = [joints[f"{side}_{end}"] for end in ends if f"{side}_{end}" in joints]
            if f"{side}_{begin}" in joints and found:
                add(f"{side}_{name}", carriers[found[0]], joints[f"{side}_{begin}"], found[0])
    top = [joints[mark] for mark in ("head_top", "head_center") if mark in joints]
    if top:
        add("head", carriers[top[0]], int(skeleton.parents[top[0]]), top[0])
    elif "head" in joints and skeleton.offset_frame == "parent":
        add("head", movers[joints["head"]], joints["head"], joints["head"])
    return segments


class Turned(NamedTuple):
    """The segments of a skeleton in each frame."""

    since_zero: dict[str, np.ndarray]  # (n_frames, 3, 3) rotations since angle zero, in the world
    positions: np.ndarray  # (n_frames, n_joints + 1, 3) of the joints in the axes of the world, the root the last, m

    def direction(self, segment: Segment) -> np.ndarray:
        """The directions (n_frames, 3) from the start of a segment to its end; zeros without length."""
        return unit(self.positions[:, segment.end] - self.positions[:, segment.start])

    def mean(self) -> "Turned":
        """The mean of the frames, as one."""
        rotations = {
            name: Rotation.from_matrix(each).mean().as_matrix()[None] for name, each in self.since_zero.items()
        }
        return Turned(rotations, self.positions.mean(axis=0, keepdims=True))


def turn_segments(motion: Motion, segments: dict[str, Segment]) -> Turned:
    """How the segments of a motion are turned."""
    root = root_orientations(motion.root_angles, motion.root_axes)
    rotations = rotations_since_zero(motion.skeleton, motion.angles, root)
    joints = forward_kinematics(motion.angles, motion.skeleton)
    positions = np.stack([root.apply(joints[:, j]) for j in range(joints.shape[1])], axis=1)
    positions = np.concatenate([positions, np.zeros((len(motion), 1, 3))], axis=1)
    return Turned({name: rotations[segment.carrier].as_matrix() for name, segment in segments.items()}, positions)
