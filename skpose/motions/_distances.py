"""Distances between whole motions: the public function and its arguments."""

from numbers import Integral, Real
from typing import Any

import numpy as np

from skpose._compat.sklearn import Interval, StrOptions, validate_params
from skpose._validation.units import warn_of_degrees
from skpose.metrics import Metric
from skpose.metrics._shared import (
    METRIC_CONSTRAINTS,
    OF_MOTIONS,
    OUT,
    MotionMetric,
    resolve,
    warn_of_no_skeleton,
    warn_of_unconverged,
)
from skpose.motions._inputs import Sequences, check_motions
from skpose.motions._matrix import ALIGNMENTS, MotionMatrix
from skpose.skeleton import Skeleton

# Constraints of the parameters that every function and estimator of distances between motions has.
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

    With d the distance between poses, and a path a sequence of pairs of frames (i, j) from (0, 0) to the last of both,
    by steps (1, 0), (0, 1) and (1, 1) [1]_,

    .. math:: D(a, b) = \frac{1}{n + m} \min_{\text{path}} \sum_{(i, j) \in \text{path}} d(a_i, b_j)

    for n and m frames. The sum has no root, and the distances are not squared.

    Parameters
    ----------
    X : list of array-like or of Motion, MotionDataset, or array of shape (n_motions, n_frames, n_dofs)
        Motions of shape (n_frames, n_dofs) each: joint angles, and rotation vectors of ball joints, rad. Lengths may
        differ.
    Y : as X, default=None
        Other motions; None is X, of which one triangle is then computed.
    skeleton : Skeleton, default=None
        The skeleton of all motions. None is that of the `Motion` objects, where they differ their mean, as
        ``MotionDataset.skeleton``; arrays need it, but for "angle".
    metric : str or Metric, default="auto"
        The distance between frames, see `pose_distances`; "auto" is "spatial" with a skeleton, else "angle" and a
        warning. "velocity" compares the velocities of the joints, "jerk" their jerks, and "centered" their positions
        less the mean over the motion, see `skpose.metrics.Velocity`, `skpose.metrics.Jerk` and
        `skpose.metrics.Centered`.
    alignment : {"dtw", "subsequence", "frames"}, default="dtw"
        "dtw" warps the whole of both. "subsequence" looks for the motion of X inside the one of Y: the path takes all
        frames of X, and begins and ends at any frame of Y; the sum is divided by n. It is not symmetric. "frames" takes
        the pairs (i, i) of motions of equal length, and is the mean over the frames.
    window : float between 0 and 1, default=None
        Sakoe–Chiba band of "dtw": times of a pair, as shares of the two durations, may differ by this; half a frame
        of the shorter motion is always allowed. None is no limit.
    normalize : bool, default=True
        Whether to divide by the number of frames. False gives the sums.
    n_jobs : int, default=None
        Threads; None is 1 unless in a ``joblib.parallel_config`` context, -1 all processors. Where that context names
        a backend of processes or a cluster, tiles are computed there. The result does not depend on it.
    out : array of shape (n_x, n_y), default=None
        Array for the result, of its dtype, such as a ``numpy.memmap`` or a zarr array; see `pose_distances`, also for
        how a file that was left incomplete is finished.
    verbose : int, default=0
        Whether to show the progress.

    Returns
    -------
    ndarray of shape (n_x, n_y)
        Distances, in m, rad for "angle", m/s for "velocity", or m/s³ for "jerk": float32 where all motions are and
        their poses are compared, else float64. Without Y exactly symmetric with a zero diagonal, but for "subsequence".
        `out` if that is given.

    Raises
    ------
    TypeError
        For one motion in the place of several, and for Motions and arrays together.
    ValueError
        For poses that `pose_distances` refuses, motions of different frame rates, skeletons that are not comparable;
        for "frames" with different lengths, a window without "dtw", "subsequence" with "centered", and "velocity" or
        "jerk" of arrays, which have no frame rate; for an `out` of another shape or dtype, or one
        that holds the beginning of other distances.

    Warns
    -----
    ConvergenceWarning
        If geodesics did not converge.
    UserWarning
        If the poses look like degrees, see `pose_distances`.

    See Also
    --------
    align_motions : The path of two motions, and the joints in which they differ.
    find_motion : The best places of a motion in long recordings.
    MotionKNeighborsTransformer : The nearest motions without most of the distances: for nearest-neighbour classifiers.

    Notes
    -----
    Time O(frames of X · frames of Y) distances between poses; the recursion adds some nanoseconds to each. Memory O(n_x
    · n_y), and the codes of some thousand frames of each side: there is no matrix of the distances between frames. DTW
    obeys no triangle inequality, under any metric.

    The distance counts frames: motions should have one frame rate, and a lower one costs less: 12 Hz is enough for most
    actions.

    References
    ----------
    .. [1] H. Sakoe, S. Chiba, "Dynamic programming algorithm optimization for spoken word recognition", IEEE
       Transactions on Acoustics, Speech, and Signal Processing 26(1), 1978, :doi:`10.1109/TASSP.1978.1163055`.
    .. [2] M. Müller, "Information retrieval for music and motion", Springer, 2007, sec. 4,
       :doi:`10.1007/978-3-540-74048-3`, for "subsequence".

    Examples
    --------
    A swing of the arm, the same one at half the speed, and one that goes half as far:

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
    """Refuse a metric under which windows of long motions cannot be looked for."""
    if isinstance(metric, MotionMetric) and not metric.of_windows:
        raise ValueError(
            f"the metric {metric.label!r} is of whole motions: the mean of a window is not known before the window is "
            'found. Take "position" or "velocity", or cut the recording and pass the parts to motion_distances'
        )


def check_alignment(alignment: str, window: float | None, metric: Metric, **given: Sequences) -> None:
    """Refuse a window where there is no band, and different lengths where frames are compared one by one."""
    if alignment == "subsequence":
        check_of_windows(metric)
    if window is not None and alignment != "dtw":
        raise ValueError(f'window is the band of alignment="dtw", got window={window} with alignment="{alignment}"')
    if alignment != "frames":
        return
    lengths = {f"{name}[{i}]": int(n) for name, one in given.items() for i, n in enumerate(one.lengths)}
    first, *others = lengths
    for other in others:
        if lengths[other] != lengths[first]:
            raise ValueError(
                f'alignment="frames" compares motions of equal length, but {first} has {lengths[first]} frames and '
                f'{other} {lengths[other]}: resample them, or take alignment="dtw"'
            )
