"""Feet and pelvis of a motion in the world: their joints, positions, velocities and heading.

Positions are rotated so that the last axis points up, by a cyclic exchange of axes, which keeps left and right.
"""

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np
from scipy.ndimage import gaussian_filter1d, median_filter
from scipy.signal import butter, sosfiltfilt

from skpose._utils.validation import check_kind
from skpose._utils.warnings import warn
from skpose.biomechanics._angles import degrees_between
from skpose.biomechanics._person import find_person, require
from skpose.biomechanics._seen import find_shown
from skpose.kinematics._anatomy import SIDES
from skpose.motions._phases import LONGEST_GAP
from skpose.skeleton import Motion, Skeleton
from skpose.skeleton._upright import describe_up, find_up

PARTS = ("hip", "ankle", "toe")
MARKS = tuple(f"{side}_{part}" for side in SIDES for part in PARTS)
LEAST_RATE = 25.0  # Hz; the contact of a running foot then has some six frames
CUTOFF = 10.0  # Hz, of the low-pass filter
HEADING = 0.25  # s, standard deviation of the weights in the mean velocity, the direction of travel
LEGS = (0.2, 1.5)  # m, from hip to ankle, shortest and longest
# Largest movement of the pelvis between two frames, and the error of a frame. Sprinters reach 12 m/s, figure skaters
# 2,050°/s. The fastest of 235 recordings of CMU and HDM05 has 4.4 m/s and 670°/s, except CMU 03_02, which jumps.
FASTEST, ERROR = 12.0, 0.01  # m/s, m
FASTEST_TURN, ERROR_OF_TURN = 2200.0, 5.0  # °/s, °
STILL = 1e-6  # m, largest movement of a root at rest


class Feet(NamedTuple):
    """Pelvis and feet over time, up last; the two sides are left and right."""

    step: float  # s, from frame to frame
    seen: np.ndarray  # (2, n) whether hips, ankle and toe are seen, short gaps included
    pelvis: np.ndarray  # (n, 3) m, amid the hips
    travel: np.ndarray  # (n, 2) m/s, velocity of the pelvis along the floor, averaged over about a step
    facing: np.ndarray  # (n, 2) unit vectors along the floor, ahead of the pelvis
    ankles: np.ndarray  # (2, n, 3) m
    toes: np.ndarray  # (2, n, 3) m
    leg: float  # m, from hip to ankle where the leg is longest


def find_feet(skeleton: Skeleton, joints: Mapping[str, str] | None) -> dict[str, str]:
    """The names of the joints at hips, ankles and toes, as given or as found."""
    found = find_person(skeleton, joints, [mark for mark in MARKS if not mark.endswith("toe")]).joints
    for side in SIDES:  # the toe markers of gait laboratories are where the toes begin; toe tips are noisy
        if f"{side}_toe" not in (joints or {}) and f"{side}_ball" in found:
            found[f"{side}_toe"] = found[f"{side}_ball"]
    require(found, MARKS)
    return {mark: skeleton.joint_names[found[mark]] for mark in MARKS}


def check_recording(motion: Motion) -> None:
    """Refuse motions that cannot show gait, such as those without movement of the root."""
    check_kind(motion, Motion, "motion", "gait needs positions of the root and a frame rate")
    if motion.frame_rate < LEAST_RATE or len(motion) < 2:
        got = f"{len(motion)} frames at {motion.frame_rate:g} Hz"
        raise ValueError(f"gait events need a stride at {LEAST_RATE:g} Hz or more, before resampling, got {got}")
    if (np.ptp(motion.root_positions, axis=0) <= STILL).all():
        raise ValueError(
            "gait needs root_positions, but they are constant: on a treadmill add the movement of the belt"
        )
    places = np.concatenate([motion.root_positions[:, None], motion.positions()], axis=1)
    if (found := find_up(motion, motion.up, places)) != motion.up:
        raise ValueError(
            f"motion.up is {motion.up!r}, but {describe_up(found)}: use dataclasses.replace(motion, up=...)"
        )


def feet_of(motion: Motion, joints: Mapping[str, str]) -> Feet:
    """Pelvis and feet in the world, low-pass filtered; a row for each frame from the first to the last."""
    columns = [motion.skeleton.joint_names.index(joints[mark]) for mark in MARKS]
    here, shown = motion.positions()[:, columns].swapaxes(0, 1), find_shown(motion, columns)
    both = [MARKS.index(f"{side}_hip") for side in SIDES]
    hips = shown[:, both].all(axis=1)
    rows = motion.frame_numbers - motion.frame_numbers[0]
    every, seen = np.arange(rows[-1] + 1), np.zeros((len(SIDES), rows[-1] + 1), dtype=bool)
    for side, known in enumerate(seen):
        known[rows] = hips & shown[:, [MARKS.index(f"{SIDES[side]}_{part}") for part in PARTS]].all(axis=1)
        for gap in runs_of(~known):
            if gap.start > 0 and gap.stop < len(known) and gap.stop - gap.start <= LONGEST_GAP * motion.frame_rate:
                known[gap] = True
    if not seen.any():
        raise ValueError("gait events need hips and feet, but no frame shows all of them")
    marks = [
        [np.interp(every, rows[known], x[known]) for x in mark.T] if known.any() else np.full((3, len(every)), np.nan)
        for mark, known in zip(here[..., axes_with_up_last(motion.up)], shown.T, strict=True)
    ]
    feet = feet_at(np.array(marks).transpose(0, 2, 1), seen, motion.frame_rate)
    metre = 1.0
    if not LEGS[0] <= feet.leg <= LEGS[1]:
        metre = feet.leg  # a person's is nearly one
        warn(f"legs of {feet.leg:.3g} m are not a person's, so lengths are not in metres: read the file with scale=")
    _check_jumps(here[both] / metre, motion, np.flatnonzero(hips))
    return feet


def runs_of(known: np.ndarray) -> list[slice]:
    """The parts of an array of bool that are True throughout."""
    return list(np.ma.clump_masked(np.ma.masked_array(known, known)))


def _check_jumps(hips: np.ndarray, motion: Motion, shown: np.ndarray) -> None:
    """Refuse motions whose pelvis, between hips at (2, n, 3), jumps between shown frames: two recordings in one."""
    hips = _without_spikes(hips[:, shown])
    seconds = np.diff(motion.frame_numbers[shown]) / motion.frame_rate
    metres = np.linalg.norm(np.diff(hips.mean(axis=0), axis=0), axis=1)
    across = hips[1] - hips[0]
    degrees = degrees_between(across[:-1], across[1:])
    for steps, unit, limit, error in ((metres, " m", FASTEST, ERROR), (degrees, "°", FASTEST_TURN, ERROR_OF_TURN)):
        over = steps - limit * seconds
        if over.max(initial=0.0) > error:
            most = int(over.argmax())
            cut = f"use motion[:{shown[most] + 1}] and motion[{shown[most + 1]}:]"
            raise ValueError(f"the pelvis jumps by {steps[most]:.3g}{unit} after frame {shown[most]}: {cut}")


def axes_with_up_last(up: str) -> list[int]:
    """The axes of the world in a cycle that ends with the one that points up."""
    i = "xyz".index(up)
    return [(i + 1) % 3, (i + 2) % 3, i]


def _without_spikes(positions: np.ndarray) -> np.ndarray:
    """The median of each frame of (n_points, n, 3) and its two neighbours.

    At the ends the third value is extrapolated from the next two (J. W. Tukey, "Exploratory data analysis", 1977): a
    low-pass filter would take a spike in the first or last frame for a movement.
    """
    n = positions.shape[1]
    before, after = (
        3.0 * positions.take([near], axis=1, mode="clip") - 2.0 * positions.take([far], axis=1, mode="clip")
        for near, far in ((1, 2), (n - 2, n - 3))
    )
    return np.asarray(median_filter(np.concatenate([before, positions, after], axis=1), size=(1, 3, 1))[:, 1:-1])


def feet_at(positions: np.ndarray, seen: np.ndarray, rate: float) -> Feet:
    """Pelvis and feet from the positions (6, n, 3) of `MARKS`, up last, and where each foot is seen, (2, n)."""
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
        1.0 / rate,
        seen,
        pelvis,
        travel,
        facing,
        np.stack([left_ankle, right_ankle]),
        np.stack([left_toe, right_toe]),
        float(np.nanmax(legs)),
    )
