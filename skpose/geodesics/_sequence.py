"""Geodesic distances from the frames of a motion; each path starts from the path of the previous frame."""

from functools import partial
from numbers import Integral

import numpy as np
from joblib import effective_n_jobs
from sklearn.exceptions import ConvergenceWarning

from skpose._compiled.path.geodesic import TOL
from skpose._compiled.path.kept_paths import Search, follow_geodesics
from skpose._compiled.pose.tree import Tree
from skpose._utils.parallel import in_threads
from skpose._utils.sklearn import validate_params
from skpose._utils.typing import ArrayLike
from skpose._utils.units import warn_of_degrees
from skpose._utils.validation import check_poses
from skpose._utils.warnings import warn
from skpose.kinematics._forward import weighted_positions
from skpose.kinematics._tree import to_tree_order, tree_of, wrap_dofs
from skpose.metrics import Metric
from skpose.metrics._geodesic import no_geodesics, no_paths
from skpose.metrics._registry import MEAN_CONSTRAINTS, require_geodesic
from skpose.skeleton import Skeleton

TASK = 8  # poses per task, tens of milliseconds per frame
NEAR = 0.1  # movement since the last search, relative to the distance, up to which a path is followed


@validate_params(
    MEAN_CONSTRAINTS | {"n_jobs": [None, Integral]},
    prefer_skip_nested_validation=True,
)
def geodesic_distances(
    X: ArrayLike,
    Y: ArrayLike,
    skeleton: Skeleton,
    *,
    metric: str | Metric = "geodesic",
    n_jobs: int | None = None,
) -> np.ndarray:
    """Compute geodesic distances from the frames of a motion, reusing the path of the previous frame.

    The result equals ``pose_distances(X, Y, metric="geodesic")`` up to different local minima. It takes less time
    if consecutive frames are similar, because a path then changes little and a few iterations update it.

    Parameters
    ----------
    X : array-like of shape (n_x, n_dofs)
        Consecutive poses of a motion: joint angles, rad. Any poses are allowed, such as several concatenated motions;
        for unrelated poses nothing is saved.
    Y : array-like of shape (n_y, n_dofs)
        The other poses, in any order.
    skeleton : Skeleton
        The skeleton of all poses.
    metric : str or Metric, default="geodesic"
        "geodesic" or a ``skpose.metrics.Geodesic`` object with at least two steps.
    n_jobs : int, default=None
        Number of threads, as in scikit-learn. It does not change the result.

    Returns
    -------
    ndarray of shape (n_x, n_y)
        Lengths of the geodesics, m.

    Raises
    ------
    ValueError
        If poses have the wrong number of columns, their columns are in the wrong order, or they are not finite.

    Warns
    -----
    ConvergenceWarning
        If geodesics did not converge.
    UserWarning
        If the poses seem to be in degrees, see `skpose.pose_distances`.

    See Also
    --------
    pose_distances : With ``metric="geodesic"``, each path by an independent search.
    geodesic : A single path.

    Notes
    -----
    A path is followed until the pose has moved by a tenth of the distance since the last search, as long as it
    converges, passes the discretisation check of `geodesic`, and is no longer than the straight line. Then a new search
    begins. Columns of the result are independent of one another.

    *Accuracy.* Paths are local minima, and following a path may lead to a different minimum than a search, mainly where
    `geodesic` refines paths. Shorter and longer paths are about equally frequent, and most differ by less than a
    percent. So a distance depends on the previous frames, and the matrix is not exactly symmetric; use
    `pose_distances` if symmetry matters.

    *Sets of poses.* Random poses of many people are too different to save time. Sorted along a short tour they take
    half the time on CMU and 0.9 on HDM05, and up to 4 % of the lengths are longer by 1e-4 or more.

    Following a path takes about a millisecond, a search two to twenty. Memory: the result, copies of the poses, and per
    thread eight paths of up to four times n_steps poses.

    Examples
    --------
    >>> import numpy as np
    >>> from skpose import pose_distances
    >>> from skpose.geodesics import geodesic_distances
    >>> from skpose.datasets import make_gait
    >>> walk = make_gait(n_subjects=1, n_sequences=1, duration=1.0, frame_rate=30, random_state=0)[0]
    >>> standing = np.zeros((1, walk.skeleton.n_dofs))
    >>> distances = geodesic_distances(walk.angles, standing, walk.skeleton)
    >>> searched = pose_distances(walk.angles, standing, skeleton=walk.skeleton, metric="geodesic")
    >>> bool(np.allclose(distances, searched, rtol=1e-3))
    True
    """
    X, Y = (check_poses(given, skeleton, name).astype(np.float64) for name, given in (("X", X), ("Y", Y)))
    warn_of_degrees(None, skeleton, X=X, Y=Y)
    tree = tree_of(skeleton)
    positions = weighted_positions(X, skeleton)
    frames, ends = to_tree_order(tree, X), to_tree_order(tree, Y)
    lengths, converged = np.empty((len(X), len(Y))), np.empty((len(X), len(Y)), dtype=bool)
    chosen = require_geodesic(metric, skeleton, "geodesic_distances")
    search = Search(int(chosen.n_steps), bool(chosen.wrap), 0.0, TOL)

    def follow(columns: slice) -> None:
        _follow(tree, frames, positions, ends[columns], search, lengths[:, columns], converged[:, columns])

    in_threads((partial(follow, slice(i, i + TASK)) for i in range(0, len(Y), TASK)), effective_n_jobs(n_jobs))
    if n_unconverged := int((~converged).sum()):
        warn(
            f"{n_unconverged} of {converged.size} geodesics did not converge; a larger n_steps may help",
            ConvergenceWarning,
        )
    return lengths


def _follow(
    tree: Tree,
    frames: np.ndarray,
    positions: np.ndarray,
    ends: np.ndarray,
    search: Search,
    lengths: np.ndarray,
    converged: np.ndarray,
) -> None:
    """Compute the distances from all frames to some poses, following the paths from frame to frame."""
    n = len(ends)
    kept, found, searched = no_paths(tree, n, search.n_steps), no_geodesics(tree, n), np.zeros(n, dtype=int)
    for i, frame in enumerate(frames):
        if i > 0:
            moved = np.linalg.norm(positions[i] - positions[searched], axis=1)
            anew = moved > NEAR * lengths[i - 1]
            kept.n_nodes[anew], searched[anew] = 0, i
        targets = wrap_dofs(tree, ends, frame[None]) if search.frees_angles else ends
        follow_geodesics(tree, frame, targets, 0, n, search, kept, found)
        lengths[i], converged[i] = found.lengths, found.converged
