"""The distances between poses: as a matrix, in chunks, and as one compiled function of two poses.

Each file is visited once, from left to right::

    _pairwise --+-----------> _matrix --> _tiled --> _output --> _run --> _writers, _zarr_writer
                +--> _dask --/               |                    |            |
                                             +---- _tiles --------+------------+

`_pairwise` holds the public functions and checks their arguments; `_matrix` knows what is to be computed, `_tiled` in
which tiles and where. The others know only arrays, tiles and checksums: `_output` what the destination is, `_run` which
tiles are complete and who writes the rest, this process or workers, and the writers where the bytes are.

A metric is one object in one file, `_angle`, `_position`, `_rotation`, `_spatial`, `_geodesic`, derived from `Metric`
(`_metric`). What the search for means asks of it is a `_sample`. `_motion_metrics` are those of motions alone.
`_registry` has them by name.

Scores of predictions against the truth, such as MPJPE, stand apart in `_scores`.
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
from skpose.metrics._scores._acceleration import acceleration_error
from skpose.metrics._scores._angles import mean_angle_error
from skpose.metrics._scores._dtw import dtw_mje
from skpose.metrics._scores._geodesic import geodesic_error
from skpose.metrics._scores._mpjpe import mpjpe
from skpose.metrics._scores._npss import npss
from skpose.metrics._scores._pck import pck, pck_auc
from skpose.metrics._scores._score import Score
from skpose.metrics._scores._scorer import get_scorer
from skpose.metrics._scores._signature import pose_score
from skpose.metrics._spatial import Spatial

__all__ = [
    "Angle",
    "Centered",
    "Geodesic",
    "Jerk",
    "Metric",
    "Position",
    "Rotation",
    "Score",
    "Spatial",
    "Velocity",
    "acceleration_error",
    "compile_encode",
    "compile_measure",
    "dtw_mje",
    "geodesic_error",
    "get_scorer",
    "mean_angle_error",
    "mpjpe",
    "npss",
    "pck",
    "pck_auc",
    "pose_distances",
    "pose_distances_chunked",
    "pose_metric",
    "pose_score",
]
