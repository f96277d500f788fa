"""A metric as one compiled function of two poses."""

import functools
from collections.abc import Callable

import numpy as np

from skpose._compiled.pose.pair import PairMetric, address_here, keep_metric, pair_distance
from skpose._compiled.simd.jit import of_this_process
from skpose._compiled.simd.lanes import empty_pairs
from skpose._utils.sklearn import validate_params
from skpose._utils.warnings import warn
from skpose.metrics._geodesic import Geodesic
from skpose.metrics._metric import Metric
from skpose.metrics._registry import METRIC_CONSTRAINTS, resolve, warn_of_no_skeleton
from skpose.metrics._spatial import Spatial
from skpose.skeleton import Skeleton

BALL_TREE = 15  # columns up to which scikit-learn picks a ball tree for a callable


@validate_params(METRIC_CONSTRAINTS, prefer_skip_nested_validation=True)
def pose_metric(
    skeleton: Skeleton | None = None, *, metric: str | Metric = "auto"
) -> Callable[[np.ndarray, np.ndarray], float]:
    """A metric as one function of two poses, compiled by numba.

    It is for estimators that take a callable, such as ``KNeighborsClassifier(metric=f)``, UMAP and pynndescent, and for
    your own numba code. For a matrix, `skpose.pose_distances` is many times faster, since it does the work of each pose
    once and not once per pair.

    Parameters
    ----------
    skeleton : Skeleton, default=None
        Needed by all metrics except "angle".
    metric : str or Metric, default="auto"
        The distance, see `skpose.pose_distances`; "auto" is "spatial" with a skeleton, else "angle" and a warning. A
        "geodesic" that does not converge gives the length of the best curve found, without a warning.

    Returns
    -------
    callable
        ``f(x, y) -> float`` on arrays of shape (n_dofs,), rad; a numba dispatcher that releases the GIL. The distance
        is in m, for "angle" in rad. It can be pickled and cloned; equal arguments give the same function.

    Raises
    ------
    ValueError
        For a metric that needs a skeleton and got none; and, when called, for poses of the wrong width.

    Warns
    -----
    UserWarning
        For "spatial" and "geodesic" with 15 columns or fewer, where scikit-learn's ``algorithm="auto"`` picks a ball
        tree for a callable. Ball trees rely on the triangle inequality, which these distances need not satisfy, and
        miss some neighbours. Pass ``algorithm="brute"``.

    Notes
    -----
    About 6 µs per pair of poses of 42 dofs through scikit-learn under "spatial" with ten steps, some milliseconds under
    "geodesic". Each process compiles a small part anew, in 0.1 to 0.2 s for each kind of rows (float32, strided). The
    function holds an address of the process, so numba does not cache your functions that call it. Each metric and
    skeleton takes about a megabyte while the process lives.

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
    >>> knn = KNeighborsClassifier(1, metric=f)
    >>> knn.fit([[0.0, 0.0], [1.5, 0.0]], ["out", "up"]).predict([[1.2, 0.1]])
    array(['up'], dtype='<U3')
    """
    chosen = resolve(metric, skeleton)
    warn_of_no_skeleton(metric, skeleton)
    if skeleton is not None and skeleton.n_dofs <= BALL_TREE and isinstance(chosen, Spatial | Geodesic):
        warn(
            f"ball trees, chosen by scikit-learn for {BALL_TREE} columns or fewer, miss neighbors under "
            f'"{chosen.name}"; pass algorithm="brute"'
        )
    return _compile(chosen, skeleton)


@functools.cache  # for good, as compiled code holds the addresses of the metric's functions
def _compile(metric: Metric, skeleton: Skeleton | None) -> Callable[[np.ndarray, np.ndarray], float]:
    steps, encode, measure = metric.steps, metric.encode, metric.measure
    tree = metric.tree_for(skeleton)
    metric._check_functions(tree, 64 if skeleton is None else skeleton.n_dofs)
    if skeleton is None:  # poses of any length
        n_dofs, refusal = -1, "the two poses must have the same length"
        n_codes = metric.n_codes(tree, 0)
        n_per_dof = metric.n_codes(tree, 1) - n_codes
        if metric.n_codes(tree, 7) != n_codes + 7 * n_per_dof:
            raise ValueError(f"{metric.label!r} needs skeleton=: the length of its codes is not linear in the columns")
    else:
        n_dofs, n_per_dof = skeleton.n_dofs, 0
        n_codes = metric.n_codes(tree, n_dofs)
        refusal = f"a pose must have {n_dofs} numbers, one for each degree of freedom of the skeleton"

    kept = keep_metric(PairMetric(encode, measure, tree, steps, n_codes, n_per_dof))

    def distance(x: np.ndarray, y: np.ndarray) -> float:
        width = x.shape[0] if n_dofs < 0 else n_dofs
        if x.shape[0] != width or y.shape[0] != width:
            raise ValueError(refusal)
        poses = empty_pairs(width, np.float64)
        for i in range(width):
            poses[i, 0, 0], poses[i, 0, 1] = x[i], y[i]
        return pair_distance(poses, address_here(kept))  # type: ignore[call-arg]

    return of_this_process(distance, (_compile, (metric, skeleton)))
