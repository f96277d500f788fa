"""The algorithm of classical scaling: eigenvectors of the centred squared distances, and the choice of landmarks."""

from dataclasses import dataclass

import numpy as np
from scipy.linalg import eigh

from skpose._warnings import warn

LANCZOS = 200  # up to this many poses one dense decomposition is the fastest for a few eigenvectors
ROUNDING = 1e-12  # an eigenvalue below this share of the largest counts as zero


@dataclass(frozen=True, eq=False)
class Scaling:
    """Result of classical scaling."""

    points: np.ndarray  # (n, n_components)
    eigenvalues: np.ndarray  # (n_components,)
    explained_variance_ratio: np.ndarray  # (n_components,)
    negative_share: float
    mean_squared: np.ndarray  # (n,) mean squared distance from each point
    projection: np.ndarray  # (n, n_components) the ½ Λ⁻¹ Zᵀ of Gower's formula, transposed

    def place(self, squared):
        """Points of others, by Gower's formula from their squared distances to the scaled ones."""
        return (self.mean_squared - squared) @ self.projection


def classical_scaling(squared, n_components):
    """Scale squared distances, overwriting them; components of eigenvalues that are not positive are zero."""
    mean_squared = squared.mean(axis=0)
    squared -= mean_squared
    squared -= squared.mean(axis=1, keepdims=True)
    squared *= -0.5
    values, vectors, spectrum = _leading_eigenpairs(squared, n_components)
    positive = values > ROUNDING * np.abs(spectrum).max()
    if not positive.all():
        few = f"the distances have only {positive.sum()} positive eigenvalues among the leading {n_components}"
        warn(
            f"{few}; the components beyond these are zero: ask for fewer"
            if positive.any()
            else "all distances are zero, and with them all components: the poses are equal under this metric"
        )
    vectors *= np.sign(vectors[np.abs(vectors).argmax(axis=0), np.arange(vectors.shape[1])])
    sqrt = np.sqrt(np.where(positive, values, 0.0))
    # Λ⁻¹ Zᵀ = Λ^-½ Uᵀ; a component of zeros takes nothing from any pose.
    projection = 0.5 * vectors * np.divide(1.0, sqrt, out=np.zeros_like(sqrt), where=positive)
    total, size = spectrum[spectrum > 0].sum(), np.abs(spectrum).sum()
    negative_share = float((size - total) / size) if size > 0 else 0.0
    ratio = np.maximum(values, 0.0) / total if total > 0 else np.zeros(n_components)
    return Scaling(vectors * sqrt, values, ratio, negative_share, mean_squared, projection)


def _leading_eigenpairs(B, n_components):
    """The leading eigenvalues of B, padded with zeros, their eigenvectors, and the whole spectrum; B is overwritten."""
    n = len(B)
    k = min(n_components, n)
    if n <= LANCZOS or k > n // 10:
        spectrum, vectors = eigh(B)
        values, vectors = spectrum[::-1][:k], vectors[:, ::-1][:, :k]
    else:
        from scipy.sparse.linalg import ArpackError, eigsh

        try:
            # A fixed start: the default is random, and B, being centred, maps a vector of ones to zero.
            values, vectors = eigsh(B, k, which="LA", v0=np.random.default_rng(0).standard_normal(n))
        except ArpackError:
            values, vectors = eigh(B, subset_by_index=[n - k, n - 1])
        order = np.argsort(values)[::-1]
        values, vectors = values[order], vectors[:, order]
        spectrum = np.linalg.eigvalsh(B)  # without vectors: half the time; scipy's stops every other thread
    missing = n_components - k
    return np.pad(values, (0, missing)), np.pad(vectors, ((0, 0), (0, missing))), spectrum


def farthest_points(distances_from, n, n_chosen, rng):
    """Indices of points each of which is the farthest from those before it; the first is random."""
    chosen = [int(rng.randint(n))]
    nearest = np.full(n, np.inf)
    while len(chosen) < n_chosen:
        np.minimum(nearest, distances_from(chosen[-1]), out=nearest)
        nearest[chosen] = -1.0
        chosen.append(int(nearest.argmax()))
    return np.sort(chosen)
