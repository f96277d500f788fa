"""Names of `skpose.geodesics` for other packages of skpose, besides the public ones."""

from skpose.geodesics._descent import MEAN, descend
from skpose.geodesics._logarithm import to_joints, why_no_logarithms
from skpose.geodesics._tangent_space import TangentSpace
from skpose.geodesics._weightings import WeightedMeans

__all__ = ["MEAN", "TangentSpace", "WeightedMeans", "descend", "to_joints", "why_no_logarithms"]
