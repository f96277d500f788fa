"""Whole motions: distances by dynamic time warping, alignment, exact search, means, repetitions.

| module       |                                                                                  |
|--------------|----------------------------------------------------------------------------------|
| `_inputs`    | motions that the user gives, as one array of frames on one skeleton              |
| `_distances` | the matrix of distances as a function; `_matrix` knows its tiles and their cost  |
| `_mean`      | the mean of motions; `_barycenter` has its two steps                             |
| `_repetitions` | repetitions in one motion; `_template` finds what is repeated                  |
"""

from skpose.motions._distances import motion_distances
from skpose.motions._mean import MeanMotion, mean_motion
from skpose.motions._repetitions import Repetitions, segment_repetitions

__all__ = ["MeanMotion", "Repetitions", "mean_motion", "motion_distances", "segment_repetitions"]
