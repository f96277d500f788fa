"""The geodesic between two poses: the shortest motion from one to the other."""

from dataclasses import dataclass, field
from numbers import Integral, Real

import numpy as np
from sklearn.exceptions import ConvergenceWarning

from skpose._compiled.path.geodesic import MAX_ITER, TOL, path_between
from skpose._compiled.path.minimiser import Bounds
from skpose._compiled.pose.tree import Tree
from skpose._utils.sklearn import Interval, StrOptions, validate_params
from skpose._utils.typing import ArrayLike
from skpose._utils.units import warn_of_degrees
from skpose._utils.validation import check_integer, check_limits, check_pose, limits_of
from skpose._utils.warnings import warn
from skpose.kinematics._forward import weighted_positions
from skpose.kinematics._tree import from_tree_order, to_tree_order, tree_of, wrap_dofs
from skpose.metrics import Geodesic, Metric
from skpose.metrics._registry import MEAN_CONSTRAINTS, require_geodesic
from skpose.skeleton import Skeleton
from skpose.skeleton._bone import limited_dofs
from skpose.skeleton._interpolation import interpolate_poses, straight_line
from skpose.skeleton._rotations import remove_jumps

BEND = 0.5  # standard deviation of the angles by which the middle of a further start is bent, rad
SPEED_GRID = 64  # subdivisions of each step when resampling at constant speed


@dataclass(frozen=True, eq=False)
class GeodesicResult:
    """A path between two poses, as returned by `geodesic`.

    Attributes
    ----------
    path : ndarray of shape (n_points, n_dofs)
        Poses along the path, rad, from the first to the second. n_points is n_steps + 1, or more if the path was
        refined. Angles are continuous from pose to pose (except at gimbal lock) and may leave [−π, π]. Enforced limits
        hold for every pose.
    length : float
        Sum of the chords ‖F(θ_i) − F(θ_{i−1})‖, m: the distance as defined in the paper.
    curve_length : float
        Length of the curve on a grid eight times finer, m, with piecewise linear angles and slerp for joints with
        three dofs. At least `length`, and at most 0.5 % more if the path passes the discretisation check.
    energy : float
        Sum of the squared chords, m² (eq. 6).
    gradient_norm : float
        Norm of the gradient of the energy, m²/rad. Joints with three dofs are differentiated by rotation vectors.
        Components that push against enforced limits are excluded.
    gain : float
        Fraction of `length` that could still be gained according to a quadratic model of the energy. inf if the search
        was aborted; NaN if the path is the straight line because no other path passed the discretisation check.
    n_iter : int
        Number of iterations, over all refinements.
    converged : bool
        Whether the path is a local minimum: `gain` is at most `tol` (or the precision of float64), the path passes the
        discretisation check, and it is not a saddle point. Another path may still be shorter, see `n_starts`.

    Examples
    --------
    >>> from skpose import Skeleton, geodesic
    >>> found = geodesic([0.0], [1.0], Skeleton.chain(1))
    >>> len(found.path), round(found.length, 4), round(found.curve_length, 4)
    (11, 0.9996, 1.0)
    >>> found.resample(3).round(2)
    array([[0. ],
           [0.5],
           [1. ]])
    """

    path: np.ndarray = field(repr=False)
    length: float
    curve_length: float
    energy: float
    gradient_norm: float
    gain: float
    n_iter: int
    converged: bool
    _skeleton: Skeleton = field(repr=False)
    _limited: np.ndarray | None = field(default=None, repr=False)  # (n_dofs,) bool: dofs with enforced limits

    def resample(self, n: int) -> np.ndarray:
        """Sample the path at constant speed: equal curve length between consecutive poses.

        Parameters
        ----------
        n : int
            Number of poses, at least 2, including both ends.

        Returns
        -------
        ndarray of shape (n, n_dofs)
            Joint angles, rad.
        """
        check_integer(n, 2, "n")
        return self._at(np.linspace(0.0, 1.0, n))

    def _at(self, shares: np.ndarray) -> np.ndarray:
        """Poses at fractions of the curve length, from 0 to 1."""
        n_fine = SPEED_GRID * (len(self.path) - 1) + 1
        steps = np.arange(n_fine) / SPEED_GRID
        fine = interpolate_poses(self._skeleton.bones, self.path, steps, self._limited)
        positions = weighted_positions(fine, self._skeleton)
        travelled = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(positions, axis=0), axis=1))])
        if travelled[-1] == 0.0:  # no joint moves, though angles may
            travelled = steps
        at = np.interp(shares * travelled[-1], travelled, steps)
        return interpolate_poses(self._skeleton.bones, self.path, at, self._limited)


@validate_params(
    MEAN_CONSTRAINTS
    | {
        "joint_limits": [StrOptions(["ignore", "enforce"])],
        "max_iter": [Interval(Integral, 1, None, closed="left")],
        "tol": [Interval(Real, 0, None, closed="left")],
        "n_starts": [Interval(Integral, 1, None, closed="left")],
    },
    prefer_skip_nested_validation=True,
)
def geodesic(
    start: ArrayLike,
    end: ArrayLike,
    skeleton: Skeleton,
    *,
    metric: str | Metric = "geodesic",
    joint_limits: str = "ignore",
    max_iter: int = MAX_ITER,
    tol: float = TOL,
    n_starts: int = 1,
) -> GeodesicResult:
    r"""Find the shortest path from one pose to another on the kinematic manifold.

    The geodesic is the curve of poses along which the joints travel least (eq. 3). It is found by minimising the
    discrete energy

    .. math:: E = \sum_{i=1}^{N} \|F(\theta_i) - F(\theta_{i-1})\|^2

    (eq. 6) from a straight line: linear in the angles, or slerp for joints with three dofs, whichever is shorter. The
    result is never longer than either. The gradient is
    :math:`2 (2F(\theta_i) - F(\theta_{i-1}) - F(\theta_{i+1}))^T J_{\theta_i}`; eq. 12 of the paper drops the minus
    sign of the first inner derivative, so F(θ_i) is missing from its eq. 7 and 13.

    Parameters
    ----------
    start, end : array-like of shape (n_dofs,)
        The two poses: joint angles, rad, in the order of ``skeleton.dof_names``.
    skeleton : Skeleton
        The skeleton of the two poses.
    metric : str or Metric, default="geodesic"
        "geodesic" or a ``skpose.metrics.Geodesic`` object with at least two steps.
    joint_limits : {"ignore", "enforce"}, default="ignore"
        "enforce" keeps all poses inside ``skeleton.limits`` (Θ of eq. 2), also after `GeodesicResult.resample`. Both
        ends must be inside; ends outside by at most 1e-6 rad are clipped. A dof with limits never wraps from π to −π,
        however far apart its two ends are. Joints with three angles and limits keep their Euler angles.
    max_iter : int, default=500
        Maximum number of iterations of each refinement.
    tol : float, default=1e-6
        Fraction of the length that may be left to gain at convergence. It refers to the local minimum found; a much
        shorter path may exist elsewhere.
    n_starts : int, default=1
        Number of searches, the first from the straight line and the others from lines bent at random, always the same
        ones; the shortest path is returned. `pose_distances` uses one. Poses of people gain little: of 80 far pairs of
        CMU and HDM05, two paths are more than 0.5 % longer than the shortest of eight.

    Returns
    -------
    GeodesicResult
        The path, its length and convergence information.

    Raises
    ------
    ValueError
        If a pose has the wrong length, its columns are in the wrong order (checked by name), or it is not finite; if
        limits are to be enforced but the skeleton has none, or a pose is outside.

    Warns
    -----
    ConvergenceWarning
        If the path did not converge. It is still a valid curve, and not longer than the straight line
        by `curve_length`.
    UserWarning
        If the poses seem to be in degrees, see `skpose.pose_distances`.

    See Also
    --------
    pose_distances : With ``metric="geodesic"``, the lengths for many pairs.

    Notes
    -----
    *Discretisation check.* Ten poses can have short chords while the motion between them is long. Between very
    different poses, the chords of the path of least energy may add up to half the straight line although its curve is
    longer than the line. So every path is measured again on a grid eight times finer. If the lengths differ by more
    than 0.5 %, the energy is computed with four chords per step, and then with more steps.

    *Coordinates.* Near gimbal lock, the straight line in Euler angles leads to a local minimum that is longer than
    slerp. So joints with three dofs are parametrised by rotation vectors relative to the orientation half-way between
    the two poses.

    *Method.* Gauss-Newton with trust-region damping. The normal equations are block tridiagonal in the poses and
    separate into the branches of the skeleton at the root; in large skeletons, limbs are eliminated before the trunk.
    Conjugate gradients combine the steps, and the exact Hessian decides about convergence. JᵀJ is singular (a twist of
    an end bone moves no joint), so the path need not be unique even if its length is. Dofs that move no joint with
    weight follow the straight line.

    *Convergence.* The energy is flat around a geodesic: joints may move far with almost no change of length. So the
    criterion is the predicted gain of the exact quadratic model rather than the norm of the gradient. Refined paths
    have several minima, and a smaller `tol` may end in a different one.

    Time O(n_iter · n_steps · n_dofs³): a few milliseconds for ten steps of 56 dofs, tens of milliseconds if the path is
    refined. Memory O(n_steps · n_dofs²). The result is a local minimum: for poses far apart a shorter path may exist.

    References
    ----------
    .. [1] S. Hauberg, K. S. Pedersen, "Spatial measures between human poses for classification and understanding",
       AMDO 2012, sec. 2.1 and appendix A, :doi:`10.1007/978-3-642-31567-1_3`.
    .. [2] R. Featherstone, "Rigid Body Dynamics Algorithms", Springer 2008, ch. 6 (composite-rigid-body algorithm,
       used to sum JᵀJ), :doi:`10.1007/978-1-4899-7560-7`.

    Examples
    --------
    An arm of three bones of 1 m folds while it swings from one side to the other:

    >>> import numpy as np
    >>> from skpose import Skeleton, geodesic, pose_distances
    >>> arm = Skeleton.chain(3)
    >>> found = geodesic([0.2, 0.3, 0.0], [2.4, 0.2, 0.1], arm)
    >>> round(found.length, 2), found.converged
    (7.17, True)
    >>> found.resample(3)[1].round(1)  # in the middle, rad
    array([ 0.7,  2.1, -1.7])
    >>> pose_distances([[0.2, 0.3, 0.0]], [[2.4, 0.2, 0.1]], skeleton=arm).round(2)  # straight in angle space
    array([[8.02]])
    """
    first, last = check_pose(start, skeleton, "start"), check_pose(end, skeleton, "end")
    warn_of_degrees(None, skeleton, start=first[None], end=last[None])
    chosen = require_geodesic(metric, skeleton, "geodesic")
    if joint_limits == "enforce":
        first, last = check_limits(first, skeleton, "start"), check_limits(last, skeleton, "end")
    found = shortest_path(first, last, skeleton, chosen, joint_limits, max_iter, tol, n_starts)
    if not found.converged:
        warn(
            f"the geodesic did not converge in {found.n_iter} iterations (gain {found.gain:.2g}): raise max_iter or "
            "n_steps",
            ConvergenceWarning,
        )
    return found


def shortest_path(
    first: np.ndarray,
    last: np.ndarray,
    skeleton: Skeleton,
    metric: Geodesic,
    joint_limits: str = "ignore",
    max_iter: int = MAX_ITER,
    tol: float = TOL,
    n_starts: int = 1,
) -> GeodesicResult:
    """Find the geodesic of `geodesic` without its checks and warnings."""
    tree = tree_of(skeleton)
    begin, target = to_tree_order(tree, first), to_tree_order(tree, last)
    limited = limited_dofs(skeleton.bones) if joint_limits == "enforce" else np.zeros(skeleton.n_dofs, bool)
    if metric.wrap:
        target = np.where(limited[tree.column], target, wrap_dofs(tree, target, begin))
    bounds, wrap = _bounds(tree, skeleton, joint_limits), bool(metric.wrap)
    bends = np.random.default_rng(0).normal(scale=BEND, size=(n_starts, len(begin)))
    bends[0] = 0.0
    curves = [
        path_between(tree, begin, target, int(metric.n_steps), wrap, bounds, max_iter, float(tol), bend)
        for bend in bends
    ]
    curve = min(curves, key=lambda one: (not one.converged, one.curve_length))
    line = _interpolate_unweighted(tree, skeleton, first, last, len(curve.poses), wrap, limited)
    path = from_tree_order(tree, curve.poses, line)
    path[0] = first
    return GeodesicResult(
        path=path,
        length=curve.length,
        curve_length=curve.curve_length,
        energy=curve.energy,
        gradient_norm=curve.gradient_norm,
        gain=curve.gain,
        n_iter=curve.n_iter,
        converged=curve.converged,
        _skeleton=skeleton,
        _limited=limited if joint_limits == "enforce" else None,
    )


def _interpolate_unweighted(
    tree: Tree, skeleton: Skeleton, first: np.ndarray, last: np.ndarray, n_poses: int, wrap: bool, limited: np.ndarray
) -> np.ndarray:
    """Interpolate linearly the columns of bones without weight, which the tree omits.

    Other columns of the result are undefined.
    """
    line = np.empty((n_poses, skeleton.n_dofs))
    bone_of = np.repeat(np.arange(len(skeleton.bones)), [bone.n_dofs for bone in skeleton.bones])
    missing = np.setdiff1d(bone_of, bone_of[tree.column])
    if len(missing) == 0:
        return line
    bones, columns = [skeleton.bones[i] for i in missing], np.isin(bone_of, missing)
    if wrap:
        ends, steps = np.stack([first[columns], last[columns]]), np.linspace(0.0, 1.0, n_poses)
        between = interpolate_poses(bones, ends, steps, limited[columns])
        line[:, columns] = remove_jumps(bones, between, limited[columns])
    else:
        line[:, columns] = straight_line(bones, first[columns], last[columns], n_poses)
    return line


def _bounds(tree: Tree, skeleton: Skeleton, joint_limits: str) -> Bounds:
    """Lower and upper bound of each dof, in the tree's order."""
    free = np.full(len(tree.column), np.inf)
    bounds = Bounds(-free, free)
    if joint_limits == "enforce":
        limited = np.append(tree.angle_dof, tree.slide_dof)
        # A reversed axis swaps its limits.
        limits = limits_of(skeleton)[tree.column[limited]] * tree.sign[limited, None]
        bounds.lower[limited], bounds.upper[limited] = limits.min(axis=1), limits.max(axis=1)
    return bounds
