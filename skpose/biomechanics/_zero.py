"""The pose in which joints are at zero: the rest pose of the skeleton, or a pose in which a person stands.

All joints of a standing person are at zero by definition, so any bend in that pose is missing from all angles. The
limits are chosen from recordings of people who stand and who walk.
"""

from typing import Any, NamedTuple

import numpy as np
from scipy.spatial.transform import Rotation

from skpose._utils.warnings import warn
from skpose.biomechanics._angles import degrees_between
from skpose.biomechanics._axes import Reference, find_reference
from skpose.biomechanics._measure import MIDDLE, OF_SIDES
from skpose.biomechanics._seen import find_seen
from skpose.biomechanics._segments import Segment, Turned, turn_segments
from skpose.keypoints._fit import is_of_layout
from skpose.kinematics._anatomy import SIDES, Anatomy
from skpose.skeleton import Motion
from skpose.skeleton._upright import describe_up, find_up

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
        lines = find_seen(motion, segments).lines
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
    if bent := [each for each in deviations if each not in far and each.degrees > SMALL]:
        warn(f"in zero, {words}, {_list(bent)}: angles of these joints are relative to that pose")
    if stands_at_rest and (rotated := _find_rotated(mean)):
        warn(f"in zero, {words}, {_list(rotated)} relative to the rest pose, and so are angles of these joints")
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
                found.append(Deviation(f"its {inner.replace('_', ' ')} is rotated", degrees, LIMIT))
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
    return motion[int(zero)], f"frame {int(zero) % len(motion)}"


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
