"""A test of whether two sets of poses differ."""

from dataclasses import dataclass
from numbers import Integral
from typing import Any

import numpy as np
from sklearn.utils import check_random_state

from skpose._compat.sklearn import Interval, StrOptions, validate_params
from skpose._validation.units import warn_of_degrees
from skpose.metrics import Metric
from skpose.metrics._shared import METRIC_CONSTRAINTS, OF_MOTIONS, resolve, warn_of_no_skeleton, warn_of_unconverged
from skpose.motions._shared import Sequences
from skpose.skeleton import Skeleton
from skpose.statistics._permutations import Design, permutation_test
from skpose.statistics._unit_means import Distances, mean_kernel, negative_distances
from skpose.statistics._units import check_units


@dataclass(frozen=True, eq=False)
class TwoSampleTestResult:
    """A test of whether two sets of poses differ, as `two_sample_test` returns it.

    Attributes
    ----------
    statistic : float
        The squared distance between the two sets: for "energy" in the unit of the metric, m (rad for "angle"), for
        "mmd" a number.
    pvalue : float
        The share of the splits into two sets whose statistic is at least as large.
    null_distribution : ndarray
        The statistics of these splits: of all of them, or of `n_permutations` random ones.
    least_pvalue : float
        The smallest p-value that so few motions or poses, and so few permutations, can give. Where it is above the
        level of the test, nothing can be found.
    exact : bool
        Whether `null_distribution` has all splits. If not, the given one is counted in addition to it.
    n_x, n_y : int
        The number of motions, or of single poses, in X and in Y.
    paired : bool
        Whether only the two of each pair were exchanged.
    width : float or None
        The σ of the kernel, in the unit of the metric; None for "energy".
    negative_share : float or None
        Sum of the magnitudes of the kernel's negative eigenvalues, before its repair, over that of all; None for
        "energy".

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
    r"""Test whether two sets of poses differ, by permutations.

    With d the distance between poses, a and a' independent poses of the first set, and b and b' of the second:

    - "energy", the energy statistic [1]_, :math:`2 E\, d(a, b) - E\, d(a, a') - E\, d(b, b')`.
    - "mmd", the squared maximum mean discrepancy [2]_, :math:`E\, k(a, a') + E\, k(b, b') - 2 E\, k(a, b)`, with the
      kernel :math:`k = \exp(-d^2 / 2 \sigma^2)`, σ the median distance.

    The p-value is the share of the splits of all of X and Y into two such sets whose statistic is at least as large.

    **The elements of X and Y are permuted**: the rows of an array, or whole motions of a list. They must be
    exchangeable: if X and Y do not differ, any of them could as well be in the other set. Consecutive frames of a
    recording are not: permuted one by one, they mostly give a small p to any two recordings, and whole cycles of a
    walk a large one. So pass motions, or an array of poses that are independent, such as one of each recording. The
    question decides what a motion is:

    - Two people's walks: a recording. The test is about these two people, of whom more recordings could be taken.
    - Two groups of people: all recordings of a person, joined by ``Motion.concatenate``, as people are exchangeable
      and recordings of one person belong together.
    - The same people before and after: ``paired=True``, where X[i] is before and Y[i] after of one person. Only X[i]
      and Y[i] change places, and the differences between people cancel.

    Parameters
    ----------
    X : list of array-like or of Motion, MotionDataset, or array of shape (n_poses, n_dofs)
        Motions of shape (n_frames, n_dofs) each, or poses that are exchangeable: joint angles, and rotation vectors of
        ball joints, rad. An array of shape (n_motions, n_frames, n_dofs) is motions too. Lengths may differ: each
        motion counts once, with the mean over its poses.
    Y : as X
        The other set; the number may be another one.
    skeleton : Skeleton, default=None
        The skeleton of all poses. None is that of the `Motion` objects, where they differ their mean; arrays need it,
        but for "angle".
    metric : str or Metric, default="auto"
        The distance, see `pose_distances`; "auto" is "spatial" with a skeleton, else "angle" and a warning. Of lists of
        motions also "velocity", "jerk" and "centered", see `motion_distances`.
    statistic : {"energy", "mmd"}, default="energy"
        "energy" has no parameter; "mmd" weighs distances well above σ less.
    paired : bool, default=False
        Whether X[i] and Y[i] belong together, and only they are exchanged.
    n_permutations : int, default=999
        Random permutations. If there are no more splits than this, all are taken, each once.
    random_state : int, RandomState instance or None, default=None
        Source of the permutations. Pass an int for the same p-value at every call.
    n_jobs : int, default=None
        Threads for the distances, or workers of a ``joblib.parallel_config`` context, see `pose_distances`.

    Returns
    -------
    TwoSampleTestResult
        The statistic, the p-value, the statistics of the permutations, and the least p-value that was possible.

    Raises
    ------
    TypeError
        For one motion in the place of several, and for Motions and arrays together.
    ValueError
        For poses that `pose_distances` refuses and motions that `motion_distances` refuses; for poses in X and
        motions in Y; for one element in each; for pairs with sets of different sizes; for a metric of motions and rows
        that are poses.

    Warns
    -----
    UserWarning
        If rows of an array follow one another as frames of a recording do; if poses look like degrees, see
        `pose_distances`.
    ConvergenceWarning
        If geodesics did not converge.

    See Also
    --------
    outlier_test : Test of each motion of a set by itself.
    motion_distances : Distances between whole motions, which the order of their poses has part in.
    PoseDistanceTransformer : The kernel between poses, for scikit-learn.

    Notes
    -----
    The test is about sets of poses: the order of the frames has no part in it, unless the metric is of motions.
    Velocities and jerks are computed inside each motion, and the test is then one of sets of velocities or of jerks. It
    says that the distributions differ, not in what. All poses are compared on one skeleton, so that the lengths of
    people's bones have no part either.

    The p-value is valid under any metric and either statistic: if X and Y are exchangeable, it is at most α with a
    probability of no more than α. It is never zero [5]_. Ties count as larger. With few elements it cannot be small:
    three motions against three have 20 splits, of which any two that exchange X and Y have the same statistic, so
    that p is at least 0.1; four against four 0.029, five pairs 0.0625, six 0.031; see
    `TwoSampleTestResult.least_pvalue`.

    Whether *any* difference is found, given enough data, depends on the metric. "position" and "angle"
    are Euclidean distances, which are of strong negative type [3]_, and the Gaussian kernel is characteristic on them:
    both statistics are zero only for equal distributions, of the positions and of the angles. The other metrics need
    not be of negative type. Their energy statistic can then be negative, and different sets can have the same as equal
    ones. The two statistics are one family: an energy statistic is an MMD with another kernel [4]_.

    The kernel is averaged over the pairs of poses of every two elements, and then repaired: negative eigenvalues of the
    matrix become zero, as with ``PoseDistanceTransformer(psd="clip")``, so that the squared MMD is not negative. σ is
    the median distance between different poses of two elements, of some 500 poses evenly spread over the motions, or
    of all poses where these are permuted. Neither depends on the split.

    Pairs of a pose with itself, and of one motion with itself, are counted, as in `scipy.stats.energy_distance`: in one
    dimension, "energy" is the square of it.

    Time: all distances once, as of `pose_distances`; with n elements O(n²) a permutation, and O(n³) for "mmd".
    Memory O(n²), and a few tiles of 134 MB; there is no matrix of the distances between frames.

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
    Walks of two people, five recordings of each:

    >>> from skpose.statistics import two_sample_test
    >>> from skpose.datasets import make_gait
    >>> walks = make_gait(n_subjects=2, n_sequences=5, activities=["walk"], frame_rate=12, random_state=0)
    >>> two_sample_test(walks[walks.subjects == "01"], walks[walks.subjects == "02"])
    TwoSampleTestResult(statistic=0.213, pvalue=0.00794, the least possible, exact, 5 against 5)

    The first three recordings of one person against the last two:

    >>> one = walks[walks.subjects == "01"]
    >>> two_sample_test(one[:3], one[3:])
    TwoSampleTestResult(statistic=0.052, pvalue=0.5, at least 0.1, exact, 3 against 2)
    """
    units = check_units(X, Y, skeleton, paired)
    skeleton = units.skeleton
    if skeleton is not None:
        warn_of_degrees(None, skeleton, X=units.of_x, Y=units.of_y)
    chosen = resolve(metric, skeleton, of_motions=True)
    sequences = Sequences.join(units.encode(chosen))
    warn_of_no_skeleton(metric, skeleton)
    distances = Distances(chosen, skeleton, n_jobs)
    means = (negative_distances if statistic == "energy" else mean_kernel)(sequences, distances)
    design = Design(units.n_x, units.n_y, paired)
    outcome = permutation_test(means.matrix, design, n_permutations, check_random_state(random_state))
    n_poses = len(sequences.poses)
    warn_of_unconverged([means.unconverged], n_poses * (n_poses - 1) // 2)
    return TwoSampleTestResult(
        **outcome._asdict(),
        n_x=units.n_x,
        n_y=units.n_y,
        paired=paired,
        width=means.width,
        negative_share=means.negative_share,
    )
