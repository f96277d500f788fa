"""Whole motions: distances by dynamic time warping, alignment, exact search.

| module       |                                                                                  |
|--------------|----------------------------------------------------------------------------------|
| `_inputs`    | motions that the user gives, as one array of frames on one skeleton              |
| `_distances` | the matrix of distances as a function; `_matrix` knows its tiles and their cost  |
| `_transformer` | the distances as a step of a pipeline; `_base` is what the estimators share     |
"""

from skpose.motions._distances import motion_distances
from skpose.motions._transformer import MotionDistanceTransformer

__all__ = ["MotionDistanceTransformer", "motion_distances"]
