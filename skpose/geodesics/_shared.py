"""Names of `skpose.geodesics` that the other packages of skpose use, in addition to the public ones."""

from skpose.geodesics._descent import MEAN, descend
from skpose.geodesics._logarithm import to_joints, why_no_logarithms
from skpose.geodesics._tangent_space import TangentSpace
from skpose.geodesics._weightings import WeightedMeans

__all__ = ["MEAN", "TangentSpace", "WeightedMeans", "descend", "to_joints", "why_no_logarithms"]
