"""What positions show of the segments of a person: nothing, the direction of the line, or all of the rotation."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from skpose.biomechanics._segments import ROOT, Segment
from skpose.kinematics._shared import find_carriers
from skpose.skeleton import Motion, Skeleton
from skpose.skeleton._shared import positions_at_zero

# Distance of a point from the line of its segment, relative to the length of that, from which the point shows how the
# segment is rotated about the line. An epicondyle is 5 cm from the line of a thigh of 40 cm.
OFF_LINE = 0.05
APART = 0.5  # distance of two points, likewise, from which they show the direction of the line
NOTHING, DIRECTION, ROTATION = 0, 1, 2
SHOULDERS = "shoulders"


class Seen(NamedTuple):
    """What the positions to which a motion was fitted show of its segments; a recording of rotations shows all."""

    lines: set[str]  # segments of which no frame shows more than the direction
    # (n_frames,) of each segment, whether a frame shows as much as any; of "shoulders", whether it shows both.
    frames: dict[str, np.ndarray]


def find_seen(motion: Motion, segments: dict[str, Segment]) -> Seen:
    """Return what the positions show to which a motion was fitted."""
    if motion.seen is None:
        return Seen(set(), {name: np.ones(len(motion), dtype=bool) for name in (*segments, SHOULDERS)})
    lines, frames = set(), {SHOULDERS: np.zeros(len(motion), dtype=bool)}
    for name, segment in segments.items():
        patterns, which = np.unique(_seen_points(motion.skeleton, motion.seen, segment), axis=0, return_inverse=True)
        shown: np.ndarray = np.array([_shows(segment, pattern) for pattern in patterns], dtype=int)[which.ravel()]
        most = int(shown.max(initial=NOTHING))
        if most < ROTATION:
            lines.add(name)
        if name == "trunk":
            most = ROTATION  # its line is that of the shoulders, which does not show how it leans
            frames[SHOULDERS] = motion.seen[:, segment.start] & motion.seen[:, segment.end]
        frames[name] = shown >= max(most, DIRECTION)
    return Seen(lines, frames)


def find_shown(motion: Motion, joints: Sequence[int]) -> np.ndarray:
    """Return in which frames the places of joints are known, (n_frames, n): the joint, or what it is fixed to, is seen.

    Three points that are not on one line show where everything is that is fixed to them.
    """
    if motion.seen is None:
        return np.ones((len(motion), len(joints)), dtype=bool)
    carriers, parents = np.array(find_carriers(motion.skeleton)), np.asarray(motion.skeleton.parents)
    zero, shown = positions_at_zero(motion.skeleton), motion.seen[:, joints].copy()
    for i, joint in enumerate(joints):
        for carrier in {carriers[joint], *carriers[parents == joint]}:
            carried = np.flatnonzero(carriers == carrier)
            points = np.array(sorted({*carried, *parents[carried]} - {ROOT}))
            patterns, which = np.unique(motion.seen[:, points], axis=0, return_inverse=True)
            size = float(np.linalg.norm(np.ptp(zero[points], axis=0)))
            shows = np.array([_is_spread(zero[points[pattern]], size) for pattern in patterns], dtype=bool)
            shown[:, i] |= shows[which.ravel()]
    return shown


def _is_spread(points: np.ndarray, size: float) -> bool:
    """Return whether points (n, 3) of a body of some size, m, are not on one line."""
    return len(points) > 2 and bool(np.linalg.svd(points - points.mean(axis=0))[1][1] > 0.5 * OFF_LINE * size)


def _seen_points(skeleton: Skeleton, seen: np.ndarray, segment: Segment) -> np.ndarray:
    """Return which points of a segment are seen, (n_frames, n_points).

    The root has no position of its own. It is where a joint of no length is, or as far from a joint that another
    segment carries as their bone is long.
    """
    columns = seen[:, segment.points].copy()
    if ROOT in segment.points:
        at_root = [
            joint
            for joint, parent in enumerate(skeleton.parents)
            if parent == ROOT and (joint not in segment.points or not positions_at_zero(skeleton)[joint].any())
        ]
        columns[:, segment.points.index(ROOT)] = seen[:, at_root].any(axis=1)
    return columns


def _shows(segment: Segment, seen: np.ndarray) -> int:
    """Return what the points of a segment that are seen, (n_points,) of bool, show of it."""
    length = float(np.linalg.norm(segment.along))
    points = segment.at_zero[seen]
    if not length:  # as a head has that ends where it begins
        return DIRECTION if seen.any() else NOTHING
    across = points - (points @ segment.along)[:, None] * segment.along / length**2
    off_line = np.linalg.norm(across, axis=1) >= OFF_LINE * length
    if seen.all():
        return ROTATION if off_line.any() else DIRECTION
    if _is_spread(points, length):
        return ROTATION
    on_line = points[~off_line] @ segment.along / length
    return DIRECTION if len(on_line) > 1 and np.ptp(on_line) >= APART * length else NOTHING
