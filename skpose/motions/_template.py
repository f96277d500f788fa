"""The search for the segment of a motion that its repetitions resemble most, from the distances between its frames."""

from collections.abc import Callable, Iterator
from functools import partial
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from skpose._compiled.path.family import first_far, fitness_of, segments_of
from skpose._parallel.threads import in_threads

FAST, FAR = 0.95, 0.95  # quantiles: of speeds, and of distances between frames, that stand for the largest
TRAVEL = 0.3  # speed is measured over so many frames that fast ones travel this share of a far distance
STILL = 0.2  # speed below which a frame is still, relative to a fast one
# Relative to the median distance between moving frames:
ZERO = 0.9  # distance of similarity zero
EXTENT = 1.25  # distance that a template must have between two of its frames
# Candidates for templates: lengths in a geometric series, starts a part of the length apart.
LEAST_LENGTH, GROWTH, STARTS_PER_LENGTH = 5, 1.15, 4
SLIVER = 0.25  # of a segment: the most that is cut off behind a pause
# Relative to the frames of the template that move:
LONGEST_PAUSE = 0.5  # within a repetition
SHORTEST_PAUSE = 0.25  # between repetitions: what is shorter is a turn, not a pause
REFINED = 3  # the best of them, whose start and length are then varied in steps from an eighth of the length to 1


class Template(NamedTuple):
    """A segment of the frames that move, and how well it explains them."""

    fitness: float
    start: int
    length: int


class Found(NamedTuple):
    """The repetitions of a template, in frames of the whole motion."""

    segments: np.ndarray  # (n_repetitions, 2) first frame, and the one behind the last
    distances: np.ndarray  # (n_repetitions,) mean distance from the template
    template: int | None
    pauses: np.ndarray  # (n_pauses, 2) first still frame, and the one behind the last


def moving_frames(distances: np.ndarray) -> np.ndarray:
    """Return the frames that move, given the distances between all frames of a motion.

    The speed of a frame is the distance between the frames `reach` before and after it; noise counts little where
    `reach` is long enough.
    """
    n, frames = len(distances), np.arange(len(distances))
    far, reach = np.quantile(distances, FAR), 1
    while True:
        before, after = np.maximum(frames - reach, 0), np.minimum(frames + reach, n - 1)
        speeds = distances[before, after] * (2 * reach / np.maximum(after - before, 1))
        fast = np.quantile(speeds, FAST)
        if fast >= TRAVEL * far or reach > n // 8:
            break
        reach += 1 + reach // 4
    return np.flatnonzero(speeds > STILL * fast)


class Templates:
    """All segments of a motion as templates, with the distances between its frames.

    `least` and `most` are the numbers of frames that a template may have, those that are still among them.
    """

    def __init__(self, distances: np.ndarray, least: float, most: float):
        self.n_frames = len(distances)
        self.frames = moving_frames(distances)
        self.distances = moving = distances[np.ix_(self.frames, self.frames)].astype(np.float64)
        self.n = len(self.frames)
        median = np.median(moving) if self.n else 0.0
        self.zero = ZERO * median
        self.least, self.most = least, most
        self.similarities = 1.0 - moving / self.zero if median > 0.0 else np.ones(moving.shape)
        self.reach = first_far((moving >= EXTENT * median) & (moving > 0.0))
        self.pauses = np.diff(self.frames, prepend=self.frames[:1]) - 1  # still frames before each one that moves

    def best(self, n_jobs: int) -> Template:
        """Return the template of the largest fitness; its fitness is zero where nothing repeats."""
        found: list[Template] = []

        def rate(length: int) -> None:
            step = max(1, length // STARTS_PER_LENGTH)
            found.extend(self._rate(start, length) for start in range(0, self.n - length + 1, step))

        tasks: Iterator[Callable[[], None]] = (partial(rate, length) for length in self._lengths())
        in_threads(tasks, n_jobs)
        found.sort(reverse=True)
        return max(map(self._refine, found[:REFINED]), default=Template(0.0, 0, 0))

    def repetitions(self, template: Template) -> Found:
        """Return the template and the segments of its path families, in their order."""
        start, stop = template.start, template.start + template.length
        before, near_before = self._segments(0, start, template)
        after, near_after = self._segments(stop, self.n, template)
        rows = np.concatenate([before, [(start, stop)], after])
        segments = np.array([_trim_slivers(self.frames[first:last]) for first, last in rows])
        if np.ptp(segments[len(before)]) < self.least:
            segments[len(before)] = self.frames[start], self.frames[stop - 1] + 1  # the template is long enough whole
        similarities = np.concatenate([near_before, [1.0], near_after])
        distances = self.zero * np.maximum(0.0, 1.0 - similarities)
        pauses = self._pauses(segments, max(1.0, SHORTEST_PAUSE * template.length))
        return Found(segments, distances, len(before), pauses)

    def nothing(self) -> Found:
        """Return no repetition, and all pauses."""
        none = np.zeros((0, 2), dtype=np.int64)
        return Found(none, np.zeros(0), None, self._pauses(none, LEAST_LENGTH))

    def _segments(self, first: int, last: int, template: Template) -> tuple[np.ndarray, np.ndarray]:
        """Return the segments of a template in some frames, and their mean similarities: between long pauses each."""
        start, stop = template.start, template.start + template.length
        cuts = first + np.flatnonzero(self.pauses[first:last] > LONGEST_PAUSE * template.length)
        edges = [first, *cuts[cuts > first], last]
        found = [segments_of(self.similarities, i, j, start, stop) for i, j in pairwise(edges)]
        segments, similarities = zip(*found, strict=True)
        return np.concatenate(segments), np.concatenate(similarities)

    def _pauses(self, segments: np.ndarray, least: float) -> np.ndarray:
        """Return the runs of still frames outside of the segments that have at least so many frames."""
        is_still = np.ones(self.n_frames, dtype=bool)
        is_still[self.frames] = False
        for first, last in segments:
            is_still[first:last] = False
        edges = np.flatnonzero(np.diff(is_still, prepend=False, append=False)).reshape(-1, 2)
        return edges[np.ptp(edges, axis=1) >= least]

    def _lengths(self) -> Iterator[int]:
        length = LEAST_LENGTH
        while length <= self.n // 2:
            yield length
            length = max(length + 1, int(GROWTH * length))

    def _rate(self, start: int, length: int) -> Template:
        """Return a template with its fitness, zero for one that is not allowed."""
        if not self._is_allowed(start, length):
            return Template(0.0, start, length)
        longest = LONGEST_PAUSE * length
        return Template(fitness_of(self.similarities, self.pauses, longest, start, start + length), start, length)

    def _is_allowed(self, start: int, length: int) -> bool:
        if not (0 <= start <= self.n - length and LEAST_LENGTH <= length <= self.n // 2):
            return False
        last = start + length - 1
        if self.pauses[start + 1 : last + 1].max() > LONGEST_PAUSE * length:
            return False
        return self.reach[start] <= last and self.least <= self.frames[last] - self.frames[start] + 1 <= self.most

    def _refine(self, template: Template) -> Template:
        """Return the best template near one."""
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


def _trim_slivers(frames: np.ndarray) -> tuple[int, int]:
    """Return the first frame of a segment, given those of it that move, and the one behind its last.

    What lies at an edge, apart from the rest by a pause that is longer than itself, belongs to the repetition before or
    behind: a template explains no less with a few frames of it.
    """
    most = int(SLIVER * len(frames))
    before, behind = np.arange(1, most + 1), np.arange(len(frames) - most, len(frames))
    pauses = np.diff(frames)  # frames from one that moves to the next
    starts = before[pauses[before - 1] > frames[before - 1] - frames[0] + 1]
    stops = behind[pauses[behind - 1] > frames[-1] - frames[behind] + 1]
    first, last = max(starts, default=0), min(stops, default=len(frames))
    return int(frames[first]), int(frames[last - 1]) + 1
