"""Steps of a scikit-learn pipeline: positions to poses, poses to distances."""

from skpose.preprocessing._distances import PoseDistanceTransformer
from skpose.preprocessing._positions import PoseFromPositions

__all__ = ["PoseDistanceTransformer", "PoseFromPositions"]
