"""Matrices of distances between poses: the public functions and their arguments.

`_pairwise` checks the arguments, `_matrix` computes tiles, `_output` has them written; `_dask` does the first two
lazily.
"""

from collections.abc import Callable, Iterator
from numbers import Integral, Real
from typing import Any

import numpy as np
from sklearn import get_config
from sklearn.utils import gen_batches

from skpose._compat.sklearn import Interval, validate_params
from skpose._parallel.progress import progress
from skpose._typing import ArrayLike
from skpose._validation.poses import check_poses, check_same_width
from skpose._validation.units import warn_of_degrees
from skpose.metrics._convergence import warn_of_unconverged
from skpose.metrics._dask import is_lazy, lazy_distances
from skpose.metrics._matrix import DistanceMatrix
from skpose.metrics._metric import Metric
from skpose.metrics._registry import METRIC_CONSTRAINTS, OUT, resolve, warn_of_no_skeleton
from skpose.skeleton import Skeleton

CONSTRAINTS = METRIC_CONSTRAINTS | {"n_jobs": [None, Integral], "verbose": ["verbose"]}


@validate_params(CONSTRAINTS | {"out": OUT}, prefer_skip_nested_validation=True)
def pose_distances(
    X: ArrayLike,
    Y: ArrayLike | None = None,
    *,
    skeleton: Skeleton | None = None,
    metric: str | Metric = "auto",
    n_jobs: int | None = None,
    out: Any = None,
    verbose: int = 0,
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
        Poses: joint angles, and rotation vectors of ball joints, rad. With a skeleton, one column per name in
        ``skeleton.dof_names``; the columns of a data frame must have these names.
    Y : array-like of shape (n_y, n_dofs), default=None
        Other poses; None is X, of which one triangle is then computed.
    skeleton : Skeleton, default=None
        The skeleton of all poses; `Skeleton.mean` makes one of several. Needed by all but "angle".
    metric : str or Metric, default="auto"
        A metric of `skpose.metrics` with its parameters, such as ``Spatial(n_steps=20)``, or its name, "angle",
        "position", "rotation", "spatial" or "geodesic", for that with the defaults. "auto" is "spatial" with a
        skeleton, else "angle" and a warning.
    n_jobs : int, default=None
        Threads; None is 1 unless in a ``joblib.parallel_config`` context, -1 all processors. Where that context names
        a backend of processes or a cluster ("loky", "dask", "ray"), tiles are computed there. The result does not
        depend on it.
    out : array of shape (n_x, n_y), default=None
        Array for the result, of its dtype: an ndarray, a ``numpy.memmap``, a zarr array. If writing into a whole
        memmap or a zarr array is interrupted, the same call continues it. Workers write into these themselves, see
        Notes.
    verbose : int, default=0
        Whether to show the progress: a bar where rich is installed, else some lines on stderr.

    Returns
    -------
    ndarray of shape (n_x, n_y)
        The distances, or `out`; float32 where all poses are, computed in float32 (but for "geodesic"), else float64.
        float32 has an absolute error, see Notes.
        Without Y exactly symmetric, with an exactly zero diagonal. Equal poses are at distance zero also between X and
        Y.

    Raises
    ------
    ValueError
        For poses of the wrong width, out of order by column name, or not finite; for a metric that needs a skeleton
        and got none; for an `out` of another shape or dtype, that holds the beginning of other distances, or whose
        file was moved or deleted after it was opened.
    RuntimeError
        If joblib's workers die, or fail, several times in a row; if another process or thread writes into `out`,
        or something else changes it meanwhile.
    OSError
        If the file of `out` cannot be written, for example as the disk is full.

    Warns
    -----
    ConvergenceWarning
        If geodesics did not converge, with their number.
    UserWarning
        If `metric` is "auto" and there is no skeleton, so that the distances are those of "angle", in rad.
        If a skeleton is given and the angles look like degrees: 15 % of the columns go beyond three whole turns. Angles
        may leave [−π, π] by some turns, as those of recordings do that are continuous in time. Those in a
        ``dask.array`` are not looked at.
        If workers cannot write into `out`: they do not see its file, two of them would share a chunk of zarr's, or
        two computers a file on NFS.

    See Also
    --------
    geodesic : One geodesic, with its path.
    pose_distances_chunked : The same chunk by chunk.
    pose_metric : The same as a function of two poses.
    PoseDistanceTransformer : The same as a step of a scikit-learn pipeline.

    Notes
    -----
    Distances in float32 have an absolute error, for near poses as for far ones: for "position" and "rotation" less than
    1e-6 S, with S = √Σ w r² over the joints, r the length of the bones from the root to a joint, m, and w its weight;
    for "spatial" 1 + n_steps/2 times as much; for "angle" 1e-6 times the norm of the longer row, rad. For a person of
    22 joints S is 4.6 m: the error is below 5e-6 m, and 3e-5 m for "spatial" with ten steps. Smaller distances mean
    nothing; pass such poses as float64.

    "position" ≤ "geodesic" ≤ "spatial": a chord is no longer than a curve, and the geodesic is the shortest one.
    Neither "spatial" nor "geodesic", which is a local minimum and measured by chords, need obey the triangle
    inequality. F does not depend on a twist about a bone that ends the chain, so all but "angle" are pseudo-metrics.

    Time O(n_x · n_y · n_dofs), for "spatial" times n_steps; no sine or cosine is computed per pair. "geodesic" takes
    some milliseconds a pair, and a hundred for poses very far apart; pairs whose chord and straight line agree to 1e-6
    are not solved. Memory beyond the poses and the result: the codes of some 4096 poses at a time, 12 MB for "spatial"
    and 56 dofs, a few times. A file that is written does not stay resident, except for two or three tiles of 4096 by
    4096: less than 0.5 GB for a matrix of any size. Workers hold the poses and a tile or two of 32 MB, and this
    process, where they do not write themselves, no more than four such tiles per worker.

    A matrix in a file is written tile by tile. When the disk has a tile, it is noted with the checksum of its bytes:
    for a memmap in a file of the same name with ".progress" at the end, for a zarr array in a folder in the file
    "skpose.progress" there, for one elsewhere among its attributes. The same call on the array, opened again with mode
    "r+", computes only the tiles that are not noted or whose bytes have another checksum. The notes are removed when
    the matrix is complete.

    Workers of joblib's backends write tiles into the file or the folder of `out` themselves, if they see it under the
    same path. They recognise it by a token in the file of the lock (".lock", "skpose.lock"), which excludes all other
    calls on the same `out` and ends with the process. If they do not see it, or if tiles cannot be made of whole
    chunks, this process writes, after a warning. Other stores of zarr's, parts of a memmap and plain arrays are
    written by this process, and have no lock.

    Poses in a ``dask.array`` give a lazy ``dask.array`` of distances, computed where dask computes. It takes no `out`
    and ignores `n_jobs` and `verbose`, and its warnings appear where it is computed.

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
    chosen = resolve(metric, skeleton)
    if is_lazy(X) or is_lazy(Y):
        if out is not None:
            raise ValueError(
                "out is for distances that are computed at once; store those of a dask array with da.store"
            )
        lazy = lazy_distances(X, Y, skeleton, chosen)
        warn_of_no_skeleton(metric, skeleton)
        return lazy
    matrix = DistanceMatrix(*_check(X, Y, skeleton), chosen, skeleton)
    warn_of_no_skeleton(metric, skeleton)
    distances, unconverged = matrix.write(out, n_jobs, verbose)
    warn_of_unconverged(unconverged, matrix.n_pairs)
    return distances


@validate_params(
    CONSTRAINTS
    | {"reduce_func": [callable, None], "working_memory": [Interval(Real, 0, None, closed="neither"), None]},
    prefer_skip_nested_validation=True,
)
def pose_distances_chunked(
    X: ArrayLike,
    Y: ArrayLike | None = None,
    *,
    reduce_func: Callable[[np.ndarray, int], Any] | None = None,
    skeleton: Skeleton | None = None,
    metric: str | Metric = "auto",
    n_jobs: int | None = None,
    working_memory: float | None = None,
    verbose: int = 0,
) -> Iterator[Any]:
    """Distances chunk by chunk, each chunk of rows as large as memory allows, with an optional reduction.

    What scikit-learn's ``pairwise_distances_chunked`` is for its distances.

    Parameters
    ----------
    X : array-like of shape (n_x, n_dofs)
        Poses: joint angles, rad, as for `pose_distances`.
    Y : array-like of shape (n_y, n_dofs), default=None
        Other poses; None is X.
    reduce_func : callable, default=None
        Called as ``reduce_func(D_chunk, start)`` with a chunk of shape (n_chunk, n_y), which it may change, and the
        index of its first row in X. It returns an array, a list or a sparse matrix of length n_chunk, a tuple of
        these, or None where it keeps its result elsewhere. None gives the chunks themselves.
    skeleton : Skeleton, default=None
        The skeleton of all poses. Needed by all but "angle".
    metric : str or Metric, default="auto"
        The distance, see `pose_distances`; "auto" is "spatial" with a skeleton, else "angle" and a warning.
    n_jobs : int, default=None
        Threads, or workers of a ``joblib.parallel_config`` context, see `pose_distances`.
    working_memory : float, default=None
        Memory for a chunk, MiB; at least one row. None takes scikit-learn's ``working_memory``, 1 GiB unless set.
    verbose : int, default=0
        Whether to show the progress.

    Yields
    ------
    D_chunk : ndarray, sparse matrix, list or tuple
        A chunk of distances, or the result of `reduce_func`, None too.

    Raises
    ------
    ValueError
        As `pose_distances`; and if `reduce_func` returns something of another length.
    TypeError
        If `reduce_func` returns something without a length.

    See Also
    --------
    pose_distances : All at once, also into a file.
    PoseKNeighborsTransformer : Nearest neighbours without most of the distances.

    Notes
    -----
    Each chunk has whole rows, so that without Y each pair is computed twice, once from either end; under "spatial" the
    two may differ in the last bits. Time as of `pose_distances`, memory `working_memory` and the codes of some
    4096 poses at a time.

    Examples
    --------
    The medoid of a motion, without its matrix:

    >>> import numpy as np
    >>> from skpose import Skeleton, pose_distances_chunked
    >>> swing = np.linspace([0.0, 0.0], [1.0, 0.0], 101)
    >>> sums = pose_distances_chunked(
    ...     swing, skeleton=Skeleton.chain(2), reduce_func=lambda chunk, start: chunk.sum(axis=1), working_memory=0.01
    ... )
    >>> int(np.concatenate(list(sums)).argmin())
    50
    """
    chosen = resolve(metric, skeleton)
    X, Y = _check(X, Y, skeleton)
    warn_of_no_skeleton(metric, skeleton)
    complete = DistanceMatrix(X, Y, chosen, skeleton)
    n_rows, n_columns = complete.shape
    memory = get_config()["working_memory"] if working_memory is None else working_memory
    n_fitting = max(1, int(memory * 2**20 / (complete.result_dtype.itemsize * n_columns)))
    batches = list(gen_batches(n_rows, min(n_rows, n_fitting)))
    unconverged = []
    with progress(str(complete), len(batches), verbose) as advance:
        for batch in batches:
            matrix = DistanceMatrix(X[batch], X if Y is None else Y, chosen, skeleton)
            chunk, parts = matrix.write(None, n_jobs)
            unconverged += parts
            yield chunk if reduce_func is None else _reduce(reduce_func, chunk, batch.start)
            advance()
    warn_of_unconverged(unconverged, n_rows * n_columns)


def _check(X: ArrayLike, Y: ArrayLike | None, skeleton: Skeleton | None) -> tuple[np.ndarray, np.ndarray | None]:
    """Return the poses as arrays; Y is None where it is X."""
    if Y is X:
        Y = None
    X = check_poses(X, skeleton, "X")
    if Y is not None:
        Y = check_poses(Y, skeleton, "Y")
        check_same_width(X, Y)
    if skeleton is not None:
        warn_of_degrees(None, skeleton, X=X, Y=Y)
    return X, Y


def _reduce(reduce_func: Callable[[np.ndarray, int], Any], chunk: np.ndarray, start: int) -> Any:
    """Return what the user's function returns for a chunk, whose length it must have."""
    n_rows = len(chunk)
    result = reduce_func(chunk, start)
    if result is None:  # nothing to keep; the chunk itself would pass for a result where a return was forgotten
        return None
    for part in result if isinstance(result, tuple) else (result,):
        if not hasattr(part, "__len__") and not hasattr(part, "shape"):
            raise TypeError(
                "reduce_func must return a sequence, an array or a sparse matrix with one entry for each row of the "
                f"chunk, or a tuple of these, got {part!r}"
            )
        length = part.shape[0] if hasattr(part, "shape") else len(part)
        if length != n_rows:
            raise ValueError(
                f"reduce_func returned {length} entries for a chunk of {n_rows} rows that starts at row {start}; it "
                "must return one for each row"
            )
    return result
