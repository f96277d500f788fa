"""Segments of a person that positions show: nothing of them, the direction of their line, or all of the rotation."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from skpose.biomechanics._segments import Segment
from skpose.kinematics._lines import ROOT, find_carriers
from skpose.skeleton import Motion
from skpose.skeleton._rest import positions_at_zero

# Least distance of a point from the line of its segment, relative to its length, if the point shows how the
# segment is rotated about the line. An epicondyle is 5 cm from the line of a thigh of 40 cm.
OFF_LINE = 0.05
SPREAD = 0.1  # the same of some of the points, about their own line, as a root of a sum of squares
APART = 0.5  # least distance of two points that show the direction of the line, likewise
NOTHING, DIRECTION, ROTATION = 0, 1, 2


class Seen(NamedTuple):
    """Segments as the positions show them to which a motion was fitted; a recording of rotations shows all."""

    lines: set[str]  # segments of which no frame shows more than the direction
    frames: dict[str, np.ndarray]  # (n_frames,) of each segment, whether a frame shows as much as any


def find_seen(motion: Motion, segments: dict[str, Segment]) -> Seen:
    """The segments shown by the positions to which a motion was fitted."""
    if motion.seen is None:
        return Seen(set(), {name: np.ones(len(motion), dtype=bool) for name in segments})
    known = find_shown(motion, range(motion.skeleton.n_joints))
    lines, frames = set(), {"trunk": np.zeros(len(motion), dtype=bool)}  # where the skeleton has none
    for name, segment in segments.items():
        seen = _seen_points(motion, known, segment)
        patterns, which = np.unique(seen, axis=0, return_inverse=True)
        shown: np.ndarray = np.array([_shows(segment, pattern) for pattern in patterns], dtype=int)[which.ravel()]
        most = int(shown.max(initial=NOTHING))
        if most < ROTATION:
            lines.add(name)
        frames[name] = shown >= max(most, DIRECTION)
    return Seen(lines, frames)


def find_shown(motion: Motion, joints: Sequence[int]) -> np.ndarray:
    """In which frames the places of joints are known, (n_frames, n): the joint, or what it is fixed to, is seen.

    Three points that are not on one line show where everything is that is fixed to them.
    """
    if motion.seen is None:
        return np.ones((len(motion), len(joints)), dtype=bool)
    carriers, parents = np.array(find_carriers(motion.skeleton)), np.asarray(motion.skeleton.parents)
    zero, shown = positions_at_zero(motion.skeleton), motion.seen[:, joints].copy()
    for carrier in np.unique(carriers):
        carried = np.flatnonzero(carriers == carrier)
        points = np.array(sorted({*carried, *parents[carried]} - {ROOT}))
        patterns, which = np.unique(motion.seen[:, points], axis=0, return_inverse=True)
        size = float(np.linalg.norm(np.ptp(zero[points], axis=0)))
        shows = np.array([_is_spread(zero[points[pattern]], size) for pattern in patterns], dtype=bool)[which.ravel()]
        shown |= shows[:, None] & np.isin(joints, points)
    return shown


def _is_spread(points: np.ndarray, size: float) -> bool:
    """Whether points (n, 3) of a segment of some size, m, are not on one line."""
    return len(points) > 2 and bool(np.linalg.svd(points - points.mean(axis=0))[1][1] > SPREAD * size)


def _seen_points(motion: Motion, known: np.ndarray, segment: Segment) -> np.ndarray:
    """Which points of a segment, its start and its end are known, (n_frames, n_points + 2).

    The root has no position of its own. It is where a joint of no length is, or as far from a joint that another
    segment carries as their bone is long.
    """
    points = (*segment.points, segment.start, segment.end)
    columns = known[:, points].copy()
    if ROOT in points:
        at_zero = positions_at_zero(motion.skeleton)
        at_root = [
            joint
            for joint, parent in enumerate(motion.skeleton.parents)
            if parent == ROOT and (joint not in segment.points or not at_zero[joint].any())
        ]
        columns[:, np.equal(points, ROOT)] = known[:, at_root].any(axis=1, keepdims=True)
    return columns


def _shows(segment: Segment, seen: np.ndarray) -> int:
    """How much of a segment is shown by its known points and ends, (n_points + 2,) of bool."""
    length = float(np.linalg.norm(segment.along))
    (*_, start, end), fixed = seen, seen[:-2]
    points = segment.at_zero[fixed]
    if not length:  # as a head has that ends where it begins
        return DIRECTION if seen.any() else NOTHING
    across = points - (points @ segment.along)[:, None] * segment.along / length**2
    off_line = np.linalg.norm(across, axis=1) >= OFF_LINE * length
    ends_are_fixed = {segment.start, segment.end} <= {*segment.points}
    if (ends_are_fixed and fixed.all() and off_line.any()) or _is_spread(points, length):
        return ROTATION
    on_line = points[~off_line] @ segment.along / length
    two = len(on_line) > 1 and np.ptp(on_line) >= APART * length
    return DIRECTION if (start and end) or two else NOTHING
