"""The distances between poses: as a matrix, in chunks, and as one compiled function of two poses.

Each file is visited once, from left to right::

    _pairwise --+-----------> _matrix --> _tiled --> _output --> _run --> _writers, _zarr_writer
                +--> _dask --/               |                    |            |
                                             +---- _tiles --------+------------+

`_pairwise` holds the public functions and checks their arguments; `_matrix` knows what is to be computed, `_tiled` in
which tiles and where. The others know only arrays, tiles and checksums: `_output` what the destination is, `_run` which
tiles are complete and who writes the rest, this process or workers, and the writers where the bytes are. `_registry`
defines the five metrics.
"""

from skpose.metrics._pairwise import pose_distances, pose_distances_chunked
from skpose.metrics._pose_metric import pose_metric

__all__ = ["pose_distances", "pose_distances_chunked", "pose_metric"]
