"""Classical scaling by eigenvectors of centred squared distances, and the choice of landmarks."""

from dataclasses import dataclass

import numpy as np
from scipy.linalg import eigh

from skpose._utils.warnings import warn

LANCZOS = 200  # up to this many poses a dense decomposition is fastest
ROUNDING = 1e-12  # eigenvalues below this share of the largest count as zero


@dataclass(frozen=True, eq=False)
class Scaling:
    """Result of classical scaling."""

    points: np.ndarray  # (n, n_components)
    eigenvalues: np.ndarray  # (n_components,)
    explained_variance_ratio: np.ndarray  # (n_components,)
    negative_share: float
    mean_squared: np.ndarray  # (n,) mean squared distance of each point
    projection: np.ndarray  # (n, n_components) the ½ Λ⁻¹ Zᵀ of Gower's formula, transposed

    def place(self, squared):
        """Coordinates of new points from their squared distances to the scaled points, by Gower's formula."""
        return (self.mean_squared - squared) @ self.projection


def classical_scaling(squared, n_components):
    """Scale squared distances, which are overwritten; components without positive eigenvalue are zero."""
    mean_squared = squared.mean(axis=0)
    squared -= mean_squared
    squared -= squared.mean(axis=1, keepdims=True)
    squared *= -0.5
    values, vectors, spectrum = _leading_eigenpairs(squared, n_components)
    positive = values > ROUNDING * np.abs(spectrum).max()
    if not positive.all():
        warn(f"only {positive.sum()} of the leading {n_components} eigenvalues are positive; other components are zero")
    vectors *= np.sign(vectors[np.abs(vectors).argmax(axis=0), np.arange(vectors.shape[1])])
    sqrt = np.sqrt(np.where(positive, values, 0.0))
    # Λ⁻¹ Zᵀ = Λ^-½ Uᵀ, zero for components without positive eigenvalue.
    projection = 0.5 * vectors * np.divide(1.0, sqrt, out=np.zeros_like(sqrt), where=positive)
    total, size = spectrum[spectrum > 0].sum(), np.abs(spectrum).sum()
    negative_share = float((size - total) / size) if size > 0 else 0.0
    ratio = np.maximum(values, 0.0) / total if total > 0 else np.zeros(n_components)
    return Scaling(vectors * sqrt, values, ratio, negative_share, mean_squared, projection)


def _leading_eigenpairs(B, n_components):
    """Leading eigenvalues padded with zeros, their eigenvectors, and the whole spectrum; B is overwritten."""
    n = len(B)
    k = min(n_components, n)
    if n <= LANCZOS or k > n // 10:
        spectrum, vectors = eigh(B)
        values, vectors = spectrum[::-1][:k], vectors[:, ::-1][:, :k]
    else:
        from scipy.sparse.linalg import ArpackError, eigsh

        try:
            # A fixed start, as the default is random. A vector of ones is in the kernel of the centred B.
            values, vectors = eigsh(B, k, which="LA", v0=np.random.default_rng(0).standard_normal(n))
        except ArpackError:
            values, vectors = eigh(B, subset_by_index=[n - k, n - 1])
        order = np.argsort(values)[::-1]
        values, vectors = values[order], vectors[:, order]
        spectrum = np.linalg.eigvalsh(B)  # scipy's holds the GIL
    missing = n_components - k
    return np.pad(values, (0, missing)), np.pad(vectors, ((0, 0), (0, missing))), spectrum


def farthest_points(distances_from, n, n_chosen, rng):
    """Sorted indices of a random point and, repeatedly, the point farthest from all chosen ones."""
    chosen = [int(rng.randint(n))]
    nearest = np.full(n, np.inf)
    while len(chosen) < n_chosen:
        np.minimum(nearest, distances_from(chosen[-1]), out=nearest)
        nearest[chosen] = -1.0
        chosen.append(int(nearest.argmax()))
    return np.sort(chosen)
