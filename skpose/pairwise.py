"""Matrices of distances between poses."""

import functools
import warnings
from collections.abc import Callable, Iterator, Sequence
from numbers import Integral

import numpy as np
from joblib import effective_n_jobs
from numpy.typing import ArrayLike
from sklearn.exceptions import ConvergenceWarning
from sklearn.utils._param_validation import validate_params

from skpose import _loops
from skpose._kernels import Steps
from skpose._threads import in_threads
from skpose._tree import tree_of
from skpose._validation import check_poses
from skpose.metrics import METRIC_CONSTRAINTS, Metric, resolve
from skpose.skeleton import Skeleton

PANEL = 4096  # poses that are encoded at once
TASKS_PER_JOB = 4  # enough that no thread waits long for the last; each costs 0.25 ms
MIRROR_BLOCK = 512


@validate_params(
    METRIC_CONSTRAINTS | {"n_jobs": [None, Integral], "out": [np.ndarray, None]}, prefer_skip_nested_validation=True
)
def pose_distances(
    X: ArrayLike,
    Y: ArrayLike | None = None,
    *,
    skeleton: Skeleton | None = None,
    metric: str = "auto",
    n_steps: int = 10,
    wrap: bool | str = "auto",
    n_jobs: int | None = None,
    out: np.ndarray | None = None,
) -> np.ndarray:
    r"""Distances between all poses of X and all poses of Y.

    ============== ===================================================================================== =========
    ``metric``     distance between poses a and b                                                        unit
    ============== ===================================================================================== =========
    ``"angle"``    :math:`\|a - b\|_2` (eq. 1); needs no skeleton                                        rad
    ``"position"`` :math:`\|F(a) - F(b)\|_2`, with F(θ) the joint positions (sec. 2)                     m
    ``"rotation"`` :math:`\sqrt{\sum_b \ell_b^2 \varphi_b^2}`, with φ the angle between the world        m
                   orientations of bone b in the two poses and ℓ its length (sec. 1.1)
    ``"spatial"``  length of the curve that the joints trace as the angles go from a to b in a straight  m
                   line, :math:`\sum_n \|F(c_n) - F(c_{n-1})\|` (sec. 2.2)
    ``"geodesic"`` length of the shortest curve that the joints can trace from a to b (eq. 3), see            m
                   `skpose.geodesic`
    ============== ===================================================================================== =========

    Parameters
    ----------
    X : array-like of shape (n_x, n_dofs)
        Poses: joint angles, rad. With a skeleton, one column per name in ``skeleton.dof_names``; a data frame's
        columns are held to these names.
    Y : array-like of shape (n_y, n_dofs), default=None
        Other poses; None is X, of which one triangle is then computed.
    skeleton : Skeleton, default=None
        The body that all the poses are put on; `Skeleton.mean` makes one of several. Needed by all but "angle".
    metric : {"auto", "angle", "position", "rotation", "spatial", "geodesic"}, default="auto"
        "auto" is "spatial" with a skeleton and "angle" without one.
    n_steps : int, default=10
        Chords along the curve of "spatial" and "geodesic"; the paper's ten. With one, both are "position".
    wrap : bool or "auto", default="auto"
        Whether each difference of angles goes the short way round, in [−π, π], so that a file's jump by 360° is no
        movement. "auto" does so for "spatial" and "geodesic" and takes "angle" literally; the others cannot tell.
    n_jobs : int, default=None
        Threads; None is 1 unless in a ``joblib.parallel_config`` context, -1 all processors. The result does not
        depend on it.
    out : ndarray of shape (n_x, n_y), default=None
        Where to put the result, such as a ``numpy.memmap``; of the result's dtype.

    Returns
    -------
    ndarray of shape (n_x, n_y)
        The distances; float32 where all poses are, computed in float32 (but for "geodesic"), else float64. Without Y
        exactly symmetric, with an exactly zero diagonal. Equal poses are at distance zero also between X and Y.

    Warns
    -----
    ConvergenceWarning
        If geodesics did not converge; it says how many.

    Raises
    ------
    ValueError
        For poses of the wrong width, out of order by column name, or not finite; for a metric that needs a skeleton
        and got none; for an `out` that does not fit.

    See Also
    --------
    geodesic : One geodesic, with its path.
    pose_metric : The same as a function of two poses.
    PoseDistanceTransformer : The same as a step of a scikit-learn pipeline.

    Notes
    -----
    "position" ≤ "geodesic" ≤ "spatial": a chord is no longer than a curve, and the geodesic is the shortest one.
    Neither "spatial" nor, as it is a local minimum and measured by chords, "geodesic" need obey the triangle
    inequality. F does not see a twist about a bone that ends the chain, so all but "angle" are pseudo-metrics.

    Time O(n_x · n_y · n_dofs), for "spatial" times n_steps; no sine or cosine is computed per pair. "geodesic" takes
    some milliseconds a pair, and a hundred for poses very far apart; pairs whose chord and straight line agree to 1e-6
    are not solved. Memory beyond the result: the codes of some panels of 4096 poses, 12 MB each for "spatial" and 56
    dofs.

    References
    ----------
    .. [1] S. Hauberg, K. S. Pedersen, "Spatial measures between human poses for classification and understanding",
       AMDO 2012, :doi:`10.1007/978-3-642-31567-1_3`.
    .. [2] M. Tournier, X. Wu, N. Courty, E. Arnaud, L. Revéret, "Motion compression using principal geodesics
       analysis", Computer Graphics Forum 28(2), 2009, :doi:`10.1111/j.1467-8659.2009.01375.x`.

    Examples
    --------
    >>> import numpy as np
    >>> from skpose import Skeleton, pose_distances
    >>> X = np.array([[0.0, 0.0], [np.pi / 2, 0.0], [0.0, np.pi / 2]])
    >>> pose_distances(X, metric="angle").round(3)
    array([[0.   , 1.571, 1.571],
           [1.571, 0.   , 2.221],
           [1.571, 2.221, 0.   ]])

    The first joint of an arm of two bones moves both, the second only the outer one:

    >>> pose_distances(X, skeleton=Skeleton.chain(2)).round(3)
    array([[0.   , 3.509, 1.569],
           [3.509, 0.   , 2.219],
           [1.569, 2.219, 0.   ]])
    """
    chosen, steps = resolve(metric, skeleton, n_steps, wrap)
    triangle = Y is None or Y is X
    X = check_poses(X, skeleton, "X")
    Y = X if triangle else check_poses(Y, skeleton, "Y")
    if X.shape[1] != Y.shape[1]:
        raise ValueError(f"X has {X.shape[1]} columns and Y has {Y.shape[1]}; poses of one body have equally many")
    dtype = np.result_type(X, Y)
    result = _result(out, (len(X), len(Y)), dtype)
    if chosen.always_float64:
        dtype = np.dtype(np.float64)
    distances = result if result.dtype == dtype else np.empty(result.shape, dtype)
    tasks = _tasks(X, None if triangle else Y, chosen, skeleton, steps, distances, effective_n_jobs(n_jobs))
    doubts = in_threads(tasks, effective_n_jobs(n_jobs))
    warn_of_doubts(doubts, len(X) * (len(X) - 1) // 2 if triangle else distances.size, stacklevel=3)
    if triangle:
        _mirror(distances)
    if distances is not result:
        result[...] = distances
    return result if out is None else out


def warn_of_doubts(doubts: Sequence[tuple[int, float]], n_pairs: int, stacklevel: int) -> None:
    """Warn where geodesics did not converge; how many in each task, and the largest gap in it."""
    n_doubtful = sum(n for n, _ in doubts)
    if n_doubtful:
        warnings.warn(
            f"{n_doubtful} of {n_pairs} geodesics did not converge; their distances are lengths of curves no "
            "longer than the straight line in angle space, which may not be the shortest. The largest relative gap "
            f"between such a curve's length and the sum of its chords is {max(gap for _, gap in doubts):.2g}",
            ConvergenceWarning,
            stacklevel=stacklevel,
        )


def _result(out: np.ndarray | None, shape: tuple[int, int], dtype: np.dtype) -> np.ndarray:
    """The array to write into: a new one, or the user's as a plain ndarray."""
    if out is None:
        return np.empty(shape, dtype)
    if out.shape != shape or out.dtype != dtype or not out.flags.writeable or not out.flags.aligned:
        state = "" if out.flags.writeable else ", read-only"
        raise ValueError(f"out must be a writeable {dtype} array of shape {shape}, got {out.dtype} {out.shape}{state}")
    return np.asarray(out)


def _tasks(
    X: np.ndarray,
    Y: np.ndarray | None,
    metric: Metric,
    skeleton: Skeleton | None,
    steps: Steps,
    distances: np.ndarray,
    n_jobs: int,
) -> Iterator[Callable[[], tuple[int, float]]]:
    """Tiles of the matrix, or of its upper triangle, as functions to call.

    Poses are encoded a panel at a time, when its first tile is asked for, so that no more codes than a few panels' are
    ever held.
    """
    dtype = distances.dtype
    tree, loop = tree_of(skeleton if metric.needs_skeleton else None, dtype), _loops.pair_distances_loop(dtype)

    def encoded(poses: np.ndarray) -> np.ndarray:
        return metric.encoded(poses, skeleton, steps).astype(dtype, copy=False)

    pairs_per_task = metric.pairs_per_task
    if n_jobs > 1:
        pairs_per_task = min(pairs_per_task, max(1, distances.size // (TASKS_PER_JOB * n_jobs)))
    for x in range(0, len(X), PANEL):
        rows = encoded(X[x : x + PANEL])
        for y in range(x if Y is None else 0, distances.shape[1], PANEL):
            diagonal = Y is None and x == y
            columns = rows if diagonal else encoded((X if Y is None else Y)[y : y + PANEL])
            blocks, panel = _loops.in_lanes(columns), distances[x : x + PANEL, y : y + PANEL]
            for tile in _tiles(len(rows), len(blocks) // rows.shape[1], blocks.shape[1], diagonal, pairs_per_task):
                yield functools.partial(loop, rows, blocks, *tile, diagonal, metric.measure, tree, steps, panel)


def _tiles(
    n_rows: int, n_blocks: int, width: int, triangle: bool, pairs_per_task: int
) -> Iterator[tuple[int, int, int, int]]:
    """First and last row, first and last block of tiles of no more than so many pairs each."""
    block_step = min(n_blocks, max(1, pairs_per_task // width))
    row_step = max(1, pairs_per_task // (block_step * width))
    for first in range(0, n_rows, row_step):
        last = min(first + row_step, n_rows)
        for block in range(first // width if triangle else 0, n_blocks, block_step):
            yield first, last, block, min(block + block_step, n_blocks)


def _mirror(distances: np.ndarray) -> None:
    """Copy the upper triangle into the lower one, by blocks for the cache's sake, and clear the diagonal."""
    n = len(distances)
    for start in range(0, n, MIRROR_BLOCK):
        stop = min(start + MIRROR_BLOCK, n)
        distances[stop:, start:stop] = distances[start:stop, stop:].T
        block = distances[start:stop, start:stop]
        block[...] = np.triu(block, 1) + np.triu(block, 1).T
