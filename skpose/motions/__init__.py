"""Whole motions: distances by dynamic time warping, alignment, exact search, means, repetitions.

| module         |                                                                                             |
|----------------|---------------------------------------------------------------------------------------------|
| `_inputs`      | motions that the user gives, as one array of frames on one skeleton                         |
| `_distances`   | the matrix of distances as a function; `_matrix` knows its tiles and their cost             |
| `_alignment`   | the path of two motions, and the joints in which they differ                                |
| `_transformer` | the distances as a step of a pipeline; `_base` is what the estimators share                 |
| `_memory`      | distances that earlier calls have computed, in files                                        |
| `_kneighbors`  | the graph of the nearest motions; `_queries` splits its requests, `_search` answers one     |
| `_find`        | the best windows of long motions; `_windows` finds them                                     |
| `_stream`      | movements in a stream, frame by frame; `_stream_rows` has the sums of its templates         |
| `_index`       | motions that are searched; `_bounds` are lower bounds of the distances to them              |
| `_mean`        | the mean of motions; `_barycenter` has its two steps                                        |
| `_repetitions` | repetitions in one motion; `_template` finds what is repeated, `_surrogates` how surely,     |
|                | in `_frames`, which has the distances of long motions piece by piece                        |
"""

from skpose.motions._alignment import Alignment, JointDifference, align_motions
from skpose.motions._distances import motion_distances
from skpose.motions._find import MotionIndex, MotionMatch, find_motion
from skpose.motions._kneighbors import MotionKNeighborsTransformer
from skpose.motions._mean import MeanMotion, mean_motion
from skpose.motions._repetitions import Repetitions, segment_repetitions
from skpose.motions._results import MotionEvaluations
from skpose.motions._stream import MotionStream, StreamMatch, StreamState
from skpose.motions._transformer import MotionDistanceTransformer

__all__ = [
    "Alignment",
    "JointDifference",
    "MeanMotion",
    "MotionDistanceTransformer",
    "MotionEvaluations",
    "MotionIndex",
    "MotionKNeighborsTransformer",
    "MotionMatch",
    "MotionStream",
    "Repetitions",
    "StreamMatch",
    "StreamState",
    "align_motions",
    "find_motion",
    "mean_motion",
    "motion_distances",
    "segment_repetitions",
]
