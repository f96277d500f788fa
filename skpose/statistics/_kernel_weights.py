"""Weights of training rows around a query, by a Gaussian kernel."""

import numpy as np
from scipy.spatial.distance import cdist

FARTHEST = 1e150  # distance whose square is finite
NEGLIGIBLE = 1e-6  # weight, relative to the largest around a query, that counts as zero


class KernelWeights:
    """Training rows, and the weights that they have around any query.

    Equal rows count as one, so that a row twice is the same as the row with twice the weight.

    Parameters
    ----------
    X : ndarray of shape (n_samples, n_features)
        Training rows, float64.
    sample_weight : ndarray of shape (n_samples,)
        Positive weights.
    gamma : "scott" or float
        The γ of the kernel.
    """

    def __init__(self, X, sample_weight, gamma):
        self.rows, row_of = np.unique(X, axis=0, return_inverse=True)
        self.row_of = row_of.ravel()  # numpy 2.0 gave it the shape of a column
        shares = sample_weight / sample_weight.max()
        sums = np.bincount(self.row_of, shares)
        self.share_of_row = shares / sums[self.row_of]
        self.log_weights = np.log(sums)
        self.gamma = self._scott(X, shares) if gamma == "scott" else float(gamma)

    def _scott(self, X, shares):
        """Return the γ of Scott's width, from the mean variance of the columns and the number of different rows."""
        mean = np.average(X, axis=0, weights=shares)
        with np.errstate(over="ignore"):
            variance = np.average((X - mean) ** 2, axis=0, weights=shares).mean()
            squared_width = variance * len(self.rows) ** (-2.0 / (X.shape[1] + 4))
        return float(0.5 / squared_width) if 0.0 < squared_width < np.inf else 1.0

    def of(self, queries, n_neighbors):
        """Return the weights (n_queries, n_samples) around queries (n_queries, n_features), the largest row's one.

        With `n_neighbors` rows that are farther than so many others weigh nothing.
        """
        distances = np.minimum(cdist(queries, self.rows), FARTHEST)
        nearest = distances.min(axis=1, keepdims=True)
        with np.errstate(over="ignore"):
            # d² − d₀² with the distance d₀ of the nearest row: its kernel is one, however far it is.
            logarithms = self.log_weights - (self.gamma * (distances - nearest)) * (distances + nearest)
        if n_neighbors is not None and n_neighbors < len(self.rows):
            last = np.partition(distances, n_neighbors - 1, axis=1)[:, n_neighbors - 1, np.newaxis]
            logarithms[distances > last] = -np.inf
        weights = np.exp(logarithms - logarithms.max(axis=1, keepdims=True))
        weights[weights < NEGLIGIBLE] = 0.0
        return weights[:, self.row_of] * self.share_of_row
