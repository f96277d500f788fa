"""Clusters of poses."""

from skpose.cluster._medoid_shift import MedoidShift

__all__ = ["MedoidShift"]
