"""Geodesic distances from the frames of a motion: each path starts from that of the frame before."""

from functools import partial
from numbers import Integral

import numpy as np
from joblib import effective_n_jobs
from sklearn.exceptions import ConvergenceWarning

from skpose._compat.sklearn import validate_params
from skpose._compiled.path.geodesic import TOL
from skpose._compiled.path.kept_paths import Search, follow_geodesics
from skpose._compiled.pose.tree import Tree
from skpose._parallel.threads import in_threads
from skpose._typing import ArrayLike
from skpose._validation.poses import check_poses
from skpose._validation.units import warn_of_degrees
from skpose._warnings import warn
from skpose.kinematics._shared import to_tree_order, tree_of, weighted_positions, wrap_dofs
from skpose.metrics import Metric
from skpose.metrics._shared import MEAN_CONSTRAINTS, no_geodesics, no_paths, require_geodesic
from skpose.skeleton import Skeleton

# Share of the distance by which a pose may have moved since its path was searched. With more, more of the paths end in
# other minima than a search would; with less, more of them are searched.
TASK = 8  # poses; some tens of milliseconds a frame
NEAR = 0.1


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
    """Compute geodesic distances from the frames of a motion to poses, each path from that of the frame before.

    The distances of ``pose_distances(X, Y, metric="geodesic")``, but for other local minima, and in less time
    where frames are near one another: a path changes little from one frame to the next, so that some iterations find it
    again.

    Parameters
    ----------
    X : array-like of shape (n_x, n_dofs)
        Poses that follow one another in time: joint angles, rad. Any poses are allowed, also several motions one after
        another; without neighbours it takes as long as new searches.
    Y : array-like of shape (n_y, n_dofs)
        The other poses, in any order.
    skeleton : Skeleton
        The skeleton of all poses.
    metric : str or Metric, default="geodesic"
        "geodesic", or a ``skpose.metrics.Geodesic`` with its parameters: chords, at least two, and where the search
        starts.
    n_jobs : int, default=None
        Threads, as in scikit-learn. The distances do not depend on it.

    Returns
    -------
    ndarray of shape (n_x, n_y)
        Lengths of the geodesics, m.

    Raises
    ------
    ValueError
        For poses of the wrong width, out of order by name or not finite.

    Warns
    -----
    ConvergenceWarning
        If geodesics did not converge.
    UserWarning
        If the poses look like degrees, see `skpose.pose_distances`.

    See Also
    --------
    pose_distances : With ``metric="geodesic"``, each path by a search of its own, in files and on clusters.
    geodesic : One path.

    Notes
    -----
    A path is followed from frame to frame until the pose has moved, since the path was searched, by a tenth of the
    distance; as long as it converges, passes the discretisation check of `geodesic` and is no longer than the straight
    line. Then a new search begins. A column of the result depends on the frames, and on no other column.

    *Accuracy.* Paths are local minima, and that of the frame before may lead to another one than a search, mostly where
    `geodesic` has to refine paths: about as often a shorter as a longer one, mostly by less than a percent, and by more
    where joints are near half a turn apart. ``benchmarks/geodesic_distances.py`` measures it. So a distance depends on
    the frames before, the one from a to b is not to the last bit that from b to a, and a matrix that has to be
    symmetric is one for `pose_distances`.

    *Sets of poses.* Random poses of many people are too far from one another. In order along a short tour it takes half
    the time on CMU and 0.9 on HDM05, and up to 4 % of the lengths are longer by 1e-4 or more.

    Between the millisecond that a followed path takes and the two to twenty of a search for each distance. Memory: the
    result, copies of the poses, and paths of up to four times n_steps poses for eight columns a thread.

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
        found = lengths[:, columns], converged[:, columns]
        _follow(tree, frames, positions, ends[columns], search, *found)

    in_threads((partial(follow, slice(i, i + TASK)) for i in range(0, len(Y), TASK)), effective_n_jobs(n_jobs))
    if n_unconverged := int((~converged).sum()):
        warn(
            f"{n_unconverged} of {converged.size} geodesics did not converge; their lengths are those of curves no "
            "longer than the straight line, which may not be the shortest; a larger n_steps may help",
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
    """Compute the distances from all frames to some poses, with the path to each of them from frame to frame."""
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
