"""Faults of the body in the world: units, axes, frame rate, the floor, and poses that people do not take."""

import warnings
from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from skpose._utils.units import LARGEST, SMALLEST, UNITS, likely_unit
from skpose.biomechanics import gait_parameters
from skpose.biomechanics._feet import LEGS
from skpose.biomechanics._gait_parameters import doubt_of_rate
from skpose.checks._findings import Found, check, limit
from skpose.checks._recording import Recording
from skpose.kinematics._anatomy import ANKLE, BALL, HIP, LEG, SIDES, TOE
from skpose.kinematics._ground import runs, speeds_of
from skpose.kinematics._lines import unit
from skpose.scores._plausibility import LOW, slips_of
from skpose.skeleton._rest import size_of
from skpose.skeleton._upright import describe_up, find_up

SOLES = {ANKLE: 0.08, BALL: 0.03}  # m, of joints above the sole
ENDS = 0.5  # s at both ends in which a calibration pose is looked for
STILL = 0.25  # m/s, of the lowest joint: at the top of a jump it is so slow for a twentieth of a second
TURN = 1.0  # rad/s: a foot that turns on the spot moves relative to the root
WALK = 1.5  # m, shortest path of gait
FACTORS = 1.0, 0.25, 0.5, 2.0, 4.0  # of the frame rate that are tried
STRIDES = 3  # that show gait at another rate
LASTS, SHORT = 0.25, 0.1  # s


@check("units", "error", "read the file with scale= metres per unit")
def units(recording: Recording) -> Iterator[Found]:
    size, leg = size_of(recording.skeleton), recording.leg
    if (leg and not LEGS[0] <= leg <= LEGS[1]) or not SMALLEST <= size <= LARGEST:
        name = likely_unit(size, 1.0)
        remedy = f"read it with scale={UNITS[name]:.4g} times the present one if it is in {name}"
        yield Found(size, "m", f"the skeleton is {size:.3g} m from end to end at angle zero", remedy=remedy)


@check("up axis", "error", "read the file with up=, or dataclasses.replace(motion, up=...)")
def up_axis(recording: Recording) -> Iterator[Found]:
    motion = recording.motion
    if (found := find_up(motion, motion.up, recording.world)) != motion.up:
        yield Found(1.0, "", f"{motion.up} is up, but {describe_up(found)}")


@check("frame rate", "error", "read the file with frame_rate=, or dataclasses.replace(motion, frame_rate=...)")
def frame_rate(recording: Recording) -> Iterator[Found]:
    path = np.linalg.norm(np.diff(recording.points[:, 0, :2], axis=0), axis=1).sum()
    if path < WALK or not recording.leg:
        return
    stated, motion = recording.motion.frame_rate, recording.motion
    for factor in FACTORS:  # at another rate strides are too short or too long to be some
        motion = replace(motion, frame_rate=stated * factor)
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")
                gait = gait_parameters(motion)
        except ValueError:  # no gait
            continue
        doubt = doubt_of_rate(gait, motion)
        if factor == 1.0:
            if doubt:
                yield Found(stated, "Hz", doubt.rstrip("?"))
            return
        if not doubt and len(gait) >= STRIDES:
            yield Found(stated, "Hz", f"at {stated:g} Hz this is no gait, at {motion.frame_rate:g} Hz a usual one")
            return


@check("calibration pose", "warning", "cut these frames")
def calibration_pose(recording: Recording) -> Iterator[Found]:
    """A T-pose, or all angles zero, at an end of the motion only."""
    n, motion = len(recording.motion), recording.motion
    poses = np.abs(motion.angles).max(axis=1, initial=0.0) < 0.01
    if recording.has(*(f"{side}_{mark}" for side in SIDES for mark in ("shoulder", "elbow", "wrist"))):
        left, right = (recording.at(f"{side}_shoulder") for side in SIDES)
        least, across = np.cos(np.radians(limit("horizontal"))), unit(left - right)
        held = np.ones(n, dtype=bool)
        for side, sign in zip(SIDES, (1.0, -1.0), strict=True):
            shoulder, elbow, wrist = (recording.at(f"{side}_{mark}") for mark in ("shoulder", "elbow", "wrist"))
            for bone in (elbow - shoulder, wrist - elbow):
                held &= (unit(bone) * across).sum(axis=1) * sign > least
        poses |= held
    found = [run for run in runs(poses) if 0 in run or n in run]
    if found and not poses.all():
        first, end = found[0]
        yield Found(
            (end - first) * recording.step,
            "s",
            f"{end - first} frames at an end hold a T-pose or the zero pose",
            (first, end),
        )


@check("floor", "warning", "move the root, or tell programs the height of the floor")
def floor(recording: Recording) -> Iterator[Found]:
    if recording.soles is not None:
        part = ANKLE if recording.soles.points.shape[2] == 1 else BALL
        off = float(recording.soles.floors[-1]) - SOLES[part]
        if abs(off) > limit("floor"):
            size = off * recording.scale
            yield Found(
                size,
                "m",
                f"feet stand {abs(size):.2g} m {'above' if off > 0 else 'below'} 0 along {recording.motion.up}",
            )


def _longest(chosen: np.ndarray, recording: Recording, least: float) -> tuple[int, int] | None:
    """The longest run of frames, if it takes some seconds."""
    found = max(runs(chosen), key=lambda run: run[1] - run[0], default=(0, 0))
    return found if (found[1] - found[0]) * recording.step >= least else None


@check("floating", "warning", "lower the root there, or leave the part out")
def floating(recording: Recording) -> Iterator[Found]:
    """The whole body stands still above the floor."""
    if recording.soles is None:
        return
    lowest = recording.points[..., 2].argmin(axis=1)
    rows = np.arange(len(lowest))
    heights = np.minimum(
        recording.points[rows, lowest, 2] - recording.soles.floors.min(), recording.soles.heights.min(axis=(1, 2))
    )
    slow = speeds_of(recording.points, recording.motion.times, 0.05)[rows, lowest] < STILL
    if run := _longest((heights > limit("float")) & slow, recording, LASTS):
        size = float(np.median(heights[slice(*run)])) * recording.scale
        yield Found(size, "m", f"the lowest joint stands still {size:.2g} m above the floor, afloat or on a step", run)


@check("sinking", "warning", "raise the root there, or leave the part out")
def sinking(recording: Recording) -> Iterator[Found]:
    if recording.soles is None:
        return
    depths = -recording.soles.heights.min(axis=(1, 2))
    if run := _longest((depths > limit("sink")) & recording.upright, recording, SHORT):
        size = float(depths[slice(*run)].max()) * recording.scale
        yield Found(size, "m", f"a foot is {size:.2g} m below the floor", run)


@check("skating", "warning", "keep the feet in place by inverse kinematics, or leave the part out")
def skating(recording: Recording) -> Iterator[Found]:
    if recording.soles is None:
        return
    slips = slips_of(recording.soles).min(axis=1)
    if run := _longest(np.isfinite(slips) & (slips > limit("slide")) & recording.upright, recording, LASTS):
        size = float(np.median(slips[slice(*run)])) * recording.scale
        yield Found(size, "m/s", f"both feet slide along the floor at {size:.2g} m/s while one stands", run)


@check("travel", "error", "check the unit and the axes of the root, and the scale of retargeting")
def travel(recording: Recording) -> Iterator[Found]:
    """The root against the foot that stands."""
    if recording.soles is None or len(recording.motion) < 3:
        return
    root = recording.points[:, 0, :2]
    feet = recording.soles.points[..., -1, :2].swapaxes(0, 1)
    lowest = recording.soles.heights.min(axis=2).argmin(axis=1)
    velocity = [np.gradient(x, recording.motion.times, axis=0) for x in (root, feet[0] - root, feet[1] - root)]
    shown = -np.where(lowest[:, None] == 0, velocity[1], velocity[2])
    moves = np.linalg.norm(shown, axis=1) > 0.3
    left = (recording.at("left_hip") - recording.at("right_hip"))[:, :2]
    turn = np.gradient(np.unwrap(np.arctan2(left[:, 1], left[:, 0])), recording.motion.times)
    moves &= (recording.soles.heights.min(axis=(1, 2)) < LOW) & recording.upright & (np.abs(turn) < TURN)
    if moves.sum() * recording.step > 1.0:
        ratios = (velocity[0] * shown).sum(axis=1)[moves] / (shown**2).sum(axis=1)[moves]
        low, ratio, high = np.percentile(ratios, (25.0, 50.0, 75.0)).tolist()
        if low > 1.0 + limit("travel") or high < 1.0 - limit("travel"):
            yield Found(ratio, "", f"the root travels {ratio:.2g} times as far as the standing foot shows")


@check("sides exchanged", "error", "exchange left and right in the names of the joints")
def sides_exchanged(recording: Recording) -> Iterator[Found]:
    for mark in (HIP, "shoulder"):
        tips = [part for part in (BALL, TOE) if recording.has(*(f"{side}_{part}" for side in SIDES))][:1]
        marks = [f"{side}_{part}" for side in SIDES for part in (mark, ANKLE, *tips)]
        if not tips or not recording.has(*marks):
            continue
        left = recording.at(f"left_{mark}") - recording.at(f"right_{mark}")
        ahead = np.cross(left, [0.0, 0.0, 1.0])
        toes = [recording.at(f"{side}_{tips[0]}") - recording.at(f"{side}_{ANKLE}") for side in SIDES]
        share = float(np.mean([((toe * ahead)[:, :2].sum(axis=1) < 0.0) for toe in toes]))
        if share > 0.9:
            what = f"the toes point behind the line from left to right {mark}, in {share:.0%} of the frames"
            yield Found(share, "", what, None, (f"left {mark}", f"right {mark}"))


@check("joint limits", "warning", "check the axes of the joint, the retargeting, or the fit to the markers")
def joint_limits(recording: Recording) -> Iterator[Found]:
    """Knees that bend forward, and hinges of robots beyond their limits."""
    for side in SIDES:
        tips = [part for part in (BALL, TOE) if recording.has(f"{side}_{part}")][:1]
        if not tips or not recording.has(*(f"{side}_{mark}" for mark in LEG)):
            continue
        hip, knee, ankle, tip = (recording.at(f"{side}_{mark}") for mark in (*LEG, tips[0]))
        thigh, shank, foot = unit(knee - hip), unit(ankle - knee), unit(tip - ankle)
        bend = np.degrees(np.arccos(np.clip((thigh * shank).sum(axis=1), -1.0, 1.0)))
        ahead = unit(foot - (foot * shank).sum(axis=1, keepdims=True) * shank)
        wrong = np.where(
            ((thigh - shank) * ahead).sum(axis=1) < -0.5 * np.linalg.norm(thigh - shank, axis=1), bend, 0.0
        )
        if run := _longest(wrong > limit("knee"), recording, SHORT):
            size = float(wrong[slice(*run)].max())
            yield Found(size, "°", f"the {side} knee bends forward by {size:.0f}°", run, (f"{side} knee",))
    motion, limits = recording.motion, recording.skeleton.limits
    bones = recording.skeleton.bones
    hinges = np.repeat([bone.axis is not None for bone in bones], [bone.n_dofs for bone in bones])
    if limits is not None and hinges.any():  # ASF files state limits that their own motions break
        off = np.degrees(np.maximum(limits[:, 0] - motion.angles, motion.angles - limits[:, 1])) * hinges
        beyond = off.max(axis=1)
        if (beyond > limit("hinge")).any():
            row, name = int(beyond.argmax()), recording.skeleton.dof_names[int(off.max(axis=0).argmax())]
            what = f"{name} is {beyond[row]:.3g}° beyond its limit"
            yield Found(float(beyond[row]), "°", what, (row, row + 1), (name,))
