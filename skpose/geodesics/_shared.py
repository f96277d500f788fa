"""What the other packages of skpose use of `skpose.geodesics` beside its public names."""

from skpose.geodesics._descent import MEAN, descend
from skpose.geodesics._logarithm import TangentSpace, require_logarithms, to_joints
from skpose.geodesics._weightings import WeightedMeans

__all__ = ["MEAN", "TangentSpace", "WeightedMeans", "descend", "require_logarithms", "to_joints"]
