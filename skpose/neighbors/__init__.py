"""Nearest neighbours of poses, exact ones as sparse graphs for scikit-learn."""

from skpose.neighbors._kneighbors import PoseKNeighborsTransformer
from skpose.neighbors._radius_neighbors import PoseRadiusNeighborsTransformer

__all__ = ["PoseKNeighborsTransformer", "PoseRadiusNeighborsTransformer"]
