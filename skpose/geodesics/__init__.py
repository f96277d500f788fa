"""Shortest paths between poses, and the means of poses that they define."""

from skpose.geodesics._geodesic import Geodesic, geodesic
from skpose.geodesics._mean import FrechetMean, frechet_mean
from skpose.geodesics._median import GeometricMedian, geometric_median

__all__ = ["FrechetMean", "Geodesic", "GeometricMedian", "frechet_mean", "geodesic", "geometric_median"]
