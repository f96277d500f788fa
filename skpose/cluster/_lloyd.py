"""K-means under any distance that has means: initialisation and Lloyd's iterations.

Costs are weighted sums of squared distances. `squared(centers)` computes the squared distances (n_samples, n_centers)
to some poses, `means(weightings)` the means under weightings (n_means, n_samples).
"""

from typing import NamedTuple

import numpy as np


class Clusters(NamedTuple):
    """The result of one run."""

    centers: np.ndarray  # (n_clusters, n_dofs)
    inertia: float  # weighted sum of squared distances to the nearest centre
    n_iter: int
    converged: bool
    n_unconverged: int  # centres whose last mean did not converge


def first_centers(poses, weights, squared, n_clusters, rng):
    """Indices of the first centres by greedy k-means++, as in scikit-learn.

    D. Arthur, S. Vassilvitskii, "k-means++: the advantages of careful seeding", SODA 2007.
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
    """Draw rows with probabilities proportional to chances; any rows if all chances are zero."""
    sums = np.cumsum(chances)
    return np.minimum(np.searchsorted(sums, rng.uniform(size=n) * sums[-1], side="right"), len(chances) - 1)


def lloyd(centers, weights, squared, means, max_iter, tol):
    """Lloyd's iterations from some centres, which are changed in place.

    The cost never rises: a mean replaces a centre only if it is nearer to the cluster, which matters for distances with
    several minima. An empty cluster gets the sample farthest from its centre.
    """
    n_clusters = len(centers)
    rows = np.arange(len(weights))
    distances = squared(centers)
    labels = distances.argmin(axis=1)
    inertia = _cost(weights, distances, labels)
    fixed = np.full(len(labels), -1)  # labels for which the centres are means
    unconverged = np.zeros(n_clusters, dtype=bool)
    for iteration in range(1, max_iter + 1):
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
    """Assign the sample of the largest cost to each empty cluster, unless all costs are zero."""
    labels = labels.copy()
    for empty in np.setdiff1d(np.arange(n_clusters), labels):
        farthest = costs.argmax()
        if costs[farthest] == 0.0:
            break
        labels[farthest], costs[farthest] = empty, 0.0
    return labels
