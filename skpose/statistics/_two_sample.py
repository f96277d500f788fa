"""Permutation test of whether two sets of poses differ."""

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import combinations, islice
from math import comb
from numbers import Integral
from typing import Any

import numpy as np
from sklearn.utils import check_random_state, gen_batches

from skpose._utils.sklearn import Interval, StrOptions, validate_params
from skpose._utils.units import warn_of_degrees
from skpose.metrics import Metric
from skpose.metrics._matrix import warn_of_unconverged
from skpose.metrics._registry import METRIC_CONSTRAINTS, OF_MOTIONS, resolve, warn_of_no_skeleton
from skpose.motions._inputs import Sequences
from skpose.skeleton import Skeleton
from skpose.statistics._units import ROUNDING, Distances, check_units, mean_kernel, negative_distances

VALUES_AT_ONCE = 2**21  # entries of a batch of splits: 16 MB, and as much for the products


@dataclass(frozen=True, eq=False)
class TwoSampleTestResult:
    """A test of whether two sets of poses differ, as returned by `two_sample_test`.

    Attributes
    ----------
    statistic : float
        The squared distance between the two sets: in the unit of the metric, m (rad for "angle"), for "energy";
        dimensionless for "mmd".
    pvalue : float
        Share of splits with a statistic at least as large.
    null_distribution : ndarray
        Statistics of all splits, or of `n_permutations` random ones.
    least_pvalue : float
        The smallest p-value possible with this number of elements and permutations. If it exceeds the level of the
        test, no difference can be found.
    exact : bool
        Whether `null_distribution` has all splits. If not, the p-value also counts the observed one.
    n_x, n_y : int
        Number of motions, or of single poses, in X and Y.
    paired : bool
        Whether only X[i] and Y[i] were exchanged.
    width : float or None
        The σ of the kernel, in the unit of the metric; None for "energy".
    negative_share : float or None
        Share of negative eigenvalues of the kernel before its repair, by magnitude; None for "energy".

    Examples
    --------
    >>> from skpose import Skeleton
    >>> from skpose.statistics import two_sample_test
    >>> two_sample_test([[0.0], [0.2], [0.1]], [[0.9], [0.8], [1.1]], skeleton=Skeleton.chain(1))
    TwoSampleTestResult(statistic=1.44, pvalue=0.1, the least possible, exact, 3 against 3)
    """

    statistic: float
    pvalue: float
    null_distribution: np.ndarray
    least_pvalue: float
    exact: bool
    n_x: int
    n_y: int
    paired: bool
    width: float | None = None
    negative_share: float | None = None

    def __repr__(self) -> str:
        least = "the least possible" if self.pvalue <= self.least_pvalue else f"at least {self.least_pvalue:.3g}"
        how = "exact" if self.exact else f"{len(self.null_distribution)} permutations"
        sets = f"{self.n_x} pairs" if self.paired else f"{self.n_x} against {self.n_y}"
        return f"TwoSampleTestResult(statistic={self.statistic:.3g}, pvalue={self.pvalue:.3g}, {least}, {how}, {sets})"


@validate_params(
    METRIC_CONSTRAINTS
    | {
        "metric": OF_MOTIONS,
        "statistic": [StrOptions(["energy", "mmd"])],
        "paired": ["boolean"],
        "n_permutations": [Interval(Integral, 1, None, closed="left")],
        "random_state": ["random_state"],
        "n_jobs": [None, Integral],
    },
    prefer_skip_nested_validation=True,
)
def two_sample_test(
    X: Any,
    Y: Any,
    *,
    skeleton: Skeleton | None = None,
    metric: str | Metric = "auto",
    statistic: str = "energy",
    paired: bool = False,
    n_permutations: int = 999,
    random_state: int | np.random.RandomState | None = None,
    n_jobs: int | None = None,
) -> TwoSampleTestResult:
    r"""Permutation test of whether two sets of poses differ.

    With d the distance between poses, a and a' independent poses of the first set, and b and b' of the second, the
    statistics are:

    - "energy": the energy statistic [1]_, :math:`2 E\, d(a, b) - E\, d(a, a') - E\, d(b, b')`.
    - "mmd": the squared maximum mean discrepancy [2]_, :math:`E\, k(a, a') + E\, k(b, b') - 2 E\, k(a, b)`, with the
      kernel :math:`k = \exp(-d^2 / 2 \sigma^2)`, σ the median distance.

    The p-value is the share of splits of all elements into two such sets with a statistic at least as large.

    **The elements of X and Y are permuted**: the rows of an array, or whole motions of a list. They must be
    exchangeable: under the null hypothesis each could as well be in the other set. Consecutive frames of a recording
    are not exchangeable, and give small p-values for almost any two recordings. So pass motions, or an array of
    independent poses, such as one per recording. What counts as one motion depends on the question:

    - Walks of two people: one recording. The test is about these two people.
    - Two groups of people: all recordings of a person, joined by ``Motion.concatenate``, because people are
      exchangeable and recordings of the same person are not independent.
    - The same people before and after: ``paired=True``, where X[i] is before and Y[i] after for one person. Only X[i]
      and Y[i] are exchanged, so differences between people cancel.

    Parameters
    ----------
    X : list of array-like or of Motion, MotionDataset, or array of shape (n_poses, n_dofs)
        Motions of shape (n_frames, n_dofs), or exchangeable poses: joint angles and rotation vectors of ball joints,
        rad. An array of shape (n_motions, n_frames, n_dofs) is a set of motions. Lengths may differ; every motion has
        the same weight.
    Y : as X
        The other set, of any size.
    skeleton : Skeleton, default=None
        The skeleton of all poses. None takes the skeleton of the `Motion` objects, or their mean if they differ. Arrays
        need it, except under "angle".
    metric : str or Metric, default="auto"
        The distance, see `pose_distances`. "auto" is "spatial" with a skeleton, else "angle" with a warning. Lists of
        motions also accept "velocity", "jerk" and "centered", see `motion_distances`.
    statistic : {"energy", "mmd"}, default="energy"
        "energy" has no parameter; "mmd" gives less weight to distances well above σ.
    paired : bool, default=False
        Whether X[i] and Y[i] belong together and are exchanged only with each other.
    n_permutations : int, default=999
        Number of random permutations. If there are at most as many splits, each is used once.
    random_state : int, RandomState instance or None, default=None
        Seed of the permutations. Pass an int for reproducible p-values.
    n_jobs : int, default=None
        Number of threads for distances, or of workers of a ``joblib.parallel_config`` context, see `pose_distances`.

    Returns
    -------
    TwoSampleTestResult
        The statistic, the p-value, the null distribution, and the smallest possible p-value.

    Raises
    ------
    TypeError
        If a single motion is passed instead of several, or Motions are mixed with arrays.
    ValueError
        If poses or motions are invalid, see `pose_distances` and `motion_distances`; if X has poses and Y motions; if
        both sets have one element; if pairs come in sets of different size; if a metric of motions is used with poses.

    Warns
    -----
    UserWarning
        If the rows of an array seem to be consecutive frames, or poses seem to be in degrees, see `pose_distances`.
    ConvergenceWarning
        If geodesics did not converge.

    See Also
    --------
    outlier_test : Test of single motions against a set.
    motion_distances : Distances between whole motions, which depend on the order of poses.
    PoseDistanceTransformer : Kernels between poses for scikit-learn.

    Notes
    -----
    The test compares sets of poses: the order of frames does not matter, unless the metric is one of motions.
    Velocities and jerks are computed within each motion, and their sets are compared. The test tells that distributions
    differ, not how. All poses are compared on one skeleton, so bone lengths do not matter either.

    The p-value is valid under any metric and either statistic: if X and Y are exchangeable, it is at most α with
    probability at most α. It is never zero [5]_, and ties count as larger. Few elements cannot give a small p-value:
    three motions against three have 20 splits in pairs of equal statistic, so p is at least 0.1; four against
    four 0.029, five pairs 0.0625, six pairs 0.031; see `TwoSampleTestResult.least_pvalue`.

    Whether every difference is found, given enough data, depends on the metric. "position" and "angle" are Euclidean
    distances, which are of strong negative type [3]_, and the Gaussian kernel on them is characteristic: both
    statistics are zero only for equal distributions of positions or angles. The other metrics need not be of negative
    type. Their energy statistic can be negative, or equal for different and equal distributions. An energy statistic is
    an MMD with another kernel [4]_.

    The kernel is averaged over the pairs of poses of every two elements. Negative eigenvalues of the resulting matrix
    are set to zero, as in ``PoseDistanceTransformer(psd="clip")``, so the squared MMD is not negative. σ is the median
    distance between different poses of two elements, over about 500 poses evenly spread over the motions, or over all
    single poses. Neither depends on the split.

    Pairs of a pose or a motion with itself count, as in `scipy.stats.energy_distance`; in one dimension, "energy" is
    the square of that distance.

    Time: all distances once, and O(n²) per permutation for n elements, plus O(n³) for "mmd". Memory O(n²), and a few
    tiles of 134 MB; the matrix of distances between frames is never stored.

    References
    ----------
    .. [1] G. J. Székely, M. L. Rizzo, "Energy statistics: a class of statistics based on distances", Journal of
       Statistical Planning and Inference 143(8), 2013, :doi:`10.1016/j.jspi.2013.03.018`.
    .. [2] A. Gretton, K. M. Borgwardt, M. J. Rasch, B. Schölkopf, A. Smola, "A kernel two-sample test", Journal of
       Machine Learning Research 13, 2012.
    .. [3] R. Lyons, "Distance covariance in metric spaces", Annals of Probability 41(5), 2013,
       :doi:`10.1214/12-AOP803`.
    .. [4] D. Sejdinovic, B. Sriperumbudur, A. Gretton, K. Fukumizu, "Equivalence of distance-based and RKHS-based
       statistics in hypothesis testing", Annals of Statistics 41(5), 2013, :doi:`10.1214/13-AOS1140`.
    .. [5] B. Phipson, G. K. Smyth, "Permutation p-values should never be zero", Statistical Applications in Genetics
       and Molecular Biology 9(1), 2010, :doi:`10.2202/1544-6115.1585`.

    Examples
    --------
    Walks of two people, five recordings each:

    >>> from skpose.statistics import two_sample_test
    >>> from skpose.datasets import make_gait
    >>> walks = make_gait(n_subjects=2, n_sequences=5, activities=["walk"], frame_rate=12, random_state=0)
    >>> two_sample_test(walks[walks.subjects == "01"], walks[walks.subjects == "02"])
    TwoSampleTestResult(statistic=0.211, pvalue=0.00794, the least possible, exact, 5 against 5)

    The first three recordings of one person against the other two:

    >>> one = walks[walks.subjects == "01"]
    >>> two_sample_test(one[:3], one[3:])
    TwoSampleTestResult(statistic=0.0518, pvalue=0.5, at least 0.1, exact, 3 against 2)
    """
    units = check_units(X, Y, skeleton, paired)
    skeleton = units.skeleton
    if skeleton is not None:
        warn_of_degrees(None, skeleton, X=units.X.sequences.poses, Y=units.Y.sequences.poses)
    chosen = resolve(metric, skeleton, of_motions=True)
    sequences = Sequences.join(units.encode(chosen))
    warn_of_no_skeleton(metric, skeleton)
    distances = Distances(chosen, skeleton, n_jobs)
    mean = negative_distances if statistic == "energy" else mean_kernel
    matrix, unconverged, width, negative_share = mean(sequences, distances)
    n_x, n_y, rng = units.n_x, units.n_y, check_random_state(random_state)
    n_splits = 2**n_x if paired else comb(n_x + n_y, n_x)
    exact = n_splits <= n_permutations
    batches = _splits(n_x, n_y, paired, n_splits if exact else n_permutations, None if exact else rng)
    null = np.concatenate([_values(splits, matrix) for splits in batches])
    (observed,) = _values(_observed_split(n_x, n_y)[None], matrix)
    n_as_large = int((null >= observed - ROUNDING * np.abs(matrix).max()).sum())
    n_poses = len(sequences.poses)
    warn_of_unconverged([unconverged], n_poses * (n_poses - 1) // 2)
    return TwoSampleTestResult(
        statistic=float(observed),
        pvalue=n_as_large / n_splits if exact else (n_as_large + 1) / (n_permutations + 1),
        null_distribution=null,
        least_pvalue=(2 if n_x == n_y else 1) / n_splits if exact else 1 / (n_permutations + 1),
        exact=exact,
        n_x=n_x,
        n_y=n_y,
        paired=paired,
        width=width,
        negative_share=negative_share,
    )


def _observed_split(n_x: int, n_y: int) -> np.ndarray:
    """The vector c with 1 / n_x for the units in X and −1 / n_y for those in Y; the statistic is cᵀGc."""
    return np.repeat([1.0 / n_x, -1.0 / n_y], [n_x, n_y])


def _values(splits: np.ndarray, G: np.ndarray) -> np.ndarray:
    return np.asarray(np.einsum("su,su->s", splits @ G, splits))


def _splits(n_x: int, n_y: int, paired: bool, n: int, rng: np.random.RandomState | None) -> Iterator[np.ndarray]:
    """Yield batches of n random splits, or all n splits without `rng`; scipy's test needs two units in each set."""
    subsets = combinations(range(n_x + n_y), n_x)
    for batch in gen_batches(n, max(1, VALUES_AT_ONCE // (n_x + n_y))):
        size = batch.stop - batch.start
        if paired:
            numbers = np.arange(batch.start, batch.stop)[:, None]
            flips = (numbers >> np.arange(n_x)) & 1 == 1 if rng is None else rng.random_sample((size, n_x)) < 0.5
            yield np.tile(np.where(flips, -1.0, 1.0), 2) * _observed_split(n_x, n_y)
        else:
            drawn = list(islice(subsets, size)) if rng is None else rng.random_sample((size, n_x + n_y)).argsort(axis=1)
            splits = np.full((size, n_x + n_y), -1.0 / n_y)
            np.put_along_axis(splits, np.array(drawn)[:, :n_x], 1.0 / n_x, axis=1)
            yield splits
