"""Names of `skpose.geodesics` that the other packages of skpose use, in addition to the public ones."""

from skpose.geodesics._descent import MEAN, descend
from skpose.geodesics._extrinsic import TOL
from skpose.geodesics._geodesic_view import GeodesicPoses
from skpose.geodesics._logarithm import TangentSpace, to_joints
from skpose.geodesics._weightings import WeightedMeans

__all__ = ["MEAN", "TOL", "GeodesicPoses", "TangentSpace", "WeightedMeans", "descend", "to_joints"]
