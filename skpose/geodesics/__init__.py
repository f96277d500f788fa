"""Shortest paths between poses, logarithms, means, medians, and motions through key poses.

| module                      |                                                               |
|-----------------------------|---------------------------------------------------------------|
| `_geodesic`                 | the path between two poses                                    |
| `_logarithm`                | poses as tangent vectors at a base pose, and back             |
| `_interpolate`              | motions through key poses, along geodesics or a spline        |
| `_mean`                     | Fréchet means and geometric medians                           |
| `_descent`                  | the two minimisers behind means and medians                   |
"""

from skpose.geodesics._geodesic import GeodesicResult as GeodesicResult, geodesic
from skpose.geodesics._interpolate import interpolate
from skpose.geodesics._logarithm import exp_map, log_map
from skpose.geodesics._mean import GeometricMedianResult as GeometricMedianResult, frechet_mean, geometric_median
from skpose.metrics._means import FrechetMeanResult as FrechetMeanResult

__all__ = [
    "exp_map",
    "frechet_mean",
    "geodesic",
    "geometric_median",
    "interpolate",
    "log_map",
]
