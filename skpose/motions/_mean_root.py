"""The mean movement of the root, along the paths that align motions to their mean."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from scipy.spatial.transform import Rotation

from skpose.motions._barycenter import Aligned
from skpose.skeleton import Motion
from skpose.skeleton._shared import continuous_root_angles, find_root_joint, heading, join_seen, root_orientations


class MeanRoot(NamedTuple):
    """The movement of the root of a mean."""

    positions: np.ndarray  # (n_frames, 3), m
    angles: np.ndarray  # (n_frames, k), rad
    axes: str
    up: str
    name: str
    seen: np.ndarray | None  # (n_frames, n_joints) joints with positions in all aligned frames; None: not fitted


def check_roots(motions: Sequence[Motion]) -> None:
    """Refuse motions with different up axes, or with different parts of the root's orientation in their poses."""
    first = motions[0] if motions else None
    for i, motion in enumerate(motions):
        if motion.up != first.up:
            raise ValueError(f'motions[0] has "{first.up}" up and motions[{i}] "{motion.up}": rotate one of them')
        axes, others = (set(one.root_axes.lower()) for one in (first, motion))
        if axes != others and find_root_joint(motion.skeleton):
            raise ValueError(f"motions[0] and motions[{i}] differ in root axes: call without_root() of all")


def mean_root(motions: Sequence[Motion], aligned: Aligned) -> MeanRoot:
    """Average the roots, each relative to the place and heading at which its motion begins.

    Each motion has the same weight in each frame, however many of its frames are aligned there; otherwise the mean
    would jump where these numbers change.
    """
    first = motions[0]
    orientations: list[Rotation] = []
    positions = []
    for motion in motions:
        own = root_orientations(motion.root_angles, motion.root_axes)
        # Relative to the first motion: bones that point down at angle zero have no heading of their own.
        begin = own[:1] if not orientations else orientations[0][:1]
        back = Rotation.from_euler(first.up, -heading(own[:1] * begin.inv(), first.up))
        orientations.append(back * own)
        positions.append(back.apply(motion.root_positions - motion.root_positions[0] * _on_floor(first.up)))
    everywhere, places = Rotation.concatenate(orientations), np.concatenate(positions)
    motion_of = np.repeat(np.arange(len(motions)), [len(motion) for motion in motions])
    means, mean_places = [], []
    for rows in aligned.groups():
        counts = np.bincount(motion_of[rows], minlength=len(motions))
        weights = 1.0 / (len(motions) * counts[motion_of[rows]])
        means.append(everywhere[rows].mean(weights))
        mean_places.append(weights @ places[rows])
    mean = Rotation.concatenate(means)
    back = Rotation.from_euler(first.up, -heading(mean[:1], first.up))
    angles, axes = continuous_root_angles(back * mean, first.root_axes)
    there = np.array(mean_places)
    there = back.apply(there - there[0] * _on_floor(first.up))
    seen = join_seen([motion.seen for motion in motions], list(map(len, motions)))
    if seen is not None:
        seen = np.stack([seen[rows].all(axis=0) for rows in aligned.groups()])
    return MeanRoot(there, angles, axes, first.up, first.root_name, seen)


def _on_floor(up: str) -> np.ndarray:
    """1 for axes along the floor and 0 for the one that points up."""
    return np.array([float(axis != up) for axis in "xyz"])
