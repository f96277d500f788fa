"""Significance of repetitions: the motion is compared with surrogates, its own poses in another order.

A surrogate has the pieces of the motion in random order (J. Theiler et al., 1992, doi:10.1016/0167-2789(92)90102-S), so
its distance matrix is the one of the motion, reordered. Pieces are shorter than a movement, so a
surrogate has the poses and the speeds of the motion, but repeats by chance only. Still frames are left out.

Short templates fit by chance, long ones rarely. So the fittest template of each length gets a standard score among
templates of the same length, and the largest score is the statistic (P. H. Westfall, S. S. Young, "Resampling-Based
Multiple Testing", 1993: max-T). It is the same function of the motion and of each surrogate, so the rank of the motion
is a p-value that accounts for the search over lengths and starts.
"""

from functools import partial

import numpy as np

from skpose._compiled.path.family import first_far, fitness_by_length
from skpose._utils.parallel import in_threads
from skpose.motions._template import BACK, LEAST_LENGTH, ZERO, Frames

EXTENT = 1.25  # least distance between two frames of a template, in units of the near distance
# In units of the median number of frames from a pose to a distant one, about half a movement:
PIECE = 0.25  # mean length of a piece
LEAST_TEMPLATE = 2.0  # shortest template: a movement
RESOLUTION = 4  # frames of such a half that are kept
MOST_FRAMES = 300  # of a section
SECTIONS = 5  # for the length of half a movement
GROWTH, STARTS_PER_LENGTH = 1.4, 3  # of the templates; coarser than in `_template`
STEADY = 0.03  # added to the standard deviation of the fitness, which may be zero


def p_value(
    frames: Frames, limits: tuple[float, float], n_surrogates: int, rng: np.random.RandomState, n_jobs: int
) -> float:
    """Share of the surrogates that repeat as much as the motion, the motion included."""
    moving, near = frames.moving(1), frames.near  # other movements may be far away, so not the median
    if len(moving) < 2 * LEAST_LENGTH or near == 0.0:
        return 1.0
    half = _frames_of_half(frames, EXTENT * near)
    thinning = max(1, int(half / RESOLUTION))
    half = half / thinning
    kept = moving[::thinning]
    sections = np.array_split(kept, -(-len(kept) // MOST_FRAMES))
    lengths = _lengths(min(map(len, sections)), half, *(n / thinning for n in limits))
    fitness = np.zeros((1 + n_surrogates, len(lengths)))
    for section in sections:
        n, distances = len(section), frames.distances(section)
        similarities, is_far = 1.0 - distances / (ZERO * near), distances >= EXTENT * near
        orders = [np.arange(n), *(_shuffle(n, PIECE * half, rng) for _ in range(n_surrogates))]

        def rate(i: int, similarities: np.ndarray, is_far: np.ndarray, order: np.ndarray) -> None:
            shuffled = (matrix[np.ix_(order, order)] for matrix in (similarities, is_far))
            fitness[i] = np.maximum(fitness[i], fitness_by_length(*shuffled, lengths, STARTS_PER_LENGTH, BACK))

        in_threads((partial(rate, i, similarities, is_far, order) for i, order in enumerate(orders)), n_jobs)
    scores = (fitness - fitness.mean(axis=0)) / (fitness.std(axis=0) + STEADY)
    largest = scores.max(axis=1, initial=-np.inf)
    return float(np.mean(largest >= largest[0]))


def _frames_of_half(frames: Frames, far: float) -> float:
    """Median number of frames from a frame to the first one far from it, or from one in between.

    Long motions are measured in some sections; movements longer than a section among every second or fourth frame.
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
    """Lengths of templates in n frames."""
    longest = int(min(n // 2, most))
    length = int(min(max(LEAST_LENGTH, LEAST_TEMPLATE * half, 0.5 * least), longest))
    lengths = []
    while LEAST_LENGTH <= length <= longest:
        lengths.append(length)
        length = longest if length < longest < GROWTH * length else max(length + 1, int(GROWTH * length))
    return np.array(lengths, dtype=np.int64)


def _shuffle(n: int, piece: float, rng: np.random.RandomState) -> np.ndarray:
    """The frames with pieces of half to three halves of a mean length in random order."""
    lengths = np.maximum(1, np.rint(piece * rng.uniform(0.5, 1.5, size=n))).astype(np.int64)
    cuts = np.cumsum(lengths)
    pieces = np.split(np.arange(n), cuts[cuts < n])
    return np.concatenate([pieces[i] for i in rng.permutation(len(pieces))])
