"""Whole motions: distances by dynamic time warping, alignment, exact search, means, repetitions.

| module         |                                                                                             |
|----------------|---------------------------------------------------------------------------------------------|
| `_inputs`      | motions of the user as one array of frames on one skeleton                                  |
| `_distances`   | the matrix of distances, computed tile by tile                                              |
| `_alignment`   | the path of two motions, and the differences of their joints                                |
| `_transformer` | the distances as a step of a pipeline                                                       |
| `_kneighbors`  | the graph of the nearest motions                                                            |
| `_find`        | the best windows of long motions                                                            |
| `_search`      | the motions to search, lower bounds of the distances to them, the search of both            |
| `_mean`        | the mean of motions and their roots                                                         |
| `_repetitions` | repetitions in one motion; `_template` finds them, `_surrogates` how surely                   |
"""

from skpose.motions._alignment import Alignment as Alignment, JointDifference as JointDifference, align_motions
from skpose.motions._distances import motion_distances
from skpose.motions._find import MotionIndex, MotionMatch as MotionMatch, find_motion
from skpose.motions._kneighbors import MotionKNeighborsTransformer
from skpose.motions._mean import MeanMotion as MeanMotion, mean_motion
from skpose.motions._repetitions import Repetitions as Repetitions, segment_repetitions
from skpose.motions._transformer import MotionDistanceTransformer

__all__ = [
    "MotionDistanceTransformer",
    "MotionIndex",
    "MotionKNeighborsTransformer",
    "align_motions",
    "find_motion",
    "mean_motion",
    "motion_distances",
    "segment_repetitions",
]
