"""The geodesic between two poses: the shortest motion from one to the other."""

from dataclasses import dataclass, field
from numbers import Integral, Real

import numpy as np
from sklearn.exceptions import ConvergenceWarning

from skpose._compat.sklearn import Interval, StrOptions, validate_params
from skpose._compiled.path.geodesic import MAX_ITER, TOL, path_between
from skpose._compiled.path.minimiser import Bounds
from skpose._compiled.pose.tree import Tree
from skpose._typing import ArrayLike
from skpose._validation.limits import check_limits
from skpose._validation.poses import check_pose
from skpose._validation.skeletons import limits_of
from skpose._validation.units import warn_of_degrees
from skpose._warnings import warn
from skpose.kinematics._shared import from_tree_order, to_tree_order, tree_of, weighted_positions, wrap_dofs
from skpose.metrics import Geodesic, Metric
from skpose.metrics._shared import MEAN_CONSTRAINTS, require_geodesic
from skpose.skeleton import Skeleton
from skpose.skeleton._shared import interpolate_poses, limited_dofs, remove_jumps, straight_line

SPEED_GRID = 64  # chords into which each step of a path is divided to find poses at constant speed


@dataclass(frozen=True, eq=False)
class GeodesicResult:
    """A path between two poses, as `geodesic` finds it.

    Attributes
    ----------
    path : ndarray of shape (n_points, n_dofs)
        Poses along the path, rad, from the first to the second. Of the numbers that are one rotation each pose has
        those nearest to the pose before, so that no step jumps but through gimbal lock; they may leave [−π, π]. Dofs
        whose limits are enforced have numbers inside these, and exactly those given at the ends. n_points is
        n_steps + 1, or more where the path had to be refined.
    length : float
        Sum of the path's chords ‖F(θ_i) − F(θ_{i−1})‖, m: the distance, as the paper measures it.
    curve_length : float
        Length of the curve that the joints trace along the path in straight pieces, on which joints with three dofs
        turn by slerp, measured on a grid eight times finer, m. Never less than `length`, and at most 0.5 % more if the
        path passes the discretisation check.
    energy : float
        Sum of the squared chords, m² (eq. 6).
    gradient_norm : float
        Norm of the energy's gradient in the poses that were free to move, m²/rad, by angles, and by rotation vectors
        for joints with three dofs; with limits enforced, without the part that pushes against them.
    gain : float
        Share of `length` that is left to gain, by the exact quadratic model of the energy around the path; inf if the
        search was given up. NaN if the path is the straight line, as no other passes the discretisation check.
    n_iter : int
        Iterations, of all refinements.
    converged : bool
        Whether `gain` came down to `tol`, or to what float64 can show, on a path that passes the discretisation check
        and is no saddle.

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

    path: np.ndarray
    length: float
    curve_length: float
    energy: float
    gradient_norm: float
    gain: float
    n_iter: int
    converged: bool
    _skeleton: Skeleton = field(repr=False)
    _limited: np.ndarray | None = field(default=None, repr=False)  # (n_dofs,) bool: limits that hold

    def __repr__(self) -> str:
        state = "converged" if self.converged else "not converged"
        return (
            f"GeodesicResult(length={self.length:.4g}, n_points={len(self.path)}, {state} in {self.n_iter} iterations)"
        )

    def resample(self, n: int) -> np.ndarray:
        """Return poses along the curve at constant speed: the same length of curve between each two.

        Parameters
        ----------
        n : int
            Number of poses, at least 2; the first and the last are the ends.

        Returns
        -------
        ndarray of shape (n, n_dofs)
            Joint angles, rad.
        """
        if not isinstance(n, Integral) or n < 2:
            raise ValueError(f"n must be a whole number of at least 2 poses, got {n!r}")
        return self._at(np.linspace(0.0, 1.0, n))

    def _at(self, shares: np.ndarray) -> np.ndarray:
        """Return the poses at shares of the length of the curve, from 0 to 1."""
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
) -> GeodesicResult:
    r"""Find the shortest path from one pose to another on the kinematic manifold.

    Of all curves of poses between the two, it is the one along which the joints travel least (eq. 3): the minimiser of
    the discrete energy

    .. math:: E = \sum_{i=1}^{N} \|F(\theta_i) - F(\theta_{i-1})\|^2

    (eq. 6) that is found downhill from a straight line: the line of the angles, or that on which joints with three dofs
    turn by slerp, whichever is shorter. It is no longer than either. Its gradient is
    :math:`2 (2F(\theta_i) - F(\theta_{i-1}) - F(\theta_{i+1}))^T J_{\theta_i}`; eq. 12 of the paper drops the minus
    sign of the first inner derivative, so that F(θ_i) is missing in its eq. 7 and 13.

    Parameters
    ----------
    start, end : array-like of shape (n_dofs,)
        The two poses: joint angles, rad, one for each of ``skeleton.dof_names``.
    skeleton : Skeleton
        The skeleton of the two poses.
    metric : str or Metric, default="geodesic"
        "geodesic", or a ``skpose.metrics.Geodesic`` with its parameters: chords, at least two, and where the search
        starts.
    joint_limits : {"ignore", "enforce"}, default="ignore"
        "enforce" keeps all poses inside ``skeleton.limits`` (Θ of eq. 2), those of `GeodesicResult.resample` too. Both
        ends must be inside; what is outside by a rounding error of 1e-6 rad is taken to be at the limit. A dof with
        limits takes the angles between those of the two ends, however far they are apart: it never goes over from π to
        −π. Joints with three angles and limits do not turn freely.
    max_iter : int, default=500
        Largest number of iterations of each refinement.
    tol : float, default=1e-6
        Share of the length that may be left to gain when the path has converged. Far shorter paths may exist
        elsewhere: it is about this minimum.

    Returns
    -------
    GeodesicResult
        The path, its length, and how reliable they are.

    Raises
    ------
    ValueError
        For poses of the wrong length, out of order by name, or not finite; for limits to be enforced on a skeleton
        that has none, or on poses outside of them: the message names the dof, its angle and its limits.

    Warns
    -----
    ConvergenceWarning
        If the path did not converge, with the reason. It is then still a real curve, and its `curve_length` no more
        than the straight line's.
    UserWarning
        If the poses look like degrees, see `skpose.pose_distances`.

    See Also
    --------
    pose_distances : With ``metric="geodesic"``, the lengths for many pairs at once.

    Notes
    -----
    *Discretisation check.* Ten poses can sit where their chords are short while the motion between them is long.
    Between very different poses, the chords of the path of least energy may add up to half the straight line, and its
    curve to more than the whole line. So every path is measured again, on a grid eight times finer. Where the lengths
    differ by more than 0.5 %, the energy is taken over four chords a step, with the samples between on straight
    pieces, then over more steps.

    *Coordinates.* Three Euler angles are a poor coordinate of a rotation: near gimbal lock the straight line of the
    angles leads to a local minimum that is longer than the slerp. So joints with three dofs are rotation vectors here,
    from half-way between the two poses on, whichever numbers the poses have.

    *Method.* Damped Gauss-Newton with the damping of a trust region: the normal equations are block tridiagonal in the
    poses and separate into the branches of the skeleton at the root; in a large skeleton, limbs such as an arm with its
    fingers are eliminated before the trunk that carries them. Steps are combined by conjugate gradients; the exact
    Hessian decides whether a path has converged. JᵀJ is singular (a twist of a last bone moves nothing), so the path is
    not unique where its length is. Dofs that move no joint with weight follow the straight line.

    *Convergence.* The valley around a geodesic is flat: joints may move far and almost keep the length. So a path has
    converged where the exact quadratic model has no more than `tol` of the length left to gain, and not where a
    gradient is small. Refined paths have several minima, so that a smaller `tol` may lead to another one.

    Time O(n_iter · n_steps · n_dofs³), some milliseconds for ten steps of 56 dofs and some tens where the path has to
    be refined; memory O(n_steps · n_dofs²). It is a local minimum: for poses far apart there may be a shorter path.

    References
    ----------
    .. [1] S. Hauberg, K. S. Pedersen, "Spatial measures between human poses for classification and understanding",
       AMDO 2012, sec. 2.1 and appendix A, :doi:`10.1007/978-3-642-31567-1_3`.
    .. [2] R. Featherstone, "Rigid Body Dynamics Algorithms", Springer 2008, ch. 6 (the composite-rigid-body algorithm,
       which is how JᵀJ is summed), :doi:`10.1007/978-1-4899-7560-7`.

    Examples
    --------
    An arm of three bones of 1 m that swings from one side to the other folds in between:

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
    found = shortest_path(first, last, skeleton, chosen, joint_limits, max_iter, tol)
    if not found.converged:
        warn(
            f"the geodesic did not converge: length {found.length:.6g} by its chords and {found.curve_length:.6g} as a "
            f"curve. It is a real path, but may not be the shortest. {_reason(found, chosen.n_steps, max_iter, tol)}",
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
) -> GeodesicResult:
    """Return the geodesic between two poses, which are inside limits that are enforced, without a warning."""
    tree = tree_of(skeleton)
    begin, target = to_tree_order(tree, first), to_tree_order(tree, last)
    limited = limited_dofs(skeleton.bones) if joint_limits == "enforce" else np.zeros(skeleton.n_dofs, bool)
    if metric.wrap:
        target = np.where(limited[tree.column], target, wrap_dofs(tree, target, begin))
    bounds, wrap = _bounds(tree, skeleton, joint_limits), bool(metric.wrap)
    curve = path_between(tree, begin, target, int(metric.n_steps), wrap, bounds, max_iter, float(tol))
    line = _where_not_found(tree, skeleton, first, last, len(curve.poses), wrap, limited)
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


def _where_not_found(
    tree: Tree, skeleton: Skeleton, first: np.ndarray, last: np.ndarray, n_poses: int, wrap: bool, limited: np.ndarray
) -> np.ndarray:
    """Return the straight line between two poses in the columns of the bones that the tree has left out.

    It leaves out what carries no weight. What stands in the other columns is undefined.
    """
    line = np.empty((n_poses, skeleton.n_dofs))
    bone_of = np.repeat(np.arange(len(skeleton.bones)), [bone.n_dofs for bone in skeleton.bones])
    missing = np.setdiff1d(bone_of, bone_of[tree.column])
    if len(missing) == 0:
        return line
    bones, columns = [skeleton.bones[i] for i in missing], np.isin(bone_of, missing)
    if wrap:  # numbers must not jump at the end either
        ends, steps = np.stack([first[columns], last[columns]]), np.linspace(0.0, 1.0, n_poses)
        between = interpolate_poses(bones, ends, steps, limited[columns])
        line[:, columns] = remove_jumps(bones, between, limited[columns])
    else:
        line[:, columns] = straight_line(bones, first[columns], last[columns], n_poses)
    return line


def _reason(found: GeodesicResult, n_steps: int, max_iter: int, tol: float) -> str:
    """Return in words why a geodesic did not converge, and the remedy."""
    if np.isnan(found.gain):
        return (
            "No path that is no longer than the straight line passed the discretisation check, so that it is that "
            f"line; a larger n_steps than {n_steps} may help, a larger max_iter does not"
        )
    if found.n_iter < max_iter:
        return f"After {found.n_iter} iterations no step was downhill; a larger n_steps may help"
    left = f"{found.gain:.2g} of the length was left to gain, not at most tol={tol:.2g}"
    if len(found.path) == n_steps + 1:
        return f"After max_iter={max_iter} iterations {left}; raise max_iter"
    return f"After {found.n_iter} iterations of all refinements, max_iter={max_iter} each, {left}; raise max_iter"


def _bounds(tree: Tree, skeleton: Skeleton, joint_limits: str) -> Bounds:
    """Return the least and the largest value of each dof, in the tree's order."""
    free = np.full(len(tree.column), np.inf)
    bounds = Bounds(-free, free)
    if joint_limits == "ignore":
        return bounds
    limited = np.append(tree.angle_dof, tree.slide_dof)
    limits = limits_of(skeleton)[tree.column[limited]] * tree.sign[limited, None]  # a reversed axis swaps its limits
    bounds.lower[limited], bounds.upper[limited] = limits.min(axis=1), limits.max(axis=1)
    return bounds
