"""How well distances recognise actions: the nearest neighbour among other people, of frames and of sequences."""

import numpy as np
from numba import njit

RATE = 12  # Hz


@njit(nogil=True)
def warped(distances):
    """Dynamic time warping: the least sum along a monotone path, over the number of frames of both."""
    n, m = distances.shape
    sums = np.full((n + 1, m + 1), np.inf)
    sums[0, 0] = 0.0
    for i in range(n):
        for j in range(m):
            sums[i + 1, j + 1] = distances[i, j] + min(sums[i, j], sums[i, j + 1], sums[i + 1, j])
    return sums[n, m] / (n + m)


def shares(distances, sequence, dataset):
    """The shares of frames, and of sequences, whose nearest neighbour among other people does the same, in percent."""
    subjects, actions = dataset.subjects, dataset.actions
    same_person = subjects[sequence][:, None] == subjects[sequence]
    nearest = np.where(same_person, np.inf, distances).argmin(axis=1)
    frames = (actions[sequence][nearest] == actions[sequence]).mean()
    starts = np.searchsorted(sequence, np.arange(len(dataset) + 1))
    sums = np.full((len(dataset), len(dataset)), np.inf)
    for i, j in zip(*np.nonzero(subjects[:, None] != subjects), strict=True):
        sums[i, j] = warped(np.ascontiguousarray(distances[starts[i] : starts[i + 1], starts[j] : starts[j + 1]]))
    return 100 * frames, 100 * (actions[sums.argmin(axis=1)] == actions).mean()
