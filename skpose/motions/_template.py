"""The search for the segment of a motion that its repetitions resemble most, from the distances between its frames.

Up to 2,000 frames all distances are computed once. For longer motions they are computed on demand, which bounds memory,
and every k-th frame gives the typical distance.
"""

from collections.abc import Iterable
from functools import partial
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from joblib import effective_n_jobs

from skpose._compiled.path.family import comes_back, first_far, fitness_of, segments_of
from skpose._utils.parallel import in_threads
from skpose.metrics import Metric
from skpose.metrics._matrix import DistanceMatrix, Unconverged, paired_distances
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
# Of long motions every frame, every second, every fourth is searched, section by section:
LONGEST = 256  # template in a section
SHORTEST = 16  # template if frames are left out: start and stop are exact to a sixteenth
RATED = 10  # templates of each section, and of each size, that are rated on the whole motion,
COARSELY = 4  # in this many times as large steps as memory would allow
# A template is the movement several times if another explains nearly as much that is shorter and more frequent:
MULTIPLE, SHORTER = 0.9, 0.6  # times as much, and times as long
SLIVER = 0.25  # largest share of a segment that is cut off at a pause
LONGEST_PAUSE = 0.5  # within a repetition, in moving frames of the template,
HELD = 1.25  # unless longer ones make the fitness this many times as large


class Frames:
    """The frames of a motion.

    Attributes
    ----------
    is_moving : ndarray of shape (n,) of bool
        Whether each frame moves.
    median, near : float
        Median distance between moving frames, zeros included, and a small distance above zero.
    unconverged : list of Unconverged, n_pairs : int
        Distances that did not converge, and the number of all.
    """

    most = 2000  # frames with all distances in memory

    def __init__(self, poses: np.ndarray, metric: Metric, skeleton: Skeleton | None, n_jobs: int | None):
        self.n = len(poses)
        self.unconverged: list[Unconverged] = []
        self.n_pairs = 0
        self._given = poses, metric, skeleton, n_jobs
        self._all: np.ndarray | None = None
        some = np.arange(0, self.n, -(-self.n // self.most))
        distances = self._measure(some, None)
        if len(some) == self.n:
            self._all = distances
        self.is_moving = self._find_moving(some, np.quantile(distances, FAR))
        moving = self.is_moving[some]
        distances = distances[np.ix_(moving, moving)].astype(np.float64)
        positive = distances[distances > 0.0]
        self.median = float(np.median(distances)) if len(distances) else 0.0
        self.near = float(np.quantile(positive, NEAR)) if len(positive) else 0.0

    def moving(self, every: int) -> np.ndarray:
        """The moving ones of every k-th frame."""
        return np.flatnonzero(self.is_moving[::every]) * every

    def sections(self, every: int, n: int | None = None) -> list[np.ndarray]:
        """These in sections with distances that fit into memory, or n of the sections, spread evenly."""
        moving = self.moving(every)
        sections = np.array_split(moving, max(1, -(-len(moving) // self.most)))
        chosen = np.linspace(0, len(sections) - 1, min(len(sections), n or len(sections)))
        return [sections[i] for i in chosen.astype(int)]

    def distances(self, rows: np.ndarray, columns: np.ndarray | None = None) -> np.ndarray:
        """Distances of some frames from others, or from each other."""
        if self._all is not None:
            return self._all[np.ix_(rows, rows if columns is None else columns)].astype(np.float64)
        return self._measure(rows, columns).astype(np.float64, copy=False)

    def _measure(self, rows: np.ndarray, columns: np.ndarray | None) -> np.ndarray:
        poses, metric, skeleton, n_jobs = self._given
        others = None if columns is None else poses[columns]
        distances, unconverged = DistanceMatrix(poses[rows], others, metric, skeleton).write(None, n_jobs)
        self.unconverged += unconverged
        self.n_pairs += distances.size
        return distances

    def _find_moving(self, some: np.ndarray, far: float) -> np.ndarray:
        """Find the moving frames by their speeds, the distances between the frames `reach` before and after each."""
        reach = 1
        while True:
            speeds = self._speeds(some, reach)
            fast = np.quantile(speeds, FAST)
            if fast >= TRAVEL * far or reach > self.n // 8:
                break
            reach += 1 + reach // 4
        if len(some) < self.n:
            speeds = self._speeds(np.arange(self.n), reach)
        return speeds > STILL * fast

    def _speeds(self, frames: np.ndarray, reach: int) -> np.ndarray:
        """Distances over twice `reach` frames, fewer at both ends."""
        before, after = np.maximum(frames - reach, 0), np.minimum(frames + reach, self.n - 1)
        return self._apart(before, after) * (2 * reach / np.maximum(after - before, 1))

    def _apart(self, some: np.ndarray, others: np.ndarray) -> np.ndarray:
        """Distances between paired frames."""
        if self._all is not None:
            return self._all[some, others]
        poses, metric, skeleton, n_jobs = self._given
        return paired_distances(poses[some], poses[others], skeleton, metric, effective_n_jobs(n_jobs))


class Template(NamedTuple):
    """A segment of some moving frames, and its fitness."""

    fitness: float
    start: int
    length: int


class Segment(NamedTuple):
    """A template by its first and last frame in the motion, and its fitness among the frames around it."""

    fitness: float
    first: int
    last: int
    is_held: bool  # whether its repetitions may contain pauses of any length
    n_repetitions: int = 0

    @property
    def length(self) -> int:
        return self.last - self.first + 1

    @property
    def relative_fitness(self) -> float:
        """The fitness relative to a motion of as many equal repetitions and nothing else."""
        return self.fitness / (1 - 1 / max(self.n_repetitions, 2))

    def is_part_of(self, other: "Segment") -> bool:
        """Whether the other template is this one several times: this one is shorter and repeats more often."""
        return self.length <= SHORTER * other.length and self.n_repetitions * SHORTER >= other.n_repetitions


class Found(NamedTuple):
    """The repetitions of a template in frames of the whole motion."""

    segments: np.ndarray  # (n_repetitions, 2) start and stop
    distances: np.ndarray  # (n_repetitions,) mean distance from the template
    template: int | None


NOTHING = Found(np.zeros((0, 2), dtype=np.int64), np.zeros(0), None)


class Templates:
    """All segments of a section as templates; a section has every k-th frame of a motion that moves.

    Held ones may contain pauses up to the longest one next to them.
    """

    def __init__(
        self,
        frames: Frames,
        section: np.ndarray,
        distances: np.ndarray,
        every: int,
        limits: tuple[float, float],
        is_held: bool,
    ):
        self.frames, self.every, self.limits, self.is_held = section, every, limits, is_held
        self.n = len(section)
        self.similarities = _similarities(frames, distances)
        self.reach = first_far((distances >= EXTENT * frames.median) & (distances > 0.0))
        self.pauses = _still_before(section, every)

    def best(self, lengths: Iterable[int], n_refined: int, n_jobs: int) -> list[Segment]:
        """The fittest templates of different lengths, refined."""

        def rate(length: int) -> Template:
            return max((self._rate(start, length) for start in self._starts(length)), default=Template(0.0, 0, length))

        found = in_threads((partial(rate, length) for length in lengths if length <= self.n // 2), n_jobs)
        found = [one for one in sorted(found, reverse=True) if one.fitness > 0.0]
        most = SHORTER * found[0].length if found else 0
        chosen = {*found[:n_refined], *[one for one in found if one.length <= most][:n_refined]}
        refined = {self._refine(one) for one in chosen}
        ends = [(one, self.frames[[one.start, one.start + one.length - 1]].tolist()) for one in refined]
        return [Segment(one.fitness, first, last, self.is_held) for one, (first, last) in ends]

    def _starts(self, length: int) -> list[int]:
        """Starts of the templates of a length that are rated: next to pauses, and, if not held, evenly spread."""
        behind = np.flatnonzero(self.pauses > LONGEST_PAUSE * length)
        steps = range(0, 0 if self.is_held else self.n - length + 1, max(1, length // STARTS_PER_LENGTH))
        return np.unique([*behind, *(behind - length), *steps]).astype(int).tolist()

    def _rate(self, start: int, length: int) -> Template:
        """A template with its fitness, zero if it is not allowed."""
        fitness = 0.0
        if self._is_allowed(start, length):
            longest = np.inf if self.is_held else LONGEST_PAUSE * length
            fitness = fitness_of(self.similarities, self.pauses, longest, start, start + length, start)
        return Template(fitness, start, length)

    def _is_allowed(self, start: int, length: int) -> bool:
        stop = start + length
        if not (0 <= start <= self.n - length and LEAST_LENGTH <= length <= self.n // 2):
            return False
        if self.reach[start] >= stop or not comes_back(self.similarities, start, stop, BACK):
            return False
        outside = self.pauses[[start, stop] if stop < self.n else [start]].max()
        if self.pauses[start + 1 : stop].max() > (outside if self.is_held else LONGEST_PAUSE * length):
            return False
        first, last = _trim_slivers(self.frames[start:stop])
        return self.limits[0] <= last - first + self.every - 1 <= self.limits[1]

    def _refine(self, template: Template) -> Template:
        """The best template near one."""
        step = max(1, template.length // 8)
        while step and template.fitness > 0.0:
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


class Explanation:
    """A template and how it explains the whole motion, of long ones every k-th frame, so that memory is bounded."""

    def __init__(self, frames: Frames, segment: Segment, coarsely: float = 1.0):
        first, last = segment.first, segment.last
        n, length = frames.is_moving.sum(), frames.is_moving[first : last + 1].sum()
        fitting = int(np.ceil(coarsely * np.sqrt(n * length) / frames.most))
        self.every = max(1, min(fitting, length // SHORTEST))
        self.of, self.segment = frames, segment
        self.frames = frames.moving(self.every)
        self.n = len(self.frames)
        self.pauses = _still_before(self.frames, self.every)
        self.start, self.stop = (int(i) for i in np.searchsorted(self.frames, [first, last + 1]))
        self.length = self.stop - self.start
        self.similarities = _similarities(frames, frames.distances(self.frames, self.frames[self.start : self.stop]))
        self.longest = np.inf if segment.is_held else LONGEST_PAUSE * self.length
        self.fitness = fitness_of(self.similarities, self.pauses, self.longest, 0, self.length, self.start)

    def rate(self) -> Segment:
        """The template with its fitness in the whole motion, and its number of repetitions."""
        n = 1 + len(self._segments(0, self.start)[0]) + len(self._segments(self.stop, self.n)[0])
        return self.segment._replace(fitness=self.fitness, n_repetitions=n)

    def repetitions(self) -> Found:
        """The template and the segments of its path families, in order."""
        before, near_before = self._segments(0, self.start)
        after, near_after = self._segments(self.stop, self.n)
        rows = np.concatenate([before, [(self.start, self.stop)], after])
        similarities = np.concatenate([near_before, [1.0], near_after])
        is_template = np.arange(len(rows)) == len(before)
        whole = is_template | [self._comes_back(first, stop) for first, stop in rows]
        if whole.sum() < 2:
            return NOTHING
        segments = np.array([_trim_slivers(self.frames[first:stop]) for first, stop in rows[whole]])
        segments[:, 1] = np.minimum(segments[:, 1] + self.every - 1, self.of.n)
        distances = ZERO * self.of.median * np.maximum(0.0, 1.0 - similarities[whole])
        return Found(segments, distances, int(is_template[whole].argmax()))

    def _comes_back(self, first: int, stop: int) -> bool:
        """Whether a segment comes back, as a template must: a path may go through a part of it twice as fast."""
        distances = self.of.distances(self.frames[first : first + 1], self.frames[first : stop + 1])[0]
        length = stop - first
        return bool(distances[length - 1 :].min() <= PART * distances[:length].max())

    def _segments(self, first: int, last: int) -> tuple[np.ndarray, np.ndarray]:
        """The segments of the template in some frames, between long pauses, and their mean similarities."""
        cuts = first + np.flatnonzero(self.pauses[first:last] > self.longest)
        edges = [first, *cuts[cuts > first], last]
        found = [segments_of(self.similarities, i, j, 0, self.length) for i, j in pairwise(edges)]
        segments, similarities = zip(*found, strict=True)
        return np.concatenate(segments), np.concatenate(similarities)


def explain(frames: Frames, limits: tuple[float, float], n_jobs: int) -> Explanation | None:
    """The template that explains most of a motion; None if nothing repeats.

    The limits are the least and the largest number of its frames, still frames included.

    Templates are searched among all frames in sections, then among every second frame in half as many, and so on, until
    one section has all.
    """
    found: list[Segment] = []
    every, is_last = 1, False
    while not is_last:
        sections = frames.sections(every)
        is_last = len(sections) == 1
        shortest, longest = LEAST_LENGTH if every == 1 else SHORTEST, len(sections[0]) if is_last else LONGEST
        asked_for = [int(np.ceil(n / every)) for n in limits if shortest <= n / every <= longest]
        lengths = sorted({*_lengths(shortest, longest), *asked_for})
        for section in sections:
            distances = frames.distances(section)
            for is_held in (False, True):
                templates = Templates(frames, section, distances, every, limits, is_held)
                found += templates.best(lengths, REFINED if every == 1 and is_last else RATED, n_jobs)
        every *= 2
    best, held = (_best_of(frames, [one for one in found if one.is_held == is_held]) for is_held in (False, True))
    return held if held is not None and (best is None or held.fitness > HELD * best.fitness) else best


def _best_of(frames: Frames, segments: list[Segment]) -> Explanation | None:
    """The segment that explains most of the motion, among the fittest of each size."""
    of_size: dict[int, list[Segment]] = {}
    for one in sorted(segments, reverse=True):
        of_size.setdefault(one.length.bit_length(), []).append(one)
    rated = [Explanation(frames, one, COARSELY).rate() for similar in of_size.values() for one in similar[:RATED]]
    if not rated:
        return None
    best = max(rated)
    least = MULTIPLE * best.relative_fitness
    while shorter := [one for one in rated if one.is_part_of(best) and one.relative_fitness >= least]:
        best = max(shorter)
    return Explanation(frames, best)


def _similarities(frames: Frames, distances: np.ndarray) -> np.ndarray:
    return 1.0 - distances / (ZERO * frames.median) if frames.median > 0.0 else np.ones(distances.shape)


def _still_before(frames: np.ndarray, every: int) -> np.ndarray:
    """The number of still frames, of every k-th, before each moving one."""
    return np.diff(frames, prepend=frames[:1] - every) // every - 1


def _lengths(shortest: int, longest: int) -> list[int]:
    lengths = [shortest]
    while lengths[-1] <= longest:
        lengths.append(max(lengths[-1] + 1, int(GROWTH * lengths[-1])))
    return lengths[:-1]


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
