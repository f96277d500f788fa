"""The pose in which joints are at zero: the rest pose of the skeleton, or one in which a person stands, and whether so.

All joints of a standing person are at zero by definition, so that what they are bent by is missing from all angles. The
limits are chosen from recordings of people who stand and who walk.
"""

from typing import Any, NamedTuple

import numpy as np
from scipy.spatial.transform import Rotation

from skpose._validation.motions import is_motion
from skpose._warnings import warn
from skpose.biomechanics._axes import EXCHANGED, Reference, find_reference
from skpose.biomechanics._measure import MIDDLE, OF_SIDES
from skpose.biomechanics._seen import find_seen
from skpose.biomechanics._segments import SIDES, Segment, Turned, turn_segments
from skpose.keypoints._shared import is_of_layout
from skpose.skeleton import Motion
from skpose.skeleton._shared import describe_up, find_up

# Degrees up to which limbs are as of a person who stands, and from which that is said. OpenCap's standing trial has 3
# at knees, 8 at shanks and 12 at upper arms, a standing person of CMU 16 to 25 at knees. No frame of walks and runs
# passes, of OpenCap's (131) and CMU's (5,082); with 30 some would. Few of HDM05's standing people pass: their
# skeletons bend the knees of a straight leg by 25 to 35, and the rest pose is a better zero.
LIMIT, SMALL = 25.0, 12.0
ELBOW_LIMIT = 45.0  # 35 in OpenCap's standing trial, 20 to 40 in standing people of CMU
FEW = 0.1  # share of the frames of a recording which need not stand
STILL = 10.0  # degrees up to which the segments of a standing person rotate about their mean
# Joints whose rotation the lines of limbs do not show, such as twists and that of feet: the outer segment, the inner.
ROTATED = (
    ("pelvis", "trunk"),
    ("trunk", "head"),
    *(("pelvis", f"{side}_thigh") for side in SIDES),
    *((f"{side}_shank", f"{side}_foot") for side in SIDES),
)
NEEDED = ("pelvis", *(f"{side}_{limb}" for side in SIDES for limb in ("thigh", "shank")))
REMEDY = (
    "pass zero=, a frame of the motion in which the person stands upright with hanging arms, or a recording of "
    "that on the same skeleton"
)
REMEDY_OF_SIDES = (
    "exchange left and right in joints=; where the skeleton's own names are exchanged, pass joints= with all landmarks "
    "of both sides; where it is a mirror image, an axis of the file has the wrong sign"
)


class Deviation(NamedTuple):
    """A limb that is not where it is in a person who stands."""

    what: str  # in words
    degrees: float
    limit: float
    joints: tuple[tuple[str, str], ...] = ()  # those that have no zero beyond the limit; none: nobody stands

    def __str__(self) -> str:
        return f"{self.what} by {self.degrees:.0f}°"


def find_zero(motion: Motion, zero: Any, segments: dict[str, Segment]) -> tuple[Reference, str]:
    """Return the pose to which angles are relative, and what it is in words."""
    for name in NEEDED:
        if name not in segments:
            raise ValueError(
                f"the {name.replace('_', ' ')} of this skeleton has no length at angle zero: expected hips, knees and "
                "ankles that are apart; pass joints= with others"
            )
    rest = turn_segments(Motion(motion.skeleton, np.zeros((1, motion.skeleton.n_dofs)), 1.0), segments)
    at_rest = find_reference(motion.skeleton, segments, rest, None)
    if zero is not None:
        remedy = REMEDY
        if not isinstance(at_rest, str):
            remedy += "; or leave zero out, as somebody stands in the rest pose of the skeleton"
        lines = find_seen(motion, segments).lines
        return _find_standing(*_frames_of(zero, motion), segments, lines, remedy, not isinstance(at_rest, str))
    if isinstance(at_rest, str):
        remedy = REMEDY_OF_SIDES if at_rest == EXCHANGED else REMEDY
        raise ValueError(f"nobody stands in the rest pose of this skeleton, at angle zero: {at_rest}. So {remedy}")
    if complaint := _complain_of_up(motion):
        warn(f"{complaint}. Else the person lies or is upside down, and so are tilt, list and rotation of the pelvis")
    if is_of_layout(motion.skeleton):
        warn(
            "zero is how the person of the layout stands, to which the skeleton was fitted, and not the one who was "
            f"recorded, whose hips, knees and ankles may differ from it by 10 to 25°: {REMEDY}"
        )
        return at_rest, "rest pose of the layout"
    return at_rest, "rest pose"


def _find_standing(
    standing: Motion,
    words: str,
    segments: dict[str, Segment],
    lines: set[str],
    remedy: str,
    stands_at_rest: bool,
) -> tuple[Reference, str]:
    """Return the mean of frames in which a person stands as a reference, and what it is in words.

    Of the segments that are `lines` the motion does not show more than the direction.
    """
    up = np.eye(3)["xyz".index(standing.up)]
    turned, unseen, rotations_unseen = _turn_seen(standing, segments, words)
    deviations = _find_deviations(turned, {name: one for name, one in segments.items() if name not in unseen}, up)
    n_frames = len(turned.positions)
    often = "in a tenth of them at least " if n_frames > 1 else ""
    far = [each for each in deviations if each.degrees > each.limit]
    if fallen := [each for each in far if not each.joints]:
        complaint = _complain_of_up(standing)
        raise ValueError(
            f"nobody stands in zero, {words}: {often}{_list(fallen)}; expected at most {LIMIT:.0f}°. "
            f"{f'And {complaint}. ' if complaint else ''}So {remedy}"
        )
    if n_frames > 1:
        some = f"{n_frames} of {len(standing)}" if n_frames < len(standing) else f"{n_frames}"
        words = f"mean of {some} standing frames"
    if (most := _least_still(turned)) is not None:
        warn(
            f"the recording zero is no standing person: its {most[0]} rotates by {most[1]:.0f}° about its mean; pass a "
            "part in which the person stands still, zero[start:stop]"
        )
    mean = turned.mean()
    reference = find_reference(standing.skeleton, segments, mean, up)
    if isinstance(reference, str):
        remedy = REMEDY_OF_SIDES if reference == EXCHANGED else remedy
        raise ValueError(f"nobody stands in zero, {words}: {reference}. So {remedy}")
    unknown = {joint: f"in zero {each}" for each in reversed(far) for joint in each.joints}
    if unknown:
        warn(
            f"arms do not hang in zero, {words}: {often}{_list(far)}; expected at most {LIMIT:.0f}°, at elbows "
            f"{ELBOW_LIMIT:.0f}°. So angles of {', '.join(f'{side} {joint}' for joint, side in sorted(unknown))} are "
            f"NaN: {remedy}"
        )
    if bent := [each for each in deviations if each not in far and each.degrees > SMALL]:
        warn(
            f"in zero, {words}, {_list(bent)}. Angles are relative to that pose: those of these joints lack as much. "
            "Where the person stands straighter, pass zero= of that"
        )
    if stands_at_rest and (rotated := _find_rotated(mean)):
        warn(
            f"in zero, {words}, {_list(rotated)} from the rest pose of the skeleton, in which somebody stands, too. If "
            "the person does not stand straight in zero, from feet to head, angles of these joints lack as much: pass "
            "another zero="
        )
    unknown |= {
        (joint.name, side): f"positions of its points are not seen in zero, {words}"
        for joint in (*MIDDLE, *OF_SIDES)
        for side in (SIDES if joint in OF_SIDES else ("",))
        if (unseen | rotations_unseen - lines) & {*joint.segments(side)}
    }
    return reference._replace(unknown=unknown), words


def _turn_seen(standing: Motion, segments: dict[str, Segment], words: str) -> tuple[Turned, set[str], set[str]]:
    """Return the segments in the frames that show all that any frame shows, those of which none is shown, and lines."""
    lines, seen = find_seen(standing, segments)
    unseen = {name for name, frames in seen.items() if not frames.any()}
    frames = np.logical_and.reduce([seen[name] for name in segments if name not in unseen])
    absent = [name.replace("_", " ") for name in NEEDED if name in unseen]
    if absent or not frames.any():
        what = f"points of its {' and its '.join(absent)} are in none of them"
        if not absent:
            what = "the segments that are seen in some frames are in no frame seen together"
        raise ValueError(f"zero, {words}, does not show all of a person who stands: {what}. So {REMEDY}")
    return turn_segments(standing, segments).choose(frames), unseen, lines


def _find_rotated(mean: Turned) -> list[Deviation]:
    """Return the joints of a pose that are rotated from the rest pose by more than the limit, twists included."""
    found = []
    for outer, inner in ROTATED:
        if outer in mean.since_zero and inner in mean.since_zero:
            between = mean.since_zero[outer][0].T @ mean.since_zero[inner][0]
            degrees = float(np.degrees(Rotation.from_matrix(between).magnitude()))
            if degrees > LIMIT:
                found.append(Deviation(f"its {inner.replace('_', ' ')} is rotated", degrees, LIMIT))
    return sorted(found, key=lambda each: -each.degrees)


def _frames_of(zero: Any, motion: Motion) -> tuple[Motion, str]:
    """Return the frames in which a person shall stand, and what they are in words."""
    if is_motion(zero):
        if zero.skeleton != motion.skeleton:
            raise ValueError(
                "zero has another skeleton than the motion: fit one to both recordings, "
                "fit_skeleton([standing, moving], layout), or pass skpose.kinematics.retarget(zero, motion.skeleton)"
            )
        if zero.up != motion.up:
            raise ValueError(f"zero has up={zero.up!r}, but the motion up={motion.up!r}: their worlds are not the same")
        if not len(zero):
            raise ValueError("zero has no frames; expected a recording of a person who stands")
        return zero, f"a recording of {len(zero)} frames"
    if isinstance(zero, bool) or not isinstance(zero, (int, np.integer)):
        raise TypeError(f"zero must be the number of a frame, a Motion or None, got {type(zero).__name__}")
    if not -len(motion) <= zero < len(motion):
        raise ValueError(f"zero is frame {zero} of a motion of {len(motion)} frames, 0 to {len(motion) - 1}")
    return motion[int(zero) % len(motion)], f"frame {int(zero) % len(motion)}"


def _find_deviations(turned: Turned, segments: dict[str, Segment], up: np.ndarray) -> list[Deviation]:
    """Return how far limbs are from those of a person who stands, in the frames but for the `FEW` that are farthest."""
    along = {name: turned.direction(segment) for name, segment in segments.items()}
    found: list[Deviation] = []

    def add(what: str, a: np.ndarray, b: np.ndarray, *joints: tuple[str, str], limit: float = LIMIT) -> None:
        angles = np.degrees(np.arctan2(np.linalg.norm(np.cross(a, b), axis=1), (a * b).sum(axis=1)))
        found.append(Deviation(what, float(np.quantile(angles, 1.0 - FEW)), limit, joints))

    down = np.broadcast_to(-up, along["pelvis"].shape)
    hips = along["pelvis"].mean(axis=0)
    add("the line of its hips is rotated", along["pelvis"], np.broadcast_to(hips, down.shape))
    add("its thighs are apart", along["left_thigh"], along["right_thigh"])
    trunk = down
    if "trunk" in segments:
        ends = [
            turned.positions[:, segments[name].start] + turned.positions[:, segments[name].end]
            for name in ("pelvis", "trunk")
        ]
        trunk = ends[0] - ends[1]
        add("its trunk leans", trunk, down)
    for side in SIDES:
        thigh, shank = (along[f"{side}_{limb}"] for limb in ("thigh", "shank"))
        add(f"its {side} thigh is away from down", thigh, down)
        add(f"its {side} shank is away from down", shank, down)
        add(f"its {side} knee is bent", thigh, shank)
        arm, forearm = (along.get(f"{side}_{limb}") for limb in ("upper_arm", "forearm"))
        if arm is not None:
            add(f"its {side} upper arm is away from the trunk", arm, trunk, ("shoulder", side), ("elbow", side))
            if forearm is not None:
                add(f"its {side} elbow is bent", arm, forearm, ("elbow", side), limit=ELBOW_LIMIT)
    return sorted(found, key=lambda each: -each.degrees)


def _least_still(turned: Turned) -> tuple[str, float] | None:
    """Return the segment that rotates most about its mean, and by how many degrees; None if all stand still."""
    mean = turned.mean()
    most = max(
        (float(np.degrees(Rotation.from_matrix(mean.since_zero[name][0].T @ each).magnitude().max())), name)
        for name, each in turned.since_zero.items()
    )
    return (most[1], most[0]) if most[0] > STILL else None


def _complain_of_up(motion: Motion) -> str:
    """Return in words what speaks against the axis of a motion that points up; empty where nothing does."""
    found = find_up(motion, motion.up)
    if found == motion.up:
        return ""
    remedy = f"if {found[-1]} points up, read the file with up={found!r}"
    return f"motion.up is {motion.up!r}, but {describe_up(found)}; {remedy}"


def _list(deviations: list[Deviation]) -> str:
    """Return the three largest deviations in words."""
    others = f" and {len(deviations) - 3} more" if len(deviations) > 3 else ""
    return ", ".join(map(str, deviations[:3])) + others
