"""Distances between human poses that measure how far the joints move, for scikit-learn.

The metrics of S. Hauberg and K. S. Pedersen, "Spatial measures between human poses for classification and
understanding", AMDO 2012, :doi:`10.1007/978-3-642-31567-1_3`. In the order in which data flows: files (`skpose.io`)
and datasets (`skpose.datasets`), `Skeleton` and `Motion`, kinematics, metrics, matrices of distances, estimators.
"""

from importlib.metadata import version

from skpose.cluster import MedoidShift
from skpose.geodesics import FrechetMean, Geodesic, frechet_mean, geodesic
from skpose.kinematics import forward_kinematics, metric_tensor, position_jacobian
from skpose.manifold import SpatialMDS
from skpose.metrics import pose_distances, pose_distances_chunked, pose_metric
from skpose.neighbors import PoseKNeighborsTransformer, PoseRadiusNeighborsTransformer
from skpose.preprocessing import PoseDistanceTransformer
from skpose.skeleton import Bone, Motion, Skeleton, poses_from_rotations, rotations_from_poses

__all__ = [
    "Bone",
    "FrechetMean",
    "Geodesic",
    "MedoidShift",
    "Motion",
    "PoseDistanceTransformer",
    "PoseKNeighborsTransformer",
    "PoseRadiusNeighborsTransformer",
    "Skeleton",
    "SpatialMDS",
    "forward_kinematics",
    "frechet_mean",
    "geodesic",
    "metric_tensor",
    "pose_distances",
    "pose_distances_chunked",
    "pose_metric",
    "poses_from_rotations",
    "position_jacobian",
    "rotations_from_poses",
]

__version__ = version("skpose")
