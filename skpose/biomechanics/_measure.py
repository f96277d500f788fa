"""Measure the angles of all joints."""

from itertools import combinations
from typing import Any, NamedTuple

import numpy as np
from scipy.spatial.transform import Rotation

from skpose._utils.warnings import warn
from skpose.biomechanics._segments import LIMBS, Segment, Turned, find_seen, turn_segments
from skpose.keypoints._fit import is_of_layout
from skpose.kinematics._anatomy import SIDES, Anatomy, path_up
from skpose.kinematics._body import find_bends, flexion_axis
from skpose.motions._phases import without_jumps
from skpose.skeleton import Motion, Skeleton
from skpose.skeleton._rest import ROOT, degrees_between, unit
from skpose.skeleton._upright import describe_up, find_up

# Bend of a joint, degrees, that shows the rotation of the segment before it, fully and at all. In
# between a straight limb becomes a bent one without a jump; flexion of a straight limb is measured as if it were not
# rotated, which is off by less than 1° for rotations of 30°.
BENT, STRAIGHT_LIMB = 15.0, 5.0
# Cosine of the second angle below which the first and the third are one (gimbal lock): within 3° of a right angle.
GIMBAL_LOCK = 0.05
HANGING = 0.05  # sine of the elevation below which an arm has no plane of elevation


def angles_of(rotations: np.ndarray) -> tuple[np.ndarray, ...]:
    """The angles about z, x and y of rotations (n, 3, 3), rad; NaN if undefined."""
    flexion, adduction = direction_angles(rotations[:, :, 1])
    rotation = np.arctan2(-rotations[:, 2, 0], rotations[:, 2, 2])
    return flexion, adduction, np.where(np.isnan(flexion), np.nan, rotation)


def direction_angles(y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The angles about z and then x that take up to directions (n, 3), in the axes of the proximal segment."""
    flexion = np.arctan2(-y[:, 0], y[:, 1])
    adduction = np.arcsin(np.clip(y[:, 2], -1.0, 1.0))
    return np.where(np.hypot(y[:, 0], y[:, 1]) < GIMBAL_LOCK, np.nan, flexion), adduction


def pelvis_angles(rotations: np.ndarray) -> tuple[np.ndarray, ...]:
    """Tilt, list and rotation of a pelvis, rotations (n, 3, 3), taken apart about y, x and z (Baker 2001).

    The rotation comes first, so that tilt and list do not depend on the heading.
    """
    tilt = np.arctan2(rotations[:, 1, 0], rotations[:, 1, 1])
    lean = np.arcsin(np.clip(-rotations[:, 1, 2], -1.0, 1.0))
    rotation = np.arctan2(rotations[:, 0, 2], rotations[:, 2, 2])
    is_locked = np.hypot(rotations[:, 0, 2], rotations[:, 2, 2]) < GIMBAL_LOCK
    return np.where(is_locked, np.nan, tilt), lean, np.where(is_locked, np.nan, rotation)


def elevation_angles(y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Plane and angle of elevation (Wu 2005) of right arms with y (n, 3), in the axes of the trunk."""
    elevation = np.arctan2(np.hypot(y[:, 0], y[:, 2]), y[:, 1])
    plane = np.arctan2(-y[:, 0], -y[:, 2])
    return np.where(np.hypot(y[:, 0], y[:, 2]) < HANGING, np.nan, plane), elevation


def set_upright(y: np.ndarray) -> np.ndarray:
    """Axes (n, 3, 3) of segments with these y (n, 3) that have no rotation about them, in proximal axes.

    Directions to the side, where flexion is not defined, are taken as adduction alone.
    """
    flexion, adduction = direction_angles(y)
    return np.asarray(Rotation.from_euler("ZX", np.stack([np.nan_to_num(flexion), adduction], axis=1)).as_matrix())


def hinge_rotations(axes: np.ndarray, distal: np.ndarray, sign: float) -> tuple[np.ndarray, np.ndarray]:
    """The rotation of segments about themselves that bends of a hinge show, rad, and the bends, degrees.

    Axes (n, 3, 3) come from `set_upright`, distal (n, 3) the y of the next ones in the same axes. The sign
    is 1 where a bend goes forward, as of an elbow, and -1 where it goes backward.
    """
    y = axes[:, :, 1]
    hinge = sign * np.cross(y, distal)
    rotation = np.arctan2((hinge * axes[:, :, 0]).sum(axis=1), (hinge * axes[:, :, 2]).sum(axis=1))
    return rotation, degrees_between(y, distal)


def partly(bend: np.ndarray) -> np.ndarray:
    """How far a rotation that a bend (n,) shows counts, from 0 for a straight limb to 1 for a bent one."""
    t = np.clip((bend - STRAIGHT_LIMB) / (BENT - STRAIGHT_LIMB), 0.0, 1.0)
    return t * t * (3.0 - 2.0 * t)


# --- axes -------------------------------------------------------------------------------------------------------------
# The axes of the segments in the reference pose.
#
# There are two kinds of reference pose. The *rest pose* of a skeleton is made by a program: arms may be held out,
# knees bent. There each segment has its own axes, with y along a limb, which are parallel in a straight limb. In a
# *standing pose* of the person, all joints are at zero by definition: the two segments of a joint have the same axes.


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


# --- measure ----------------------------------------------------------------------------------------------------------


class Joint(NamedTuple):
    """A joint between two segments, with the names of its three angles and the sign of the first."""

    name: str
    proximal: str
    distal: str
    angles: tuple[str, str, str]
    sign: float = 1.0

    def segments(self, side: str) -> tuple[str, str]:
        """The names of its segments, the proximal one first; side is "" in the middle."""
        proximal, distal = (
            name if name in ("pelvis", "trunk", "head") else f"{side}_{name}" for name in (self.proximal, self.distal)
        )
        return proximal, distal


MIDDLE = (
    Joint("trunk", "pelvis", "trunk", ("extension", "bending", "rotation")),
    Joint("neck", "trunk", "head", ("extension", "bending", "rotation")),
)
OF_SIDES = (
    Joint("hip", "pelvis", "thigh", ("flexion", "adduction", "rotation")),
    Joint("knee", "thigh", "shank", ("flexion", "adduction", "rotation"), -1.0),
    Joint("ankle", "shank", "foot", ("dorsiflexion", "inversion", "rotation")),
    Joint("shoulder", "trunk", "upper_arm", ("flexion", "adduction", "rotation")),
    Joint("elbow", "upper_arm", "forearm", ("flexion", "adduction", "pronation")),
    Joint("wrist", "forearm", "hand", ("flexion", "ulnar_deviation", "rotation")),
)
HINGES = {"thigh": ("shank", -1.0), "upper_arm": ("forearm", 1.0)}  # the next segment, and the sign of its bend

LOCKED = "flexion and rotation are one where the limb points to the side"
HANGS = f"an arm that hangs within {np.degrees(HANGING):.0f}° of the trunk has no plane of elevation"
NO_POINTS = "positions show it only by points off the line of the segment"
PALM = "no thumb next to the line of the hand shows where the palm is"
HINGE = "positions do not show it without points off the line of the limb above; the joint is taken for a hinge"
UPRIGHT_PELVIS = "tilt and rotation are one where the line of the hips is vertical"
UNSEEN = "positions of its points are not seen"
NO_TILT = "positions show only the line of the hips"
NO_HEAD = "positions do not show the rotation of a head without a point beyond its joint"
# Angles, 0 to 2, of joints below a line that depend on the rotation of the line about itself.
BELOW_LINES = {
    "knee": {1: HINGE, 2: HINGE},
    "elbow": {1: HINGE, 2: HINGE},
    "ankle": {1: NO_POINTS, 2: NO_POINTS},
    "wrist": dict.fromkeys(range(3), NO_POINTS),
}


class _Joints:
    """The joints of a motion, measured from the pelvis outward.

    `since` has the rotations (n_frames, 3, 3) of each segment since the reference, in the world. For segments that are
    lines in a motion fitted to positions, they are made of directions.
    """

    def __init__(self, motion: Motion, segments: dict[str, Segment], reference: Reference):
        self.segments, self.reference = segments, reference
        self.turned = turn_segments(motion, segments)
        self.lines, self.seen = find_seen(motion, segments)
        self.axes = rest_axes(reference, segments) if reference.is_rest else {}
        self.columns: dict[str, np.ndarray] = {}
        self.reasons: dict[str, str] = {}
        at_reference = reference.turned.since_zero
        self.since = {
            name: rotations @ at_reference[name].transpose(0, 2, 1)
            for name, rotations in self.turned.since_zero.items()
            if name not in self.lines
        }
        # Hips and shoulders show a trunk of which no three fixed points are seen.
        self.by_ends = {"pelvis", "trunk"} & self.lines
        if "trunk" in self.by_ends:
            self.lines.remove("trunk")
        for name in self.by_ends:
            before = _axes_by_lines(reference.turned, segments, name)
            self.since[name] = _axes_by_lines(self.turned, segments, name) @ before.transpose(0, 2, 1)

    def add(self, name: str, angles: np.ndarray, reason: str, *segments: str) -> None:
        """Add a column, rad, with the reason for NaN; it is also NaN if one of its segments is not seen."""
        seen = np.logical_and.reduce([np.ones(len(angles), bool), *(self.seen[segment] for segment in segments)])
        if not seen.all():
            reason = f"{reason}; {UNSEEN}" if np.isnan(angles[seen]).any() else UNSEEN
        self.columns[name] = np.where(seen, angles, np.nan)
        self.reasons[name] = reason

    def hide(self, name: str, reason: str, *segments: str) -> None:
        """Add a column of NaN."""
        self.add(name, np.full(len(self.turned.positions), np.nan), reason, *segments)

    def pelvis(self, world: np.ndarray) -> None:
        """Measure the pelvis relative to axes (3, 3) of the world."""
        tilt, pelvis_list, rotation = pelvis_angles(world.T @ self.since["pelvis"] @ self.reference.body)
        shown_by = self._shown_by("pelvis")
        if "pelvis" in self.lines:
            warn(f"{NO_TILT}: pelvis_tilt and trunk_extension are NaN, and hip flexion is relative to the trunk")
            self.hide("pelvis_tilt", NO_TILT)
        else:
            self.add("pelvis_tilt", tilt, UPRIGHT_PELVIS, *shown_by)
        self.add("pelvis_list", pelvis_list, UPRIGHT_PELVIS, *shown_by)
        self.add("pelvis_rotation", without_jumps(rotation, 2.0 * np.pi), UPRIGHT_PELVIS, *shown_by)

    def _shown_by(self, *names: str) -> list[str]:
        """The segments that must be seen to know others."""
        return [*names, "pelvis", "trunk"] if self.by_ends & {*names} else list(names)

    def measure(self, joint: Joint, side: str) -> None:
        """Measure a joint; side is "" in the middle."""
        proximal, distal = joint.segments(side)
        carriers = {self.segments[name].carrier for name in (proximal, distal) if name in self.segments}
        if len(carriers) < 2:
            return  # it lacks one, or nothing bends between them
        if distal in self.lines and not self.segments[distal].along.any():
            for angle in joint.angles:
                self.hide(f"{joint.name}_{angle}", NO_HEAD)
            return
        at_proximal, at_distal = self._axes_of(joint, side, proximal, distal)
        before = self.since[proximal] @ at_proximal
        shown_by = self._shown_by(proximal, distal)
        of_rotation, reasons = shown_by, [LOCKED] * 3
        if distal in self.lines and joint.distal == "foot":
            three = self._measure_foot(before, at_proximal, distal)
        elif distal in self.lines:
            following = f"{side}_{HINGES[joint.distal][0]}" if joint.distal in HINGES else ""
            three = self._measure_line(joint, before, at_distal, distal, following)
            if following in self.segments:
                of_rotation, reasons = (
                    [*shown_by, following],
                    [
                        LOCKED,
                        LOCKED,
                        f"positions do not show it; the next joint does where it is bent by {BENT:.0f}° and more",
                    ],
                )
        else:
            three = angles_of(before.transpose(0, 2, 1) @ self.since[distal] @ at_distal)
        hidden = self._hidden(joint, side, proximal, distal)
        mirror = -1.0 if side == "left" else 1.0
        for i, (angle, sign) in enumerate(zip(joint.angles, (joint.sign, mirror, mirror), strict=True)):
            name, segments = f"{joint.name}_{angle}" + (f"_{side}" if side else ""), of_rotation if i == 2 else shown_by
            if i in hidden:
                self.hide(name, hidden[i], *segments)
            else:
                self.add(name, sign * three[i] + 0.0, reasons[i], *segments)  # no −0
        if joint.name == "shoulder":
            y = (before.transpose(0, 2, 1) @ self.since[distal] @ at_distal)[:, :, 1] * [1.0, 1.0, mirror]
            plane, elevation = elevation_angles(y)
            self.add(f"shoulder_plane_{side}", plane, HANGS, *shown_by)
            self.add(f"shoulder_elevation_{side}", elevation, HANGS, *shown_by)

    def _hidden(self, joint: Joint, side: str, proximal: str, distal: str) -> dict[int, str]:
        """The angles of a joint, 0 to 2, that the motion or the reference pose does not show, and why."""
        hidden: dict[int, str] = {}
        if distal in self.lines and joint.distal == "foot":
            hidden = {1: NO_POINTS, 2: NO_POINTS}
        elif distal in self.lines and f"{side}_{HINGES.get(joint.distal, ('',))[0]}" not in self.segments:
            hidden = {2: NO_POINTS}
        if proximal in self.lines:  # how it is rotated about itself is not known
            hidden |= BELOW_LINES.get(joint.name, {})
        if joint.name in ("elbow", "wrist") and f"{side}_wrist" not in self.reference.lines:
            if joint.name == "wrist":
                hidden = dict.fromkeys(range(3), PALM)
            elif self.reference.is_rest:
                hidden[2] = PALM
        if joint.name == "trunk" and "pelvis" in self.lines:
            hidden[0] = NO_TILT
        return hidden

    def _axes_of(self, joint: Joint, side: str, proximal: str, distal: str) -> tuple[np.ndarray, np.ndarray]:
        """The axes of both segments of a joint in the reference pose."""
        if self.reference.is_rest:
            at_proximal, at_distal = self.axes[proximal], self.axes[distal]
        else:
            limb = self.segments[distal] if joint.distal in LIMBS and joint.distal != "foot" else None
            at_proximal = at_distal = joint_axes(self.reference, f"{side}_{joint.name}", limb)
        if joint.distal == "head" and distal in self.lines:  # its line need not be vertical in the reference
            y = self._upward(self.reference.turned, distal)[0]
            at_proximal = at_distal = rotation_onto(at_proximal[:, 1], y) @ at_proximal
        return at_proximal, at_distal

    def _upward(self, turned: Turned, name: str) -> np.ndarray:
        """The directions (n, 3) of y of a segment that is a line: up the head, and up a hanging limb."""
        return turned.direction(self.segments[name]) * (1.0 if name == "head" else -1.0)

    def _measure_line(
        self, joint: Joint, before: np.ndarray, at_distal: np.ndarray, distal: str, following: str
    ) -> tuple[np.ndarray, ...]:
        """Measure a joint whose distal segment is a line; the following segment may show its rotation."""
        y = np.einsum("nji,nj->ni", before, self._upward(self.turned, distal))
        axes = set_upright(y)
        rotation = np.full(len(y), np.nan)
        if following in self.segments:
            towards = np.einsum("nji,nj->ni", before, self._upward(self.turned, following))
            shown, bend = hinge_rotations(axes, towards, HINGES[joint.distal][1])
            rotation = np.where(bend >= BENT, shown, np.nan)
            axes = axes @ Rotation.from_euler("y", (partly(bend) * shown)[:, None]).as_matrix()
        self.since[distal] = before @ axes @ at_distal.T
        return *direction_angles(y), rotation

    def _measure_foot(self, before: np.ndarray, at_proximal: np.ndarray, distal: str) -> tuple[np.ndarray, ...]:
        """Measure the dorsiflexion of an ankle whose foot is a line, relative to the reference pose."""
        along = np.einsum("nji,nj->ni", before, self.turned.direction(self.segments[distal]))
        # At rest relative to a shank that is vertical on a horizontal sole.
        axes = self.axes[distal] if self.reference.is_rest else at_proximal
        toes = axes.T @ self.reference.direction(self.segments[distal])
        up = np.arctan2(along[:, 1], along[:, 0]) - np.arctan2(toes[1], toes[0])
        return ((up + np.pi) % (2.0 * np.pi) - np.pi,)


def _axes_by_lines(turned: Turned, segments: dict[str, Segment], name: str) -> np.ndarray:
    """Axes (n, 3, 3) of a pelvis or trunk by the line of hips or shoulders.

    y is from the hips to the shoulders, or away from the knees without shoulders.
    """
    z = turned.direction(segments[name])
    hips = turned.positions[:, segments["pelvis"].start] + turned.positions[:, segments["pelvis"].end]
    if "trunk" in segments:
        trunk = segments["trunk"]
        towards = turned.positions[:, trunk.start] + turned.positions[:, trunk.end] - hips
    else:
        towards = hips - sum(turned.positions[:, segments[f"{side}_thigh"].end] for side in SIDES)
    x = unit(np.cross(towards, z))
    return np.stack([x, np.cross(z, x), z], axis=2)


def measure(
    motion: Motion, segments: dict[str, Segment], reference: Reference
) -> tuple[dict[str, np.ndarray], dict[str, str], np.ndarray]:
    """The angles (n_frames,) of all joints by name, rad, relative to a reference pose, and the reasons for NaN.

    The last is the direction (3,) in the world relative to which the pelvis is rotated.
    """
    joints = _Joints(motion, segments, reference)
    world = rotation_onto(reference.body[:, 1], np.eye(3)["xyz".index(motion.up)]) @ reference.body
    joints.pelvis(world)
    for joint in MIDDLE:
        joints.measure(joint, "")
    for joint in OF_SIDES:
        for side in SIDES:
            joints.measure(joint, side)
    for (start, side), reason in reference.unknown.items():
        for name in joints.columns:
            if name.startswith(start) and name.endswith(side):
                joints.hide(name, reason)
    return joints.columns, joints.reasons, world[:, 0]


# --- zero -------------------------------------------------------------------------------------------------------------
# The pose in which joints are at zero: the rest pose of the skeleton, or a pose in which a person stands.
#
# All joints of a standing person are at zero by definition, so any bend in that pose is missing from all angles. The
# limits are chosen from recordings of people who stand and who walk.


# Largest deviation of a person who stands, degrees, and the least one that is reported. OpenCap's standing trial has 3
# at knees, 8 at shanks and 12 at upper arms, a standing person of CMU 16 to 25 at knees. No frame of walks and runs of
# OpenCap (131) and CMU (5,082) passes; with 30 some would. Few of HDM05's standing people pass: their skeletons bend
# the knees of a straight leg by 25 to 35, and the rest pose is a better zero.
LIMIT, SMALL = 25.0, 12.0
ELBOW_LIMIT = 45.0  # 35 in OpenCap's standing trial, 20 to 40 in standing people of CMU
FEW = 0.1  # share of the frames of a recording that may deviate more
STILL = 10.0  # degrees up to which the segments of a standing person rotate about their mean
# Segments whose relative rotation the lines of limbs do not show, such as twists: the outer and the inner one.
ROTATED = (
    ("pelvis", "trunk"),
    ("trunk", "head"),
    *(("pelvis", f"{side}_thigh") for side in SIDES),
    *((f"{side}_shank", f"{side}_foot") for side in SIDES),
)
NEEDED = ("pelvis", *(f"{side}_{limb}" for side in SIDES for limb in ("thigh", "shank")))
REMEDY = "pass zero=, a frame or recording of standing upright with hanging arms"


class Deviation(NamedTuple):
    """Deviation of a limb from a standing person's."""

    what: str
    degrees: float
    limit: float
    joints: tuple[tuple[str, str], ...] = ()  # joints without zero beyond the limit; empty: the person does not stand

    def __str__(self) -> str:
        return f"{self.what} by {self.degrees:.0f}°"


def find_zero(motion: Motion, zero: Any, person: Anatomy, segments: dict[str, Segment]) -> tuple[Reference, str]:
    """The pose to which angles are relative, and its description."""
    absent = [name for name in NEEDED if name not in segments]
    if absent:
        raise ValueError(f"{absent[0]} has no length at angle zero: pass joints= with other joints")
    rest = turn_segments(Motion(motion.skeleton, np.zeros((1, motion.skeleton.n_dofs)), 1.0), segments)
    at_rest = find_reference(motion.skeleton, person, segments, rest, None)
    if zero is not None:
        lines, _ = find_seen(motion, segments)
        return _find_standing(*_frames_of(zero, motion), person, segments, lines, not isinstance(at_rest, str))
    if isinstance(at_rest, str):
        raise ValueError(f"the rest pose is not upright: {at_rest}; {REMEDY}")
    if (found := find_up(motion, motion.up)) != motion.up:
        warn(f"motion.up is {motion.up!r}, but {describe_up(found)}: if {found[-1]} is up, read it with up={found!r}")
    if is_of_layout(motion.skeleton):
        warn(f"zero is the rest pose of the layout, from which people differ by 10 to 25°: {REMEDY}")
        return at_rest, "rest pose of the layout"
    return at_rest, "rest pose"


def _find_standing(
    standing: Motion, words: str, person: Anatomy, segments: dict[str, Segment], lines: set[str], stands_at_rest: bool
) -> tuple[Reference, str]:
    """The mean of frames in which a person stands as a reference, and its description.

    The motion shows only the direction of the segments that are `lines`.
    """
    up = np.eye(3)["xyz".index(standing.up)]
    turned, unseen, rotations_unseen = _turn_seen(standing, segments, words)
    deviations = _find_deviations(turned, {name: one for name, one in segments.items() if name not in unseen}, up)
    far = [each for each in deviations if each.degrees > each.limit]
    if fallen := [each for each in far if not each.joints]:
        raise ValueError(f"zero, {words}, is not upright: {_list(fallen)}; expected at most {LIMIT:.0f}°")
    n_frames = len(turned.positions)
    if n_frames > 1:
        some = f"{n_frames} of {len(standing)}" if n_frames < len(standing) else f"{n_frames}"
        words = f"mean of {some} standing frames"
    mean = turned.mean()
    _warn_of_movement(turned, mean)
    reference = find_reference(standing.skeleton, person, segments, mean, up)
    if isinstance(reference, str):
        raise ValueError(f"zero, {words}, is not upright: {reference}")
    unknown = {joint: f"in zero {each}" for each in reversed(far) for joint in each.joints}
    if unknown:
        names = ", ".join(f"{side} {joint}" for joint, side in sorted(unknown))
        warn(f"arms do not hang in zero, {words}: {_list(far)}. Angles of {names} are NaN")
    rotated = _find_rotated(mean) if stands_at_rest else []
    if bent := rotated + [each for each in deviations if each not in far and each.degrees > SMALL]:
        warn(f"in zero, {words}, {_list(bent)}: angles of these joints are relative to that pose")
    unknown |= {
        (joint.name, side): f"positions of its points are not seen in zero, {words}"
        for joint in (*MIDDLE, *OF_SIDES)
        for side in (SIDES if joint in OF_SIDES else ("",))
        if (unseen | rotations_unseen - lines) & {*joint.segments(side)}
    }
    return reference._replace(unknown=unknown), words


def _turn_seen(standing: Motion, segments: dict[str, Segment], words: str) -> tuple[Turned, set[str], set[str]]:
    """The segments in the frames that show as much as any frame, segments that are never shown, and lines."""
    lines, seen = find_seen(standing, segments)
    unseen = {name for name, frames in seen.items() if not frames.any()}
    frames = np.logical_and.reduce([seen[name] for name in segments if name not in unseen])
    if absent := [name for name in NEEDED if name in unseen]:
        raise ValueError(f"zero, {words}, does not show {', '.join(absent)}")
    if not frames.any():
        raise ValueError(f"zero, {words}, has no frame that shows all segments together")
    since_zero, positions = turn_segments(standing, segments)
    return Turned({name: each[frames] for name, each in since_zero.items()}, positions[frames]), unseen, lines


def _find_rotated(mean: Turned) -> list[Deviation]:
    """The segments rotated from the rest pose by more than the limit, twists included."""
    found = []
    for outer, inner in ROTATED:
        if outer in mean.since_zero and inner in mean.since_zero:
            between = mean.since_zero[outer][0].T @ mean.since_zero[inner][0]
            degrees = float(np.degrees(Rotation.from_matrix(between).magnitude()))
            if degrees > LIMIT:
                found.append(Deviation(f"its {inner.replace('_', ' ')} is rotated from the rest pose", degrees, LIMIT))
    return sorted(found, key=lambda each: -each.degrees)


def _frames_of(zero: Any, motion: Motion) -> tuple[Motion, str]:
    """The frames in which the person should stand, and their description."""
    if isinstance(zero, Motion):
        if zero.skeleton != motion.skeleton or zero.up != motion.up or not len(zero):
            raise ValueError("zero must have frames, and the skeleton and up axis of the motion")
        return zero, f"a recording of {len(zero)} frames"
    if isinstance(zero, bool) or not isinstance(zero, (int, np.integer)):
        raise TypeError(f"zero must be the number of a frame, a Motion or None, got {type(zero).__name__}")
    if not -len(motion) <= zero < len(motion):
        raise ValueError(f"zero is frame {zero} of a motion with {len(motion)} frames")
    return motion[zero], f"frame {zero % len(motion)}"


def _find_deviations(turned: Turned, segments: dict[str, Segment], up: np.ndarray) -> list[Deviation]:
    """Deviations of limbs from a standing person's, except in the `FEW` worst frames."""
    along = {name: turned.direction(segment) for name, segment in segments.items()}
    down = np.broadcast_to(-up, along["pelvis"].shape)
    hips = np.broadcast_to(along["pelvis"].mean(axis=0), down.shape)
    pairs: list[tuple[str, np.ndarray | None, np.ndarray | None, float, tuple[tuple[str, str], ...]]] = [
        ("the line of its hips is rotated", along["pelvis"], hips, LIMIT, ()),
        ("its thighs are apart", along["left_thigh"], along["right_thigh"], LIMIT, ()),
    ]
    trunk = down
    if "trunk" in segments:
        ends = [
            turned.positions[:, segments[name].start] + turned.positions[:, segments[name].end]
            for name in ("pelvis", "trunk")
        ]
        trunk = ends[0] - ends[1]
        pairs.append(("its trunk leans", trunk, down, LIMIT, ()))
    for side in SIDES:
        thigh, shank, arm, forearm = (
            along.get(f"{side}_{limb}") for limb in ("thigh", "shank", "upper_arm", "forearm")
        )
        pairs += [
            (f"its {side} thigh is away from down", thigh, down, LIMIT, ()),
            (f"its {side} shank is away from down", shank, down, LIMIT, ()),
            (f"its {side} knee is bent", thigh, shank, LIMIT, ()),
            (f"its {side} upper arm is away from the trunk", arm, trunk, LIMIT, (("shoulder", side), ("elbow", side))),
            (f"its {side} elbow is bent", arm, forearm, ELBOW_LIMIT, (("elbow", side),)),
        ]
    found = [
        Deviation(what, float(np.quantile(degrees_between(a, b), 1.0 - FEW)), limit, joints)
        for what, a, b, limit, joints in pairs
        if a is not None and b is not None
    ]
    return sorted(found, key=lambda each: -each.degrees)


def _warn_of_movement(turned: Turned, mean: Turned) -> None:
    """Warn if a segment rotates much about its mean."""
    for name, each in turned.since_zero.items():
        degrees = float(np.degrees(Rotation.from_matrix(mean.since_zero[name][0].T @ each).magnitude().max()))
        if degrees > STILL:
            warn(f"the person moves in the recording zero: {name} rotates by {degrees:.0f}°; pass a still part")
            return


def _list(deviations: list[Deviation]) -> str:
    """The three largest deviations."""
    return ", ".join(map(str, deviations[:3]))
