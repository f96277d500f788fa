"""Kernels of distances, what the transformers share of them, and the repair of those not positive semidefinite.

A training kernel K = U Λ Uᵀ of distances that are not Euclidean may have negative eigenvalues. Two repairs of
Y. Chen, E. K. Garcia, M. R. Gupta, A. Rahimi, L. Cazzanti, "Similarity-based classification: concepts and algorithms",
Journal of Machine Learning Research 10, 2009, sec. 4, for the training kernel and, consistently, for rows k of others:

clip
    The negative eigenvalues become zero. That is K P with the projection P = I − U₋U₋ᵀ on the other eigenvectors, so a
    row of a new pose becomes k P. A row of a training pose becomes its row of the repaired kernel.
shift
    K + λI with λ the magnitude of the least eigenvalue: each pose is more similar to itself, and no two different poses
    change. So rows of new poses stay, unless a new pose is one of the training poses: as a function of two poses, this
    is the kernel plus λ where they are equal. Equal training poses share the λ: with K = Z K' Zᵀ, where Z assigns poses
    to the different ones, K + λ Z Zᵀ = Z (K' + λI) Zᵀ, and the least eigenvalue of K' is no less than that of K.
"""

from collections.abc import Callable
from dataclasses import dataclass
from numbers import Real

import numpy as np
from scipy.linalg import eigh, eigvalsh

from skpose._utils.sklearn import Interval, StrOptions

SCALE_SAMPLES = 500  # training samples from which gamma="scale" takes the mean squared distance
KERNEL_CONSTRAINTS: dict[str, list] = {
    "kernel": [StrOptions(["rbf", "laplacian"]), None],
    "gamma": [StrOptions(["scale"]), Interval(Real, 0, None, closed="left")],
    "psd": [StrOptions(["ignore", "clip", "shift"])],
}


@dataclass(frozen=True)
class Kernel:
    """A kernel by name, and its γ."""

    name: str
    gamma: float

    def of(self, distances):
        """Turn distances into the kernel, in place."""
        if self.name == "rbf":
            np.square(distances, out=distances)
        distances *= -self.gamma
        return np.exp(distances, out=distances)


@dataclass(frozen=True, eq=False)
class Repair:
    """The repair of a training kernel, and of rows of the same kernel.

    Attributes
    ----------
    vectors : ndarray of shape (n, n_negative)
        The eigenvectors that "clip" removes; none with "shift".
    shift : float
        The λ of "shift"; zero with "clip".
    negative_share : float
        Share of the negative eigenvalues in the sum of all magnitudes.
    """

    vectors: np.ndarray
    shift: float
    negative_share: float

    def rows(self, kernel, equal):
        """Repair rows of the kernel in place; `equal` is True for two equal poses."""
        if self.vectors.shape[1]:
            kernel -= (kernel @ self.vectors) @ self.vectors.T
        if self.shift:
            kernel[equal] += self.shift
        return kernel


def repair_kernel(kernel, equal, psd):
    """Repair a symmetric kernel in place; also its `Repair`.

    The diagonal of a kernel of distances is one, so rounding changes an eigenvalue by no more than some n times the
    precision of its numbers. Negative eigenvalues of that size count as zero.
    """
    n = len(kernel)
    in_float64 = kernel.astype(np.float64)  # a copy, which is overwritten
    options = {"overwrite_a": True, "check_finite": False}
    if psd == "clip":
        values, vectors = eigh(in_float64, **options)
    else:
        values, vectors = eigvalsh(in_float64, **options), np.empty((n, 0))
    negative = values < -n * np.finfo(kernel.dtype).eps
    below = np.abs(values[negative]).sum()
    share = float(below / (below + values[~negative].clip(0).sum()))
    if psd == "shift":
        repair = Repair(vectors, float(np.abs(values[negative]).max(initial=0.0)), share)
        return repair.rows(kernel, equal), repair
    removed = vectors[:, negative]
    scaled = removed * np.sqrt(-values[negative])
    kernel += scaled @ scaled.T  # exactly symmetric, as the product of a matrix with its own transpose is
    return kernel, Repair(removed, 0.0, share)


class KernelMixin:
    """Mixin for transformers whose distances may become a kernel: with the parameters `kernel`, `gamma` and `psd`.

    Attributes
    ----------
    gamma_ : float
        The γ in use. Only with a kernel.
    negative_share_ : float
        Share of the negative eigenvalues in the sum of all magnitudes before the repair. Only with a repair.
    """

    kernel: str | None
    gamma: str | float
    psd: str

    def _check_kernel(self):
        """Refuse the repair of distances."""
        if self.psd != "ignore" and self.kernel is None:
            raise ValueError(f'psd="{self.psd}" repairs a kernel, got kernel=None: choose "rbf" or "laplacian"')

    def _learn_kernel(self, n: int, among: Callable[[np.ndarray | None], np.ndarray]) -> np.ndarray | None:
        """Learn γ and the repair from n training samples; the result is their kernel if it was computed, else None.

        `among` computes the distances among some of the training samples, or all if None.
        """
        self._kernel = self._repair = distances = None
        if self.kernel is None:
            return None
        if self.gamma == "scale":
            chosen = np.unique(np.linspace(0, n - 1, SCALE_SAMPLES).astype(int))
            some = among(None if len(chosen) == n else chosen)
            distances = some if len(chosen) == n else None
        self.gamma_ = self._scale_of(some) if self.gamma == "scale" else float(self.gamma)
        self._kernel = Kernel(self.kernel, self.gamma_)
        if self.psd == "ignore":
            return None if distances is None else self._kernel.of(distances)
        distances = among(None) if distances is None else distances
        equal = distances == 0
        kernel, self._repair = repair_kernel(self._kernel.of(distances), equal, self.psd)
        self.negative_share_ = self._repair.negative_share
        return kernel

    def _scale_of(self, distances: np.ndarray) -> float:
        """The γ of gamma="scale", from distances among training samples."""
        squared = np.square(distances, dtype=np.float64).mean()
        if squared == 0:  # all samples are equal: every scale gives the same
            return 1.0
        return float(2.0 / squared if self.kernel == "rbf" else np.sqrt(2.0 / squared))

    def _similarity(self, distances: np.ndarray) -> np.ndarray:
        """Turn distances into the kernel in place, if there is one."""
        if self._kernel is None:
            return distances
        if self._repair is None:
            return self._kernel.of(distances)
        equal = distances == 0
        return self._repair.rows(self._kernel.of(distances), equal)
