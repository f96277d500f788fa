"""Distances between whole motions."""

import functools
from collections.abc import Callable, Iterator
from numbers import Integral, Real
from typing import Any

import numpy as np

from skpose._compiled.pose import loops
from skpose._compiled.warping.paths import Encoded, MotionPairs, Paths, warp_pairs
from skpose._utils.parallel import LITTLE_WORK, TASKS_PER_JOB, WORK_PER_TASK, in_threads
from skpose._utils.sklearn import Interval, StrOptions, validate_params
from skpose._utils.units import warn_of_degrees
from skpose.metrics import Metric
from skpose.metrics._matrix import (
    ENCODED_AT_ONCE,
    DistanceMatrix,
    Tile,
    TiledMatrix,
    Unconverged,
    mirror,
    warn_of_unconverged,
)
from skpose.metrics._motion_metrics import MotionMetric
from skpose.metrics._registry import METRIC_CONSTRAINTS, OF_MOTIONS, OUT, resolve, warn_of_no_skeleton
from skpose.motions._inputs import Sequences, check_motions
from skpose.skeleton import Skeleton

ALIGNMENTS = ("dtw", "subsequence", "frames")
WORK_PER_CELL = 6.0  # of the recursion, added to the work of the distance


class MotionMatrix(TiledMatrix):
    """The distances between motions X and motions Y, where Y=None is X.

    See `motion_distances` for `alignment` and `window`; `normalize` divides by the number of frames.
    """

    smallest_edge = 1

    def __init__(
        self,
        X: Sequences,
        Y: Sequences | None,
        metric: Metric,
        skeleton: Skeleton | None,
        *,
        alignment: str = "dtw",
        window: float | None = None,
        normalize: bool = True,
    ):
        self.X, self.Y, self.metric = X, Y, metric
        self.columns = X if Y is None else Y
        self.alignment, self.normalize = alignment, normalize
        self.paths = Paths.of(window, alignment == "subsequence")
        self.skeleton = skeleton if metric.needs_skeleton else None
        self.work_per_cell = work_per_cell(metric, self.skeleton, X)
        self.result_dtype = np.result_type(X.poses, self.columns.poses)
        self.dtype = np.dtype(np.float64) if metric.iterative else self.result_dtype
        self.shape = X.n_motions, self.columns.n_motions
        self.symmetric = Y is None and alignment != "subsequence"

    @property
    def n_cells(self) -> int:
        """The number of pairs of frames, in one triangle if symmetric."""
        if self.alignment == "frames":
            return len(self.X.poses) // self.X.n_motions * self.n_pairs
        n_frames = len(self.X.poses)
        if self.symmetric:
            return (n_frames * n_frames - int((self.X.lengths**2).sum())) // 2
        return n_frames * len(self.columns.poses)

    @property
    def work_per_pair(self) -> float:
        work = self.work_per_cell * share_of_band(self.paths.window) * self.n_cells
        return max(1.0, work / max(1, self.n_pairs))

    @property
    def largest_edge(self) -> int:
        """About as many motions as have ENCODED_AT_ONCE frames; a power of two."""
        longest = max(self.X.lengths.mean(), self.columns.lengths.mean())
        return 2 ** int(np.log2(max(1.0, ENCODED_AT_ONCE / longest)))

    def distances(self, tile: Tile, n_jobs: int = 1, out: np.ndarray | None = None) -> tuple[np.ndarray, Unconverged]:
        rows, columns = (
            motions.slice(part.start, part.stop) for motions, part in zip((self.X, self.columns), tile, strict=True)
        )
        diagonal = self.symmetric and tile[0].start == tile[1].start
        if self.alignment == "frames":
            sums, unconverged = self._sums_of_frames(rows, None if diagonal else columns, n_jobs)
        else:
            sums = np.zeros((rows.n_motions, columns.n_motions))
            unconverged = Unconverged.join(in_threads(self._tasks(rows, columns, diagonal, n_jobs, sums), n_jobs))
        if diagonal:
            mirror(sums, n_jobs)
        if self.normalize:
            n = rows.lengths[:, np.newaxis]
            sums /= n + columns.lengths if self.alignment == "dtw" else n
        if out is None:
            return sums.astype(self.dtype, copy=False), unconverged
        out[...] = sums
        return out, unconverged

    def _sums_of_frames(
        self, rows: Sequences, columns: Sequences | None, n_jobs: int
    ) -> tuple[np.ndarray, Unconverged]:
        """Sums of the distances between frames i of both motions, all of equal length."""
        n_rows, n_columns = rows.n_motions, (rows if columns is None else columns).n_motions
        sums, parts = np.zeros((n_rows, n_columns)), []
        X = rows.poses.reshape(n_rows, -1, rows.poses.shape[1])
        Y = None if columns is None else columns.poses.reshape(n_columns, -1, X.shape[2])
        for frame in range(X.shape[1]):
            poses = np.ascontiguousarray(X[:, frame]), None if Y is None else np.ascontiguousarray(Y[:, frame])
            matrix = DistanceMatrix(*poses, self.metric, self.skeleton)
            distances, unconverged = matrix.distances((slice(0, n_rows), slice(0, n_columns)), n_jobs)
            sums += distances
            parts.append(unconverged)
        return sums, Unconverged.join(parts)

    def _tasks(
        self, rows: Sequences, columns: Sequences, diagonal: bool, n_jobs: int, sums: np.ndarray
    ) -> Iterator[Callable[[], tuple[int, float]]]:
        metric, tree = self.metric, self.metric.tree_for(self.skeleton, self.dtype)
        X = self._encode(rows.poses)
        Y = loops.in_lanes(X if diagonal else self._encode(columns.poses))
        work = WORK_PER_TASK
        if n_jobs > 1:
            whole = len(rows.poses) * len(columns.poses) * self.work_per_cell
            work = min(work, max(LITTLE_WORK, whole / (TASKS_PER_JOB * n_jobs)))
        for pairs in motion_pairs(rows.lengths, columns.lengths, diagonal, work / self.work_per_cell):
            x, y = Encoded(X, rows.starts), Encoded(Y, columns.starts)
            yield functools.partial(warp_pairs, x, y, pairs, self.paths, metric.measure, tree, metric.steps, sums)

    def _encode(self, poses: np.ndarray) -> np.ndarray:
        return self.metric.encode_poses(poses, self.skeleton).astype(self.dtype, copy=False)


def work_per_cell(metric: Metric, skeleton: Skeleton | None, motions: Sequences) -> float:
    """The work of a pair of frames, in the unit of `skpose._utils.parallel`."""
    return WORK_PER_CELL + metric.n_codes(metric.tree_for(skeleton), motions.poses.shape[1]) * metric.measure_work


def share_of_band(window: float | None) -> float:
    """The share of all pairs of frames inside the band, for long motions."""
    w = 1.0 if window is None else min(1.0, window)
    return max(0.01, w * (2.0 - w))


def motion_pairs(n: np.ndarray, m: np.ndarray, triangle: bool, most_cells: float) -> Iterator[MotionPairs]:
    """Yield ranges of rows and columns of at most `most_cells` cells, or of one pair; n and m are numbers of frames."""
    starts_n, starts_m = (np.concatenate([[0], np.cumsum(numbers)]) for numbers in (n, m))

    def end_of(starts: np.ndarray, start: int, most: float) -> int:
        return max(start + 1, int(np.searchsorted(starts, starts[start] + most, side="right")) - 1)

    first = 0
    while first < len(n):
        left = first + 1 if triangle else 0
        last = end_of(starts_n, first, most_cells / max(1, starts_m[-1] - starts_m[left]))
        while left < len(m):
            right = end_of(starts_m, left, most_cells / (starts_n[last] - starts_n[first]))
            yield MotionPairs(first, last, left, right, triangle)
            left = right
        first = last


# --- distances --------------------------------------------------------------------------------------------------------


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
