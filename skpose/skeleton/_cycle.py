"""Cycles: motions whose last frame is the first one, moved along the floor, so that they can be repeated.

Let δ be the difference between end and start: a rotation of each joint and of the root's tilt, and a height. With s
from 0 to 1 over the cycle, frame s is changed by (s − ½) δ, a rotation about a fixed axis, so that the ends meet
halfway. Place and heading do not change: their difference is the travel of the cycle.
"""

from typing import NamedTuple

import numpy as np
from scipy.spatial.transform import Rotation

from skpose.skeleton._bone import BALL, Bone, are_slides
from skpose.skeleton._chart import move, steps_from
from skpose.skeleton._root import heading
from skpose.skeleton._rotations import joint_positions
from skpose.skeleton._skeleton import Skeleton

ROOT = Bone("root", None, (0.0, 0.0, 0.0), BALL)
NEAR = 0.25  # of the smaller step at the ends; if nearer, the last pose is the first one again
FAR = 0.2  # of the largest distance from the first pose, beyond which a cycle is not whole; strides reach 0.17
CUT = 1.5  # steps by which the cut at whole frames may be off
SEAM = 0.1  # of the largest change between two frames; tolerance at the ends of a cycle
ROUNDING = 1e-6  # of files: rad, m


class Frames(NamedTuple):
    """The frames of a motion, the root a ball joint among others."""

    skeleton: Skeleton
    poses: np.ndarray  # (n, n_dofs + 3) joints' columns, then the root's rotation vector
    places: np.ndarray  # (n, 3) of the root, m
    numbers: np.ndarray  # (n,)
    rows: np.ndarray  # (n,) the frame of the motion from which each is made
    up: str

    @property
    def bones(self) -> list[Bone]:
        """The joints of all columns."""
        return [*self.skeleton.bones, ROOT]

    @property
    def root(self) -> Rotation:
        """Orientations of the root."""
        return Rotation.from_rotvec(self.poses[:, -3:])

    @property
    def heights(self) -> np.ndarray:
        """Heights of the root, m; a view."""
        return self.places[:, "xyz".index(self.up)]

    @property
    def turns(self) -> np.ndarray:
        """Changes of the heading since the first frame, rad in [−π, π]."""
        return heading(self.root * self.root[:1].inv(), self.up)

    def rotate(self, turns: np.ndarray) -> "Frames":
        """Rotate the frames about the vertical through the root, each or all by an angle."""
        poses = self.poses.copy()
        poses[:, -3:] = (Rotation.from_euler(self.up, np.reshape(turns, (-1, 1))) * self.root).as_rotvec()
        return self._replace(poses=poses)


def close_cycle(frames: Frames, endpoint: bool) -> tuple[Frames, list[str]]:
    """A cycle, and warnings if the frames were none; without `endpoint` the frame that ends it is added."""
    positions = _positions(frames)
    steps = _distances(positions[1:], positions[:-1]) / np.diff(frames.numbers)
    complaints = []
    if not endpoint:
        if _distances(positions[-1], positions[0]) < NEAR * steps[[0, -1]].min():
            complaints.append(
                "the last pose is the first one again, but is taken for the one before: pass endpoint=True"
            )
        frames = _add_end(frames)
        positions = _positions(frames)
    away = _distances(positions, positions[0])
    if away[-1] > max(FAR * away.max(), CUT * max(np.median(steps), steps[[0, -1]].mean())):
        complaints.append(
            "the cycle ends far from its first pose: it is not one whole cycle, but is closed nevertheless"
        )
    turn = frames.turns[-1]
    gap = steps_from(frames.bones, frames.poses[-1:], frames.rotate(turn).poses[:1])
    shares = (frames.numbers - frames.numbers[0]) / (frames.numbers[-1] - frames.numbers[0]) - 0.5
    closed = frames._replace(poses=move(frames.bones, frames.poses, shares[:, None] * gap), places=frames.places.copy())
    closed.heights[:] += shares * (frames.heights[0] - frames.heights[-1])
    return closed, complaints


def _add_end(frames: Frames) -> Frames:
    """Add a frame at the mean of the velocities of the last step and of the first.

    The first step is repeated at the end, with the heading of the end.
    """
    ends = np.array([0, -1])
    times = np.diff(frames.numbers)[ends]
    rates = steps_from(frames.bones, frames.poses[[0, -2]], frames.poses[[1, -1]]) / times[:, None]
    turns = heading(frames.root[[1, -1]] * frames.root[[0, -2]].inv(), frames.up) / times
    velocities = np.diff(frames.places, axis=0)[ends] / times[:, None]
    next_velocity = Rotation.from_euler(frames.up, frames.turns[-1] + turns.mean()).apply(velocities[0])
    pose = move(frames.bones, frames.poses[-1:], rates.mean(axis=0, keepdims=True))
    place = frames.places[-1] + (velocities[1] + next_velocity) / 2.0
    return frames._replace(
        poses=np.concatenate([frames.poses, pose]),
        places=np.concatenate([frames.places, place[None]]),
        numbers=np.append(frames.numbers, frames.numbers[-1] + 1),
        rows=np.append(frames.rows, frames.rows[-1]),
    )


def describe_opening(frames: Frames) -> str:
    """The difference between the last frame and the first, moved along; empty if there is none."""
    gap = np.abs(steps_from(frames.bones, frames.poses[-1:], frames.rotate(frames.turns[-1]).poses[:1]))[0]
    steps = np.abs(steps_from(frames.bones, frames.poses[:-1], frames.poses[1:]))
    names, slides = np.array([*frames.skeleton.dof_names, *["the root"] * 3]), are_slides(frames.bones)
    for these, unit in ((~slides, "rad"), (slides, "m")):
        if these.any() and gap[these].max() > SEAM * steps[:, these].max() + ROUNDING:
            return f"{names[these][gap[these].argmax()]} differs by {gap[these].max():.2g} {unit}"
    rise = abs(frames.heights[-1] - frames.heights[0])
    if rise > SEAM * np.abs(np.diff(frames.heights)).max() + ROUNDING:
        return f"the height of the root differs by {rise:.2g} m"
    return ""


def repeat_cycle(frames: Frames, n: int) -> Frames:
    """Repeat a cycle n times, each from the place and with the heading of the end of the one before."""
    turn, duration = frames.turns[-1], frames.numbers[-1] - frames.numbers[0]
    places = frames.places - frames.places[0]
    travel = places[-1].copy()
    travel["xyz".index(frames.up)] = 0.0
    start, copies = frames.places[0], []
    for i in range(n):
        onward = Rotation.from_euler(frames.up, i * turn)
        copy = frames.rotate(i * turn)
        copy = copy._replace(places=start + onward.apply(places), numbers=frames.numbers + i * duration)
        start = start + onward.apply(travel)
        rows = slice(None if i == n - 1 else -1)
        copies.append([array[rows] for array in (copy.poses, copy.places, copy.numbers, copy.rows)])
    poses, places, numbers, made_of = (np.concatenate(arrays) for arrays in zip(*copies, strict=True))
    return frames._replace(poses=poses, places=places, numbers=numbers, rows=made_of)


def _positions(frames: Frames) -> np.ndarray:
    """The positions (n, n_joints + 1, 3) of root and joints, all with the first heading and above the origin."""
    level = frames.rotate(-frames.turns)
    positions = joint_positions(frames.skeleton, frames.poses[:, :-3], level.root)
    positions[..., "xyz".index(frames.up)] += frames.heights[:, None]
    return positions


def _distances(positions: np.ndarray, others: np.ndarray) -> np.ndarray:
    """The roots (n,) of the sums of squared distances of joints, m."""
    return np.sqrt(np.square(positions - others).sum(axis=(-2, -1)))
