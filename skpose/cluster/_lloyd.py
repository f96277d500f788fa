"""The algorithm of k-means under any distance that has means: the first centres, and the iterations.

Costs are weighted sums of squared distances. `squared(centers)` returns the squared distances (n_samples, n_centers) of
all samples to some poses, and `means(weightings)` the means of the samples under weightings (n_means, n_samples).
"""

from typing import NamedTuple

import numpy as np


class Clusters(NamedTuple):
    """The result of the iterations from one start."""

    centers: np.ndarray  # (n_clusters, n_dofs)
    inertia: float  # weighted sum of squared distances to the nearest centre
    n_iter: int
    converged: bool
    n_unconverged: int  # centres, the last of whose means did not converge


def first_centers(poses, weights, squared, n_clusters, rng):
    """Return the samples that are the first centres: k-means++ with some candidates for each, the best of which stays.

    D. Arthur, S. Vassilvitskii, "k-means++: the advantages of careful seeding", SODA 2007; candidates as in
    scikit-learn.
    """
    n_trials = 2 + int(np.log(n_clusters))
    chosen = _draw(weights, 1, rng)
    nearest = squared(poses[chosen])[:, 0]
    while len(chosen) < n_clusters:
        candidates = _draw(weights * nearest, n_trials, rng)
        trials = np.minimum(squared(poses[candidates]), nearest[:, np.newaxis])
        best = (weights @ trials).argmin()
        chosen, nearest = np.append(chosen, candidates[best]), trials[:, best]
    return chosen


def _draw(chances, n, rng):
    """Return rows that are drawn with probabilities in proportion to chances; any rows if all chances are zero."""
    sums = np.cumsum(chances)
    return np.minimum(np.searchsorted(sums, rng.uniform(size=n) * sums[-1], side="right"), len(chances) - 1)


def lloyd(centers, weights, squared, means, max_iter, tol, fit_progress):
    """Move centres to the means of their clusters, in turns with the assignment of samples, until nothing changes.

    The cost never rises: a mean that is no nearer to its cluster than the centre before, as where distances have
    several minima, is not taken. A cluster without samples gets the one that is farthest from its centre.
    """
    n_clusters = len(centers)
    rows = np.arange(len(weights))
    distances = squared(centers)
    labels = distances.argmin(axis=1)
    inertia = _cost(weights, distances, labels)
    fixed = np.full(len(labels), -1)  # the labels with which each centre is the mean of its cluster
    unconverged = np.zeros(n_clusters, dtype=bool)
    for iteration in range(1, max_iter + 1):
        with fit_progress.step("iteration"):
            labels = _fill_empty(labels, weights * distances[rows, labels], n_clusters)
            changed = labels != fixed
            moving = np.union1d(labels[changed], fixed[changed & (fixed >= 0)])
            moving = moving[np.isin(moving, labels)]
            weightings = (labels == moving[:, np.newaxis]) * weights
            found, converged = means(weightings)
            unconverged[moving] = ~converged
            to_found = squared(found)
            better = (weightings * to_found.T).sum(axis=1) < (weightings * distances[:, moving].T).sum(axis=1)
            centers[moving[better]], distances[:, moving[better]] = found[better], to_found[:, better]
            fixed, labels = labels, distances.argmin(axis=1)
            before, inertia = inertia, _cost(weights, distances, labels)
        if np.array_equal(labels, fixed) or before - inertia <= tol * inertia:
            return Clusters(centers, inertia, iteration, True, int(unconverged.sum()))
    return Clusters(centers, inertia, max_iter, False, int(unconverged.sum()))


def _cost(weights, distances, labels):
    return float(weights @ distances[np.arange(len(labels)), labels])


def _fill_empty(labels, costs, n_clusters):
    """Return labels where each empty cluster has the sample of the largest cost; none if all costs are zero."""
    labels = labels.copy()
    for empty in np.setdiff1d(np.arange(n_clusters), labels):
        farthest = costs.argmax()
        if costs[farthest] == 0.0:
            break
        labels[farthest], costs[farthest] = empty, 0.0
    return labels
