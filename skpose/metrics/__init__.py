"""The distances between poses: as a matrix, in chunks, and as one compiled function of two poses.

A metric is an object derived from `Metric` (`_metric`), in one file: `_angle`, `_position`, `_rotation`, `_spatial`,
`_geodesic`; `_motion_metrics` are for motions only, and `_registry` has all by name. `_means` has what
means of poses need. `_pairwise` holds the public functions of matrices; `_matrix` computes tiles, distributes them and
writes each into `out`, or does so lazily for dask.
"""

from skpose.metrics._angle import Angle
from skpose.metrics._geodesic import Geodesic
from skpose.metrics._metric import Metric
from skpose.metrics._motion_metrics import Centered, Jerk, Velocity
from skpose.metrics._own import compile_encode, compile_measure
from skpose.metrics._pairwise import pose_distances, pose_distances_chunked
from skpose.metrics._pose_metric import pose_metric
from skpose.metrics._position import Position
from skpose.metrics._rotation import Rotation
from skpose.metrics._spatial import Spatial

__all__ = [
    "Angle",
    "Centered",
    "Geodesic",
    "Jerk",
    "Metric",
    "Position",
    "Rotation",
    "Spatial",
    "Velocity",
    "compile_encode",
    "compile_measure",
    "pose_distances",
    "pose_distances_chunked",
    "pose_metric",
]
