"""A metric as one compiled function of two poses."""

import functools
from collections.abc import Callable

import numpy as np

from skpose._compat.sklearn import validate_params
from skpose._compiled.pose.pair import PairMetric, address_here, keep_metric, pair_distance
from skpose._compiled.simd.jit import of_this_process
from skpose._compiled.simd.lanes import empty_pairs
from skpose.metrics._metric import Metric
from skpose.metrics._registry import METRIC_CONSTRAINTS, resolve, warn_of_no_skeleton
from skpose.skeleton import Skeleton


@validate_params(METRIC_CONSTRAINTS, prefer_skip_nested_validation=True)
def pose_metric(
    skeleton: Skeleton | None = None, *, metric: str | Metric = "auto"
) -> Callable[[np.ndarray, np.ndarray], float]:
    """A metric as one function of two poses, compiled by numba.

    For a matrix of distances `skpose.pose_distances` is many times faster, since it does the work of a pose once and
    not once per pair. The function is for estimators that take a callable: ``KNeighborsClassifier(metric=f)``,
    ``pairwise_distances(metric=f)``, UMAP, pynndescent, and for one's own numba code, which can call it.

    Parameters
    ----------
    skeleton : Skeleton, default=None
        Needed by all but "angle".
    metric : str or Metric, default="auto"
        The distance, see `skpose.pose_distances`; "auto" is "spatial" with a skeleton, else "angle" and a warning. A
        "geodesic" that does not converge is the length of the best curve found, without a warning, which compiled code
        cannot give.

    Returns
    -------
    callable
        ``f(x, y) -> float`` on arrays of shape (n_dofs,), rad; a numba dispatcher that releases the GIL. The distance
        is in m, or in rad for "angle". It can be pickled and cloned; equal arguments give the same function.

    Raises
    ------
    ValueError
        For a metric that needs a skeleton and got none; and, when called, for poses of the wrong width.

    Warnings
    --------
    "spatial" and "geodesic" need not obey the triangle inequality, on which ball trees rely, and scikit-learn's
    ``algorithm="auto"`` picks a ball tree for a callable metric on 15 columns or fewer. Always pass
    ``algorithm="brute"``.

    Notes
    -----
    One function for all skeletons comes from numba's disk cache; what is compiled in every process takes a tenth of a
    second or two, once for each kind of rows (float32, strided). It holds an address of this process, so that numba
    does not cache a function of one's own that calls it. Each metric and skeleton takes a megabyte or so while the
    process lives. About 6 µs a pair of poses of 42 dofs through scikit-learn under "spatial" with ten steps, some
    milliseconds under "geodesic".

    References
    ----------
    S. Hauberg, K. S. Pedersen, "Spatial measures between human poses for classification and understanding", AMDO
    2012, :doi:`10.1007/978-3-642-31567-1_3`.

    Examples
    --------
    >>> import numpy as np
    >>> from sklearn.neighbors import KNeighborsClassifier
    >>> from skpose import Skeleton, pose_metric
    >>> arm = Skeleton.chain(2)
    >>> f = pose_metric(arm, metric="position")
    >>> round(f(np.array([0.0, 0.0]), np.array([np.pi, 0.0])), 3)
    4.472
    >>> knn = KNeighborsClassifier(1, metric=pose_metric(arm, metric="spatial"), algorithm="brute")
    >>> knn.fit([[0.0, 0.0], [1.5, 0.0]], ["out", "up"]).predict([[1.2, 0.1]])
    array(['up'], dtype='<U3')
    """
    chosen = resolve(metric, skeleton)
    warn_of_no_skeleton(metric, skeleton)
    return _compile(chosen, skeleton)


@functools.cache  # for good, as compiled code knows the addresses of the metric's functions
def _compile(metric: Metric, skeleton: Skeleton | None) -> Callable[[np.ndarray, np.ndarray], float]:
    steps, encode, measure = metric.steps, metric.encode, metric.measure
    tree = metric.tree_for(skeleton)
    metric._check_functions(tree, 64 if skeleton is None else skeleton.n_dofs)
    if skeleton is None:  # poses of any length
        n_dofs, refusal = -1, "the two poses differ in length"
        n_codes = metric.n_codes(tree, 0)
        n_per_dof = metric.n_codes(tree, 1) - n_codes
        if metric.n_codes(tree, 7) != n_codes + 7 * n_per_dof:
            raise ValueError(
                f"the code of {metric.label!r} does not grow by as many numbers with each column: pass skeleton=, "
                "which says how many columns there are"
            )
    else:
        n_dofs, n_per_dof = skeleton.n_dofs, 0
        n_codes = metric.n_codes(tree, n_dofs)
        refusal = f"a pose has the wrong length: the skeleton has {n_dofs} degrees of freedom, one number for each"

    kept = keep_metric(PairMetric(encode, measure, tree, steps, n_codes, n_per_dof))

    def distance(x: np.ndarray, y: np.ndarray) -> float:
        width = x.shape[0] if n_dofs < 0 else n_dofs
        if x.shape[0] != width or y.shape[0] != width:
            raise ValueError(refusal)
        poses = empty_pairs(width, np.float64)
        for i in range(width):
            poses[i, 0, 0], poses[i, 0, 1] = x[i], y[i]
        return pair_distance(poses, address_here(kept))

    return of_this_process(distance, (_compile, (metric, skeleton)))
