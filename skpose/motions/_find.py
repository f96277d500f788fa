"""The best matches of a motion in long recordings."""

from numbers import Integral
from typing import Any, NamedTuple

import numpy as np
from joblib import effective_n_jobs

from skpose._utils.sklearn import Interval, validate_params
from skpose._utils.units import warn_of_degrees
from skpose.metrics import Metric
from skpose.metrics._matrix import warn_of_unconverged
from skpose.metrics._registry import resolve, warn_of_no_skeleton
from skpose.motions._distances import COMPARED_CONSTRAINTS, check_of_windows
from skpose.motions._inputs import check_motions, check_single_motions, rates_differ
from skpose.motions._search import SequenceIndex, WindowSearch
from skpose.skeleton import Skeleton


class MotionMatch(NamedTuple):
    """A match of the query, from `find_motion`.

    Attributes
    ----------
    motion : int
        Index of the motion.
    start, stop : int
        Its frames, as in a slice: ``motions[match.motion][match.start : match.stop]``.
    distance : float
        Sum of the distances between frames, divided by the number of frames of the query, m, or rad for "angle".

    Examples
    --------
    >>> from skpose.motions import MotionMatch
    >>> MotionMatch(motion=3, start=120, stop=180, distance=0.2)
    MotionMatch(motion=3, start=120, stop=180, distance=0.2)
    """

    motion: int
    start: int
    stop: int
    distance: float


class MotionIndex:
    """Motions prepared for many searches with `find_motion`.

    Parameters
    ----------
    motions : list of array-like of shape (n_frames, n_dofs), list of Motion, MotionDataset, or array of shape \
(n_motions, n_frames, n_dofs)
        Motions, as for `motion_distances`.
    skeleton : Skeleton, default=None
        The skeleton of all motions. None takes it from the `Motion` objects; arrays need it except for "angle".
    metric : str or Metric, default="auto"
        The distance between frames, see `motion_distances`, except "centered"; "auto" is "spatial" with a skeleton,
        else "angle" with a warning.

    Attributes
    ----------
    skeleton : Skeleton or None
        The skeleton in use.
    frame_rate : float or None
        Frame rate of the motions, Hz; None for arrays.

    See Also
    --------
    find_motion : The search.

    Notes
    -----
    Time O(frames), some microseconds each. Memory: a copy of the poses and about 90 bytes per frame.

    Examples
    --------
    >>> import numpy as np
    >>> from skpose import Skeleton
    >>> from skpose.motions import MotionIndex, find_motion
    >>> wave = np.sin(np.linspace(0, 20, 400))[:, None]
    >>> index = MotionIndex([wave, 2.0 * wave], skeleton=Skeleton.chain(1))
    >>> [match.motion for match in find_motion(2.0 * wave[30:70], index, k=2)]
    [1, 1]
    """

    @validate_params(COMPARED_CONSTRAINTS, prefer_skip_nested_validation=True)
    def __init__(
        self,
        motions: Any,
        *,
        skeleton: Skeleton | None = None,
        metric: str | Metric = "auto",
    ):
        (checked,) = check_motions({"motions": motions}, skeleton)
        chosen = resolve(metric, checked.skeleton, of_motions=True)
        check_of_windows(chosen)
        if checked.skeleton is not None:
            warn_of_degrees(None, checked.skeleton, motions=checked.sequences.poses)
        warn_of_no_skeleton(metric, checked.skeleton)
        self.skeleton, self.frame_rate = checked.skeleton, checked.frame_rate
        self._n_dofs = checked.sequences.poses.shape[1]
        self._index = SequenceIndex(checked.rows(chosen, "motions"), checked.skeleton, chosen)


@validate_params(
    COMPARED_CONSTRAINTS
    | {
        "k": [Interval(Integral, 1, None, closed="left")],
        "n_jobs": [None, Integral],
    },
    prefer_skip_nested_validation=True,
)
def find_motion(
    query: Any,
    motions: Any,
    *,
    k: int = 5,
    skeleton: Skeleton | None = None,
    metric: str | Metric = "auto",
    n_jobs: int | None = None,
) -> list[MotionMatch]:
    """Find the k best matches of a short motion in long recordings, by exact subsequence search.

    A *window* ends at a frame of a recording, and begins where the best path of the query to that frame begins: the
    path takes all frames of the query and warps time freely, see "subsequence" of `motion_distances`. The best window
    is the first match. The second is the best window that overlaps the first by at most half of the shorter one, and so
    on.

    Parameters
    ----------
    query : array-like of shape (n_frames, n_dofs) or Motion
        The motion to find: joint angles, and rotation vectors of ball joints, rad.
    motions : list of array-like of shape (n_frames, n_dofs), list of Motion, MotionDataset, MotionIndex, or array of \
shape (n_motions, n_frames, n_dofs)
        The recordings. For many queries pass a `MotionIndex`.
    k : int, default=5
        Number of matches.
    skeleton : Skeleton, default=None
        As for `motion_distances`; a `MotionIndex` has its own.
    metric : str or Metric, default="auto"
        Likewise.
    n_jobs : int, default=None
        Threads; None is 1 unless in a ``joblib.parallel_config`` context, -1 uses all processors.

    Returns
    -------
    list of MotionMatch
        The k best windows, by distance; fewer if the recordings are too short for k.

    Raises
    ------
    TypeError
        If the query is a list of motions, or `motions` a single motion.
    ValueError
        If query and recordings have different frame rates.

    Warns
    -----
    ConvergenceWarning
        If geodesics did not converge.

    See Also
    --------
    motion_distances : Distances of whole motions.
    MotionKNeighborsTransformer : The nearest of whole motions.

    Notes
    -----
    The result equals brute force, which measures each frame of the query against each frame of the recordings
    [1]_. *Filter and refine*, with bounds in order of their cost [2]_, is faster. The chord is never longer than the
    curve, ‖F(a) − F(b)‖ ≤ "geodesic" ≤ "spatial", so the least sum of chords along the paths through a frame bounds the
    sum of every window that contains it. Bounds are computed for boxes around eight frames first, then for the frames
    that the boxes leave, and the metric is measured only where a path within the k-th distance can go. "rotation" and
    ``Angle(wrap=True)`` have no bound and are searched by brute force.

    Time warps freely: one frame of the recording may match many of the query. If the recordings contain nothing like
    the query, the best windows are much shorter than it; check ``match.stop - match.start`` and the distance.

    Time O(frames of the query · frames of the recordings) in the worst case. Memory O(frames of the recordings), and
    some 4 bytes for each pair of a frame of the query and a frame of the longest recording.

    References
    ----------
    .. [1] M. Müller, "Information retrieval for music and motion", Springer, 2007, sec. 4.4,
       :doi:`10.1007/978-3-540-74048-3`.
    .. [2] T. Rakthanmanon et al., "Searching and mining trillions of time series subsequences under dynamic time
       warping", KDD 2012, :doi:`10.1145/2339530.2339576`.

    Examples
    --------
    A wave of the arm, twice in a recording:

    >>> import numpy as np
    >>> from skpose import Skeleton
    >>> from skpose.motions import find_motion
    >>> wave, rest = np.sin(np.linspace(0, 2 * np.pi, 30)), np.zeros(50)
    >>> recording = np.concatenate([rest, wave, rest, 0.9 * wave, rest])[:, None]
    >>> for match in find_motion(wave[:, None], [recording], k=2, skeleton=Skeleton.chain(1)):
    ...     print(match.start, match.stop, round(match.distance, 3))
    50 80 0.0
    130 160 0.051
    """
    if not isinstance(motions, MotionIndex):
        index = MotionIndex(motions, skeleton=skeleton, metric=metric)
    elif skeleton is None and metric == "auto":
        index = motions
    else:
        raise ValueError("a MotionIndex has its own skeleton and metric: pass them to MotionIndex")
    (checked,) = check_single_motions({"query": query}, index.skeleton)
    if index.skeleton is not None:
        warn_of_degrees(None, index.skeleton, query=checked.sequences.poses)
    here, there = checked.frame_rate, index.frame_rate
    if here is not None and there is not None and rates_differ(here, there):
        raise ValueError(f"query has {here:g} Hz and motions have {there:g} Hz: pass query.resample({there:g})")
    n_dofs = checked.sequences.poses.shape[1]
    if n_dofs != index._n_dofs:
        raise ValueError(f"query has {n_dofs} columns and motions have {index._n_dofs}")
    search = WindowSearch(index._index, effective_n_jobs(n_jobs))
    rows, starts = checked.rows(index._index.metric, "query").poses, index._index.sequences.starts
    windows = search.best(rows, int(k))
    warn_of_unconverged(search.unconverged, search.n_cells)
    motions = np.searchsorted(starts, [w.start for w in windows], side="right") - 1
    firsts = starts[motions].tolist()
    return [
        MotionMatch(motion, w.start - first, w.stop - first, w.sum / len(rows))
        for motion, first, w in zip(motions.tolist(), firsts, windows, strict=True)
    ]
