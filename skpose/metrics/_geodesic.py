"""The metric "geodesic": the shortest curve that the joints can trace from pose to pose."""

from functools import partial

import numpy as np

from skpose._compiled.path.geodesic import GRADIENT_NORM, measure_geodesic
from skpose._compiled.path.kept_paths import MOST_NODES, Geodesics, KeptPaths, follow_geodesics
from skpose._utils.parallel import in_threads
from skpose.kinematics._tree import jacobian_at, wrap_dofs
from skpose.metrics._means import JointSample, Linearization, Sample
from skpose.metrics._metric import Metric, require_skeleton
from skpose.metrics._spatial import CurveMetric, Spatial
from skpose.skeleton import Skeleton

TASK = 8  # geodesics; some tens of milliseconds
FIRST_TOL = 1e-5  # norm of the gradient of the first paths, m²/rad
SHARE = 0.04  # of the gradient of the mean, which the error of a path may have


class Geodesic(CurveMetric):
    r"""Length of the shortest curve that the joints can trace, :math:`\min_c \int \|\dot F(c)\| dt`, m (eq. 3 of [1]_).

    `skpose.geodesic` finds one such curve, and describes how. It is a local minimum, measured by chords: never shorter
    than `Position` or longer than `Spatial`.

    Parameters
    ----------
    n_steps : int, default=10
        Chords along the curve. With one it is `Position`.
    wrap : bool, default=True
        Whether the search starts from the line whose differences of angles are wrapped to [−π, π]. It has no effect on
        ball joints.

    See Also
    --------
    Spatial : The length along the straight line, an upper bound.

    References
    ----------
    .. [1] S. Hauberg, K. S. Pedersen, "Spatial measures between human poses for classification and understanding",
       AMDO 2012, :doi:`10.1007/978-3-642-31567-1_3`.

    Examples
    --------
    >>> from skpose import Skeleton, pose_distances
    >>> from skpose.metrics import Geodesic, Spatial
    >>> X, arm = [[0.0, 0.0], [1.5, 1.5]], Skeleton.chain(2)
    >>> [float(pose_distances(X, skeleton=arm, metric=metric)[0, 1].round(2)) for metric in (Geodesic(), Spatial())]
    [4.0, 4.39]
    """

    name = "geodesic"
    equation = r"\min_c \int \|\dot F(c(t))\| \, dt"
    source = "eq. 3"
    iterative = True

    measure = measure_geodesic
    measure_work = 100_000

    def upper_bound(self) -> Metric:
        """The length along the straight line."""
        return Spatial(self.n_steps, self.wrap)

    @property
    def has_means(self) -> bool:
        """Whether there are two steps or more: with one it is `Position`."""
        return self.n_steps > 1

    def sample(self, X: np.ndarray, weights: np.ndarray, skeleton: Skeleton | None, n_jobs: int) -> Sample:
        """Poses with the geodesics to them from the current pose of the search; the mean is Karcher's."""
        return _GeodesicSample(self, X, weights, require_skeleton(skeleton), n_jobs)


class _GeodesicSample(JointSample):
    is_uneven = True

    def __init__(self, metric: Geodesic, X: np.ndarray, weights: np.ndarray, skeleton: Skeleton, n_jobs: int):
        super().__init__(X, weights, skeleton)
        self.metric, self.n_jobs, self.frees_angles = metric, n_jobs, bool(metric.wrap)
        n, n_dofs = self.dofs.shape
        self.kept = KeptPaths(
            np.empty((n, MOST_NODES * metric.n_steps + 1, n_dofs)),  # memory that is not written to is not used
            np.empty((n, len(self.tree.frame_parent), 4)),
            np.zeros(n, dtype=int),
            np.zeros(n, dtype=int),
        )

    def linearize(self, pose: np.ndarray, slope: float) -> Linearization:
        """Compute the geodesics from a pose to all poses, as well as the gradient so far needs them."""
        tree, n, n_steps = self.tree, len(self.dofs), int(self.metric.n_steps)
        found = Geodesics(np.empty(n), np.empty(n), np.empty(self.dofs.shape), np.empty(n, dtype=bool))
        ends = wrap_dofs(tree, self.dofs, pose[None]) if self.frees_angles else self.dofs
        tol = max(GRADIENT_NORM, SHARE * slope / n_steps) if np.isfinite(slope) else FIRST_TOL
        settings = n_steps, self.frees_angles, tol
        in_threads(
            (
                partial(follow_geodesics, tree, pose, ends, i, min(i + TASK, n), *settings, self.kept, found)
                for i in range(0, n, TASK)
            ),
            self.n_jobs,
        )
        jacobian = jacobian_at(tree, pose, self.frees_angles)
        n_unconverged = int((~found.converged).sum())
        return Linearization(found.lengths, found.energies, found.gradients, jacobian.T @ jacobian, n_unconverged)

    def remeasure(self, pose: np.ndarray, lengths: np.ndarray) -> np.ndarray:
        """The distances, with those along refined paths computed anew, as `pose_distances` finds them.

        A path that was refined at one pose stays refined at the next, where a new path may need no refinement; the
        lengths differ by about 0.1 %.
        """
        rows = np.flatnonzero(self.kept.substeps > 1)
        if len(rows):
            anew = _GeodesicSample(self.metric, self.X[rows], self.weights[rows], self.skeleton, self.n_jobs)
            lengths = lengths.copy()
            lengths[rows] = anew.linearize(pose, 0.0).lengths
        return lengths
