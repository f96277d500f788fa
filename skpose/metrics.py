"""The metrics by name, and each as one compiled function of two poses."""

import functools
from collections.abc import Callable
from numbers import Integral
from typing import NamedTuple

import numpy as np
from numba import njit
from sklearn.utils._param_validation import Interval, StrOptions, validate_params

from skpose import _kernels, _loops, _measures, _minimiser
from skpose._kernels import Steps, Tree
from skpose._tree import tree_of
from skpose.skeleton import Skeleton

WORK_PER_TASK = 1e9  # in the unit of `Metric.measure_work`: little enough that Ctrl-C is heard
LITTLE_WORK = 1e7  # for a thread


class Metric(NamedTuple):
    """One way to measure poses: two kernels, and what they need."""

    encode: Callable  # what to know of one pose
    measure: Callable  # from one encoded pose to others
    n_codes: Callable[[Tree, int], int]  # length of an encoded pose, given its length before
    needs_skeleton: bool
    wraps: bool | None  # what wrap="auto" means; None for a metric that whole turns do not change
    bound: str | None  # a Euclidean metric that is never more than this one with wrap="auto"
    encode_work: float  # roughly, for each code of a pose, where adding a square to a sum is 1: 0.2 ns or so
    measure_work: float  # and for each code of a pair
    always_float64: bool = False
    measure_within: Callable | None = None  # the same up to a limit, see `skpose._nearest`

    def encoded(self, poses: np.ndarray, skeleton: Skeleton | None, steps: Steps) -> np.ndarray:
        """The codes of poses, in float64."""
        tree = tree_of(skeleton if self.needs_skeleton else None)
        codes = np.empty((len(poses), self.n_codes(tree, poses.shape[1])))
        _loops.encode_poses(poses, self.encode, tree, steps, codes)
        return codes


def _n_coordinates(tree: Tree, n_dofs: int) -> int:
    return 3 * (len(tree.offset) - 1)


def _n_quaternions(tree: Tree, n_dofs: int) -> int:
    return 4 * (len(tree.frame_parent) - 1)


def _n_curve_end(tree: Tree, n_dofs: int) -> int:
    return 5 * n_dofs + _n_coordinates(tree, n_dofs)


METRICS = {
    "angle": Metric(
        _kernels.encode_angles,
        _measures.measure_euclidean,
        lambda tree, n_dofs: n_dofs,
        needs_skeleton=False,
        wraps=False,
        bound="angle",
        encode_work=3,
        measure_work=1,
    ),
    "position": Metric(
        _kernels.encode_positions,
        _measures.measure_euclidean,
        _n_coordinates,
        needs_skeleton=True,
        wraps=None,
        bound="position",
        encode_work=60,
        measure_work=1,
    ),
    "rotation": Metric(
        _kernels.encode_rotations,
        _measures.measure_rotations,
        _n_quaternions,
        needs_skeleton=True,
        wraps=None,
        bound=None,
        encode_work=40,
        measure_work=8,
    ),
    "spatial": Metric(
        _kernels.encode_curve_end,
        _measures.measure_line,
        _n_curve_end,
        needs_skeleton=True,
        wraps=True,
        bound="position",
        encode_work=20,
        measure_work=16,
        measure_within=_measures.measure_line_within,
    ),
    "geodesic": Metric(
        _kernels.encode_curve_end,
        _minimiser.measure_geodesic,
        _n_curve_end,
        needs_skeleton=True,
        wraps=True,
        bound="position",
        encode_work=20,
        measure_work=100_000,
        always_float64=True,
    ),
}

# Constraints of the parameters that every function and estimator of distances has, for scikit-learn's validation.
METRIC_CONSTRAINTS = {
    "skeleton": [Skeleton, None],
    "metric": [StrOptions({"auto", *METRICS})],
    "n_steps": [Interval(Integral, 1, None, closed="left")],
    "wrap": ["boolean", StrOptions({"auto"})],
}


def effective_name(metric: str, skeleton: Skeleton | None) -> str:
    """The metric's own name; "auto" is "spatial" with a skeleton and "angle" without one."""
    if metric != "auto":
        return metric
    return "angle" if skeleton is None else "spatial"


def resolve(metric: str, skeleton: Skeleton | None, n_steps: int, wrap: bool | str) -> tuple[Metric, Steps]:
    """The metric meant by a name, and its steps."""
    metric = effective_name(metric, skeleton)
    chosen = METRICS[metric]
    if chosen.needs_skeleton and skeleton is None:
        raise ValueError(
            f'metric="{metric}" needs a skeleton to place the joints, got skeleton=None: pass the Skeleton that the '
            'poses belong to, or use metric="angle"'
        )
    wraps = chosen.wraps if wrap == "auto" or chosen.wraps is None else wrap
    return chosen, Steps.of(n_steps, bool(wraps))


@validate_params(METRIC_CONSTRAINTS, prefer_skip_nested_validation=True)
def pose_metric(
    metric: str = "auto", skeleton: Skeleton | None = None, *, n_steps: int = 10, wrap: bool | str = "auto"
) -> Callable[[np.ndarray, np.ndarray], float]:
    """A metric as one function of two poses, compiled by numba, for whatever takes a callable as its metric.

    For a matrix of distances `skpose.pose_distances` is many times faster, since it does the work of a pose once and
    not once per pair. The function is for estimators that take a callable: ``KNeighborsClassifier(metric=f)``,
    ``pairwise_distances(metric=f)``, UMAP, pynndescent, and for one's own numba code, which can call it.

    Parameters
    ----------
    metric : {"auto", "angle", "position", "rotation", "spatial", "geodesic"}, default="auto"
        See `skpose.pose_distances`. A "geodesic" that does not converge is the length of the best curve found, without
        a warning, which compiled code cannot give.
    skeleton : Skeleton, default=None
        Needed by all but "angle".
    n_steps : int, default=10
        Chords along the curve of "spatial" and "geodesic".
    wrap : bool or "auto", default="auto"
        Whether differences of angles are taken the short way round.

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
    The first call compiles for a second or so in every process; what does not depend on the skeleton comes from
    numba's disk cache. About 10 µs a pair of poses of 56 dofs under "spatial" with ten steps, some
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
    >>> f = pose_metric("position", arm)
    >>> round(f(np.array([0.0, 0.0]), np.array([np.pi, 0.0])), 3)
    4.472
    >>> knn = KNeighborsClassifier(1, metric=pose_metric("spatial", arm), algorithm="brute")
    >>> knn.fit([[0.0, 0.0], [1.5, 0.0]], ["out", "up"]).predict([[1.2, 0.1]])
    array(['up'], dtype='<U3')
    """
    chosen, steps = resolve(metric, skeleton, n_steps, wrap)
    return _compiled(chosen, skeleton, steps)


@functools.lru_cache(maxsize=64)
def _compiled(metric: Metric, skeleton: Skeleton | None, steps: Steps) -> Callable[[np.ndarray, np.ndarray], float]:
    encode, measure, pair = metric.encode, metric.measure, _loops.pair_distance_function()
    tree = tree_of(skeleton if metric.needs_skeleton else None)
    if skeleton is None:  # "angle" on poses of any length, which are their own code
        n_dofs, n_codes, refusal = -1, -1, "the two poses differ in length"
    else:
        n_dofs = skeleton.n_dofs
        n_codes = metric.n_codes(tree, n_dofs)
        refusal = f"a pose has the wrong length: the skeleton has {n_dofs} degrees of freedom, one number for each"

    @njit(nogil=True)
    def distance(x, y):
        width = x.shape[0] if n_dofs < 0 else n_dofs
        if x.shape[0] != width or y.shape[0] != width:
            raise ValueError(refusal)
        # Copies, since rows may be of any dtype and stride.
        a, b = np.empty(width), np.empty(width)
        for i in range(width):
            a[i], b[i] = x[i], y[i]
        return pair(a, b, width if n_codes < 0 else n_codes, encode, measure, tree, steps)

    return distance
