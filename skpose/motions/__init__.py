"""Whole motions: distances by dynamic time warping, alignment, exact search.

| module       |                                                                                  |
|--------------|----------------------------------------------------------------------------------|
| `_inputs`    | motions that the user gives, as one array of frames on one skeleton              |
| `_alignment` | the path of two motions, and the joints in which they differ                     |
| `_distances` | the matrix of distances as a function; `_matrix` knows its tiles and their cost  |
"""

from skpose.motions._alignment import Alignment, JointDifference, align_motions
from skpose.motions._distances import motion_distances

__all__ = ["Alignment", "JointDifference", "align_motions", "motion_distances"]
