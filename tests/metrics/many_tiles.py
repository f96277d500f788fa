"""A matrix of many small tiles, each noted at once."""

import numpy as np
from test_out import TREE

from skpose.metrics import _run
from skpose.metrics._matrix import DistanceMatrix

X = np.cumsum(np.random.default_rng(0).normal(0, 0.1, size=(150, TREE.n_dofs)), axis=0)


def use_small_tiles(monkeypatch):
    """Make tiles 16 × 16."""
    monkeypatch.setattr("skpose.metrics._matrix.ENCODED_AT_ONCE", 16)
    monkeypatch.setattr(_run, "SECONDS", -1.0)


def record_tiles(monkeypatch):
    """Return a list of the tiles that are computed from now on, a single one too, which `counted` does not see."""
    compute, tiles = DistanceMatrix.distances, []

    def recorded(matrix, tile, *arguments):
        tiles.append(tile)
        return compute(matrix, tile, *arguments)

    monkeypatch.setattr(DistanceMatrix, "distances", recorded)
    return tiles
