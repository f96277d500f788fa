"""Feet that stand where the motion's stand, times the ratio of the lengths of the legs.

The root takes the mean shift of the standing feet, and each leg the rest, as far as hip and knee rotate little for it.
"""

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from scipy.ndimage import gaussian_filter1d, minimum_filter1d
from scipy.spatial.transform import Rotation

from skpose.kinematics._anatomy import ANKLE, BALL, HIP, SIDES, TOE, Anatomy, length_of
from skpose.skeleton import Motion, Skeleton
from skpose.skeleton._rest import unit
from skpose.skeleton._rotations import shortest_rotations

LOW, SLOW = 0.08, 1.0  # leg lengths above the floor, and leg lengths per second, of a foot that stands
NEARBY = 0.5  # s, before and after: the floor of a foot is its lowest place in this time, as on stairs and slopes
STANDS, LEAST = 0.5, 1e-3  # weights of a foot that stands, and of one that does not
PLANTED = 0.1, 0.3  # weights from which on a foot is moved to its place, partly and fully
SMOOTH = 0.12  # s, standard deviation of the mean over time
AHEAD = 0.3  # s, of the line of the hips
HIP_TURN, KNEE_BEND = np.radians(1.1), np.radians(1.8)  # largest changes; thighs rotate by about 2°
STRAIGHT = 0.02  # rad, bend of a knee whose axis is not seen
EXACT = 1e-9  # of a leg length: smaller shifts are rounding errors


class Steps(NamedTuple):
    """How the feet of a result have to move."""

    root: np.ndarray  # (n_frames, 3) the shift of the root, m
    feet: np.ndarray  # (n_frames, n_sides, 3) then of the feet
    stands: np.ndarray  # (n_frames, n_sides) whether each stands


def leg_length(skeleton: Skeleton, person: Anatomy) -> float:
    """The length of the bones from hip to ankle, m, mean of both sides; 0 without legs."""
    lengths = [length_of(skeleton, person.joints, side, HIP, ANKLE) for side in SIDES]
    return float(np.mean(lengths)) if all(lengths) else 0.0


def find_steps(
    motion: Motion,
    positions: tuple[np.ndarray, np.ndarray],
    people: tuple[Anatomy, Anatomy],
    factor: float,
    sides: Sequence[str] = SIDES,
) -> Steps:
    """How the feet of a result have to move to stand as the motion's, by the positions (n_frames, n_joints, 3) of both.

    The shift of the root is the mean of both feet, weighted by how low and slow each is, and smoothed in time. In the
    median, the lowest joint of a foot that stands is as high as the motion's, times the factor.
    """
    leg, up = factor * leg_length(motion.skeleton, people[0]), "xyz".index(motion.up)
    both, joints = (factor * positions[0], positions[1]), [person.joints for person in people]
    stood = next(part for part in (BALL, ANKLE) if all(f"{side}_{part}" in each for each in joints for side in sides))
    theirs, ours = (
        each[:, [marks[f"{side}_{stood}"] for side in sides]] for each, marks in zip(both, joints, strict=True)
    )
    step = float(np.median(np.diff(motion.times))) if len(motion) > 1 else 1.0
    heights = theirs[:, :, up]
    heights = heights - minimum_filter1d(heights, 1 + 2 * round(NEARBY / step), axis=0, mode="nearest")
    speeds = np.zeros((len(motion) + 1, len(sides)))  # of the steps before and after each frame
    speeds[1:-1] = np.linalg.norm(np.diff(theirs, axis=0), axis=2) / np.diff(motion.times)[:, None]
    speeds[[0, -1]] = speeds[[1, -2]]
    speeds = np.minimum(speeds[1:], speeds[:-1])  # so that one jump does not lift a foot
    weights = np.exp(-((heights / (LOW * leg)) ** 2) - (speeds / (SLOW * leg)) ** 2)[..., None]
    hips = [
        each[:, marks[f"left_{HIP}"]] - each[:, marks[f"right_{HIP}"]] for each, marks in zip(both, joints, strict=True)
    ]
    wider = np.linalg.norm(hips[1], axis=1) - np.linalg.norm(hips[0], axis=1)  # so are the feet apart
    left = unit(gaussian_filter1d(hips[0], AHEAD / step, axis=0, mode="nearest"))
    theirs = theirs + np.multiply.outer(
        [0.5 if side == SIDES[0] else -0.5 for side in sides], wider[:, None] * left
    ).swapaxes(0, 1)
    apart = theirs - ours
    root = ((weights + LEAST) * apart).sum(axis=1) / (weights + LEAST).sum(axis=1)
    root = gaussian_filter1d(root, SMOOTH / step, axis=0, mode="nearest")
    lowest = [
        each[
            :,
            [j for mark, j in marks.items() if mark.startswith(tuple(sides)) and mark.endswith((ANKLE, BALL, TOE))],
            up,
        ].min(axis=1)
        for each, marks in zip(both, joints, strict=True)
    ]
    on_floor = weights.max(axis=(1, 2)) >= min(STANDS, weights.max())
    higher = np.median((lowest[0] - lowest[1] - root[:, up])[on_floor])
    root[:, up] += higher
    apart[..., up] += higher
    if np.abs(apart).max() <= EXACT * leg:
        root, apart = np.zeros_like(root), np.zeros_like(apart)
    shares = np.clip((weights - PLANTED[0]) / (PLANTED[1] - PLANTED[0]), 0.0, 1.0)
    return Steps(root, shares * (apart - root[:, None]), weights[..., 0] > STANDS)


def keep_feet(motion: Motion, result: Motion, people: tuple[Anatomy, Anatomy], factor: float) -> Motion:
    """Move the root of a result such that the feet that stand are where the motion's are, times a factor."""
    if not len(motion):
        return result
    steps = find_steps(motion, (motion.positions(), result.positions()), people, factor)
    return replace(result, root_positions=result.root_positions + steps.root)


def move_ankle(leg: np.ndarray, step: np.ndarray, axis: np.ndarray) -> tuple[Rotation, Rotation]:
    """The rotations (n_frames,) of thigh and shank that move an ankle by a step (n_frames, 3), as far as may be.

    The leg (n_frames, 3, 3) has the positions of hip, knee and ankle; the knee bends about the axis (n_frames, 3).
    """
    hip, knee, ankle = leg.swapaxes(0, 1)
    a, b = (np.linalg.norm(bone, axis=1) for bone in (knee - hip, ankle - knee))
    bend = np.arccos(np.clip((unit(knee - hip) * unit(ankle - knee)).sum(axis=1), -1.0, 1.0))
    before, wished = np.linalg.norm(ankle - hip, axis=1), np.linalg.norm(ankle + step - hip, axis=1)
    bends = np.arccos(np.clip((wished**2 - a**2 - b**2) / (2.0 * a * b), -1.0, 1.0))
    bends = np.clip(bends, np.maximum(bend - KNEE_BEND, 0.0), bend + KNEE_BEND)
    after = np.sqrt(a**2 + b**2 + 2.0 * a * b * np.cos(bends))
    turn = shortest_rotations(unit(ankle - hip), unit(ankle + step - hip))
    turn = Rotation.from_rotvec(turn.as_rotvec() / np.maximum(turn.magnitude() / HIP_TURN, 1.0)[:, None])
    axis = turn.apply(unit(axis))
    rotations = []
    for first, second, sign in ((a, b, -1.0), (b, a, 1.0)):
        angles = [
            np.arccos(np.clip((first**2 + d**2 - second**2) / (2.0 * first * d), -1.0, 1.0)) for d in (before, after)
        ]
        rotations.append(Rotation.from_rotvec((sign * (angles[1] - angles[0]))[:, None] * axis) * turn)
    return rotations[0], rotations[1]
