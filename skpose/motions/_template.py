"""The search for the segment of a motion that its repetitions resemble most, from the distances between its frames."""

from collections.abc import Iterable
from functools import partial
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from skpose._compiled.path.family import comes_back, first_far, fitness_of, segments_of
from skpose._parallel.threads import in_threads
from skpose.motions._frames import Frames

# Chosen on two people of HDM05 (`benchmarks/repetitions.py`): of 64 joined recordings 56 are right. With BACK of 0.5 to
# 0.9, PART of 0.75 or none, EXTENT of 0.7 to 1.1, MULTIPLE from 0.8, SHORTER of 0.5 to 0.7, LONGEST_PAUSE of 0.35 to
# 0.75, HELD from 1.1, and REFINED of 1 to 10, one by one, it is 55 to 57; with ZERO of 0.7 it is 42, with 1.1 it is 58,
# for which the controls, of motions that do not repeat, have not been measured. Circles whose period is no whole number
# of frames need MULTIPLE of 0.9 or less, and SHORTER of 0.6 or more.
# Relative to the median distance between moving frames:
ZERO = 0.9  # distance of similarity zero
EXTENT = 0.9  # distance that a template must have between two of its frames: a pose that lasts is no movement
# Relative to the distance of the template's first frame from the one that is farthest from it:
BACK = 0.7  # distance of the first frame from the last, or from the one behind it: a half of a movement has 1
PART = 0.85  # likewise of a segment of its family, which may be cut a little worse: with more it is a part
# Candidates for templates: lengths in a geometric series, and those that are asked for, starts a part of the length
# apart, and behind and ahead of pauses.
LEAST_LENGTH, GROWTH, STARTS_PER_LENGTH = 5, 1.15, 4
REFINED = 3  # the best of them, whose start and length are then varied in steps from an eighth of the length to 1
# Long motions, of which every frame, every second, every fourth is looked at, section by section:
LONGEST = 256  # template in a section: with eight of them, it has enough to choose from
SHORTEST = 16  # template, where frames are left out, in frames that are not: start and stop are exact to a sixteenth
RATED = 10  # templates of each section, and of each size of all sections, which are compared with the whole motion,
COARSELY = 4  # in so many times as large steps as memory would allow: this only ranks them
# A template is the movement several times if one explains nearly as much that is shorter and more frequent:
MULTIPLE, SHORTER = 0.9, 0.6  # times as much, and times as long: half as long, and a little for rounding
SLIVER = 0.25  # of a segment: the most that is cut off behind a pause
# Relative to the frames of the template that move:
LONGEST_PAUSE = 0.5  # within a repetition, unless the fitness with longer ones is so many times as large:
HELD = 1.25
SHORTEST_PAUSE = 0.25  # between repetitions: what is shorter is a turn, not a pause


class Limits(NamedTuple):
    """The numbers of frames that a template may have, those that are still among them."""

    least: float
    most: float


class Template(NamedTuple):
    """A segment of some frames that move, and how well it explains them."""

    fitness: float
    start: int
    length: int


class Segment(NamedTuple):
    """A template in frames of the motion, its first and its last, and how well it explains the frames around it."""

    fitness: float
    first: int
    last: int
    is_held: bool  # whether its repetitions may have pauses of any length, and it one that is shorter than one outside
    n_repetitions: int = 0

    @property
    def length(self) -> int:
        return self.last - self.first + 1

    @property
    def relative_fitness(self) -> float:
        """The fitness relative to that of as many equal repetitions which are all there is."""
        return self.fitness / (1 - 1 / max(self.n_repetitions, 2))

    def is_part_of(self, other: "Segment") -> bool:
        """Return whether another one is this one several times: it is shorter, and repeats more often."""
        return self.length <= SHORTER * other.length and self.n_repetitions * SHORTER >= other.n_repetitions


class Found(NamedTuple):
    """The repetitions of a template, in frames of the whole motion."""

    segments: np.ndarray  # (n_repetitions, 2) first frame, and the one behind the last
    distances: np.ndarray  # (n_repetitions,) mean distance from the template
    template: int | None
    pauses: np.ndarray  # (n_pauses, 2) first still frame, and the one behind the last


class Templates:
    """All segments of a section as templates: of every k-th frame of a motion, some of those that move."""

    def __init__(self, frames: Frames, section: np.ndarray, every: int, limits: Limits):
        distances = frames.distances(section)
        self.frames, self.every, self.limits = section, every, limits
        self.n = len(section)
        self.similarities = _similarities(frames, distances)
        self.reach = first_far((distances >= EXTENT * frames.median) & (distances > 0.0))
        self.pauses = _still_before(section, every)

    def best(self, lengths: Iterable[int], is_held: bool, n_refined: int, n_jobs: int) -> list[Segment]:
        """Return the fittest template of each length, of which the best are refined and the others left out."""
        found: list[Template] = []

        def rate(length: int) -> None:
            starts = self._starts(length, is_held)
            found.append(
                max((self._rate(start, length, is_held) for start in starts), default=Template(0.0, 0, length))
            )

        in_threads((partial(rate, length) for length in lengths if length <= self.n // 2), n_jobs)
        found = [one for one in sorted(found, reverse=True) if one.fitness > 0.0]
        most = SHORTER * found[0].length if found else 0
        chosen = {*found[:n_refined], *[one for one in found if one.length <= most][:n_refined]}
        refined = {self._refine(one, is_held) for one in chosen}
        ends = [(one, self.frames[[one.start, one.start + one.length - 1]].tolist()) for one in refined]
        return [Segment(one.fitness, first, last, is_held) for one, (first, last) in ends]

    def _starts(self, length: int, is_held: bool) -> Iterable[int]:
        """Return where templates of a length begin that are rated: behind or ahead of a pause, others if not held."""
        behind = np.flatnonzero(self.pauses > LONGEST_PAUSE * length)
        steps = range(0, 0 if is_held else self.n - length + 1, max(1, length // STARTS_PER_LENGTH))
        return np.unique([*behind, *(behind - length), *steps]).astype(int).tolist()

    def _rate(self, start: int, length: int, is_held: bool) -> Template:
        """Return a template with its fitness, zero for one that is not allowed."""
        fitness, longest = 0.0, np.inf if is_held else LONGEST_PAUSE * length
        if self._is_allowed(start, length, is_held):
            fitness = fitness_of(self.similarities, self.pauses, longest, start, start + length, start)
        return Template(fitness, start, length)

    def _is_allowed(self, start: int, length: int, is_held: bool) -> bool:
        stop = start + length
        if not (0 <= start <= self.n - length and LEAST_LENGTH <= length <= self.n // 2):
            return False
        if self.reach[start] >= stop or not comes_back(self.similarities, start, stop, BACK):
            return False
        outside = max(self.pauses[start], self.pauses[stop] if stop < self.n else 0)
        if self.pauses[start + 1 : stop].max() > (outside if is_held else LONGEST_PAUSE * length):
            return False
        first, last = _trim_slivers(self.frames[start:stop])
        return self.limits.least <= last - first + self.every - 1 <= self.limits.most

    def _refine(self, template: Template, is_held: bool) -> Template:
        """Return the best template near one."""
        step = max(1, template.length // 8)
        while step and template.fitness > 0.0:
            near = [
                self._rate(template.start + shift, template.length + growth, is_held)
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
    """A template, and how it explains the whole motion; of long ones every k-th frame, so that memory is bounded."""

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
        self.similarities = _similarities(frames, frames.distances(self.frames, self.frames[self.start : self.stop]))
        self.longest = np.inf if segment.is_held else LONGEST_PAUSE * self.length
        self.fitness = fitness_of(self.similarities, self.pauses, self.longest, 0, self.length, self.start)

    @property
    def length(self) -> int:
        return self.stop - self.start

    def rate(self) -> Segment:
        """Return the template with how well it explains the whole, and how often it is there."""
        n = 1 + len(self._segments(0, self.start)[0]) + len(self._segments(self.stop, self.n)[0])
        return self.segment._replace(fitness=self.fitness, n_repetitions=n)

    def repetitions(self) -> Found:
        """Return the template and the segments of its path families, in their order."""
        before, near_before = self._segments(0, self.start)
        after, near_after = self._segments(self.stop, self.n)
        rows = np.concatenate([before, [(self.start, self.stop)], after])
        similarities = np.concatenate([near_before, [1.0], near_after])
        is_template = np.arange(len(rows)) == len(before)
        whole = is_template | [self._comes_back(first, stop) for first, stop in rows]
        if whole.sum() < 2:
            return nothing(self.of)
        segments = np.array([_trim_slivers(self.frames[first:stop]) for first, stop in rows[whole]])
        segments[:, 1] = np.minimum(segments[:, 1] + self.every - 1, self.of.n)
        distances = ZERO * self.of.median * np.maximum(0.0, 1.0 - similarities[whole])
        least = max(1.0, SHORTEST_PAUSE * self.length * self.every)
        return Found(segments, distances, int(is_template[whole].argmax()), pauses(self.of, segments, least))

    def _comes_back(self, first: int, stop: int) -> bool:
        """Return whether a segment comes back, as a template must: a path may go through a part of it twice as fast."""
        distances = self.of.distances(self.frames[first : first + 1], self.frames[first : stop + 1])[0]
        length = stop - first
        return bool(distances[length - 1 :].min() <= PART * distances[:length].max())

    def _segments(self, first: int, last: int) -> tuple[np.ndarray, np.ndarray]:
        """Return the segments of the template in some frames, and their mean similarities: between long pauses each."""
        cuts = first + np.flatnonzero(self.pauses[first:last] > self.longest)
        edges = [first, *cuts[cuts > first], last]
        found = [segments_of(self.similarities, i, j, 0, self.length) for i, j in pairwise(edges)]
        segments, similarities = zip(*found, strict=True)
        return np.concatenate(segments), np.concatenate(similarities)


def explain(frames: Frames, limits: Limits, n_jobs: int) -> Explanation | None:
    """Return the template that explains most of a motion; None where nothing repeats.

    Templates are looked for among all frames in sections, among every second frame in half as many, and so on, until
    one section has all: where movements are short, and where they are long or rare.
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
            templates = Templates(frames, section, every, limits)
            for is_held in (False, True):
                if not is_held or templates.pauses.max(initial=0) > LONGEST_PAUSE * LEAST_LENGTH:
                    found += templates.best(lengths, is_held, REFINED if every == 1 and is_last else RATED, n_jobs)
        every *= 2
    best, held = (_best_of(frames, [one for one in found if one.is_held == is_held]) for is_held in (False, True))
    return held if held is not None and (best is None or held.fitness > HELD * best.fitness) else best


def _best_of(frames: Frames, segments: list[Segment]) -> Explanation | None:
    """Return the segment that explains most of the motion, one of those that explain most of their section."""
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


def nothing(frames: Frames) -> Found:
    """Return no repetition, and all pauses."""
    none = np.zeros((0, 2), dtype=np.int64)
    return Found(none, np.zeros(0), None, pauses(frames, none, LEAST_LENGTH))


def pauses(frames: Frames, segments: np.ndarray, least: float) -> np.ndarray:
    """Return the runs of still frames outside of the segments that have at least so many frames."""
    is_still = ~frames.is_moving
    for first, last in segments:
        is_still[first:last] = False
    edges = np.flatnonzero(np.diff(is_still, prepend=False, append=False)).reshape(-1, 2)
    return edges[np.ptp(edges, axis=1) >= least]


def _similarities(frames: Frames, distances: np.ndarray) -> np.ndarray:
    return 1.0 - distances / (ZERO * frames.median) if frames.median > 0.0 else np.ones(distances.shape)


def _still_before(frames: np.ndarray, every: int) -> np.ndarray:
    """Return how many still frames, of every k-th, are before each one that moves."""
    return np.diff(frames, prepend=frames[:1] - every) // every - 1


def _lengths(shortest: int, longest: int) -> list[int]:
    lengths = [shortest]
    while lengths[-1] <= longest:
        lengths.append(max(lengths[-1] + 1, int(GROWTH * lengths[-1])))
    return lengths[:-1]


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
