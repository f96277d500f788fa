"""The search for the segment of a motion that its repetitions resemble most, from the distances between its frames."""

from collections.abc import Callable, Iterator
from functools import partial
from typing import NamedTuple

import numpy as np

from skpose._compiled.path_family import family_of, segments_of
from skpose._parallel.threads import in_threads

FAST, FAR = 0.95, 0.95  # quantiles: of speeds, and of distances between frames, that stand for the largest
TRAVEL = 0.3  # speed is measured over so many frames that fast ones travel this share of a far distance
STILL = 0.2  # speed below which a frame is still, relative to a fast one
# Relative to the median distance between moving frames:
ZERO = 0.9  # distance of similarity zero
EXTENT = 1.25  # distance that a template must have between two of its frames
# Candidates for templates: lengths in a geometric series, starts a part of the length apart.
LEAST_LENGTH, GROWTH, STARTS_PER_LENGTH = 5, 1.15, 4
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
    fitness: float


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
        self.frames = moving_frames(distances)
        moving = distances[np.ix_(self.frames, self.frames)].astype(np.float64)
        self.n = len(self.frames)
        median = np.median(moving) if self.n else 0.0
        self.zero = ZERO * median
        self.least, self.most = least, most
        far = np.triu(moving >= EXTENT * median) if median > 0.0 else np.zeros(moving.shape, dtype=bool)
        nearest = np.where(far.any(axis=1), far.argmax(axis=1), self.n)
        # The first frame behind each start, up to which a template must reach to move far enough.
        self.reach = np.minimum.accumulate(nearest[::-1])[::-1]
        self.similarities = 1.0 - moving / self.zero if self.zero > 0.0 else moving

    def best(self, n_jobs: int) -> Template:
        """Return the template of the largest fitness; its fitness is zero where nothing repeats."""
        found: list[Template] = []

        def rate(length: int) -> None:
            step = max(1, length // STARTS_PER_LENGTH)
            found.extend(self._rated(start, length) for start in range(0, self.n - length + 1, step))

        tasks: Iterator[Callable[[], None]] = (partial(rate, length) for length in self._lengths())
        in_threads(tasks, n_jobs)
        found.sort(reverse=True)
        return max(map(self._refined, found[:REFINED]), default=Template(0.0, 0, 0))

    def repetitions(self, template: Template) -> Found:
        """Return the segments of the template's path family."""
        start, stop = template.start, template.start + template.length
        rows, similarities = segments_of(self.similarities, start, stop)
        segments = np.stack([self.frames[rows[:, 0]], self.frames[rows[:, 1] - 1] + 1], axis=1)
        return Found(segments, np.maximum(0.0, self.zero * (1.0 - similarities)), template.fitness)

    def _lengths(self) -> Iterator[int]:
        length = LEAST_LENGTH
        while length <= self.n // 2:
            yield length
            length = max(length + 1, int(GROWTH * length))

    def _rated(self, start: int, length: int) -> Template:
        """Return a template with its fitness, the harmonic mean of score and coverage; zero for one not allowed.

        The template's own path is left out of both.
        """
        if not self._is_allowed(start, length):
            return Template(0.0, start, length)
        score, n_cells, n_covered = family_of(self.similarities, start, start + length)
        if score <= length or n_covered <= length:
            return Template(0.0, start, length)
        mean_score, coverage = (score - length) / n_cells, (n_covered - length) / self.n
        return Template(2.0 * mean_score * coverage / (mean_score + coverage), start, length)

    def _is_allowed(self, start: int, length: int) -> bool:
        if not (0 <= start <= self.n - length and LEAST_LENGTH <= length <= self.n // 2):
            return False
        last = start + length - 1
        return self.reach[start] <= last and self.least <= self.frames[last] - self.frames[start] + 1 <= self.most

    def _refined(self, template: Template) -> Template:
        """Return the best template near one."""
        step = max(1, template.length // 8)
        while step and template.fitness > 0.0:
            near = [
                self._rated(template.start + shift, template.length + growth)
                for shift in (-step, 0, step)
                for growth in (-step, 0, step)
            ]
            better = max(near)
            if better.fitness > template.fitness:
                template = better
            else:
                step //= 2
        return template
