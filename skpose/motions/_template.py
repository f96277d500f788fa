"""The search for the segment of a motion that its repetitions resemble most, from the distances between its frames."""

from functools import partial
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from skpose._compiled.path.family import comes_back, first_far, fitness_of, segments_of
from skpose._utils.parallel import in_threads
from skpose.metrics import Metric
from skpose.metrics._matrix import DistanceMatrix
from skpose.skeleton import Skeleton

FAST, FAR = 0.95, 0.95  # quantiles of speeds, and of distances between frames, that count as large
NEAR = 0.25  # quantile of distances that counts as small
TRAVEL = 0.3  # speed is measured over enough frames for fast ones to travel this share of a far distance
STILL = 0.2  # speed below which a frame is still, relative to a fast one
# Tuned on 64 joined recordings of two people of HDM05; 56 are right, and 55 to 58 with other values.
# Relative to the median distance between moving frames:
ZERO = 0.9  # distance at which similarity is zero
EXTENT = 0.9  # least distance between two frames of a template: a lasting pose is not a movement
# Relative to the largest distance from the template's first frame:
BACK = 0.7  # largest distance of the last frame, or the next, from the first one
PART = 0.85  # the same for other segments, which may be cut a little worse
# Candidates for templates have lengths in a geometric series and start a part of their length apart.
LEAST_LENGTH, GROWTH, STARTS_PER_LENGTH = 5, 1.15, 4
REFINED = 3  # best candidates whose start and length are refined, in steps from an eighth of the length to 1
# A template is the movement several times if another explains nearly as much that is shorter and more frequent:
MULTIPLE, SHORTER = 0.9, 0.6  # times as much, and times as long
SLIVER = 0.25  # largest share of a segment that is cut off at a pause
LONGEST_PAUSE = 0.5  # within a repetition, in moving frames of the template,
HELD = 1.25  # unless longer ones make the fitness this many times as large


class Frames:
    """The frames of a motion, and how similar those are that move.

    Attributes
    ----------
    moving : ndarray of shape (n,)
        The frames that move.
    distances : ndarray of shape (n, n)
        Distances between them.
    near : float
        A small distance above zero.
    similarities : ndarray of shape (n, n)
        1 for equal frames, 0 at 0.9 times the median distance, zeros included.
    reach : ndarray of shape (n,)
        For each frame, the last one that a segment needs to be more than a lasting pose.
    pauses : ndarray of shape (n,)
        The number of still frames before each.
    """

    def __init__(self, poses: np.ndarray, metric: Metric, skeleton: Skeleton | None, n_jobs: int | None):
        distances, self.unconverged = DistanceMatrix(poses, None, metric, skeleton).write(None, n_jobs)
        self.n_pairs = distances.size
        self.moving = _find_moving(distances)
        self.distances = distances[np.ix_(self.moving, self.moving)].astype(np.float64)
        positive = self.distances[self.distances > 0.0]
        self.near = float(np.quantile(positive, NEAR)) if len(positive) else 0.0
        median = float(np.median(self.distances)) if len(self.moving) else 0.0
        self.zero = ZERO * median
        self.similarities = 1.0 - self.distances / self.zero if median > 0.0 else np.ones(self.distances.shape)
        self.reach = first_far((self.distances >= EXTENT * median) & (self.distances > 0.0))
        self.pauses = np.diff(self.moving, prepend=self.moving[:1] - 1) - 1


class Template(NamedTuple):
    """A segment of the moving frames, and how well its repetitions explain the motion."""

    fitness: float
    start: int
    length: int
    longest_pause: float  # within a repetition; infinite for movements that are held
    n_frames: int = 0  # still frames included
    n_repetitions: int = 0

    @property
    def relative_fitness(self) -> float:
        """The fitness relative to a motion of as many equal repetitions and nothing else."""
        return self.fitness / (1 - 1 / max(self.n_repetitions, 2))

    def is_part_of(self, other: "Template") -> bool:
        """Whether the other template is this one several times: this one is shorter and repeats more often."""
        return self.n_frames <= SHORTER * other.n_frames and self.n_repetitions * SHORTER >= other.n_repetitions


class Found(NamedTuple):
    """The repetitions of a template in frames of the whole motion."""

    segments: np.ndarray  # (n_repetitions, 2) start and stop
    distances: np.ndarray  # (n_repetitions,) mean distance from the template
    template: int | None


NOTHING = Found(np.zeros((0, 2), dtype=np.int64), np.zeros(0), None)


class Templates:
    """All segments of the moving frames as templates; held ones may contain pauses up to the longest one next to them.

    Their least and largest numbers of frames include still frames.
    """

    def __init__(self, frames: Frames, least: int, most: int, is_held: bool):
        self.frames, self.least, self.most, self.is_held = frames, least, most, is_held
        self.n = len(frames.moving)

    def best(self, n_jobs: int) -> Template | None:
        """The fittest template that is not the movement several times; None if nothing repeats."""
        rated = in_threads((partial(self._fittest, length) for length in self._lengths()), n_jobs)
        found = [one for one in sorted(rated, reverse=True) if one.fitness > 0.0]
        if not found:
            return None
        shorter = [one for one in found if one.length <= SHORTER * found[0].length]
        candidates = [self._count(self._refine(one)) for one in {*found[:REFINED], *shorter[:REFINED]}]
        best = max(candidates)
        least = MULTIPLE * best.relative_fitness
        while parts := [one for one in candidates if one.is_part_of(best) and one.relative_fitness >= least]:
            best = max(parts)
        return best

    def _lengths(self) -> list[int]:
        longest = self.n // 2
        lengths, length = {n for n in (self.least, self.most) if LEAST_LENGTH <= n <= longest}, LEAST_LENGTH
        while length <= longest:
            lengths.add(length)
            length = max(length + 1, int(GROWTH * length))
        return sorted(lengths)

    def _fittest(self, length: int) -> Template:
        """The fittest template of a length: they start next to pauses, and, if not held, evenly spread."""
        behind = np.flatnonzero(self.frames.pauses > LONGEST_PAUSE * length)
        steps = range(0, 0 if self.is_held else self.n - length + 1, max(1, length // STARTS_PER_LENGTH))
        starts = np.unique([*behind, *(behind - length), *steps]).astype(int).tolist()
        return max((self._rate(start, length) for start in starts), default=self._rate(-1, length))

    def _rate(self, start: int, length: int) -> Template:
        """A template with its fitness, zero if it is not allowed."""
        fitness, longest = 0.0, np.inf if self.is_held else LONGEST_PAUSE * length
        if self._is_allowed(start, length):
            frames = self.frames
            fitness = fitness_of(frames.similarities, frames.pauses, longest, start, start + length, start)
        return Template(fitness, start, length, longest)

    def _is_allowed(self, start: int, length: int) -> bool:
        stop, frames = start + length, self.frames
        if not (0 <= start <= self.n - length and LEAST_LENGTH <= length <= self.n // 2):
            return False
        if frames.reach[start] >= stop or not comes_back(frames.similarities, start, stop, BACK):
            return False
        outside = frames.pauses[start : stop + 1 : length].max()
        if frames.pauses[start + 1 : stop].max() > (outside if self.is_held else LONGEST_PAUSE * length):
            return False
        first, last = _trim_slivers(frames.moving[start:stop])
        return self.least <= last - first <= self.most

    def _refine(self, template: Template) -> Template:
        """The best template near one."""
        step = max(1, template.length // 8)
        while step:
            near = [
                self._rate(template.start + shift, template.length + growth)
                for shift in (-step, 0, step)
                for growth in (-step, 0, step)
            ]
            better = max(near)
            if better.fitness > template.fitness:
                template = better
            else:
                step //= 2
        return template

    def _count(self, template: Template) -> Template:
        first, last = self.frames.moving[[template.start, template.start + template.length - 1]].tolist()
        n_repetitions = len(_path_family(self.frames, template)[0])
        return template._replace(n_frames=last - first + 1, n_repetitions=n_repetitions)


def explain(frames: Frames, least: int, most: int, n_jobs: int) -> Template | None:
    """The template that explains most of a motion; None if nothing repeats."""
    best, held = (Templates(frames, least, most, is_held).best(n_jobs) for is_held in (False, True))
    return held if held is not None and (best is None or held.fitness > HELD * best.fitness) else best


def repetitions(frames: Frames, template: Template) -> Found:
    """The template and the segments of its path families that come back, in order."""
    rows, similarities = _path_family(frames, template)
    is_template = rows[:, 0] == template.start
    whole = is_template | [_comes_back(frames.distances[first, first : stop + 1], stop - first) for first, stop in rows]
    if whole.sum() < 2:
        return NOTHING
    segments = np.array([_trim_slivers(frames.moving[first:stop]) for first, stop in rows[whole]])
    distances = frames.zero * np.maximum(0.0, 1.0 - similarities[whole])
    return Found(segments, distances, int(is_template[whole].argmax()))


def _comes_back(distances: np.ndarray, length: int) -> bool:
    """Whether a segment comes back, as a template must: a path may go through a part of it twice as fast."""
    return bool(distances[length - 1 :].min() <= PART * distances[:length].max())


def _path_family(frames: Frames, template: Template) -> tuple[np.ndarray, np.ndarray]:
    """The segments (n, 2) of a template's repetitions, itself included, and their mean similarities."""
    start, stop = template.start, template.start + template.length
    columns = np.ascontiguousarray(frames.similarities[:, start:stop])
    found = [(np.array([(start, stop)]), np.ones(1))]
    for first, last in ((0, start), (stop, len(frames.moving))):
        cuts = first + np.flatnonzero(frames.pauses[first:last] > template.longest_pause)
        edges = [first, *cuts[cuts > first], last]
        found += [segments_of(columns, i, j, 0, template.length) for i, j in pairwise(edges)]
    segments, similarities = (np.concatenate(parts) for parts in zip(*found, strict=True))
    order = segments[:, 0].argsort()
    return segments[order], similarities[order]


def _trim_slivers(frames: np.ndarray) -> tuple[int, int]:
    """Start and stop of a segment, given its moving frames.

    A few frames at an edge, separated from the rest by a pause longer than themselves, belong to another repetition.
    """
    most = int(SLIVER * len(frames))
    before, behind = np.arange(1, most + 1), np.arange(len(frames) - most, len(frames))
    pauses = np.diff(frames)  # frames from one that moves to the next
    starts = before[pauses[before - 1] > frames[before - 1] - frames[0] + 1]
    stops = behind[pauses[behind - 1] > frames[-1] - frames[behind] + 1]
    first, last = max(starts, default=0), min(stops, default=len(frames))
    return int(frames[first]), int(frames[last - 1]) + 1


def _find_moving(distances: np.ndarray) -> np.ndarray:
    """The frames that move, by their speeds: the distances between the frames `reach` before and after each."""
    n, far, reach = len(distances), np.quantile(distances, FAR), 1
    frames = np.arange(n)
    while True:
        before, after = np.maximum(frames - reach, 0), np.minimum(frames + reach, n - 1)
        speeds = distances[before, after] * (2 * reach / np.maximum(after - before, 1))
        fast = np.quantile(speeds, FAST)
        if fast >= TRAVEL * far or reach > n // 8:
            return np.flatnonzero(speeds > STILL * fast)
        reach += 1 + reach // 4
