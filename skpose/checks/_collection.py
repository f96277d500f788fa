"""Faults of a collection: motions twice in it, on several rigs or at several rates, and motions unlike all others.

Motions are compared by the distances between the landmarks of the person, and their heights, in some frames evenly
spaced in time. These do not depend on the place and the heading of the root, on its axes, or on the rig.
"""

from collections import Counter, defaultdict
from collections.abc import Callable, Iterator, Sequence
from typing import NamedTuple

import numpy as np

from skpose.checks._findings import Finding
from skpose.checks._recording import Recording
from skpose.skeleton._sides import others

POSES = 24  # of each motion that are compared
SAME, NEAR = 0.005, 0.015  # m, mean differences; two takes of one action by one person differ by 0.016
STILL = 0.045  # m, movement about the mean pose below which nothing shows a mirror image
ELSEWHERE = 0.02  # m, difference of two paths of roots
MANY, UNLIKE = 10, 5.0  # motions, and times the median distance to the nearest other one
ONE_OF = "keep one of them, or both in one part of a split"


class Summary(NamedTuple):
    """What is kept of a motion to compare it with others."""

    number: int
    n_frames: int
    seconds: float
    scale: float  # of the person, to one with legs of 0.9 m, which lengths below are of
    kept: dict[str, tuple]  # what most motions of a collection have in common
    marks: tuple[str, ...]
    poses: tuple[np.ndarray, np.ndarray]  # (POSES, n_numbers) of it and of its mirror image, m
    path: np.ndarray  # (POSES, 2) of the root: distance from the start, and height, m


def summarise(recording: Recording, number: int) -> Summary:
    motion = recording.motion
    columns = dict(sorted(recording.joints.items())) or dict(
        zip(motion.skeleton.joint_names, range(10**6), strict=False)
    )
    marks = list(columns)
    partners = [
        next((marks.index(other) for other in others(mark) if other in columns), i) for i, mark in enumerate(marks)
    ]
    rows = np.linspace(0, len(motion) - 1, POSES).round().astype(int)
    points = recording.around_root[rows][:, [j + 1 for j in columns.values()]].astype(np.float32)
    root, upper = recording.points[rows, 0], np.triu_indices(len(marks), 1)
    poses = []
    for some in (points, points[:, partners]):
        apart = np.linalg.norm(some[:, :, None] - some[:, None], axis=3)
        numbers = np.concatenate([apart[:, upper[0], upper[1]], some[:, :, 2]], axis=1)
        poses.append(numbers / np.float32(np.sqrt(numbers.size)))
    path = np.stack([np.linalg.norm(root - root[0], axis=1), root[:, 2]], axis=1)
    kept = {
        "rig": (f"{motion.skeleton.n_joints} joints", motion.skeleton.joint_names),
        "frame rate": (f"{motion.frame_rate:g} Hz",),
        "up axis": (motion.up,),
    }
    seconds = float(motion.times[-1] - motion.times[0])
    return Summary(number, len(motion), seconds, recording.scale, kept, tuple(marks), (poses[0], poses[1]), path)


def compare(summaries: Sequence[Summary], name_of: Callable[[int], str]) -> Iterator[Finding]:
    """The findings of a collection of motions."""
    groups = defaultdict(list)
    for summary in summaries:
        groups[summary.marks].append(summary)
    for group in groups.values():
        yield from _doubles(group, name_of)
    for name in ("rig", "frame rate", "up axis"):
        for value, n in Counter(summary.kept[name] for summary in summaries).most_common()[1:]:
            first = next(summary for summary in summaries if summary.kept[name] == value)
            what = f"{n} of {len(summaries)} motions, first this one, have another {name} than most: {value[0]}"
            frames, remedy = (0, first.n_frames), "retarget, resample or turn them to one before they are compared"
            yield Finding("note", "mixture", first.number, frames, (), float(n), "motions", what, remedy)


def _doubles(group: Sequence[Summary], name_of: Callable[[int], str]) -> Iterator[Finding]:
    """Motions with the poses of an earlier one, or of its mirror image, and motions far from all others."""
    poses, mirrored = (np.stack([summary.poses[i] for summary in group]) for i in range(2))
    plain = _apart(poses, poses)
    centred, other = (one - one.mean(axis=1, keepdims=True) for one in (poses, mirrored))  # limbs differ in length
    flipped = _apart(centred, other)
    flipped[np.linalg.norm(centred.reshape(len(group), -1), axis=1) < STILL] = np.inf  # only noise
    for one in (plain, flipped):
        np.fill_diagonal(one, np.inf)
    distances = np.minimum(plain, flipped)
    moving = np.array([np.ptp(summary.poses[0], axis=0).any() for summary in group])
    for i, j in np.argwhere(np.tril(distances < NEAR) & moving & moving[:, None]).tolist():
        a, b, is_mirrored = group[j], group[i], bool(flipped[i, j] < plain[i, j])
        apart = float(np.abs(a.path - b.path).max())
        differs = [f"the root is up to {apart * b.scale:.2g} m elsewhere"] * (apart > ELSEWHERE)
        if abs(a.seconds - b.seconds) > 0.05 * a.seconds:
            differs.append(f"it takes {b.seconds:.3g} s instead of {a.seconds:.3g} s: one frame rate is wrong")
        what = f"it has the {'mirrored ' * is_mirrored}poses of {name_of(a.number)}" + "".join(
            f"; {x}" for x in differs
        )
        same, distance = bool(distances[i, j] < SAME), float(distances[i, j]) * b.scale
        severity, kind = "error" if same and differs else "warning", "duplicate" if same else "near duplicate"
        yield Finding(severity, kind, b.number, (0, b.n_frames), (), distance, "m", what, ONE_OF)
    nearest = np.where(plain < NEAR, np.inf, plain).min(axis=1)
    usual = float(np.median(nearest))
    for k in np.flatnonzero((nearest > UNLIKE * usual) & np.isfinite(nearest)).tolist() if len(group) >= MANY else ():
        what = f"the nearest other motion is {nearest[k] / usual:.2g} times as far as usual"
        yield Finding(
            "note",
            "unlike others",
            group[k].number,
            (0, group[k].n_frames),
            (),
            float(nearest[k]) * group[k].scale,
            "m",
            what,
            "look at it",
        )


def _apart(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    a, b = a.reshape(len(a), -1), b.reshape(len(b), -1)
    squares = (a**2).sum(axis=1)[:, None] + (b**2).sum(axis=1) - 2.0 * a @ b.T
    return np.sqrt(np.maximum(squares, 0.0))
