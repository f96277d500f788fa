"""The measure of each kind of fault: its size at each frame, see `KINDS`, of a person with legs of 0.9 m."""

from dataclasses import replace
from typing import NamedTuple

import numpy as np
from scipy.ndimage import median_filter

from skpose._utils.units import LARGEST, SMALLEST, UNITS, likely_unit
from skpose.biomechanics._gait_events import LEGS
from skpose.biomechanics._gait_parameters import measure_gait
from skpose.checks._recording import Recording, Unknown
from skpose.kinematics._anatomy import ARM
from skpose.kinematics._ground import runs, speeds_of
from skpose.scores._plausibility import slips_of
from skpose.skeleton._rest import size_of, unit
from skpose.skeleton._upright import describe_up, find_up

WALK = 1.5  # m, shortest path of gait
FACTORS = 0.25, 0.5, 2.0, 4.0  # of the frame rate, tried where strides are missing
STRIDES = 3  # that show gait at another rate
SAME, LINEAR = 1e-9, 0.003  # m, movement of a repeated frame; share by which velocities change on a straight line
AROUND, SUDDEN, JERK = 0.15, 8.0, 1500.0  # s, around a step; times what steps usually differ there; m/s³
FAST = 6.0  # Hz; people move more slowly, so that it is a usual cut-off of gait data
NORMAL = 6.9  # √20 times the median length of a normal vector in space: of third differences of white noise
T_POSE, ZERO = np.cos(np.radians(15.0)), 0.01  # rad
SOLES = 0.08, 0.03  # m, of ankle and ball above the sole
STILL = 0.25  # m/s


class Measured(NamedTuple):
    """The size of a fault."""

    sizes: np.ndarray  # (n_frames,) or (n_frames, n_names); or () for the whole motion
    names: tuple[str, ...] = ()  # of the columns
    note: str = ""


def units(recording: Recording) -> Measured:
    size, leg = size_of(recording.skeleton), recording.leg
    wrong = (leg and not LEGS[0] <= leg <= LEGS[1]) or not SMALLEST <= size <= LARGEST
    name = likely_unit(size, 1.0)
    return Measured(
        np.array(size / recording.scale * bool(wrong)), note=f", so it may be in {name}: {UNITS[name]:.4g} m"
    )


def up_axis(recording: Recording) -> Measured:
    up = recording.motion.up
    found = find_up(recording.motion, up)
    return Measured(np.array(float(found != up)), note=f"{up} is up, but {describe_up(found)}")


def frame_rate(recording: Recording) -> Measured:
    rate = recording.motion.frame_rate
    if not recording.leg or np.linalg.norm(np.diff(recording.points[:, 0, :2], axis=0), axis=1).sum() < WALK:
        raise Unknown
    for factor in (1.0, *FACTORS):
        motion = replace(recording.motion, frame_rate=rate * factor)
        try:
            gait, doubt = measure_gait(motion)
        except ValueError:  # no gait
            continue
        if factor == 1.0:
            return Measured(np.array(rate * bool(doubt)), note=doubt)
        if not doubt and len(gait) >= STRIDES:
            return Measured(np.array(rate), note=f"at {rate:g} Hz this is no gait, at {rate * factor:g} Hz a usual one")
    raise Unknown


def missing_frames(recording: Recording) -> Measured:
    return Measured(np.diff(recording.motion.frame_numbers, append=recording.motion.frame_numbers[-1] + 1) - 1.0)


def repeated_frames(recording: Recording) -> Measured:
    moved = np.abs(np.diff(recording.points, axis=0)).max(axis=(1, 2)) + np.diff(recording.motion.frame_numbers) - 1
    return Measured(np.concatenate([[0.0], moved <= SAME]))


def interpolated_frames(recording: Recording) -> Measured:
    found = np.zeros(len(recording.points))
    for values in (recording.motion.root_positions, recording.unwrapped):
        steps = np.diff(values, axis=0)
        found[1:-1] += np.abs(np.diff(steps, axis=0)).sum(axis=1) < LINEAR * np.abs(steps[1:]).sum(axis=1)
    return Measured(found)


def jump(recording: Recording) -> Measured:
    """By how much each step differs from the two around it, where that is sudden."""
    recording.need(4)
    steps = np.diff(recording.around_root, axis=0)
    padded = np.concatenate([steps[1:2], steps, steps[-2:-1]])
    off = np.linalg.norm(steps - (padded[:-2] + padded[2:]) / 2.0, axis=2)
    gaps = np.convolve(np.diff(recording.motion.frame_numbers) > 1, np.ones(3), mode="same") > 0
    usual = median_filter(off, size=(2 * max(3, round(AROUND / recording.step)) + 1, 1), mode="nearest")
    sizes = np.where((off > np.maximum(SUDDEN * usual, JERK * recording.step**3)) & ~gaps[:, None], off, 0.0)
    return Measured(np.concatenate([sizes, sizes[-1:] * 0.0]), recording.names)


def noise(recording: Recording) -> Measured:
    recording.need(12)
    first, third = (np.diff(recording.around_root, n=n, axis=0) for n in (1, 3))
    moved, rough = (np.median(np.linalg.norm(x, axis=2), axis=0) for x in (first - first.mean(axis=0), third))
    return Measured(1e3 * (rough - (2.0 * np.pi * FAST * recording.step) ** 2 * moved)[None] / NORMAL, recording.names)


def angle_flips(recording: Recording) -> Measured:
    motion = recording.motion
    off = np.concatenate([motion.angles, motion.root_angles], axis=1) - recording.unwrapped
    names = (*motion.skeleton.dof_names, *(f"{motion.root_name}_{axis}" for axis in motion.root_axes))
    return Measured(np.abs(np.diff(off, axis=0, append=off[-1:])), names)


def calibration_pose(recording: Recording) -> Measured:
    """A T-pose, or all angles zero, at an end of the motion only."""
    arms = recording.limbs(*ARM)
    across = unit(arms[0, 0] - arms[1, 0]) * np.array([1.0, -1.0])[:, None, None, None]
    held = ((unit(np.diff(arms, axis=1)) * across).sum(axis=-1) > T_POSE).all(axis=(0, 1))
    held |= np.abs(recording.motion.angles).max(axis=1, initial=0.0) < ZERO
    at_end = np.zeros(len(held))
    for first, end in runs(held):
        at_end[first:end] = (first == 0 or end == len(held)) * recording.step * (end - first) * (not held.all())
    return Measured(at_end)


def floor(recording: Recording) -> Measured:
    off = float(recording.soles.floors[-1]) - SOLES[min(1, len(recording.soles.floors) - 1)]
    return Measured(np.array(abs(off)), note="above" if off > 0.0 else "below")


def floating(recording: Recording) -> Measured:
    """The height of the whole body above the floor while its lowest joint is still."""
    rows, lowest = np.arange(len(recording.points)), recording.points[..., 2].argmin(axis=1)
    heights = recording.points[rows, lowest, 2] - recording.soles.floors.min()
    still = speeds_of(recording.points, recording.times, 0.05)[rows, lowest] < STILL
    return Measured(np.minimum(heights, recording.soles.heights.min(axis=(1, 2))) * still)


def sinking(recording: Recording) -> Measured:
    return Measured(-recording.soles.heights.min(axis=(1, 2)) * recording.upright)


def skating(recording: Recording) -> Measured:
    slips = slips_of(recording.soles, recording.times).min(axis=1)
    return Measured(np.where(np.isfinite(slips) & recording.upright, slips, 0.0))


def sides_exchanged(recording: Recording) -> Measured:
    hips, _, ankles, toes = recording.legs().swapaxes(0, 1)
    ahead = np.cross(hips[0] - hips[1], [0.0, 0.0, 1.0])
    return Measured(np.array(np.mean(((toes - ankles) * ahead).sum(axis=2) < 0.0)))


def joint_limits(recording: Recording) -> Measured:
    """Knees that bend towards the toes."""
    thighs, shanks, feet = unit(np.diff(recording.legs(), axis=1)).swapaxes(0, 1)
    bends = np.degrees(np.arccos(np.clip((thighs * shanks).sum(axis=2), -1.0, 1.0)))
    ahead = unit(feet - (feet * shanks).sum(axis=2, keepdims=True) * shanks)
    wrong = ((thighs - shanks) * ahead).sum(axis=2) < -0.5 * np.linalg.norm(thighs - shanks, axis=2)
    return Measured((bends * wrong).T, ("the left knee", "the right knee"))
