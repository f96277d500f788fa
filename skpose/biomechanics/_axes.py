"""The axes of the segments in the reference pose.

There are two kinds of reference pose. The *rest pose* of a skeleton is made by a program: arms may be held out, knees
bent. There each segment has its own axes, with y along a limb, which are parallel in a straight limb. In a *standing
pose* of the person, all joints are at zero by definition: the two segments of a joint have the same axes.
"""

from itertools import combinations
from typing import NamedTuple

import numpy as np
from scipy.spatial.transform import Rotation

from skpose.biomechanics._angles import degrees_between
from skpose.biomechanics._segments import LIMBS, Segment, Turned
from skpose.kinematics._anatomy import SIDES, Anatomy, path_up
from skpose.kinematics._body import find_bends, flexion_axis
from skpose.kinematics._lines import ROOT, unit
from skpose.skeleton import Skeleton

UPRIGHT = np.cos(np.radians(45.0))  # of the angle to the vertical up to which legs and trunk stand in a rest pose
# Degrees from down from which an arm of a rest pose points up: in which plane it would be lowered is arbitrary there.
RAISED = 135.0
# Two points are the ends of a joint's axis, such as the epicondyles of a knee, if the joint is in the middle of them,
# and if their line is across the limb; relative to the distance between them, and the cosine.
OFF_MIDDLE, ALONG = 0.2, 0.5
# Distance of a thumb from the line of the hand, relative to its length, that shows where the palm is.
THUMB_OFF_LINE = 0.1
PARALLEL = 1e-6  # sine of the angle between two directions below which they show no axes
BEFORE = {"shank": "thigh", "forearm": "upper_arm", "hand": "forearm"}


class Reference(NamedTuple):
    """A pose in which the person stands."""

    turned: Turned  # of one frame
    body: np.ndarray  # (3, 3) its columns are the axes of the body: forward, up, to the right
    # (3,) of axes of knees, ankles and elbows, "left_knee" and so on, to the right; of wrists, along which the thumb is
    # next to the hand, to the right where palms face forward.
    lines: dict[str, np.ndarray]
    is_rest: bool  # whether it is the rest pose of the skeleton
    # Angles that the pose gives no zero, by the beginning of their names and the side, such as ("elbow", "left"), and
    # why.
    unknown: dict[tuple[str, str], str]

    def direction(self, segment: Segment) -> np.ndarray:
        """The direction (3,) of a segment."""
        return self.turned.direction(segment)[0]


def find_reference(
    skeleton: Skeleton, person: Anatomy, segments: dict[str, Segment], turned: Turned, up: np.ndarray | None
) -> Reference | str:
    """A pose, one frame, as a reference, or why it does not stand; up is None for the rest pose.

    The vertical of a rest pose is the axis along which the legs are. Whether a person stands in another pose is to be
    known.
    """
    positions = turned.positions[0]
    pelvis = segments["pelvis"]
    left, right = positions[pelvis.start], positions[pelvis.end]
    is_rest = up is None
    if up is None:
        legs = {
            f"its {side} leg": positions[segments[f"{side}_thigh"].start] - positions[segments[f"{side}_shank"].end]
            for side in SIDES
        }
        upward = sum(legs.values())
        axis = int(np.abs(upward).argmax())
        up = np.eye(3)[axis] * np.sign(upward[axis])
        if "trunk" in segments:
            legs["its trunk"] = positions[segments["trunk"].start] + positions[segments["trunk"].end] - left - right
        for what, line in legs.items():
            if degrees_between(line, up) > np.degrees(np.arccos(UPRIGHT)):
                return f"{what} leans by {degrees_between(line, up):.0f}°"
    across = (right - left) - (right - left) @ up * up
    size = np.linalg.norm(across)
    if size <= UPRIGHT * np.linalg.norm(right - left):
        return "the line of its hips is not horizontal"
    z = across / size
    body = np.stack([np.cross(up, z), up, z], axis=1)
    feet = [turned.direction(segments[f"{side}_foot"])[0] for side in SIDES if f"{side}_foot" in segments]
    if feet and all(foot @ body[:, 0] < -0.5 for foot in feet):
        return "toes point backward: exchange left and right in joints=, or mirror the file"
    lines: dict[str, np.ndarray] = {}
    for bend in find_bends(skeleton, person) if is_rest else ():
        flexion = flexion_axis(bend, ROOT, None)
        if bend.hinge is not None and flexion is not None:
            lines[bend.name] = -flexion if bend.name.endswith("knee") else flexion
    for side in SIDES:
        for joint, limb in (("knee", "thigh"), ("ankle", "shank")):
            line = _line_of(skeleton, positions, segments[f"{side}_{limb}"])
            if line is not None:
                lines[f"{side}_{joint}"] = line if line @ z > 0.0 else -line
        if f"{side}_hand" in segments:
            thumb = _thumb_of(skeleton, positions, segments[f"{side}_hand"])
            if thumb is not None:
                lines[f"{side}_wrist"] = thumb if side == "right" else -thumb
    return Reference(turned, body, lines, is_rest, _raised_arms(segments, turned, up) if is_rest else {})


def rest_axes(reference: Reference, segments: dict[str, Segment]) -> dict[str, np.ndarray]:
    """The axes (3, 3) of each segment in a rest pose."""
    body = reference.body
    axes: dict[str, np.ndarray] = {name: body for name in ("pelvis", "trunk", "head") if name in segments}
    for side in SIDES:
        for limb, (_, ends) in LIMBS.items():
            if (name := f"{side}_{limb}") not in segments:
                continue
            along = reference.direction(segments[name])
            line = reference.lines.get(f"{side}_{ends[0]}")
            if limb == "foot":  # the sole is on the floor, or as far from it as the legs are spread
                shank = reference.direction(segments[f"{side}_shank"])
                up = unit((shank @ body[:, 0]) * body[:, 0] - shank)
                axes[name] = _with_line(up, np.cross(along, up))
            elif line is not None:
                axes[name] = _with_line(-along, line)
            else:
                before = axes.get(f"{side}_{BEFORE[limb]}", body) if limb in BEFORE else body
                axes[name] = rotation_onto(before[:, 1], -along) @ before
    return axes


def joint_axes(reference: Reference, joint: str, distal: Segment | None) -> np.ndarray:
    """The axes (3, 3) of a joint in a standing pose: z is its line, and y along the limb that it moves."""
    along = reference.body[:, 1] if distal is None else -reference.direction(distal)
    return _with_line(along, reference.lines.get(joint, reference.body[:, 2]))


def rotation_onto(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """The smallest rotation (3, 3) that takes a direction to another."""
    return np.asarray(Rotation.align_vectors(b, a)[0].as_matrix())


def _raised_arms(segments: dict[str, Segment], turned: Turned, up: np.ndarray) -> dict[tuple[str, str], str]:
    """The angles that arms which point up in a rest pose give no zero, and why."""
    arms = {side: segments[f"{side}_upper_arm"] for side in SIDES if f"{side}_upper_arm" in segments}
    return {
        (angle, side): f"the rest pose, in which the {side} arm points up, does not show how a hanging arm is rotated"
        for side, arm in arms.items()
        for angle in ("shoulder_rotation", "elbow")
        if degrees_between(turned.direction(arm)[0], -up) > RAISED
    }


def _with_line(y: np.ndarray, z: np.ndarray) -> np.ndarray:
    """Axes with a given y, whose z is as near to a line as may be; any axes with y if both are parallel."""
    x = np.cross(y, z)
    if np.linalg.norm(x) < PARALLEL:
        return rotation_onto(np.array([0.0, 1.0, 0.0]), y)
    x = unit(x)
    return np.stack([x, y, np.cross(x, y)], axis=1)


def _thumb_of(skeleton: Skeleton, positions: np.ndarray, hand: Segment) -> np.ndarray | None:
    """The direction from the line of a hand to its thumb; None if there is none."""
    along = positions[hand.end] - positions[hand.start]
    for j, name in enumerate(skeleton.joint_names):
        if "thumb" in name.lower() and hand.start in path_up(skeleton, j):
            across = positions[j] - positions[hand.start]
            across = across - (across @ along) / max(float(along @ along), 1e-300) * along
            size = float(np.linalg.norm(across))
            if size > THUMB_OFF_LINE * np.linalg.norm(along):
                return across / size
    return None


def _line_of(skeleton: Skeleton, positions: np.ndarray, segment: Segment) -> np.ndarray | None:
    """The direction of the line through two points on both sides of the joint at the end of a segment."""
    points = [j for j, bone in enumerate(skeleton.bones) if skeleton.parents[j] == segment.end and not bone.dofs]
    along = positions[segment.end] - positions[segment.start]
    best, found = OFF_MIDDLE, None
    for a, b in combinations(points, 2):
        line, middle = positions[b] - positions[a], (positions[a] + positions[b]) / 2.0 - positions[segment.end]
        size, off = float(np.linalg.norm(line)), float(np.linalg.norm(middle))
        if size and abs(line @ along) <= ALONG * size * np.linalg.norm(along) and off < best * size:
            best, found = off / size, line / size
    return found
