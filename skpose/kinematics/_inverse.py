"""Inverse kinematics: the poses of a skeleton at given positions of its joints.

`problem_of` checks the arguments and brings them into the order of compiled code; a `Problem` consists of tasks.
"""

import itertools
from dataclasses import dataclass, replace
from numbers import Integral, Real
from typing import Literal, NamedTuple

import numpy as np
from scipy.spatial.transform import Rotation
from sklearn.exceptions import ConvergenceWarning

from skpose._compiled.inverse.frames import Found, Observed, Rules, fit_frames
from skpose._compiled.pose.tree import Tree
from skpose._utils.parallel import in_processes, results_of
from skpose._utils.sklearn import Interval, StrOptions, validate_params
from skpose._utils.typing import ArrayLike
from skpose._utils.units import extent_of
from skpose._utils.validation import as_numbers, check_poses, check_positions, limits_of
from skpose._utils.warnings import warn
from skpose.keypoints import Keypoints
from skpose.keypoints._checks import is_spatial, refuse_pictures
from skpose.kinematics._tree import from_tree_order, to_tree_order, tree_of_all_joints
from skpose.skeleton import Motion, Skeleton
from skpose.skeleton._rest import positions_at_zero, size_of
from skpose.skeleton._root import root_angles_of, with_root_joint
from skpose.skeleton._upright import complaint_of_up

WORTH_SENDING = 20_000  # frames, from which on other processes are started
TASK = 512  # frames, some 50 ms; fixed, so that poses do not depend on n_jobs
WARM_UP = 32  # frames before a task that it computes and drops, so that its first frame does not start from scratch
WARM_ITER = 20  # iterations from the frame before
MAX_ITER = 1000  # iterations from the initial pose; a few frames need hundreds
LARGER, SMALLER = 10.0, 50.0  # times that positions may differ in size from the skeleton: few joints may be seen
N_ROOT = 3  # columns of the root's orientation


@dataclass(frozen=True, eq=False, repr=False)
class FittedPoses:
    """Poses at given positions of the joints, as `inverse_kinematics` finds them.

    In the world the joints are at R·F(θ) + o, with the pose θ, the rotation R of the root and its position o.

    Attributes
    ----------
    skeleton : Skeleton
        The skeleton.
    poses : ndarray of shape (n_frames, n_dofs)
        Joint angles, rad.
    residuals : ndarray of shape (n_frames, n_joints)
        Distance of each joint from its given position, m; NaN if it is not seen.
    converged : ndarray of shape (n_frames,) of bool
        Whether no small change of the pose would bring the joints nearer. False where nothing is seen.
    root_positions : ndarray of shape (n_frames, 3)
        Positions of the root, m.
    root_rotations : ndarray of shape (n_frames, 3)
        Orientations of the root as rotation vectors, rad.
    n_iter : ndarray of shape (n_frames,) of int
        Iterations.
    frame_rate : float or None
        Frames per second, Hz, of the `Keypoints`; None for an array.
    up : {"x", "y", "z"} or None
        The axis of the world that points up in the `Keypoints`; None for an array.

    Examples
    --------
    >>> from skpose import Skeleton, inverse_kinematics
    >>> inverse_kinematics([[[1, 0, 0], [1, 1, 0]]], Skeleton.chain(2))
    FittedPoses(1 frame, 2 of 2 joints seen, 0 mm off in the mean, all converged)
    """

    skeleton: Skeleton
    poses: np.ndarray
    residuals: np.ndarray
    converged: np.ndarray
    root_positions: np.ndarray
    root_rotations: np.ndarray
    n_iter: np.ndarray
    frame_rate: float | None = None
    up: Literal["x", "y", "z"] | None = None

    def __len__(self) -> int:
        return len(self.poses)

    def __repr__(self) -> str:
        seen = ~np.isnan(self.residuals)
        frames = f"{len(self)} frame{'s' if len(self) != 1 else ''}"
        joints = f"{seen.any(axis=0).sum()} of {self.skeleton.n_joints} joints seen"
        off = f"{round(1e3 * float(np.mean(self.residuals[seen])), 3) if seen.any() else np.nan:g} mm off in the mean"
        left = int((~self.converged).sum())
        return f"FittedPoses({frames}, {joints}, {off}, {f'{left} not converged' if left else 'all converged'})"

    def to_motion(self, frame_rate: float | None = None, up: Literal["x", "y", "z"] | None = None) -> Motion:
        """Convert the poses to a motion.

        Parameters
        ----------
        frame_rate : float, default=None
            Frames per second, Hz. None takes the rate of the `Keypoints`; arrays of positions need it.
        up : {"x", "y", "z"}, default=None
            The axis of the world that points up. None takes the axis of the `Keypoints`; for an array, y.

        Returns
        -------
        Motion
            With the root's positions and orientations; the latter as angles about "xyz", see `Motion.unwrap`.

        Raises
        ------
        ValueError
            If the frame rate is not known.

        Warns
        -----
        UserWarning
            If the axis that points up is not known, and in nearly all frames the poses stand along another axis than y.
        """
        rate = self.frame_rate if frame_rate is None else frame_rate
        if rate is None:
            raise ValueError("the frame rate is not known: pass frame_rate=, in Hz")
        angles, axes = np.zeros((len(self), 3)), "xyz"
        if len(self):
            angles, axes = root_angles_of(Rotation.from_rotvec(self.root_rotations), angles, axes)
        known = self.up if up is None else up
        seen = ~np.isnan(self.residuals)
        motion = Motion(self.skeleton, self.poses, rate, self.root_positions, angles, axes, up=known or "y", seen=seen)
        if known is None and (complaint := complaint_of_up(motion, "y")):
            warn(complaint)
        return motion


@validate_params(
    {
        "skeleton": [Skeleton],
        "weights": ["array-like", None],
        "initial": ["array-like", None],
        "lengths": ["array-like", None],
        "joint_limits": [StrOptions(["ignore", "enforce"])],
        "regularization": [Interval(Real, 0, None, closed="left")],
        "n_jobs": [None, Integral],
        "verbose": ["verbose"],
    },
    prefer_skip_nested_validation=True,
)
def inverse_kinematics(
    positions: ArrayLike | Keypoints,
    skeleton: Skeleton,
    *,
    weights: ArrayLike | None = None,
    initial: ArrayLike | None = None,
    lengths: ArrayLike | None = None,
    joint_limits: str = "ignore",
    regularization: float = 0.0,
    n_jobs: int | None = None,
    verbose: int = 0,
) -> FittedPoses:
    r"""Find the poses of a skeleton whose joints are nearest to given positions.

    This is the projection of positions onto the kinematic manifold (eq. 2 of [1]_): of each frame

    .. math:: \min_{\theta, R, o} \sum_j w_j \|R F_j(\theta) + o - p_j\|^2 + \rho^2 \|\theta \ominus \theta_0\|^2

    over the joints j that are seen. The position o and the orientation R of the root are found along with the pose.

    Parameters
    ----------
    positions : array-like of shape (n_frames, n_joints, 3) or Keypoints
        Positions of the joints in the world, m, in the order of ``skeleton.joint_names``; NaN where a joint is not
        seen. `Keypoints` are matched with the joints by name: joints without a keypoint are not seen, keypoints without
        a joint are left out.
    skeleton : Skeleton
        The skeleton, such as `fit_skeleton` finds for keypoints. Its weights have no effect.
    weights : array-like of shape (n_joints,) or (n_frames, n_joints), default=None
        Weights w of the joints, such as the confidences of a pose estimator; zero is not seen. The confidences of
        `Keypoints` are multiplied by them. None is 1.
    initial : array-like of shape (n_dofs,) or (n_frames, n_dofs), default=None
        The pose from which each sequence starts, rad; None is the rest pose, all angles zero. With one for each frame,
        no frame depends on others.
    lengths : array-like of shape (n_sequences,), default=None
        Number of frames of each sequence, one after the other in `positions`; None is one sequence.
    joint_limits : {"ignore", "enforce"}, default="ignore"
        "enforce" keeps angles inside ``skeleton.limits``. The search then starts from the initial pose clipped to
        them. Joints with three angles and limits do not turn freely.
    regularization : float, default=0.0
        The factor ρ, m/rad: a joint that is turned by 1 rad from the initial pose costs as much as a joint that is ρ
        off. For noisy positions some 0.01 to 0.03 keeps angles that the positions barely show, such as twists of
        straight arms, from following the noise. With 0 positions are reached as well as possible.
    n_jobs : int, default=None
        Threads, as in scikit-learn, or workers of joblib's configured backend. Poses do not depend on it.
    verbose : int, default=0
        Whether to show the progress.

    Returns
    -------
    FittedPoses
        The poses, how far each joint is off, whether each frame converged, and the movement of the root.

    Raises
    ------
    ValueError
        For positions in two dimensions, of another number of joints, or infinite; keypoints of which none is a joint;
        weights that are negative; limits to be enforced on a skeleton without any.

    Warns
    -----
    ConvergenceWarning
        If frames did not converge; they have the best pose found.
    UserWarning
        If in some frames nothing is seen: these have the pose of the frame before, and `converged` is False. If the
        positions and the skeleton are likely in different units.

    See Also
    --------
    skpose.keypoints.fit_skeleton : Find the skeleton of keypoints.
    skpose.preprocessing.PoseFromPositions : A transformer that fits each row separately.
    frechet_mean : The pose nearest to the mean of positions.

    Notes
    -----
    *What the positions leave open.* A twist of a bone at the end of a chain moves no joint, and joints may not be seen.
    With ``regularization=0`` such angles do not matter to the sum. They follow the frame before, and go back to the
    initial pose by a tenth from frame to frame at most: so they do not drift. If a joint is lost for some frames,
    the joints before it keep the angles of the frame before unless other joints determine them. Interpolated positions
    are a better guess, see `skpose.keypoints.Keypoints.fill_gaps`.

    *Method.* Gauss-Newton steps in a trust region, with turns of joints instead of angles; JᵀJ is summed along the
    skeleton and factorised along it without filling in [2]_; where positions cannot be reached the exact Hessian takes
    over. Each frame starts from the one before. The first, and those for which that fails, start from the initial pose,
    with the root by the best fit of all joints [3]_, and each joint turned to where the ends of its bones are seen,
    parents first. Minima are local; hinges are tried on both sides. Sequences are computed in tasks of 512 frames.

    Some 0.1 ms a frame of 30 joints and 56 dofs in a sequence, and 1 ms for a separate frame, on one thread.

    References
    ----------
    .. [1] S. Hauberg, K. S. Pedersen, "Spatial measures between human poses for classification and understanding",
       AMDO 2012, :doi:`10.1007/978-3-642-31567-1_3`.
    .. [2] R. Featherstone, "Efficient factorization of the joint-space inertia matrix for branched kinematic trees",
       International Journal of Robotics Research 24(6), 2005, :doi:`10.1177/0278364905054928`.
    .. [3] B. K. P. Horn, "Closed-form solution of absolute orientation using unit quaternions", Journal of the Optical
       Society of America A 4(4), 1987, :doi:`10.1364/JOSAA.4.000629`.

    Examples
    --------
    An arm, seen from the world; its wrist is lost in the second frame:

    >>> from skpose import Bone, Skeleton, inverse_kinematics
    >>> arm = Skeleton([Bone("elbow", None, (0.3, 0, 0)), Bone("wrist", "elbow", (0.25, 0, 0), "z")])
    >>> positions = [[[2.0, 0.3, 0], [2.0, 0.3, 0.25]], [[2.0, 0.4, 0], [np.nan, np.nan, np.nan]]]
    >>> fitted = inverse_kinematics(positions, arm)
    >>> fitted
    FittedPoses(2 frames, 2 of 2 joints seen, 0 mm off in the mean, all converged)
    >>> fitted.residuals.round(6)
    array([[ 0.,  0.],
           [ 0., nan]])
    """
    problem = problem_of(positions, skeleton, weights, initial, lengths, joint_limits, float(regularization))
    remote = len(problem.weights) > WORTH_SENDING and in_processes(n_jobs)
    parts = results_of(Problem.solve, problem, problem.tasks(), n_jobs, remote, "Inverse kinematics", verbose)
    found = Found(*(np.concatenate(arrays) for arrays in zip(problem.empty(0), *parts, strict=True)))
    fitted = problem.fit(found)
    problem.warn_of_failures(fitted)
    if isinstance(positions, Keypoints):
        return replace(fitted, frame_rate=positions.frame_rate, up=positions.up)
    return fitted


# --- tasks ------------------------------------------------------------------------------------------------------------


class Task(NamedTuple):
    """Frames that are computed together."""

    first: int
    last: int  # the one after the last
    start: int  # first frame of the sequence
    end: int


@dataclass(frozen=True, eq=False)
class Problem:
    """Positions and options of inverse kinematics, in the order of a tree with the root as a joint."""

    skeleton: Skeleton
    tree: Tree
    positions: np.ndarray  # (n_frames, n_joints + 2, 3) m; finite
    weights: np.ndarray  # (n_frames, n_joints + 2); the largest of a frame is 1
    stiffness: np.ndarray  # (n_frames,) ρ² of these weights, m²/rad²
    initial: np.ndarray  # (n_frames or 1, n_dofs + 3)
    changes: np.ndarray  # (n_frames,) rad, see `Observed`
    ends: np.ndarray  # (n_sequences,) number of the frame after the last of each sequence
    rules: Rules

    def tasks(self) -> list[Task]:
        """The parts of the sequences."""
        return [
            Task(first, min(first + TASK, end), start, end)
            for start, end in itertools.pairwise([0, *self.ends.tolist()])
            for first in range(start, end, TASK)
        ]

    def empty(self, n: int) -> Found:
        n_dofs = len(self.tree.column)
        residuals = np.empty((n, self.weights.shape[1]))
        return Found(np.empty((n, n_dofs)), np.empty((n, 3)), residuals, np.zeros(n, np.int64), np.zeros(n, bool))

    def solve(self, task: Task) -> Found:
        """Find the poses of some frames."""
        warm_up = self.warm_up(task) if self.rules.is_sequence else np.array([], np.int64)
        frames, found = np.concatenate([warm_up, np.arange(task.first, task.last)]), self.empty(task.last - task.first)
        ever = np.asarray((self.weights[task.start : task.end] > 0.0).any(axis=0))
        observed = Observed(
            self.positions[frames], self.weights[frames], self.stiffness[frames], ever, self.changes[frames]
        )
        initial = self.initial if self.rules.is_sequence else self.initial[frames]
        fit_frames(self.tree, observed, initial, self.rules, len(warm_up), found)
        return found

    def warm_up(self, task: Task) -> np.ndarray:
        """The frames before a task from which it starts.

        They are those just before it, and just before the last sight of each joint: a joint that is lost keeps the
        angles that it had then, however long ago.
        """
        before = self.weights[task.start : task.first] > 0.0
        sights = task.first - np.argmax(before[::-1, before.any(axis=0)], axis=0) if len(before) else task.first
        ends = np.unique(np.append(sights, task.first))
        chosen = [np.arange(max(end - WARM_UP, task.start), end) for end in ends.tolist()]
        return np.unique(np.concatenate(chosen))

    def fit(self, found: Found) -> FittedPoses:
        """The found poses, in the order of the skeleton."""
        n = len(self.weights)
        columns = from_tree_order(self.tree, found.dofs, np.zeros((n, N_ROOT + self.skeleton.n_dofs)))
        held = np.arange(n)
        if self.rules.is_sequence:  # the last frame up to each one in which a joint is seen, or the sequence's first
            starts = np.repeat(np.append(0, self.ends[:-1]), np.diff(self.ends, prepend=0))
            held = np.maximum.accumulate(np.where((self.weights > 0.0).any(axis=1), held, starts))
        columns = columns[held]
        residuals = np.full((n, self.skeleton.n_joints + 2), np.nan)
        residuals[:, self.tree.code_joint] = np.where(self.weights > 0.0, found.residuals, np.nan)
        return FittedPoses(
            skeleton=self.skeleton,
            poses=columns[:, N_ROOT:],
            residuals=residuals[:, 2:],
            converged=found.converged,
            root_positions=found.origins[held],
            root_rotations=columns[:, :N_ROOT],
            n_iter=found.n_iter,
        )

    def warn_of_failures(self, fitted: FittedPoses) -> None:
        """Warn of frames in which no joint is seen, and of frames that did not converge."""
        n, unseen = len(fitted), np.isnan(fitted.residuals).all(axis=1)
        if unseen.any():
            kept = "the one before" if self.rules.is_sequence else "the initial one"
            frames = f"in {unseen.sum()} of {n} frames, first in frame {unseen.argmax()}"
            warn(f"{frames}, no joint is seen: their pose is {kept}")
        left = ~fitted.converged & ~unseen
        if left.any():
            message = f"{left.sum()} of {n} frames did not converge, first in {left.argmax()}: try regularization=0.01"
            warn(message, ConvergenceWarning)


def problem_of(
    positions: ArrayLike | Keypoints,
    skeleton: Skeleton,
    weights: ArrayLike | None,
    initial: ArrayLike | None,
    lengths: ArrayLike | None,
    joint_limits: str,
    regularization: float,
) -> Problem:
    """Check the arguments of `inverse_kinematics`, and bring them into the order of a tree."""
    given, confidences = _match(positions, skeleton)
    n = len(given)
    seen = confidences * _weights(weights, confidences.shape)
    seen[np.isnan(given).any(axis=2)] = 0.0
    extent, size = extent_of(given), size_of(skeleton)
    if size > 0.0 and (extent > LARGER * size or 0.0 < extent < size / SMALLER):
        warn(f"positions extend over {extent:.3g} m, the skeleton over {size:.3g} m: one is likely not in metres")
    tree = tree_of_all_joints(with_root_joint(skeleton))
    order = tree.code_joint  # 0 is the root, 1 the joint that is added to turn it
    padded, padded_weights = np.zeros((n, len(order), 3)), np.zeros((n, len(order)))
    padded[:, 2:], padded_weights[:, 2:] = np.where(seen[:, :, None] > 0.0, given, 0.0), seen
    start = _check_initial(initial, skeleton, n)
    lower, upper = _limits(tree, skeleton, joint_limits)
    scales = seen.max(axis=1, initial=0.0)  # tolerances are distances, so weights are relative
    scales[scales == 0.0] = 1.0
    dofs = to_tree_order(tree, np.concatenate([np.zeros((len(start), N_ROOT)), start], axis=1))
    rules = Rules(
        is_sequence=len(start) == 1,
        warm_iter=WARM_ITER,
        max_iter=MAX_ITER,
        tries_first=False,
        lower=lower,
        upper=upper,
    )
    return Problem(
        skeleton=skeleton,
        tree=tree,
        positions=padded[:, order],
        weights=padded_weights[:, order] / scales[:, None],
        stiffness=regularization**2 / scales,
        initial=np.clip(dofs, lower, upper),
        changes=np.full(n, np.inf),
        ends=_ends(lengths, n),
        rules=rules,
    )


def _match(positions: ArrayLike | Keypoints, skeleton: Skeleton) -> tuple[np.ndarray, np.ndarray]:
    """Positions (n_frames, n_joints, 3) and confidences (n_frames, n_joints) in the skeleton's order."""
    if not isinstance(positions, Keypoints):
        given = check_positions(positions, skeleton.n_joints, "positions")
        if is_spatial(positions_at_zero(skeleton)):  # an arm may move in one plane
            refuse_pictures(given, skeleton.joint_names, "positions")
        return given, np.ones(given.shape[:2])
    common = [name for name in skeleton.joint_names if name in positions.names]
    if not common:
        raise ValueError(
            f"no keypoint, such as {positions.names[0]!r}, has the name of a joint: use skpose.keypoints.fit_skeleton"
        )
    chosen = [skeleton.joint_names.index(name) for name in common]
    given = np.full((len(positions), skeleton.n_joints, 3), np.nan)
    confidences = np.zeros(given.shape[:2])
    part = positions.select(common)
    given[:, chosen], confidences[:, chosen] = part.positions, part.confidences
    return given, confidences


def _weights(weights: ArrayLike | None, shape: tuple[int, ...]) -> np.ndarray:
    """Check weights (n_frames, n_joints)."""
    if weights is None:
        return np.ones(shape)
    array = as_numbers(weights, "weights", masked=0.0)
    if array.shape not in (shape, shape[1:]):
        raise ValueError(f"weights must have shape {shape[1:]} or {shape}, got {array.shape}")
    if not np.isfinite(array).all() or (array < 0.0).any():
        raise ValueError("weights must be finite and not negative")
    return np.broadcast_to(array, shape)


def _check_initial(initial: ArrayLike | None, skeleton: Skeleton, n: int) -> np.ndarray:
    """Check the first poses (1, n_dofs) or (n_frames, n_dofs)."""
    if initial is None:
        return np.zeros((1, skeleton.n_dofs))
    array = np.atleast_2d(initial)
    if len(array) not in (1, n):
        raise ValueError(f"initial must be one pose, or one for each of the {n} frames, got {len(array)}")
    return check_poses(array, skeleton, "initial").astype(np.float64)


def _ends(lengths: ArrayLike | None, n: int) -> np.ndarray:
    """The number of the frame after the last of each sequence."""
    if lengths is None:
        return np.array([n])
    array = np.asarray(lengths)
    if array.ndim != 1 or array.dtype.kind not in "iu" or (array < 1).any() or array.sum() != n:
        raise ValueError(f"lengths must be positive integers whose sum is the number of frames, {n}, got {lengths!r}")
    return np.cumsum(array)


def _limits(tree: Tree, skeleton: Skeleton, joint_limits: str) -> tuple[np.ndarray, np.ndarray]:
    """The limits of each dof, in the tree's order."""
    lower = np.full(len(tree.column), -np.inf)
    if joint_limits == "ignore":
        return lower, -lower
    upper, limited = -lower, np.append(tree.angle_dof, tree.slide_dof)
    limits = limits_of(skeleton)[tree.column[limited] - N_ROOT] * tree.sign[limited, None]  # a reversed axis swaps them
    lower[limited], upper[limited] = limits.min(axis=1), limits.max(axis=1)
    return lower, upper
