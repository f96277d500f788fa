"""Permutation test of a quadratic form cᵀGc.

A split of the units into sets X and Y is a vector c with entries 1 / n for units in X and −1 / m for units in Y. Under
the null hypothesis all splits that the design allows are equally likely.
"""

from collections.abc import Iterator
from itertools import combinations, islice
from math import comb
from typing import Any, NamedTuple

import numpy as np

VALUES_AT_ONCE = 2**21  # entries of a chunk of splits: 16 MB, and as much for the products
ROUNDING = 100 * np.finfo(np.float64).eps  # relative to the largest entry of G; smaller differences are ties


class Design(NamedTuple):
    """The splits that are equally likely under the null hypothesis."""

    n_x: int
    n_y: int
    paired: bool  # whether X[i] and Y[i] are exchanged, and nothing else

    @property
    def n_splits(self) -> int:
        return 2**self.n_x if self.paired else comb(self.n_x + self.n_y, self.n_x)

    @property
    def n_equal(self) -> int:
        """Number of splits with equal value: in sets of equal size, X and Y can be exchanged."""
        return 2 if self.n_x == self.n_y else 1

    @property
    def given(self) -> np.ndarray:
        """The observed split."""
        return np.repeat([1.0 / self.n_x, -1.0 / self.n_y], [self.n_x, self.n_y])

    def all(self) -> Iterator[np.ndarray]:
        """Yield all splits in chunks (n, n_units)."""
        if self.paired:
            for first in range(0, self.n_splits, self._at_once):
                numbers = np.arange(first, min(first + self._at_once, self.n_splits))
                yield self._flip((numbers[:, None] >> np.arange(self.n_x)) & 1 == 1)
            return
        subsets = combinations(range(self.n_x + self.n_y), self.n_x)
        while chunk := list(islice(subsets, self._at_once)):
            yield self._split(np.array(chunk))

    def draw(self, n_permutations: int, rng: np.random.RandomState) -> Iterator[np.ndarray]:
        """Yield random splits in chunks (n, n_units); they do not depend on the size of a chunk."""
        for first in range(0, n_permutations, self._at_once):
            n = min(self._at_once, n_permutations - first)
            if self.paired:
                yield self._flip(rng.random_sample((n, self.n_x)) < 0.5)
            else:
                order = rng.random_sample((n, self.n_x + self.n_y)).argsort(axis=1)
                yield self._split(order[:, : self.n_x])

    @property
    def _at_once(self) -> int:
        return max(1, VALUES_AT_ONCE // (self.n_x + self.n_y))

    def _flip(self, flips: np.ndarray) -> np.ndarray:
        signs = np.where(flips, -1.0, 1.0)
        return np.concatenate([signs, signs], axis=1) * self.given

    def _split(self, units: np.ndarray) -> np.ndarray:
        splits = np.full((len(units), self.n_x + self.n_y), -1.0 / self.n_y)
        np.put_along_axis(splits, units, 1.0 / self.n_x, axis=1)
        return splits


def permutation_test(G: np.ndarray, design: Design, n_permutations: int, rng: np.random.RandomState) -> dict[str, Any]:
    """Test the statistic cᵀGc; large values speak against equal sets. The result has fields of `TwoSampleTestResult`.

    The p-value is defined as in `scipy.stats.permutation_test`: the share of all splits if there are at most
    `n_permutations`, else the share of random splits plus the observed one.
    """
    exact = design.n_splits <= n_permutations
    chunks = design.all() if exact else design.draw(n_permutations, rng)
    (statistic,) = _values(design.given[None], G)
    null = np.concatenate([_values(splits, G) for splits in chunks])
    n_as_large = int((null >= statistic - ROUNDING * np.abs(G).max()).sum())
    counted = 0 if exact else 1
    pvalue = (n_as_large + counted) / (len(null) + counted)
    least = design.n_equal / design.n_splits if exact else 1.0 / (n_permutations + 1)
    return {
        "statistic": float(statistic),
        "pvalue": pvalue,
        "null_distribution": null,
        "least_pvalue": least,
        "exact": exact,
    }


def _values(splits: np.ndarray, G: np.ndarray) -> np.ndarray:
    return np.einsum("su,su->s", splits @ G, splits)
