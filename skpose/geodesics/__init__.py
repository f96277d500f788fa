"""Shortest paths between poses, and the means of poses that they define."""

from skpose.geodesics._geodesic import Geodesic, geodesic
from skpose.geodesics._interpolate import interpolate
from skpose.geodesics._logarithm import exp_map, log_map
from skpose.geodesics._mean import FrechetMean, frechet_mean

__all__ = ["FrechetMean", "Geodesic", "exp_map", "frechet_mean", "geodesic", "interpolate", "log_map"]
