"""Feet and pelvis of a motion in the world: the joints that show them, their positions, velocities and heading.

Positions are turned so that the last axis points up, by exchanging axes in a cycle, which keeps left and right.
"""

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np
from scipy.ndimage import gaussian_filter1d
from scipy.signal import butter, sosfiltfilt

from skpose._validation.names import near_names
from skpose._validation.options import check_kind
from skpose._warnings import warn
from skpose.biomechanics._person import check_joints
from skpose.biomechanics._seen import find_shown
from skpose.kinematics import forward_kinematics
from skpose.kinematics._shared import find_landmarks
from skpose.skeleton import Motion, Skeleton
from skpose.skeleton._shared import describe_up, find_up, root_orientations

SIDES = ("left", "right")
PARTS = ("hip", "ankle", "toe")
MARKS = tuple(f"{side}_{part}" for side in SIDES for part in PARTS)
LEAST_RATE = 25.0  # Hz; the contact of a running foot then has some six frames
CUTOFF = 10.0  # Hz, of the low-pass filter
HEADING = 0.25  # s, standard deviation of the weights over which velocity is averaged to find where one travels
LONGEST_GAP = 0.1  # s without frames that is filled
LEGS = (0.2, 1.5)  # m, from hip to ankle, of an infant and of a giant
# What the pelvis moves and turns at most between two frames, and the error of a frame. Sprinters reach 12 m/s, figure
# skaters 2,050°/s. Of 235 recordings of CMU and HDM05 the fastest has 4.4 m/s and 670°/s, but for CMU 03_02, which is
# still for 24 frames and 11 cm on in the next one.
FASTEST, ERROR = 12.0, 0.01  # m/s, m
FASTEST_TURN, ERROR_OF_TURN = 2200.0, 5.0  # °/s, °
STILL = 1e-6  # m, by which a root that is not recorded moves


class Feet(NamedTuple):
    """Pelvis and feet over time, up last; the two sides are left and right."""

    times: np.ndarray  # (n,) s, evenly spaced
    pelvis: np.ndarray  # (n, 3) m, amid the hips
    travel: np.ndarray  # (n, 2) m/s, velocity of the pelvis along the floor, averaged over about a step
    facing: np.ndarray  # (n, 2) unit vectors along the floor, ahead of the pelvis
    ankles: np.ndarray  # (2, n, 3) m
    toes: np.ndarray  # (2, n, 3) m
    leg: float  # m, from hip to ankle where the leg is longest

    @property
    def step(self) -> float:
        """Time from frame to frame, s."""
        return float(self.times[1] - self.times[0])


def find_feet(skeleton: Skeleton, joints: Mapping[str, str] | None) -> dict[str, str]:
    """Return the names of the joints at hips, ankles and toes: those that the user gives, others by known rigs."""
    given = {} if joints is None else dict(joints)
    unknown = [mark for mark in given if mark not in MARKS]
    if unknown:
        raise ValueError(f"joints must have keys among {', '.join(map(repr, MARKS))}, got {unknown[0]!r}")
    for mark, name in given.items():
        if name not in skeleton.joint_names:
            hint = near_names(skeleton.joint_names, str(name))
            raise ValueError(f"joints has {name!r} as {mark!r}, which is no joint of the skeleton: {hint}")
    landmarks = find_landmarks(skeleton)
    found = {}
    for mark in MARKS:
        # The toe markers of gait laboratories are where the toes begin; toe tips are noisy in many files.
        names = (mark.replace("toe", "ball"), mark)
        joint = next((landmarks.joints[name] for name in names if name in landmarks.joints), None)
        if joint is not None:
            found[mark] = skeleton.joint_names[joint]
    found |= given
    missing = [mark for mark in MARKS if mark not in found]
    if missing:
        of = f"of {landmarks.rig}" if landmarks.rig else "of no rig that is known"
        reason = f" ({landmarks.reason})" if landmarks.reason else ""
        raise ValueError(
            f"hips, ankles and the front of the feet must be known, but the skeleton is {of}{reason} and shows no "
            f"{', '.join(missing)}: pass joints={{{missing[0]!r}: NAME, ...}}, names of motion.skeleton.joint_names. "
            "Without a point at the front of the foot it is not seen when the foot leaves the floor"
        )
    for name in found.values():
        marks = [mark for mark, other in found.items() if other == name]
        if len(marks) > 1:
            raise ValueError(f"hips, ankles and toes must be different joints, but {' and '.join(marks)} are {name!r}")
    if given:
        numbers = {mark: skeleton.joint_names.index(joint) for mark, joint in found.items()}
        check_joints(skeleton, landmarks._replace(joints=landmarks.joints | numbers), given)
    return found


def check_recording(motion: Motion) -> None:
    """Refuse what shows no gait: too low a frame rate, too few frames, no movement of the root, another axis up."""
    check_kind(motion, Motion, "motion", "gait needs the positions of the root and a frame rate")
    if motion.frame_rate < LEAST_RATE:
        raise ValueError(
            f"gait events need at least {LEAST_RATE:g} Hz, as a runner's foot stands for a quarter of a second; "
            f"the motion has {motion.frame_rate:g} Hz: use the recording before it was resampled"
        )
    if len(motion) < 2:
        raise ValueError(f"gait events need a recording of at least a stride, got a motion of {len(motion)} frames")
    if (np.ptp(motion.root_positions, axis=0) <= STILL).all():
        raise ValueError(
            "gait needs to know where the person is, but all root_positions of the motion are one: the file has none, "
            "or they were left out. On a treadmill add what the belt moves: dataclasses.replace(motion, "
            "root_positions=motion.root_positions + np.outer(motion.times, belt_velocity))"
        )
    if (found := find_up(motion, motion.up)) != motion.up:
        raise ValueError(
            f"gait needs the axis that points up: motion.up is {motion.up!r}, but {describe_up(found)}. Where "
            "another axis points up, dataclasses.replace(motion, up=...) states so"
        )
    gap = np.diff(motion.frame_numbers).max() / motion.frame_rate
    if gap > LONGEST_GAP + 1.5 / motion.frame_rate:
        frame = int(np.diff(motion.frame_numbers).argmax())
        raise ValueError(
            f"gait events need all frames, but {gap:.2g} s are missing after frame {frame}: cut the motion there, "
            f"motion[:{frame + 1}] and motion[{frame + 1}:]"
        )


def feet_of(motion: Motion, joints: Mapping[str, str]) -> Feet:
    """Return pelvis and feet in the world, low-pass filtered."""
    skeleton = motion.skeleton
    columns = [skeleton.joint_names.index(joints[mark]) for mark in MARKS]
    relative = forward_kinematics(motion.angles, skeleton)[:, columns]
    turned = root_orientations(motion.root_angles, motion.root_axes)
    here = np.stack([turned.apply(relative[:, i]) for i in range(len(columns))]) + motion.root_positions
    shown = _find_frames(motion, columns)
    feet = feet_at(here[:, shown][..., _axes(motion.up)], motion.frame_numbers[shown], motion.frame_rate)
    metre = 1.0
    if not LEGS[0] <= feet.leg <= LEGS[1]:
        metre = feet.leg  # as that of a person is nearly one
        warn(
            f"legs of {feet.leg:.3g} m from hip to ankle are no person's, and lengths and speeds are not in metres: "
            "read the file with another scale="
        )
    _check_jumps(here[[MARKS.index("left_hip"), MARKS.index("right_hip")]] / metre, motion)
    return feet


def _find_frames(motion: Motion, columns: list[int]) -> np.ndarray:
    """Return the frames that show hips and feet; refuse long times between them, and ends that do not."""
    frames = np.flatnonzero(find_shown(motion, columns).all(axis=1))
    if not len(frames):
        raise ValueError("gait events need hips and feet, but no frame shows all of them: positions are not seen")
    first, last = int(frames[0]), int(frames[-1])
    if last - first + 1 < len(motion):
        raise ValueError(
            f"gait events need hips and feet in all frames, but only from frame {first} to {last} of {len(motion)} "
            f"positions of all of them are seen: pass motion[{first}:{last + 1}]"
        )
    gaps = np.diff(frames) - 1
    if gaps.max(initial=0) > LONGEST_GAP * motion.frame_rate:
        before = int(frames[gaps.argmax()])
        after = before + int(gaps.max()) + 1
        raise ValueError(
            f"gait events need hips and feet in all frames, but positions of some are not seen for "
            f"{gaps.max() / motion.frame_rate:.2g} s, from frame {before + 1} to {after - 1}: cut the motion there, "
            f"motion[:{before + 1}] and motion[{after}:]"
        )
    return frames


def _check_jumps(hips: np.ndarray, motion: Motion) -> None:
    """Refuse motions in which the pelvis, between hips at (2, n, 3) m, is elsewhere from one frame to the next one."""
    hips = _without_spikes(hips)
    seconds = np.diff(motion.frame_numbers) / motion.frame_rate
    metres = np.linalg.norm(np.diff(hips.mean(axis=0), axis=0), axis=1)
    across = hips[1] - hips[0]
    sine, cosine = np.linalg.norm(np.cross(across[:-1], across[1:]), axis=1), (across[:-1] * across[1:]).sum(axis=1)
    degrees = np.degrees(np.arctan2(sine, cosine))
    for steps, unit, verb, limit, error in (
        (metres, " m", "moves", FASTEST, ERROR),
        (degrees, "°", "turns", FASTEST_TURN, ERROR_OF_TURN),
    ):
        most = int((steps - limit * seconds).argmax())
        if steps[most] > limit * seconds[most] + error:
            raise ValueError(
                f"the pelvis {verb} by {steps[most]:.3g}{unit} from frame {most} to the next, in {seconds[most]:.2g} "
                f"s, which nobody does (at most {limit:,.0f}{unit}/s): one recording ends there and another one "
                "begins, frames are missing, or positions are wrong. Cut the motion there, "
                f"motion[:{most + 1}] and motion[{most + 1}:]"
            )


def _axes(up: str) -> list[int]:
    """Return the axes of the world in a cycle that ends with the one that points up."""
    i = "xyz".index(up)
    return [(i + 1) % 3, (i + 2) % 3, i]


def to_world(positions: np.ndarray, up: str) -> np.ndarray:
    """Return positions (n, 3) whose last axis points up in the axes of the world."""
    return positions[:, np.argsort(_axes(up))]


def _without_spikes(positions: np.ndarray) -> np.ndarray:
    """Return the median of each frame of (6, n, 3) and its two neighbours, "3" with Tukey's rule at the ends.

    There the third value is the one to which the next two medians point, two frames on (J. W. Tukey, "Exploratory data
    analysis", 1977): a low-pass filter would take a spike in the first or the last frame for a movement.
    """
    if positions.shape[1] < 4:
        return positions
    smooth = positions.copy()
    smooth[:, 1:-1] = np.median([positions[:, :-2], positions[:, 1:-1], positions[:, 2:]], axis=0)
    for end, near, far in ((0, 1, 2), (-1, -2, -3)):
        ahead = 3.0 * smooth[:, near] - 2.0 * smooth[:, far]
        smooth[:, end] = np.median([positions[:, end], smooth[:, near], ahead], axis=0)
    return smooth


def feet_at(positions: np.ndarray, numbers: np.ndarray, rate: float) -> Feet:
    """Return pelvis and feet from the positions (6, n, 3) of `MARKS`, up last, at numbered frames."""
    every = np.arange(numbers[0], numbers[-1] + 1)
    if len(every) > len(numbers):
        positions = np.stack([[np.interp(every, numbers, x) for x in mark.T] for mark in positions]).transpose(0, 2, 1)
    positions = _without_spikes(positions)
    low_pass = butter(2, CUTOFF, fs=rate, output="sos")
    positions = sosfiltfilt(low_pass, positions, axis=1, padlen=min(9, positions.shape[1] - 1))
    left_hip, left_ankle, left_toe, right_hip, right_ankle, right_toe = positions
    pelvis = (left_hip + right_hip) / 2.0
    travel = gaussian_filter1d(np.gradient(pelvis[:, :2], 1.0 / rate, axis=0), HEADING * rate, axis=0, mode="nearest")
    to_right = (right_hip - left_hip)[:, :2]
    facing = np.stack([-to_right[:, 1], to_right[:, 0]], axis=1)
    facing /= np.maximum(np.linalg.norm(facing, axis=1, keepdims=True), 1e-12)
    legs = [np.linalg.norm(hip - ankle, axis=1) for hip, ankle in ((left_hip, left_ankle), (right_hip, right_ankle))]
    return Feet(
        every / rate,
        pelvis,
        travel,
        facing,
        np.stack([left_ankle, right_ankle]),
        np.stack([left_toe, right_toe]),
        float(np.max(legs)),
    )
