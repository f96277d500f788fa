"""Distances between whole motions."""

from numbers import Integral, Real
from typing import Any

import numpy as np

from skpose._utils.sklearn import Interval, StrOptions, validate_params
from skpose._utils.units import warn_of_degrees
from skpose.metrics import Metric
from skpose.metrics._convergence import warn_of_unconverged
from skpose.metrics._motion_metrics import MotionMetric
from skpose.metrics._registry import METRIC_CONSTRAINTS, OF_MOTIONS, OUT, resolve, warn_of_no_skeleton
from skpose.motions._inputs import Sequences, check_motions
from skpose.motions._matrix import ALIGNMENTS, MotionMatrix
from skpose.skeleton import Skeleton

# Parameter constraints of all functions and estimators of distances between motions.
ALIGNMENT_CONSTRAINTS = {
    "alignment": [StrOptions(ALIGNMENTS)],
    "window": [Interval(Real, 0, 1, closed="both"), None],
}
COMPARED_CONSTRAINTS: dict[str, list] = METRIC_CONSTRAINTS | {"metric": OF_MOTIONS}
MOTION_CONSTRAINTS = COMPARED_CONSTRAINTS | ALIGNMENT_CONSTRAINTS | {"n_jobs": [None, Integral], "verbose": ["verbose"]}


@validate_params(
    MOTION_CONSTRAINTS
    | {
        "normalize": ["boolean"],
        "out": OUT,
    },
    prefer_skip_nested_validation=True,
)
def motion_distances(
    X: Any,
    Y: Any = None,
    *,
    skeleton: Skeleton | None = None,
    metric: str | Metric = "auto",
    alignment: str = "dtw",
    window: float | None = None,
    normalize: bool = True,
    n_jobs: int | None = None,
    out: Any = None,
    verbose: int = 0,
) -> np.ndarray:
    r"""Distances between all motions of X and all motions of Y, by dynamic time warping under a distance of poses.

    With d the distance between poses, and a path a sequence of pairs of frames (i, j) from the first frames of both
    motions to the last ones, by steps (1, 0), (0, 1) and (1, 1) [1]_,

    .. math:: D(a, b) = \frac{1}{n + m} \min_{\text{path}} \sum_{(i, j) \in \text{path}} d(a_i, b_j)

    for n and m frames. Distances are not squared.

    Parameters
    ----------
    X : list of array-like or of Motion, MotionDataset, or array of shape (n_motions, n_frames, n_dofs)
        Motions of shape (n_frames, n_dofs): joint angles, and rotation vectors of ball joints, rad. Lengths may differ.
    Y : as X, default=None
        Other motions; None compares the motions of X with each other.
    skeleton : Skeleton, default=None
        The skeleton of all motions. None takes it from the `Motion` objects, or their mean as
        ``MotionDataset.skeleton``. Arrays need it for every metric except "angle".
    metric : str or Metric, default="auto"
        The distance between frames, see `pose_distances`; "auto" is "spatial" with a skeleton, else "angle" with a
        warning. "velocity" compares the velocities of the joints, "jerk" their jerks, and "centered" their positions
        minus the mean over the motion, see `skpose.metrics.Velocity`, `skpose.metrics.Jerk` and
        `skpose.metrics.Centered`.
    alignment : {"dtw", "subsequence", "frames"}, default="dtw"
        "dtw" warps both motions as a whole. "subsequence" finds the motion of X inside the one of Y: the path takes all
        frames of X, and begins and ends at any frame of Y; the sum is divided by n, and is not symmetric. "frames" is
        the mean over the pairs (i, i) of motions of equal length.
    window : float between 0 and 1, default=None
        Sakoe–Chiba band of "dtw": the largest difference between the times of a pair, as shares of the durations. Half
        a frame of the shorter motion is always allowed. None sets no limit.
    normalize : bool, default=True
        Whether to divide by the number of frames. False gives the sums.
    n_jobs : int, default=None
        Threads, or workers of the backend of a ``joblib.parallel_config`` context; -1 uses all processors. The result
        does not depend on it.
    out : array of shape (n_x, n_y), default=None
        Array for the result, of its dtype, such as a ``numpy.memmap`` or a zarr array; see `pose_distances`.
    verbose : int, default=0
        Whether to show progress.

    Returns
    -------
    ndarray of shape (n_x, n_y)
        Distances, in m, rad for "angle", m/s for "velocity", or m/s³ for "jerk": float32 if all motions are and the
        metric compares poses, else float64. Without Y exactly symmetric with a zero diagonal, except for "subsequence".
        `out` if given.

    Raises
    ------
    TypeError
        If X or Y is a single motion, or Motions and arrays are mixed.
    ValueError
        If the motions have different frame rates or skeletons that are not comparable; for "frames" with different
        lengths, a window without "dtw", "subsequence" with "centered", and "velocity" or "jerk" of arrays, which have
        no frame rate.

    Warns
    -----
    ConvergenceWarning
        If geodesics did not converge.
    UserWarning
        If the poses look like degrees, see `pose_distances`.

    See Also
    --------
    align_motions : The path of two motions, and the joints in which they differ.
    find_motion : The best matches of a motion in long recordings.
    MotionKNeighborsTransformer : The nearest motions, without computing most distances.

    Notes
    -----
    Time O(frames of X · frames of Y) distances between poses. Memory O(n_x · n_y): the distances between frames are not
    stored. Dynamic time warping does not obey the triangle inequality, under any metric.

    The distance counts frames, so all motions must have one frame rate. A lower rate costs less; 12 Hz is enough for
    most actions.

    References
    ----------
    .. [1] H. Sakoe, S. Chiba, "Dynamic programming algorithm optimization for spoken word recognition", IEEE
       Transactions on Acoustics, Speech, and Signal Processing 26(1), 1978, :doi:`10.1109/TASSP.1978.1163055`.
    .. [2] M. Müller, "Information retrieval for music and motion", Springer, 2007, sec. 4,
       :doi:`10.1007/978-3-540-74048-3`, for "subsequence".

    Examples
    --------
    A swing of the arm, the same swing at half the speed, and one half as far:

    >>> import numpy as np
    >>> from skpose import Skeleton, motion_distances
    >>> swing = np.sin(np.linspace(0, np.pi, 21))[:, None]
    >>> slow = np.sin(np.linspace(0, np.pi, 41))[:, None]
    >>> motion_distances([swing, slow, 0.5 * swing], skeleton=Skeleton.chain(1)).round(3)
    array([[0.   , 0.015, 0.118],
           [0.015, 0.   , 0.144],
           [0.118, 0.144, 0.   ]])
    """
    if Y is X:
        Y = None
    given = {"X": X} if Y is None else {"X": X, "Y": Y}
    checked = check_motions(given, skeleton)
    skeleton = checked[0].skeleton
    chosen = resolve(metric, skeleton, of_motions=True)
    if skeleton is not None:
        poses = {argument: one.sequences.poses for argument, one in zip(given, checked, strict=True)}
        warn_of_degrees(None, skeleton, in_estimator=False, **poses)
    sequences = [one.rows(chosen, argument) for argument, one in zip(given, checked, strict=True)]
    check_alignment(alignment, window, chosen, **dict(zip(given, sequences, strict=True)))
    matrix = MotionMatrix(
        sequences[0],
        None if Y is None else sequences[1],
        chosen,
        skeleton,
        alignment=alignment,
        window=window,
        normalize=normalize,
    )
    warn_of_no_skeleton(metric, skeleton)
    distances, unconverged = matrix.write(out, n_jobs, verbose)
    warn_of_unconverged(unconverged, matrix.n_cells)
    return distances


def check_of_windows(metric: Metric) -> None:
    """Refuse a metric that compares whole motions only."""
    if isinstance(metric, MotionMetric) and not metric.of_windows:
        raise ValueError(f'the metric {metric.label!r} compares whole motions, not windows; take "position"')


def check_alignment(alignment: str, window: float | None, metric: Metric, **given: Sequences) -> None:
    """Refuse a window without "dtw", and motions of different lengths where frame i is compared with frame i."""
    if alignment == "subsequence":
        check_of_windows(metric)
    if window is not None and alignment != "dtw":
        raise ValueError(f'window needs alignment="dtw", got alignment="{alignment}"')
    lengths = sorted({int(n) for one in given.values() for n in one.lengths})
    if alignment == "frames" and len(lengths) > 1:
        raise ValueError(f'alignment="frames" needs motions of equal length, got {lengths[0]} to {lengths[-1]} frames')
