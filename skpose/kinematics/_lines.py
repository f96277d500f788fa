"""The lines of two skeletons that are made parallel: bones that are counterparts, or lines in their place.

A bone's counterpart is the line between the counterparts of its ends, or, where its near end has none, the bone that
ends at the counterpart of its far end. In people pelvis, chest, head and feet are aligned by their axes instead, see
`_body`.
"""

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from skpose.kinematics._anatomy import COLLAR, HIP, SHOULDER, SIDES, Anatomy, pair_of
from skpose.kinematics._forward import joint_positions
from skpose.skeleton import Skeleton
from skpose.skeleton._rest import NO_DIRECTION, directions_at_zero, find_carriers

ROOT = -1
MIDDLE = -2  # the middle between the hips, in people: roots are higher up in some rigs
STRAIGHT = np.cos(np.radians(30.0))  # bones of a limb, or of the trunk, up to this angle apart have one direction


class Line(NamedTuple):
    """Two joints of the target, and the two of the source between which the direction is, or `ROOT` or `MIDDLE`."""

    start: int
    end: int
    source_start: int
    source_end: int


class Lines(NamedTuple):
    """The lines that are made parallel."""

    of_bones: dict[int, Line]  # for the joint at which each bone of the target ends
    hips: tuple[tuple[int, int] | None, tuple[int, int] | None]  # of source and target
    directions: np.ndarray  # (n_joints, 3) of the lines of bones in the target at angle zero; zeros if there is none
    positions: np.ndarray  # (n_joints + 2, 3) of the target at angle zero, see `with_root`


def find_lines(source: Skeleton, target: Skeleton, there: np.ndarray, people: tuple[Anatomy, Anatomy] | None) -> Lines:
    """Find the lines of counterparts; people are the landmarks of source and target, if both are people."""
    lines, carriers = {}, find_carriers(target)
    lengths = np.linalg.norm(target.offsets, axis=1)
    for joint in np.flatnonzero(there >= 0).tolist():
        start = int(target.parents[joint])
        while start >= 0 and there[start] < 0 and lengths[start] == 0.0:  # the same point as the joint before
            start = int(target.parents[start])
        end = int(there[joint])
        source_start = ROOT if start < 0 else int(there[start]) if there[start] >= 0 else int(source.parents[end])
        lines[joint] = Line(int(target.parents[joint]), joint, source_start, end)
    directions = directions_at_zero(target)
    hips = (None, None) if people is None else (pair_of(people[0].joints, HIP), pair_of(people[1].joints, HIP))
    positions = with_root(joint_positions(np.zeros((1, target.n_dofs)), target), hips[1])[0]
    if people is None:
        return Lines(lines, hips, directions, positions)
    _keep_straight(lines, target, there, people[1], positions)
    _adapt_girdles(lines, source, target, there, people[1].joints)
    for joint in people[1].trunk if None not in hips else ():  # the trunk begins in the middle between the hips
        line = lines.get(joint)
        if line is not None and line.source_start == ROOT:
            start = MIDDLE if line.start == ROOT and carriers[joint] == ROOT else line.start
            lines[joint] = line._replace(start=start, source_start=MIDDLE)
    for joint, line in lines.items():
        if line.start != int(target.parents[joint]) or line.end != joint:
            directions[joint] = unit(positions[line.end] - positions[line.start])
    return Lines(lines, hips, directions, positions)


def with_root(positions: np.ndarray, hips: tuple[int, int] | None) -> np.ndarray:
    """Append the middle between the hips and the root, `MIDDLE` and `ROOT`, to positions (n_frames, n_joints, 3)."""
    root = np.zeros((len(positions), 1, 3))
    middle = positions[:, list(hips)].mean(axis=1, keepdims=True) if hips is not None else root
    return np.concatenate([positions, middle, root], axis=1)


def unit(vectors: np.ndarray) -> np.ndarray:
    """Normalise vectors (..., 3); zeros stay zero, and NaN stays NaN."""
    sizes = np.linalg.norm(vectors, axis=-1, keepdims=True)
    return np.divide(vectors, sizes, out=np.zeros_like(vectors), where=sizes != 0.0)


def _keep_straight(
    lines: dict[int, Line], target: Skeleton, there: np.ndarray, person: Anatomy, positions: np.ndarray
) -> None:
    """Give all bones between two joints with counterparts one direction, if they are on one line at angle zero.

    So a forearm of two bones is as straight as one of one bone.
    """
    parents = target.parents
    for end in sorted({*person.joints.values(), *person.trunk, *person.neck}):
        if there[end] < 0:
            continue
        path = [end]
        while (above := int(parents[path[-1]])) >= 0 and there[above] < 0:
            path.append(above)
        along = unit(positions[end] - positions[above])
        bones = unit(positions[path] - positions[parents[path]])
        if len(path) > 1 and ((bones @ along > STRAIGHT) | ~bones.any(axis=1)).all():
            source_start = ROOT if above < 0 else int(there[above])
            for joint in path:
                lines[joint] = Line(int(parents[joint]), joint, source_start, int(there[end]))


def _adapt_girdles(
    lines: dict[int, Line], source: Skeleton, target: Skeleton, there: np.ndarray, ours: Mapping[str, int]
) -> None:
    """Bones of the pelvis that can move stay at rest, and collarbones that end at shoulders follow collarbones."""
    for joint in pair_of(ours, HIP) or ():
        lines.pop(joint, None)
    for side, joint in zip(SIDES, pair_of(ours, SHOULDER) or (), strict=False):
        if there[joint] >= 0 and int(target.parents[joint]) != ours.get(f"{side}_{COLLAR}"):
            start = int(source.parents[there[joint]])
            lines[joint] = Line(int(target.parents[joint]), joint, start, int(there[joint]))


def source_lines(source: Skeleton, positions: np.ndarray, lines: list[Line]) -> np.ndarray:
    """The directions (n_frames, n_lines, 3) of lines in the source; zeros for lines too short in any frame.

    Positions (n_frames, n_joints + 2, 3) as from `with_root`.
    """
    starts, ends = [line.source_start for line in lines], [line.source_end for line in lines]
    vectors = positions[:, ends] - positions[:, starts]
    sizes = np.linalg.norm(vectors, axis=2)
    longest = np.linalg.norm(source.offsets, axis=1).max()
    directions = unit(vectors)
    directions[:, sizes.min(axis=0) <= NO_DIRECTION * longest] = 0.0
    return directions
