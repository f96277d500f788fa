"""Clustering of poses."""

from skpose.cluster._k_means import PoseKMeans
from skpose.cluster._medoid_shift import MedoidShift

__all__ = ["MedoidShift", "PoseKMeans"]
