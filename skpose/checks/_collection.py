"""Faults of a collection: motions twice in it, on several rigs or at several rates, and motions unlike all others."""

from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from typing import NamedTuple

import numpy as np

from skpose.checks._findings import Finding, limit
from skpose.checks._recording import Recording
from skpose.kinematics._anatomy import HIP, SIDES
from skpose.kinematics._lines import unit
from skpose.skeleton._sides import partners

POSES = 24  # of each motion that are compared, evenly spaced in time
MANY = 10  # motions from which one can be unlike the others
BLOCK = 512  # motions of which the distances to all others are in memory


class Summary(NamedTuple):
    """What is kept of a motion to compare it with others."""

    n_frames: int
    rate: float
    duration: float
    up: str
    moves: bool
    rig: tuple[str, ...]
    marks: tuple[str, ...]  # of the points
    poses: np.ndarray  # (POSES, n_marks, 3), facing along x from the root
    path: np.ndarray  # (POSES, 3) of the root, from the first frame along its heading


def summarise(recording: Recording) -> Summary:
    motion, joints = recording.motion, recording.person.joints
    marks = tuple(sorted(joints)) if joints else recording.names[1:]
    columns = [joints[mark] + 1 for mark in marks] if joints else list(range(1, len(recording.names)))
    rows = np.linspace(0, len(motion) - 1, POSES).round().astype(int)
    root, poses = recording.points[rows, 0], recording.around_root[rows][:, columns]
    if recording.has(*(f"{side}_{HIP}" for side in SIDES)):
        left = (recording.at(f"left_{HIP}") - recording.at(f"right_{HIP}"))[rows, :2]
    else:
        left = np.tile([0.0, 1.0], (POSES, 1))
    left = unit(left)
    turns = np.zeros((POSES, 3, 3))  # to axes forward, left and up
    turns[:, 0, 0], turns[:, 0, 1], turns[:, 2, 2] = left[:, 1], -left[:, 0], 1.0
    turns[:, 1, :2] = left
    poses = np.einsum("fij,fkj->fki", turns, poses)
    path = (root - root[0]) @ turns[0].T
    seconds = float(motion.times[-1] - motion.times[0])
    moves = bool(np.ptp(poses, axis=0).max() > limit("near"))
    head = len(motion), motion.frame_rate, seconds, motion.up, moves, recording.names, marks
    return Summary(*head, poses.astype(np.float32), path.astype(np.float32))


def compare(summaries: Sequence[tuple[int, Summary]], name_of: Callable[[int], str]) -> Iterator[Finding]:
    """The findings of a collection of numbered motions."""
    yield from _mixtures(summaries)
    groups: dict[tuple, list[tuple[int, Summary]]] = {}
    for number, summary in summaries:
        groups.setdefault(summary.marks, []).append((number, summary))
    for marks, group in groups.items():
        group = [one for one in group if one[1].moves]
        if len(group) > 1:
            yield from _doubles(marks, group, name_of)


def _mixtures(summaries: Sequence[tuple[int, Summary]]) -> Iterator[Finding]:
    """Rigs, frame rates and up axes other than most motions have."""
    for name, field in (("rig", "rig"), ("frame rate", "rate"), ("up axis", "up")):
        counts = Counter(getattr(summary, field) for _, summary in summaries)
        for value, n in counts.most_common()[1:]:
            number, first = next(one for one in summaries if getattr(one[1], field) == value)
            text = f"{len(value) - 1} joints" if field == "rig" else f"{value:g} Hz" if field == "rate" else value
            what = f"{n} of {len(summaries)} motions, of which this is the first, have another {name} than most: {text}"
            yield Finding(
                "note", "mixture", number, (0, first.n_frames), (), float(n), "motions", what,
                "retarget, resample or turn them to one before they are compared",
            )  # fmt: skip


def _doubles(
    marks: tuple[str, ...], group: list[tuple[int, Summary]], name_of: Callable[[int], str]
) -> Iterator[Finding]:
    """Motions with the poses of an earlier one, or of its mirror image, and motions far from all others."""
    poses = np.stack([summary.poses for _, summary in group])
    try:
        mirrored = poses[:, :, partners(marks)] * np.array([1.0, -1.0, 1.0], dtype=np.float32)
    except ValueError:  # names without partners
        mirrored = np.full_like(poses, np.inf)
    rms = np.sqrt(poses[0, :, :, 0].size)
    flat, flipped = (one.reshape(len(group), -1) / rms for one in (poses, mirrored))
    nearest, known = np.full(len(group), np.inf), set()
    for start in range(0, len(group), BLOCK):
        rows = slice(start, start + BLOCK)
        for others, word in ((flat, ""), (flipped, "mirrored ")):
            distances = _distances(flat[rows], others)
            numbers = np.arange(start, start + len(distances))
            distances[np.arange(len(distances)), numbers] = np.inf
            nearest[rows] = np.minimum(nearest[rows], distances.min(axis=1))
            for i, j in np.argwhere(distances < limit("near")).tolist():
                if j < i + start and (i + start, j) not in known:
                    known.add((i + start, j))
                    yield _double(group[j], group[i + start], float(distances[i, j]), word, name_of)
    if len(group) >= MANY:
        usual = float(np.median(nearest))
        for k in np.flatnonzero(nearest > limit("unlike") * usual):
            number, summary = group[k]
            what = f"the nearest other motion is {nearest[k]:.2g} m away, in the median {usual:.2g} m"
            yield Finding(
                "note", "unlike others", number, (0, summary.n_frames), (), float(nearest[k]), "m", what, "look at it"
            )


def _distances(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    squares = (a**2).sum(axis=1)[:, None] + (b**2).sum(axis=1) - 2.0 * a @ b.T
    return np.sqrt(np.maximum(squares, 0.0))


def _double(
    one: tuple[int, Summary], other: tuple[int, Summary], distance: float, word: str, name_of: Callable[[int], str]
) -> Finding:
    (i, a), (j, b) = one, other
    same = distance < limit("same")
    path = a.path * [1.0, -1.0, 1.0] if word else a.path
    apart = float(np.linalg.norm(path - b.path, axis=1).max())
    differs = [f"the root is up to {apart:.2g} m elsewhere"] * (apart > limit("near"))
    if abs(a.duration - b.duration) > 0.5 / min(a.rate, b.rate) + 0.01 * a.duration:
        differs.append(f"it takes {b.duration:.3g} s instead of {a.duration:.3g} s: one frame rate is wrong")
    what = f"it has the {word}poses of {name_of(i)} within {1e3 * distance:.2g} mm" + "".join(f"; {x}" for x in differs)
    return Finding(
        "error" if same and differs else "warning", "duplicate" if same else "near duplicate", j, (0, b.n_frames), (),
        distance, "m", what, "keep one of them, or both in one part of a split",
    )  # fmt: skip
