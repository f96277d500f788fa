"""Gaussian kernel weights of training rows around a query."""

import numpy as np
from scipy.spatial.distance import cdist

NEGLIGIBLE = 1e-6  # weight, relative to the largest, that counts as zero


class KernelWeights:
    """Training rows and their weights around any query.

    Equal rows count once, with the sum of their weights.

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
        self.row_of = row_of.ravel()  # a column in numpy 2.0
        shares = sample_weight / sample_weight.max()
        sums = np.bincount(self.row_of, shares)
        self.share_of_row = shares / sums[self.row_of]
        self.log_weights = np.log(sums)
        self.gamma = self._scott(X, shares) if gamma == "scott" else float(gamma)

    def _scott(self, X, shares):
        """The γ of Scott's rule, from the mean variance of the columns and the number of distinct rows."""
        mean = np.average(X, axis=0, weights=shares)
        variance = np.average((X - mean) ** 2, axis=0, weights=shares).mean()
        squared_width = variance * len(self.rows) ** (-2.0 / (X.shape[1] + 4))
        return float(0.5 / squared_width) if squared_width > 0.0 else 1.0

    def of(self, queries, n_neighbors):
        """Weights (n_queries, n_samples) around queries; the largest distinct row of each query has weight 1."""
        distances = cdist(queries, self.rows)
        nearest = distances.min(axis=1, keepdims=True)
        # d² − d₀², with d₀ the distance of the nearest row, so that its kernel is 1 and never underflows.
        logarithms = self.log_weights - (self.gamma * (distances - nearest)) * (distances + nearest)
        if n_neighbors is not None and n_neighbors < len(self.rows):
            last = np.partition(distances, n_neighbors - 1, axis=1)[:, n_neighbors - 1, np.newaxis]
            logarithms[distances > last] = -np.inf
        weights = np.exp(logarithms - logarithms.max(axis=1, keepdims=True))
        weights[weights < NEGLIGIBLE] = 0.0
        return weights[:, self.row_of] * self.share_of_row
