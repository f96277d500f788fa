"""`skpose find`: the places in some files where a motion, or a single pose, is found."""

import sys
from pathlib import Path
from typing import NamedTuple

import numpy as np
from scipy.ndimage import minimum_filter1d

from skpose._cli.inputs import files_in_messages
from skpose._cli.stages import steps
from skpose.datasets import MotionDataset
from skpose.metrics import pose_distances
from skpose.metrics._shared import resolve
from skpose.motions import find_motion
from skpose.skeleton import Motion

APART = 0.5  # s, between two places of a pose


class Query(NamedTuple):
    """The part of its file that is to be found, by times in s; None is not chosen."""

    begins: float | None
    ends: float | None
    pose: float | None


class Place(NamedTuple):
    """A place where something was found: the number of the file, the first row and the one behind the last."""

    file: int
    start: int
    stop: int
    distance: float


def find(
    dataset: MotionDataset,
    part: Query,
    *,
    k: int,
    metric: str,
    n_jobs: int,
    exclude_query: bool = False,
    one_per_file: bool = False,
) -> None:
    """Print where a part of the first motion of a dataset is found in the others, which have the names of their files.

    Of the file that the first motion is of, `exclude_query` leaves out the places that have frames of the query.
    """
    whole, *recordings = dataset.motions
    name, *names = dataset.subjects
    here = _rows(whole, part, name)
    left_out = {i for i, other in enumerate(names) if exclude_query and _is_same(name, other)}
    with files_in_messages(names):
        if part.pose is None:
            places = _find_motion(whole[here], recordings, left_out, here, (k, one_per_file), metric, n_jobs)
        else:
            places = _find_pose(whole, recordings, left_out, here.start, one_per_file, metric, n_jobs)[:k]
    if not places:
        raise ValueError(f"no place is left without --exclude-query: all frames of the files are those of {name}")
    width = max(len(name) for name in ("file", *names))
    distance = f"distance, {resolve(metric, whole.skeleton).unit}"
    times = f"{'time, s':>10}" if part.pose is not None else f"{'start, s':>10}  {'end, s':>10}"
    print(f"{'rank':>6}  {'file':<{width}}  {times}  {distance:>14}")
    for rank, (i, start, stop, far) in enumerate(places, start=1):
        times = f"{recordings[i].times[start]:>10.2f}"
        if part.pose is None:
            times += f"  {_end(recordings[i], stop - 1):>10.2f}"
        print(f"{rank:>6}  {names[i]:<{width}}  {times}  {far:>14.4f}")
    short = sum(2 * (place.stop - place.start) < here.stop - here.start for place in places)
    if short:  # time warps freely, and where nothing is like the query a single frame may stand for most of it
        seconds = (here.stop - here.start) / whole.frame_rate
        print(
            f"skpose: {short} of {len(places)} places last less than half as long as the motion to find, "
            f"{seconds:.2f} s, and have little of it",
            file=sys.stderr,
        )


def _find_motion(
    query: Motion,
    recordings: list[Motion],
    left_out: set[int],
    here: slice,
    most: tuple[int, bool],
    metric: str,
    n_jobs: int,
) -> list[Place]:
    """Return the best places of a motion: so many, or the best one of each recording."""
    k, one_per_file = most
    parts: list[tuple[int, int, Motion]] = []  # the number of the file, the first row, and the frames
    for i, recording in enumerate(recordings):
        rows = [slice(0, here.start), slice(here.stop, len(recording))] if i in left_out else [slice(0, len(recording))]
        parts += [(i, part.start, recording[part]) for part in rows if part.start < part.stop]
    groups = [[part for part in parts if part[0] == i] for i in range(len(recordings))] if one_per_file else [parts]
    places = []
    for group in steps(f"searching {len(groups)} files", [*filter(None, groups)]):
        found = find_motion(
            query,
            [motion for *_, motion in group],
            k=1 if one_per_file else k,
            skeleton=query.skeleton,
            metric=metric,
            n_jobs=n_jobs,
        )
        for match in found:
            i, first, _ = group[match.motion]
            places.append(Place(i, first + match.start, first + match.stop, match.distance))
    return sorted(places, key=lambda place: place.distance)[:k]


def _find_pose(
    whole: Motion,
    recordings: list[Motion],
    left_out: set[int],
    row: int,
    one_per_file: bool,
    metric: str,
    n_jobs: int,
) -> list[Place]:
    """Return all places of a pose, or the best one of each recording, the best first."""
    poses = np.concatenate([recording.angles for recording in recordings])
    (far,) = pose_distances(whole.angles[row : row + 1], poses, skeleton=whole.skeleton, metric=metric, n_jobs=n_jobs)
    places, starts = [], np.cumsum([0, *map(len, recordings)])
    for i, recording in enumerate(recordings):
        distances = far[starts[i] : starts[i + 1]]
        rows = find_minima(distances, recording.frame_numbers, recording.frame_rate)
        if i in left_out:
            rows = rows[np.abs(recording.times[rows] - whole.times[row]) > APART]
        if one_per_file:
            rows = rows[np.argsort(distances[rows], kind="stable")[:1]]
        places += [Place(i, r, r + 1, float(distances[r])) for r in rows.tolist()]
    return sorted(places, key=lambda place: place.distance)


def find_minima(distances: np.ndarray, numbers: np.ndarray, frame_rate: float) -> np.ndarray:
    """Return the rows of the frames to which no other within half a second is nearer; of equal ones the first."""
    reach = int(APART * frame_rate)
    at = np.full(numbers[-1] - numbers[0] + 1, np.inf)
    at[numbers - numbers[0]] = distances
    lowest = minimum_filter1d(at, 2 * reach + 1, mode="constant", cval=np.inf)
    rows: list[int] = []
    for row in np.flatnonzero(lowest[numbers - numbers[0]] == distances).tolist():
        if not rows or numbers[row] - numbers[rows[-1]] > reach:
            rows.append(row)
    return np.array(rows, dtype=np.intp)


def _is_same(name: str, other: str) -> bool:
    """Return whether two names are of one file."""
    one, two = Path(name), Path(other)
    return one.exists() and two.exists() and one.samefile(two)


def _rows(motion: Motion, part: Query, name: str) -> slice:
    """Return the rows of the frames between two times, or of the one nearest to a time, s."""
    if part.pose is not None:
        if part.pose > _end(motion, -1):
            raise ValueError(f"{name} lasts {_end(motion, -1):.2f} s: choose another time than --pose {part.pose:g}")
        row = int(np.abs(motion.times - part.pose).argmin())
        return slice(row, row + 1)
    begins, ends = part.begins or 0.0, part.ends
    first, last = np.searchsorted(motion.times, [begins, np.inf if ends is None else ends])
    if first == last:
        until = "" if ends is None else f" and before {ends:g} s"
        raise ValueError(
            f"{name} has no frame from {begins:g} s on{until}, as it lasts {_end(motion, -1):.2f} s: choose other "
            "times for --from and --to"
        )
    return slice(int(first), int(last))


def _end(motion: Motion, row: int) -> float:
    """Return the time at which a frame ends, s."""
    return motion.times[row] + 1.0 / motion.frame_rate
