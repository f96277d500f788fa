"""Test of single motions against a set."""

from dataclasses import dataclass
from numbers import Integral
from typing import Any

import numpy as np

from skpose._utils.sklearn import validate_params
from skpose._utils.units import warn_of_degrees
from skpose.metrics import Metric
from skpose.metrics._matrix import Unconverged, warn_of_unconverged
from skpose.metrics._registry import METRIC_CONSTRAINTS, OF_MOTIONS, resolve, warn_of_no_skeleton
from skpose.skeleton import Skeleton
from skpose.statistics._units import ROUNDING, Distances, check_units, mean_distances


@dataclass(frozen=True, eq=False)
class OutlierTestResult:
    """Tests of single motions against a set, as returned by `outlier_test`.

    Attributes
    ----------
    statistic : ndarray of shape (n_x,)
        The energy statistic between each motion of X and the set Y, in the unit of the metric.
    pvalue : ndarray of shape (n_x,)
        The p-value of each motion of X: the share of the n_y + 1 motions, itself and Y, that are at least as far from
        the others.
    least_pvalue : float
        The smallest possible p-value, 1 / (n_y + 1).
    n_x, n_y : int
        Number of motions, or of single poses, in X and Y.

    Examples
    --------
    >>> from skpose import Skeleton
    >>> from skpose.statistics import outlier_test
    >>> found = outlier_test([[0.1], [0.9]], [[0.0], [0.2], [0.1], [-0.1]], skeleton=Skeleton.chain(1))
    >>> found
    OutlierTestResult(2 against a set of 4, pvalue from 0.2 to 1, at least 0.2)
    >>> found.statistic.round(2), found.pvalue
    (array([0.08, 1.57]), array([1. , 0.2]))
    """

    statistic: np.ndarray
    pvalue: np.ndarray
    least_pvalue: float
    n_x: int
    n_y: int

    def __repr__(self) -> str:
        lowest, highest = f"{self.pvalue.min():.3g}", f"{self.pvalue.max():.3g}"
        found = lowest if lowest == highest else f"from {lowest} to {highest}"
        return (
            f"OutlierTestResult({self.n_x} against a set of {self.n_y}, pvalue {found}, at least "
            f"{self.least_pvalue:.3g})"
        )


@validate_params(
    METRIC_CONSTRAINTS | {"metric": OF_MOTIONS, "n_jobs": [None, Integral]}, prefer_skip_nested_validation=True
)
def outlier_test(
    X: Any,
    Y: Any,
    *,
    skeleton: Skeleton | None = None,
    metric: str | Metric = "auto",
    n_jobs: int | None = None,
) -> OutlierTestResult:
    r"""Test for each motion of X whether it could belong to the set Y.

    The statistic is the energy statistic of a set of one, :math:`2 E\, d(a, b) - E\, d(a, a') - E\, d(b, b')`, with d
    the distance between poses, a and a' independent poses of the motion, and b and b' independent poses of Y. It
    measures how far the motion is from the set. The p-value is the share of the motion and all motions of Y whose
    statistic against the others is at least as large. Both equal the result of ``two_sample_test([motion], Y)``, but
    the distances within Y are computed only once.

    Parameters
    ----------
    X : list of array-like or of Motion, MotionDataset, or array of shape (n_poses, n_dofs)
        Motions of shape (n_frames, n_dofs), which may differ in length, or poses: joint angles and rotation vectors of
        ball joints, rad. An array of shape (n_motions, n_frames, n_dofs) is a set of motions.
    Y : as X
        The set, with at least two elements, such as recordings of people.
    skeleton : Skeleton, default=None
        The skeleton of all poses. None takes the skeleton of the `Motion` objects, or their mean if they differ. Arrays
        need it, except under "angle". Pass one to make the result for a motion independent of the rest of X.
    metric : str or Metric, default="auto"
        The distance between frames, see `pose_distances`. "auto" is "spatial" with a skeleton, else "angle" with a
        warning. Lists of motions also accept "velocity", "jerk" (which finds jitter) and "centered", see
        `motion_distances`.
    n_jobs : int, default=None
        Number of threads for distances, or of workers of a ``joblib.parallel_config`` context, see `pose_distances`.

    Returns
    -------
    OutlierTestResult
        Statistics and p-values of the motions of X, and the smallest possible p-value.

    Raises
    ------
    TypeError
        If a single motion is passed instead of several, or Motions are mixed with arrays.
    ValueError
        If poses or motions are invalid, see `pose_distances` and `motion_distances`; if X has poses and Y motions; if a
        metric of motions is used with poses; if Y has a single element.

    Warns
    -----
    UserWarning
        If the rows of an array seem to be consecutive frames, or poses seem to be in degrees, see `pose_distances`.
    ConvergenceWarning
        If geodesics did not converge.

    See Also
    --------
    two_sample_test : Test of two sets; it also detects a lack of variety in X.
    skpose.metrics.Jerk : A metric that finds jitter.

    Notes
    -----
    The p-value is valid for a motion that is exchangeable with the motions of Y. A recording of another person is not
    exchangeable with recordings of a few people, and its p-value is too small too often. So compare generated motions
    with real motions of people who are not in Y, by `sklearn.metrics.roc_auc_score` of the statistics or the share of
    p-values below a level. The p-values of X share the set Y, so they are not independent. They are conformal p-values
    [1]_.

    A large statistic means that a motion is unusual, not that it is bad. Aspects that the metric ignores have no
    effect: the order of frames under "position", the movement of the root under all metrics. A statistic need not grow
    with the fault: under "velocity" a slow motion is far from faster ones, and a little noise brings it nearer.

    Time: m (n + m / 2) distances for n frames in X and m in Y. Memory O(n_y (n_x + n_y)), and a few tiles of 134 MB.

    References
    ----------
    .. [1] V. Vovk, A. Gammerman, G. Shafer, "Algorithmic learning in a random world", Springer, 2005,
       :doi:`10.1007/b106715`.

    Examples
    --------
    Walks of a new person, and the same with half a degree of jitter in the joint angles:

    >>> import numpy as np
    >>> from dataclasses import replace
    >>> from skpose.datasets import make_gait
    >>> from skpose.statistics import outlier_test
    >>> walks = make_gait(n_subjects=5, n_sequences=4, activities=["walk"], frame_rate=30, random_state=0)
    >>> seen, new = walks[walks.subjects != "05"], walks[walks.subjects == "05"]
    >>> rng = np.random.default_rng(0)
    >>> jittery = [replace(walk, angles=walk.angles + rng.normal(0, 0.01, walk.angles.shape)) for walk in new]
    >>> for metric in ("position", "jerk"):
    ...     print(*(outlier_test(some, seen, metric=metric).pvalue.round(2) for some in (new, jittery)))
    [0.12 0.12 0.12 0.24] [0.12 0.12 0.18 0.24]
    [0.41 0.53 0.53 0.94] [0.06 0.06 0.06 0.06]
    """
    units = check_units(X, Y, skeleton, paired=False)
    if units.n_y < 2:
        raise ValueError(f"Y must have at least two {units.name}, got one")
    skeleton = units.skeleton
    if skeleton is not None:
        warn_of_degrees(None, skeleton, X=units.X.sequences.poses, Y=units.Y.sequences.poses)
    chosen = resolve(metric, skeleton, of_motions=True)
    tested, others = units.encode(chosen)
    warn_of_no_skeleton(metric, skeleton)
    distances = Distances(chosen, skeleton, n_jobs)
    between, first = mean_distances(tested, others, distances)
    among, second = mean_distances(others, None, distances)
    found = [mean_distances(tested.slice(i, i + 1), None, distances) for i in range(tested.n_motions)]
    inside, third = np.array([means.item() for means, _ in found]), Unconverged.join(one for _, one in found)
    statistic, pvalue = _leave_each_out(between, among, inside)
    n_pairs = len(others.poses) * (len(tested.poses) + (len(others.poses) - 1) // 2)
    n_pairs += sum(int(n) * (int(n) - 1) // 2 for n in tested.lengths)
    warn_of_unconverged([first, second, third], n_pairs)
    return OutlierTestResult(statistic, pvalue, 1.0 / (units.n_y + 1), units.n_x, units.n_y)


def _leave_each_out(between: np.ndarray, among: np.ndarray, inside: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Statistics of units against a set, and their p-values.

    Parameters
    ----------
    between : ndarray of shape (n_x, n_y)
        Mean distances between the units and the set.
    among : ndarray of shape (n_y, n_y)
        Mean distances within the set.
    inside : ndarray of shape (n_x,)
        Mean distance within each unit.
    """
    n, within = among.shape[0], np.diag(among)
    sums, total = among.sum(axis=1), among.sum()
    statistic = 2.0 * between.mean(axis=1) - inside - total / n**2
    # Each unit of Y against the n others, replaced by the unit of X
    to_others = sums - within + between
    among_others = total - 2.0 * sums + within + 2.0 * (between.sum(axis=1, keepdims=True) - between) + inside[:, None]
    of_others = 2.0 * to_others / n - within - among_others / n**2
    largest = np.maximum(between.max(axis=1), among.max())
    as_large = of_others >= (statistic - ROUNDING * largest)[:, None]
    return statistic, (1 + as_large.sum(axis=1)) / (n + 1)
