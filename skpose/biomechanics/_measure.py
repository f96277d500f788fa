"""Measure the angles of all joints."""

from typing import NamedTuple

import numpy as np
from scipy.spatial.transform import Rotation

from skpose._utils.warnings import warn
from skpose.biomechanics._angles import (
    BENT,
    HANGING,
    angles_of,
    direction_angles,
    elevation_angles,
    hinge_rotations,
    partly,
    pelvis_angles,
    set_upright,
)
from skpose.biomechanics._axes import Reference, joint_axes, rest_axes, rotation_onto
from skpose.biomechanics._seen import find_seen
from skpose.biomechanics._segments import LIMBS, Segment, Turned, turn_segments
from skpose.kinematics._anatomy import SIDES
from skpose.kinematics._lines import unit
from skpose.motions._phases import without_jumps
from skpose.skeleton import Motion


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
        if not {proximal, distal} <= self.segments.keys():
            return
        if self.segments[proximal].carrier == self.segments[distal].carrier:
            return  # nothing bends between them
        if distal in self.lines and not self.segments[distal].along.any():
            for angle in joint.angles:
                self.hide(
                    f"{joint.name}_{angle}",
                    "positions do not show the rotation of a head without a point beyond its joint",
                )
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
    vertical = np.eye(3)["xyz".index(motion.up)]
    world = rotation_onto(reference.body[:, 1], vertical) @ reference.body
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
