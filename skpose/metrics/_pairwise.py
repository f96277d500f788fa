"""Matrices of distances between poses: the public functions and their arguments."""

from collections.abc import Callable, Iterator
from numbers import Integral, Real
from typing import Any

import numpy as np
from sklearn import get_config
from sklearn.utils import gen_batches

from skpose._utils.progress import progress
from skpose._utils.sklearn import Interval, check_chunk_size, validate_params
from skpose._utils.typing import ArrayLike
from skpose._utils.units import warn_of_degrees
from skpose._utils.validation import check_poses, check_same_width
from skpose.kinematics._arrays import array_distances, namespace_of
from skpose.metrics._matrix import DistanceMatrix, is_lazy, lazy_distances, warn_of_unconverged
from skpose.metrics._metric import Metric, require_skeleton
from skpose.metrics._position import Position
from skpose.metrics._registry import METRIC_CONSTRAINTS, OUT, resolve, warn_of_no_skeleton
from skpose.metrics._rotation import Rotation
from skpose.metrics._spatial import Spatial
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
        ``skeleton.dof_names``; a dataframe must have these columns in this order.
    Y : array-like of shape (n_y, n_dofs), default=None
        Other poses. None is X; each pair is then computed once.
    skeleton : Skeleton, default=None
        The skeleton of all poses; `Skeleton.mean` makes one of several. Needed by all metrics except "angle".
    metric : str or Metric, default="auto"
        A metric of `skpose.metrics` with its parameters, such as ``Spatial(n_steps=20)``, or the name of one with its
        defaults: "angle", "position", "rotation", "spatial" or "geodesic". "auto" is "spatial" with a skeleton, else
        "angle" and a warning.
    n_jobs : int, default=None
        Threads; None is 1 unless in a ``joblib.parallel_config`` context, -1 all processors. If that context names a
        backend of processes or a cluster ("loky", "dask", "ray"), tiles are computed there. The result does not depend
        on it.
    out : array of shape (n_x, n_y), default=None
        Array for the result, of the dtype of the result: an ndarray, ``numpy.memmap``, h5py dataset, zarr array, or any
        other object that supports ``out[i:j, k:l] = block``. Each tile is written once it is computed.
    verbose : int, default=0
        Whether to show the progress, as some lines on stderr.

    Returns
    -------
    ndarray of shape (n_x, n_y)
        The distances, or `out`. The dtype is float32 if all poses are float32, and computations are in float32 then
        except for "geodesic"; else float64. Without Y, exactly symmetric with a zero diagonal. Equal poses are at
        distance zero also between X and Y.

    Raises
    ------
    ValueError
        For poses that are not finite or do not fit the skeleton; for a metric that needs a skeleton and got none; for
        `out` of another shape or dtype.

    Warns
    -----
    ConvergenceWarning
        If geodesics did not converge, with their number.
    UserWarning
        If `metric` is "auto" and there is no skeleton. If there is a skeleton and the angles look like degrees: 15 % of
        the columns exceed three whole turns. A ``dask.array`` is not checked for that.

    See Also
    --------
    geodesic : One geodesic, with its path.
    pose_distances_chunked : The same chunk by chunk.
    pose_metric : The same as a function of two poses.
    PoseDistanceTransformer : The same as a step of a scikit-learn pipeline.

    Notes
    -----
    float32 has an absolute error: for "position" and "rotation" less than 1e-6 S, with S = √Σ w r² over the joints, r
    the length of the bones from the root to a joint, m, and w its weight; for "spatial" 1 + n_steps/2 times as much;
    for "angle" 1e-6 times the norm of the longer row, rad. A person of 22 joints has S = 4.6 m, so the error is below
    5e-6 m, and 3e-5 m for "spatial" with ten steps. For smaller distances, pass float64.

    "position" ≤ "geodesic" ≤ "spatial": a chord is no longer than a curve, and the geodesic is the shortest curve.
    "spatial" and "geodesic", which is a local minimum, need not obey the triangle inequality. F does not depend on a
    twist about a bone at the end of a chain, so all metrics except "angle" are pseudo-metrics.

    Time O(n_x · n_y · n_dofs), for "spatial" times n_steps; no sine or cosine is computed per pair. "geodesic" takes
    some milliseconds per pair, and up to 0.1 s for poses very far apart; pairs whose chord and straight line agree to
    1e-6 are not solved. Memory in addition to the poses and the result: a few times the codes of 4096 poses, which are
    12 MB for "spatial" and 56 dofs. Other arrays than ndarrays are written from tiles of at most 128 MB.

    Poses in a ``dask.array`` give a lazy ``dask.array`` of distances, computed where dask computes. It takes no `out`
    and ignores `n_jobs` and `verbose`, and its warnings appear where it is computed.

    Poses in arrays of torch, JAX, CuPy or another library of the array API standard give distances in an array of that
    library, on its device, in its precision and with gradients, under "position", "rotation" and "spatial". Their
    values are not checked, `n_jobs` and `verbose` are ignored, and there is no `out`.

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
            raise ValueError("out is not supported for dask arrays: use da.store")
        lazy = lazy_distances(X, Y, skeleton, chosen)
        warn_of_no_skeleton(metric, skeleton)
        return lazy
    xp = namespace_of(X, Y)
    if xp is not None:
        if out is not None:
            raise ValueError(f"out is not supported for arrays of {xp.__name__}")
        return _distances_of_arrays(xp, X, None if Y is X else Y, skeleton, chosen)
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
    """Distances chunk by chunk, with an optional reduction, like scikit-learn's ``pairwise_distances_chunked``.

    Parameters
    ----------
    X : array-like of shape (n_x, n_dofs)
        Poses: joint angles, rad, as for `pose_distances`.
    Y : array-like of shape (n_y, n_dofs), default=None
        Other poses; None is X.
    reduce_func : callable, default=None
        Called as ``reduce_func(D_chunk, start)`` with a chunk of shape (n_chunk, n_y), which it may change, and the
        index of its first row in X. It returns an array, a list or a sparse matrix of length n_chunk, a tuple of
        these, or None if it keeps its result elsewhere. None gives the chunks themselves.
    skeleton : Skeleton, default=None
        The skeleton of all poses. Needed by all metrics except "angle".
    metric : str or Metric, default="auto"
        The distance, see `pose_distances`; "auto" is "spatial" with a skeleton, else "angle" and a warning.
    n_jobs : int, default=None
        Threads, or workers of a ``joblib.parallel_config`` context, see `pose_distances`.
    working_memory : float, default=None
        Memory for a chunk, MiB; at least one row. None is scikit-learn's ``working_memory``, by default 1 GiB.
    verbose : int, default=0
        Whether to show the progress.

    Yields
    ------
    D_chunk : ndarray, sparse matrix, list or tuple
        A chunk of distances, or the result of `reduce_func`.

    Raises
    ------
    ValueError
        As `pose_distances`; if the length of a result of `reduce_func` is not n_chunk.
    TypeError
        If a result of `reduce_func` has no length.

    See Also
    --------
    pose_distances : All at once, also into a file.
    PoseKNeighborsTransformer : Nearest neighbours without most of the distances.

    Notes
    -----
    Chunks have whole rows, so without Y each pair is computed twice; under "spatial" the two results may differ in the
    last bits. Arrays of torch and others give such arrays, as in `pose_distances`. Time as for `pose_distances`; memory
    `working_memory`, and the codes of some 4096 poses.

    Examples
    --------
    The medoid of a motion, without its matrix:

    >>> import numpy as np
    >>> from skpose import Skeleton
    >>> from skpose.metrics import pose_distances_chunked
    >>> swing = np.linspace([0.0, 0.0], [1.0, 0.0], 101)
    >>> sums = pose_distances_chunked(
    ...     swing, skeleton=Skeleton.chain(2), reduce_func=lambda chunk, start: chunk.sum(axis=1), working_memory=0.01
    ... )
    >>> int(np.concatenate(list(sums)).argmin())
    50
    """
    chosen = resolve(metric, skeleton)
    xp = namespace_of(X, Y)
    arrays: tuple[Any, Any] = _check(X, Y, skeleton) if xp is None else (X, Y)
    warn_of_no_skeleton(metric, skeleton)
    rows, columns = arrays[0], arrays[0] if arrays[1] is None else arrays[1]
    memory = get_config()["working_memory"] if working_memory is None else working_memory
    itemsize = np.result_type(rows, columns).itemsize if xp is None else xp.finfo(columns.dtype).bits // 8
    n_rows, n_columns = rows.shape[0], columns.shape[0]
    n_fitting = max(1, int(memory * 2**20 / (itemsize * n_columns)))
    batches = list(gen_batches(n_rows, min(n_rows, n_fitting)))
    unconverged = []
    with progress(f"{n_rows:,} × {n_columns:,} distances", len(batches), verbose) as advance:
        for batch in batches:
            if xp is None:
                chunk, parts = DistanceMatrix(rows[batch], columns, chosen, skeleton).write(None, n_jobs)
                unconverged += parts
            else:
                chunk = _distances_of_arrays(xp, rows[batch, :], columns, skeleton, chosen)
            yield chunk if reduce_func is None else _reduce(reduce_func, chunk, batch.start)
            advance()
    warn_of_unconverged(unconverged, n_rows * n_columns)


def _distances_of_arrays(xp: Any, X: Any, Y: Any, skeleton: Skeleton | None, metric: Metric) -> Any:
    if type(metric) not in (Position, Rotation, Spatial):
        raise ValueError(f"arrays of {xp.__name__} need 'position', 'rotation' or 'spatial', got {metric.label!r}")
    memory = get_config()["working_memory"]
    return array_distances(xp, X, Y, require_skeleton(skeleton), metric.name, memory, **metric.get_params())


def _check(X: ArrayLike, Y: ArrayLike | None, skeleton: Skeleton | None) -> tuple[Any, Any]:
    """The poses as arrays; Y is None if it is X."""
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
    reduced = reduce_func(chunk, start)
    check_chunk_size(reduced, chunk.shape[0])
    return reduced
