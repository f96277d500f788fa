"""The distances between poses: as a matrix, in chunks, and as one compiled function of two poses."""

from skpose.metrics._pairwise import pose_distances, pose_distances_chunked
from skpose.metrics._pose_metric import pose_metric

__all__ = ["pose_distances", "pose_distances_chunked", "pose_metric"]
