"""Names of `skpose.metrics` that the other packages of skpose use, in addition to the public ones."""

from skpose.metrics._convergence import Unconverged, warn_of_unconverged
from skpose.metrics._matrix import ENCODED_AT_ONCE, DistanceMatrix
from skpose.metrics._mirror import mirror
from skpose.metrics._paired import paired_distances
from skpose.metrics._registry import (
    METRIC_CONSTRAINTS,
    METRICS,
    OUT,
    Chosen,
    Coarse,
    Metric,
    resolve,
    warn_of_no_skeleton,
)
from skpose.metrics._tiled import TiledMatrix, digest, metric_fingerprint
from skpose.metrics._tiles import Tile

__all__ = [
    "ENCODED_AT_ONCE",
    "METRICS",
    "METRIC_CONSTRAINTS",
    "OUT",
    "Chosen",
    "Coarse",
    "DistanceMatrix",
    "Metric",
    "Tile",
    "TiledMatrix",
    "Unconverged",
    "digest",
    "metric_fingerprint",
    "mirror",
    "paired_distances",
    "resolve",
    "warn_of_no_skeleton",
    "warn_of_unconverged",
]
