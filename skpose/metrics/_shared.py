"""Names of `skpose.metrics` that the other packages of skpose use, in addition to the public ones."""

from skpose.metrics._convergence import Unconverged, warn_of_unconverged
from skpose.metrics._direct_means import TOL as TOL_EXTRINSIC
from skpose.metrics._geodesic import no_geodesics, no_paths
from skpose.metrics._matrix import ENCODED_AT_ONCE, DistanceMatrix
from skpose.metrics._metric import CoarseBound, require_skeleton
from skpose.metrics._mirror import mirror
from skpose.metrics._motion_metrics import MotionMetric
from skpose.metrics._paired import paired_distances
from skpose.metrics._registry import (
    MEAN_CONSTRAINTS,
    METRIC_CONSTRAINTS,
    METRICS,
    OF_MOTIONS,
    OUT,
    require,
    require_geodesic,
    require_means,
    resolve,
    warn_of_no_skeleton,
    why_no_paths,
)
from skpose.metrics._sample import Sample
from skpose.metrics._tiled import Tile, TiledMatrix

__all__ = [
    "ENCODED_AT_ONCE",
    "MEAN_CONSTRAINTS",
    "METRICS",
    "METRIC_CONSTRAINTS",
    "OF_MOTIONS",
    "OUT",
    "TOL_EXTRINSIC",
    "CoarseBound",
    "DistanceMatrix",
    "MotionMetric",
    "Sample",
    "Tile",
    "TiledMatrix",
    "Unconverged",
    "mirror",
    "no_geodesics",
    "no_paths",
    "paired_distances",
    "require",
    "require_geodesic",
    "require_means",
    "require_skeleton",
    "resolve",
    "warn_of_no_skeleton",
    "warn_of_unconverged",
    "why_no_paths",
]
