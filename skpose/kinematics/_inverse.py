"""Inverse kinematics: the poses of a skeleton at given positions of its joints."""

from functools import partial
from numbers import Integral, Real

from joblib import effective_n_jobs

from skpose._compiled.inverse.frames import Found
from skpose._utils.backends import from_workers, in_processes
from skpose._utils.parallel import in_threads
from skpose._utils.progress import progress
from skpose._utils.sklearn import Interval, StrOptions, validate_params
from skpose._utils.typing import ArrayLike
from skpose.keypoints import Keypoints
from skpose.kinematics._fitted_poses import FittedPoses
from skpose.kinematics._inverse_problem import Problem, Task, problem_of
from skpose.skeleton import Skeleton

WORTH_SENDING = 20_000  # frames, from which on other processes are started


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

    >>> import numpy as np
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
    arguments = positions, skeleton, weights, initial, lengths, joint_limits, float(regularization)
    problem = problem_of(*arguments)
    tasks = list(problem.tasks())
    found = problem.empty(len(problem.weights))
    with progress("Inverse kinematics", len(tasks), verbose) as advance:

        def take(task: Task, part: Found) -> None:
            for array, values in zip(found, part, strict=True):
                array[task.first : task.last] = values
            advance()

        def solve(task: Task) -> None:
            take(task, problem.solve(task))

        if len(problem.weights) > WORTH_SENDING and in_processes(n_jobs):
            for task, part in from_workers(Problem.solve, problem, tasks, n_jobs):
                take(task, part)
        else:
            in_threads((partial(solve, task) for task in tasks), effective_n_jobs(n_jobs))
    return problem.collect(found)
