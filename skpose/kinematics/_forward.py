"""Joint positions, their Jacobian, and the metric tensor that weighted positions F(θ) induce on angle space."""

from numbers import Integral

import numpy as np
from joblib import effective_n_jobs

from skpose._compiled.pose import jacobian, loops
from skpose._compiled.pose.encode import encode_positions
from skpose._compiled.pose.tree import Steps, Tree
from skpose._utils.parallel import over_rows
from skpose._utils.sklearn import validate_params
from skpose._utils.typing import ArrayLike
from skpose._utils.units import warn_of_degrees
from skpose._utils.validation import check_poses, check_skeleton
from skpose.kinematics._arrays import array_positions, namespace_of
from skpose.kinematics._tree import from_tree_order, to_tree_order, tree_of, tree_of_all_joints
from skpose.skeleton import Motion, Skeleton
from skpose.skeleton._root import root_orientations

WORK_PER_COORDINATE = 25.0  # in the unit of `skpose._utils.parallel`


@validate_params({"n_jobs": [None, Integral]}, prefer_skip_nested_validation=True)
def forward_kinematics(angles: ArrayLike, skeleton: Skeleton, *, n_jobs: int | None = None) -> np.ndarray:
    """Compute the joint positions of every pose, the root at the origin and unrotated.

    All joints of the skeleton are computed, those without weight too.

    Parameters
    ----------
    angles : array-like of shape (n_poses, n_dofs)
        Joint angles, rad, or m where a joint slides, one column per name in ``skeleton.dof_names``.
    skeleton : Skeleton
        The skeleton to pose.
    n_jobs : int, default=None
        Threads; None is 1 unless in a ``joblib.parallel_config`` context, -1 all processors. The result does not
        depend on it.

    Returns
    -------
    ndarray of shape (n_poses, n_joints, 3)
        Positions of the joints, m; float32 for float32 angles, else float64.

    Raises
    ------
    ValueError
        For angles of the wrong width, out of order by name, or not finite; for ``n_jobs=0``.

    Warns
    -----
    UserWarning
        If the angles look like degrees, see `skpose.pose_distances`.

    See Also
    --------
    position_jacobian : Derivatives of the positions by the angles.

    Notes
    -----
    Computed in float64, eight poses at once. A pose of 30 joints and 56 dofs takes some 0.5 µs on one thread; each
    task has some 4,000 such poses or more, so that fewer run on one thread. All run in this process.

    Arrays of torch, JAX, CuPy or another library of the array API standard give positions in an array of that library,
    on its device, in its precision and with gradients. Their values are not checked, and `n_jobs` is ignored.

    References
    ----------
    S. Hauberg, K. S. Pedersen, "Spatial measures between human poses for classification and understanding", AMDO
    2012, sec. 2 and eq. 2, :doi:`10.1007/978-3-642-31567-1_3`.

    Examples
    --------
    >>> import numpy as np
    >>> from skpose import Skeleton, forward_kinematics
    >>> forward_kinematics([[0, np.pi / 2]], Skeleton.chain(2)).round(3)
    array([[[1., 0., 0.],
            [1., 1., 0.]]])
    """
    xp = namespace_of(angles)
    if xp is not None:
        return array_positions(xp, angles, skeleton)
    return joint_positions(_check_angles(angles, skeleton), skeleton, effective_n_jobs(n_jobs))


def joint_positions(angles: np.ndarray, skeleton: Skeleton, n_threads: int = 1) -> np.ndarray:
    """`forward_kinematics` of checked angles."""
    positions = _positions(angles, tree_of_all_joints(skeleton), n_threads)
    return positions.astype(angles.dtype, copy=False).reshape(len(angles), skeleton.n_joints, 3)


def _check_angles(angles: ArrayLike, skeleton: Skeleton) -> np.ndarray:
    check_skeleton(skeleton)
    angles = check_poses(angles, skeleton, "angles")
    warn_of_degrees(None, skeleton, angles=angles)
    return angles


def world_positions(motion: Motion) -> np.ndarray:
    """The positions (n_frames, n_joints, 3) of a motion's joints in the world, m."""
    root = root_orientations(motion.root_angles, motion.root_axes).as_matrix()
    relative = joint_positions(motion.angles, motion.skeleton)
    return np.asarray(np.einsum("nij,nkj->nki", root, relative) + motion.root_positions[:, None])


def weighted_positions(angles: np.ndarray, skeleton: Skeleton) -> np.ndarray:
    """F(θ) (n_poses, n): positions of the joints with weight, times the square roots of their weights."""
    return _positions(angles, tree_of(skeleton))


def _positions(angles: np.ndarray, tree: Tree, n_threads: int = 1) -> np.ndarray:
    positions = np.empty((len(angles), 3 * len(tree.offset) - 3))
    steps = Steps.of(1, wrap=False)

    def compute(first: int, last: int) -> None:
        loops.encode_poses(angles[first:last], encode_positions, tree, steps, positions[first:last])

    over_rows(compute, len(angles), positions.size * WORK_PER_COORDINATE, n_threads)
    return positions


def position_jacobian(angles: ArrayLike, skeleton: Skeleton) -> np.ndarray:
    """Compute the Jacobian of the joint positions, in closed form; weights have no effect on it.

    A rotation about the unit axis a through the point o moves a point p at the rate a × (p − o).

    Parameters
    ----------
    angles : array-like of shape (n_poses, n_dofs)
        Joint angles, rad.
    skeleton : Skeleton
        The skeleton to pose.

    Returns
    -------
    ndarray of shape (n_poses, 3 * n_joints, n_dofs)
        Jacobians, m/rad, of slides m/m. Row 3j + i is component i of joint j, as in ``forward_kinematics(angles,
        skeleton)`` with its last two axes made one.

    Raises
    ------
    ValueError
        For angles of the wrong width, out of order by name, or not finite.

    Warns
    -----
    UserWarning
        If the angles look like degrees, see `skpose.pose_distances`.

    Notes
    -----
    Time and memory O(n_poses · n_joints · n_dofs): 40 kB a pose of 30 joints and 56 dofs.

    References
    ----------
    J. Zhao, N. I. Badler, "Inverse kinematics positioning using nonlinear programming for highly articulated
    figures", ACM Transactions on Graphics 13(4), 1994, :doi:`10.1145/195826.195827`.

    Examples
    --------
    >>> from skpose import Skeleton
    >>> from skpose.kinematics import position_jacobian
    >>> position_jacobian([[0.0, 0.0]], Skeleton.chain(2))[0].round(3) + 0.0
    array([[0., 0.],
           [1., 0.],
           [0., 0.],
           [0., 0.],
           [2., 1.],
           [0., 0.]])
    """
    return jacobians_of(_check_angles(angles, skeleton), tree_of_all_joints(skeleton))


def metric_tensor(angles: ArrayLike, skeleton: Skeleton) -> np.ndarray:
    """Compute the metric tensor JᵀJ of the kinematic manifold in angle space, appendix B of the paper.

    J is the Jacobian of F(θ), the positions of the joints times the square roots of their weights.

    Parameters
    ----------
    angles : array-like of shape (n_poses, n_dofs)
        Joint angles, rad.
    skeleton : Skeleton
        The skeleton to pose.

    Returns
    -------
    ndarray of shape (n_poses, n_dofs, n_dofs)
        Tensors, m²/rad²; symmetric and positive semi-definite. One is singular where a dof moves nothing: a twist about
        a bone at the end of the chain, or one that is followed only by bones along its own axis, and what carries no
        weight.

    Raises
    ------
    ValueError
        For angles of the wrong width, out of order by name, or not finite.

    Warns
    -----
    UserWarning
        If the angles look like degrees, see `skpose.pose_distances`.

    See Also
    --------
    position_jacobian : The Jacobian of the positions without weights.

    References
    ----------
    S. Hauberg, K. S. Pedersen, "Spatial measures between human poses for classification and understanding", AMDO
    2012, appendix B, eq. 15, :doi:`10.1007/978-3-642-31567-1_3`.

    Examples
    --------
    >>> from skpose import Skeleton
    >>> from skpose.kinematics import metric_tensor
    >>> metric_tensor([[0.0, 0.0]], Skeleton.chain(2))[0]
    array([[5., 2.],
           [2., 1.]])
    """
    jacobians = jacobians_of(_check_angles(angles, skeleton), tree_of(skeleton))
    return jacobians.transpose(0, 2, 1) @ jacobians


def jacobians_of(angles: np.ndarray, tree: Tree) -> np.ndarray:
    """The Jacobians (n_poses, n, n_dofs) of the positions of a tree, by the columns of poses."""
    rates = np.empty((len(angles), 3 * len(tree.offset) - 3, len(tree.column)))
    jacobian.position_jacobians(to_tree_order(tree, angles.astype(np.float64)), tree, rates)
    # A rate of change by dofs becomes one by columns as dofs become columns: the change of axes is a rotation.
    unmoved = np.zeros((*rates.shape[:2], angles.shape[1]))
    return from_tree_order(tree, rates, unmoved).astype(angles.dtype, copy=False)
