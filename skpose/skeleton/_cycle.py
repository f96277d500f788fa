"""Cycles: motions whose last frame is the first one, moved along the floor, so that they can be repeated.

Let δ be the difference between end and start: a rotation of each joint and of the root's tilt, and a height. With s
from 0 to 1 over the cycle, frame s is changed by (s − ½) δ, a rotation about a fixed axis, so that the ends meet
halfway. Place and heading do not change: their difference is the travel of the cycle.

Motions are those of ``with_root("whole")``: the root's orientation is the first joint.
"""

from dataclasses import replace

import numpy as np
from scipy.spatial.transform import Rotation

from skpose._utils.validation import MotionLike
from skpose._utils.warnings import warn
from skpose.skeleton._bone import are_slides
from skpose.skeleton._interpolation import move, steps_from
from skpose.skeleton._root import heading
from skpose.skeleton._rotations import joint_positions, remove_jumps

ROOT = slice(3)  # the columns of the root
NEAR = 0.25  # of the smaller step at the ends; if nearer, the last pose is the first one again
FAR = 0.2  # of the largest distance from the first pose, beyond which a cycle is not whole; strides reach 0.17
CUT = 1.5  # steps by which the cut at whole frames may be off
SEAM = 0.1  # of the largest change between two frames; tolerance at the ends of a cycle
ROUNDING = 1e-6  # of files: rad, m


def _root(motion: MotionLike) -> Rotation:
    """Orientations of the root."""
    return Rotation.from_rotvec(motion.angles[:, ROOT])


def _turns(motion: MotionLike) -> np.ndarray:
    """Changes of the heading since the first frame, rad in [−π, π]."""
    return heading(_root(motion) * _root(motion)[:1].inv(), motion.up)


def _rotate(motion: MotionLike, turns: np.ndarray | float) -> np.ndarray:
    """Poses rotated about the vertical through the root, each or all by an angle."""
    poses: np.ndarray = motion.angles.copy()
    poses[:, ROOT] = (Rotation.from_euler(motion.up, np.reshape(turns, (-1, 1))) * _root(motion)).as_rotvec()
    return poses


def _gap(motion: MotionLike) -> np.ndarray:
    """The steps (1, n_dofs) from the last pose to the first one with the heading of the last."""
    return steps_from(motion.skeleton.bones, motion.angles[-1:], _rotate(motion, _turns(motion)[-1])[:1])


def close_cycle(motion: MotionLike, endpoint: bool) -> MotionLike:
    """A cycle, with warnings if the motion was none; without `endpoint` the frame that ends it is added."""
    positions = _positions(motion)
    steps = _distances(positions[1:], positions[:-1]) / np.diff(motion.frame_numbers)
    if not endpoint:
        if _distances(positions[-1], positions[0]) < NEAR * steps[[0, -1]].min():
            warn("the last pose is the first one again, but is taken for the one before: pass endpoint=True")
        motion = _add_end(motion)
        positions = _positions(motion)
    away = _distances(positions, positions[0])
    if away[-1] > max(FAR * away.max(), CUT * max(np.median(steps), steps[[0, -1]].mean())):
        warn("the cycle ends far from its first pose: it is not one whole cycle, but is closed nevertheless")
    shares = (motion.times - motion.times[0]) / (motion.times[-1] - motion.times[0]) - 0.5
    poses = move(motion.skeleton.bones, motion.angles, shares[:, None] * _gap(motion))
    places = motion.root_positions.copy()
    heights = places[:, "xyz".index(motion.up)]
    heights += shares * (heights[0] - heights[-1])
    return replace(motion, angles=remove_jumps(motion.skeleton.bones, poses), root_positions=places)


def _add_end(motion: MotionLike) -> MotionLike:
    """Add a frame at the mean of the velocities of the last step and of the first.

    The first step is repeated at the end, with the heading of the end.
    """
    ends = np.array([0, -1])
    times, root = np.diff(motion.frame_numbers)[ends], _root(motion)
    rates = steps_from(motion.skeleton.bones, motion.angles[[0, -2]], motion.angles[[1, -1]]) / times[:, None]
    turns = heading(root[[1, -1]] * root[[0, -2]].inv(), motion.up) / times
    velocities = np.diff(motion.root_positions, axis=0)[ends] / times[:, None]
    next_velocity = Rotation.from_euler(motion.up, _turns(motion)[-1] + turns.mean()).apply(velocities[0])
    pose = move(motion.skeleton.bones, motion.angles[-1:], rates.mean(axis=0, keepdims=True))
    place = motion.root_positions[-1] + (velocities[1] + next_velocity) / 2.0
    return replace(
        motion,
        angles=np.concatenate([motion.angles, pose]),
        root_positions=np.concatenate([motion.root_positions, place[None]]),
        root_angles=None,
        frame_numbers=np.append(motion.frame_numbers, motion.frame_numbers[-1] + 1),
        seen=None if motion.seen is None else np.concatenate([motion.seen, motion.seen[-1:]]),
    )


def describe_opening(motion: MotionLike) -> str:
    """The difference between the last frame and the first, moved along; empty if there is none."""
    bones, gap = motion.skeleton.bones, np.abs(_gap(motion))[0]
    steps = np.abs(steps_from(bones, motion.angles[:-1], motion.angles[1:]))
    names, slides = np.array([*["the root"] * 3, *motion.skeleton.dof_names[3:]]), are_slides(bones)
    for these, unit in ((~slides, "rad"), (slides, "m")):
        if these.any() and gap[these].max() > SEAM * steps[:, these].max() + ROUNDING:
            return f"{names[these][gap[these].argmax()]} differs by {gap[these].max():.2g} {unit}"
    heights = motion.root_positions[:, "xyz".index(motion.up)]
    rise = abs(heights[-1] - heights[0])
    if rise > SEAM * np.abs(np.diff(heights)).max() + ROUNDING:
        return f"the height of the root differs by {rise:.2g} m"
    return ""


def repeat_cycle(motion: MotionLike, n: int) -> MotionLike:
    """Repeat a cycle n times, each from the place and with the heading of the end of the one before."""
    turn, duration = _turns(motion)[-1], motion.frame_numbers[-1] - motion.frame_numbers[0]
    start, copies = motion.root_positions[0], []
    for i in range(n):
        onward = Rotation.from_euler(motion.up, i * turn)
        rows = slice(None if i == n - 1 else -1)
        places = start + onward.apply(motion.root_positions - motion.root_positions[0])
        copies.append((_rotate(motion, i * turn)[rows], places[rows], motion.frame_numbers[rows] + i * duration))
        start = np.where(np.array([*"xyz"]) == motion.up, start, places[-1])
    poses, places, numbers = (np.concatenate(arrays) for arrays in zip(*copies, strict=True))
    return replace(
        motion,
        angles=remove_jumps(motion.skeleton.bones, poses),
        root_positions=places,
        root_angles=None,
        frame_numbers=numbers,
        seen=None if motion.seen is None else motion.seen[[*np.arange(len(poses) - 1) % (len(motion) - 1), -1]],
    )


def _positions(motion: MotionLike) -> np.ndarray:
    """The positions (n, n_joints + 1, 3) of root and joints, all with the first heading and above the origin."""
    poses = _rotate(motion, -_turns(motion))
    positions = joint_positions(motion.skeleton, poses, Rotation.identity(len(poses)))
    up = "xyz".index(motion.up)
    positions[..., up] += motion.root_positions[:, None, up]
    return positions


def _distances(positions: np.ndarray, others: np.ndarray) -> np.ndarray:
    """The roots (n,) of the sums of squared distances of joints, m."""
    return np.sqrt(np.square(positions - others).sum(axis=(-2, -1)))
