"""Distances to the training poses as a step of a scikit-learn pipeline."""

from skpose.preprocessing._distances import PoseDistanceTransformer

__all__ = ["PoseDistanceTransformer"]
