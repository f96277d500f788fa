"""Shortest paths between poses, and what rests on them: logarithms, means and medians, motions through key poses.

| module                                    |                                                                         |
|-------------------------------------------|-------------------------------------------------------------------------|
| `_geodesic`                               | the path between two poses                                              |
| `_sequence`                               | lengths of the paths from the frames of a motion to poses               |
| `_logarithm`                              | poses as vectors at a base, and back                                    |
| `_interpolate`, `_spline`                 | motions through key poses                                               |
| `_mean`, `_median`                        | Fréchet means and geometric medians; `_weighted_poses` checks the poses |
| `_descent`, `_quasi_newton`               | how they are found, from what a metric's `sample` says at a pose        |
| `_weightings`                             | means of many weightings of one set of poses                            |
"""

from skpose.geodesics._geodesic import GeodesicResult as GeodesicResult
from skpose.geodesics._geodesic import geodesic
from skpose.geodesics._interpolate import interpolate
from skpose.geodesics._logarithm import exp_map, log_map
from skpose.geodesics._mean import FrechetMeanResult as FrechetMeanResult
from skpose.geodesics._mean import frechet_mean
from skpose.geodesics._median import GeometricMedianResult as GeometricMedianResult
from skpose.geodesics._median import geometric_median
from skpose.geodesics._sequence import geodesic_distances

__all__ = [
    "exp_map",
    "frechet_mean",
    "geodesic",
    "geodesic_distances",
    "geometric_median",
    "interpolate",
    "log_map",
]
