"""Significance of repetitions: the motion is compared with surrogates, its own poses in another order.

A surrogate has the pieces of the motion in random order (J. Theiler et al., 1992, doi:10.1016/0167-2789(92)90102-S).
Its distances are those of the motion, with rows and columns in that order; none is computed anew. Pieces are shorter
than a movement, so that a surrogate has the poses and the speeds of the motion, and repeats by chance alone. Still
frames are left out of the motion, and a surrogate has none: its neighbouring frames are less far apart than those of
the motion, so that p-values of noise are too large rather than too small.

Short templates fit by chance, long ones rarely. So the fittest template of each length is compared with those of the
same length, by a standard score, and the largest score is the statistic (P. H. Westfall, S. S. Young, "Resampling-Based
Multiple Testing", 1993: max-T). It is the same function of the motion and of each surrogate, in which templates must
come back too, so that the rank of the motion among them is a p-value, and the search over lengths and starts is
accounted for.
"""

from functools import partial

import numpy as np

from skpose._compiled.path.family import first_far, fitness_by_length
from skpose._parallel.threads import in_threads
from skpose.motions._frames import Frames
from skpose.motions._template import BACK, LEAST_LENGTH, ZERO, Limits

EXTENT = 1.25  # distance that a template must have between two of its frames, in units of the near one
# In units of the frames in which the motion gets from a pose to a distant one (median), about half a movement:
PIECE = 0.25  # mean length of a piece
LEAST_TEMPLATE = 2.0  # shortest template: a movement
RESOLUTION = 4  # frames of such a half that are kept, where there are more
MOST_FRAMES = 300  # of a section; longer motions are compared section by section
SECTIONS = 5  # in which the length of half a movement is measured
GROWTH, STARTS_PER_LENGTH = 1.4, 3  # of the templates; coarser than in `_template`
STEADY = 0.03  # is added to the standard deviation of a fitness: where all are equal, nothing stands out


def p_value(frames: Frames, limits: Limits, n_surrogates: int, rng: np.random.RandomState, n_jobs: int) -> float:
    """Return the share of the surrogates that repeat as much as the motion does, the motion counted among them."""
    moving, near = frames.moving(1), frames.near  # not the median: other movements may be far from this one
    if len(moving) < 2 * LEAST_LENGTH or near == 0.0:
        return 1.0
    half = _frames_of_half(frames, EXTENT * near)
    thinning = max(1, int(half / RESOLUTION))
    half = half / thinning
    kept = moving[::thinning]
    sections = np.array_split(kept, -(-len(kept) // MOST_FRAMES))
    lengths = _lengths(min(map(len, sections)), half, limits.least / thinning, limits.most / thinning)
    fitness = np.zeros((1 + n_surrogates, len(lengths)))
    for section in sections:
        n, distances = len(section), frames.distances(section)
        similarities, is_far = 1.0 - distances / (ZERO * near), distances >= EXTENT * near
        orders = [np.arange(n), *(_shuffle(n, PIECE * half, rng) for _ in range(n_surrogates))]

        def rate(i: int, similarities: np.ndarray, is_far: np.ndarray, order: np.ndarray) -> None:
            of_section = fitness_by_length(similarities, is_far, order, lengths, STARTS_PER_LENGTH, BACK)
            fitness[i] = np.maximum(fitness[i], of_section)

        in_threads((partial(rate, i, similarities, is_far, order) for i, order in enumerate(orders)), n_jobs)
    scores = (fitness - fitness.mean(axis=0)) / (fitness.std(axis=0) + STEADY)
    largest = scores.max(axis=1, initial=-np.inf)
    return float(np.mean(largest >= largest[0]))


def _frames_of_half(frames: Frames, far: float) -> float:
    """Return the median number of frames from a frame to the first one that is far from it, or from one between.

    Of long motions in some sections, and of movements that are longer than a section among every second, fourth frame.
    """
    every, sections = 1, []
    while True:
        sections, found = frames.sections(every, SECTIONS), []
        for section in sections:
            reach = first_far(frames.distances(section) >= far)
            starts = np.flatnonzero(reach < len(reach))
            found.append(every * (reach[starts] - starts))
        halves = np.concatenate(found)
        if 2 * len(halves) > sum(map(len, sections)) or len(frames.sections(every)) == 1:
            return float(np.median(halves)) if len(halves) else every * len(sections[0]) / 2
        every *= 2


def _lengths(n: int, half: float, least: float, most: float) -> np.ndarray:
    """Return the lengths of templates in n frames: the longest that may be, where all of them are short."""
    longest = int(min(n // 2, most))
    length = int(min(max(LEAST_LENGTH, LEAST_TEMPLATE * half, 0.5 * least), longest))
    lengths = []
    while LEAST_LENGTH <= length <= longest:
        lengths.append(length)
        length = longest if length < longest < GROWTH * length else max(length + 1, int(GROWTH * length))
    return np.array(lengths, dtype=np.int64)


def _shuffle(n: int, piece: float, rng: np.random.RandomState) -> np.ndarray:
    """Return the frames with pieces of half to three halves of a mean length in random order."""
    lengths = np.maximum(1, np.rint(piece * rng.uniform(0.5, 1.5, size=n))).astype(np.int64)
    cuts = np.cumsum(lengths)
    pieces = np.split(np.arange(n), cuts[cuts < n])
    return np.concatenate([pieces[i] for i in rng.permutation(len(pieces))])
